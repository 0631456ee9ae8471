//! What strategies are compared on: a study's first packing at one wavelength and direction, or an
//! explicit case.

use super::error::CompareResult;
use super::row::Varied;
use crate::input::case::Case;
use crate::input::check::check;
use crate::input::fault::{Fault, StudyError};
use crate::input::file::StudyFile;
use crate::input::forms::{IndexWritten, Pair};
use crate::input::load::{read_study, read_table};
use crate::input::study::Study;
use crate::input::variation::CellRule;
use crate::numerics::files;
use crate::run::point::pack_realisation;
use crate::wave::{Incidence, Media, Scene};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Deserialize;
use std::borrow::Cow;
use std::path::{Path, PathBuf};

/// The study of a comparison, as written.
#[derive(Clone, Debug, Deserialize)]
#[serde(untagged, expecting = "a study file's path, or a table with a whole study")]
pub enum StudyWritten {
    /// Its file, relative to the comparison.
    File(PathBuf),
    /// The study itself.
    Table(toml::Table),
}

impl JsonSchema for StudyWritten {
    fn schema_name() -> Cow<'static, str> {
        "StudyOrFile".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let file = "A study file, relative to this one.";
        let study = generator.subschema_for::<StudyFile>();
        json_schema!({ "anyOf": [{ "description": file, "type": "string" }, study] })
    }
}

/// A study, and the light that strategies are compared at.
#[derive(Clone, Debug)]
pub(super) struct Packed {
    file: StudyFile,
    /// The file it was read from: its tables are relative to this file, and errors name it.
    path: PathBuf,
    /// Prefix of its keys in that file.
    inside: &'static str,
    /// Wavelength, nm; the middle one of the study if not given.
    wavelength_nm: Option<f64>,
    /// Polar angle, degrees; the first of the study if not given.
    polar_deg: Option<f64>,
}

impl Packed {
    /// A study as written in the comparison `origin`, at a wavelength in nm and a polar angle.
    pub fn read(
        written: &StudyWritten,
        origin: &Path,
        wavelength_nm: Option<f64>,
        polar_deg: Option<f64>,
    ) -> CompareResult<Packed> {
        let (file, path, inside) = match written {
            StudyWritten::File(path) => {
                let path = origin.parent().unwrap_or(Path::new("")).join(path);
                (read_study(&path)?.1, path, "")
            }
            StudyWritten::Table(table) => {
                let file = read_table(table.clone()).map_err(|faults| told(faults, origin, INSIDE))?;
                (file, origin.to_owned(), INSIDE)
            }
        };
        Ok(Packed { file, path, inside, wavelength_nm, polar_deg })
    }

    /// Replaces the cell by a square one of the given period, and the index of the first pigment.
    pub fn varied(&self, Varied { pigment: [n, kappa], period_um }: Varied) -> CompareResult<Packed> {
        let mut other = self.clone();
        other.file.layer.cell = CellRule::Fixed;
        other.file.layer.period_um = Some(Pair::Both(period_um));
        let Some(pigment) = other.file.pigments.first_mut() else {
            let allowed = "at least one pigment, whose index the matrix varies";
            return Err(Fault::new("study.pigment", "none", allowed, "add a [[study.pigment]]").into());
        };
        pigment.index = IndexWritten { n: Some(n), k: Some(kappa), ..IndexWritten::default() };
        Ok(other)
    }

    /// The study, checked.
    ///
    /// # Errors
    /// Errors of the study; a study with a wave of its own.
    fn study(&self) -> CompareResult<Study> {
        let checked = check(&self.file, self.path.parent().unwrap_or(Path::new("")), "study");
        let study = checked.map_err(|faults| told(faults, &self.path, self.inside))?;
        if study.wave.is_vector() {
            let allowed = "scalar: the comparison's own `wave` says which equation is solved";
            let remedy = "leave it out, and write wave = \"vector\" in the comparison";
            return Err(Fault::new("study.light.wave", study.wave.name(), allowed, remedy).into());
        }
        // of a composed layer, an inner slab
        Ok(study.portions().into_iter().next().unwrap_or(study))
    }

    /// Packs the first realisation.
    ///
    /// # Errors
    /// Faults of the study, a wavelength outside its range, no packing.
    pub fn case(&self) -> CompareResult<Case> {
        let study = self.study()?;
        let scene = Scene::from_packing(&pack_realisation(&study, 0, &())?);
        let incidence = self.incidence(&study)?;
        let media = study.media(incidence.wavelength_um);
        scene.check(&media)?;
        incidence.check()?;
        Ok(Case { scene, media, incidence, directions: Vec::new(), remarks: Vec::new() })
    }

    /// The indices of all media.
    ///
    /// # Errors
    /// Faults of the study, a wavelength outside its range.
    pub fn media(&self) -> CompareResult<Media> {
        let study = self.study()?;
        Ok(study.media(self.incidence(&study)?.wavelength_um))
    }

    fn incidence(&self, study: &Study) -> CompareResult<Incidence> {
        let all = &study.wavelengths_nm;
        let nm = self.wavelength_nm.unwrap_or(all[all.len() / 2]);
        let low = all[0];
        let high = all[all.len() - 1];
        if !(low..=high).contains(&nm) {
            let allowed = format!("{low} to {high} nm, the study's range");
            let remedy = "widen the study's [light], or leave the wavelength out";
            return Err(Fault::new("wavelength_nm", nm, allowed, remedy).into());
        }
        let first = study.points(0)[0].incidence;
        let polar_deg = self.polar_deg.unwrap_or(first.polar_deg);
        Ok(Incidence { wavelength_um: 1e-3 * nm, polar_deg, ..first })
    }
}

/// Prefix of the keys of a study inside a comparison.
const INSIDE: &str = "study.";

/// Errors of a study with the text of its file, or without if that can no longer be read.
fn told(faults: Vec<Fault>, path: &Path, inside: &str) -> StudyError {
    let faults = faults.into_iter();
    let faults = faults.map(|fault| Fault { field: format!("{inside}{}", fault.field), ..fault }).collect();
    let text = files::read_text(path, files::STUDY).unwrap_or_default();
    StudyError::Values { path: path.to_owned(), text, faults }
}
