//! Amplitudes of elements that stand one behind another, and of many that are alike.
//!
//! An element between two half-spaces has amplitudes r, r′ and t, scaled to the roots of fluxes, so
//! that t is the same from both sides. Of an element A in front of B, with q = 1/(1 − r′_A r_B),
//!
//! ```text
//! r = r_A + t_A² r_B q      r′ = r′_B + t_B² r′_A q      t = t_A t_B q
//! ```
//!
//! and the composition without interference has the squares of all moduli in their places (R.
//! Redheffer, J. Math. Phys. 41 (1962) 1). The product goes over the whole stack: what the mean
//! wave does in one layer depends on the faces of all others.
//!
//! Of n elements that are alike, each with amplitudes r and t, with ρ + 1/ρ = (1 + r² − t²)/r and
//! e = t/(1 − ρ r) (G. Stokes, Proc. R. Soc. 11 (1862) 545):
//!
//! ```text
//! r_n = ρ (1 − e²ⁿ)/(1 − ρ² e²ⁿ)      t_n = eⁿ (1 − ρ²)/(1 − ρ² e²ⁿ)
//! ```
//!
//! Slabs that were solved between half-spaces of another index than their own mirror the steps to
//! these, which cancel between neighbours: the product of amplitudes knows that, and that of powers
//! has what composing makes of them.

use super::FAINT;
use super::slab_film::logarithm;
use num_complex::Complex64;
use std::f64::consts::TAU;
use std::ops::{Add, Mul};

/// Amplitudes of an element: r, r′ and t; or their squared moduli.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FilmMatrix<T> {
    pub(super) reflected: [T; 2],
    pub(super) transmitted: T,
}

impl<T: Copy + Add<Output = T> + Mul<Output = T>> FilmMatrix<T> {
    /// This in front of `behind`, with q of light that goes back and forth between them.
    fn joined(self, behind: Self, q: T) -> Self {
        let passed = self.transmitted * self.transmitted;
        let passed_behind = behind.transmitted * behind.transmitted;
        Self {
            reflected: [
                self.reflected[0] + passed * behind.reflected[0] * q,
                behind.reflected[1] + passed_behind * self.reflected[1] * q,
            ],
            transmitted: self.transmitted * behind.transmitted * q,
        }
    }
}

impl FilmMatrix<Complex64> {
    pub(super) fn then(self, behind: Self) -> Self {
        self.joined(behind, 1.0 / (1.0 - self.reflected[1] * behind.reflected[0]))
    }

    pub(super) fn powers(self) -> FilmMatrix<f64> {
        FilmMatrix {
            reflected: self.reflected.map(|r| r.norm_sqr()),
            transmitted: self.transmitted.norm_sqr(),
        }
    }
}

impl FilmMatrix<f64> {
    pub(super) fn then(self, behind: Self) -> Self {
        self.joined(behind, 1.0 / (1.0 - self.reflected[1] * behind.reflected[0]).max(FAINT))
    }
}

/// Loss of an element, and what it mirrors, below which there is nothing to compose but the rest.
const LOSSLESS: f64 = 1e-12;

impl FilmMatrix<Complex64> {
    /// `count` of these one behind another, a part of one included; `way` is what tells between the
    /// logarithms of a part.
    pub(super) fn repeated(self, count: f64, way: Complex64) -> Self {
        if count == 1.0 {
            return self;
        }
        let mirrored = 0.5 * (self.reflected[0] + self.reflected[1]);
        let own = eigenwave(mirrored, self.transmitted);
        let mut log = logarithm(self.transmitted / (1.0 - own * mirrored));
        log.im += TAU * ((way.im - log.im) / TAU).round();
        let onward = (log * count).exp();
        let back = onward * onward;
        let divisor = 1.0 - own * own * back;
        Self {
            reflected: [own * (1.0 - back) / divisor; 2],
            transmitted: onward * (1.0 - own * own) / divisor,
        }
    }
}

/// The amplitude ρ that a half-space of such elements mirrors: the root within the unit circle, the
/// reciprocal of the other one, which has the same digits where elements mirror little.
fn eigenwave(mirrored: Complex64, transmitted: Complex64) -> Complex64 {
    if mirrored.norm() < LOSSLESS {
        return Complex64::ZERO;
    }
    let half = (1.0 + mirrored * mirrored - transmitted * transmitted) / (2.0 * mirrored);
    let root = (half * half - 1.0).sqrt();
    let [one, other] = [half - root, half + root];
    1.0 / if one.norm() > other.norm() { one } else { other }
}

