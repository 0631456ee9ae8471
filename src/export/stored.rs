//! A finished study, read back from its folder: the study in `results.json` and the records of its
//! solves.

use super::finished::{FinishedStudy, PackedLayer};
use super::npz;
use super::print::{Bands, InstrumentGeometry, Print, PrintSpectra, PrintSpectrum, resample};
use super::provenance::Described;
use super::request::{ExportError, ExportResult};
use crate::evaluate::directional::{DirectionalInk, DirectionalPrint};
use crate::evaluate::ink::InkOnPaper;
use crate::evaluate::manifest::Manifest;
use crate::evaluate::printed::Prints;
use crate::evaluate::seen::{Seen, see};
use crate::evaluate::summary::summarise;
use crate::input::study::{Paper, Study};
use crate::input::variation::LightRule;
use crate::report::tables;
use crate::run::{Collected, Stores};
use crate::store::database::RECORDS;
use crate::work::rounds::collect;
use serde::Deserialize;
use std::path::Path;

/// Numbers and provenance of a run.
const RESULTS: &str = "results.json";

/// A finished study with the evaluation of its solves.
#[derive(Debug)]
pub struct Stored {
    /// The study.
    pub study: Study,
    /// Every record.
    pub collected: Collected,
    /// The evaluated records.
    pub seen: Seen,
}

#[derive(Deserialize)]
struct Results {
    study_hash: String,
    study: Study,
}

impl Stored {
    /// Reads a folder of `inkwave run`, or of one variant of a sweep.
    ///
    /// # Errors
    /// No results there, an unfinished study, or results and store that do not fit.
    pub fn read(path: &Path) -> ExportResult<Self> {
        let study = study(path)?;
        if study.composed().is_some() {
            let reason = format!("{} holds a composed layer, which has no orders and no BDF", path.display());
            let remedy = "spectra.csv, medium.csv and results.json have its numbers";
            return Err(ExportError::Folder { reason, remedy });
        }
        Self::of_study(study, path)
    }

    /// What the folder holds of the study that was read from it.
    pub(super) fn of_study(study: Study, path: &Path) -> ExportResult<Self> {
        let collected = collect(&study, &stores(path)?, 0);
        let asked = study.solves() - collected.as_ref().map_or(0, |collected| collected.spared(&study));
        let finished = collected.as_ref().map_or(0, Collected::finished);
        let Some(collected) = collected.filter(|_| finished >= asked) else {
            return Err(ExportError::Unfinished { path: path.to_owned(), finished, asked });
        };
        let seen = see(&study, &collected)?;
        Ok(Self { study, collected, seen })
    }
}

impl Stored {
    fn ink(&self, format: &str) -> ExportResult<&InkOnPaper> {
        self.seen.ink.as_ref().map_err(|reason| ExportError::no_ink(format, &reason.to_string()))
    }
}

impl FinishedStudy for Stored {
    fn study(&self) -> &Study {
        &self.study
    }

    fn is_isotropic(&self) -> bool {
        false
    }

    fn directions(&self, _: f64) -> ExportResult<Box<dyn DirectionalPrint + '_>> {
        Ok(Box::new(DirectionalInk::new(self.ink("mitsuba")?)?))
    }

    fn print(&self, _: f64, format: &str, created: &str) -> ExportResult<Print> {
        self.ink(format)?;
        print(self, format, created)
    }

    fn prints(&self) -> ExportResult<Option<Prints>> {
        Ok(summarise(&self.study, &self.collected, &self.seen).prints)
    }

    fn far_fields(&self) -> ExportResult<Vec<Described>> {
        let orders = npz::far_fields(&self.collected)?;
        Ok(vec![Described::new("far-fields.npz", orders, "all propagating orders of all solves")])
    }

    fn results(&self) -> ExportResult<Vec<Described>> {
        results_of(&summarise(&self.study, &self.collected, &self.seen), Some(&self.seen))
    }

    fn packed(&self, _: &str) -> ExportResult<PackedLayer<'_>> {
        Ok(PackedLayer { study: &self.study, resolution: self.collected.resolved.resolution })
    }
}

