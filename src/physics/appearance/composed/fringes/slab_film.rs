//! The mean wave in a layer of m slabs of one medium, as in a film: amplitudes of the front slab,
//! of m − 2 inner ones and of the back slab.
//!
//! Known are amplitudes in the directions that were solved. In between, their differences from
//! those of plane faces of the even medium (Fresnel) are polynomials.
//!
//! Slabs are solved between half-spaces of a real index n. Where the medium absorbs, its own index
//! N is complex, and the amplitudes hold the steps from N to n, which in the layer are not there:
//! for the coherent light, a step from n to N behind the front slab and one from N to n in front of
//! the back slab undo them, and t of inner slabs is taken between half-spaces of N.

use super::film_matrix::{FilmMatrix, plane};
use super::{FAINT, Interference, Lobes, MeanField, MeanWave, known_sines, passive};
use crate::appearance::composed::flux::{Coherent, Hemisphere};
use num_complex::Complex64;
use std::f64::consts::TAU;

/// Amplitudes of the slabs of a layer at one wavelength.
#[derive(Clone, Debug)]
pub struct CoherentFilm {
    /// Of the front slab, of an inner one, and of the back slab.
    pub slabs: [Coherent; 3],
    /// Media in front, within and behind.
    pub media: [Hemisphere; 3],
    /// Permittivity N² of the even medium within, with what it absorbs.
    pub permittivity: Complex64,
    /// Thickness of a slab, µm.
    pub slab_um: f64,
    /// Vacuum wavelength, µm.
    pub wavelength_um: f64,
    /// Whether one of the known directions, halfway, is left out of the polynomials between them:
    /// what that changes is more than what they are off.
    pub fewer_directions: bool,
}

/// One direction of one polarisation: what varies slowly with the angle.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Slow {
    /// r of the front slab.
    pub(super) front: Complex64,
    /// t t′ of the front slab, r′ from inside and r_b of the back slab, less the phase of the even
    /// medium.
    pub(super) through: Complex64,
    pub(super) inside: Complex64,
    pub(super) behind: Complex64,
    /// Logarithm of an inner slab's amplitude, less that of the even medium.
    pub(super) slab: Complex64,
    /// √(T T_b) of the front and the back slab.
    pub(super) passed: f64,
}

impl Slow {
    /// This and a multiple of another.
    pub(super) fn plus(self, by: f64, other: &Self) -> Self {
        Self {
            front: self.front + by * other.front,
            through: self.through + by * other.through,
            inside: self.inside + by * other.inside,
            behind: self.behind + by * other.behind,
            slab: self.slab + by * other.slab,
            passed: self.passed + by * other.passed,
        }
    }
}

impl CoherentFilm {
    /// The layer turned over: for light from behind.
    pub fn turned(&self) -> Self {
        let turned = |[a, b]: &Coherent| [b.clone(), a.clone()];
        let [front, inner, back] = &self.slabs;
        let [before, within, behind] = self.media.clone();
        Self { slabs: [turned(back), turned(inner), turned(front)], media: [behind, within, before], ..*self }
    }

