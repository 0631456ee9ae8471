//! Fringes of light that cannot leave on the other side: from a dense medium beyond the critical
//! angle of air, as light of a paper in optical contact.
//!
//! Such light goes through the layer, is reflected as a whole at its far face, with a phase, and
//! comes back: nothing of the mean field is transmitted, and what is not reflected is scattered or
//! absorbed. Its film has fringes in what it absorbs, and towards grazing angles, where the near
//! face reflects as much as the far one, resonances.
//!
//! In a zone of [`Ordinates`](crate::appearance::composed::ordinates::Ordinates) beyond the edge,
//! every element is compared with an even film of a complex index N that has its phase and its loss
//! in the known direction: of a film that is even, N is the same in all directions and nothing else
//! is left over. In between, N² − n² and what is left over are polynomials in √(s₁² − s²) in the
//! zone that ends at s₁. The half-spaces that a slab is solved between, where its medium goes on,
//! are in its solve and not in the layer.
//!
//! Where a layer's index is below that of the paper, light beyond its own critical angle decays in
//! it, and what tunnels reaches the layers on its other side. No slab was solved there: it is an
//! even film of the N that it has at 0°.

mod element;
mod even_slab;

use self::element::{TURNED_BACK, TrappedElement};
use self::even_slab::normal;
use super::film_matrix::FilmMatrix;
use super::slab_film::CoherentFilm;
use super::stack_film::{FilmElement, FilmFace, Mirrors, SolvedElement, StackFilm};
use super::{FAINT, Lobes, MOST_FRINGES, MeanField, passive, shares};
use crate::appearance::composed::flux::Coherent;
use crate::appearance::composed::ordinates::{DirectionZone, NARROWEST, Ordinates};
use crate::numerics::integral::{Halving, halved};
use crate::numerics::interpolate::lagrange;
use gauss_quad::GaussLegendre;
use num_complex::Complex64;
use std::f64::consts::{FRAC_PI_2, TAU};
use std::sync::LazyLock;

/// Nodes of a piece of the mean over a zone, and of the rule beside it that tells where they do not
/// suffice: a piece is halved where both differ by more than an error, far below any bar.
const NODES: [usize; 2] = [16, 11];
const MEAN_ERROR: f64 = 1e-7;
/// Fringes of the pieces that are begun with, and most pieces beyond them.
const FRINGES_OF_A_PIECE: f64 = 4.0;
const MOST_HALVINGS: usize = 48;
/// Rounds of the search for N: what faces do to the phase is a tenth of what the way does, or less.
const ROUNDS: usize = 12;
/// Largest |N² − n²| that an even film is compared with; beyond it, N is n.
const FURTHEST: f64 = 1.0;
/// Loss of composed light that turns back at an element in which it decays, below which the shares
/// of the zone before tell more of what becomes of it.
const LITTLE: f64 = 0.02;

/// Rules on 0…1.
static RULES: LazyLock<[Vec<(f64, f64)>; 2]> = LazyLock::new(|| {
    NODES.map(|count| {
        let rule = GaussLegendre::new(count).expect("a positive number of nodes");
        rule.iter().map(|(x, weight)| (0.5 * (1.0 + x), 0.5 * weight)).collect()
    })
});

/// One element as light from the dense side meets it.
#[derive(Clone, Copy, Debug)]
pub(super) enum TrappedPart<'a> {
    /// A slab, or a whole layer, that was solved between two half-spaces.
    Solved(TrappedSlab<'a>),
    /// A plane face between two media.
    Face(FilmFace),
    /// An even medium.
    Even { index: Complex64, thickness_um: f64 },
}

/// What the solves of a slab say of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct TrappedSlab<'a> {
    /// Its mean amplitudes.
    pub amplitudes: &'a Coherent,
    /// Real indices of the half-spaces in front and behind.
    pub between: [f64; 2],
    /// Real index of the even medium that it is compared with.
    pub index: f64,
    /// Its thickness, µm.
    pub thickness_um: f64,
    /// Where its medium ends.
    pub mirrors: Mirrors,
    /// How many of it stand one behind another.
    pub count: f64,
}

