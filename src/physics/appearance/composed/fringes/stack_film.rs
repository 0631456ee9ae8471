//! The mean wave through a stack of elements as through a film: star products of amplitudes,
//! direction by direction.
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
//!
//! Between the directions that were solved, polynomials give what an element differs by from an
//! even film of its thickness: the logarithm of t, and r and r′ less those of that film, with the
//! phase of the depth at which the wave is reflected taken off.

use super::slab_film::logarithm;
use super::{FAINT, Lobes, MeanField, passive};
use crate::appearance::composed::flux::{Coherent, Hemisphere};
use num_complex::Complex64;
use std::f64::consts::TAU;
use std::ops::{Add, Mul};

/// One element of a stack as the mean wave meets it, at one wavelength.
#[derive(Clone, Debug)]
pub enum FilmElement {
    /// A slab or a whole layer that was solved between two half-spaces.
    Solved(SolvedElement),
    /// A plane face between two media.
    Face([Complex64; 2]),
    /// An even medium on both of whose sides nothing changes.
    Even {
        /// Its index.
        index: Complex64,
        /// Its thickness, µm.
        thickness_um: f64,
    },
}

/// What the solves of a slab say of the mean wave.
#[derive(Clone, Debug)]
pub struct SolvedElement {
    /// Its mean amplitudes.
    pub amplitudes: Coherent,
    /// Real indices of the half-spaces in front and behind.
    pub between: [f64; 2],
    /// Real index of the even medium that it is compared with.
    pub index: f64,
    /// Its thickness, µm.
    pub thickness_um: f64,
    /// Where it mirrors the mean wave.
    pub mirrors: Mirrors,
    /// How many of it stand one behind another, a part of one included.
    pub count: f64,
}

/// The faces of an element at which its medium ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mirrors {
    /// None: the medium goes on on both sides, in half-spaces of its own index.
    Nowhere,
    /// The front one.
    InFront,
    /// The back one.
    Behind,
    /// Both.
    OnBothSides,
}

impl Mirrors {
    /// Seen from the front, the depth at which the wave is mirrored, as a part of the thickness:
    /// with faces on both sides half of it, from which either phase is the least.
    pub(super) fn depth(self) -> f64 {
        match self {
            Self::InFront => 0.0,
            Self::Nowhere | Self::OnBothSides => 0.5,
            Self::Behind => 1.0,
        }
    }

    /// Of the element turned over.
    fn turned(self) -> Self {
        match self {
            Self::InFront => Self::Behind,
            Self::Behind => Self::InFront,
            other => other,
        }
    }
}

/// The mean wave in a stack at one wavelength.
#[derive(Clone, Debug)]
pub struct StackFilm {
    /// Its elements, in the order of the light.
    pub elements: Vec<FilmElement>,
    /// Media in front and behind.
    pub media: [Hemisphere; 2],
    /// Vacuum wavelength, µm.
    pub wavelength_um: f64,
    /// Whether one of the known directions is left out of the polynomials between them.
    pub fewer_directions: bool,
}

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

/// The amplitude ρ that a half-space of such elements mirrors: the root within the unit circle.
fn eigenwave(mirrored: Complex64, transmitted: Complex64) -> Complex64 {
    if mirrored.norm() < LOSSLESS {
        return Complex64::ZERO;
    }
    let half = (1.0 + mirrored * mirrored - transmitted * transmitted) / (2.0 * mirrored);
    let root = (half * half - 1.0).sqrt();
    let [one, other] = [half - root, half + root];
    if one.norm() <= other.norm() { one } else { other }
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
        let own = half - (half * half - 1.0).max(0.0).sqrt();
        let onward = (passed / (1.0 - own * mirrored)).powf(count);
        let back = onward * onward;
        let divisor = 1.0 - own * own * back;
        Self {
            reflected: [own * (1.0 - back) / divisor; 2],
            transmitted: onward * (1.0 - own * own) / divisor,
        }
    }
}

/// What an element differs by from an even film, in one direction.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Beyond {
    /// Logarithm of t over that of the film.
    passed: Complex64,
    /// r and r′ less those of the film, without the phases of their depths.
    reflected: [Complex64; 2],
}

/// The mean field of a stack, and its first element's \[R, T\].
#[derive(Clone, Copy, Debug)]
pub(super) struct StackField {
    pub mean: MeanField,
    pub front: [f64; 2],
}

impl FilmElement {
    /// The element turned over.
    fn turned(&self) -> Self {
        match self {
            Self::Solved(solved) => {
                let [a, b] = solved.amplitudes.clone();
                let [before, behind] = solved.between;
                Self::Solved(SolvedElement {
                    amplitudes: [b, a],
                    between: [behind, before],
                    mirrors: solved.mirrors.turned(),
                    ..solved.clone()
                })
            }
            Self::Face([before, behind]) => Self::Face([*behind, *before]),
            even => even.clone(),
        }
    }

