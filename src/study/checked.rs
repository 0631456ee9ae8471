//! A study that has passed every check: the only input a run takes.

use super::identity::Key;
use crate::wave::{Incidence, Side};
use num_complex::Complex64;
use serde::Serialize;

/// All that was asked, checked. Built by [`super::check`] alone.
#[derive(Clone, Debug, Serialize)]
pub struct Study {
    pub title: String,
    pub layer: Layer,
    pub pigments: Vec<Pigment>,
    pub paper: Paper,
    /// Vacuum wavelengths, nm, rising.
    pub wavelengths_nm: Vec<f64>,
    /// Polar angles of incidence, degrees, rising, below 90.
    pub polar_deg: Vec<f64>,
    pub azimuth_deg: f64,
    pub realisations: usize,
    pub seed: u64,
    pub resolution: WantedResolution,
    pub solver: WantedSolver,
    pub output: Output,
}

/// The periodic cell 0 ≤ z ≤ thickness and its surroundings.
#[derive(Clone, Debug, Serialize)]
pub struct Layer {
    pub period_um: [f64; 2],
    pub thickness_um: f64,
    pub index_above: f64,
    pub index_below: f64,
    /// Index of the binder at every wavelength of the study.
    pub binder: Vec<Complex64>,
}

/// One kind of grain.
#[derive(Clone, Debug, Serialize)]
pub struct Pigment {
    pub name: String,
    pub diameter_nm: f64,
    /// Relative standard deviation of the log-normal sizes.
    pub diameter_spread: f64,
    pub volume_fraction: f64,
    /// Index n + iκ at every wavelength of the study.
    pub index: Vec<Complex64>,
}

/// The Lambertian substrate behind a thin air gap.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Paper {
    pub albedo: f64,
}

/// A wanted accuracy, or the grid itself.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum WantedResolution {
    /// Largest error of any order's amplitude.
    Accuracy(f64),
    Grid {
        points_per_um: f64,
        planes_per_um: f64,
    },
}

/// Solver and goal.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WantedSolver {
    pub method: String,
    pub tolerance: f64,
    pub max_steps: usize,
}

/// What the results look like; no number depends on it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Output {
    pub folder: Option<String>,
    pub picture_pixels: usize,
}

/// One solve of the study.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Point {
    pub realisation: usize,
    /// Place of the wavelength in the study's list.
    pub wavelength: usize,
    pub incidence: Incidence,
}

impl Study {
    /// Content hash of the whole study.
    pub fn key(&self) -> Key {
        Key::of("study", self)
    }

    /// The sides the layer is lit from. A layer between equal half-spaces is statistically the same from both
    /// sides, so light from above serves for both.
    pub fn sides(&self) -> &'static [Side] {
        if self.layer.index_above == self.layer.index_below {
            &[Side::Above]
        } else {
            &[Side::Above, Side::Below]
        }
    }

    /// All solves of one realisation, in their order: wavelength, side, angle.
    pub fn points(&self, realisation: usize) -> Vec<Point> {
        let wavelengths = self.wavelengths_nm.iter().enumerate();
        let directions = |(wavelength, &nm): (usize, &f64)| {
            let point = move |from, polar_deg| Point {
                realisation,
                wavelength,
                incidence: Incidence {
                    wavelength_um: nm * 1e-3,
                    polar_deg,
                    azimuth_deg: self.azimuth_deg,
                    from,
                },
            };
            let side = move |&from| self.polar_deg.iter().map(move |&polar_deg| point(from, polar_deg));
            self.sides().iter().flat_map(side)
        };
        wavelengths.flat_map(directions).collect()
    }

    /// Number of solves of the whole study.
    pub fn solves(&self) -> usize {
        self.realisations * self.wavelengths_nm.len() * self.polar_deg.len() * self.sides().len()
    }
}
