//! The contrast V as weights W_p, divided by the number of points of each plane.

use super::Problem;
use crate::wave::contrast::coverage::Channel;
use crate::wave::{Coverage, Media};
use ndarray::Array2;
use num_complex::Complex64;

/// Contrast k0²(η² − η_background²) of each channel, then the products of each folded pair, divided
/// by the number of points of a plane.
pub(super) fn strengths(coverage: &Coverage, media: &Media, k0: f64) -> Vec<Complex64> {
    let points = coverage.grid.points() as f64;
    let contrast = |c: &Channel| {
        let [inclusion, background] = [media.index_of(c.material), media.backgrounds[c.background]];
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
}
