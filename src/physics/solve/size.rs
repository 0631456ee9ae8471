//! The size of a solve, and the memory of its parts.

use crate::wave::{Media, Resolution, Scene, Wave};
use std::f64::consts::PI;

/// Bytes of a complex number.
const COMPLEX: f64 = 16.0;
/// Ratio of the coverage's harmonics to those of the grid: twice as many along both axes.
const WIDE: f64 = 4.0;
/// Ratio of the coverage's source points to its harmonics: twice as many along both axes.
const FINE: f64 = 4.0;

/// Quantities that determine the memory of a solve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Size {
    /// The grid.
    pub resolution: Resolution,
    /// Pairs of a background and a body material; 0 for films.
    pub channels: usize,
    /// Periods and thickness, µm.
    pub layer_um: [f64; 3],
    /// Largest wavenumber in a medium and wavenumber in vacuum, 1/µm; zeros if no guided modes are
    /// treated.
    pub wavenumbers: [f64; 2],
    /// Whether the wave is the vector wave, with three components per unknown.
    pub vector: bool,
}

/// Bytes per point and plane of the vector wave: the contrast tensor (complex), two tables of the
/// mean operator's cells and four of its nodes for every two planes (complex), both in double and
/// in single precision, and seven moments per channel (real).
const VECTOR_TENSOR: f64 = 9.0 * COMPLEX;
const VECTOR_TABLES: f64 = 4.5 * COMPLEX;
const VECTOR_MOMENTS: f64 = 7.0 * 8.0;

impl Size {
    /// Size of a scene on a grid; guided modes are treated for the scalar wave only.
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

    /// Number of points of a plane.
    pub fn points(&self) -> f64 {
        self.resolution.nx as f64 * self.resolution.ny as f64
    }

    /// Number of planes with unknowns.
    pub fn planes(&self) -> f64 {
        self.resolution.scheme.degree() as f64 * self.resolution.cells as f64 + 1.0
    }

    /// Upper limit on the number of unknowns.
    pub fn unknowns(&self) -> f64 {
        let components = if self.vector { 3.0 } else { 1.0 };
        components * self.points() * self.planes()
    }

    /// Memory of `count` fields, bytes.
    pub fn fields(&self, count: f64) -> f64 {
        count * COMPLEX * self.unknowns()
    }

    /// Number of eigenvalues of the mean slab's operator within `threshold` k0² of zero:
    /// wavevectors in a shell of half of k-space, plus those of the two faces.
    pub fn near_null_modes(&self, threshold: f64) -> f64 {
        let ([lx, ly, h], [k, k0]) = (self.layer_um, self.wavenumbers);
        let shell = threshold * k0 * k0;
        lx * ly * shell * (h * k / (2.0 * PI * PI) + 1.0 / (2.0 * PI)) + 1.0
    }

    /// Memory held by a problem, bytes: coverage and factors of the mean operator.
    pub fn problem(&self) -> f64 {
        let (channels, degree) = (self.channels as f64, self.resolution.scheme.degree() as f64);
        if self.vector {
            let each = VECTOR_TENSOR + VECTOR_TABLES + VECTOR_MOMENTS * channels;
            return self.points() * self.planes() * each;
        }
        let moments = channels + 0.5 * channels * (channels + 1.0);
        // Tables of the mean operator and contrast in double precision, and those of A⁻¹V in single
        // precision.
        let factors = COMPLEX * (4.5 + 2.0 / degree);
        self.unknowns() * (8.0 * moments + factors)
    }

    /// Memory needed while the coverage is computed beyond its result, bytes: coefficients of every
    /// cell, and source grids of every thread.
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

/// Adds an item unless the list contains it.
fn note<T: PartialEq>(list: &mut Vec<T>, item: T) {
    if !list.contains(&item) {
        list.push(item);
    }
}
