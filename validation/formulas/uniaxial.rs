//! Uniaxial films by 4 × 4 matrices (Berreman, J. Opt. Soc. Am. 62 (1972) 502), with the exponential of
//! Berreman's matrix in place of its eigenvectors, which meet where the optic axis is along the wave.

use num_complex::Complex64;
use std::f64::consts::TAU;

type Matrix = [[Complex64; 4]; 4];

/// A film of a uniaxial crystal.
#[derive(Clone, Copy, Debug)]
pub struct UniaxialFilm {
    /// Indices of the ordinary and the extraordinary ray.
    pub rays: [Complex64; 2],
    /// Optic axis, of any length.
    pub axis: [f64; 3],
    pub thickness_um: f64,
}

/// A plane wave on films, angles in degrees, and the indices of both half-spaces.
#[derive(Clone, Copy, Debug)]
pub struct FilmLight {
    pub wavelength_um: f64,
    pub polar_deg: f64,
    pub azimuth_deg: f64,
    pub half_spaces: [f64; 2],
}

/// Amplitudes \[reflected, transmitted\]\[in\]\[out\] of s and p, each at its face; p amplitudes are those of the magnetic
/// field over the index, s = z × p.
pub fn amplitudes(light: &FilmLight, films: &[UniaxialFilm]) -> [[[Complex64; 2]; 2]; 2] {
    let [n_in, n_out] = light.half_spaces;
    let along = n_in * light.polar_deg.to_radians().sin();
    let k0 = TAU / light.wavelength_um;
    let (sin, cos) = light.azimuth_deg.to_radians().sin_cos();
    let mut through = identity();
    for film in films {
        let [x, y, z] = film.axis;
        let axis = [cos * x + sin * y, cos * y - sin * x, z];
        let rate = berreman(film.rays, axis, along);
        let turn = Complex64::new(0.0, k0 * film.thickness_um);
        through = product(&exponential(&rate.map(|row| row.map(|v| v * turn))), &through);
    }
    // (E_p, E_s, H_p, H_s) of waves of amplitude 1 towards ±z in a half-space
    let wave = |n: f64, sign: f64| {
        let c = Complex64::from(1.0 - (along / n).powi(2)).sqrt();
        let zero = Complex64::ZERO;
        [[zero, Complex64::ONE, -sign * n * c, zero], [sign * c, zero, zero, n.into()]]
    };
    let back = wave(n_in, -1.0);
    let onwards = wave(n_out, 1.0);
    // through (incoming + Σ r back) = Σ t onwards
    let mut matrix = [[Complex64::ZERO; 4]; 4];
    for k in 0..2 {
        let reflected = applied(&through, &back[k]);
        for i in 0..4 {
            matrix[i][k] = reflected[i];
            matrix[i][2 + k] = -onwards[k][i];
        }
    }
    let mut found = [[[Complex64::ZERO; 2]; 2]; 2];
    for (input, incoming) in wave(n_in, 1.0).iter().enumerate() {
        let right = applied(&through, incoming).map(|v| -v);
        let [rs, rp, ts, tp] = solved(matrix, right);
        found[0][input] = [rs, rp];
        found[1][input] = [ts, tp];
    }
    found
}

/// Berreman's Δ in d/dz (E_p, E_s, H_p, H_s) = i k0 Δ (…), for a lateral wavenumber `along` k0.
fn berreman([ordinary, extraordinary]: [Complex64; 2], axis: [f64; 3], along: f64) -> Matrix {
    let length = axis.iter().map(|a| a * a).sum::<f64>().sqrt();
    let a = axis.map(|v| v / length);
    let o = ordinary * ordinary;
    let e = extraordinary * extraordinary;
    let eps = |i: usize, j: usize| (if i == j { o } else { Complex64::ZERO }) + (e - o) * a[i] * a[j];
    // E_z = Σ z_i (…)_i from D_z = −along H_s
    let z = [-eps(2, 0) / eps(2, 2), -eps(2, 1) / eps(2, 2), Complex64::ZERO, -along / eps(2, 2)];
    let mut rows = [[Complex64::ZERO; 4]; 4];
    rows[0] = z.map(|v| along * v);
    rows[0][3] += 1.0;
    rows[1][2] = -Complex64::ONE;
    for (row, (field, sign)) in [(2, (1, -1.0)), (3, (0, 1.0))] {
        for i in 0..4 {
            let inner = if i < 2 { eps(field, i) } else { Complex64::ZERO };
            rows[row][i] = sign * (inner + eps(field, 2) * z[i]);
        }
    }
    rows[2][1] += along * along;
    rows
}

fn identity() -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| Complex64::from(f64::from(u8::from(i == j)))))
}

fn product(a: &Matrix, b: &Matrix) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..4).map(|k| a[i][k] * b[k][j]).sum()))
}

fn applied(a: &Matrix, v: &[Complex64; 4]) -> [Complex64; 4] {
    std::array::from_fn(|i| (0..4).map(|k| a[i][k] * v[k]).sum())
}

/// The exponential by its series after halving.
fn exponential(matrix: &Matrix) -> Matrix {
    let size = matrix.iter().flatten().map(|v| v.norm()).fold(0.0, f64::max);
    let halvings = (size.max(1e-3).log2().ceil() as i32 + 4).max(0);
    let small = matrix.map(|row| row.map(|v| v / 2f64.powi(halvings)));
    let mut sum = identity();
    let mut term = identity();
    for k in 1..=16 {
        term = product(&term, &small).map(|row| row.map(|v| v / f64::from(k)));
        for i in 0..4 {
            for j in 0..4 {
                sum[i][j] += term[i][j];
            }
        }
    }
    for _ in 0..halvings {
        sum = product(&sum, &sum);
    }
    sum
}

/// Gaussian elimination with pivots.
fn solved(mut a: Matrix, mut b: [Complex64; 4]) -> [Complex64; 4] {
    for k in 0..4 {
        let pivot = (k..4).max_by(|&i, &j| a[i][k].norm().total_cmp(&a[j][k].norm())).expect("rows");
        a.swap(k, pivot);
        b.swap(k, pivot);
        for i in k + 1..4 {
            let factor = a[i][k] / a[k][k];
            for j in k..4 {
                let above = a[k][j];
                a[i][j] -= factor * above;
            }
            let above = b[k];
            b[i] -= factor * above;
        }
    }
    for k in (0..4).rev() {
        let known: Complex64 = (k + 1..4).map(|j| a[k][j] * b[j]).sum();
        b[k] = (b[k] - known) / a[k][k];
    }
    b
}
