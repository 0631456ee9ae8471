//! One cell of the mean medium for one harmonic, in closed form.
//!
//! In a cell of height h with kz² = k̄² − kx² − ky² the exact difference scheme
//! (Tikhonov–Samarskii) reads o (U_{j+1} + U_{j−1}) − 2 o cos(kz h) U_j with o = kz / sin(kz h); P2
//! (3.5) has o = 1/h instead. Only decaying exponentials occur, so strongly evanescent harmonics
//! cannot overflow (as they do in P2 (2.10)).

use crate::wave::{MAX_DEGREE, Scheme};
use num_complex::Complex64;

/// Threshold of |kz h|² below which Taylor series avoid the cancellation of exponentials.
pub(super) const SMALL: f64 = 2.5e-3;

/// Node coefficients of one cell for one harmonic: coupling, and the cell's contribution to each
/// node's diagonal.
#[derive(Clone, Copy, Debug)]
pub struct NodeCoefficients {
    /// Coupling o of the cell's two nodes, 1/µm.
    pub off: Complex64,
    /// Contribution −o cos(k̄h) of the cell to each node's diagonal, 1/µm.
    pub diagonal: Complex64,
}

impl NodeCoefficients {
    /// The coefficients of a cell of height `h` (µm) for k̄² = `kz2` (1/µm²).
    pub fn new(kz2: Complex64, h: f64, scheme: Scheme) -> NodeCoefficients {
        if scheme == Scheme::SecondDifference {
            let off = Complex64::from(1.0 / h);
            return NodeCoefficients { off, diagonal: 0.5 * h * kz2 - off };
        }
        let x2 = kz2 * (h * h);
        if x2.norm() < SMALL {
            let off = 1.0 / (h * sinc_series(x2));
            return NodeCoefficients { off, diagonal: -off * cosine_series(x2) };
        }
        let ikz = Complex64::I * decaying_root(kz2);
        NodeCoefficients::of_step(ikz, (ikz * h).exp())
    }

    /// The coefficients from ikz and e^{ikz h}.
    pub(crate) fn of_step(ikz: Complex64, step: Complex64) -> NodeCoefficients {
        Self::of_scale(ikz, step, 1.0 / (1.0 - step * step))
    }

    /// The coefficients from ikz, e = e^{ikz h} and 1/(1 − e²).
    fn of_scale(ikz: Complex64, step: Complex64, scale: Complex64) -> NodeCoefficients {
        let scale = ikz * scale;
        // kz/sin(kz h) = −2ikz e/(1 − e²), −kz cot(kz h) = ikz (1 + e²)/(1 − e²)
        NodeCoefficients { off: -2.0 * step * scale, diagonal: (step * step + 1.0) * scale }
    }
}

/// Exponents ikz h Δt of the wave between neighbours among the ends and the inner `points` of a
/// cell. These are symmetric, so that at most two differ.
pub(super) fn increments(kz2: Complex64, h: f64, points: &[f64]) -> [Complex64; 2] {
    let ikz = Complex64::I * decaying_root(kz2);
    let first = points.first().copied().unwrap_or(1.0);
    let second = points.get(1).map_or(0.0, |second| second - first);
    [first, second].map(|step| ikz * (h * step))
}

/// Coefficients of one cell for one harmonic, all from two exponentials, those of the
/// [`increments`]: the nodes' coefficients, and the first node's basis function at the inner
/// `points` (see [`left_share`]).
pub(super) fn cell_factors(
    kz2: Complex64,
    h: f64,
    points: &[f64],
    scheme: Scheme,
    steps: [Complex64; 2],
) -> (NodeCoefficients, [Complex64; MAX_DEGREE]) {
    let mut shares = [Complex64::default(); MAX_DEGREE];
    if scheme == Scheme::SecondDifference || (kz2 * (h * h)).norm_sqr() < SMALL * SMALL {
        points.iter().zip(&mut shares).for_each(|(&t, share)| *share = left_share(kz2, h, t, scheme));
        return (NodeCoefficients::new(kz2, h, scheme), shares);
    }
    let ikz = Complex64::I * decaying_root(kz2);
    // e^{ikz h t} at the inner points: increments repeat from both ends.
    let mut waves = [Complex64::ONE; MAX_DEGREE + 1];
    let count = points.len();
    for q in 0..=count {
        let before = if q == 0 { Complex64::ONE } else { waves[q - 1] };
        waves[q] = before * steps[q.min(count - q)];
    }
    let step = waves[count];
    let scale = 1.0 / (1.0 - step * step);
    for q in 0..count {
        let rest = waves[count - 1 - q];
        shares[q] = waves[q] * (1.0 - rest * rest) * scale;
    }
    (NodeCoefficients::of_scale(ikz, step, scale), shares)
}

/// Basis function of the left node in the mean medium at the fraction t of a cell: sin(kz h
/// (1−t))/sin(kz h).
pub fn left_share(kz2: Complex64, h: f64, t: f64, scheme: Scheme) -> Complex64 {
    let s = 1.0 - t;
    if scheme == Scheme::SecondDifference {
        return s.into();
    }
    let x2 = kz2 * (h * h);
    if x2.norm() < SMALL {
        return s * sinc_series(x2 * (s * s)) / sinc_series(x2);
    }
    let ikz = Complex64::I * decaying_root(kz2);
    (ikz * (h * t)).exp() * (1.0 - (ikz * (2.0 * h * s)).exp()) / (1.0 - (ikz * (2.0 * h)).exp())
}

/// Series of sin x / x in x²; the first omitted term is below 1e-16 for |x| ≤ 0.05.
fn sinc_series(x2: Complex64) -> Complex64 {
    1.0 - x2 / 6.0 * (1.0 - x2 / 20.0 * (1.0 - x2 / 42.0 * (1.0 - x2 / 72.0)))
}

fn cosine_series(x2: Complex64) -> Complex64 {
    1.0 - x2 / 2.0 * (1.0 - x2 / 12.0 * (1.0 - x2 / 30.0 * (1.0 - x2 / 56.0)))
}

/// Root √z with Im ≥ 0, so that e^{i√z s} decays or stays bounded for s > 0. Without the
/// trigonometric functions of the general one: every harmonic of every cell has such a root.
pub fn decaying_root(z: Complex64) -> Complex64 {
    if z.im == 0.0 {
        let size = z.re.abs().sqrt();
        return if z.re < 0.0 { Complex64::new(0.0, size) } else { size.into() };
    }
    // √((|z| + |Re z|)/2), and the other part from Re √z · Im √z = Im z / 2
    let square = z.norm_sqr();
    let modulus = if square > 1e-280 { square.sqrt() } else { z.norm() };
    let larger = (0.5 * (modulus + z.re.abs())).sqrt();
    let other = 0.5 * z.im / larger;
    match (z.re < 0.0, z.im < 0.0) {
        (true, _) => Complex64::new(other, larger),
        (false, false) => Complex64::new(larger, other),
        (false, true) => Complex64::new(-larger, -other),
    }
}
