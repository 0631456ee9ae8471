//! Schemas of the values that may be written in more than one form; each says what the visitor of that type reads and the
//! check allows.

use super::forms::{AlbedoWritten, Diameter, IndexWritten, Pair, Strategy, ThicknessWritten};
use super::limits::{ABSORPTION, ALBEDO, INDEX, PERIOD_UM, THICKNESS_UM};
use crate::material::synthetic::Synthetic;
use crate::numerics::allowed::Allowed;
use crate::solve::{Registry, SolverChoice};
use schemars::transform::Transform;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde_json::Value;
use std::borrow::Cow;

fn number(mut allowed: Allowed, description: &str, example: f64) -> Schema {
    let mut schema = json_schema!({ "description": description, "type": "number", "examples": [example] });
    allowed.transform(&mut schema);
    schema
}

impl JsonSchema for IndexWritten {
    fn schema_name() -> Cow<'static, str> {
        "Index".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let names = Synthetic::ALL.map(Synthetic::name);
        let built_in = json_schema!({ "description": "A built-in synthetic pigment.", "enum": names, "examples": ["yellow"] });
        json_schema!({
            "description": "A complex refractive index n + iκ.",
            "anyOf": [
                number(INDEX, "A transparent medium: its real index.", 1.558),
                constant("k"),
                constant("kappa"),
                table("built_in", built_in),
                index_file("csv", "Table wavelength_nm, kappa[, n], relative to the study file; without a column n with n beside it."),
                index_file("yaml", "Record of refractiveindex.info, relative to the study file; without n with n beside it."),
            ],
        })
    }
}

/// A file of indices, with n beside it where it has κ alone.
fn index_file(key: &str, what: &str) -> Schema {
    let path =
        json_schema!({ "description": what, "type": "string", "examples": [format!("measured.{key}")] });
    let mut schema = table(key, path);
    let n = number(INDEX, "Real part at all wavelengths, where the file has κ alone.", 1.4);
    if let Some(properties) = schema.ensure_object()["properties"].as_object_mut() {
        properties.insert("n".into(), n.into());
    }
    schema
}

/// A table of n and κ, which is called `name`.
fn constant(name: &str) -> Schema {
    let real = number(INDEX, "Real part.", 1.4);
    let absorption = number(ABSORPTION, "Imaginary part κ, which absorbs; 0 when left out.", 0.1);
    let other = if name == "k" { "kappa" } else { "k" };
    json_schema!({
        "description": format!("The same at all wavelengths: n + iκ; κ is called {name} here ({other} elsewhere)."),
        "type": "object",
        "properties": { "n": real, name: absorption },
        "required": if name == "k" { vec!["n"] } else { vec!["n", name] },
        "additionalProperties": false,
    })
}

/// A table of one key.
fn table(key: &str, value: Schema) -> Schema {
    json_schema!({
        "type": "object",
        "properties": { key: value },
        "required": [key],
        "additionalProperties": false,
    })
}

impl JsonSchema for Diameter {
    fn schema_name() -> Cow<'static, str> {
        "Diameter".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let limit =
            "The limit of vanishing grains: nothing is packed, the pigment is dissolved in the binder.";
        json_schema!({
            "anyOf": [
                number(Allowed::above(0.0, f64::MAX, "nm"), "Diameter of the sphere of equal volume, nm.", 250.0),
                { "description": limit, "type": "string", "const": "molecular" },
            ],
        })
    }
}

impl JsonSchema for ThicknessWritten {
    fn schema_name() -> Cow<'static, str> {
        "Thickness".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let spread = Allowed::between(0.0, f64::MAX, "µm");
        json_schema!({
            "anyOf": [
                number(THICKNESS_UM, "An even layer, µm.", 1.0),
                {
                    "description": "An uneven layer: every realisation has a thickness of its own.",
                    "type": "object",
                    "properties": {
                        "mean": number(THICKNESS_UM, "Mean, µm.", 1.0),
                        "std": number(spread, "Standard deviation, µm; at most a quarter of the mean.", 0.1),
                    },
                    "required": ["mean", "std"],
                    "additionalProperties": false,
                },
            ],
        })
    }
}

impl JsonSchema for AlbedoWritten {
    fn schema_name() -> Cow<'static, str> {
        "Albedo".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let csv = "Table wavelength_nm, albedo, relative to the study file.";
        json_schema!({
            "anyOf": [
                number(ALBEDO, "The same at all wavelengths.", 0.9),
                {
                    "description": "Rows of wavelength in nm and albedo, rising, linear in between.",
                    "type": "array",
                    "items": { "type": "array", "items": { "type": "number" }, "minItems": 2, "maxItems": 2 },
                    "minItems": 2,
                },
                table("csv", json_schema!({ "description": csv, "type": "string", "examples": ["paper.csv"] })),
            ],
        })
    }
}

impl JsonSchema for Pair {
    fn schema_name() -> Cow<'static, str> {
        "Pair".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "anyOf": [
                number(PERIOD_UM, "The same along x and y, µm.", 1.6),
                {
                    "description": "Along x and along y, µm.",
                    "type": "array",
                    "items": number(PERIOD_UM, "µm", 1.6),
                    "minItems": 2,
                    "maxItems": 2,
                },
            ],
        })
    }
}

impl JsonSchema for Strategy {
    fn schema_name() -> Cow<'static, str> {
        "Strategy".into()
    }

    /// Every strategy by its name, or as a table with its settings.
    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let named = |name: &str, description: &str| json_schema!({ "description": description, "type": "string", "const": name });
        let registry = Registry::default();
        let names = registry.entries().iter().map(|e| named(e.name(), e.description()));
        let mut forms: Vec<Value> = names.map(Value::from).collect();
        forms.push(generator.subschema_for::<SolverChoice>().into());
        json_schema!({ "anyOf": forms })
    }
}
