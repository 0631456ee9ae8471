//! What is published of a composed layer beside what every print has.

use crate::appearance::colour::Colour;
use crate::evaluate::published::{ErrorParts, NamedNumber, NumberNote, PublishedRow};
use crate::evaluate::quantities::{ComposedNumbers, Lab, LayerNumbers, MediumNumbers};
use crate::input::study::Composed;
use serde::Serialize;

/// A layer at one wavelength. `null` is a number that cannot be
/// ([`super::Manifest::withheld`] says why).
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
    /// The colour on the paper under natural light, with the bars of its L*, a*, b* as if they were
    /// independent.
    #[serde(skip)]
    pub colour: Option<Colour>,
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
/// determine it ([`super::Manifest::withheld`] says why).
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

/// What a composed layer has beside the numbers of every print.
#[derive(Clone, Debug, Serialize)]
pub struct SlabNotes<'a> {
    /// How it was composed.
    pub composed: &'a Composed,
    /// The medium at every wavelength.
    pub medium: Vec<MediumRow>,
    /// Where light at 0° goes, of each requested thickness.
    pub distributions: Vec<DistributionRow>,
    /// What every layer of a stack absorbs; none of one layer.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub absorbed: Vec<AbsorbedRow>,
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
    /// Jackknife replicates of all numbers by name, before any is withheld: \[portion of whole
    /// slabs with more than one realisation\]. Their variances add up to the squares of
    /// [`ErrorParts::chance`]; not written to files.
    #[serde(skip)]
    pub replicates: Vec<ComposedNumbers<Vec<f64>>>,
    /// Complete realisations of the slab that has fewest of them.
    #[serde(skip)]
    pub realisations: usize,
}

/// Variances of L*, a*, b* from their bars, as if these were independent.
pub fn independent(lab: Lab<ErrorParts>) -> [[f64; 3]; 3] {
    let mut covariance = [[0.0; 3]; 3];
    (0..3).for_each(|i| covariance[i][i] = lab[i].standard_error.powi(2));
    covariance
}