    /// A layer of this many slabs, 2 or more and not always whole, whose R and T at 0° and at all
    /// nodes are composed as `composed`.
    pub fn interference(&self, count: f64, polarisation: usize, composed: &[Lobes]) -> Interference<'_> {
        let sines = known_sines(&self.media[0]);
        let solve = |(direction, sine): (usize, &f64)| self.solved(direction, polarisation, *sine);
        let mut solved: Vec<Slow> = sines.iter().enumerate().map(solve).collect();
        unwrap(&mut solved);
        let incoherent =
            |(sine, slow): (&f64, &Slow)| passive(self.incoherent(count, polarisation, *sine, slow));
        let fields: Vec<Lobes> = sines.iter().zip(&solved).map(incoherent).collect();
        let even = |(sine, slow): (&f64, &Slow)| slow.plus(-1.0, &self.even(*sine, polarisation));
        let beyond = sines.iter().zip(&solved).map(even).collect();
        let wave = MeanWave::Slabs { film: self, count, beyond };
        let mut interference = Interference::new(wave, &self.media[0], polarisation, &fields, composed);
        interference.trapped = self.trapped(count, polarisation, composed);
        if self.fewer_directions {
            interference.leave_out(sines.len() / 2);
        }
        interference
    }

    /// k_z in the even medium, 1/µm.
    fn phase_per_um(&self, sine: f64) -> f64 {
        let index = self.media[1].ordinates.index;
        TAU / self.wavelength_um * (index * index - sine * sine).max(0.0).sqrt()
    }

    /// What was solved.
    fn solved(&self, direction: usize, polarisation: usize, sine: f64) -> Slow {
        let amplitude =
            |slab: usize, side: usize, lobe: usize| self.slabs[slab][side][direction][polarisation][lobe];
        let once = Complex64::from_polar(1.0, -self.phase_per_um(sine) * self.slab_um);
        let twice = once * once;
        Slow {
            front: amplitude(0, 0, 0),
            through: amplitude(0, 0, 1) * amplitude(0, 1, 1) * twice,
            inside: amplitude(0, 1, 0) * twice,
            behind: amplitude(2, 0, 0) * twice,
            slab: logarithm(amplitude(1, 0, 1) * once),
            passed: amplitude(0, 0, 1).norm() * amplitude(2, 0, 1).norm(),
        }
    }

    /// The even medium between plane faces.
    fn even(&self, sine: f64, polarisation: usize) -> Slow {
        let before = self.media[0].ordinates.index;
        let within = self.media[1].ordinates.index;
        let behind = self.media[2].ordinates.index;
        let front = face(sine, polarisation, before, within);
        let back = face(sine, polarisation, within, behind);
        let passes = |r: Complex64| (1.0 - r.norm_sqr()).max(0.0).sqrt();
        Slow {
            front,
            through: 1.0 - front * front,
            inside: -front,
            behind: back,
            slab: Complex64::ZERO,
            passed: passes(front) * passes(back),
        }
    }

    /// Fringes over the hemisphere in a layer of `count` slabs: 0 where light between the surfaces
    /// is too faint for any.
    pub(super) fn fringes(&self, at_normal: &Slow, count: f64) -> f64 {
        if (at_normal.slab.re * 2.0 * (count - 2.0)).exp() < FAINT {
            return 0.0;
        }
        let normal = self.phase_per_um(0.0);
        let grazing = self.phase_per_um(self.media[0].ordinates.edge());
        2.0 * (normal - grazing) * self.slab_um * count / TAU
    }

    /// What varies slowly, in a direction between those that are known, with their weights.
    pub(super) fn between(&self, beyond: &[Slow], weights: &[f64], polarisation: usize, sine: f64) -> Slow {
        let mut slow = self.even(sine, polarisation);
        for (weight, beyond) in weights.iter().zip(beyond) {
            slow = slow.plus(*weight, beyond);
        }
        // In between, noise of few realisations must not let a slab pass more than in any known
        // direction: many slabs raise that to their power.
        let clearest = beyond.iter().map(|slow| slow.slab.re).fold(f64::NEG_INFINITY, f64::max);
        slow.slab.re = slow.slab.re.min(clearest.min(0.0));
        slow
    }

    /// The mean field in a layer of `count` slabs, without interference as composing has it.
    pub(super) fn film(&self, count: f64, polarisation: usize, sine: f64, slow: &Slow) -> MeanField {
        let coherent = self.coherent(count, sine, &self.in_own_medium(polarisation, sine, slow));
        let incoherent = self.incoherent(count, polarisation, sine, slow);
        MeanField { coherent: passive(coherent), incoherent: passive(incoherent) }
    }

    /// R and T of a layer of `count` slabs with interference between its surfaces.
    fn coherent(&self, count: f64, sine: f64, slow: &Slow) -> Lobes {
        let inner = count - 2.0;
        let depth = self.phase_per_um(sine) * self.slab_um;
        let passed = (slow.slab * (2.0 * inner)).exp();
        // both ways through the back slab and the inner ones, then through the front one
        let to_back = Complex64::from_polar(1.0, 2.0 * depth * (inner + 1.0)) * passed * slow.behind;
        let front_depth = Complex64::from_polar(1.0, 2.0 * depth);
        let rho = slow.inside * front_depth * to_back;
        let back = slow.through * front_depth * to_back;
        Lobes {
            reflected: (slow.front + back / (1.0 - rho)).norm_sqr(),
            transmitted: slow.passed.powi(2) * passed.norm_sqr().sqrt() / (1.0 - rho).norm_sqr(),
        }
    }

    /// R and T of a layer of `count` slabs, as composing has them: of slabs between the half-spaces
    /// of their solves, which mirror the steps to these.
    fn incoherent(&self, count: f64, polarisation: usize, sine: f64, slow: &Slow) -> Lobes {
        let at_front = slow.through.norm_sqr().sqrt();
        let front =
            FilmMatrix { reflected: [slow.front.norm_sqr(), slow.inside.norm_sqr()], transmitted: at_front };
        let step = self.step(polarisation, sine);
        let through = self.way(sine) * slow.slab.exp();
        let inner = FilmMatrix {
            reflected: [even_slab(step, through).norm_sqr(); 2],
            transmitted: through.norm_sqr(),
        };
        let back = FilmMatrix {
            reflected: [slow.behind.norm_sqr(), 0.0],
            transmitted: slow.passed.powi(2) / at_front.max(FAINT),
        };
        let whole = front.then(inner.repeated(count - 2.0)).then(back);
        Lobes { reflected: whole.reflected[0], transmitted: whole.transmitted }
    }

    /// Phase of one way through a slab of the half-spaces' index.
    fn way(&self, sine: f64) -> Complex64 {
        Complex64::from_polar(1.0, self.phase_per_um(sine) * self.slab_um)
    }

    /// What a step from the half-spaces of the solves to the medium's own index mirrors; 0 where it
    /// does not absorb.
    fn step(&self, polarisation: usize, sine: f64) -> Complex64 {
        if self.permittivity.im == 0.0 {
            return Complex64::ZERO;
        }
        let index = self.media[1].ordinates.index;
        plane(index.into(), self.permittivity.sqrt(), sine, polarisation).reflected[0]
    }

    /// The amplitudes between half-spaces of the medium's own index within the layer.
    fn in_own_medium(&self, polarisation: usize, sine: f64, slow: &Slow) -> Slow {
        let step = self.step(polarisation, sine);
        if step == Complex64::ZERO {
            return *slow;
        }
        let once = self.way(sine);
        let twice = once * once;
        let passes = 1.0 - step * step;
        let [inside, behind] = [slow.inside, slow.behind].map(|reflected| reflected * twice);
        let [at_front, at_back] = [inside, behind].map(|reflected| 1.0 / (1.0 - reflected * step));
        let through = once * slow.slab.exp();
        let own = own_passage(step, through);
        Slow {
            front: slow.front + slow.through * twice * step * at_front,
            through: slow.through * passes * at_front * at_front,
            inside: (passes * inside * at_front - step) / twice,
            behind: (passes * behind * at_back - step) / twice,
            slab: slow.slab + own.ln(),
            passed: slow.passed * (passes * at_front * at_back).norm(),
        }
    }
}

