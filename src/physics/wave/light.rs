//! The light: the incident plane wave, the wave equation and polarisation.

use super::Scheme;

/// Linear polarisation of a plane wave: s has E along s = ẑ × p̂, p has H along it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum Polarisation {
    /// E perpendicular to the plane of incidence.
    S,
    /// E in the plane of incidence.
    P,
}

impl Polarisation {
    /// Both polarisations, s first.
    pub const BOTH: [Polarisation; 2] = [Polarisation::S, Polarisation::P];
}

/// Which equation is solved, and for which light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum Wave {
    /// The scalar wave equation: like s light, without polarisation.
    #[default]
    Scalar,
    /// Maxwell's equations, E perpendicular to the plane of incidence.
    S,
    /// Maxwell's equations, E in the plane of incidence.
    P,
    /// Maxwell's equations, the mean of s and p efficiencies.
    Unpolarised,
}

impl Wave {
    /// Names in study files, in the order of the variants.
    pub const NAMES: [&'static str; 4] = ["scalar", "s", "p", "unpolarised"];

    /// Polarisations to solve; none for the scalar wave.
    pub fn polarisations(self) -> &'static [Polarisation] {
        match self {
            Wave::Scalar => &[],
            Wave::S => &Polarisation::BOTH[..1],
            Wave::P => &Polarisation::BOTH[1..],
            Wave::Unpolarised => &Polarisation::BOTH,
        }
    }

    /// Whether the wave obeys Maxwell's equations.
    pub fn is_vector(self) -> bool {
        self != Wave::Scalar
    }

    /// The light returned by paper: paper depolarises.
    pub fn returned(self) -> Wave {
        if self.is_vector() { Wave::Unpolarised } else { Wave::Scalar }
    }

    /// The scheme required by the wave: the vector wave has two Gauss planes per cell.
    pub fn scheme(self, scalar: Scheme) -> Scheme {
        if self.is_vector() { Scheme::Quadratic } else { scalar }
    }

    /// Name in study files.
    pub fn name(self) -> &'static str {
        Wave::NAMES[self as usize]
    }

    /// Short description for reports.
    pub fn in_words(self) -> &'static str {
        match self {
            Wave::Scalar => "scalar wave equation",
            Wave::S => "Maxwell's equations, s-polarised light",
            Wave::P => "Maxwell's equations, p-polarised light",
            Wave::Unpolarised => "Maxwell's equations, unpolarised light",
        }
    }
}

/// A side of the layer 0 ≤ z ≤ H. By default light comes from the incident side, z < 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum Side {
    /// z < 0.
    #[default]
    Incident,
    /// z > H.
    Exit,
}

/// A plane wave: vacuum wavelength in µm, polar angle from the layer's normal (0° ≤ σ < 90°) and
/// azimuth φ, both in the half-space of incidence (P2 section 2: kx = k sin σ cos φ).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Incidence {
    /// Vacuum wavelength, µm.
    pub wavelength_um: f64,
    /// Polar angle σ from the layer's normal, degrees.
    pub polar_deg: f64,
    /// Azimuth φ from the x axis, degrees.
    pub azimuth_deg: f64,
    /// Side of incidence.
    pub from: Side,
}

impl Incidence {
    /// Rejects wavelengths that are not positive and angles outside 0° ≤ σ < 90°.
    pub fn check(&self) -> Result<(), super::WaveError> {
        let wavelength = self.wavelength_um;
        let polar = self.polar_deg;
        let azimuth = self.azimuth_deg;
        let grazing = "grazing light carries no flux into the layer: use 89 or less";
        let rules = [
            ("wavelength (µm)", wavelength, wavelength > 0.0, "finite and above 0", "give it in µm"),
            ("polar angle (degrees)", polar, (0.0..90.0).contains(&polar), "0 ≤ σ < 90", grazing),
            ("azimuth (degrees)", azimuth, true, "any finite angle", "give it in degrees"),
        ];
        let wrong = rules.into_iter().find(|&(_, value, is_allowed, ..)| !(value.is_finite() && is_allowed));
        let Some((field, value, _, allowed, remedy)) = wrong else { return Ok(()) };
        Err(super::WaveError::range(field, value, allowed, remedy))
    }
}
