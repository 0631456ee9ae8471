//! The numbers of a composed layer as they are published.

use super::quantities::{Lab, LayerNumbers, MediumNumbers};
use crate::evaluate::manifest::{Count, Provenance};
use crate::evaluate::printed::Prints;
use crate::evaluate::published::{ErrorParts, NamedNumber, NumberNote, PublishedRow, Withheld};
use crate::input::study::{Composed, Study};
use serde::Serialize;

/// A layer at one wavelength. `null` is a number that cannot be
/// ([`ComposedManifest::withheld`] says why).
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ComposedRow {
    /// Thickness of the layer, µm.
    pub thickness_um: f64,
    /// Vacuum wavelength, nm.
    pub wavelength_nm: f64,
    /// Its numbers.
    #[serde(flatten)]
    pub layer: LayerNumbers<Option<ErrorParts>>,
}

impl PublishedRow for ComposedRow {
    const PLACE: &'static [&'static str] = &["thickness_um", "wavelength_nm"];

    fn names() -> Vec<&'static str> {
        LayerNumbers::<Option<ErrorParts>>::names()
    }

    fn place(&self) -> Vec<f64> {
        vec![self.thickness_um, self.wavelength_nm]
    }

    fn wavelength_nm(&self) -> f64 {
        self.wavelength_nm
    }

    fn numbers(&self) -> Vec<NamedNumber> {
        self.layer.named()
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
    pub natural_light: Option<Lab<ErrorParts>>,
    /// On the paper at 45:0.
    pub lit_at_45: Option<Lab<ErrorParts>>,
    /// At 45:0 over black.
    pub over_black: Option<Lab<ErrorParts>>,
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
    /// Its numbers.
    #[serde(flatten)]
    pub medium: MediumNumbers<Option<ErrorParts>>,
}

impl PublishedRow for MediumRow {
    const PLACE: &'static [&'static str] = &["wavelength_nm"];

    fn names() -> Vec<&'static str> {
        MediumNumbers::<Option<ErrorParts>>::names()
    }

    fn place(&self) -> Vec<f64> {
        vec![self.wavelength_nm]
    }

    fn wavelength_nm(&self) -> f64 {
        self.wavelength_nm
    }

    fn numbers(&self) -> Vec<NamedNumber> {
        self.medium.named()
    }
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

/// What one layer of a stack absorbs at one wavelength.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AbsorbedRow {
    /// Thickness of the varied layer, or of the stack, µm.
    pub thickness_um: f64,
    /// Vacuum wavelength, nm.
    pub wavelength_nm: f64,
    /// Name of the layer.
    pub layer: String,
    /// Share of light at 0° that it absorbs, without paper.
    pub absorptance_normal: ErrorParts,
}

/// All numbers of a composed layer: the file `results.json`.
#[derive(Clone, Debug, Serialize)]
pub struct ComposedManifest<'a> {
    /// Where the numbers come from.
    #[serde(flatten)]
    pub origin: Provenance,
    /// How it was composed.
    pub composed: &'a Composed,
    /// Solves requested and finished.
    pub solves: Count,
    /// Solves without a result, and packings without room.
    pub failures: Vec<String>,
    /// One row for each requested thickness and wavelength.
    pub spectra: Vec<ComposedRow>,
    /// Colours of each requested thickness.
    pub colours: Vec<ComposedColours>,
    /// Why there are none.
    pub no_colour: Option<String>,
    /// Prints in dots, and under the lights of instruments on paper that fluoresces.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub prints: Option<Prints>,
    /// The medium at every wavelength.
    pub medium: Vec<MediumRow>,
    /// Where light at 0° goes, of each requested thickness.
    pub distributions: Vec<DistributionRow>,
    /// What every layer of a stack absorbs; none of one layer.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub absorbed: Vec<AbsorbedRow>,
    /// Weighted numbers that the study asks for, of each requested thickness.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub numbers: Vec<NumberNote>,
    /// Numbers that were withheld because they are impossible or not determined.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub withheld: Vec<Withheld>,
    /// Rows of whole numbers of slabs.
    pub curve: Vec<ComposedRow>,
    /// Their colours.
    pub curve_colours: Vec<ComposedColours>,
    /// Their weighted numbers.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub curve_numbers: Vec<NumberNote>,
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
