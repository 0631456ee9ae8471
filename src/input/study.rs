//! A study that has passed every check: the only input a run takes.

use crate::appearance::angles::AngleRule;
use crate::appearance::paper::{Albedo, Coupling, MirroredSky};
use crate::ink::{PackingRequest, PigmentGrains};
use crate::solve::{Goal, SolverChoice};
use crate::store::identity::Key;
use crate::wave::contrast::coverage::{EXACT, error_for};
use crate::wave::{Incidence, Media, Scheme, Side};
use num_complex::Complex64;
use serde::{Deserialize, Serialize};

/// All that was asked, checked. Built by [`super::check`] alone.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Study {
    pub title: String,
    pub layer: Layer,
    pub pigments: Vec<Pigment>,
    /// Pigments without grains (`diameter_nm = "molecular"`); they are part of `layer.binder`'s index.
    pub dissolved: Vec<Dissolved>,
    /// The packing of realisation 0; the others differ in their random stream.
    pub packing: PackingRequest,
    pub paper: Paper,
    /// Vacuum wavelengths, nm, rising.
    pub wavelengths_nm: Vec<f64>,
    pub angles: Angles,
    pub realisations: usize,
    pub resolution: WantedResolution,
    pub solver: SolverChoice,
    pub goal: Goal,
    pub output: Output,
}

/// The periodic cell 0 ≤ z ≤ thickness and its surroundings.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Layer {
    pub period_um: [f64; 2],
    pub thickness_um: f64,
    pub index_above: f64,
    pub index_below: f64,
    pub binder: Material,
}

/// One kind of grain.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Pigment {
    pub name: String,
    pub grains: PigmentGrains,
    pub material: Material,
}

/// A pigment in the limit of vanishing grains: a homogeneous mixture with the binder.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Dissolved {
    pub name: String,
    /// Share of the layer's volume.
    pub volume_fraction: f64,
    pub material: Material,
}

/// A material by its index n + iκ at every wavelength of the study.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Material {
    /// For people: a constant, the name of a built-in spectrum, or the path of a table.
    pub source: String,
    pub index: Vec<Complex64>,
}

/// The Lambertian substrate.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Paper {
    /// For people: the albedo itself, or where its table comes from.
    pub source: String,
    pub albedo: Albedo,
    pub coupling: Coupling,
}

/// Angles of incidence, degrees from the normal, below 90.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Angles {
    /// For light from above, rising.
    pub above: Vec<f64>,
    /// For light from below, in the rule's order; empty where the layer is the same from both sides.
    pub below: Vec<f64>,
    pub azimuth_deg: f64,
    /// The quadrature rule, unless the angles were listed.
    pub rule: Option<AngleRule>,
    /// Largest angle of the picture's axes.
    pub picture_max_deg: f64,
}

/// A wanted accuracy, or the grid itself.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum WantedResolution {
    /// Largest error of any order's amplitude.
    Accuracy { amplitude: f64, scheme: Scheme },
    /// Points and planes per µm.
    Grid { points_per_um: f64, planes_per_um: f64, scheme: Scheme },
}

impl WantedResolution {
    /// The discretisation in z.
    pub fn scheme(&self) -> Scheme {
        match *self {
            Self::Accuracy { scheme, .. } | Self::Grid { scheme, .. } => scheme,
        }
    }

    /// Relative error of the contrast's coefficients that is nothing beside the grid's: a grid of one's own choice may
    /// be as fine as it likes.
    pub fn coverage_error(&self) -> f64 {
        match *self {
            Self::Accuracy { amplitude, .. } => error_for(amplitude),
            Self::Grid { .. } => EXACT,
        }
    }
}

/// What the results look like; no solve depends on it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Output {
    pub folder: Option<String>,
    pub picture_pixels: usize,
    pub mirrored_sky: MirroredSky,
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
    /// Content hash of everything the results depend on: all but the title and the output's form.
    pub fn key(&self) -> Key {
        let ensemble = (&self.layer, &self.pigments, &self.packing, self.realisations);
        let light = (&self.paper, &self.wavelengths_nm, &self.angles);
        Key::of("study", &(ensemble, light, &self.resolution, &self.solver, &self.goal))
    }

    /// The packing of a realisation: its own stream of the study's seed.
    pub fn packing_request(&self, realisation: usize) -> PackingRequest {
        PackingRequest { stream: realisation as u64, ..self.packing.clone() }
    }

    /// Indices at one wavelength; pigment i is inclusion i.
    pub fn media(&self, wavelength: usize) -> Media {
        Media {
            incident: self.layer.index_above.into(),
            exit: self.layer.index_below.into(),
            backgrounds: vec![self.layer.binder.index[wavelength]],
            inclusions: self.pigments.iter().map(|p| p.material.index[wavelength]).collect(),
        }
    }

    /// The same indices for a content hash: incident side, exit side, binder, pigments.
    pub fn indices(&self, wavelength: usize) -> Vec<Complex64> {
        let Media { incident, exit, backgrounds, inclusions } = self.media(wavelength);
        [incident, exit].into_iter().chain(backgrounds).chain(inclusions).collect()
    }

    /// All solves of one realisation, in their order: wavelength, side, angle.
    pub fn points(&self, realisation: usize) -> Vec<Point> {
        let at = |wavelength: usize, from: Side, polar_deg: f64| {
            let wavelength_um = self.wavelengths_nm[wavelength] * 1e-3;
            let azimuth_deg = self.angles.azimuth_deg;
            let incidence = Incidence { wavelength_um, polar_deg, azimuth_deg, from };
            Point { realisation, wavelength, incidence }
        };
        let of_wavelength = |wavelength: usize| {
            let above = self.angles.above.iter().map(move |&deg| at(wavelength, Side::Incident, deg));
            let below = self.angles.below.iter().map(move |&deg| at(wavelength, Side::Exit, deg));
            above.chain(below)
        };
        (0..self.wavelengths_nm.len()).flat_map(of_wavelength).collect()
    }

    /// Volume of the cell, µm³.
    pub fn volume_um3(&self) -> f64 {
        self.layer.period_um[0] * self.layer.period_um[1] * self.layer.thickness_um
    }

    /// Number of solves of one realisation.
    pub fn solves_each(&self) -> usize {
        self.wavelengths_nm.len() * (self.angles.above.len() + self.angles.below.len())
    }

    /// Number of solves of the whole study.
    pub fn solves(&self) -> usize {
        self.realisations * self.solves_each()
    }
}
