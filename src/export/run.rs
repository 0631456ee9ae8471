//! `inkwave export`: from a finished study to files in the formats asked for.

use super::mitsuba::{self, Table};
use super::print::{Geometry, Print, PrintSpectrum, resample, uniform_grid};
use super::provenance::{self, Described, Run, STUDY};
use super::samples::{self, SampleError};
use super::stored::Stored;
use super::voxels::Voxels;
use super::{cgats, cxf, near_field, npz, viewer};
use crate::evaluate::directional::DirectionalInk;
use crate::evaluate::ink::{InkError, InkOnPaper};
use crate::evaluate::manifest::Manifest;
use crate::evaluate::seen::NoInk;
use crate::evaluate::summary::{LIT_AT_45, NATURAL_LIGHT, program, summarise};
use crate::ink::PackError;
use crate::input::study::Study;
use crate::numerics::estimate::Estimate;
use crate::report::tables;
use crate::run::point::{Stopper, pack_realisation};
use crate::run::watch::RunWatch;
use crate::solve::SolveError;
use crate::store::record::PointRecord;
use crate::wave::{Coverage, Incidence, Mean, Problem, Scene, Side, WaveError};
use std::sync::Arc;

/// A format, or a group of files that belong together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Measured material for the renderer Mitsuba 3, spectral and RGB, with scenes and tables to check it by.
    Mitsuba,
    /// CxF3: spectra with Lab.
    Cxf,
    /// CGATS.17 and ArgyllCMS's dialect of it.
    Cgats,
    /// Far fields as NumPy arrays.
    Npz,
    /// Contrast, and on request the wave inside the layer, as VTK images.
    Vti,
    /// The first packing as a page for the browser.
    Viewer,
    /// RO-Crate and Data Package with the tables they describe.
    Crate,
}

/// Light for a near field, which is computed anew: no run keeps it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearField {
    /// One of the study's wavelengths, nm.
    pub wavelength_nm: f64,
    /// Angle of incidence, degrees.
    pub polar_deg: f64,
}

/// What to export.
#[derive(Clone, Debug)]
pub struct Request {
    /// Formats, in any order.
    pub formats: Vec<Format>,
    /// A solve for `near-field.vti`; none unless asked.
    pub near_field: Option<NearField>,
    /// Date and time for the files that carry one, RFC 3339.
    pub created: String,
}