impl FilmMatrix<f64> {
    /// `count` of these one behind another without interference.
    pub(super) fn repeated(self, count: f64) -> Self {
        if count == 1.0 {
            return self;
        }
        let mirrored = 0.5 * (self.reflected[0] + self.reflected[1]);
        let passed = self.transmitted;
        if mirrored < LOSSLESS {
            return Self { reflected: [0.0; 2], transmitted: passed.powf(count) };
        }
        if 1.0 - mirrored - passed < LOSSLESS {
            let transmitted = passed / (passed + count * mirrored);
            return Self { reflected: [1.0 - transmitted; 2], transmitted };
        }
        let half = (1.0 + mirrored * mirrored - passed * passed) / (2.0 * mirrored);
        let own = 1.0 / (half + (half * half - 1.0).max(0.0).sqrt());
        let onward = (passed / (1.0 - own * mirrored)).powf(count);
        let back = onward * onward;
        let divisor = 1.0 - own * own * back;
        Self {
            reflected: [own * (1.0 - back) / divisor; 2],
            transmitted: onward * (1.0 - own * own) / divisor,
        }
    }
}

/// n cos θ in a medium: decaying or going on.
pub(super) fn normal(index: Complex64, sine: f64) -> Complex64 {
    let root = (index * index - sine * sine).sqrt();
    if root.im < 0.0 { -root } else { root }
}

/// A plane face between two media, of s light (and of the scalar wave) or of p light (1), whose
/// amplitude is that of the magnetic field.
pub(super) fn plane(
    before: Complex64,
    behind: Complex64,
    sine: f64,
    polarisation: usize,
) -> FilmMatrix<Complex64> {
    let admittance = |index: Complex64| {
        if polarisation == 0 { normal(index, sine) } else { normal(index, sine) / (index * index) }
    };
    let (a, b) = (admittance(before), admittance(behind));
    let reflected = if (a + b).norm() > 0.0 { (a - b) / (a + b) } else { Complex64::ZERO };
    FilmMatrix { reflected: [reflected, -reflected], transmitted: (1.0 - reflected * reflected).sqrt() }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An even film between other media, cut into slabs that were each solved between these: the
    /// steps to them cancel, and n slabs are the film. *Planted*: their mirroring left out.
    #[test]
    fn slabs_with_steps_are_the_film_of_their_thickness() {
        let (outside, index) = (Complex64::from(1.558), Complex64::new(1.47, 0.004));
        for polarisation in [0, 1] {
            for sine in [0.0, 0.7, 1.3] {
                let film = |um: f64| {
                    let phase = Complex64::I * TAU / 0.5 * normal(index, sine) * um;
                    let way = FilmMatrix { reflected: [Complex64::ZERO; 2], transmitted: phase.exp() };
                    let faces = [
                        plane(outside, index, sine, polarisation),
                        plane(index, outside, sine, polarisation),
                    ];
                    (faces[0].then(way).then(faces[1]), phase)
                };
                let (slab, way) = film(0.4);
                for count in [1.0, 4.0, 6.5, 300.0] {
                    let (whole, _) = film(0.4 * count);
                    let found = slab.repeated(count, way);
                    let apart = (found.reflected[0] - whole.reflected[0]).norm()
                        + (found.transmitted - whole.transmitted).norm();
                    assert!(apart < 1e-9, "{polarisation} {sine} {count}: {found:?} {whole:?}");
                }
            }
        }
    }

    /// Powers of slabs as composing makes them; of slabs without loss, too.
    #[test]
    fn powers_are_those_of_slabs_one_behind_another() {
        for (mirrored, transmitted) in [(0.01, 0.9), (0.3, 0.7), (0.0, 0.8), (0.05, 0.95)] {
            let slab = FilmMatrix { reflected: [mirrored; 2], transmitted };
            let three = slab.then(slab).then(slab);
            let found = slab.repeated(3.0);
            assert!((found.reflected[0] - three.reflected[0]).abs() < 1e-10, "{found:?} {three:?}");
            assert!((found.transmitted - three.transmitted).abs() < 1e-10, "{found:?} {three:?}");
        }
    }
}
