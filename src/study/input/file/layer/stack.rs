//! Stacks of layers: `[[layer]]` in the order of the light, and `[stack]` for what they share.

use super::{
    BinderTable, ComposedTable, ContrastPart, LayerTable, MicrostructureTable, PigmentTable, vacuum,
};
use crate::ink::{Joint, ReliefRequest};
use crate::input::file::StudyFile;
use crate::input::forms::{Pair, ThicknessWritten};
use crate::input::{limits, variation};
use crate::material::mixing::MixingRule;
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
use serde_json::json;
use std::fmt;

/// `[stack]`: what all layers of `[[layer]]` share; a single `[layer]` has these keys itself.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct StackTable {
    /// Whether every realisation has a cell of its own size, shape and azimuth.
    pub cell: variation::CellRule,
    /// Nominal period along x and y, µm: one number or `[x, y]`. For varied cells it follows from
    /// the largest grains of all layers by default.
    #[schemars(example = 1.6)]
    pub period_um: Option<Pair>,
    /// Refractive index of the half-space before the first layer.
    #[schemars(transform = limits::INDEX.mark())]
    pub index_in: f64,
    /// Refractive index of the half-space behind the last layer; 1 for the thin air gap to the
    /// paper.
    #[schemars(transform = limits::INDEX.mark())]
    pub index_out: f64,
    /// How `"molecular"` pigments mix with their binder (default: the limit of vanishing grains,
    /// which is `"volume-average"` for the scalar wave and `"maxwell-garnett"` for Maxwell's
    /// equations).
    #[schemars(example = &"volume-average")]
    pub mixing: Option<MixingRule>,
    /// Which part of the contrast in η² scatters: all of it, or only its real or imaginary part.
    pub contrast: ContrastPart,
    /// The stack as a list of plates: every layer is solved alone, as a whole or in slabs, and any
    /// thickness of one layer follows from one set of solves.
    #[schemars(example = ComposedTable::default())]
    pub composed: Option<ComposedTable>,
    /// Whether a stack that is solved as a whole is also solved without each of its layers, and
    /// each layer alone: their colours, contrast ratios and densities. It costs the solves of these
    /// stacks; a composed stack of several layers tells this in any case, but for one with
    /// `joint_index`, whose plates are for libraries.
    pub without_layers: bool,
}

impl Default for StackTable {
    fn default() -> Self {
        Self {
            cell: variation::CellRule::default(),
            period_um: None,
            index_in: vacuum(),
            index_out: vacuum(),
            mixing: None,
            contrast: ContrastPart::default(),
            composed: None,
            without_layers: false,
        }
    }
}

/// `[[layer]]`: one layer of a stack; the first one is lit.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StackLayerTable {
    /// Name in reports and in the fields of sweeps (default: "layer 1" and so on).
    #[schemars(example = &"varnish")]
    pub name: Option<String>,
    /// Thickness, µm; `{ mean, std }` if it varies, in one layer of the stack.
    #[schemars(example = 1.0)]
    pub thickness_um: ThicknessWritten,
    /// The medium between its grains (default: index 1.558, P1 section 5).
    #[serde(default)]
    pub binder: BinderTable,
    /// Its own pigments, one `[[layer.pigment]]` each; without any the layer is clear.
    #[serde(default, rename = "pigment")]
    pub pigments: Vec<PigmentTable>,
    /// Grains in given places instead of packed ones, with z from this layer's own face.
    #[schemars(example = MicrostructureTable::example())]
    pub microstructure: Option<MicrostructureTable>,
    /// A rough outer face: `incident` on the first layer, `exit` on the last.
    pub relief: Option<ReliefRequest>,
    /// In a composed stack, thickness of the slabs that this layer is composed of, µm; its own
    /// thickness solves it as a whole (default: `stack.composed.slab_um`, and as a whole a layer of
    /// less than two slabs).
    #[schemars(transform = limits::THICKNESS_UM.mark())]
    pub slab_um: Option<f64>,
    /// How the layer meets the one behind it (default: `"wall"`); the last layer has no joint.
    pub joint: Option<Joint>,
}

