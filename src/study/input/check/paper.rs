//! The paper: its albedo as a number, a list or a table, and its contact with the layer.

use crate::appearance::paper::{Albedo, Coupling};
use crate::input::fault::Faults;
use crate::input::file::{CouplingName, StudyFile};
use crate::input::forms::AlbedoWritten;
use crate::input::limits;
use crate::input::study::Paper;
use crate::material::columns::micrometres;
use crate::numerics::files;
use serde::Deserialize;
use std::path::Path;

const REMEDY: &str = "0 is black, 1 is a perfect white, 0.9 is good paper";

pub fn paper(file: &StudyFile, wavelengths_nm: &[f64], folder: &Path, faults: &mut Faults) -> Paper {
    let coupling = match file.paper.coupling {
        CouplingName::Gap => Coupling::Gap,
        CouplingName::OpticalContact => Coupling::OpticalContact { index: file.layer.index_out },
    };
    let (source, albedo) = match &file.paper.albedo {
        AlbedoWritten::Constant(value) => {
            faults.number("paper.albedo", *value, limits::ALBEDO, REMEDY);
            (value.to_string(), Albedo::Constant(*value))
        }
        AlbedoWritten::Rows(rows) => {
            let source = format!("listed at {} wavelengths", rows.len());
            (source, spectral("paper.albedo", rows.clone(), wavelengths_nm, faults))
        }
        AlbedoWritten::Csv { csv } => {
            let path = folder.join(csv);
            let rows = read(&path, faults).unwrap_or_default();
            // only the file name: the same table is the same paper in any folder
            let name = path.file_name().map_or_else(|| csv.clone(), |name| name.to_string_lossy().into());
            (name, spectral("paper.albedo.csv", rows, wavelengths_nm, faults))
        }
    };
    Paper { source, albedo, coupling }
}

/// A table that covers every wavelength of the study.
fn spectral(field: &str, rows: Vec<[f64; 2]>, wavelengths_nm: &[f64], faults: &mut Faults) -> Albedo {
    let albedo = Albedo::Spectral(rows.clone());
    if let Some(i) = rows.iter().position(|row| !(0.0..=1.0).contains(&row[1])) {
        let found = format!("{} at {} nm", rows[i][1], rows[i][0]);
        faults.add(format!("{field}[{i}]"), found, "albedos from 0 to 1", REMEDY);
    } else if let Some(largest) = micrometres(rows.iter().map(|row| row[0])) {
        let found = format!("wavelengths up to {largest}, which look like µm");
        faults.add(field, found, "wavelengths in nm", "multiply the wavelengths by 1000");
    } else if let Some(error) = wavelengths_nm.iter().find_map(|&nm| albedo.at(nm).err()) {
        let allowed = "two or more rows [wavelength in nm, albedo], rising, that cover [light]";
        let remedy =
            "extend the table: colours need 400 to 700 nm; or, for spectra alone, keep [light] inside it";
        faults.add(field, error, allowed, remedy);
    }
    albedo
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct AlbedoRow {
    wavelength_nm: f64,
    albedo: f64,
}

fn read(path: &Path, faults: &mut Faults) -> Option<Vec<[f64; 2]>> {
    let mut builder = csv::ReaderBuilder::new();
    let builder = builder.comment(Some(b'#')).trim(csv::Trim::All);
    let rows = files::read_bytes(path, files::TABLE).map_err(csv::Error::from).and_then(|bytes| {
        builder.from_reader(bytes.as_slice()).deserialize().collect::<Result<Vec<AlbedoRow>, _>>()
    });
    let allowed = "a readable table with the header wavelength_nm,albedo";
    let remedy = "correct the table; its path is relative to the study file";
    let rows = rows.map_err(|error| {
        faults.add("paper.albedo.csv", format!("{} ({error})", path.display()), allowed, remedy);
    });
    Some(rows.ok()?.iter().map(|row| [row.wavelength_nm, row.albedo]).collect())
}
