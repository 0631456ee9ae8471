//! Stacks as lists of plates: from the ensembles of all portions to a stack of one thickness of its
//! varied layer.
//!
//! A layer that is solved as a whole is one element, and among slabs of half the thickness it is
//! its two halves, so that the comparison carries what a joint within a strong layer costs.

use super::between::FilmLayer;
use super::level::{Change, Level, MeanSlab};
use crate::appearance::composed::flux::Hemisphere;
use crate::appearance::composed::fringes::stack_film::{Mirrors, SolvedElement};
use crate::appearance::composed::ordinates::Ordinates;
use crate::appearance::composed::stack::{PlateStack, StackElement};
use crate::appearance::paper::PRINT_DEG;
use crate::input::study::{Composed, LayerPlates, Position, StackMedia, Study};

/// Difference of indices that is rounding.
const SAME_INDEX: f64 = 1e-9;

/// The stack of a study at all wavelengths.
pub struct StackTask<'a> {
    study: &'a Study,
    composed: &'a Composed,
    /// \[wavelength\]
    media: Vec<StackMedia>,
    /// Index of every layer itself, \[wavelength\]\[layer\].
    own: Vec<Vec<f64>>,
}

/// The layers of a stack that are there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum KeptLayers {
    /// Every one.
    All,
    /// All but one.
    AllBut(usize),
    /// One alone.
    Only(usize),
    /// None: the bare paper.
    None,
}

impl KeptLayers {
    fn has(self, layer: usize) -> bool {
        match self {
            Self::All => true,
            Self::AllBut(other) => layer != other,
            Self::Only(one) => layer == one,
            Self::None => false,
        }
    }
}

/// What one layer of a stack is made of at one wavelength.
struct Around<'a> {
    layer: usize,
    media: &'a StackMedia,
    wavelength: usize,
}

impl<'a> StackTask<'a> {
    /// `None` for studies that are no stack of plates.
    pub fn new(study: &'a Study) -> Option<Self> {
        let composed = study.composed().filter(|composed| !composed.layers.is_empty())?;
        let layers: Vec<Study> = (0..study.stack.len()).map(|layer| study.of_layer(layer)).collect();
        let own = |nm: &f64| layers.iter().map(|layer| layer.embedding_index(1e-3 * nm)).collect();
        let own = study.wavelengths_nm.iter().map(own).collect();
        Some(Self { study, composed, media: study.stack_media(), own })
    }

    /// The stack at every wavelength, its varied layer `thickness_um` thick.
    ///
    /// # Errors
    /// A portion that is missing; joints whose media differ.
    pub fn stacks(
        &self,
        level: &Level,
        thickness_um: f64,
        change: Change,
    ) -> Result<Vec<PlateStack>, String> {
        self.joined(KeptLayers::All, &self.layers(level, thickness_um, change)?)
    }

    /// Every layer as an even film; the varied one has this thickness.
    pub(super) fn films(&self, thickness_um: f64) -> Vec<FilmLayer> {
        let film = |layer: usize| FilmLayer {
            indices: self.own.iter().map(|own| own[layer]).collect(),
            thickness_um: self.thickness_of(layer, thickness_um),
        };
        (0..self.study.stack.len()).map(film).collect()
    }

    /// Thickness of a layer, µm, where the varied one has this thickness.
    fn thickness_of(&self, layer: usize, varied_um: f64) -> f64 {
        if self.composed.varied == Some(layer) { varied_um } else { self.study.stack[layer].thickness_um }
    }

    /// The elements of every layer, \[wavelength\]\[layer\].
    ///
    /// # Errors
    /// A portion that is missing.
    pub fn layers(
        &self,
        level: &Level,
        thickness_um: f64,
        change: Change,
    ) -> Result<Vec<Vec<Vec<StackElement>>>, String> {
        let at_wavelength = |wavelength: usize| {
            let plates = self.composed.layers.iter().enumerate();
            plates
                .map(|(layer, plates)| {
                    let around = Around { layer, media: &self.media[wavelength], wavelength };
                    let um = self.thickness_of(layer, thickness_um);
                    match plates {
                        LayerPlates::Clear => Ok(self.clear(&around, um)),
                        LayerPlates::Whole => self.solved(&around, level, 1.0, change),
                        LayerPlates::Slabs(slab_um) => {
                            self.solved(&around, level, slabs_in(um, *slab_um), change)
                        }
                    }
                })
                .collect()
        };
        (0..self.media.len()).map(at_wavelength).collect()
    }

    /// Some of the layers, joined at every wavelength: where others were, a plane face leads from
    /// the medium in front of them to that behind.
    ///
    /// # Errors
    /// Joints whose media differ.
    pub fn joined(
        &self,
        kept: KeptLayers,
        layers: &[Vec<Vec<StackElement>>],
    ) -> Result<Vec<PlateStack>, String> {
        self.media.iter().zip(layers).map(|(media, layers)| self.stack(kept, media, layers)).collect()
    }

    fn stack(
        &self,
        kept: KeptLayers,
        media: &StackMedia,
        layers: &[Vec<StackElement>],
    ) -> Result<PlateStack, String> {
        let mut elements = Vec::new();
        let mut reached = 0;
        for (layer, own) in layers.iter().enumerate().filter(|(layer, _)| kept.has(*layer)) {
            elements.extend(self.face(media, [reached, layer]));
            elements.extend(own.iter().cloned());
            reached = layer + 1;
        }
        let last = layers.len();
        elements.extend(self.face(media, [reached, last]));
        if elements.is_empty() {
            elements.push(self.face_between(media, [last, last], 0));
        }
        let oblique_deg = Some(PRINT_DEG);
        let Some([before, behind]) = media.outer else {
            let before = Hemisphere { oblique_deg, ..self.medium(media, media.joints[0]) };
            return PlateStack::new(elements, before, 1e-3 * media.wavelength_nm);
        };
        let before = Hemisphere { oblique_deg, ..self.medium(media, before) };
        let joint = self.medium(media, media.joints[0]);
        let behind = self.medium(media, behind);
        between_faces(elements, [&before, &joint, &behind], 1e-3 * media.wavelength_nm)
    }

