//! Vacuum above a rough binder surface, between the grains that stand out of it.
//!
//! Columns of a raster finer than the grid: in each, vacuum fills 0 ≤ z < s(x, y) except where balls are. Moments
//! along z are exact in every column, so what is sampled is continuous and the raster's aliasing decays fast.

use super::cell::{CellCoefficients, CellColumns};
use crate::numerics::fourier::{PlaneFft, Real};
use crate::wave::scene::{Ball, HeightField};
use gauss_quad::GaussLegendre;

/// Raster points per point of the grid's widest harmonics; doubling it changes amplitudes of rough ink by < 1e-5.
const FINER: usize = 4;

impl HeightField {
    /// z of the surface at (x, y): bilinear, periodic.
    pub fn z_um(&self, x_um: f64, y_um: f64) -> f64 {
        let [nx, ny] = self.count;
        let split = |x: f64, period: f64, n: usize| {
            let t = (x / period).rem_euclid(1.0) * n as f64;
            let i = (t as usize).min(n - 1);
            (i, (i + 1) % n, t - i as f64)
        };
        let (i0, i1, u) = split(x_um, self.period_um[0], nx);
        let (j0, j1, v) = split(y_um, self.period_um[1], ny);
        let z = |i: usize, j: usize| self.z_um[j * nx + i];
        (1.0 - v) * ((1.0 - u) * z(i0, j0) + u * z(i1, j0)) + v * ((1.0 - u) * z(i0, j1) + u * z(i1, j1))
    }

    /// Lowest point of the surface, largest z.
    pub fn deepest_um(&self) -> f64 {
        self.z_um.iter().copied().fold(0.0, f64::max)
    }
}

/// Adds the vacuum's moments in one cell to `planes` (harmonics of the grid's widest set).
pub(crate) fn add_vacuum<T: Real>(
    surface: &HeightField,
    balls: &[Ball],
    cell: &CellColumns,
    sum: &mut CellCoefficients<T>,
) {
    let count = cell.widest.map(|m| if m == 0 { 1 } else { FINER * (2 * m + 2) });
    let fft = PlaneFft::new(count[0], count[1]);
    let mut scratch = fft.scratch();
    let columns = column_moments(surface, balls, cell, count);
    let points = (count[0] * count[1]) as f64;
    for (plane, out) in sum.spectra.iter_mut().enumerate() {
        scratch.plane.iter_mut().zip(&columns).for_each(|(s, m)| *s = T::of(m[plane] / points).into());
        sum.means[plane] += columns.iter().map(|m| m[plane]).sum::<f64>() / points;
        fft.forward(&mut scratch, std::slice::from_ref(&(0..count[0])));
        for (value, &[m, n]) in out.iter_mut().zip(cell.orders) {
            let row = m.rem_euclid(count[0] as i32) as usize;
            *value += scratch.spectrum[row * count[1] + n.rem_euclid(count[1] as i32) as usize];
        }
    }
}

/// ∫ ψ_p dz over the vacuum of each column within the cell.
fn column_moments(
    surface: &HeightField,
    balls: &[Ball],
    cell: &CellColumns,
    count: [usize; 2],
) -> Vec<Vec<f64>> {
    let [lo, hi] = cell.range_um;
    let near: Vec<&Ball> = balls
        .iter()
        .filter(|b| b.center_um[2] - b.radius_um < hi && b.center_um[2] + b.radius_um > lo)
        .collect();
    let rule = GaussLegendre::new(cell.element.degree + 1).expect("at least two nodes");
    let column = |k: usize| {
        let fraction = [(k % count[0]) as f64 / count[0] as f64, (k / count[0]) as f64 / count[1] as f64];
        let [x, y] = [0, 1].map(|i| fraction[i] * surface.period_um[i]);
        let top = surface.z_um(x, y).min(hi);
        let mut blocked: Vec<[f64; 2]> =
            near.iter().filter_map(|b| chord(b, x, y, surface.period_um)).collect();
        blocked.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let mut moments = vec![0.0; cell.element.degree + 1];
        let mut from = lo;
        for [start, end] in blocked.into_iter().chain([[top, top]]) {
            add_stretch(&mut moments, cell, &rule, [from, start.min(top)]);
            from = from.max(end);
        }
        moments
    };
    (0..count[0] * count[1]).map(column).collect()
}

/// The stretch of the vertical line at (x, y) inside a ball or its nearest image.
fn chord(ball: &Ball, x: f64, y: f64, period: [f64; 2]) -> Option<[f64; 2]> {
    let nearest = |d: f64, l: f64| d - l * (d / l).round();
    let dx = nearest(x - ball.center_um[0], period[0]);
    let dy = nearest(y - ball.center_um[1], period[1]);
    let square = ball.radius_um.powi(2) - dx * dx - dy * dy;
    (square > 0.0).then(|| [ball.center_um[2] - square.sqrt(), ball.center_um[2] + square.sqrt()])
}

fn add_stretch(moments: &mut [f64], cell: &CellColumns, rule: &GaussLegendre, [from, to]: [f64; 2]) {
    if to <= from {
        return;
    }
    let [lo, hi] = cell.range_um;
    for &(x, w) in rule.as_node_weight_pairs() {
        let z = from + 0.5 * (to - from) * (x + 1.0);
        let psi = cell.element.shape_functions((z - lo) / (hi - lo));
        moments.iter_mut().zip(psi).for_each(|(m, p)| *m += 0.5 * (to - from) * w * p);
    }
}
