//! Exports of a composed layer: those that need no packing of the whole layer.

use super::error::ExportError;
use super::print::{InstrumentGeometry, Print, PrintSpectrum, resample, uniform_grid};
use super::run::{Exported, Format, Request, in_air};
use super::{cxf, npz, stored};
use crate::appearance::colour::{Colorimeter, Colour};
use crate::evaluate::composed::level::SolvedPortion;
use crate::evaluate::composed::manifest::{ComposedColours, ComposedManifest, ComposedRow, ErrorParts};
use crate::evaluate::composed::report::report;
use crate::evaluate::composed::view::ComposedView;
use crate::evaluate::summary::program;
use crate::input::study::Study;
use crate::numerics::estimate::Estimate;
use crate::report::composed::tables;
use crate::run::watch::RunWatch;
use crate::store::record::PointRecord;
use crate::sweep::work::rounds::collect;
use clap::ValueEnum;
use std::path::Path;

/// A finished composed layer, read back from its folder.
#[derive(Debug)]
pub struct ComposedStored {
    study: Study,
    solved: Vec<SolvedPortion>,
}

/// A spectrum of the print: where from, and its Lab on the page.
type PublishedSpectrum =
    (InstrumentGeometry, fn(&ComposedRow) -> ErrorParts, fn(&ComposedColours) -> [ErrorParts; 3]);

const SPECTRA: [PublishedSpectrum; 2] = [
    (InstrumentGeometry::LitAt45, |row| row.lit_at_45, |colours| colours.lit_at_45),
    (InstrumentGeometry::NaturalLight, |row| row.natural_light, |colours| colours.natural_light),
];

impl ComposedStored {
    /// Reads a folder of `inkwave run`; `None` if its layer is not composed.
    ///
    /// # Errors
    /// No results there, an unfinished study, or results and store that do not fit.
    pub fn read(path: &Path) -> Result<Option<Self>, ExportError> {
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
    pub fn export(&self, request: &Request, watch: &dyn RunWatch) -> Result<Exported, ExportError> {
        if request.near_field.is_some() {
            return Err(ExportError::OnePacking { format: "near field".to_owned() });
        }
        let um = self.thickness(request.thickness_um)?;
        let manifest = report(&self.study, &self.solved).map_err(ExportError::Slabs)?;
        let print = |format| self.print(&manifest, um, format, &request.created);
        let mut out = Exported::default();
        for &format in &request.formats {
            match format {
                Format::Mitsuba => {
                    in_air(&self.study)?;
                    watch.stage("tabulating the material");
                    let view =
                        ComposedView::new(&self.study, &self.solved, um).map_err(ExportError::Slabs)?;
                    out.material(&view, &self.study)?;
                    out.remarks
                        .push(format!("the material is the layer of {um} µm, a mean over the azimuth"));
                }
                Format::Cxf => {
                    out.add("spectra.cxf", cxf::cxf(&print("cxf")?)?, "spectra of the print with Lab, CxF3");
                }
                Format::Cgats => out.cgats(&print("cgats")?),
                Format::Npz => self.npz(&mut out)?,
                Format::Crate => (),
                other => {
                    let name = other.to_possible_value().map(|value| value.get_name().to_owned());
                    return Err(ExportError::OnePacking { format: name.unwrap_or_default() });
                }
            }
        }
        if request.formats.contains(&Format::Crate) {
            out.add("results.json", serde_json::to_vec_pretty(&manifest)?, "all numbers with their errors");
            for (name, bytes, about) in tables(&manifest)? {
                out.add(name, bytes, about);
            }
            out.describe(&self.study, &request.created)?;
        }
        Ok(out)
    }

    /// The thickness asked for, µm: one of the study's.
    fn thickness(&self, asked: Option<f64>) -> Result<f64, ExportError> {
        let all = self.study.layer.composed.iter().flat_map(|composed| &composed.thicknesses_um);
        let found = asked.or_else(|| all.clone().next().copied()).unwrap_or(f64::NAN);
        if all.clone().any(|um| *um == found) {
            return Ok(found);
        }
        let allowed = all.map(f64::to_string).collect::<Vec<_>>().join(", ");
        Err(ExportError::Thickness { found, allowed })
    }

    /// Spectra of the layer of this thickness, interpolated to a grid of 10 nm.
    fn print(
        &self,
        manifest: &ComposedManifest,
        um: f64,
        format: &'static str,
        created: &str,
    ) -> Result<Print, ExportError> {
        let (study, nm) = (&self.study, &self.study.wavelengths_nm);
        let grid = uniform_grid(nm);
        if grid.len() < 2 || nm.len() < 2 {
            return Err(ExportError::TooFewWavelengths { format });
        }
        let wavelengths_nm: Vec<f64> = grid.iter().map(|&nm| f64::from(nm)).collect();
        let viewing = &study.judgement.viewing;
        let meter = Colorimeter::under(&wavelengths_nm, viewing).ok();
        let colours = manifest.colours.iter().find(|colours| colours.thickness_um == um);
        let mut spectra = Vec::new();
        for (geometry, of, lab) in SPECTRA {
            let own = manifest.spectra.iter().filter(|row| row.thickness_um == um);
            let values: Vec<Estimate> = own.map(|row| of(row).estimate()).collect();
            let values = resample(nm, &values, &grid);
            let reflectance: Vec<f64> = values.iter().map(|e| e.value).collect();
            let page = colours.map(lab);
            let colour = meter.as_ref().and_then(|meter| meter.colour(&reflectance).ok()).zip(page);
            let colour =
                colour.map(|(colour, page)| Colour { lab_covariance: Some(diagonal(page)), ..colour });
            let page_lab = page.map(|page| page.map(|part| part.value));
            spectra.push(PrintSpectrum { geometry, values, colour, page_lab });
        }
        Ok(Print {
            title: format!("{}, {um} µm", study.title),
            study_hash: study.key().to_string(),
            program: program(),
            created: created.to_owned(),
            viewing: viewing.clone(),
            spectra,
            interpolated: true,
            wavelengths_nm: grid,
        })
    }

    /// The orders of every slab's solves, one file for each kind of slab.
    fn npz(&self, out: &mut Exported) -> Result<(), ExportError> {
        for (study, collected) in &self.solved {
            let records: Vec<&PointRecord> =
                collected.realisations.iter().flat_map(|r| r.points.iter().flatten()).collect();
            let kind = study.portion.as_ref().map(|portion| portion.in_words()).unwrap_or_default();
            let name = format!("far-fields-{}.npz", kind.replace(", ", "-").replace(' ', "-"));
            out.add(&name, npz::far_fields(&records)?, &format!("all propagating orders: {kind}"));
        }
        Ok(())
    }
}

/// The bars of Lab, as if they were independent.
fn diagonal(lab: [ErrorParts; 3]) -> [[f64; 3]; 3] {
    let own = |i: usize, j: usize| if i == j { lab[i].standard_error.powi(2) } else { 0.0 };
    std::array::from_fn(|i| std::array::from_fn(|j| own(i, j)))
}
