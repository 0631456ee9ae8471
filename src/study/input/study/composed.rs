//! Layers composed of solved slabs: what is asked, and the studies that it takes.
//!
//! A portion is an ordinary study of a slab between half-spaces of which some have nearly the
//! layer's own index, by the mixing rule of its wave equation: so its solves have records, stores
//! and progress as any others.

mod stack_plates;

pub use stack_plates::{LayerPlates, StackMedia, StackedPortion};

use super::{Angles, Study, StudyKind};
use crate::appearance::composed::flux::{Hemisphere, Sides};
use crate::appearance::composed::ordinates::Ordinates;
use crate::appearance::paper::PRINT_DEG;
use crate::ink::PackingRequest;
use crate::input::variation::LightRule;
use crate::material::mixing::MixingRule;
use crate::wave::{Incidence, Side, Wave};
use num_complex::Complex64;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// The seeds of a study's portions are this far apart.
const SEEDS_APART: u64 = 1_000_003;

/// A layer cut into slabs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Composed {
    /// Thickness h of a slab, µm: the first thickness over a whole number.
    pub slab_um: f64,
    /// Directions in the zone from which light reaches air, and in each zone beyond.
    pub directions: [usize; 2],
    /// Thicknesses of the layer that are reported, µm.
    pub thicknesses_um: Vec<f64>,
    /// Mixing rule of the half-spaces that slabs are solved between; without one, that of the wave
    /// equation. Another one may change nothing but the bars.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mixing: Option<MixingRule>,
    /// How the layers of a stack become plates, in the order of the light; empty for one layer.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub layers: Vec<LayerPlates>,
    /// The layer of a stack whose thicknesses are reported; without one, the stack's own is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub varied: Option<usize>,
    /// Index of the half-spaces that every layer of a stack is solved between; without one, those
    /// of its neighbours.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub joint_index: Option<f64>,
}

/// Where a slab lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Position {
    /// Between others.
    Inner,
    /// At the incident side, with the layer's surface.
    Front,
    /// At the exit side, with the layer's surface.
    Back,
    /// On both sides at the layer's surfaces: a layer of a stack that is solved as a whole.
    Whole,
}

/// A study of one slab of a composed layer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Portion {
    /// Where it lies.
    pub position: Position,
    /// Whether it has half the thickness: the comparison tells what composing costs.
    pub halved: bool,
    /// Its number among the slabs of the layer, from 0.
    pub(super) number: u64,
    /// Thickness of a slab that is not halved, µm.
    pub(super) slab_um: f64,
    /// Directions of every zone.
    pub(super) directions: [usize; 2],
    /// Mixing rule of the half-spaces, if it is not that of the wave equation.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) mixing: Option<MixingRule>,
    /// Its layer of a stack; `None` in a layer that is alone.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) stacked: Option<StackedPortion>,
}

impl Portion {
    /// The first slab of the same layer.
    fn first(&self) -> Self {
        let (position, number) = match &self.stacked {
            None => (Position::Inner, 0),
            Some(StackedPortion { first, .. }) => *first,
        };
        Self { position, halved: false, number, ..self.clone() }
    }

    /// Number of its layer in a stack, from 0.
    pub fn layer(&self) -> usize {
        self.stacked.as_ref().map_or(0, |stacked| stacked.layer)
    }

    /// Its thickness, µm.
    fn thickness_um(&self) -> f64 {
        if self.halved { 0.5 * self.slab_um } else { self.slab_um }
    }

    /// How far the seed of its packings is from that of the layer.
    fn seed_offset(&self) -> u64 {
        SEEDS_APART.wrapping_mul(self.number)
    }

    /// What distinguishes its packings from those of other slabs with the same request.
    pub(super) fn packing_place(&self) -> (Position, u64) {
        (self.position, self.number)
    }

    /// What it is, in words.
    pub fn in_words(&self) -> String {
        let place = match self.position {
            Position::Inner => "inner slab",
            Position::Front => "slab with the front surface",
            Position::Back => "slab with the back surface",
            Position::Whole => "whole layer",
        };
        let layer = self.stacked.as_ref().map(|stacked| format!("{}: ", stacked.name)).unwrap_or_default();
        format!("{layer}{place}{}", if self.halved { ", half as thick" } else { "" })
    }

