//! An opaque paint of one pigment: spheres that scatter one by one (Mie), the radiation between them by adding and doubling
//! (Hansen and Travis, Space Sci. Rev. 16, 527 (1974)), and a smooth face (Fresnel), lit at 45° and viewed along the normal.
//!
//! R(μ, μ₀) and T(μ, μ₀) are reflectance factors: radiance over that of a perfect white in the same light. Products run over
//! 2μ dμ by Gauss's rule; the directions of the lamp and of the eye within the paint take part with weight 0. The eye is on the
//! normal, so that the mean over the azimuth, which alone is computed, is exact.

use super::mie::Sphere;
use num_complex::Complex64;
use std::f64::consts::PI;

/// Directions of Gauss's rule on 0 < μ < 1.
const DIRECTIONS: usize = 16;
/// Azimuths of the mean of a phase function.
const AZIMUTHS: usize = 48;
/// Optical thickness from which doubling starts: its square is neglected.
const THIN: f64 = 1e-6;

/// Spheres of a lognormal law of diameters by number, in a binder.
#[derive(Clone, Copy, Debug)]
pub struct OpaquePaint {
    /// Median diameter, µm.
    pub diameter_um: f64,
    /// Standard deviation of the logarithm of the diameter.
    pub spread: f64,
    /// Index of the binder.
    pub binder: f64,
}

/// What spheres of several sizes do to light, on average.
struct Medium {
    /// Scattering functions of each size with its share of the scattered light.
    parts: Vec<(f64, super::mie::Mie)>,
}

type Matrix = Vec<Vec<f64>>;

impl OpaquePaint {
    /// Diameters and their shares by number: middles of nine equal steps over ±2.25 standard deviations.
    fn sizes(&self) -> Vec<(f64, f64)> {
        if self.spread == 0.0 {
            return vec![(self.diameter_um, 1.0)];
        }
        let steps = (-4..=4).map(|k| 0.5 * f64::from(k));
        steps.map(|s| (self.diameter_um * (s * self.spread).exp(), (-0.5 * s * s).exp())).collect()
    }

    /// Reflectance factor at 45:0 without the gloss; the layer is `thickness` optical thicknesses deep, over black.
    pub fn reflectance(&self, index: Complex64, wavelength_um: f64, thickness: f64) -> f64 {
        let mut scattered = 0.0;
        let mut lost = 0.0;
        let mut parts = Vec::new();
        for (diameter, share) in self.sizes() {
            let radius_um = 0.5 * diameter;
            let mie = Sphere { wavelength_um, radius_um, index, host: self.binder }.mie();
            let [scattering, extinction] = mie.efficiencies(radius_um);
            let area = share * PI * radius_um * radius_um;
            scattered += area * scattering;
            lost += area * extinction;
            parts.push((area * scattering, mie));
        }
        parts.iter_mut().for_each(|(share, _)| *share /= scattered);
        let medium = Medium { parts };
        seen_through_a_face(scattered / lost, &|cosine| medium.phase(cosine), self.binder, thickness)
    }
}

impl Medium {
    /// The phase function at cos Θ, of mean 1.
    fn phase(&self, cosine: f64) -> f64 {
        let part = |(share, mie): &(f64, super::mie::Mie)| {
            let [s1, s2] = mie.amplitudes(cosine);
            // ∫ (|S₁|² + |S₂|²)/2 dΩ = k² C_sca
            let total: f64 = (1..mie.a.len())
                .map(|l| (2 * l + 1) as f64 * (mie.a[l].norm_sqr() + mie.b[l].norm_sqr()))
                .sum();
            share * (s1.norm_sqr() + s2.norm_sqr()) / total
        };
        self.parts.iter().map(part).sum()
    }
}

/// Phase functions averaged over the azimuth: rows of directions, of the same or of opposite sense. `table` holds the phase
/// function at equal steps of Θ.
fn azimuth_mean(table: &[f64], nodes: &[f64], sense: f64) -> Matrix {
    let phase = |cosine: f64| {
        let place = cosine.clamp(-1.0, 1.0).acos() / PI * (table.len() - 1) as f64;
        let below = (place as usize).min(table.len() - 2);
        table[below] + (place - below as f64) * (table[below + 1] - table[below])
    };
    let mean = |a: f64, b: f64| {
        let across = ((1.0 - a * a) * (1.0 - b * b)).sqrt();
        let azimuths = (0..AZIMUTHS).map(|k| PI * (k as f64 + 0.5) / AZIMUTHS as f64);
        azimuths.map(|phi| phase(sense * a * b + across * phi.cos())).sum::<f64>() / AZIMUTHS as f64
    };
    nodes.iter().map(|a| nodes.iter().map(|b| mean(*a, *b)).collect()).collect()
}

