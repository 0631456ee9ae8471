//! Absorption in the mean medium: Σ Im k̄² ∫|E|² over its cells, from the exact field in each of
//! them.
//!
//! In a cell of height h, with τ = t − ½ and a source linear in τ, every field combines four
//! functions (x = kz h):
//!
//! C = cos xτ / cos ½x     S = sin xτ / sin ½x     (C − 1)/x²: source 1     (S − 2τ)/x²: source 2τ
//!
//! TE gives E_s; TM gives h and from it E_p = (−i h' − J_p)/k̄², E_z = (−q h − J_z)/k̄². The
//! quadrature points are unrelated to the moments of [`super::cell`], so that R + T + A = 1 checks
//! both. The division by x² loses no more than rounding: |x²| ≥ Im k̄² h², and Im k̄² multiplies
//! everything.

use super::mean::{CELL_ROWS, Nodes, VectorMean};
use crate::numerics::exponential::exponentials;
use crate::wave::contrast::section::gauss_rule;
use crate::wave::{Field, decaying_root};
use num_complex::Complex64;
use rayon::prelude::*;

const I: Complex64 = Complex64::I;

/// A function of τ and its derivative.
type WithSlope = [Complex64; 2];

/// Values at a cell's nodes, and a source a + bτ with the sign of u'' + kz² u = −(a + bτ).
struct Driven {
    nodes: [Complex64; 2],
    source: [Complex64; 2],
}

/// One harmonic in a cell: q, E_s, h, and a + bτ of the components s, p, z of J.
struct Waves {
    q: f64,
    electric: Driven,
    magnetic: Driven,
    sources: [[Complex64; 2]; 3],
}

/// One cell.
struct AbsorbingCell {
    index: usize,
    height: f64,
    k2: Complex64,
}

impl VectorMean {
    /// Losses Σ Im k̄² ∫|E|² dz over harmonics in every cell, 1/µm, of the field with these node
    /// values and the source V E = −`y`.
    pub(super) fn losses(&self, y: &Field, nodes: &Nodes) -> Vec<f64> {
        let cell = |index| AbsorbingCell { index, height: self.heights[index], k2: self.mean_k2[index] };
        let cells = (0..self.heights.len()).into_par_iter();
        cells.map(|index| cell(index).loss(&self.lateral, y, nodes)).collect()
    }
}

impl AbsorbingCell {
    fn loss(&self, lateral: &[f64], y: &Field, nodes: &Nodes) -> f64 {
        if self.k2.im == 0.0 {
            return 0.0;
        }
        let intensity: f64 = lateral.iter().enumerate().map(|(i, &q)| self.intensity(i, q, y, nodes)).sum();
        self.k2.im * self.height * intensity
    }

    /// Integral ∫|E|² dt of one harmonic.
    fn intensity(&self, harmonic: usize, q: f64, y: &Field, nodes: &Nodes) -> f64 {
        let x2 = (self.k2 - q * q) * (self.height * self.height);
        let x = decaying_root(x2);
        let sources = [0, 1, 2].map(|component| self.source(harmonic, component, y));
        let [s, p, z] = sources;
        let ends = |k: usize| [0, 1].map(|side| nodes[k][[self.index + side, harmonic]]);
        let electric = Driven { nodes: ends(0), source: s };
        // h'' + kz² h = q J_z + i J_p'.
        let magnetic = Driven { nodes: ends(1), source: [-(q * z[0] + I * p[1] / self.height), -q * z[1]] };
        let waves = Waves { q, electric, magnetic, sources };
        let half: f64 =
            CellBasis::on_half(x, x2).map(|(weight, basis)| weight * self.square(&waves, &basis)).sum();
        0.5 * half
    }

    /// Mean of |E|² at ±τ of the basis: the squares of the even and of the odd part.
    fn square(&self, waves: &Waves, basis: &CellBasis) -> f64 {
        let h2 = self.height * self.height;
        let [_, p, z] = waves.sources.map(|[a, b]| [a, basis.tau * b]);
        let [e, _] = waves.electric.at(basis, h2);
        let [h, slope] = waves.magnetic.at(basis, h2);
        let part = |k: usize| {
            let along = -I * slope[k] / self.height - p[k];
            let upright = -waves.q * h[k] - z[k];
            e[k].norm_sqr() + (along.norm_sqr() + upright.norm_sqr()) / self.k2.norm_sqr()
        };
        part(0) + part(1)
    }

