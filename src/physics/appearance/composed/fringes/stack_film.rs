//! The mean wave through a stack of elements as through a film: star products of amplitudes,
//! direction by direction.
//!
//! The products are in `film_matrix`.
//!
//! Between the directions that were solved, polynomials give what an element differs by from an
//! even film of its thickness: the logarithm of t, and r and r′ less those of that film, with the
//! phase of the depth at which the wave is reflected taken off.

use super::film_matrix::{FilmMatrix, normal, plane};
use super::slab_film::{even_slab, logarithm, own_passage};
use super::{FAINT, Lobes, MeanField, passive};
use crate::appearance::composed::flux::{Coherent, Hemisphere};
use num_complex::Complex64;
use std::f64::consts::TAU;

/// One element of a stack as the mean wave meets it, at one wavelength.
#[derive(Clone, Debug)]
pub enum FilmElement {
    /// A slab or a whole layer that was solved between two half-spaces.
    Solved(SolvedElement),
    /// A plane face between two media.
    Face(FilmFace),
    /// An even medium on both of whose sides nothing changes.
    Even {
        /// Its index.
        index: Complex64,
        /// Its thickness, µm.
        thickness_um: f64,
    },
}

/// A plane face between two media.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilmFace {
    /// Their indices.
    pub indices: [Complex64; 2],
    /// Their real indices, between which the fluxes of the face are composed.
    pub composed: [f64; 2],
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
    /// Permittivity of that medium, with what it absorbs.
    pub permittivity: Complex64,
    /// Its thickness, µm.
    pub thickness_um: f64,
    /// Where it mirrors the mean wave.
    pub mirrors: Mirrors,
    /// How many of it stand one behind another, a part of one included.
    pub count: f64,
    /// Whether the part is in front: as the light meets a layer that was turned over.
    pub part_first: bool,
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

impl FilmFace {
    /// Between media that do not absorb.
    pub fn clear(composed: [f64; 2]) -> Self {
        Self { indices: composed.map(Complex64::from), composed }
    }

    /// Seen from behind.
    fn turned(self) -> Self {
        let ([a, b], [c, d]) = (self.indices, self.composed);
        Self { indices: [b, a], composed: [d, c] }
    }
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
                    part_first: !solved.part_first,
                    ..solved.clone()
                })
            }
            Self::Face(face) => Self::Face(face.turned()),
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
        let even = self.even_film(solved, 1.0, polarisation, sine, Complex64::ZERO).transmitted;
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
        let even = self.even_film(solved, 1.0, polarisation, sine, passed);
        let phases = self.depths(solved, 1.0, sine, passed);
        let reflected = [0, 1].map(|side| {
            let difference = solved.amplitudes[side][d][polarisation][0] - even.reflected[side];
            difference * phases[side].conj()
        });
        Beyond { passed, reflected }
    }

    /// Phase of both ways to the depth at which the wave is mirrored, from either side, in this
    /// part of an element.
    fn depths(&self, solved: &SolvedElement, part: f64, sine: f64, passed: Complex64) -> [Complex64; 2] {
        let once = self.phase(solved.index.into(), part * solved.thickness_um, sine).re + passed.im;
        let depth = solved.mirrors.depth();
        [depth, 1.0 - depth].map(|side| Complex64::from_polar(1.0, 2.0 * side * once))
    }

    /// The even film of this part of an element, whose wave changes by exp(`passed`) besides on
    /// each way through it.
    fn even_film(
        &self,
        solved: &SolvedElement,
        part: f64,
        polarisation: usize,
        sine: f64,
        passed: Complex64,
    ) -> FilmMatrix<Complex64> {
        let phase = self.phase(solved.index.into(), part * solved.thickness_um, sine);
        let way = (Complex64::I * phase + passed).exp();
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
    pub(super) fn element(
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
            FilmElement::Face(FilmFace { indices: [before, behind], composed }) => {
                let [in_front, beyond] = composed.map(Complex64::from);
                let powers = plane(in_front, beyond, sine, polarisation).powers();
                return (plane(*before, *behind, sine, polarisation), powers);
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
        // from the half-spaces of its solve to its own medium, which may absorb
        let step = plane(solved.index.into(), solved.permittivity.sqrt(), sine, polarisation);
        let slab = |part: f64| self.slab(solved, here, part, polarisation, sine);
        match solved.mirrors {
            Mirrors::Nowhere => {
                let once = Complex64::I * self.phase(solved.index.into(), solved.thickness_um, sine);
                let way = once + here.passed;
                let through = way.exp();
                let own = way + own_passage(step.reflected[0], through).ln();
                let transmitted = (own * solved.count).exp();
                let mirrored = even_slab(step.reflected[0], through).norm_sqr();
                let as_solved = FilmMatrix { reflected: [mirrored; 2], transmitted: through.norm_sqr() };
                let within = FilmMatrix { reflected: [Complex64::ZERO; 2], transmitted };
                (within, as_solved.repeated(solved.count))
            }
            Mirrors::InFront => {
                let one = slab(1.0);
                (one.then(step), one.powers())
            }
            Mirrors::Behind => {
                let one = slab(1.0);
                (step.turned().then(one), one.powers())
            }
            Mirrors::OnBothSides => {
                let one = slab(1.0);
                let all = match solved.part_first {
                    true => one.turned().repeated(solved.count, |part| slab(part).turned()).turned(),
                    false => one.repeated(solved.count, slab),
                };
                (all, one.powers().repeated(solved.count))
            }
        }
    }

    /// This part of an element that differs so from an even film.
    fn slab(
        &self,
        solved: &SolvedElement,
        beyond: Beyond,
        part: f64,
        polarisation: usize,
        sine: f64,
    ) -> FilmMatrix<Complex64> {
        let passed = part * beyond.passed;
        let even = self.even_film(solved, part, polarisation, sine, passed);
        // the film's own t holds what goes to and fro in it: so do both here and in `passed`
        let straight = self.even_film(solved, part, polarisation, sine, Complex64::ZERO);
        let phases = self.depths(solved, part, sine, passed);
        let mirrored = |side: usize| even.reflected[side] + part * beyond.reflected[side] * phases[side];
        FilmMatrix { reflected: [0, 1].map(mirrored), transmitted: straight.transmitted * passed.exp() }
    }

    /// The mean field of the whole stack at a lateral wavenumber.
    pub(super) fn field(
        &self,
        beyond: &[Vec<Beyond>],
        weights: &[f64],
        polarisation: usize,
        sine: f64,
    ) -> StackField {
        let mut whole = FilmMatrix::NONE;
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

/// Takes jumps of 2π out of logarithms along the angle.
fn unwrap(rising_angles: &mut [Complex64]) {
    for k in 1..rising_angles.len() {
        let turns = (rising_angles[k].im - rising_angles[k - 1].im) / TAU;
        rising_angles[k].im -= TAU * turns.round();
    }
}
