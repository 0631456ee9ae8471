//! One element of a layer in the known directions of a zone beyond the critical angle, and between
//! them.

use super::super::film_matrix::FilmMatrix;
use super::super::slab_film::logarithm;
use super::super::stack_film::Mirrors;
use super::even_slab::{EvenOf, EvenSlab, KnownSlab, normal, plane};
use super::{TrappedLight, TrappedSlab};
use crate::appearance::composed::ordinates::DirectionZone;
use num_complex::Complex64;
use std::f64::consts::TAU;

/// Amplitude that a far face mirrors much with.
const MUCH: f64 = 0.4;

/// What composing makes of an element in which light decays.
pub(super) const TURNED_BACK: FilmMatrix<f64> = FilmMatrix { reflected: [1.0; 2], transmitted: 0.0 };

/// An element in the known directions of a zone.
#[derive(Clone, Debug)]
pub(super) enum TrappedElement {
    Solved {
        film: EvenSlab,
        count: f64,
        is_last: bool,
        known: Vec<KnownSlab>,
    },
    /// Permittivities of the media, and those of the faces of fluxes.
    Face {
        squared: [Complex64; 2],
        composed: [Complex64; 2],
    },
    Even {
        squared: Complex64,
        thickness_um: f64,
    },
}

impl TrappedElement {
    /// A slab in the known directions of a zone; `None` where a direction is not known.
    pub(super) fn of_slab(
        slab: &TrappedSlab,
        light: TrappedLight,
        zone: &DirectionZone,
        is_last: bool,
        before: Option<&Self>,
    ) -> Option<Self> {
        let &TrappedSlab { between, index, thickness_um, mirrors, count, .. } = slab;
        let polarisation = light.polarisation;
        let wavenumber = TAU / light.wavelength_um;
        let neighbours = before.filter(|_| is_last).and_then(|before| before.alike(index));
        let film = EvenSlab { between, index, thickness_um, mirrors, polarisation, wavenumber };
        let amplitude = |side: usize, direction: usize, lobe: usize| -> Option<Complex64> {
            Some(slab.amplitudes[side].get(direction)?.get(polarisation)?[lobe])
        };
        let measured = |direction: usize| -> Option<Complex64> {
            if is_last { amplitude(0, direction, 0) } else { slab.passed(direction, polarisation) }
        };
        // What an even film of that index mirrors. Where that is much, the slab differs from it by
        // a factor, whose phase costs no light; else by a difference, without a root to divide by.
        let is_factor = neighbours.is_some_and(|known| {
            let mirrored = |k: usize| film.solved(known[k].squared, light.ordinates.sines[zone.first + k]);
            (0..zone.count).all(|k| mirrored(k).reflected[0].norm() > MUCH)
        });
        let mut known = Vec::new();
        let mut turned = 0.0;
        // From 0° outwards, so that logarithms do not jump between directions; what a far face
        // mirrors of p light has a root on the way.
        let first = if is_last { zone.first + 1 } else { 0 };
        for direction in first..=zone.first + zone.count {
            let sine = if direction == 0 { 0.0 } else { light.ordinates.sines[direction - 1] };
            let value = measured(direction)?;
            if direction <= zone.first {
                turned = film.logarithm(value, Complex64::ZERO, sine, is_last, turned).im;
                continue;
            }
            let mut own = match neighbours {
                Some(known) => EvenOf::neighbour(&known[direction - zone.first - 1]),
                None => film.even_of(value, sine, is_last, turned),
            };
            turned = own.turned;
            own.known.solved = if is_last {
                [value.norm_sqr(), 0.0, 0.0]
            } else {
                let [front, behind] = [amplitude(0, direction, 0)?, amplitude(1, direction, 0)?];
                [front.norm_sqr(), behind.norm_sqr(), value.norm_sqr()]
            };
            let sides = match neighbours {
                _ if !is_last => 0..2,
                Some(_) if !is_factor => 0..1,
                _ => 0..0,
            };
            let even = film.solved(own.known.squared, sine);
            if is_factor {
                own.known.further = logarithm(value / even.reflected[0]);
            }
            let phases = film.depths(own.known.squared, sine);
            for side in sides {
                let difference = amplitude(side, direction, 0)? - even.reflected[side];
                own.known.reflected[side] = difference * phases[side].conj();
            }
            known.push(own.known);
        }
        Some(Self::Solved { film, count, is_last, known })
    }

    /// A slab whose directions in a zone were not solved, or decay in it: an even film of the index
    /// N that it has at 0°, where its faces hide least of it.
    pub(super) fn beyond_solves(
        slab: &TrappedSlab,
        light: TrappedLight,
        zone: &DirectionZone,
        is_last: bool,
    ) -> Self {
        let &TrappedSlab { between, index, thickness_um, mirrors, count, .. } = slab;
        let wavenumber = TAU / light.wavelength_um;
        let film =
            EvenSlab { between, index, thickness_um, mirrors, polarisation: light.polarisation, wavenumber };
        let squared = match slab.passed(0, light.polarisation) {
            Some(passed) => film.even_of(passed, 0.0, false, 0.0).known.squared,
            None => Complex64::ZERO,
        };
        let known = light.ordinates.sines[zone.first..zone.first + zone.count].iter().map(|&sine| {
            let [front, behind] = between.map(|index| index > sine);
            let FilmMatrix { reflected, transmitted } = film.solved(squared, sine).powers();
            let turned_back = if front { reflected[0].min(1.0) } else { 1.0 };
            let solved = if front && behind && !is_last {
                [reflected[0], reflected[1], transmitted]
            } else {
                [turned_back, 1.0, 0.0]
            };
            KnownSlab { squared, solved, ..KnownSlab::default() }
        });
        Self::Solved { film, count, is_last, known: known.collect() }
    }

