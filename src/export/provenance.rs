//! Where the files come from and what their columns hold: a Process Run Crate (RO-Crate 1.1) and a
//! Data Package.

use crate::report::columns;
use serde_json::{Value, json};

/// One exported file.
#[derive(Clone, Debug)]
pub struct Described {
    /// Name relative to the crate.
    pub name: String,
    /// The file's bytes.
    pub bytes: Vec<u8>,
    /// Description of its content.
    pub about: String,
}

impl Described {
    /// A file with its description.
    pub fn new(name: &str, bytes: impl Into<Vec<u8>>, about: &str) -> Self {
        Self { name: name.to_owned(), bytes: bytes.into(), about: about.to_owned() }
    }
}

/// What a crate says about the run as a whole.
#[derive(Clone, Debug)]
pub struct Run {
    /// The study's heading.
    pub title: String,
    /// Content hash of the study.
    pub study_hash: String,
    /// Date and time of the export, RFC 3339.
    pub created: String,
}

/// Version of the program.
const VERSION: &str = env!("CARGO_PKG_VERSION");
/// File with the study as it was run.
pub const STUDY: &str = "study.json";
const METADATA: &str = "ro-crate-metadata.json";
const PROFILE: &str = "https://w3id.org/ro/wfrun/process/0.5";
const SPECIFICATION: &str = "https://w3id.org/ro/crate/1.1";

/// `ro-crate-metadata.json`: one action that made all files from the study.
pub fn ro_crate(run: &Run, files: &[Described]) -> Value {
    let reference = |id: &str| json!({ "@id": id });
    let parts: Vec<Value> = files.iter().map(|f| reference(&f.name)).collect();
    let results: Vec<Value> = files.iter().filter(|f| f.name != STUDY).map(|f| reference(&f.name)).collect();
    let mut graph = vec![
        json!({
            "@id": METADATA,
            "@type": "CreativeWork",
            "about": reference("./"),
            "conformsTo": reference(SPECIFICATION),
        }),
        json!({
            "@id": "./",
            "@type": "Dataset",
            "name": run.title,
            "description": format!("Simulated appearance of an ink layer, study {}", run.study_hash),
            "datePublished": run.created,
            "identifier": run.study_hash,
            "conformsTo": reference(PROFILE),
            "hasPart": parts,
            "mentions": reference("#run"),
        }),
        json!({ "@id": PROFILE, "@type": "CreativeWork", "name": "Process Run Crate", "version": "0.5" }),
        json!({
            "@id": "#inkwave",
            "@type": "SoftwareApplication",
            "name": "inkwave",
            "softwareVersion": VERSION,
            "version": VERSION,
            "description": env!("CARGO_PKG_DESCRIPTION"),
        }),
        json!({
            "@id": "#run",
            "@type": "CreateAction",
            "name": format!("inkwave run: {}", run.title),
            "instrument": reference("#inkwave"),
            "object": [reference(STUDY)],
            "result": results,
            "endTime": run.created,
        }),
    ];
    graph.extend(files.iter().map(file_entity));
    json!({ "@context": format!("{SPECIFICATION}/context"), "@graph": graph })
}

fn file_entity(file: &Described) -> Value {
    json!({
        "@id": file.name,
        "@type": "File",
        "name": file.name,
        "description": file.about,
        "contentSize": file.bytes.len().to_string(),
        "encodingFormat": media_type(&file.name),
    })
}

/// `datapackage.json`: every file, and the types of every table's columns. Types are stated because
/// readers that guess them take an angle that happens to be whole for an integer.
pub fn data_package(run: &Run, files: &[Described]) -> Value {
    json!({
        "profile": "data-package",
        "name": format!("inkwave-{}", run.study_hash),
        "title": run.title,
        "id": run.study_hash,
        "created": run.created,
        "version": VERSION,
        "resources": files.iter().map(resource).collect::<Vec<_>>(),
    })
}

fn resource(file: &Described) -> Value {
    let name = file.name.to_lowercase().replace([' ', '/'], "-");
    let mut resource = json!({
        "name": name.replace('.', "-"),
        "path": file.name,
        "description": file.about,
        "mediatype": media_type(&file.name),
        "bytes": file.bytes.len(),
    });
    if file.name.ends_with(".csv") {
        resource["profile"] = json!("tabular-data-resource");
        resource["format"] = json!("csv");
        resource["encoding"] = json!("utf-8");
        resource["schema"] =
            json!({ "fields": columns::fields(&file.name, &file.bytes, &[]), "missingValues": [""] });
    }
    resource
}

fn media_type(name: &str) -> &'static str {
    match name.rsplit('.').next().unwrap_or("") {
        "csv" => "text/csv",
        "json" => "application/json",
        "png" => "image/png",
        "html" => "text/html",
        "xml" | "cxf" | "vti" | "vtp" => "application/xml",
        "cgats" | "sp" | "txt" | "toml" => "text/plain",
        "npz" => "application/zip",
        _ => "application/octet-stream",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_file_is_part_of_the_crate_and_every_column_has_a_type() {
        let run =
            Run { title: "Yellow".into(), study_hash: "0f".into(), created: "2026-01-01T00:00:00Z".into() };
        let file = |name: &str, bytes: &[u8]| Described {
            name: name.into(),
            bytes: bytes.into(),
            about: "x".into(),
        };
        let files = [file(STUDY, b"{}"), file("bdf.csv", b"polar_deg,from,m,specular\n0,above,0,true\n")];
        let crate_ = ro_crate(&run, &files);
        let graph = crate_["@graph"].as_array().unwrap();
        let by_id = |id: &str| graph.iter().find(|e| e["@id"] == id).unwrap();
        assert_eq!(by_id("./")["hasPart"].as_array().unwrap().len(), 2);
        assert_eq!(by_id("#run")["result"], json!([{ "@id": "bdf.csv" }]));
        let package = data_package(&run, &files);
        let fields = &package["resources"][1]["schema"]["fields"];
        let types: Vec<&str> =
            fields.as_array().unwrap().iter().map(|f| f["type"].as_str().unwrap()).collect();
        assert_eq!(types, ["number", "string", "integer", "boolean"]);
    }
}