/// Index between plates where neither the file nor a binder gives a number.
const USUAL_JOINT: f64 = 1.5;

impl StudyFile {
    /// Makes plates of the layers, solved between half-spaces of one index: that of
    /// `stack.composed.joint_index`, else of the first binder. A single layer gets this name.
    pub(in crate::input) fn make_plates(&mut self, name: &str) {
        let mut stack = self.stack.take().unwrap_or_default();
        if self.layer.stacked.is_none() {
            let LayerTable { composed, thickness_um, binder, microstructure, relief, .. } =
                self.layer.clone();
            stack = StackTable {
                cell: self.layer.cell,
                period_um: self.layer.period_um,
                index_in: self.layer.index_in,
                index_out: self.layer.index_out,
                mixing: self.layer.mixing,
                contrast: self.layer.contrast,
                composed: composed.clone(),
                without_layers: false,
            };
            self.layer.stacked = Some(vec![StackLayerTable {
                name: Some(name.to_owned()),
                thickness_um,
                binder,
                pigments: std::mem::take(&mut self.pigments),
                microstructure,
                relief,
                slab_um: composed.map(|table| table.slab_um),
                joint: None,
            }]);
        }
        let first = self.layer.stacked.as_ref().and_then(|layers| layers.first());
        let binder = first.and_then(|layer| layer.binder.index.n);
        // plates are for stacks of any layers
        stack.without_layers = false;
        let composed = stack.composed.get_or_insert_default();
        composed.joint_index.get_or_insert(binder.unwrap_or(USUAL_JOINT));
        self.stack = Some(stack);
    }
}

/// Reads `[layer]`, or `[[layer]]` as [`LayerTable::stacked`].
pub(in crate::input::file) fn one_or_stacked<'de, D: Deserializer<'de>>(
    from: D,
) -> Result<LayerTable, D::Error> {
    from.deserialize_newtype_struct("layer", OneOrStacked)
}

struct OneOrStacked;

impl<'de> Visitor<'de> for OneOrStacked {
    type Value = LayerTable;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a table [layer], or a list of tables [[layer]]")
    }

    /// Whatever is to be read, from a reader that does not know its form.
    fn visit_newtype_struct<D: Deserializer<'de>>(self, from: D) -> Result<LayerTable, D::Error> {
        from.deserialize_any(self)
    }

    /// A table, from a reader that knows its form and reports all unknown keys.
    fn visit_some<D: Deserializer<'de>>(self, table: D) -> Result<LayerTable, D::Error> {
        LayerTable::deserialize(table)
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<LayerTable, A::Error> {
        LayerTable::deserialize(MapAccessDeserializer::new(map))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, layers: A) -> Result<LayerTable, A::Error> {
        let stacked = Some(Vec::deserialize(SeqAccessDeserializer::new(layers))?);
        Ok(LayerTable {
            stacked,
            ..LayerTable::of_stack(&StackLayerTable::nothing(), &StackTable::default())
        })
    }
}

impl StackLayerTable {
    /// In place of the single layer of a stack.
    fn nothing() -> Self {
        Self {
            name: None,
            thickness_um: ThicknessWritten::Several(Vec::new()),
            binder: BinderTable::default(),
            pigments: Vec::new(),
            microstructure: None,
            relief: None,
            slab_um: None,
            joint: None,
        }
    }
}

/// One table, or a list of others: what a schema says of keys is of tables alone, and what it says
/// of items is of lists alone.
pub(in crate::input::file) fn one_or_stacked_schema(generator: &mut SchemaGenerator) -> Schema {
    let stacked = generator.subschema_for::<StackLayerTable>();
    let mut schema = LayerTable::json_schema(generator);
    schema.insert("type".into(), json!(["object", "array"]));
    schema.insert("items".into(), stacked.into());
    schema.insert("minItems".into(), 1.into());
    schema
}
