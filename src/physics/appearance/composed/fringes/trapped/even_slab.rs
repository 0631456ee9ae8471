//! A slab as an even film: the index of which such a film has its phase and its loss, and what is
//! left over.

use super::super::FAINT;
use super::super::film_matrix::FilmMatrix;
use super::super::slab_film::logarithm;
use super::super::stack_film::Mirrors;
use super::{FURTHEST, ROUNDS};
use num_complex::Complex64;
use std::f64::consts::TAU;

/// What is known of a slab in one direction.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct KnownSlab {
    /// N² − n².
    pub squared: Complex64,
    /// Logarithm of t over that of the even film of index N; of r, where the light is turned back.
    pub further: Complex64,
    /// r and r′ less those of that film, without the phases of their depths.
    pub reflected: [Complex64; 2],
    /// |r|², |r′|² and |t|² of the mean wave as they were solved.
    pub solved: [f64; 3],
}

/// A slab of an even medium.
#[derive(Clone, Copy, Debug)]
pub(super) struct EvenSlab {
    pub between: [f64; 2],
    pub index: f64,
    pub thickness_um: f64,
    pub mirrors: Mirrors,
    pub polarisation: usize,
    /// Vacuum wavenumber, 1/µm.
    pub wavenumber: f64,
}

/// The even film of one direction, and the imaginary part of its logarithm.
pub(super) struct EvenOf {
    pub known: KnownSlab,
    pub turned: f64,
}

impl EvenOf {
    /// That of the slab in front, whose t tells N. Of the last slab r alone is known, in which the
    /// step to its half-space may cancel what the far face mirrors.
    pub fn neighbour(before: &KnownSlab) -> Self {
        let known = KnownSlab { squared: before.squared, ..KnownSlab::default() };
        Self { known, turned: 0.0 }
    }
}

impl EvenSlab {
    /// i k_z d of one way; `further` is N² − n².
    pub fn phase(&self, further: Complex64, sine: f64) -> Complex64 {
        let squared = self.index * self.index + further;
        Complex64::I * self.wavenumber * normal(squared, sine) * self.thickness_um
    }

    /// The film between the half-spaces of its solve.
    pub fn solved(&self, further: Complex64, sine: f64) -> FilmMatrix<Complex64> {
        self.film(further, sine, [true; 2])
    }

    /// The film where it lies, with the faces at which its medium ends.
    pub fn within(&self, further: Complex64, sine: f64) -> FilmMatrix<Complex64> {
        let mirrors = self.mirrors;
        let front = matches!(mirrors, Mirrors::InFront | Mirrors::OnBothSides);
        let behind = matches!(mirrors, Mirrors::Behind | Mirrors::OnBothSides);
        self.film(further, sine, [front, behind])
    }

    /// This part of the slab where it lies, with what it differs by from an even film.
    pub fn part(&self, known: &KnownSlab, part: f64, sine: f64) -> FilmMatrix<Complex64> {
        let thinner = Self { thickness_um: part * self.thickness_um, ..*self };
        let even = thinner.within(known.squared, sine);
        let phases = thinner.depths(known.squared, sine);
        let mirrored = |side: usize| even.reflected[side] + part * known.reflected[side] * phases[side];
        FilmMatrix {
            reflected: [0, 1].map(mirrored),
            transmitted: even.transmitted * (part * known.further).exp(),
        }
    }

    fn film(&self, further: Complex64, sine: f64, faces: [bool; 2]) -> FilmMatrix<Complex64> {
        let [before, behind] = self.between.map(|index| Complex64::from(index * index));
        let squared = self.index * self.index + further;
        let transmitted = self.phase(further, sine).exp();
        let mut film = FilmMatrix { reflected: [Complex64::ZERO; 2], transmitted };
        if faces[0] {
            film = plane(before, squared, sine, self.polarisation).then(film);
        }
        if faces[1] {
            film = film.then(plane(squared, behind, sine, self.polarisation));
        }
        film
    }

