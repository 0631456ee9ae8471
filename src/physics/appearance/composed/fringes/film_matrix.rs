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
//! Of n elements that are alike, the products are doubled: of the whole ones, as a part of one is a
//! film of its own. Of powers, each R and T, with ρ + 1/ρ = (1 + R² − T²)/R and e = T/(1 − ρ R) (G.
//! Stokes, Proc. R. Soc. 11 (1862) 545), for any real n:
//!
//! ```text
//! R_n = ρ (1 − e²ⁿ)/(1 − ρ² e²ⁿ)      T_n = eⁿ (1 − ρ²)/(1 − ρ² e²ⁿ)
//! ```
//!
//! Slabs that were solved between half-spaces of another index than their own mirror the steps to
//! these, which cancel between neighbours: the product of amplitudes knows that, and that of powers
//! has what composing makes of them.

use super::FAINT;
use crate::appearance::composed::plate::in_a_row;
use num_complex::Complex64;
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

    /// Seen from the other side.
    pub(super) fn turned(self) -> Self {
        let [front, behind] = self.reflected;
        Self { reflected: [behind, front], ..self }
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

impl FilmMatrix<Complex64> {
    /// Nothing: all light passes.
    pub(super) const NONE: Self = Self { reflected: [Complex64::ZERO; 2], transmitted: Complex64::ONE };

    /// `count` of these one behind another: the whole ones, and behind them the part of one that is
    /// left, which `part` gives. A root of the product would jump along the angle where noise in
    /// what slabs mirror has a band of its own, near half waves.
    pub(super) fn repeated(self, count: f64, part: impl Fn(f64) -> Self) -> Self {
        if count == 1.0 {
            return self;
        }
        let all = in_a_row(Self::NONE, self, count as usize, |all, power| all.then(*power));
        if count.fract() > 0.0 { all.then(part(count.fract())) } else { all }
    }
}

/// Loss of an element, and what it mirrors, below which there is nothing to compose but the rest.
const LOSSLESS: f64 = 1e-12;

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
    let reflected = if a + b != Complex64::ZERO { (a - b) / (a + b) } else { Complex64::ZERO };
    FilmMatrix { reflected: [reflected, -reflected], transmitted: (1.0 - reflected * reflected).sqrt() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// An even film between other media, cut into slabs that were each solved between these: the
    /// steps to them cancel, and n slabs are the film. *Planted*: their mirroring left out; the
    /// part of a slab left out.
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
                    faces[0].then(way).then(faces[1])
                };
                for count in [1.0, 4.0, 6.5, 300.0] {
                    let whole = film(0.4 * count);
                    let found = film(0.4).repeated(count, |part| film(0.4 * part));
                    let apart = (found.reflected[0] - whole.reflected[0]).norm()
                        + (found.transmitted - whole.transmitted).norm();
                    assert!(apart < 1e-9, "{polarisation} {sine} {count}: {found:?} {whole:?}");
                }
            }
        }
    }

    /// What slabs and a part of one do goes on smoothly over the angle, also near half waves, where
    /// noise in what they mirror has a band of its own. *Planted*: a root of the product in place
    /// of doubled products (the amplitude jumped by 0.3).
    #[test]
    fn noise_near_half_waves_makes_no_jumps() {
        let (outside, index) = (Complex64::from(1.5), Complex64::new(1.47, 1e-4));
        let slab = |sine: f64, part: f64| {
            let phase = Complex64::I * TAU / 0.45 * normal(index, sine) * 0.34 * part;
            let way = FilmMatrix { reflected: [Complex64::ZERO; 2], transmitted: phase.exp() };
            let film = plane(outside, index, sine, 0).then(way).then(plane(index, outside, sine, 0));
            let noise = part * 0.03 * Complex64::from_polar(1.0, phase.im);
            FilmMatrix { reflected: film.reflected.map(|r| r + noise), ..film }
        };
        let passed = |k: i32| {
            let sine = 0.9 * f64::from(k) / 2000.0;
            slab(sine, 1.0).repeated(6.4, |part| slab(sine, part)).transmitted
        };
        for k in 1..=2000 {
            let apart = (passed(k) - passed(k - 1)).norm();
            // the step of the angle: half of it moves the amplitude by half as much
            assert!(apart < 0.02, "{k}: {apart}");
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
