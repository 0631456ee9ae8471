//! Fringes of weak layers: the coherent light between the two surfaces, which composing fluxes
//! treats as if it did not interfere with itself.
//!
//! The mean field goes through a layer of m slabs as through a film: with amplitudes r, t of the
//! front (r′, t′ from inside), r_b of the back, and P of all inner slabs,
//!
//! ```text
//! ρ = r′ P² r_b      T_c/T_i = (1 − |ρ|²)/|1 − ρ|²
//! R_c = |r + t t′ P² r_b/(1 − ρ)|²      R_i = |r|² + |t t′ P² r_b|²/(1 − |ρ|²)
//! ```
//!
//! where c is the film and i its incoherent composition, the mean of c over all phases of ρ. Of
//! what the field loses by scattering and absorption, L = 1 − R − T, composing reflects a share s_R
//! and transmits s_T: R = R_i + s_R L_i. With interference R = R_c + s_R L_c, and T alike, so R + T
//! + A stays 1 exactly.
//!
//! Known are amplitudes and shares at 0° and at the nodes of light that passes both surfaces. In
//! between, shares and the differences of the amplitudes from those of plane faces of the even
//! medium (Fresnel) are polynomials; a medium that is even has no such differences. P = p^(m − 2)
//! with the amplitude p of an inner slab, for any real m: thicknesses between whole slabs have
//! their own fringes.
//!
//! Light from a dense medium beyond the edge, which cannot leave on the other side, has zones of
//! its own, in `trapped`.
//!
//! In a stack of layers the mean field is that of [`stack_film`], and the rest is the same.

mod film_matrix;
mod lobes;
mod slab_film;
pub mod stack_film;
mod stack_losses;
mod trapped;

pub use lobes::Lobes;
pub use slab_film::CoherentFilm;

use self::slab_film::Slow;
use self::stack_film::{Beyond, StackFilm};
use self::trapped::TrappedZone;
use super::flux::Hemisphere;
use super::ordinates::gauss_legendre;
use crate::numerics::interpolate::lagrange;
use std::sync::OnceLock;

/// Nodes of the mean over the hemisphere in each of its pieces, and the least number of pieces.
const PIECE: usize = 8;
const PIECES: usize = 16;
/// Layers with more fringes over the hemisphere have the mean over all phases: what is left of the
/// fringes is of the amplitude over 2π times their number, below 1e-4.
const MOST_FRINGES: f64 = 200.0;
/// Of fainter light between the surfaces, there are no fringes.
const FAINT: f64 = 1e-9;
/// Below this nothing is lost that could be shared.
const NOTHING: f64 = 1e-9;

/// The mean field at one angle, with and without interference.
#[derive(Clone, Copy, Debug)]
struct MeanField {
    coherent: Lobes,
    incoherent: Lobes,
}

/// What interference does in a layer of one thickness to light of one polarisation that comes from
/// in front.
#[derive(Clone, Debug)]
pub struct Interference<'a> {
    wave: MeanWave<'a>,
    /// Medium in front.
    before: &'a Hemisphere,
    polarisation: usize,
    /// Places of the known directions, cosines of their angles in air: 0°, then the nodes.
    places: Vec<f64>,
    /// Shares of the loss there that composing reflects and transmits.
    shares: Vec<Lobes>,
    /// R and T there without interference.
    incoherent: Vec<Lobes>,
    /// Zones whose light cannot leave on the other side.
    trapped: Vec<TrappedZone>,
}

/// The mean wave, and what it differs by from that in even media in the known directions.
#[derive(Clone, Debug)]
enum MeanWave<'a> {
    /// In a layer of three kinds of slabs, of a thickness in slabs.
    Slabs { film: &'a CoherentFilm, count: f64, beyond: Vec<Slow> },
    /// In a stack: \[element\]\[direction\].
    Stack { film: &'a StackFilm, beyond: Vec<Vec<Beyond>> },
}

/// What is known in one direction.
#[derive(Clone, Copy, Debug)]
struct KnownField {
    mean: MeanField,
    /// R and T of the first slab, which is in front of all nodes.
    front: f64,
    through: f64,
    /// Shares of the mean field's loss that composing reflects and transmits.
    shares: Lobes,
}

impl StackFilm {
    /// The stack, whose R and T at 0° and at all nodes are composed as `composed`.
    pub fn interference(&self, polarisation: usize, composed: &[Lobes]) -> Interference<'_> {
        let sines = known_sines(&self.media[0]);
        let beyond = self.beyond(&sines, polarisation);
        let incoherent = |(direction, sine): (usize, &f64)| {
            let weights: Vec<f64> = (0..sines.len()).map(|d| f64::from(u8::from(d == direction))).collect();
            self.field(&beyond, &weights, polarisation, *sine).mean.incoherent
        };
        let fields: Vec<Lobes> = sines.iter().enumerate().map(incoherent).collect();
        let wave = MeanWave::Stack { film: self, beyond };
        let mut interference = Interference::new(wave, &self.media[0], polarisation, &fields, composed);
        interference.trapped = self.trapped(polarisation, composed);
        if self.fewer_directions {
            interference.leave_out(sines.len() / 2);
        }
        interference
    }
}

