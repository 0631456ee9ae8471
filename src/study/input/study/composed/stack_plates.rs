//! Stacks as lists of plates: which layers are solved as a whole, which in slabs, and between which
//! media.
//!
//! Between two layers lies a medium without extent, their joint, of the highest index of their
//! binders and of what is behind the stack: a lower one would mirror light that passes from binder
//! to binder, or from a paper in contact, where one of the layers is left out. The steps of index
//! are in the solves of the layers. All media have the same zones of directions, which end at the
//! indices of all of them.

use super::{Composed, Portion, Position};
use crate::input::study::{StackLayer, Study, StudyKind};
use serde::{Deserialize, Serialize};

/// How one layer of a stack becomes plates.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LayerPlates {
    /// Without grains: it is known exactly.
    Clear,
    /// Solved as a whole, from surface to surface.
    Whole,
    /// Composed of slabs of this thickness, µm.
    Slabs(f64),
}

/// The layer that a slab of a stack belongs to, and the media of the stack.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StackedPortion {
    /// Number of the layer, from 0.
    pub(super) layer: usize,
    /// Its name.
    pub(super) name: String,
    /// Position and number of the portion whose grid all portions of the layer have.
    pub(super) first: (Position, u64),
    /// The media of the stack at every wavelength.
    pub(super) media: Vec<StackMedia>,
}

/// Real indices of a stack's half-spaces at one wavelength.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StackMedia {
    /// Vacuum wavelength, nm.
    pub wavelength_nm: f64,
    /// In front of layer k: for k = 0 the incident side, else the joint with the layer before; and
    /// the exit side.
    pub joints: Vec<f64>,
    /// What inner slabs of layer k are solved between; of a clear layer its own index. Between
    /// plane faces it is that of the joints or more: of a medium that is less dense, the joints'
    /// directions would have a critical angle between nodes, and their fluxes no balance.
    pub within: Vec<f64>,
    /// In front of the stack and behind it, where plane faces lead from there to joints of one
    /// index; `None` where the outermost layers are solved with what surrounds the stack.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub outer: Option<[f64; 2]>,
}

impl StackMedia {
    /// Indices at which zones of directions end: of all media; between plane faces those of the
    /// layers are left out, so that a layer's plates do not depend on other layers.
    pub fn all(&self) -> Vec<f64> {
        match self.outer {
            None => self.joints.iter().chain(&self.within).copied().collect(),
            Some(outer) => self.joints.iter().copied().chain(outer).collect(),
        }
    }
}

impl StackedPortion {
    /// The media at the wavelength nearest to this one.
    fn at(&self, wavelength_um: f64) -> Option<&StackMedia> {
        let distance = |media: &StackMedia| (media.wavelength_nm - 1e3 * wavelength_um).abs();
        self.media.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)))
    }

    /// Whether plane faces lead to what surrounds the stack.
    pub(super) fn has_faces(&self, wavelength_um: f64) -> bool {
        self.at(wavelength_um).is_some_and(|media| media.outer.is_some())
    }

    /// Indices of all media.
    pub(super) fn media_at(&self, wavelength_um: f64) -> Vec<f64> {
        self.at(wavelength_um).map(StackMedia::all).unwrap_or_default()
    }

    /// Indices in front of and behind a portion at this position.
    pub(super) fn between(&self, position: Position, wavelength_um: f64) -> [f64; 2] {
        let Some(media) = self.at(wavelength_um) else { return [f64::NAN; 2] };
        let (before, behind) = (media.joints[self.layer], media.joints[self.layer + 1]);
        let within = media.within[self.layer];
        match position {
            Position::Inner => [within; 2],
            Position::Front => [before, within],
            Position::Back => [within, behind],
            Position::Whole => [before, behind],
        }
    }
}