    /// Its index within and its thickness, µm.
    pub(in crate::appearance::composed) fn depth(&self) -> (Complex64, f64) {
        match self {
            Self::Solved(solved) => (solved.index.into(), solved.thickness_um * solved.count),
            Self::Face(_) => (Complex64::ONE, 0.0),
            Self::Even { index, thickness_um } => (*index, *thickness_um),
        }
    }
}

impl StackFilm {
    /// The stack turned over: for light from behind.
    pub fn turned(&self) -> Self {
        let [before, behind] = self.media.clone();
        let elements = self.elements.iter().rev().map(FilmElement::turned).collect();
        Self { elements, media: [behind, before], ..*self }
    }

    /// k_z times the thickness.
    fn phase(&self, index: Complex64, thickness_um: f64, sine: f64) -> Complex64 {
        TAU / self.wavelength_um * normal(index, sine) * thickness_um
    }

    /// What every element differs by from an even film, in every known direction:
    /// \[element\]\[direction\].
    pub(super) fn beyond(&self, sines: &[f64], polarisation: usize) -> Vec<Vec<Beyond>> {
        let of_element = |element: &FilmElement| {
            let FilmElement::Solved(solved) = element else { return vec![Beyond::default(); sines.len()] };
            let mut passed: Vec<Complex64> =
                (0..sines.len()).map(|d| self.passed(solved, d, polarisation, sines[d])).collect();
            unwrap(&mut passed);
            let directions = passed.into_iter().zip(sines).enumerate();
            directions.map(|(d, (passed, s))| self.difference(solved, d, polarisation, *s, passed)).collect()
        };
        self.elements.iter().map(of_element).collect()
    }

    /// Logarithm of an element's t over that of the even film.
    fn passed(&self, solved: &SolvedElement, d: usize, polarisation: usize, sine: f64) -> Complex64 {
        let [onward, back] = [0, 1].map(|side| solved.amplitudes[side][d][polarisation][1]);
        let root = (onward * back).sqrt();
        // the root that is the amplitude, not less it
        let amplitude = if (root.conj() * onward).re < 0.0 { -root } else { root };
        let even = self.even_film(solved, polarisation, sine, Complex64::ZERO).transmitted;
        logarithm(amplitude / even)
    }

    fn difference(
        &self,
        solved: &SolvedElement,
        d: usize,
        polarisation: usize,
        sine: f64,
        passed: Complex64,
    ) -> Beyond {
        let even = self.even_film(solved, polarisation, sine, passed);
        let phases = self.depths(solved, sine, passed);
        let reflected = [0, 1].map(|side| {
            let difference = solved.amplitudes[side][d][polarisation][0] - even.reflected[side];
            difference * phases[side].conj()
        });
        Beyond { passed, reflected }
    }

    /// Phase of both ways to the depth at which the wave is mirrored, from either side.
    fn depths(&self, solved: &SolvedElement, sine: f64, passed: Complex64) -> [Complex64; 2] {
        let once = self.phase(solved.index.into(), solved.thickness_um, sine).re + passed.im;
        let depth = solved.mirrors.depth();
        [depth, 1.0 - depth].map(|part| Complex64::from_polar(1.0, 2.0 * part * once))
    }

    /// The even film, whose wave changes by exp(`passed`) besides on each way through it.
    fn even_film(
        &self,
        solved: &SolvedElement,
        polarisation: usize,
        sine: f64,
        passed: Complex64,
    ) -> FilmMatrix<Complex64> {
        let way = (Complex64::I * self.phase(solved.index.into(), solved.thickness_um, sine) + passed).exp();
        let through = FilmMatrix { reflected: [Complex64::ZERO; 2], transmitted: way };
        if solved.mirrors == Mirrors::Nowhere {
            return through;
        }
        let [before, behind] = solved.between.map(Complex64::from);
        let index = solved.index.into();
        let front = plane(before, index, sine, polarisation);
        front.then(through).then(plane(index, behind, sine, polarisation))
    }

