//! The stacks that a stack is compared with: without each of its layers, and each of them alone.

use super::{Judgement, Paper, Study};
use crate::appearance::paper::Coupling;
use crate::ink::{Joint, PackingRequest, StackedRequest};

/// Some of a stack's layers as a study of their own.
#[derive(Clone, Debug)]
pub struct Substack {
    /// What it is, in words: "without varnish", "varnish alone".
    pub name: String,
    /// The study of the layers that are left, as if the file had no others: the same seed, cells of
    /// the same nominal size, light and paper. Where a layer is left out its neighbours meet at a
    /// plane face.
    pub study: Study,
}

impl Study {
    /// The stack without each of its layers, then each layer alone; of two layers each is what is
    /// left without the other. Empty unless [`Study::without_layers`].
    pub fn substacks(&self) -> Vec<Substack> {
        let count = self.stack.len();
        if !self.without_layers || count < 2 {
            return Vec::new();
        }
        let mut all = Vec::new();
        for (left_out, layer) in self.stack.iter().enumerate() {
            let kept: Vec<usize> = (0..count).filter(|&k| k != left_out).collect();
            all.push(self.substack(&kept, format!("without {}", layer.name)));
        }
        for (only, layer) in self.stack.iter().enumerate().filter(|_| count > 2) {
            all.push(self.substack(&[only], format!("{} alone", layer.name)));
        }
        all
    }

    /// Place of the stack without a layer in [`Study::substacks`].
    pub fn place_without(&self, layer: usize) -> usize {
        layer
    }

    /// Place of a layer alone in [`Study::substacks`].
    pub fn place_alone(&self, layer: usize) -> usize {
        let count = self.stack.len();
        if count == 2 { 1 - layer } else { count + layer }
    }

    /// The study of these layers, in the order of the light.
    fn substack(&self, kept: &[usize], name: String) -> Substack {
        let mut study = match kept {
            [only] => self.of_layer(*only),
            _ => self.of_layers(kept),
        };
        study.title = format!("{}, {name}", self.title);
        study.without_layers = false;
        study.variation.thickness_std_um = kept.iter().map(|&k| self.stack[k].thickness_std_um).sum();
        if study.pigments.is_empty() && study.variation.thickness_std_um == 0.0 {
            study.realisations = 1;
        }
        if study.stack.is_empty() && study.is_reversible() {
            // one even layer is statistically the same from both sides
            study.angles.exit_strata = 0;
        }
        // colours and contrast ratio are those under D65
        study.paper = Paper { dots: None, ..study.paper };
        study.judgement = Judgement::default();
        study.numbers = Vec::new();
        study.remarks = Vec::new();
        Substack { name, study }
    }

    /// Several layers of the stack as a stack.
    fn of_layers(&self, kept: &[usize]) -> Study {
        let ranges = self.pigments_of_layers();
        let mut study = self.clone();
        study.stack = Vec::new();
        study.pigments = Vec::new();
        study.layer.thickness_um = 0.0;
        study.layer.binder = self.stack[kept[0]].binder.clone();
        let mut layers = Vec::new();
        for (i, &k) in kept.iter().enumerate() {
            let mut layer = self.stack[k].clone();
            let next = kept.get(i + 1).copied();
            // grains reach across what is left out only where they reached across all of it
            let is_open = next.is_some_and(|next| self.stack[k..next].iter().all(|l| l.joint == Joint::Open));
            layer.joint = if is_open { Joint::Open } else { Joint::Wall };
            layers
                .push(StackedRequest { joint: layer.joint, request: self.packing.layers[k].request.clone() });
            study.layer.thickness_um += layer.thickness_um;
            study.pigments.extend(self.pigments[ranges[k].clone()].iter().cloned());
            study.stack.push(layer);
        }
        study.packing = PackingRequest {
            thickness_um: study.layer.thickness_um,
            pigments: study.pigments.iter().map(|pigment| pigment.grains.clone()).collect(),
            relief: layers.iter().find_map(|layer| layer.request.relief),
            layers,
            ..self.packing.clone()
        };
        study
    }

    /// Whether a single layer over a gap is statistically the same from both sides.
    fn is_reversible(&self) -> bool {
        let is_even = self.pigments.iter().all(|pigment| pigment.grains.profile.is_empty());
        let is_drawn = self.packing.is_drawn() && self.packing.relief.is_none();
        self.paper.coupling == Coupling::Gap && is_even && is_drawn
    }
}
