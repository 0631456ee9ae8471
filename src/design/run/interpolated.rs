//! What is interpolated of the spectra between recipes.

use crate::design::surface::Spectra3;
use serde::Serialize;

/// Least factor whose logarithm is taken: what is below, by chance, counts as this.
const LEAST: f64 = 1e-5;

/// What is interpolated of the spectra.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Interpolated {
    /// What they are beyond the coherent film: of layers that are solved as a whole.
    BeyondFilm,
    /// Themselves.
    Spectra,
    /// Their logarithms.
    Logarithms,
}

impl Interpolated {
    /// In words.
    pub fn in_words(self) -> &'static str {
        match self {
            Self::BeyondFilm => "their spectra's differences from the coherent film",
            Self::Spectra => "their spectra",
            Self::Logarithms => "the logarithms of their spectra",
        }
    }

    /// Of spectra over those of a film, if there is one.
    pub(super) fn of(self, spectra: &[f64], film: &[f64]) -> Spectra3 {
        match self {
            Self::BeyondFilm => spectra.iter().zip(film).map(|(a, b)| a - b).collect(),
            Self::Spectra => spectra.to_vec(),
            Self::Logarithms => spectra.iter().map(|value| value.max(LEAST).ln()).collect(),
        }
    }

    /// The spectra of what was interpolated.
    pub(super) fn back(self, interpolated: Spectra3, film: &[f64]) -> Spectra3 {
        match self {
            Self::BeyondFilm => film.iter().zip(interpolated).map(|(a, b)| a + b).collect(),
            Self::Spectra => interpolated,
            Self::Logarithms => interpolated.into_iter().map(f64::exp).collect(),
        }
    }

    /// Spectra after an error of what is interpolated.
    pub(super) fn wrong_by(self, spectra: &[f64], error: &[f64]) -> Spectra3 {
        let all = spectra.iter().zip(error);
        match self {
            Self::BeyondFilm | Self::Spectra => all.map(|(own, e)| own + e).collect(),
            Self::Logarithms => all.map(|(own, e)| own * e.exp()).collect(),
        }
    }
}
