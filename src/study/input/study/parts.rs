//! The layer with its materials, the paper, and what is requested: directions, accuracy and what
//! to compare with.

use crate::appearance::bare_paper::PaperGeometry;
use crate::appearance::fluorescence::Fluorescence;
use crate::appearance::paper::{Albedo, Coupling};
use crate::appearance::paper_series::LayerOptics;
use crate::appearance::viewing::Viewing;
use crate::ink::{Joint, PigmentGrains};
use crate::input::file::ContrastPart;
use crate::input::measured::{MeasuredCondition, MeasuredSpectrum};
use crate::material::mixing::MixingRule;
use crate::material::spectra::Spectrum;
use crate::wave::{Precision, Scheme};
use num_complex::Complex64;
use serde::{Deserialize, Serialize};

/// The periodic cell 0 ≤ z ≤ thickness and its surroundings.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Layer {
    /// Lateral periods, µm.
    pub period_um: [f64; 2],
    /// Thickness, µm.
    pub thickness_um: f64,
    /// Real index of the incident side.
    pub index_in: f64,
    /// Real index of the exit side.
    pub index_out: f64,
    /// The medium between the grains.
    pub binder: IndexSpectrum,
    /// Which part of the contrast scatters.
    pub contrast: ContrastPart,
}

/// One layer of a stack, in the order of the light.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct StackLayer {
    /// Name in reports.
    pub name: String,
    /// Mean thickness, µm.
    pub thickness_um: f64,
    /// Standard deviation of the thickness, µm; above 0 in one layer at most.
    pub thickness_std_um: f64,
    /// The medium between its grains.
    pub binder: IndexSpectrum,
    /// Number of its pigments with grains: those of the layers follow one another in
    /// [`Study::pigments`](super::Study::pigments), and their packing requests in
    /// [`PackingRequest::layers`](crate::ink::PackingRequest::layers).
    pub pigments: usize,
    /// How it meets the next layer; a wall at the last one.
    pub joint: Joint,
}

/// One kind of grain.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Pigment {
    /// Name in reports.
    pub name: String,
    /// Shape, sizes and volume fraction of its grains.
    pub grains: PigmentGrains,
    /// Its refractive index; that of the core where there are layers around it.
    pub material: IndexSpectrum,
    /// The index of its extraordinary ray, if it is birefringent; `material` is that of the
    /// ordinary one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub extraordinary: Option<IndexSpectrum>,
    /// Layers around the core, from the core outwards; their thicknesses are those of
    /// [`PigmentGrains::shell_nm`].
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub shell: Vec<IndexSpectrum>,
}

/// A pigment in the limit of vanishing grains: a homogeneous mixture with the binder.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Dissolved {
    /// Name in reports.
    pub name: String,
    /// Fraction of the layer's volume.
    pub volume_fraction: f64,
    /// The index at each wavelength.
    pub material: IndexSpectrum,
}

/// A material by its index n + iκ at every wavelength of the study.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct IndexSpectrum {
    /// Name in reports: a constant, a built-in spectrum, or the path of a table.
    pub source: String,
    /// The index at the study's wavelengths.
    pub index: Vec<Complex64>,
    /// The index at any wavelength in between.
    pub spectrum: Spectrum,
    /// Pigments dissolved in it: fractions of its volume, and indices.
    pub dissolved: Vec<(f64, Spectrum)>,
    /// How they are mixed.
    pub mixing: MixingRule,
}

impl IndexSpectrum {
    /// η at a vacuum wavelength within the study's range.
    pub fn index_at(&self, wavelength_um: f64) -> Complex64 {
        // the ends of the range are checked, and a spectrum is defined between its ends
        let of = |spectrum: &Spectrum| spectrum.index(wavelength_um).unwrap_or(Complex64::new(f64::NAN, 0.0));
        let own = of(&self.spectrum);
        if self.dissolved.is_empty() {
            return own;
        }
        let shares: Vec<_> = self.dissolved.iter().map(|(share, spectrum)| (*share, of(spectrum))).collect();
        self.mixing.mix(own, &shares)
    }
}

/// The Lambertian substrate.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Paper {
    /// Name in reports: the albedo, or the path of its table.
    pub source: String,
    /// Share of the light that the paper returns.
    pub albedo: Albedo,
    /// Contact between ink and paper.
    pub coupling: Coupling,
    /// The measurement of the bare paper that the albedo follows from.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub measured: Option<MeasuredPaper>,
    /// Its brightener.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fluorescence: Option<Fluorescence>,
    /// The dots that the layer is printed in, besides the solid.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dots: Option<Dots>,
}

