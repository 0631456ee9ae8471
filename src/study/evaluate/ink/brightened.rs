//! The ink on paper that fluoresces: what the paper emits below it depends on the layer at all
//! shorter wavelengths.

use super::{InkOnPaper, MovedNodes, Sight};
use crate::appearance::paper::{PRINT_DEG, PaperError};
use crate::appearance::paper_series::{AreaMix, AreaOptics};
use crate::appearance::tristimulus::{Colorimeter, EmissionWeights};
use crate::evaluate::on_paper::{Emitted, EmittedShare, LayerOnPaper, PolarAngle};
use crate::evaluate::prints::Brightened;
use std::ops::Range;

/// Step of the differences that stand for derivatives by R and T.
const STEP: f64 = 1e-4;

impl InkOnPaper {
    /// The ink on its paper under another light, where the paper fluoresces.
    ///
    /// # Errors
    /// None: 45° and 0° are within the hemisphere.
    pub(in crate::evaluate) fn lit_by(mut self, brightened: &Brightened) -> Result<Self, PaperError> {
        let light = self.at(PRINT_DEG)?;
        let view = self.at(0.0)?;
        let fitted = self.places.outputs.end.max(self.places.colours.end);
        let kept =
            self.moved.iter().flat_map(|MovedNodes { few, moved }| [*few].into_iter().chain(moved.clone()));
        let first = kept.clone().min().unwrap_or(self.whole.len());
        let blocks: Vec<[usize; 2]> =
            [[0, first]].into_iter().chain(kept.map(|start| [start, start + fitted])).collect();
        let mut whole = self.whole.clone();
        for [from, to] in blocks {
            let emitted = self.emitted(&self.whole[from..to], [&light, &view], brightened);
            whole[from..to].iter_mut().zip(emitted).for_each(|(layer, emitted)| layer.emitted = emitted);
        }
        let mut replicates = self.replicates.clone();
        for layers in &mut replicates {
            let emitted = self.emitted(layers, [&light, &view], brightened);
            layers.iter_mut().zip(emitted).for_each(|(layer, emitted)| layer.emitted = emitted);
        }
        self.whole = whole;
        self.replicates = replicates;
        Ok(self)
    }

    /// What the paper emits below each of these layers, of which the first are those of the
    /// spectra.
    fn emitted(
        &self,
        layers: &[LayerOnPaper],
        [light, view]: [&PolarAngle; 2],
        brightened: &Brightened,
    ) -> Vec<Emitted> {
        let outputs_nm = self.wavelengths_nm();
        let seen = &layers[..outputs_nm.len()];
        let at_45: Vec<AreaOptics> = seen.iter().map(|layer| layer.optics(light, view)).collect();
        let natural: Vec<AreaOptics> = seen
            .iter()
            .zip(&at_45)
            .map(|(layer, optics)| AreaOptics { entering: layer.mean_transmittance(), ..*optics })
            .collect();
        let places_nm: Vec<f64> = layers.iter().map(|layer| self.wavelength_nm(layer)).collect();
        let lit_at_45 = shares(&at_45, outputs_nm, &places_nm, brightened);
        let natural = shares(&natural, outputs_nm, &places_nm, brightened);
        let powers = brightened.lamp_powers(&places_nm);
        let both = natural.into_iter().zip(lit_at_45).enumerate();
        both.map(|(i, (natural, lit_at_45))| Emitted {
            natural,
            lit_at_45,
            lamp_power: powers.as_ref().map(|powers| powers[i]),
        })
        .collect()
    }

    /// How an eye sums what the paper emits at these nodes, where a lamp with lines excites it.
    pub(in crate::evaluate) fn emission(
        &self,
        meter: &Colorimeter,
        nodes: &Range<usize>,
    ) -> Option<EmissionWeights> {
        let power = |layer: &LayerOnPaper| layer.emitted.lamp_power;
        let powers: Option<Vec<f64>> = self.whole[nodes.clone()].iter().map(power).collect();
        powers.filter(|_| meter.viewing().has_lines()).map(|powers| meter.emission(&powers))
    }

    /// What light that is emitted between the wavelengths of the spectra does to Lab, as far as the
    /// coherent film tells.
    pub(super) fn emission_between(
        &self,
        sight: &Sight,
        xyz: [f64; 3],
        quantity: &impl Fn(&LayerOnPaper) -> f64,
    ) -> Option<[f64; 3]> {
        let [on_grid, fine] = self.guides(sight);
        let emitted = |nodes: &Range<usize>, meter: &Colorimeter| {
            Some(self.emission(meter, nodes)?.xyz(&emitted_parts(&self.whole[nodes.clone()], quantity)))
        };
        let closely = Colorimeter::under(&self.nodes.wavelengths_nm[fine.clone()], sight.meter.viewing());
        let closely = emitted(fine, &closely.ok()?)?;
        let own = emitted(on_grid, &sight.meter)?;
        let here = sight.meter.colour_of(xyz).lab;
        let there = sight.meter.colour_of(std::array::from_fn(|c| xyz[c] + closely[c] - own[c])).lab;
        Some(std::array::from_fn(|i| there[i] - here[i]))
    }
}

/// The parts of a quantity that the paper emits.
pub(in crate::evaluate) fn emitted_parts(
    layers: &[LayerOnPaper],
    quantity: &impl Fn(&LayerOnPaper) -> f64,
) -> Vec<f64> {
    layers.iter().map(|layer| quantity(layer) - quantity(&layer.dark())).collect()
}

/// S/E at these places, and its derivatives by R and T of all wavelengths together.
fn shares(
    optics: &[AreaOptics],
    outputs_nm: &[f64],
    places_nm: &[f64],
    brightened: &Brightened,
) -> Vec<EmittedShare> {
    let emitted = |change: &dyn Fn(&AreaOptics) -> AreaOptics| -> Vec<f64> {
        let moved: Vec<AreaOptics> = optics.iter().map(change).collect();
        let light = brightened.below(&AreaMix::whole(), &[&moved], outputs_nm);
        light.relative(places_nm).iter().map(|kinds| kinds.first().copied().unwrap_or(0.0)).collect()
    };
    let here = emitted(&|area| *area);
    let by_r = emitted(&|area| AreaOptics { lost: area.lost - STEP, ..*area });
    let by_t = emitted(&|area| AreaOptics { entering: area.entering + STEP, ..*area });
    let share = |i: usize| [here[i], (by_r[i] - here[i]) / STEP, (by_t[i] - here[i]) / STEP];
    (0..here.len()).map(share).collect()
}

#[cfg(test)]
#[path = "brightened_tests.rs"]
mod tests;
