//! `inkwave export`: from a finished study to files in the formats asked for.

use super::finished::{FinishedStudy, PackedLayer};
use super::mitsuba::{self, MaterialTable};
use super::print::Print;
use super::provenance::{self, Described, Run, STUDY};
use super::request::{ExportError, ExportResult, Format, NearField, Request};
use super::spectra::{self, Dialect};
use super::voxels::{self, Voxels};
use super::{grains, near_field, ramp, samples};
use crate::evaluate::directional::DirectionalPrint;
use crate::evaluate::summary::program;
use crate::ink::{Method, Packing};
use crate::input::study::Study;
use crate::report::packing::grains_csv;
use crate::run::point::{Stopper, pack_realisation};
use crate::run::watch::RunWatch;
use crate::wave::{Coverage, Incidence, Mean, Problem, Scene, Side};
use ndarray_npy::{WriteNpyExt, WriteNpzError};
use std::sync::Arc;

/// The exported files, and remarks on them.
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
/// A format that shows one packing of a layer that has none of its own; a study that does not carry
/// what a format needs.
pub fn export(
    finished: &dyn FinishedStudy,
    request: &Request,
    watch: &dyn RunWatch,
) -> ExportResult<Exported> {
    let exporter = Exporter { finished, thickness_um: thickness(finished, request)?, request, watch };
    let near_field = request.near_field.map(|light| exporter.near_field_fits(light)).transpose()?;
    let mut formats = request.formats.clone();
    let mut out = Exported::default();
    formats.extend(near_field.map(|()| Format::Vti));
    for format in formats {
        match format {
            Format::Mitsuba => exporter.mitsuba(&mut out)?,
            Format::Cxf => out.cxf(&exporter.print("cxf")?)?,
            Format::Cgats => {
                out.cgats(&exporter.print("cgats")?);
                if let Some(prints) = finished.prints()? {
                    for set in ramp::sets(finished.study(), &prints, &request.created)? {
                        out.add(&set.name, set.text, &set.about);
                    }
                }
            }
            Format::Npz => out.files.extend(finished.far_fields()?),
            Format::Vti => exporter.vti(&mut out)?,
            Format::Positions => exporter.positions(&mut out)?,
            Format::Labels => exporter.labels(&mut out)?,
            Format::Viewer => exporter.viewer(&mut out)?,
            Format::Crate => exporter.provenance(&mut out)?,
        }
    }
    Ok(out)
}

/// The thickness requested, or the study's first one, µm.
fn thickness(finished: &dyn FinishedStudy, request: &Request) -> ExportResult<f64> {
    let all = finished.thicknesses_um();
    let requested = request.thickness_um.or_else(|| all.first().copied()).unwrap_or(f64::NAN);
    if all.contains(&requested) {
        return Ok(requested);
    }
    let allowed = all.iter().map(f64::to_string).collect::<Vec<_>>().join(", ");
    Err(ExportError::thickness(requested, &allowed))
}

/// Materials of renderers lie in air.
fn in_air(study: &Study) -> ExportResult {
    match study.layer.index_in {
        1.0 => Ok(()),
        index => Err(ExportError::Refused(format!(
            "layer.index_in is {index}; a renderer's material lies in air: allowed is 1"
        ))),
    }
}

impl Exported {
    fn add(&mut self, name: &str, bytes: impl Into<Vec<u8>>, about: &str) {
        self.files.push(Described::new(name, bytes, about));
    }

    /// The print as a material for renderers, with tables to check it.
    fn material(&mut self, print: &dyn DirectionalPrint, study: &Study) -> ExportResult {
        let table = MaterialTable::new(print);
        let about = description(study);
        self.add("ink-spectral.bsdf", table.spectral(&about), "material for Mitsuba 3, spectral variants");
        self.add("scene-spectral.xml", mitsuba::scene("ink-spectral.bsdf", &study.title), "a scene with it");
        match table.rgb(&about) {
            Ok((bytes, clipped)) => {
                self.add("ink-rgb.bsdf", bytes, "material for Mitsuba 3, RGB variants");
                self.add("scene-rgb.xml", mitsuba::scene("ink-rgb.bsdf", &study.title), "a scene with it");
                self.remarks.push(format!(
                    "ink-rgb.bsdf: {:.1} % of its cells lie outside sRGB; their negative channels are 0",
                    100.0 * clipped
                ));
            }
            Err(reason) => self.remarks.push(format!("no ink-rgb.bsdf: {reason}")),
        }
        let mirrored = samples::specular(print)?;
        let chosen = samples::brdf(print)?;
        self.add("specular.csv", mirrored, "mirror part, left out of the material, and albedo");
        self.add("brdf-samples.csv", chosen, "BRDF of the ink on its paper at chosen directions");
        Ok(())
    }