/// The light of one zone: of one polarisation, at one wavelength.
#[derive(Clone, Copy, Debug)]
pub(super) struct TrappedLight<'a> {
    /// Directions of the medium that it comes from.
    pub ordinates: &'a Ordinates,
    /// Index of the medium behind the layer, where it decays.
    pub beyond: f64,
    pub polarisation: usize,
    pub wavelength_um: f64,
    /// Whether one of the known directions is left out.
    pub fewer_directions: bool,
}

/// One zone beyond the edge.
#[derive(Clone, Debug)]
pub(super) struct TrappedZone {
    zone: DirectionZone,
    polarisation: usize,
    wavenumber: f64,
    elements: Vec<TrappedElement>,
    /// √(s₁² − s²) of the known directions.
    places: Vec<f64>,
    /// Shares of the loss there that composing reflects and transmits.
    shares: Vec<Lobes>,
    /// R and T of the zone as composed of its nodes, times their étendues.
    composed: Lobes,
}

impl TrappedSlab<'_> {
    /// Its mean amplitude t in a direction that was solved from both sides, whose fluxes it scales
    /// to be alike.
    fn passed(&self, direction: usize, polarisation: usize) -> Option<Complex64> {
        let onward = |side: usize| -> Option<Complex64> {
            Some(self.amplitudes[side].get(direction)?.get(polarisation)?[1])
        };
        let root = (onward(0)? * onward(1)?).sqrt();
        // the root that is the amplitude, not less it
        Some(if (root.conj() * onward(0)?).re < 0.0 { -root } else { root })
    }
}

impl<'a> TrappedPart<'a> {
    /// An element of a stack.
    fn of(element: &'a FilmElement) -> Self {
        match element {
            FilmElement::Solved(solved) => {
                let &SolvedElement { between, index, thickness_um, mirrors, count, .. } = solved;
                let amplitudes = &solved.amplitudes;
                Self::Solved(TrappedSlab { amplitudes, between, index, thickness_um, mirrors, count })
            }
            FilmElement::Face(face) => Self::Face(*face),
            FilmElement::Even { index, thickness_um } => {
                Self::Even { index: *index, thickness_um: *thickness_um }
            }
        }
    }
}

impl CoherentFilm {
    /// What a layer of this many slabs is to light that cannot leave behind it; `composed` are R
    /// and T at 0° and at all nodes.
    pub(super) fn trapped(&self, count: f64, polarisation: usize, composed: &[Lobes]) -> Vec<TrappedZone> {
        let [before, within, behind] = self.media.each_ref().map(|medium| medium.ordinates.index);
        let part = |slab: usize, between: [f64; 2], mirrors: Mirrors, count: f64| {
            TrappedPart::Solved(TrappedSlab {
                amplitudes: &self.slabs[slab],
                between,
                index: within,
                thickness_um: self.slab_um,
                mirrors,
                count,
            })
        };
        let parts = [
            part(0, [before, within], Mirrors::InFront, 1.0),
            part(1, [within; 2], Mirrors::Nowhere, count - 2.0),
            part(2, [within, behind], Mirrors::Behind, 1.0),
        ];
        let light = TrappedLight {
            ordinates: &self.media[0].ordinates,
            beyond: behind,
            polarisation,
            wavelength_um: self.wavelength_um,
            fewer_directions: self.fewer_directions,
        };
        TrappedZone::all(&parts, light, composed)
    }
}

impl StackFilm {
    /// What the stack is to light that cannot leave behind it; `composed` are R and T at 0° and at
    /// all nodes.
    pub(super) fn trapped(&self, polarisation: usize, composed: &[Lobes]) -> Vec<TrappedZone> {
        let parts: Vec<TrappedPart> = self.elements.iter().map(TrappedPart::of).collect();
        let light = TrappedLight {
            ordinates: &self.media[0].ordinates,
            beyond: self.media[1].ordinates.index,
            polarisation,
            wavelength_um: self.wavelength_um,
            fewer_directions: self.fewer_directions,
        };
        TrappedZone::all(&parts, light, composed)
    }
}