/// `results.json` and all tables.
pub(super) fn results_of(manifest: &Manifest, seen: Option<&Seen>) -> ExportResult<Vec<Described>> {
    let results = serde_json::to_vec_pretty(manifest)?;
    let mut files = vec![Described::new("results.json", results, "all numbers with their errors")];
    let tables = tables::of_study(manifest, seen)?;
    files.extend(tables.into_iter().map(|(name, bytes, about)| Described::new(name, bytes, about)));
    Ok(files)
}

/// The spectra with their colours. Fitted spectra are evaluated at the wavelengths of the file,
/// listed ones are interpolated. Lab is computed from the exported values, so that other programs
/// find the same.
fn print(stored: &Stored, format: &str, created: &str) -> ExportResult<Print> {
    let study = &stored.study;
    let bands = Bands::new(study, format)?;
    let of_page = summarise(study, &stored.collected, &stored.seen);
    let fitted = matches!(study.variation.light, LightRule::Shifted { .. });
    let spectra = if fitted {
        let wavelengths_nm = bands.wavelengths_nm.iter().map(|&nm| f64::from(nm)).collect();
        // without dots: layers of other runs are known at the study's wavelengths alone
        let paper = Paper { dots: None, ..study.paper.clone() };
        let on_grid = Study { wavelengths_nm, paper, ..study.clone() };
        let seen = see(&on_grid, &stored.collected)?;
        known(&summarise(&on_grid, &stored.collected, &seen), &of_page)
    } else {
        let mut known = known(&of_page, &of_page);
        known
            .iter_mut()
            .for_each(|k| k.values = resample(&study.wavelengths_nm, &k.values, &bands.wavelengths_nm));
        known
    };
    if let ([], Some(reason)) = (spectra.as_slice(), of_page.withheld.first()) {
        return Err(ExportError::no_ink(format, &reason.in_words()));
    }
    // a number that the page withholds is in no file
    let has_colours = of_page.ink_maker.is_some();
    Ok(Print::new(study, created, bands, PrintSpectra { spectra, interpolated: !fitted, has_colours }))
}

/// Both spectra of the print, those that are known at every wavelength; Lab of the page is that of
/// `of_page`.
fn known(manifest: &Manifest, of_page: &Manifest) -> Vec<PrintSpectrum> {
    let mut all = Vec::new();
    for geometry in InstrumentGeometry::ALL {
        // the ink on its paper is evaluated at normal incidence only
        let normal = manifest.spectra.whole().iter().filter(|row| row.polar_deg == 0.0);
        let values = normal.map(|row| geometry.of(row.lit_at_45, row.natural_light)).collect();
        let colour = |manifest: &Manifest| {
            let maker = manifest.ink_maker.as_ref()?;
            Some(geometry.of(&maker.print, &maker.natural_light).colour)
        };
        if let Some(values) = values {
            let lab_covariance = colour(manifest).and_then(|colour| colour.lab_covariance);
            let page_lab = colour(of_page).map(|colour| colour.lab);
            all.push(PrintSpectrum { geometry, values, lab_covariance, colour: None, page_lab });
        }
    }
    all
}

/// The checked study in `results.json`; its content hash shows that it is unchanged.
pub(super) fn study(path: &Path) -> ExportResult<Study> {
    let folder = path.display();
    let text = std::fs::read(path.join(RESULTS));
    let text = text.map_err(|e| e.to_string());
    let results = text.and_then(|text| serde_json::from_slice::<Results>(&text).map_err(|e| e.to_string()));
    let Results { study_hash, study } = results.map_err(|cause| ExportError::Folder {
        reason: format!("{folder} holds no results of `inkwave run`: {RESULTS}: {cause}"),
        remedy: "give the folder written by `inkwave run STUDY.toml`, or for a sweep a folder under variants/",
    })?;
    let found = study.key();
    if found.as_str() == study_hash {
        return Ok(study);
    }
    let reason = format!("{folder}: the study has hash {found}, its results were made for {study_hash}");
    let remedy = "results.json was edited or is of another version: run the study again";
    Err(ExportError::Folder { reason, remedy })
}

/// The store of the folder itself, or the one that the variants of a sweep share.
pub(super) fn stores(path: &Path) -> ExportResult<Stores> {
    let shared = path.join("../..");
    let place = if !path.join(RECORDS).exists() && shared.join(RECORDS).exists() { &shared } else { path };
    Stores::at(place).map_err(|cause| ExportError::Folder {
        reason: format!("cannot open the store of {}: {cause}", path.display()),
        remedy: "check the folder's permissions",
    })
}