/// Lateral wavenumbers of 0° and of the nodes from which light reaches air.
fn known_sines(before: &Hemisphere) -> Vec<f64> {
    let ordinates = &before.ordinates;
    [0.0].into_iter().chain(ordinates.sines[..ordinates.escaping()].iter().copied()).collect()
}

/// Cosine in air of light of this lateral wavenumber.
fn place(before: &Hemisphere, sine: f64) -> f64 {
    let edge = before.ordinates.edge();
    (edge * edge - sine * sine).max(0.0).sqrt()
}

impl<'a> Interference<'a> {
    /// From the mean wave, and R and T in the known directions: the field's own without
    /// interference, and the composed ones.
    fn new(
        wave: MeanWave<'a>,
        before: &'a Hemisphere,
        polarisation: usize,
        fields: &[Lobes],
        composed: &[Lobes],
    ) -> Self {
        let places = known_sines(before).iter().map(|sine| place(before, *sine)).collect();
        let shares: Vec<Lobes> = fields.iter().zip(composed).map(|(f, c)| shares(*f, *c)).collect();
        let incoherent = fields.iter().zip(&shares).map(|(field, shares)| field.with_loss(*shares)).collect();
        Self { wave, before, polarisation, places, shares, incoherent, trapped: Vec::new() }
    }

    /// Leaves one of the known directions out of the polynomials.
    fn leave_out(&mut self, direction: usize) {
        self.places.remove(direction);
        self.shares.remove(direction);
        match &mut self.wave {
            MeanWave::Slabs { beyond, .. } => _ = beyond.remove(direction),
            MeanWave::Stack { beyond, .. } => {
                beyond.iter_mut().for_each(|known| _ = known.remove(direction));
            }
        }
    }

    /// The mean field and shares of its loss at a lateral wavenumber.
    fn known(&self, sine: f64) -> KnownField {
        let weights = lagrange(&self.places, place(self.before, sine));
        let mut shares = Lobes::default();
        for (weight, share) in weights.iter().zip(&self.shares) {
            shares.reflected += weight * share.reflected;
            shares.transmitted += weight * share.transmitted;
        }
        match &self.wave {
            MeanWave::Slabs { film, count, beyond } => {
                let slow = film.between(beyond, &weights, self.polarisation, sine);
                let mean = film.film(*count, self.polarisation, sine, &slow);
                KnownField {
                    mean,
                    front: slow.front.norm_sqr(),
                    through: slow.through.norm_sqr().sqrt(),
                    shares,
                }
            }
            MeanWave::Stack { film, beyond } => {
                let field = film.field(beyond, &weights, self.polarisation, sine);
                KnownField { mean: field.mean, front: field.front[0], through: field.front[1], shares }
            }
        }
    }

    /// R and T at a lateral wavenumber, with interference.
    fn with_interference(&self, sine: f64) -> Lobes {
        let KnownField { mean, shares, .. } = self.known(sine);
        mean.coherent.with_loss(shares)
    }

    /// Whether light of a lateral wavenumber passes both surfaces.
    fn passes(&self, sine: f64) -> bool {
        sine < self.before.ordinates.edge()
    }

    /// What interference changes of R and T in a direction that was solved, at 0° or at a node, by
    /// its lateral wavenumber; nothing where light does not pass both surfaces.
    pub fn change(&self, sine: f64) -> Lobes {
        if !self.passes(sine) {
            return Lobes::default();
        }
        let KnownField { mean, shares, .. } = self.known(sine);
        mean.coherent.with_loss(shares).less(mean.incoherent.with_loss(shares))
    }

    /// What interference changes in a direction whose light is shared among the nodes behind the
    /// front slab: what the shares are off is known of the mean field, and changed too.
    pub fn change_of_shared(&self, sine: f64) -> Lobes {
        if !self.passes(sine) {
            return Lobes::default();
        }
        let KnownField { front, through, shares, .. } = self.known(sine);
        let mut within = Lobes::default();
        let ordinates = &self.before.ordinates;
        for (node, share) in ordinates.shares(sine) {
            let at_node = self.known(ordinates.sines[node]);
            let front = Lobes { reflected: at_node.front, transmitted: 0.0 };
            let behind_front = at_node.mean.incoherent.less(front);
            within = within.plus(share / at_node.through.max(FAINT), behind_front);
        }
        let composed = Lobes { reflected: front, transmitted: 0.0 }.plus(through, within);
        self.with_interference(sine).less(composed.with_loss(shares))
    }