impl TrappedZone {
    /// All zones of the light whose directions are known in all elements; `composed` are R and T
    /// at 0° and at all nodes.
    pub(super) fn all(parts: &[TrappedPart], light: TrappedLight, composed: &[Lobes]) -> Vec<Self> {
        let zones = light.ordinates.beyond_edge().into_iter();
        let mut all: Vec<Self> = Vec::new();
        for zone in zones.filter(|zone| zone.from > light.beyond - NARROWEST) {
            let before = all.last().and_then(|zone| zone.shares.last().copied());
            all.extend(Self::new(parts, light, zone, composed, before.unwrap_or_default()));
        }
        all
    }

    /// A zone; `before` are the shares of the loss in the zone before, for where composing lets no
    /// light come to what scatters it.
    fn new(
        parts: &[TrappedPart],
        light: TrappedLight,
        zone: DirectionZone,
        composed: &[Lobes],
        before: Lobes,
    ) -> Option<Self> {
        let nodes = zone.first..zone.first + zone.count;
        let composed = composed.get(1 + nodes.start..1 + nodes.end)?;
        let sines = &light.ordinates.sines;
        let wavenumber = TAU / light.wavelength_um;
        let last = parts.len().checked_sub(1)?;
        let element = |(number, part): (usize, &TrappedPart), before: Option<&TrappedElement>| {
            let is_last = number == last;
            match part {
                TrappedPart::Solved(slab) => {
                    let media = [slab.between[0], slab.index, slab.between[1]];
                    let inside = if is_last { &media[..2] } else { &media[..] };
                    let propagates = inside.iter().all(|index| *index > zone.to - NARROWEST);
                    let own = || TrappedElement::of_slab(slab, light, &zone, is_last, before);
                    let beyond = || TrappedElement::beyond_solves(slab, light, &zone, is_last);
                    propagates.then(own).flatten().unwrap_or_else(beyond)
                }
                TrappedPart::Face(face) => TrappedElement::Face {
                    squared: face.indices.map(|index| index * index),
                    composed: face.composed.map(|index| (index * index).into()),
                },
                TrappedPart::Even { index, thickness_um } => {
                    TrappedElement::Even { squared: index * index, thickness_um: *thickness_um }
                }
            }
        };
        let mut elements = Vec::new();
        for part in parts.iter().enumerate() {
            let next = element(part, elements.last());
            elements.push(next);
        }
        let places = sines[nodes.clone()].iter().map(|sine| zone.place(*sine)).collect();
        let weights = &light.ordinates.weights[nodes.clone()];
        let whole = Lobes::default();
        let sum = weights.iter().zip(composed).fold(whole, |sum, (weight, lobes)| sum.plus(*weight, *lobes));
        let mut all = Self {
            polarisation: light.polarisation,
            wavenumber,
            elements,
            places,
            shares: Vec::new(),
            composed: sum,
            zone,
        };
        let known = sines[nodes].iter().zip(composed).enumerate();
        let share = |(k, (sine, composed)): (usize, (&f64, &Lobes))| {
            let field = all.solved(k, *sine);
            let decays = all.elements[..last].iter().any(|element| !element.passes(*sine));
            if decays && 1.0 - field.reflected < LITTLE { before } else { shares(field, *composed) }
        };
        all.shares = known.map(share).collect();
        if light.fewer_directions && all.places.len() > 1 {
            all.leave_out(all.places.len() / 2);
        }
        Some(all)
    }

    /// Leaves one of the known directions out of the polynomials.
    fn leave_out(&mut self, direction: usize) {
        self.places.remove(direction);
        self.shares.remove(direction);
        for element in &mut self.elements {
            if let TrappedElement::Solved { known, .. } = element {
                known.remove(direction);
            }
        }
    }