impl Study {
    /// The media of a stack at its wavelengths.
    pub fn stack_media(&self) -> Vec<StackMedia> {
        let layers: Vec<Study> = (0..self.stack.len()).map(|k| self.of_layer(k)).collect();
        let at = |nm: &f64| {
            let um = 1e-3 * nm;
            let binder = |layer: &StackLayer| {
                let index = layer.binder.index_at(um);
                (index * index).re.max(0.0).sqrt()
            };
            let binders: Vec<f64> = self.stack.iter().map(binder).collect();
            let mut within: Vec<f64> = layers.iter().map(|layer| layer.embedding_index(um)).collect();
            let mut joints = vec![self.layer.index_in];
            joints.extend(binders.windows(2).map(|pair| pair[0].max(pair[1]).max(self.layer.index_out)));
            joints.push(self.layer.index_out);
            let joint = self.composed().and_then(|composed| composed.joint_index);
            let outer = joint.map(|_| [self.layer.index_in, self.layer.index_out]);
            if let Some(index) = joint {
                joints.fill(index);
                let grains = within.iter_mut().zip(&layers).filter(|(_, layer)| !layer.pigments.is_empty());
                grains.for_each(|(within, _)| *within = within.max(index));
            }
            StackMedia { wavelength_nm: *nm, joints, within, outer }
        };
        self.wavelengths_nm.iter().map(at).collect()
    }

    /// The layers of a stack of plates that are no plates of a library, for they have no grains,
    /// and what to do; `None` where all are.
    pub fn layers_without_plates(&self) -> Option<String> {
        self.composed()?.joint_index?;
        let clear = self.stack.iter().filter(|layer| layer.pigments == 0);
        let names: Vec<&str> = clear.map(|layer| layer.name.as_str()).collect();
        (!names.is_empty()).then(|| {
            format!(
                "{}: no plate: a library holds layers with grains, and compositions of it lack this one; for colours with it, \
                 run the whole stack (inkwave run)",
                names.join(", ")
            )
        })
    }

    /// One layer of a stack as a study of its own.
    pub fn of_layer(&self, layer: usize) -> Study {
        let own = &self.stack[layer];
        let pigments = self.pigments_of_layers().swap_remove(layer);
        let mut study = self.clone();
        study.stack = Vec::new();
        study.layer.thickness_um = own.thickness_um;
        study.layer.binder = own.binder.clone();
        study.pigments = self.pigments[pigments].to_vec();
        let request = &self.packing.layers[layer].request;
        study.packing = crate::ink::PackingRequest {
            period_um: self.packing.period_um,
            seed: self.packing.seed,
            ..request.clone()
        };
        study
    }

    /// The studies that a stack of plates takes: of every layer with grains the whole layer or
    /// slabs of its own thickness, and slabs of half of that.
    pub(super) fn portions_of_stack(&self, composed: &Composed) -> Vec<Study> {
        let media = self.stack_media();
        let mut portions = Vec::new();
        for (layer, plates) in composed.layers.iter().enumerate() {
            let own_um = self.stack[layer].thickness_um;
            let slab_um = match plates {
                LayerPlates::Clear => continue,
                LayerPlates::Whole => own_um,
                LayerPlates::Slabs(um) => *um,
            };
            let study = Study { kind: StudyKind::InkOnPaper, ..self.of_layer(layer) };
            let first = (positions(plates, false)[0], portions.len() as u64);
            for halved in [false, true] {
                for &position in positions(plates, halved) {
                    let number = portions.len() as u64;
                    let stacked = StackedPortion {
                        layer,
                        name: self.stack[layer].name.clone(),
                        first,
                        media: media.clone(),
                    };
                    let portion = Portion {
                        position,
                        halved,
                        number,
                        slab_um,
                        directions: composed.directions,
                        mixing: composed.mixing,
                        stacked: Some(stacked),
                    };
                    portions.push(study.of_portion(portion, self.packing.seed));
                }
            }
        }
        portions
    }
}

/// Positions of the portions of a layer. A whole layer is compared with two halves.
fn positions(plates: &LayerPlates, halved: bool) -> &'static [Position] {
    match (plates, halved) {
        (LayerPlates::Clear, _) => &[],
        (LayerPlates::Whole, false) => &[Position::Whole],
        (LayerPlates::Whole, true) => &[Position::Front, Position::Back],
        (LayerPlates::Slabs(_), _) => &[Position::Inner, Position::Front, Position::Back],
    }
}