    /// What interference changes in a direction whose R and T are the polynomials through those at
    /// 0° and at the nodes, over the cosine.
    pub fn change_of_interpolated(&self, sine: f64) -> Lobes {
        if !self.passes(sine) {
            return Lobes::default();
        }
        let places: Vec<f64> =
            known_sines(self.before).iter().map(|sine| place(self.before, *sine)).collect();
        let weights = lagrange(&places, place(self.before, sine));
        weights
            .iter()
            .zip(&self.incoherent)
            .fold(self.with_interference(sine), |sum, (weight, lobes)| sum.plus(-weight, *lobes))
    }

    /// What interference changes of R and T of diffuse light, and the directions between the nodes.
    pub fn change_of_diffuse(&self) -> Lobes {
        let ordinates = &self.before.ordinates;
        let edge = ordinates.edge();
        let fringes = self.fringes();
        let interferes = fringes <= MOST_FRINGES;
        let pieces = PIECES + if interferes { (2.0 * fringes).ceil() as usize } else { 0 };
        let mut change = Lobes::default();
        // Equal steps of the cosine: a fringe, or less, in each. There are most for each fringe at
        // grazing angles, where fringes are sharp.
        let width = edge / pieces as f64;
        for piece in 0..pieces {
            let from = width * piece as f64;
            for &(x, weight) in piece_rule() {
                let place = from + width * x;
                let sine = (edge * edge - place * place).max(0.0).sqrt();
                let KnownField { mean, shares, .. } = self.known(sine);
                let lobes = if interferes { mean.coherent } else { mean.incoherent };
                change = change.plus(2.0 * place * width * weight, lobes.with_loss(shares));
            }
        }
        for (incoherent, weight) in self.incoherent[1..].iter().zip(&ordinates.weights) {
            change = change.plus(-weight, *incoherent);
        }
        for zone in &self.trapped {
            change = change.plus(1.0, zone.change());
        }
        Lobes::default().plus(ordinates.index.powi(-2), change)
    }

    /// Fringes over the hemisphere: 0 where light between the surfaces is too faint for any.
    fn fringes(&self) -> f64 {
        match &self.wave {
            MeanWave::Slabs { film, count, beyond } => {
                let weights = lagrange(&self.places, place(self.before, 0.0));
                film.fringes(&film.between(beyond, &weights, self.polarisation, 0.0), *count)
            }
            MeanWave::Stack { film, beyond } => film.fringes(beyond, self.polarisation),
        }
    }

    /// Shares of the light of a lateral wavenumber that the mean field mirrors \[with, without\]
    /// interference between the surfaces.
    pub fn mirrored(&self, sine: f64) -> [f64; 2] {
        let field = self.known(sine).mean;
        [field.coherent.reflected, field.incoherent.reflected]
    }

    /// What interference changes of the beam at 0° itself.
    pub fn change_of_beam(&self) -> Lobes {
        let MeanField { coherent, incoherent } = self.known(0.0).mean;
        coherent.less(incoherent)
    }
}

/// No more light than there is: amplitudes between nodes are not exact.
fn passive(lobes: Lobes) -> Lobes {
    let whole = (lobes.reflected + lobes.transmitted).max(1.0);
    Lobes { reflected: lobes.reflected / whole, transmitted: lobes.transmitted / whole }
}

/// Nodes and weights of ∫ dx over one piece, 0 < x < 1.
fn piece_rule() -> &'static [(f64, f64)] {
    static RULE: OnceLock<Vec<(f64, f64)>> = OnceLock::new();
    // weights of 2x dx, over 2x
    RULE.get_or_init(|| gauss_legendre(PIECE).into_iter().map(|(x, w)| (x, w / (2.0 * x))).collect())
}

/// Shares of what the coherent field loses that composing reflects and transmits. Where it loses
/// nothing, any that are as large together keep the energy. Neither is negative: the mean field of
/// few realisations mirrors too much.
fn shares(field: Lobes, composed: Lobes) -> Lobes {
    let lost = 1.0 - field.reflected - field.transmitted;
    if lost < NOTHING {
        return composed;
    }
    let of_both = composed.reflected + composed.transmitted - field.reflected - field.transmitted;
    let together = (of_both / lost).max(0.0);
    let reflected = ((composed.reflected - field.reflected) / lost).max(0.0).min(together);
    Lobes { reflected, transmitted: together - reflected }
}

#[cfg(test)]
#[path = "fringes_tests.rs"]
mod tests;