    /// The mean field at a lateral wavenumber of the zone: nothing passes.
    fn field(&self, sine: f64) -> MeanField {
        let weights = lagrange(&self.places, self.zone.place(sine));
        let mut whole = FilmMatrix::NONE;
        let mut powers = whole.powers();
        for element in &self.elements {
            let next = element.at(&weights, sine, self.polarisation, self.wavenumber);
            whole = whole.then(next);
            let own = element.powers(next, sine, self.polarisation);
            powers = powers.then(if element.passes(sine) { own } else { TURNED_BACK });
        }
        let lobes = |reflected: f64| {
            let reflected = if reflected.is_finite() { reflected } else { 1.0 };
            passive(Lobes { reflected, transmitted: 0.0 })
        };
        MeanField { coherent: lobes(whole.reflected[0].norm_sqr()), incoherent: lobes(powers.reflected[0]) }
    }

    /// The mean field in a known direction without interference between the slabs, as they were
    /// solved: what composing makes of it, with the steps to their half-spaces.
    fn solved(&self, direction: usize, sine: f64) -> Lobes {
        let mut powers = FilmMatrix { reflected: [0.0; 2], transmitted: 1.0 };
        for element in &self.elements {
            powers = powers.then(element.solved(direction, sine, self.polarisation, self.wavenumber));
        }
        passive(Lobes { reflected: powers.reflected[0], transmitted: 0.0 })
    }

    /// R and T at a lateral wavenumber, with or without interference. Polynomials may leave what
    /// shares can be: 0 to 1 together.
    fn lobes(&self, sine: f64, interferes: bool) -> Lobes {
        let weights = lagrange(&self.places, self.zone.place(sine));
        let mut share = Lobes::default();
        for (weight, known) in weights.iter().zip(&self.shares) {
            share = share.plus(*weight, *known);
        }
        let within = |share: f64, most: f64| share.max(0.0).min(most);
        let reflected = within(share.reflected, 1.0);
        let transmitted = within(share.transmitted, 1.0 - reflected);
        let field = self.field(sine);
        let mean = if interferes { field.coherent } else { field.incoherent };
        mean.with_loss(Lobes { reflected, transmitted })
    }

    /// What interference changes of R and T of the zone, and the directions between its nodes, as
    /// ∫ 2s ds. The zone is an arc v = v₁ cos t, along which the decay beyond the far face is
    /// smooth.
    pub(super) fn change(&self) -> Lobes {
        let width = self.zone.place(self.zone.from);
        let fringes = self.fringes().filter(|fringes| *fringes <= MOST_FRINGES);
        let interferes = fringes.is_some();
        let begun = fringes.map_or(1.0, |fringes| (fringes / FRINGES_OF_A_PIECE).ceil().max(1.0)) as usize;
        let halving = Halving { begun, most: begun + MOST_HALVINGS, error: MEAN_ERROR };
        let [reflected, transmitted] = halved(&RULES, halving, &|share: f64| {
            let t = FRAC_PI_2 * share;
            let place = width * t.cos();
            let sine = (self.zone.to * self.zone.to - place * place).max(0.0).sqrt();
            let measure = FRAC_PI_2 * width * width * (2.0 * t).sin();
            let Lobes { reflected, transmitted } = self.lobes(sine, interferes);
            [measure * reflected, measure * transmitted]
        });
        Lobes { reflected, transmitted }.less(self.composed)
    }

    /// Fringes over the zone; `None` where light that comes back is too faint for any.
    fn fringes(&self) -> Option<f64> {
        let weights = lagrange(&self.places, self.zone.place(self.zone.from));
        let last = self.elements.len() - 1;
        let mut seen = 1.0;
        let mut fringes = 0.0;
        for (number, element) in self.elements.iter().enumerate() {
            let (squared, thickness_um) = element.depth();
            let phases = [self.zone.from, self.zone.to].map(|sine| normal(squared, sine).re);
            fringes += 2.0 * (phases[0] - phases[1]) * thickness_um * self.wavenumber / TAU;
            if number < last && element.goes_on(self.zone.to - NARROWEST) {
                let at_edge = element.at(&weights, self.zone.from, self.polarisation, self.wavenumber);
                seen *= at_edge.transmitted.norm_sqr();
            }
        }
        (seen >= FAINT).then_some(fringes)
    }
}

#[cfg(test)]
#[path = "trapped_tests.rs"]
mod tests;
