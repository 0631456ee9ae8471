//! Green function of one cell between moments, in closed form.
//!
//! A field in a cell is represented by two moments e_q = 2∫ψ_q E dt with the Lagrange functions ψ₁,
//! ψ₂ of the two Gauss points t = ½ ∓ 1/(2√3), and a source is J(t) = J₁ψ₁ + J₂ψ₂. With x = kz h, y
//! = x/2, sums v₊ = v₁ + v₂ and differences v₋ = v₂ − v₁, mirror symmetry reduces all moments of
//! the cell's Dirichlet Green function g, of its derivatives and of the node functions sin
//! x(1−t)/sin x to two functions of x²:
//!
//! b = (tan y / y − 1)/x²    (BD₊: ∫∫ψgψ on sums)      c = (3(1 − y cot y)/y² − 1)/x²    (BD₋: on
//! differences)
//!
//! since ψ₊ = 1, ψ₋ = √3(2t−1) are polynomials and each derivative can be shifted onto them: ∂z g:
//! −2√3 b from sums to differences, 0 back; ∂z∂z'g − δ: −1 on sums, 12b − 1 on differences; node
//! functions l₊ = 1 + x²b, l₋ = −(1 + x²c)/√3; their derivatives l'₊ = −2, l'₋ = −2√3 x²b.

use crate::wave::Scheme;
use crate::wave::operator::cell::{NodeCoefficients, decaying_root};
use num_complex::Complex64;
use std::f64::consts::PI;
use std::sync::LazyLock;

/// Number of terms of the series; the last is below 1e-17 where the series are used.
const TERMS: usize = 18;
/// Threshold of |x|² below which the series are used: the closed form of b loses 12/|x|² ulp to
/// cancellation, that of c 720/|x|⁴.
const SERIES_B: f64 = 1.0;
const SERIES_C: f64 = 4.0;

/// The two functions b and c of a cell for one harmonic.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CellFunctions {
    /// Moments of the Dirichlet Green function on sums.
    pub b: Complex64,
    /// Moments of the Dirichlet Green function on differences.
    pub c: Complex64,
}

/// [`CellFunctions`] and the coefficients of the exact difference scheme for a cell of height `h`
/// (µm) and kz² in 1/µm², given the wave's `step` e^{ikz h} across it: for both one exponential.
pub fn cell_functions(kz2: Complex64, h: f64, step: Complex64) -> (CellFunctions, NodeCoefficients) {
    let x2 = kz2 * (h * h);
    if x2.norm_sqr() < SERIES_B * SERIES_B {
        return (CellFunctions::new(x2), NodeCoefficients::new(kz2, h, Scheme::Quadratic));
    }
    let ikz = Complex64::I * decaying_root(kz2);
    (CellFunctions::of_step(x2, -Complex64::I * ikz * h, step), NodeCoefficients::of_step(ikz, step))
}

impl CellFunctions {
    /// The functions of x² = kz² h²; real x² must be below π², where the cell resonates.
    pub fn new(x2: Complex64) -> CellFunctions {
        if x2.norm_sqr() < SERIES_B * SERIES_B {
            return CellFunctions { b: series(&B, x2), c: series(&C, x2) };
        }
        let x = decaying_root(x2);
        CellFunctions::of_step(x2, x, (Complex64::I * x).exp())
    }

    /// The functions from x and e^{ix} with Im x ≥ 0, |x²| ≥ [`SERIES_B`]: tan y from the
    /// exponential, which never overflows.
    fn of_step(x2: Complex64, x: Complex64, step: Complex64) -> CellFunctions {
        let tangent = Complex64::I * (1.0 - step) / (1.0 + step);
        let y = 0.5 * x;
        let inverse = 1.0 / x2;
        let b = (tangent / y - 1.0) * inverse;
        let closed = || (12.0 * inverse * (1.0 - y / tangent) - 1.0) * inverse;
        let c = if x2.norm_sqr() < SERIES_C * SERIES_C { series(&C, x2) } else { closed() };
        CellFunctions { b, c }
    }
}

/// Series b = Σ 2(4ⁿ−1)ζ(2n)/(π²ⁿ 4ⁿ⁻¹) x^{2n−4}, n ≥ 2, from that of tan y.
static B: LazyLock<[f64; TERMS]> = LazyLock::new(|| {
    let order = std::array::from_fn(|i| i as i32 + 2);
    order.map(|n| 2.0 * (4f64.powi(n) - 1.0) * zeta(2 * n) / PI.powi(2 * n) / 4f64.powi(n - 1))
});

/// Series of c from y cot y = 1 − 2Σζ(2n)(y/π)²ⁿ: 3(1 − y cot y)/y² = 6Σζ(2n) y^{2n−2}/π²ⁿ, in
/// powers of x².
static C: LazyLock<[f64; TERMS]> = LazyLock::new(|| {
    let order = std::array::from_fn(|i| i as i32 + 2);
    order.map(|n| 6.0 * zeta(2 * n) / PI.powi(2 * n) / 4f64.powi(n - 1))
});

fn series(terms: &[f64; TERMS], x2: Complex64) -> Complex64 {
    terms.iter().rev().fold(Complex64::default(), |sum, &t| sum * x2 + t)
}

/// Riemann's ζ(s) for s ≥ 4: the sum to 200, and the integral with Euler–Maclaurin's first
/// correction for the rest.
fn zeta(s: i32) -> f64 {
    let last = 200f64;
    let head: f64 = (1..200).rev().map(|k| f64::from(k).powi(-s)).sum();
    let tail = last.powi(1 - s) / f64::from(s - 1) + 0.5 * last.powi(-s);
    head + tail + f64::from(s) / 12.0 * last.powi(-s - 1)
}

#[cfg(test)]
#[path = "cell_tests.rs"]
mod tests;