/// Reflectance factor at 45:0 of an optically `thickness` deep medium behind a smooth face of index `binder` (1: no face), whose
/// particles scatter the share `albedo` of what they take from the light by a phase function of cos Θ.
pub fn seen_through_a_face(albedo: f64, phase: &dyn Fn(f64) -> f64, binder: f64, thickness: f64) -> f64 {
    let lamp = (1.0 - 0.5 / (binder * binder)).sqrt();
    let (mut nodes, mut weights) = gauss(DIRECTIONS);
    nodes.extend([lamp, 1.0]);
    weights.extend([0.0; 2]);
    let steps = 1440;
    let table: Vec<f64> = (0..=steps).map(|k| phase((PI * f64::from(k) / f64::from(steps)).cos())).collect();
    let mut forward = azimuth_mean(&table, &nodes, 1.0);
    let mut back = azimuth_mean(&table, &nodes, -1.0);
    // Gauss's rule and the table lose no light
    for j in 0..nodes.len() {
        let sum: f64 = (0..nodes.len()).map(|i| 0.5 * weights[i] * (forward[i][j] + back[i][j])).sum();
        for i in 0..nodes.len() {
            forward[i][j] /= sum;
            back[i][j] /= sum;
        }
    }
    let measure: Vec<f64> = nodes.iter().zip(&weights).map(|(mu, w)| 2.0 * mu * w).collect();
    let single = |phase: &Matrix| -> Matrix {
        let element = |i: usize, j: usize| albedo * phase[i][j] * THIN / (4.0 * nodes[i] * nodes[j]);
        (0..nodes.len()).map(|i| (0..nodes.len()).map(|j| element(i, j)).collect()).collect()
    };
    let mut r = single(&back);
    let mut t = single(&forward);
    let mut depth = THIN;
    while depth < thickness {
        let direct: Vec<f64> = nodes.iter().map(|mu| (-depth / mu).exp()).collect();
        (r, t) = doubled(&r, &t, &direct, &measure);
        depth *= 2.0;
    }
    // the face sends light back into the paint
    let inner: Vec<f64> = nodes.iter().map(|mu| fresnel(binder, *mu)).collect();
    let n = nodes.len();
    let system: Matrix = (0..n)
        .map(|i| (0..n).map(|j| f64::from(u8::from(i == j)) - r[i][j] * measure[j] * inner[j]).collect())
        .collect();
    let source: Vec<f64> = r.iter().map(|row| row[n - 2]).collect();
    let up = solved(system, vec![source]).remove(0);
    (1.0 - fresnel(1.0 / binder, 0.5f64.sqrt())) * (1.0 - inner[n - 1]) * up[n - 1] / (binder * binder)
}

/// Two equal layers one upon the other.
fn doubled(r: &Matrix, t: &Matrix, direct: &[f64], measure: &[f64]) -> (Matrix, Matrix) {
    let n = direct.len();
    let times = |a: &Matrix, b: &Matrix| -> Matrix {
        let element = |i: usize, j: usize| (0..n).map(|k| a[i][k] * measure[k] * b[k][j]).sum();
        (0..n).map(|i| (0..n).map(|j| element(i, j)).collect()).collect()
    };
    let joined = |parts: &dyn Fn(usize, usize) -> f64| -> Matrix {
        (0..n).map(|i| (0..n).map(|j| parts(i, j)).collect()).collect()
    };
    let q = times(r, r);
    // S = Q + Q S, column by column
    let system: Matrix = (0..n)
        .map(|i| (0..n).map(|j| f64::from(u8::from(i == j)) - q[i][j] * measure[j]).collect())
        .collect();
    let columns = (0..n).map(|j| q.iter().map(|row| row[j]).collect()).collect();
    let s = solved(system, columns);
    let s: Matrix = joined(&|i, j| s[j][i]);
    let st = times(&s, t);
    let down = joined(&|i, j| t[i][j] + s[i][j] * direct[j] + st[i][j]);
    let rd = times(r, &down);
    let up = joined(&|i, j| r[i][j] * direct[j] + rd[i][j]);
    let tu = times(t, &up);
    let td = times(t, &down);
    let both_r = joined(&|i, j| r[i][j] + direct[i] * up[i][j] + tu[i][j]);
    let both_t = joined(&|i, j| direct[i] * down[i][j] + t[i][j] * direct[j] + td[i][j]);
    (both_r, both_t)
}

/// Reflectance of a face for unpolarised light that comes at cos θ = `mu` from a medium of relative index `n`.
fn fresnel(n: f64, mu: f64) -> f64 {
    let square = 1.0 - n * n * (1.0 - mu * mu);
    if square <= 0.0 {
        return 1.0;
    }
    let out = square.sqrt();
    let s = (n * mu - out) / (n * mu + out);
    let p = (mu - n * out) / (mu + n * out);
    0.5 * (s * s + p * p)
}

/// Nodes and weights of Gauss's rule on 0 … 1, by Newton's iteration for the zeros of Legendre's polynomial.
fn gauss(count: usize) -> (Vec<f64>, Vec<f64>) {
    let rule = |i: usize| {
        let mut x = (PI * (i as f64 + 0.75) / (count as f64 + 0.5)).cos();
        let mut slope = 1.0;
        for _ in 0..50 {
            let mut before = 1.0;
            let mut here = x;
            for l in 2..=count {
                let l = l as f64;
                (before, here) = (here, ((2.0 * l - 1.0) * x * here - (l - 1.0) * before) / l);
            }
            slope = count as f64 * (before - x * here) / (1.0 - x * x);
            x -= here / slope;
        }
        (0.5 * (1.0 + x), 1.0 / ((1.0 - x * x) * slope * slope))
    };
    (0..count).map(rule).unzip()
}

/// Solves A x = b for several b by elimination.
fn solved(mut a: Matrix, mut right: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    let n = a.len();
    for k in 0..n {
        let pivot = (k..n).max_by(|&i, &j| a[i][k].abs().total_cmp(&a[j][k].abs())).unwrap_or(k);
        a.swap(k, pivot);
        right.iter_mut().for_each(|b| b.swap(k, pivot));
        for i in k + 1..n {
            let factor = a[i][k] / a[k][k];
            for j in k..n {
                a[i][j] -= factor * a[k][j];
            }
            right.iter_mut().for_each(|b| b[i] -= factor * b[k]);
        }
    }
    for b in &mut right {
        for i in (0..n).rev() {
            let known: f64 = (i + 1..n).map(|j| a[i][j] * b[j]).sum();
            b[i] = (b[i] - known) / a[i][i];
        }
    }
    right
}