/// What a slab with this t between half-spaces mirrors, both of whose faces have this step.
pub(super) fn even_slab(step: Complex64, through: Complex64) -> Complex64 {
    let own = through * own_passage(step, through);
    step * (1.0 - own * own) / (1.0 - step * step * own * own)
}

/// t of a slab between half-spaces of its own medium over the `through` that it has between
/// half-spaces to which both of its faces have this step: P/t of t = (1 − ρ²) P/(1 − ρ² P²).
pub(super) fn own_passage(step: Complex64, through: Complex64) -> Complex64 {
    let steps = step * step;
    let passes = 1.0 - steps;
    2.0 / (passes + (passes * passes + 4.0 * steps * through * through).sqrt())
}

/// Amplitude that a plane face between two indices reflects of s light (and of the scalar wave), or
/// of p light (1), whose amplitude is that of the magnetic field.
fn face(sine: f64, polarisation: usize, from: f64, to: f64) -> Complex64 {
    let admittance = |index: f64| {
        let normal = Complex64::from(index * index - sine * sine).sqrt();
        if polarisation == 0 { normal } else { normal / (index * index) }
    };
    let a = admittance(from);
    let b = admittance(to);
    if a + b != Complex64::ZERO { (a - b) / (a + b) } else { Complex64::ZERO }
}

/// A logarithm that is finite for slabs through which no coherent light is seen.
pub(super) fn logarithm(amplitude: Complex64) -> Complex64 {
    if amplitude.norm() > FAINT { amplitude.ln() } else { FAINT.ln().into() }
}

/// Takes jumps of 2π out of the logarithms along the angle, which are interpolated.
pub(super) fn unwrap(rising_angles: &mut [Slow]) {
    for k in 1..rising_angles.len() {
        let turns = (rising_angles[k].slab.im - rising_angles[k - 1].slab.im) / TAU;
        rising_angles[k].slab.im -= TAU * turns.round();
    }
}
