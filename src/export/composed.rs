//! Exports of a composed layer: those that need no packing of the whole layer.

use super::print::{InstrumentGeometry, Print, PrintSpectrum, bands, resample};
use super::request::{ExportError, ExportResult, Format, Request};
use super::run::{Exported, in_air};
use super::{npz, stored};
use crate::evaluate::composed::level::SolvedPortion;
use crate::evaluate::composed::manifest::ComposedManifest;
use crate::evaluate::composed::report::report;
use crate::evaluate::composed::view::ComposedView;
use crate::evaluate::published::{ErrorParts, Withheld};
use crate::input::study::Study;
use crate::report::composed::tables;
use crate::run::watch::RunWatch;
use crate::sweep::work::rounds::collect;
use std::path::Path;

/// A finished composed layer, read back from its folder.
#[derive(Debug)]
pub struct ComposedStored {
    study: Study,
    solved: Vec<SolvedPortion>,
}

impl ComposedStored {
    /// Reads a folder of `inkwave run`; `None` if its layer is not composed.
    ///
    /// # Errors
    /// No results there, an unfinished study, or results and store that do not fit.
    pub fn read(path: &Path) -> ExportResult<Option<Self>> {
        let study = stored::study(path)?;
        if study.layer.composed.is_none() {
            return Ok(None);
        }
        let stores = stored::stores(path)?;
        let portions = study.portions().into_iter();
        let solved: Vec<SolvedPortion> =
            portions.filter_map(|portion| Some((portion.clone(), collect(&portion, &stores, 0)?))).collect();
        let (finished, asked) = (solved.iter().map(|(_, c)| c.finished()).sum(), study.solves());
        if finished < asked {
            return Err(ExportError::Unfinished { path: path.to_owned(), finished, asked });
        }
        Ok(Some(Self { study, solved }))
    }

    /// Makes all files that `request` asks for, in memory.
    ///
    /// # Errors
    /// A format that shows one packing, or a study that does not carry what a format needs.
    pub fn export(&self, request: &Request, watch: &dyn RunWatch) -> ExportResult<Exported> {
        if request.near_field.is_some() {
            return Err(one_packing("near field"));
        }
        let um = self.thickness(request.thickness_um)?;
        let manifest = report(&self.study, &self.solved).map_err(ExportError::Refused)?;
        let print = |format| self.print(&manifest, um, format, &request.created);
        let mut out = Exported::default();
        for &format in &request.formats {
            match format {
                Format::Mitsuba => {
                    in_air(&self.study)?;
                    watch.stage("tabulating the material");
                    let view = ComposedView::new(&self.study, &self.solved, um);
                    out.material(&view.map_err(ExportError::Refused)?, &self.study)?;
                    out.remarks
                        .push(format!("the material is the layer of {um} µm, a mean over the azimuth"));
                }
                Format::Cxf => out.cxf(&print("cxf")?)?,
                Format::Cgats => out.cgats(&print("cgats")?),
                Format::Npz => self.npz(&mut out)?,
                Format::Crate => {
                    let about = "all numbers with their errors";
                    out.add("results.json", serde_json::to_vec_pretty(&manifest)?, about);
                    for (name, bytes, about) in tables(&manifest)? {
                        out.add(name, bytes, about);
                    }
                    out.describe(&self.study, &request.created)?;
                }
                other => return Err(one_packing(&format!("{other:?}").to_lowercase())),
            }
        }
        Ok(out)
    }

    /// The thickness asked for, µm: one of the study's.
    fn thickness(&self, asked: Option<f64>) -> ExportResult<f64> {
        let all = self.study.layer.composed.iter().flat_map(|composed| &composed.thicknesses_um);
        let found = asked.or_else(|| all.clone().next().copied()).unwrap_or(f64::NAN);
        if all.clone().any(|um| *um == found) {
            return Ok(found);
        }
        let allowed = all.map(f64::to_string).collect::<Vec<_>>().join(", ");
        Err(ExportError::thickness(found, &allowed))
    }

    /// Spectra of the layer of this thickness, interpolated to a grid of 10 nm.
    fn print(&self, report: &ComposedManifest, um: f64, format: &str, created: &str) -> ExportResult<Print> {
        let (study, nm) = (&self.study, &self.study.wavelengths_nm);
        let (grid, meter) = bands(study, format)?;
        let colours = report.colours.iter().find(|colours| colours.thickness_um == um);
        let mut spectra = Vec::new();
        for geometry in InstrumentGeometry::ALL {
            let own = report.spectra.iter().filter(|row| row.thickness_um == um);
            let values =
                own.map(|row| Some(geometry.of(row.layer.lit_at_45, row.layer.natural_light)?.estimate()));
            let values: Option<Vec<_>> = values.collect();
            let withheld = || {
                let reasons: Vec<_> = report.withheld.iter().map(Withheld::in_words).collect();
                ExportError::Refused(format!("the spectrum has withheld numbers: {}", reasons.join("; ")))
            };
            let values = resample(nm, &values.ok_or_else(withheld)?, &grid);
            let page = colours.and_then(|colours| geometry.of(colours.lit_at_45, colours.natural_light));
            let (lab_covariance, page_lab) = (page.map(diagonal), page.map(|lab| lab.map(|part| part.value)));
            spectra.push(PrintSpectrum { geometry, values, lab_covariance, colour: None, page_lab });
        }
        let print = Print::new(study, created, (grid, meter.filter(|_| colours.is_some())), (true, spectra));
        Ok(Print { title: format!("{}, {um} µm", study.title), ..print })
    }

    /// The orders of every slab's solves, one file for each kind of slab.
    fn npz(&self, out: &mut Exported) -> ExportResult {
        for (study, collected) in &self.solved {
            let kind = study.portion.as_ref().map(|portion| portion.in_words()).unwrap_or_default();
            let name = format!("far-fields-{}.npz", kind.replace(", ", "-").replace(' ', "-"));
            out.add(&name, npz::far_fields(collected)?, &format!("all propagating orders: {kind}"));
        }
        Ok(())
    }
}

/// A format that composed layers do not have.
fn one_packing(format: &str) -> ExportError {
    let allowed = "allowed are mitsuba, cxf, cgats, npz and crate";
    let reason = "shows one packing, and a composed layer has none of its own";
    ExportError::Refused(format!("{format} {reason}: {allowed}"))
}

/// The bars of Lab, as if they were independent.
fn diagonal(lab: [ErrorParts; 3]) -> [[f64; 3]; 3] {
    let mut covariance = [[0.0; 3]; 3];
    (0..3).for_each(|i| covariance[i][i] = lab[i].standard_error.powi(2));
    covariance
}
