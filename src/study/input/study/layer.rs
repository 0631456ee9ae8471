//! The layer with its materials, and the paper.

use super::composed::Composed;
use crate::appearance::paper::{Albedo, Coupling};
use crate::ink::PigmentGrains;
use crate::input::contrast::ContrastPart;
use crate::material::mixing::MixingRule;
use crate::material::spectra::Spectrum;
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
    /// How it is composed of slabs, where it is too thick to be solved at once.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub composed: Option<Composed>,
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
}
