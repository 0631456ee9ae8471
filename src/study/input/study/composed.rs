//! Layers composed of solved slabs: what is asked, and the studies that it takes.
//!
//! A portion is an ordinary study of a slab between half-spaces of which some have nearly the
//! layer's own index, by the mixing rule of its wave equation: so its solves have records, stores
//! and progress as any others.

use super::{Angles, Study};
use crate::appearance::composed::flux::{Hemisphere, Sides};
use crate::appearance::composed::ordinates::Ordinates;
use crate::appearance::paper::PRINT_DEG;
use crate::ink::PackingRequest;
use crate::input::variation::LightRule;
use crate::material::mixing::MixingRule;
use crate::wave::{Incidence, Side, Wave};
use serde::{Deserialize, Serialize};

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
}

/// Where a slab lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Position {
    /// Between others.
    Inner,
    /// At the incident side, with the layer's surface.
    Front,
    /// At the exit side, with the layer's surface.
    Back,
}

/// A study of one slab of a composed layer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Portion {
    /// Where it lies.
    pub position: Position,
    /// Whether it has half the thickness: the comparison tells what composing costs.
    pub halved: bool,
    /// Directions of every zone.
    directions: [usize; 2],
    /// Mixing rule of the half-spaces, if it is not that of the wave equation.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    mixing: Option<MixingRule>,
}

impl Portion {
    /// What it is, in words.
    pub fn in_words(&self) -> String {
        let place = match self.position {
            Position::Inner => "inner slab",
            Position::Front => "slab with the front surface",
            Position::Back => "slab with the back surface",
        };
        format!("{place}{}", if self.halved { ", half as thick" } else { "" })
    }

    /// The packing that it is cut out of: without walls for an inner slab, of twice the thickness
    /// for one with a surface of the layer, whose wall is on that side alone. Between walls every
    /// joint of slabs would lack grains.
    pub(super) fn packed(&self, slab: PackingRequest) -> PackingRequest {
        let height = slab.thickness_um;
        let (whole, from) = match self.position {
            // Without walls, grains reach across half of the thickness at most.
            Position::Inner if slab.widest_body_um() <= 0.5 * height => (height, 0.0),
            Position::Inner | Position::Front => (2.0 * height, 0.0),
            Position::Back => (2.0 * height, height),
        };
        let walls = self.position != Position::Inner;
        PackingRequest { thickness_um: whole, walls, cut_um: Some([from, from + height]), ..slab }
    }
}

impl Study {
    /// Real index of the half-spaces that inner slabs are solved between, at a vacuum wavelength:
    /// the layer's own in the limit of small grains, √Re⟨η²⟩ for the scalar wave, that of Maxwell
    /// Garnett for Maxwell's equations. It has to be known before the first solve; the index of the
    /// mean wave follows from the solves.
    pub fn embedding_index(&self, wavelength_um: f64) -> f64 {
        let (binder, pigments) = self.binder_and_pigments(wavelength_um);
        let shares: Vec<_> = self.material_shares().into_iter().zip(pigments).collect();
        let own = if self.wave.is_vector() { MixingRule::MaxwellGarnett } else { MixingRule::VolumeAverage };
        let composed = self.layer.composed.as_ref().and_then(|composed| composed.mixing);
        let of_portion = self.portion.as_ref().and_then(|portion| portion.mixing);
        let mixed = composed.or(of_portion).unwrap_or(own).mix(binder, &shares);
        (mixed * mixed).re.max(0.0).sqrt()
    }

    /// Real indices in front and behind: those of the layer's surroundings, or its own.
    pub(super) fn outer_indices(&self, wavelength_um: f64) -> [f64; 2] {
        let own = || self.embedding_index(wavelength_um);
        let (before, behind) = (self.layer.index_in, self.layer.index_out);
        match self.portion.as_ref().map(|portion| portion.position) {
            None => [before, behind],
            Some(Position::Inner) => [own(); 2],
            Some(Position::Front) => [before, own()],
            Some(Position::Back) => [own(), behind],
        }
    }

    /// The states of light on both sides of a portion; `None` for other studies.
    pub fn sides(&self, wavelength_um: f64) -> Option<Sides> {
        let portion = self.portion.as_ref()?;
        let borders = [self.layer.index_in, self.layer.index_out, self.embedding_index(wavelength_um)];
        let medium = |(side, index): (usize, f64)| Hemisphere {
            ordinates: Ordinates::new(index, &borders, portion.directions),
            polarisations: self.polarisations().len(),
            oblique_deg: (side == 0 && portion.position == Position::Front).then_some(PRINT_DEG),
        };
        let [before, behind] = self.outer_indices(wavelength_um);
        let alike = portion.position == Position::Inner;
        Some(Sides { media: [(0, before), (1, behind)].map(medium), alike })
    }

    /// The studies that a composed layer takes: slabs of the thickness h and of h/2, within the
    /// layer and at its surfaces; equal surroundings share one surface. Empty for other studies.
    pub fn portions(&self) -> Vec<Study> {
        let Some(composed) = &self.layer.composed else { return Vec::new() };
        let all = [Position::Inner, Position::Front, Position::Back];
        let needed = |p: &Position| *p != Position::Back || self.layer.index_in != self.layer.index_out;
        let both = [false, true].into_iter().flat_map(|halved| all.map(|position| (position, halved)));
        let both = both.filter(|(position, _)| needed(position)).enumerate();
        both.map(|(k, (position, halved))| {
            let Composed { directions, mixing, .. } = *composed;
            self.portion(Portion { position, halved, directions, mixing }, composed, k as u64)
        })
        .collect()
    }

    fn portion(&self, portion: Portion, composed: &Composed, number: u64) -> Study {
        let thickness_um = if portion.halved { 0.5 * composed.slab_um } else { composed.slab_um };
        let mut study = self.clone();
        study.title = format!("{}: {}", self.title, portion.in_words());
        study.layer.composed = None;
        study.layer.thickness_um = thickness_um;
        study.packing.thickness_um = thickness_um;
        study.packing.seed = self.packing.seed.wrapping_add(SEEDS_APART.wrapping_mul(number));
        study.variation.light = LightRule::Listed;
        if self.wave.is_vector() {
            study.wave = Wave::Unpolarised;
        }
        study.portion = Some(portion);
        let largest = self.wavelengths_nm.first().and_then(|nm| study.sides(1e-3 * nm));
        let largest = largest.map(|sides| sides.media[0].directions_deg()).unwrap_or_default();
        study.angles = Angles {
            exact_deg: vec![0.0, largest.into_iter().fold(0.0, f64::max)],
            strata: 0,
            exit_strata: 0,
            no_paper: Some("a slab of a composed layer".to_owned()),
            ..self.angles.clone()
        };
        study
    }
}

/// Directions of a portion's light at a wavelength: side by side.
pub(super) fn portion_incidences(sides: &Sides, wavelength_um: f64, azimuth_deg: f64) -> Vec<Incidence> {
    let from = if sides.alike { &[Side::Incident][..] } else { &[Side::Incident, Side::Exit] };
    let of = |(medium, &from): (&Hemisphere, &Side)| {
        let lit = move |polar_deg| Incidence { wavelength_um, polar_deg, azimuth_deg, from };
        medium.directions_deg().into_iter().map(lit)
    };
    sides.media.iter().zip(from).flat_map(of).collect()
}