    /// The packing that it is cut out of: without walls for an inner slab, of twice the thickness
    /// for one with a surface of the layer, whose wall is on that side alone. Between walls every
    /// joint of slabs would lack grains.
    pub(super) fn packed(&self, slab: PackingRequest) -> PackingRequest {
        let height = slab.thickness_um;
        if self.position == Position::Whole {
            return PackingRequest { walls: true, ..slab };
        }
        let (whole, from) = match self.position {
            // Without walls, grains reach across half of the thickness at most.
            Position::Inner if slab.widest_body_um() <= 0.5 * height => (height, 0.0),
            Position::Inner | Position::Front | Position::Whole => (2.0 * height, 0.0),
            Position::Back => (2.0 * height, height),
        };
        let walls = self.position != Position::Inner;
        PackingRequest { thickness_um: whole, walls, cut_um: Some([from, from + height]), ..slab }
    }
}

impl Study {
    /// A layer composed of the slabs of another study, whole ones and a broken one; unchanged
    /// unless both are single layers that are composed.
    pub fn in_slabs_of(mut self, solved: &Self) -> Self {
        if let (StudyKind::Composed(own), StudyKind::Composed(other)) = (&mut self.kind, &solved.kind)
            && own.layers.is_empty()
            && other.layers.is_empty()
        {
            own.slab_um = other.slab_um;
            self.packing.thickness_um = other.slab_um;
        }
        self
    }

    /// Real index of the half-spaces that inner slabs are solved between, at a vacuum wavelength:
    /// the layer's own in the limit of small grains, √Re⟨η²⟩ for the scalar wave, that of Maxwell
    /// Garnett for Maxwell's equations. It has to be known before the first solve; the index of the
    /// mean wave follows from the solves.
    pub fn embedding_index(&self, wavelength_um: f64) -> f64 {
        self.even_permittivity(wavelength_um).re.max(0.0).sqrt()
    }

    /// Permittivity of the even medium whose real index that is, with what it absorbs.
    pub fn even_permittivity(&self, wavelength_um: f64) -> Complex64 {
        let (binder, pigments) = self.binder_and_pigments(wavelength_um);
        let shares: Vec<_> = self.material_shares().into_iter().zip(pigments).collect();
        let usual =
            if self.wave.is_vector() { MixingRule::MaxwellGarnett } else { MixingRule::VolumeAverage };
        let requested = match &self.kind {
            StudyKind::Composed(composed) => composed.mixing,
            StudyKind::Slab(portion) => portion.mixing,
            StudyKind::InkOnPaper | StudyKind::LayerAlone(_) => None,
        };
        let mixed = requested.unwrap_or(usual).mix(binder, &shares);
        mixed * mixed
    }

    /// Real indices in front and behind: those of the layer's surroundings, or its own.
    pub(super) fn outer_indices(&self, wavelength_um: f64) -> [f64; 2] {
        match self.portion() {
            Some(portion) => self.indices_around(portion, wavelength_um),
            None => [self.layer.index_in, self.layer.index_out],
        }
    }

    /// Real indices in front of a portion and behind it.
    fn indices_around(&self, portion: &Portion, wavelength_um: f64) -> [f64; 2] {
        if let Portion { position, stacked: Some(stacked), .. } = portion {
            return stacked.between(*position, wavelength_um);
        }
        let within = || self.embedding_index(wavelength_um);
        let (before, behind) = (self.layer.index_in, self.layer.index_out);
        match portion.position {
            Position::Whole => [before, behind],
            Position::Inner => [within(); 2],
            Position::Front => [before, within()],
            Position::Back => [within(), behind],
        }
    }

    /// Index of the denser medium around a slab, where it is denser than the slab's binder or than
    /// those around the slab that its grid is chosen for, so that more orders propagate.
    pub fn denser_surroundings(&self, wavelength_um: f64) -> Option<f64> {
        let portion = self.portion()?;
        let [own, of_first] = [portion, &portion.first()].map(|portion| {
            let [before, behind] = self.indices_around(portion, wavelength_um);
            before.max(behind)
        });
        let binder = self.binder_and_pigments(wavelength_um).0.re;
        (own > of_first.min(binder) + 1e-9).then_some(own)
    }

