//! The numbers of a composed layer as they are published.

use crate::evaluate::manifest::{Count, Status, Withheld};
use crate::input::study::{Composed, Study};
use crate::numerics::estimate::Estimate;
use serde::Serialize;
use std::collections::BTreeSet;

/// A number with its standard error and what that is made of, all in the number's unit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct ErrorParts {
    /// The number.
    pub value: f64,
    /// One standard error: the root of the sum of the squares of all that follow.
    pub standard_error: f64,
    /// Jackknife over the realisations of all portions.
    pub chance: f64,
    /// The error of composing incoherently: what slabs of half the thickness change, beyond chance.
    pub model: f64,
    /// What the grid's error of R changes.
    pub grid: f64,
    /// What fringes between the directions that are solved may be: the change when one of these is
    /// left out.
    pub directions: f64,
    /// Of colours, what the spectrum may be between and beyond the wavelengths.
    pub wavelengths: f64,
}

impl ErrorParts {
    /// With the sum of its parts.
    pub fn summed(self) -> Self {
        let parts = [self.chance, self.model, self.grid, self.directions, self.wavelengths];
        Self { standard_error: parts.into_iter().fold(0.0, f64::hypot), ..self }
    }

    /// With a further error of the model.
    pub fn with_model(self, further: f64) -> Self {
        let standard_error = self.standard_error.hypot(further);
        Self { standard_error, model: self.model.hypot(further), ..self }
    }

    /// As a value with its standard error.
    pub fn estimate(&self) -> Estimate {
        Estimate { value: self.value, standard_error: Some(self.standard_error) }
    }
}

/// A layer at one wavelength; R and T are shares of the incident light. `null` is a number that
/// cannot be ([`ComposedManifest::withheld`] says why).
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ComposedRow {
    /// Thickness of the layer, µm.
    pub thickness_um: f64,
    /// Vacuum wavelength, nm.
    pub wavelength_nm: f64,
    /// R of light at 0°.
    pub reflectance_normal: Option<ErrorParts>,
    /// T of light at 0°.
    pub transmittance_normal: Option<ErrorParts>,
    /// R of light at 45°.
    pub reflectance_45: Option<ErrorParts>,
    /// T of light at 45°.
    pub transmittance_45: Option<ErrorParts>,
    /// R of diffuse light.
    pub reflectance_diffuse: Option<ErrorParts>,
    /// T of diffuse light.
    pub transmittance_diffuse: Option<ErrorParts>,
    /// Coherent transmittance at 0°, |⟨t⟩|²: what goes straight on, unscattered. (⟨|t|²⟩ of one
    /// order, as single cells have it, depends on the size of the cell: a composed layer has none.)
    pub coherent_transmittance: Option<ErrorParts>,
    /// Share of light at 0° that is mirrored.
    pub mirrored: Option<ErrorParts>,
    /// On the paper, under a uniform sky, seen along the normal; a perfect white: 1.
    pub natural_light: Option<ErrorParts>,
    /// On the paper, lit at 45° and seen along the normal: π × BRDF.
    pub lit_at_45: Option<ErrorParts>,
    /// At 45:0 over black.
    pub over_black: Option<ErrorParts>,
    /// At 45:0 over white of albedo 0.8.
    pub over_white: Option<ErrorParts>,
}

impl ComposedRow {
    /// Names of its numbers, in their order.
    pub const NAMES: [&'static str; 12] = [
        "reflectance_normal",
        "transmittance_normal",
        "reflectance_45",
        "transmittance_45",
        "reflectance_diffuse",
        "transmittance_diffuse",
        "coherent_transmittance",
        "mirrored",
        "natural_light",
        "lit_at_45",
        "over_black",
        "over_white",
    ];

    /// Its numbers, as [`ComposedRow::NAMES`] has them.
    pub fn numbers(&self) -> [Option<ErrorParts>; 12] {
        self.clone().numbers_mut().map(|number| *number)
    }

    /// Its numbers, to withhold some.
    pub fn numbers_mut(&mut self) -> [&mut Option<ErrorParts>; 12] {
        [
            &mut self.reflectance_normal,
            &mut self.transmittance_normal,
            &mut self.reflectance_45,
            &mut self.transmittance_45,
            &mut self.reflectance_diffuse,
            &mut self.transmittance_diffuse,
            &mut self.coherent_transmittance,
            &mut self.mirrored,
            &mut self.natural_light,
            &mut self.lit_at_45,
            &mut self.over_black,
            &mut self.over_white,
        ]
    }
}

/// Colours of a layer; L*, a*, b* under D65 for the CIE 1931 observer. `null` is a colour that
/// cannot be, or that follows from a withheld number.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ComposedColours {
    /// Thickness of the layer, µm.
    pub thickness_um: f64,
    /// As screens show it on the paper under natural light, `#rrggbb`.
    pub hex: Option<String>,
    /// On the paper under natural light.
    pub natural_light: Option<[ErrorParts; 3]>,
    /// On the paper at 45:0.
    pub lit_at_45: Option<[ErrorParts; 3]>,
    /// At 45:0 over black.
    pub over_black: Option<[ErrorParts; 3]>,
    /// Y over black by Y over white, at 45:0 (ISO 6504-3).
    pub contrast_ratio: Option<ErrorParts>,
}