    /// Spectra as CxF3.
    fn cxf(&mut self, print: &Print) -> ExportResult {
        Ok(self.add("spectra.cxf", spectra::cxf(print)?, "spectra of the print with Lab, CxF3"))
    }

    /// Spectra in both dialects of CGATS.
    fn cgats(&mut self, print: &Print) {
        let text = |dialect| spectra::cgats(print, dialect);
        self.add("spectra.cgats", text(Dialect::Standard), "spectra of the print with Lab, CGATS.17");
        self.add("spectra.sp", text(Dialect::Argyll), "spectra of the print with Lab for ArgyllCMS");
    }

    /// The study, and all files described together.
    fn describe(&mut self, study: &Study, created: &str) -> ExportResult {
        self.add(STUDY, serde_json::to_vec_pretty(study)?, "the study with every default filled in");
        let title = study.title.clone();
        let study_hash = study.key().to_string();
        let run = Run { title, study_hash, created: created.to_owned() };
        let research_crate = provenance::ro_crate(&run, &self.files);
        let package = provenance::data_package(&run, &self.files);
        self.add("ro-crate-metadata.json", serde_json::to_vec_pretty(&research_crate)?, "RO-Crate");
        self.add("datapackage.json", serde_json::to_vec_pretty(&package)?, "Data Package");
        Ok(())
    }
}

fn description(study: &Study) -> String {
    format!(
        "{}: ink on paper, simulated by {} (study {}, wave {}). Diffuse part only: the mirror reflection is a delta, see specular.csv.",
        study.title,
        program(),
        study.key(),
        study.wave.name()
    )
}

struct Exporter<'a> {
    finished: &'a dyn FinishedStudy,
    /// Thickness of the layer that is exported, µm.
    thickness_um: f64,
    request: &'a Request,
    watch: &'a dyn RunWatch,
}