    /// The states of light on both sides of a portion; `None` for other studies.
    pub fn sides(&self, wavelength_um: f64) -> Option<Sides> {
        let portion = self.portion()?;
        let borders = match &portion.stacked {
            Some(stacked) => stacked.media_at(wavelength_um),
            None => vec![self.layer.index_in, self.layer.index_out, self.embedding_index(wavelength_um)],
        };
        let faced = portion.stacked.as_ref().is_some_and(|stacked| stacked.has_faces(wavelength_um));
        let outermost =
            !faced && portion.layer() == 0 && matches!(portion.position, Position::Front | Position::Whole);
        let medium = |(side, index): (usize, f64)| Hemisphere {
            ordinates: Ordinates::new(index, &borders, portion.directions),
            polarisations: self.polarisations().len(),
            oblique_deg: (side == 0 && outermost).then_some(PRINT_DEG),
        };
        let [before, behind] = self.outer_indices(wavelength_um);
        let alike = portion.position == Position::Inner;
        Some(Sides { media: [(0, before), (1, behind)].map(medium), alike })
    }

    /// The studies that a composed layer takes: slabs of the thickness h and of h/2, within the
    /// layer and at its surfaces; equal surroundings share one surface. Empty for other studies.
    pub fn portions(&self) -> Vec<Study> {
        let Some(composed) = self.composed() else { return Vec::new() };
        if !composed.layers.is_empty() {
            return self.portions_of_stack(composed);
        }
        let positions = match self.layer.index_in == self.layer.index_out {
            true => &[Position::Inner, Position::Front][..],
            false => &[Position::Inner, Position::Front, Position::Back],
        };
        let mut portions = Vec::new();
        for halved in [false, true] {
            for &position in positions {
                let &Composed { slab_um, directions, mixing, .. } = composed;
                let number = portions.len() as u64;
                let portion =
                    Portion { position, halved, number, slab_um, directions, mixing, stacked: None };
                portions.push(self.of_portion(portion, self.packing.seed));
            }
        }
        portions
    }

    /// The study whose grid this one is solved on: for a slab, the first slab of its layer, so that
    /// differences between slabs are not those of grids; otherwise this study.
    pub fn grid_source(&self) -> Cow<'_, Study> {
        match self.portion() {
            Some(portion) if portion.number != portion.first().number => {
                let layer_seed = self.packing.seed.wrapping_sub(portion.seed_offset());
                Cow::Owned(self.of_portion(portion.first(), layer_seed))
            }
            _ => Cow::Borrowed(self),
        }
    }

    /// The study of a slab, from that of its layer or of another slab; `layer_seed` is the layer's.
    pub(super) fn of_portion(&self, portion: Portion, layer_seed: u64) -> Study {
        let mut study = self.clone();
        study.title = format!("{}: {}", self.title, portion.in_words());
        study.layer.thickness_um = portion.thickness_um();
        study.packing.thickness_um = portion.thickness_um();
        study.packing.seed = layer_seed.wrapping_add(portion.seed_offset());
        study.variation.light = LightRule::Listed;
        if self.wave.is_vector() {
            study.wave = Wave::Unpolarised;
        }
        study.kind = StudyKind::Slab(portion);
        let shortest = self.wavelengths_nm.first().and_then(|nm| study.sides(1e-3 * nm));
        let directions = shortest.map(|sides| sides.media[0].directions_deg()).unwrap_or_default();
        let largest_deg = directions.into_iter().fold(0.0, f64::max);
        study.angles =
            Angles { exact_deg: vec![0.0, largest_deg], strata: 0, exit_strata: 0, ..self.angles.clone() };
        study
    }
}

/// Directions of a portion's light at a wavelength: side by side.
pub(super) fn portion_incidences(sides: &Sides, wavelength_um: f64, azimuth_deg: f64) -> Vec<Incidence> {
    let from = if sides.alike { &[Side::Incident][..] } else { &[Side::Incident, Side::Exit] };
    let mut incidences = Vec::new();
    for (medium, &from) in sides.media.iter().zip(from) {
        for polar_deg in medium.directions_deg() {
            incidences.push(Incidence { wavelength_um, polar_deg, azimuth_deg, from });
        }
    }
    incidences
}