    /// Coefficients a and b of J = a + bτ from J = −y on both Gauss planes: ψ = ½ ∓ √3 τ.
    fn source(&self, harmonic: usize, component: usize, y: &Field) -> [Complex64; 2] {
        let row = CELL_ROWS * self.index + component;
        let first = y[[row, harmonic]];
        let second = y[[row + 3, harmonic]];
        [-0.5 * (first + second), -(3f64.sqrt()) * (second - first)]
    }
}

/// Number of nodes to integrate |e^{ixτ}|² to rounding: its Chebyshev series reaches it at degree
/// 16 + 8 √|x|.
fn points(x: Complex64) -> usize {
    (10.0 + 4.0 * x.norm().sqrt()).ceil().min(MOST_POINTS as f64) as usize
}

/// Most points of a rule.
const MOST_POINTS: usize = 60;
/// Below it, a point is the middle one.
const MIDDLE: f64 = 1e-9;

/// The four functions at one τ ≥ 0, with the parity of their names in τ; their derivatives have the
/// other.
struct CellBasis {
    tau: f64,
    even: WithSlope,
    odd: WithSlope,
    even_source: WithSlope,
    odd_source: WithSlope,
}

impl CellBasis {
    /// The basis at the points τ ≥ 0 of the rule for x, with the weights of τ and −τ on −1 … 1.
    /// Computed from decaying exponentials, so that nothing overflows.
    fn on_half(x: Complex64, x2: Complex64) -> impl Iterator<Item = (f64, CellBasis)> {
        let rule = gauss_rule(points(x)).iter().filter(|(t, _)| *t > -MIDDLE);
        let mut waves = [Complex64::ZERO; MOST_POINTS + 2];
        let mut used = 0;
        for (pair, (t, _)) in waves.chunks_exact_mut(2).zip(rule.clone()) {
            pair.copy_from_slice(&[1.0 - t, 1.0 + t].map(|t| I * x * (0.5 * t)));
            used += 2;
        }
        waves[used] = I * x;
        exponentials(&mut waves[..=used]);
        rule.enumerate().map(move |(k, &(t, weight))| {
            // the middle has no mirror image
            let both = if t < MIDDLE { weight } else { 2.0 * weight };
            (both, CellBasis::new(x, x2, 0.5 * t, [waves[2 * k], waves[2 * k + 1], waves[used]]))
        })
    }

    /// From x, x², τ and the exponentials of ix(½ − τ), ix(½ + τ) and ix.
    fn new(x: Complex64, x2: Complex64, tau: f64, [down, up, across]: [Complex64; 3]) -> CellBasis {
        let (sum, difference) = (up + down, up - down);
        let even = [sum / (1.0 + across), I * x * difference / (1.0 + across)];
        let odd = [difference / (across - 1.0), I * x * sum / (across - 1.0)];
        let even_source = [(even[0] - 1.0) / x2, even[1] / x2];
        let odd_source = [(odd[0] - 2.0 * tau) / x2, (odd[1] - 2.0) / x2];
        CellBasis { tau, even, odd, even_source, odd_source }
    }
}

impl Driven {
    /// Even and odd part in τ of the value, then those of the derivative with respect to t; `h2` is
    /// the cell's height squared.
    fn at(&self, basis: &CellBasis, h2: f64) -> [[Complex64; 2]; 2] {
        let [first, last] = self.nodes;
        let [a, b] = self.source.map(|s| h2 * s);
        let (mean, half) = (0.5 * (first + last), 0.5 * (last - first));
        let CellBasis { even, odd, even_source, odd_source, .. } = basis;
        let of_even = |k: usize| mean * even[k] + a * even_source[k];
        let of_odd = |k: usize| half * odd[k] + 0.5 * b * odd_source[k];
        [[of_even(0), of_odd(0)], [of_odd(1), of_even(1)]]
    }
}