/// Why something could not be exported.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// Colours and materials need the ink on its paper.
    #[error("{format} needs the ink on its paper: {reason}")]
    NoInk {
        /// The format.
        format: &'static str,
        /// Why there is none.
        reason: String,
    },
    /// The material's frame is vacuum.
    #[error("layer.index_above is {index}; a renderer's material lies in air: allowed is 1")]
    NotInAir {
        /// Index of the incident side.
        index: f64,
    },
    /// The wavelength is not one of the study's.
    #[error("near field: found {found} nm; allowed is one of the study's wavelengths, {allowed} nm")]
    Wavelength {
        /// Asked for, nm.
        found: f64,
        /// The study's own, nm.
        allowed: String,
    },
    /// The near field of Maxwell's equations is known as moments alone.
    #[error(
        "near field: light.wave is {wave}; allowed is \"scalar\": Maxwell's equations are solved for moments of E, which no volume shows yet"
    )]
    VectorNearField {
        /// The study's wave.
        wave: &'static str,
    },
    /// Too few wavelengths for spectra on a grid of 10 nm.
    #[error("{format} needs at least two multiples of 10 nm inside the study's wavelengths")]
    TooFewWavelengths {
        /// The format.
        format: &'static str,
    },
    /// The appearance refuses.
    #[error(transparent)]
    Ink(#[from] InkError),
    /// A table was not made.
    #[error(transparent)]
    Sample(#[from] SampleError),
    /// A table was not made.
    #[error("cannot write a table: {0}")]
    Csv(#[from] csv::Error),
    /// JSON was not made.
    #[error("cannot write JSON: {0}")]
    Json(#[from] serde_json::Error),
    /// The archive of arrays was not made.
    #[error("cannot write the archive of arrays: {0}")]
    Npz(#[from] ndarray_npy::WriteNpzError),
    /// The packing could not be made again.
    #[error(transparent)]
    Packing(#[from] PackError),
    /// The near field's problem is not valid.
    #[error(transparent)]
    Wave(#[from] WaveError),
    /// The near field's solve failed.
    #[error(transparent)]
    Solve(#[from] SolveError),
}

/// The files, and what a person should know about them.
#[derive(Clone, Debug, Default)]
pub struct Exported {
    /// Every file, none written yet.
    pub files: Vec<Described>,
    /// Remarks, one line each.
    pub remarks: Vec<String>,
}

/// Makes all files that `request` asks for, in memory.
///
/// # Errors
/// A study that does not carry what a format needs.
pub fn export(stored: &Stored, request: &Request, watch: &dyn RunWatch) -> Result<Exported, ExportError> {
    let exporter = Exporter { stored, request, watch };
    let wants = |format| request.formats.contains(&format);
    let mut out = Exported::default();
    if wants(Format::Mitsuba) {
        exporter.mitsuba(&mut out)?;
    }
    if wants(Format::Cxf) {
        let text = cxf::cxf(&exporter.print("cxf")?);
        out.add("spectra.cxf", text, "spectra of the print with Lab, CxF3");
    }
    if wants(Format::Cgats) {
        exporter.cgats(&mut out)?;
    }
    if wants(Format::Npz) {
        exporter.npz(&mut out)?;
    }
    if wants(Format::Vti) || request.near_field.is_some() {
        exporter.vti(&mut out)?;
    }
    if wants(Format::Viewer) {
        exporter.viewer(&mut out)?;
    }
    if wants(Format::Crate) {
        exporter.provenance(&mut out)?;
    }
    Ok(out)
}

impl Exported {
    fn add(&mut self, name: &str, bytes: impl Into<Vec<u8>>, about: &str) {
        self.files.push(Described { name: name.to_owned(), bytes: bytes.into(), about: about.to_owned() });
    }
}

struct Exporter<'a> {
    stored: &'a Stored,
    request: &'a Request,
    watch: &'a dyn RunWatch,
}

impl Exporter<'_> {
    fn study(&self) -> &Study {
        &self.stored.study
    }

    fn ink(&self, format: &'static str) -> Result<&InkOnPaper, ExportError> {
        let reason = |reason: &NoInk| ExportError::NoInk { format, reason: reason.to_string() };
        self.stored.seen.ink.as_ref().map_err(reason)
    }

    fn mitsuba(&self, out: &mut Exported) -> Result<(), ExportError> {
        let (ink, study) = (self.ink("mitsuba")?, self.study());
        if study.layer.index_above != 1.0 {
            return Err(ExportError::NotInAir { index: study.layer.index_above });
        }
        self.watch.stage("tabulating the material");
        let ink = DirectionalInk::new(ink)?;
        let table = Table::new(&ink, mitsuba::POINTS)?;
        let about = self.description();
        out.add("ink-spectral.bsdf", table.spectral(&about), "material for Mitsuba 3, spectral variants");
        out.add("scene-spectral.xml", mitsuba::scene("ink-spectral.bsdf", &study.title), "a scene with it");
        match table.rgb(&about) {
            Ok(rgb) => {
                out.add("ink-rgb.bsdf", rgb.bytes, "material for Mitsuba 3, RGB variants");
                out.add("scene-rgb.xml", mitsuba::scene("ink-rgb.bsdf", &study.title), "a scene with it");
                out.remarks.push(format!(
                    "ink-rgb.bsdf: {:.1} % of its cells lie outside sRGB; their negative channels are 0",
                    100.0 * rgb.clipped
                ));
            }
            Err(reason) => out.remarks.push(format!("no ink-rgb.bsdf: {reason}")),
        }
        out.add(
            "specular.csv",
            samples::specular(&ink)?,
            "mirror part, left out of the material, and albedo",
        );
        out.add(
            "brdf-samples.csv",
            samples::brdf(&ink)?,
            "BRDF of the ink on its paper at chosen directions",
        );
        Ok(())
    }

    fn description(&self) -> String {
        let study = self.study();
        format!(
            "{}: ink on paper, simulated by {} (study {}, wave {}). Diffuse part only: the mirror reflection is a delta, see specular.csv.",
            study.title,
            program(),
            study.key(),
            study.wave.name()
        )
    }

    fn manifest(&self) -> Manifest<&Study> {
        summarise(self.study(), &self.stored.collected, &self.stored.seen)
    }

    /// Spectra on a grid of 10 nm, with the colours from the study's own wavelengths.
    fn print(&self, format: &'static str) -> Result<Print, ExportError> {
        self.ink(format)?;
        let (study, manifest) = (self.study(), self.manifest());
        let grid = uniform_grid(&study.wavelengths_nm);
        if grid.len() < 2 || study.wavelengths_nm.len() < 2 {
            return Err(ExportError::TooFewWavelengths { format });
        }
        let colour = |name: &str| manifest.colours.iter().find(|c| c.conditions == name).map(|c| c.colour);
        let spectrum = |geometry, values: Option<Vec<Estimate>>, name| {
            let values = resample(&study.wavelengths_nm, &values?, &grid);
            Some(PrintSpectrum { geometry, values, colour: colour(name) })
        };
        // the ink on its paper stands beside the layer at the normal alone
        let normal = || manifest.spectra.iter().filter(|row| row.polar_deg == 0.0);
        let lit = normal().map(|row| row.lit_at_45).collect();
        let natural = normal().map(|row| row.natural_light).collect();
        let spectra = [
            spectrum(Geometry::LitAt45, lit, LIT_AT_45),
            spectrum(Geometry::NaturalLight, natural, NATURAL_LIGHT),
        ];
        Ok(Print {
            title: study.title.clone(),
            study_hash: study.key().to_string(),
            program: program(),
            created: self.request.created.clone(),
            spectra: spectra.into_iter().flatten().collect(),
            wavelengths_nm: grid,
        })
    }

    fn cgats(&self, out: &mut Exported) -> Result<(), ExportError> {
        let print = self.print("cgats")?;
        let text = |dialect| cgats::cgats(&print, dialect);
        out.add("spectra.cgats", text(cgats::Dialect::Standard), "spectra of the print with Lab, CGATS.17");
        out.add("spectra.sp", text(cgats::Dialect::Argyll), "the same for ArgyllCMS");
        Ok(())
    }

    fn npz(&self, out: &mut Exported) -> Result<(), ExportError> {
        let realisations = &self.stored.collected.realisations;
        let records: Vec<&PointRecord> =
            realisations.iter().flat_map(|r| r.points.iter().flatten()).collect();
        out.add("far-fields.npz", npz::far_fields(&records)?, "all propagating orders of all solves");
        Ok(())
    }

    fn vti(&self, out: &mut Exported) -> Result<(), ExportError> {
        let study = self.study();
        self.watch.stage("packing realisation 1 again");
        let packing = pack_realisation(study, 0, self.watch)?;
        let names: Vec<&str> = study.pigments.iter().map(|p| p.name.as_str()).collect();
        let asked = self.request.near_field.map(|light| light.wavelength_nm);
        let w = asked.map_or(Ok(study.wavelengths_nm.len() / 2), |nm| self.wavelength(nm))?;
        let image = Voxels::of(&packing).image(
            &names,
            &study.media(1e-3 * study.wavelengths_nm[w]),
            study.wavelengths_nm[w],
        );
        out.add(
            "contrast.vti",
            image.vti(),
            "η² less that of the binder, and every pigment's share; lengths in µm",
        );
        if let Some(light) = self.request.near_field {
            if study.wave.is_vector() {
                return Err(ExportError::VectorNearField { wave: study.wave.name() });
            }
            self.watch.stage("solving for the near field");
            let incidence = Incidence {
                wavelength_um: 1e-3 * study.wavelengths_nm[w],
                polar_deg: light.polar_deg,
                azimuth_deg: study.angles.azimuth_deg,
                from: Side::Incident,
            };
            let coverage = Arc::new(Coverage::new(
                &Scene::from_packing(&packing),
                self.stored.collected.resolved.resolution,
            )?);
            let problem = Problem::new(
                &coverage,
                &study.media(1e-3 * study.wavelengths_nm[w]),
                &incidence,
                Mean::default(),
            )?;
            let solution = study.solver.build().solve(&problem, study.goal, &mut Stopper(self.watch))?;
            let image = near_field::image(&problem, &solution.field);
            out.add("near-field.vti", image.vti(), "the wave inside the first packing; lengths in µm");
        }
        Ok(())
    }

    fn viewer(&self, out: &mut Exported) -> Result<(), ExportError> {
        let study = self.study();
        self.watch.stage("packing realisation 1 again");
        let packing = pack_realisation(study, 0, self.watch)?;
        let names: Vec<&str> = study.pigments.iter().map(|p| p.name.as_str()).collect();
        out.add(
            "packing.html",
            viewer::page(&packing, &study.title, &names),
            "the first packing, to turn and to cut",
        );
        Ok(())
    }

    fn wavelength(&self, nm: f64) -> Result<usize, ExportError> {
        let all = &self.study().wavelengths_nm;
        let missing = || {
            let allowed = all.iter().map(f64::to_string).collect::<Vec<_>>().join(", ");
            ExportError::Wavelength { found: nm, allowed }
        };
        all.iter().position(|known| (known - nm).abs() < 1e-6).ok_or_else(missing)
    }

    /// The tables of the run beside what was exported, described together.
    fn provenance(&self, out: &mut Exported) -> Result<(), ExportError> {
        let manifest = self.manifest();
        let amplitude_error = manifest.certainty.amplitude_error_estimate;
        let bdfs = tables::distributions(self.stored.seen.bdfs.iter(), amplitude_error)?;
        out.add(STUDY, serde_json::to_vec_pretty(self.study())?, "the study with every default filled in");
        out.add("results.json", serde_json::to_vec_pretty(&manifest)?, "all numbers with their errors");
        out.add("spectra.csv", tables::spectra(&manifest.spectra)?, "spectra of the layer and of the print");
        out.add("bdf.csv", bdfs, "distributions of the layer alone, order by order");
        let run = Run {
            title: self.study().title.clone(),
            study_hash: self.study().key().to_string(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            created: self.request.created.clone(),
        };
        let [crate_, package] =
            [provenance::ro_crate(&run, &out.files), provenance::data_package(&run, &out.files)];
        out.add("ro-crate-metadata.json", serde_json::to_vec_pretty(&crate_)?, "RO-Crate");
        out.add("datapackage.json", serde_json::to_vec_pretty(&package)?, "Data Package");
        Ok(())
    }
}