    /// Whether a wave goes on behind it: where it only decays, composing turns all of it back.
    pub(super) fn passes(&self, sine: f64) -> bool {
        match self {
            Self::Solved { film, is_last, .. } => {
                film.index > sine && (*is_last || film.between.iter().all(|index| *index > sine))
            }
            Self::Face { composed: [_, behind], .. } => behind.re > sine * sine,
            Self::Even { squared, .. } => squared.re > sine * sine,
        }
    }

    /// Whether a wave goes on in front of it and behind.
    pub(super) fn goes_on(&self, sine: f64) -> bool {
        let in_front = match self {
            Self::Face { composed: [before, _], .. } => before.re > sine * sine,
            _ => true,
        };
        in_front && self.passes(sine)
    }

    /// What is known of a slab of this index that light passes.
    fn alike(&self, index: f64) -> Option<&[KnownSlab]> {
        match self {
            Self::Solved { film, known, is_last: false, .. } if film.index == index => Some(known),
            _ => None,
        }
    }

    /// At a lateral wavenumber; `weights` are those of the known directions.
    pub(super) fn at(
        &self,
        weights: &[f64],
        sine: f64,
        polarisation: usize,
        wavenumber: f64,
    ) -> FilmMatrix<Complex64> {
        let (film, count, is_last, known) = match self {
            Self::Solved { film, count, is_last, known } => (film, *count, *is_last, known),
            Self::Face { squared: [before, behind], .. } => {
                return plane(*before, *behind, sine, polarisation);
            }
            Self::Even { squared, thickness_um } => {
                let way = (Complex64::I * wavenumber * normal(*squared, sine) * thickness_um).exp();
                return FilmMatrix { reflected: [Complex64::ZERO; 2], transmitted: way };
            }
        };
        let mut here = KnownSlab::default();
        for (weight, known) in weights.iter().zip(known) {
            here.squared += weight * known.squared;
            here.further += weight * known.further;
            (0..2).for_each(|side| here.reflected[side] += weight * known.reflected[side]);
        }
        // In between, noise of few realisations must not let a slab pass more than in any known
        // direction: many slabs raise that to their power.
        let clearest = known.iter().map(|known| known.squared.im).fold(f64::INFINITY, f64::min);
        here.squared.im = here.squared.im.max(clearest.max(0.0));
        let most = known.iter().map(|known| known.further.re).fold(f64::NEG_INFINITY, f64::max);
        here.further.re = here.further.re.min(most);
        if film.mirrors == Mirrors::Nowhere {
            let once = film.phase(here.squared, sine) + here.further;
            return FilmMatrix { reflected: [Complex64::ZERO; 2], transmitted: (once * count).exp() };
        }
        if is_last {
            let even = film.within(here.squared, sine);
            let phases = film.depths(here.squared, sine);
            let turned = even.reflected[0] * here.further.exp() + here.reflected[0] * phases[0];
            // Noise between the directions must not make more light than there is; of a wave that
            // decays towards it, an element may well mirror more than arrives.
            let most = if film.between[0] > sine { 1.0 } else { f64::INFINITY };
            let turned = turned / (turned.norm() / most).max(1.0);
            return FilmMatrix { reflected: [turned, Complex64::ZERO], transmitted: Complex64::ZERO };
        }
        let slab = |part: f64| film.part(&here, part, sine);
        slab(1.0).repeated(count, slab)
    }

    /// What composing makes of it at a lateral wavenumber, where its amplitudes are these: of faces
    /// those between real indices.
    pub(super) fn powers(
        &self,
        amplitudes: FilmMatrix<Complex64>,
        sine: f64,
        polarisation: usize,
    ) -> FilmMatrix<f64> {
        match self {
            Self::Face { composed: [before, behind], .. } => {
                plane(*before, *behind, sine, polarisation).powers()
            }
            _ => amplitudes.powers(),
        }
    }

    /// Powers in a known direction.
    pub(super) fn solved(
        &self,
        direction: usize,
        sine: f64,
        polarisation: usize,
        wavenumber: f64,
    ) -> FilmMatrix<f64> {
        match self {
            Self::Solved { film, count, known, .. } => {
                let [front, behind, passed] = known[direction].solved;
                let mut reflected = [front, behind];
                if film.mirrors == Mirrors::Nowhere {
                    // the steps to the half-spaces, without what noise of few realisations mirrors
                    let even = film.solved(known[direction].squared, sine).powers();
                    (0..2).for_each(|side| reflected[side] = reflected[side].min(even.reflected[side]));
                }
                FilmMatrix { reflected, transmitted: passed }.repeated(*count)
            }
            plain if plain.passes(sine) => {
                let amplitudes = plain.at(&[], sine, polarisation, wavenumber);
                plain.powers(amplitudes, sine, polarisation)
            }
            _ => TURNED_BACK,
        }
    }

    /// Square of its real index, and its thickness, µm.
    pub(super) fn depth(&self) -> (Complex64, f64) {
        match self {
            Self::Solved { film, count, .. } => ((film.index * film.index).into(), film.thickness_um * count),
            Self::Face { .. } => (Complex64::ONE, 0.0),
            Self::Even { squared, thickness_um } => (*squared, *thickness_um),
        }
    }
}
