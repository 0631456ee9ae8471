//! The size of a solve, and the bytes of its parts.

use crate::wave::{Media, Resolution, Scene, Wave};
use std::f64::consts::PI;

/// Bytes of a complex number.
const COMPLEX: f64 = 16.0;
/// Harmonics that the coverage is made with, for each of the grid's: twice as many along both axes.
const WIDE: f64 = 4.0;
/// Points of the coverage's source grids for each of those harmonics: twice as many along both axes.
const FINE: f64 = 4.0;

/// The size of a solve, and what its memory depends on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Size {
    /// The grid.
    pub resolution: Resolution,
    /// Pairs of a background and a material of bodies; 0 for films.
    pub channels: usize,
    /// Periods and thickness, µm.
    pub layer_um: [f64; 3],
    /// Largest wavenumber in a medium and that in vacuum, 1/µm; zeros where no guided modes are treated.
    pub wavenumbers: [f64; 2],
    /// The vector wave: three components of each unknown.
    pub vector: bool,
}

/// Per point and plane of the vector wave: the contrast's tensor (complex), two tables of the mean operator's cells and
/// four of its nodes for every two planes (complex), both in double and in single precision, and seven moments a channel (real).
const VECTOR_TENSOR: f64 = 9.0 * COMPLEX;
const VECTOR_TABLES: f64 = 4.5 * COMPLEX;
const VECTOR_MOMENTS: f64 = 7.0 * 8.0;

impl Size {
    /// Of a scene on a grid; guided modes are treated in the scalar wave alone.
    pub fn new(wave: Wave, scene: &Scene, media: &Media, wavelength_um: f64, resolution: Resolution) -> Size {
        let (mut backgrounds, mut materials) = (Vec::new(), Vec::new());
        scene.strata.iter().for_each(|s| note(&mut backgrounds, s.background));
        scene.bodies.iter().for_each(|b| note(&mut materials, b.material));
        let k0 = 2.0 * PI / wavelength_um;
        let indices = media.backgrounds.iter().chain(&media.inclusions);
        let densest = indices.map(|eta| eta.re).fold(1.0, f64::max);
        let [lx, ly] = scene.period_um;
        let layer_um = [lx, ly, scene.thickness_um()];
        Size {
            resolution,
            channels: backgrounds.len() * materials.len(),
            layer_um,
            wavenumbers: if wave.is_vector() { [0.0; 2] } else { [k0 * densest, k0] },
            vector: wave.is_vector(),
        }
    }

    /// Points of a plane.
    pub fn points(&self) -> f64 {
        self.resolution.nx as f64 * self.resolution.ny as f64
    }

    /// Planes with unknowns.
    pub fn planes(&self) -> f64 {
        self.resolution.scheme.degree() as f64 * self.resolution.cells as f64 + 1.0
    }

    /// Unknowns, at most.
    pub fn unknowns(&self) -> f64 {
        let components = if self.vector { 3.0 } else { 1.0 };
        components * self.points() * self.planes()
    }

    /// Bytes of so many fields.
    pub fn fields(&self, count: f64) -> f64 {
        count * COMPLEX * self.unknowns()
    }

    /// Eigenvalues of the mean slab's operator within `threshold` k0² of zero: wavevectors in a shell of half the k-space,
    /// and those of the two faces.
    pub fn near_null_modes(&self, threshold: f64) -> f64 {
        let ([lx, ly, h], [k, k0]) = (self.layer_um, self.wavenumbers);
        let shell = threshold * k0 * k0;
        lx * ly * shell * (h * k / (2.0 * PI * PI) + 1.0 / (2.0 * PI)) + 1.0
    }

    /// Bytes that are held while a problem is there: coverage and factors of the mean operator.
    pub fn problem(&self) -> f64 {
        let (channels, degree) = (self.channels as f64, self.resolution.scheme.degree() as f64);
        if self.vector {
            let each = VECTOR_TENSOR + VECTOR_TABLES + VECTOR_MOMENTS * channels;
            return self.points() * self.planes() * each;
        }
        let moments = channels + 0.5 * channels * (channels + 1.0);
        // The mean operator's tables and the contrast in double precision, and those of A⁻¹V in single.
        let factors = COMPLEX * (4.5 + 2.0 / degree);
        self.unknowns() * (8.0 * moments + factors)
    }

    /// Bytes that making the coverage takes besides what it keeps: coefficients of every cell, and source grids of
    /// every thread.
    pub fn making(&self) -> f64 {
        if self.channels == 0 {
            return 0.0;
        }
        let wide = |n: usize| if n == 1 { 1.0 } else { WIDE.sqrt() * n as f64 };
        let harmonics = wide(self.resolution.nx) * wide(self.resolution.ny);
        let planes = self.resolution.scheme.degree() as f64 + 1.0;
        let threads = rayon::current_num_threads() as f64;
        let cells = self.resolution.cells as f64;
        COMPLEX * harmonics * planes * (self.channels as f64 * cells + (FINE + 1.0) * threads)
    }
}

/// Adds what is not there yet.
fn note<T: PartialEq>(list: &mut Vec<T>, item: T) {
    if !list.contains(&item) {
        list.push(item);
    }
}