/// A measurement of bare paper, and the albedo behind its surface.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MeasuredPaper {
    /// Directions of light and view.
    pub geometry: PaperGeometry,
    /// The instrument's light by ISO 13655, if it was chosen.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub condition: Option<MeasuredCondition>,
    /// \[wavelength in nm, factor, albedo\] rows.
    pub rows: Vec<[f64; 3]>,
}

/// The tints of a halftone print.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Dots {
    /// Nominal coverage of the layer in each tint; the rest is bare paper.
    pub nominal: Vec<f64>,
    /// Dots per cm.
    pub ruling_per_cm: f64,
    /// Length over which the paper spreads light, µm.
    pub spread_um: f64,
    /// Physical gain of a nominal coverage of a half.
    pub physical_gain: f64,
    /// Prints with further kinds of area than this study's layer and bare paper.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mixed: Option<MixedAreas>,
}

/// Kinds of area that bear layers of other runs, and the shares of all kinds in every print.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MixedAreas {
    /// Names of the inks, or of the areas where coverages are given for areas.
    pub names: Vec<String>,
    /// The layers of other runs, at the study's wavelengths.
    pub layers: Vec<LayerOptics>,
    /// One for each of [`Dots::nominal`].
    pub prints: Vec<MixedPrint>,
}

/// The shares of one print.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MixedPrint {
    /// Nominal coverage of every name.
    pub nominal: Vec<f64>,
    /// Shares with the physical gain: of this study's layer, then of the layers of other runs; the
    /// rest is bare paper.
    pub shares: Vec<f64>,
    /// Share of the light that the paper spreads over all areas alike.
    pub spread: f64,
}

/// Directions of the light.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Angles {
    /// Polar angles common to all realisations, degrees from the normal, below 90, increasing.
    pub exact_deg: Vec<f64>,
    /// Number of directions over the hemisphere of the incident side, one in each equal stratum of
    /// cos²θ; 0 if only single angles are requested.
    pub strata: usize,
    /// Number of directions over the hemisphere of the exit side; 0 if the layer is statistically
    /// the same from both sides.
    pub exit_strata: usize,
    /// Azimuth of the plane of incidence, degrees; that of a varied cell is added.
    pub azimuth_deg: f64,
    /// Largest angle of the picture's axes.
    pub picture_max_deg: f64,
}

impl Angles {
    /// Number of directions per wavelength.
    pub fn count(&self) -> usize {
        self.exact_deg.len() + self.strata + self.exit_strata
    }
}

/// The requested accuracy, or the grid.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum WantedResolution {
    /// Largest error of any order's amplitude.
    Accuracy {
        /// Largest error of a complex amplitude.
        amplitude: f64,
        /// Discretisation along z.
        scheme: Scheme,
        /// Whether longer waves may use coarser grids.
        per_wavelength: bool,
    },
    /// Points and planes per µm.
    Grid {
        /// Points along x and y, per µm.
        points_per_um: f64,
        /// Planes along z, per µm.
        planes_per_um: f64,
        /// Discretisation along z.
        scheme: Scheme,
    },
}

impl WantedResolution {
    /// The discretisation along z.
    pub fn scheme(&self) -> Scheme {
        match *self {
            Self::Accuracy { scheme, .. } | Self::Grid { scheme, .. } => scheme,
        }
    }

    /// Relative error of the contrast's Fourier coefficients that is negligible compared with that
    /// of the grid; a given grid may be arbitrarily fine.
    pub fn coverage_error(&self) -> f64 {
        if let Self::Accuracy { amplitude, .. } = *self {
            Precision::error_for(amplitude)
        } else {
            Precision::EXACT.error
        }
    }
}

/// What an ink maker compares the prediction with.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Judgement {
    /// Illuminant, observer and summation.
    pub viewing: Viewing,
    /// Target L*, a*, b* at 45:0.
    pub target_lab: Option<[f64; 3]>,
    /// A measured spectrum at 45:0.
    pub measured: Option<MeasuredSpectrum>,
    /// The light under which paper with a brightener was measured, by ISO 13655; none for that of
    /// the illuminant.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub condition: Option<MeasuredCondition>,
}