impl Exporter<'_> {
    fn study(&self) -> &Study {
        self.finished.study()
    }

    fn mitsuba(&self, out: &mut Exported) -> ExportResult {
        in_air(self.study())?;
        self.watch.stage("tabulating the material");
        let print = self.finished.directions(self.thickness_um)?;
        out.material(print.as_ref(), self.study())?;
        if self.finished.is_isotropic() {
            let um = self.thickness_um;
            out.remarks.push(format!("the material is the layer of {um} µm, a mean over the azimuth"));
        }
        Ok(())
    }

    /// The first packing, for a format that shows it.
    fn packing(&self, format: &str) -> ExportResult<Packing> {
        let PackedLayer { study, .. } = self.finished.packed(format)?;
        self.watch.stage("packing realisation 1 again");
        Ok(pack_realisation(study, 0, self.watch)?)
    }

    /// Spectra on a grid of 10 nm with their colours.
    fn print(&self, format: &str) -> ExportResult<Print> {
        self.finished.print(self.thickness_um, format, &self.request.created)
    }

    fn vti(&self, out: &mut Exported) -> ExportResult {
        let study = self.study();
        let packing = self.packing("vti")?;
        let names = study.material_names();
        let requested_nm = self.request.near_field.map(|light| light.wavelength_nm);
        let w = requested_nm.map_or(Ok(study.wavelengths_nm.len() / 2), |nm| self.wavelength(nm))?;
        let wavelength_nm = study.wavelengths_nm[w];
        let image =
            Voxels::of(&packing).image(&names, &study.mean_media(1e-3 * wavelength_nm), wavelength_nm);
        let binder = if study.stack.is_empty() { "the binder" } else { "the first layer's binder" };
        let about = format!("η² less that of {binder}, and every pigment's share; lengths in µm");
        out.add("contrast.vti", image.vti(), &about);
        match self.request.near_field {
            Some(light) => {
                let layer = self.finished.packed("near field")?;
                self.near_field(layer, &packing, NearField { wavelength_nm, ..light }, out)
            }
            None => Ok(()),
        }
    }

    /// Refuses a near field that cannot be solved, before anything is made.
    fn near_field_fits(&self, light: NearField) -> ExportResult {
        self.finished.packed("near field")?;
        if self.study().wave.is_vector() {
            return Err(ExportError::Refused(format!(
                "near field: light.wave is {}; allowed is \"scalar\": Maxwell's equations are solved for moments of E, which no volume shows yet",
                self.study().wave.name()
            )));
        }
        self.wavelength(light.wavelength_nm).map(drop)
    }

    /// A solve of the packing for one of the study's wavelengths.
    fn near_field(
        &self,
        layer: PackedLayer,
        packing: &Packing,
        light: NearField,
        out: &mut Exported,
    ) -> ExportResult {
        let PackedLayer { study, resolution } = layer;
        self.watch.stage("solving for the near field");
        let wavelength_um = 1e-3 * light.wavelength_nm;
        let azimuth_deg = study.angles.azimuth_deg;
        let polar_deg = light.polar_deg;
        let incidence = Incidence { wavelength_um, polar_deg, azimuth_deg, from: Side::Incident };
        let coverage = Arc::new(Coverage::new(&Scene::from_packing(packing), resolution)?);
        let media = study.media(wavelength_um);
        let problem = Problem::new(&coverage, &media, &incidence, Mean::default())?;
        let solution = study.solver.build().solve(&problem, study.goal, &mut Stopper(self.watch))?;
        let image = near_field::image(&problem, &solution.field);
        out.add("near-field.vti", image.vti(), "the wave inside the first packing; lengths in µm");
        Ok(())
    }

    fn positions(&self, out: &mut Exported) -> ExportResult {
        let packing = self.packing("positions")?;
        if packing.method() == Method::Voxels {
            out.remarks
                .push("no positions: voxels have no grains to place; `--to labels` writes them".into());
            return Ok(());
        }
        if packing.grains().iter().any(|grain| grain.solid.is_some()) {
            let reason = "no positions: some grains are bodies, whose enclosing spheres are no grains";
            out.remarks.push(format!("{reason}; `--to labels` and `--to viewer` write bodies"));
            return Ok(());
        }
        out.add("grains.csv", grains_csv(&packing)?, "spheres of the first packing, lengths in µm");
        out.add("grains.dump", grains::dump(&packing), "the same as a LAMMPS dump, radii and lengths in µm");
        out.add("grains.xyz", grains::xyz(&packing), "the same as extended XYZ, radii and lengths in µm");
        out.remarks.extend(self.faces(&packing));
        Ok(())
    }

    /// Where the layers of a stack meet; `None` of one layer.
    fn faces(&self, packing: &Packing) -> Option<String> {
        let mut depth_um = 0.0;
        let ends = self.study().stack.iter().zip(packing.layers_um()).map(|(layer, um)| {
            depth_um += um;
            format!("{} to z = {depth_um:.4} µm in a binder of {}", layer.name, layer.binder.source)
        });
        let ends: Vec<String> = ends.collect();
        (!ends.is_empty()).then(|| {
            format!("layers: {}; layer.microstructure takes the grains of one layer", ends.join(", "))
        })
    }

    /// Voxels that `layer.microstructure` reads; those of a study that has read some are the same.
    fn labels(&self, out: &mut Exported) -> ExportResult {
        let packing = self.packing("labels")?;
        let labels = voxels::labels(&packing, self.study().packing.voxels.first().map(|cut| cut.count));
        let mut bytes = Vec::new();
        labels.write_npy(&mut bytes).map_err(WriteNpzError::from)?;
        out.add("labels.npy", bytes, "labels of the first packing's voxels, axes x, y, z: 0 is the binder");
        if let Some(faces) = self.faces(&packing) {
            out.remarks.push(format!("labels.npy: 0 is each layer's own binder; {faces}"));
            return Ok(());
        }
        let size = voxels::size_um(&packing);
        let edges = [0, 1, 2].map(|i| (1e9 * size[i] / labels.shape()[i] as f64).round() / 1e6);
        let names = self.study().material_names().into_iter().enumerate();
        let names = names.map(|(k, name)| format!("{} = {name:?}", k + 1)).collect::<Vec<_>>().join(", ");
        out.remarks.push(format!(
            "labels.npy: layer.microstructure = {{ voxels = \"labels.npy\", voxel_nm = {edges:?}, labels = {{ {names} }} }}"
        ));
        Ok(())
    }

    fn viewer(&self, out: &mut Exported) -> ExportResult {
        let study = self.study();
        let packing = self.packing("viewer")?;
        let page = grains::page(&packing, &study.title, &study.material_names());
        Ok(out.add("packing.html", page, "interactive view of the first packing"))
    }

    fn wavelength(&self, nm: f64) -> ExportResult<usize> {
        let all = &self.study().wavelengths_nm;
        if let Some(w) = all.iter().position(|known| (known - nm).abs() < 1e-6) {
            return Ok(w);
        }
        let allowed = all.iter().map(f64::to_string).collect::<Vec<_>>().join(", ");
        let allowed = format!("allowed is one of the study's wavelengths, {allowed} nm");
        Err(ExportError::Refused(format!("near field: found {nm} nm; {allowed}")))
    }

    /// Adds numbers and tables of the run, and describes all files together.
    fn provenance(&self, out: &mut Exported) -> ExportResult {
        out.files.extend(self.finished.results()?);
        out.describe(self.study(), &self.request.created)
    }
}