    /// The face in place of the layers between two joints; `None` where there is none. In front of
    /// the stack one that mirrors nothing still shares the oblique beam among the nodes.
    fn face(&self, media: &StackMedia, [from, to]: [usize; 2]) -> Option<StackElement> {
        let is_even = (media.joints[from] - media.joints[to]).abs() < SAME_INDEX;
        let is_needed = !is_even || self.oblique_at(media, from).is_some();
        (to > from && is_needed).then(|| self.face_between(media, [from, to], from))
    }

    fn face_between(&self, media: &StackMedia, [from, to]: [usize; 2], layer: usize) -> StackElement {
        let oblique_deg = self.oblique_at(media, from);
        let before = Hemisphere { oblique_deg, ..self.medium(media, media.joints[from]) };
        StackElement::face([&before, &self.medium(media, media.joints[to])], layer)
    }

    /// The oblique beam at a joint: in front of the stack alone.
    fn oblique_at(&self, media: &StackMedia, joint: usize) -> Option<f64> {
        (joint == 0 && media.outer.is_none()).then_some(PRINT_DEG)
    }

    /// States of light in a medium of the stack.
    fn medium(&self, media: &StackMedia, index: f64) -> Hemisphere {
        Hemisphere {
            ordinates: Ordinates::new(index, &media.all(), self.composed.directions),
            polarisations: if self.study.wave.is_vector() { 2 } else { 1 },
            oblique_deg: None,
        }
    }

    fn clear(&self, Around { layer, media, .. }: &Around, thickness_um: f64) -> Vec<StackElement> {
        let before = Hemisphere {
            oblique_deg: self.oblique_at(media, *layer),
            ..self.medium(media, media.joints[*layer])
        };
        let within = self.medium(media, media.within[*layer]);
        let behind = self.medium(media, media.joints[layer + 1]);
        let wavelength_um = 1e-3 * media.wavelength_nm;
        let index = self.study.stack[*layer].binder.index_at(wavelength_um);
        StackElement::clear([&before, &within, &behind], index, thickness_um, wavelength_um, *layer)
    }

    /// A layer of `count` slabs of the thickness that is not halved.
    fn solved(
        &self,
        around: &Around,
        level: &Level,
        count: f64,
        change: Change,
    ) -> Result<Vec<StackElement>, String> {
        let Around { layer, wavelength, .. } = *around;
        let mean = |position| level.mean([layer, wavelength], position, change);
        slab_elements(mean, level.halved, count, layer)
            .ok_or_else(|| format!("layer {} has no complete realisation yet", self.study.stack[layer].name))
    }
}

/// The elements of a layer of `count` slabs of the thickness that is not halved, from the mean
/// portion at every position; `None` if one is missing. Slabs between half-spaces of another index
/// than that of the even medium that they are compared with mirror the steps to it.
pub(super) fn slab_elements(
    mean: impl Fn(Position) -> Option<MeanSlab>,
    is_halved: bool,
    count: f64,
    layer: usize,
) -> Option<Vec<StackElement>> {
    let count = if is_halved { 2.0 * count } else { count };
    let places = if count > 1.0 {
        vec![
            (Position::Front, Mirrors::InFront, 1.0),
            (Position::Inner, Mirrors::Nowhere, count - 2.0),
            (Position::Back, Mirrors::Behind, 1.0),
        ]
    } else {
        vec![(Position::Whole, Mirrors::OnBothSides, 1.0)]
    };
    let mut elements = Vec::new();
    for (position, mirrors, count) in places.into_iter().filter(|(_, _, count)| *count > 0.0) {
        let MeanSlab { plate, coherent, media: [before, behind], permittivity, slab_um } = mean(position)?;
        let own = permittivity.re.max(0.0).sqrt();
        let inside = match position {
            Position::Back => &before,
            _ => &behind,
        };
        let is_stepped = position != Position::Whole && (inside.ordinates.index - own).abs() > SAME_INDEX;
        let mirrors = if is_stepped { Mirrors::OnBothSides } else { mirrors };
        let film = SolvedElement {
            amplitudes: coherent,
            between: [before.ordinates.index, behind.ordinates.index],
            index: own,
            permittivity,
            thickness_um: slab_um,
            mirrors,
            count,
            part_first: false,
        };
        elements.push(StackElement::solved(plate, film, behind, layer));
    }
    Some(elements)
}

/// Layers between half-spaces of one index, the joint's, with plane faces to the media in front of
/// the stack and behind it.
///
/// # Errors
/// As [`PlateStack::new`].
pub(super) fn between_faces(
    layers: Vec<StackElement>,
    [before, joint, behind]: [&Hemisphere; 3],
    wavelength_um: f64,
) -> Result<PlateStack, String> {
    let last = layers.last().map_or(0, StackElement::layer);
    let mut elements = vec![StackElement::face([before, joint], 0)];
    elements.extend(layers);
    if behind.ordinates.index != joint.ordinates.index {
        elements.push(StackElement::face([joint, behind], last));
    }
    PlateStack::new(elements, before.clone(), wavelength_um)
}

/// Slabs in a thickness: a whole number but for rounding, or any.
pub(super) fn slabs_in(thickness_um: f64, slab_um: f64) -> f64 {
    let count = thickness_um / slab_um;
    if (count - count.round()).abs() < 1e-9 * count { count.round() } else { count }
}