    /// Phases of both ways to the depth at which the wave is mirrored, from either side.
    pub fn depths(&self, further: Complex64, sine: f64) -> [Complex64; 2] {
        let once = self.phase(further, sine).im;
        let depth = self.mirrors.depth();
        [depth, 1.0 - depth].map(|part| Complex64::from_polar(1.0, 2.0 * part * once))
    }

    /// Logarithm of what the amplitude has beyond that of the plain medium's way, and beyond what
    /// the faces of a film do: t, or r of light that is turned back. `near` is the imaginary part
    /// of the logarithm in the direction before.
    pub fn logarithm(
        &self,
        measured: Complex64,
        further: Complex64,
        sine: f64,
        is_last: bool,
        near: f64,
    ) -> Complex64 {
        let ways = if is_last { 2.0 } else { 1.0 };
        let faces = self.amplitude(further, sine, is_last) / (self.phase(further, sine) * ways).exp();
        let plain = (self.phase(Complex64::ZERO, sine) * ways).exp();
        let mut log = logarithm(measured / (faces * plain));
        log.im -= TAU * ((log.im - near) / TAU).round();
        log
    }

    /// The amplitude that tells N, of a film between the half-spaces of its solve.
    fn amplitude(&self, further: Complex64, sine: f64, is_last: bool) -> Complex64 {
        let film = self.solved(further, sine);
        if is_last { film.reflected[0] } else { film.transmitted }
    }

    /// The index N with which an even film has this amplitude.
    pub fn even_of(&self, measured: Complex64, sine: f64, is_last: bool, near: f64) -> EvenOf {
        let ways = if is_last { 2.0 } else { 1.0 };
        let plain = self.phase(Complex64::ZERO, sine);
        let real = Complex64::I * self.wavenumber * self.thickness_um;
        let first = self.logarithm(measured, Complex64::ZERO, sine, is_last, near);
        let mut log = first;
        let mut squared = Complex64::ZERO;
        for _ in 0..ROUNDS {
            let normal = (plain + log / ways) / real;
            squared = normal * normal + sine * sine - self.index * self.index;
            if !squared.is_finite() || squared.norm() >= FURTHEST {
                break;
            }
            log = self.logarithm(measured, squared, sine, is_last, log.im);
        }
        if squared.is_finite() && squared.norm() < FURTHEST {
            let left = logarithm(measured / self.amplitude(squared, sine, is_last));
            if left.norm() < left_over(first) {
                return EvenOf {
                    known: KnownSlab { squared, further: left, ..KnownSlab::default() },
                    turned: log.im,
                };
            }
        }
        let known = KnownSlab { further: first, ..KnownSlab::default() };
        EvenOf { known, turned: first.im }
    }
}

/// What may be left over of a logarithm: less than there was.
fn left_over(first: Complex64) -> f64 {
    0.1 * first.norm() + FAINT
}

/// n cos θ in a medium of this squared index: going on, or decaying.
pub(super) fn normal(squared: Complex64, sine: f64) -> Complex64 {
    let root = (squared - sine * sine).sqrt();
    // of a medium that amplifies, as noise may have it, the one that goes on
    if root.im < 0.0 && root.re < -root.im { -root } else { root }
}

/// A plane face between media of these squared indices, of s light (and of the scalar wave) or of p
/// light (1), whose amplitude is that of the magnetic field.
pub(super) fn plane(
    before: Complex64,
    behind: Complex64,
    sine: f64,
    polarisation: usize,
) -> FilmMatrix<Complex64> {
    let admittance = |squared: Complex64| {
        if polarisation == 0 { normal(squared, sine) } else { normal(squared, sine) / squared }
    };
    let a = admittance(before);
    let b = admittance(behind);
    let reflected = if a + b != Complex64::ZERO { (a - b) / (a + b) } else { Complex64::ZERO };
    FilmMatrix { reflected: [reflected, -reflected], transmitted: (1.0 - reflected * reflected).sqrt() }
}
