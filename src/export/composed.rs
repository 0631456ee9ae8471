//! A composed layer as exports read it: everything but what needs a packing of the whole layer.

use super::finished::{FinishedStudy, PackedLayer};
use super::npz;
use super::print::{Bands, InstrumentGeometry, Print, PrintSpectra, PrintSpectrum, resample};
use super::provenance::Described;
use super::request::{ExportError, ExportResult};
use super::stored::{self, results_of};
use crate::evaluate::composed::level::SolvedPortion;
use crate::evaluate::composed::view::ComposedView;
use crate::evaluate::directional::DirectionalPrint;
use crate::evaluate::evaluated::{Evaluated, FinishedSolves};
use crate::evaluate::manifest::composed::{ComposedColours, ComposedRow, independent};
use crate::evaluate::printed::Prints;
use crate::evaluate::published::{ErrorParts, Withheld};
use crate::evaluate::quantities::Lab;
use crate::input::study::Study;
use crate::work::alone::stored_portions;
use std::cell::OnceCell;
use std::path::Path;

/// The solved slabs of a finished composed layer, read back from its folder.
#[derive(Debug)]
pub struct StoredSlabs {
    study: Study,
    solved: FinishedSolves,
}

/// A composed layer with its numbers, which are evaluated once, when a format needs them.
pub struct EvaluatedSlabs<'a> {
    slabs: &'a StoredSlabs,
    evaluated: OnceCell<Evaluated<'a>>,
}

impl StoredSlabs {
    /// What the folder holds of the study that was read from it.
    pub(super) fn of_study(study: Study, path: &Path) -> ExportResult<Self> {
        let stores = stored::stores(path)?;
        let solved = stored_portions(&study, &stores);
        let solved = FinishedSolves::Slabs(solved);
        let finished = solved.finished();
        let asked = study.solves();
        if finished < asked {
            return Err(ExportError::Unfinished { path: path.to_owned(), finished, asked });
        }
        Ok(Self { study, solved })
    }

    /// The study of the layer, and what is solved of its slabs.
    pub fn portions(&self) -> (&Study, &[SolvedPortion]) {
        (&self.study, self.solved.slabs())
    }

    /// For its exports.
    pub fn evaluated(&self) -> EvaluatedSlabs<'_> {
        EvaluatedSlabs { slabs: self, evaluated: OnceCell::new() }
    }
}

impl<'a> EvaluatedSlabs<'a> {
    fn evaluated(&self) -> ExportResult<&Evaluated<'a>> {
        if let Some(evaluated) = self.evaluated.get() {
            return Ok(evaluated);
        }
        let evaluated = Evaluated::new(&self.slabs.study, &self.slabs.solved)?;
        Ok(self.evaluated.get_or_init(|| evaluated))
    }
}

/// What belongs to a geometry.
fn spectrum(geometry: InstrumentGeometry, row: &ComposedRow) -> Option<ErrorParts> {
    geometry.of(row.layer.lit_at_45, row.layer.natural_light)
}

fn lab(geometry: InstrumentGeometry, colours: &ComposedColours) -> Option<Lab<ErrorParts>> {
    geometry.of(colours.lit_at_45, colours.natural_light)
}

impl FinishedStudy for EvaluatedSlabs<'_> {
    fn study(&self) -> &Study {
        &self.slabs.study
    }

    fn is_isotropic(&self) -> bool {
        true
    }

    fn directions(&self, thickness_um: f64) -> ExportResult<Box<dyn DirectionalPrint + '_>> {
        let (study, solved) = self.slabs.portions();
        let view = ComposedView::new(study, solved, thickness_um);
        Ok(Box::new(view.map_err(ExportError::Refused)?))
    }

    fn print(&self, thickness_um: f64, format: &str, created: &str) -> ExportResult<Print> {
        let study = &self.slabs.study;
        let manifest = &self.evaluated()?.manifest;
        let bands = Bands::new(study, format)?;
        let composed = manifest.composed();
        let colours = composed.as_ref().and_then(|composed| composed.colours_of(thickness_um));
        let mut spectra = Vec::new();
        for geometry in InstrumentGeometry::ALL {
            let rows = composed.iter().flat_map(|composed| composed.rows_of(thickness_um));
            let values: Option<Vec<_>> = rows.map(|row| Some(spectrum(geometry, row)?.estimate())).collect();
            let withheld = || {
                let reasons: Vec<_> = manifest.withheld.iter().map(Withheld::in_words).collect();
                ExportError::Refused(format!("the spectrum has withheld numbers: {}", reasons.join("; ")))
            };
            let values =
                resample(&study.wavelengths_nm, &values.ok_or_else(withheld)?, &bands.wavelengths_nm);
            let page = colours.and_then(|colours| lab(geometry, colours));
            spectra.push(PrintSpectrum {
                geometry,
                values,
                lab_covariance: page.map(independent),
                colour: None,
                page_lab: page.map(|lab| lab.map(|part| part.value)),
            });
        }
        let has_colours = colours.is_some();
        let print =
            Print::new(study, created, bands, PrintSpectra { spectra, interpolated: true, has_colours });
        Ok(Print { title: format!("{}, {thickness_um} µm", study.title), ..print })
    }

    fn prints(&self) -> ExportResult<Option<Prints>> {
        Ok(self.evaluated()?.manifest.prints.clone())
    }

    /// One file for each kind of slab.
    fn far_fields(&self) -> ExportResult<Vec<Described>> {
        let mut files = Vec::new();
        for (study, collected) in self.slabs.portions().1 {
            let kind = study.portion().map(|portion| portion.in_words()).unwrap_or_default();
            let named = |ending: &str| format!("far-fields-{}{ending}.npz", file_name(&kind));
            let is_taken = |name: &String| files.iter().any(|file: &Described| &file.name == name);
            // names of layers may differ by signs alone that file names do not hold
            let name = std::iter::once(named("")).chain((2..).map(|n| named(&format!("-{n}"))));
            let name = name.into_iter().find(|name| !is_taken(name)).unwrap_or_default();
            let orders = npz::far_fields(collected)?;
            files.push(Described::new(&name, orders, &format!("all propagating orders: {kind}")));
        }
        Ok(files)
    }

    fn results(&self) -> ExportResult<Vec<Described>> {
        results_of(&self.evaluated()?.manifest, None)
    }

    fn packed(&self, format: &str) -> ExportResult<PackedLayer<'_>> {
        let allowed = "allowed are mitsuba, cxf, cgats, npz and crate";
        let reason = "shows one packing, and a composed layer has none of its own";
        Err(ExportError::Refused(format!("{format} {reason}: {allowed}")))
    }
}

/// Words as a part of a file's name: letters and digits, with a hyphen for all between them.
fn file_name(words: &str) -> String {
    let parts = words.split(|c: char| !c.is_alphanumeric()).filter(|part| !part.is_empty());
    parts.collect::<Vec<_>>().join("-")
}