    /// An element at a lateral wavenumber as waves and as powers; `weights` are those of the known
    /// directions.
    fn element(
        &self,
        element: &FilmElement,
        beyond: &[Beyond],
        weights: &[f64],
        polarisation: usize,
        sine: f64,
    ) -> (FilmMatrix<Complex64>, FilmMatrix<f64>) {
        let alone = |matrix: FilmMatrix<Complex64>| (matrix, matrix.powers());
        let solved = match element {
            FilmElement::Solved(solved) => solved,
            FilmElement::Face([before, behind]) => {
                return alone(plane(*before, *behind, sine, polarisation));
            }
            FilmElement::Even { index, thickness_um } => {
                let transmitted = (Complex64::I * self.phase(*index, *thickness_um, sine)).exp();
                return alone(FilmMatrix { reflected: [Complex64::ZERO; 2], transmitted });
            }
        };
        let mut here = Beyond::default();
        for (weight, known) in weights.iter().zip(beyond) {
            here.passed += weight * known.passed;
            (0..2).for_each(|side| here.reflected[side] += weight * known.reflected[side]);
        }
        // In between, noise of few realisations must not let a slab pass more than in any known
        // direction: many slabs raise that to their power.
        let clearest = beyond.iter().map(|known| known.passed.re).fold(f64::NEG_INFINITY, f64::max);
        here.passed.re = here.passed.re.min(clearest);
        if solved.mirrors == Mirrors::Nowhere {
            let once = Complex64::I * self.phase(solved.index.into(), solved.thickness_um, sine);
            let transmitted = ((once + here.passed) * solved.count).exp();
            return alone(FilmMatrix { reflected: [Complex64::ZERO; 2], transmitted });
        }
        let even = self.even_film(solved, polarisation, sine, here.passed);
        // the film's own t holds what goes to and fro in it: so do both here and in `passed`
        let straight = self.even_film(solved, polarisation, sine, Complex64::ZERO);
        let phases = self.depths(solved, sine, here.passed);
        let one = FilmMatrix {
            reflected: [0, 1].map(|side| even.reflected[side] + here.reflected[side] * phases[side]),
            transmitted: straight.transmitted * here.passed.exp(),
        };
        let way = Complex64::I * self.phase(solved.index.into(), solved.thickness_um, sine) + here.passed;
        (one.repeated(solved.count, way), one.powers().repeated(solved.count))
    }

    /// The mean field of the whole stack at a lateral wavenumber.
    pub(super) fn field(
        &self,
        beyond: &[Vec<Beyond>],
        weights: &[f64],
        polarisation: usize,
        sine: f64,
    ) -> StackField {
        let mut whole = FilmMatrix { reflected: [Complex64::ZERO; 2], transmitted: Complex64::ONE };
        let mut powers = whole.powers();
        let mut front = None;
        for (element, beyond) in self.elements.iter().zip(beyond) {
            let (next, next_powers) = self.element(element, beyond, weights, polarisation, sine);
            front = front.or(Some([next_powers.reflected[0], next_powers.transmitted]));
            whole = whole.then(next);
            powers = powers.then(next_powers);
        }
        let lobes =
            |of: FilmMatrix<f64>| passive(Lobes { reflected: of.reflected[0], transmitted: of.transmitted });
        let mean = MeanField { coherent: lobes(whole.powers()), incoherent: lobes(powers) };
        StackField { mean, front: front.unwrap_or([0.0, 1.0]) }
    }

    /// Fringes over the hemisphere, of as many elements as coherent light goes through and back.
    pub(super) fn fringes(&self, beyond: &[Vec<Beyond>], polarisation: usize) -> f64 {
        let edge = self.media[0].ordinates.edge();
        let mut seen = 1.0;
        let mut fringes = 0.0;
        for (element, beyond) in self.elements.iter().zip(beyond) {
            let (index, thickness_um) = element.depth();
            let phases = [0.0, edge].map(|sine| self.phase(index, thickness_um, sine).re);
            fringes += 2.0 * (phases[0] - phases[1]) / TAU;
            let only = [1.0];
            let (at_normal, _) = self.element(element, &beyond[..1], &only, polarisation, 0.0);
            seen *= at_normal.transmitted.norm_sqr();
            if seen < FAINT {
                break;
            }
        }
        fringes
    }
}

/// n cos θ in a medium: decaying or going on.
fn normal(index: Complex64, sine: f64) -> Complex64 {
    let root = (index * index - sine * sine).sqrt();
    if root.im < 0.0 { -root } else { root }
}

/// A plane face between two media, of s light (and of the scalar wave) or of p light (1), whose
/// amplitude is that of the magnetic field.
fn plane(before: Complex64, behind: Complex64, sine: f64, polarisation: usize) -> FilmMatrix<Complex64> {
    let admittance = |index: Complex64| {
        if polarisation == 0 { normal(index, sine) } else { normal(index, sine) / (index * index) }
    };
    let (a, b) = (admittance(before), admittance(behind));
    let reflected = if (a + b).norm() > 0.0 { (a - b) / (a + b) } else { Complex64::ZERO };
    FilmMatrix { reflected: [reflected, -reflected], transmitted: (1.0 - reflected * reflected).sqrt() }
}

/// Takes jumps of 2π out of logarithms along the angle.
fn unwrap(rising_angles: &mut [Complex64]) {
    for k in 1..rising_angles.len() {
        let turns = (rising_angles[k].im - rising_angles[k - 1].im) / TAU;
        rising_angles[k].im -= TAU * turns.round();
    }
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
