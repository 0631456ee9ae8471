//! Fourier coefficients of point sources scattered in the plane (a type-1 non-uniform FFT).
//!
//! Spreading with the "exponential of semicircle" kernel on a grid twice as fine as the harmonics need:
//! Barnett, Magland, af Klinteberg, SIAM J. Sci. Comput. 41 (2019) C479.

use crate::numerics::fourier::{PlaneFft, PlaneScratch};
use gauss_quad::GaussLegendre;
use num_complex::Complex64;
use std::f64::consts::PI;

/// Kernel width in fine-grid points: relative error about 10^{1−w} at an oversampling of two.
const WIDTH: usize = 11;
const SHAPE: f64 = 2.30 * WIDTH as f64;

/// Transform from sources in the cell to the harmonics |m| ≤ mmax, |n| ≤ nmax.
pub struct SourceTransform {
    fine: [usize; 2],
    fft: PlaneFft,
    /// 1 / transform of the kernel at m (x) and n (y).
    correction: [Vec<f64>; 2],
}

impl SourceTransform {
    pub fn new(mmax: usize, nmax: usize) -> SourceTransform {
        let fine = [fine_size(mmax), fine_size(nmax)];
        let correction = [kernel_correction(mmax, fine[0]), kernel_correction(nmax, fine[1])];
        SourceTransform { fine, fft: PlaneFft::new(fine[0], fine[1]), correction }
    }

    pub fn scratch(&self) -> PlaneScratch {
        self.fft.scratch()
    }

    /// Points of the fine grid.
    pub fn points(&self) -> usize {
        self.fine[0] * self.fine[1]
    }

    /// Kernel values and periodic grid indices of a source at the fraction `position` of a period.
    pub fn footprint(&self, axis: usize, position: f64) -> Footprint {
        let size = self.fine[axis];
        let x = (position - position.floor()) * size as f64;
        let first = (x - WIDTH as f64 / 2.0).ceil();
        let mut footprint = Footprint { index: [0; WIDTH], weight: [0.0; WIDTH] };
        for i in 0..WIDTH {
            let g = first + i as f64;
            footprint.weight[i] = kernel((g - x) / (WIDTH as f64 / 2.0));
            footprint.index[i] = (g as i64).rem_euclid(size as i64) as usize;
        }
        footprint
    }

    /// Adds a source of strength `value` to a fine grid (x fastest).
    pub fn spread(&self, grid: &mut [Complex64], x: &Footprint, y: &Footprint, value: Complex64) {
        for (&row, &wy) in y.index.iter().zip(&y.weight) {
            let line = &mut grid[row * self.fine[0]..(row + 1) * self.fine[0]];
            let scaled = value * wy;
            for (&column, &wx) in x.index.iter().zip(&x.weight) {
                line[column] += scaled * wx;
            }
        }
    }

    /// Transforms the fine grid in `scratch.plane`; read the result with [`SourceTransform::coefficient`].
    pub fn transform(&self, scratch: &mut PlaneScratch) {
        let all = 0..self.fine[0];
        self.fft.forward(scratch, std::slice::from_ref(&all));
    }

    /// Σ_q c_q e^{−2πi(m x_q + n y_q)} from a transformed grid.
    pub fn coefficient(&self, scratch: &PlaneScratch, m: i32, n: i32) -> Complex64 {
        let row = m.rem_euclid(self.fine[0] as i32) as usize;
        let column = n.rem_euclid(self.fine[1] as i32) as usize;
        let correction =
            self.correction[0][m.unsigned_abs() as usize] * self.correction[1][n.unsigned_abs() as usize];
        scratch.spectrum[row * self.fine[1] + column] * correction
    }
}

/// One source's kernel along one axis.
pub struct Footprint {
    index: [usize; WIDTH],
    weight: [f64; WIDTH],
}

fn kernel(t: f64) -> f64 {
    let inside = 1.0 - t * t;
    if inside <= 0.0 { 0.0 } else { (SHAPE * (inside.sqrt() - 1.0)).exp() }
}

/// Smallest product of 2, 3 and 5 that is twice the harmonics and holds the kernel.
fn fine_size(mmax: usize) -> usize {
    let least = (4 * mmax + 2).max(2 * WIDTH);
    (least..).find(|&n| is_smooth(n)).expect("smooth numbers are unbounded")
}

/// True for products of 2, 3 and 5, the sizes with the fastest transforms.
pub fn is_smooth(mut n: usize) -> bool {
    for p in [2, 3, 5] {
        while n.is_multiple_of(p) {
            n /= p;
        }
    }
    n == 1
}

fn kernel_correction(mmax: usize, size: usize) -> Vec<f64> {
    let half = WIDTH as f64 / 2.0;
    let rule = GaussLegendre::new(4 * WIDTH).expect("a rule of 44 nodes exists");
    let transform = |m: usize| {
        let k = 2.0 * PI * m as f64 / size as f64 * half;
        half * rule.integrate(-1.0, 1.0, |t| kernel(t) * (k * t).cos())
    };
    (0..=mmax).map(|m| 1.0 / transform(m)).collect()
}

#[cfg(test)]
#[path = "nufft_tests.rs"]
mod tests;
