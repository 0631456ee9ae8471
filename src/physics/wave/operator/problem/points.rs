//! The points of the planes: the contrast V as weights W_p divided by their number, and fields
//! converted between harmonics and points.

use crate::numerics::fourier::PlaneScratch;
use crate::wave::{Channel, Coverage, Field, Media, Problem};
use ndarray::Array2;
use num_complex::Complex64;
use rayon::prelude::*;

/// Contrast k0²(η² − η_background²) of each channel, then the products of each folded pair, divided
/// by the number of points of a plane.
pub(super) fn strengths(coverage: &Coverage, media: &Media, k0: f64) -> Vec<Complex64> {
    let points = coverage.grid.points() as f64;
    let contrast = |c: &Channel| {
        let inclusion = media.index_of(c.material);
        let background = media.backgrounds[c.background];
        (inclusion * inclusion - background * background) * (k0 * k0)
    };
    let single: Vec<Complex64> = coverage.channels.iter().map(contrast).collect();
    let folded = coverage.pairs.iter().map(|&[a, b]| single[a] * single[b] * if a == b { 1.0 } else { 2.0 });
    single.iter().copied().chain(folded).map(|c| c / points).collect()
}

impl Problem {
    /// Weights W_p divided by the number of points of a plane: planes × points.
    pub(super) fn weights(&self) -> Array2<Complex64> {
        let grid = &self.coverage.grid;
        let mut weights = Array2::zeros((grid.planes(), grid.points()));
        for (plane, mut row) in weights.outer_iter_mut().enumerate() {
            row.iter_mut().zip(self.contrast_weights(plane)).for_each(|(out, w)| *out = w);
        }
        weights
    }

    /// Weights W_p of one plane, divided by the number of its points.
    fn contrast_weights(&self, plane: usize) -> Vec<Complex64> {
        // W_p = ∫ ψ_p (k²_background − ⟨k²⟩) dz + Σ_c (k²_c − k²_background) ∫ ψ_p χ_c dz, plus the
        // folded terms
        let mut sum = vec![self.offsets[plane]; self.coverage.grid.points()];
        let fields = self.coverage.moments.iter().chain(&self.coverage.folded);
        for (moments, &contrast) in fields.zip(&self.contrasts) {
            sum.iter_mut().zip(moments.row(plane)).for_each(|(w, &m)| *w += contrast * m);
        }
        sum
    }

    /// Fourier coefficients of W_p at (m mod nx, n mod ny).
    pub fn contrast_spectrum(&self, plane: usize) -> Array2<Complex64> {
        let mut scratch = self.fft.scratch();
        scratch.plane = self.contrast_weights(plane);
        let resolution = self.coverage.grid.resolution;
        self.fft.forward(&mut scratch, std::slice::from_ref(&(0..resolution.nx)));
        Array2::from_shape_vec((resolution.nx, resolution.ny), scratch.spectrum).expect("a full spectrum")
    }

    /// Ratio V/D at every point of a plane, so that the largest modulus is a physical k² contrast.
    pub fn contrast_per_mass(&self, plane: usize, mass: f64) -> Vec<Complex64> {
        let scale = Complex64::from(self.coverage.grid.points() as f64 / mass);
        self.contrast_weights(plane).into_iter().map(|w| scale * w).collect()
    }

    /// Row of the illuminated face, and b at its points.
    pub fn source_at_points(&self) -> (usize, Vec<Complex64>) {
        let row = self.entry_row();
        let mut scratch = self.fft.scratch();
        self.to_points(self.source().row(row).to_slice().expect("rows are contiguous"), &mut scratch);
        (row, scratch.plane)
    }

    /// Converts harmonics of every plane to values at its points, unnormalised.
    pub fn planes_to_points(&self, harmonics: &Field, points: &mut Array2<Complex64>) {
        let rows = points.outer_iter_mut().into_par_iter().zip(harmonics.outer_iter());
        rows.for_each_init(
            || self.fft.scratch(),
            |scratch, (mut out, row)| {
                self.to_points(row.to_slice().expect("rows are contiguous"), scratch);
                out.as_slice_mut().expect("rows are contiguous").copy_from_slice(&scratch.plane);
            },
        );
    }

    /// Converts values at points to harmonics of every plane (inverse of
    /// [`Problem::planes_to_points`] on the harmonics in use).
    pub fn points_to_planes(&self, points: &Array2<Complex64>, harmonics: &mut Field) {
        let scale = 1.0 / self.coverage.grid.points() as f64;
        let rows = harmonics.outer_iter_mut().into_par_iter().zip(points.outer_iter());
        rows.for_each_init(
            || self.fft.scratch(),
            |scratch, (mut out, row)| {
                scratch.plane.iter_mut().zip(row).for_each(|(p, v)| *p = v * scale);
                self.fft.forward(scratch, &self.harmonics.rows);
                self.harmonics.gather(&scratch.spectrum, out.as_slice_mut().expect("rows are contiguous"));
            },
        );
    }

    fn to_points(&self, harmonics: &[Complex64], scratch: &mut PlaneScratch) {
        self.harmonics.spread(harmonics, &mut scratch.spectrum);
        self.fft.inverse(scratch, &self.harmonics.rows);
    }
}