/// What the packed medium is to light of one wavelength; `null` where these realisations do not
/// determine it ([`ComposedManifest::withheld`] says why).
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MediumRow {
    /// Vacuum wavelength, nm.
    pub wavelength_nm: f64,
    /// Index of the half-spaces that inner slabs are solved between.
    pub embedding_index: f64,
    /// Index of the mean wave, from its phase behind an inner slab.
    pub effective_index: Option<ErrorParts>,
    /// Mean free path of coherent light, µm.
    pub coherent_path_um: Option<ErrorParts>,
    /// k_s of the medium with the slab's coherent transmittance, R̄ and Ā, 1/µm.
    pub scattering_per_um: Option<ErrorParts>,
    /// k_a of that medium, 1/µm.
    pub absorption_per_um: Option<ErrorParts>,
    /// g of that medium.
    pub asymmetry: Option<ErrorParts>,
    /// Transport mean free path 1/(k_s (1 − g)), µm.
    pub transport_path_um: Option<ErrorParts>,
    /// Kubelka and Munk's K of a thick layer without surfaces, 1/µm.
    pub kubelka_munk_absorption_per_um: Option<ErrorParts>,
    /// Their S, 1/µm.
    pub kubelka_munk_scattering_per_um: Option<ErrorParts>,
}

/// Light at 0° that leaves a layer in one direction. The layer looks alike from all azimuths.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DistributionRow {
    /// Thickness of the layer, µm.
    pub thickness_um: f64,
    /// Vacuum wavelength, nm.
    pub wavelength_nm: f64,
    /// Whether it comes back; else it has passed the layer.
    pub reflected: bool,
    /// Angle from the normal in the medium that it leaves to, degrees.
    pub polar_out_deg: f64,
    /// Projected solid angle that the direction stands for, sr: times the density it adds up to R
    /// or T less the beam's part.
    pub projected_sr: f64,
    /// BRDF or BTDF of the layer alone, 1/sr, without the mirrored and the straight beam.
    pub bdf_per_sr: ErrorParts,
}

/// Fluxes at one depth, as shares of the incident light at 0°.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DepthRow {
    /// Depth below the front surface, µm; 0 and the thickness are outside the surfaces.
    pub depth_um: f64,
    /// Towards the exit side.
    pub down: f64,
    /// Back.
    pub up: f64,
}

/// All numbers of a composed layer: the file `results.json`.
#[derive(Clone, Debug, Serialize)]
pub struct ComposedManifest<'a> {
    /// Whether every solve is there.
    pub status: Status,
    /// Title, for people.
    pub title: String,
    /// Content hash of the study.
    pub study_hash: String,
    /// Program and version.
    pub program: String,
    /// Builds that made the records.
    pub builds: BTreeSet<String>,
    /// Version of the method.
    pub method_version: u32,
    /// Seed of the packings.
    pub seed: u64,
    /// How it was composed.
    pub composed: &'a Composed,
    /// Solves asked for and finished.
    pub solves: Count,
    /// Solves without a result, and packings without room.
    pub failures: Vec<String>,
    /// One row for each thickness asked for and wavelength.
    pub spectra: Vec<ComposedRow>,
    /// Colours of each thickness asked for.
    pub colours: Vec<ComposedColours>,
    /// Why there are none.
    pub no_colour: Option<String>,
    /// The medium at every wavelength.
    pub medium: Vec<MediumRow>,
    /// Where light at 0° goes, of each thickness asked for.
    pub distributions: Vec<DistributionRow>,
    /// Numbers that were withheld because they are impossible or not determined.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub withheld: Vec<Withheld>,
    /// Rows of whole numbers of slabs.
    pub curve: Vec<ComposedRow>,
    /// Their colours.
    pub curve_colours: Vec<ComposedColours>,
    /// Thickness at which the contrast ratio reaches 0.98, µm.
    pub hiding_thickness_um: Option<ErrorParts>,
    /// Area that a litre of the dry layer hides, m².
    pub spreading_rate_m2_per_l: Option<ErrorParts>,
    /// Why neither is there.
    pub no_hiding: Option<String>,
    /// What to change, where slabs are thinner than the mean free path of coherent light.
    pub remarks: Vec<String>,
    /// Fluxes in the first thickness, on the paper, at one wavelength.
    pub depth: Vec<DepthRow>,
    /// That wavelength, nm.
    pub depth_nm: f64,
    /// Seconds that the solves took, added up.
    pub solve_seconds: f64,
    /// Processor seconds of the process that wrote this.
    pub process_seconds: Option<f64>,
    /// The study with every default filled in.
    pub study: &'a Study,
}
