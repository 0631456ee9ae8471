//! The numbers of a stack of plates: of the whole, of what each layer absorbs, and of what the
//! stack is without each layer.

use super::{LayerExtent, LayerTask};
use crate::appearance::composed::fringes::stack_film::StackFilm;
use crate::appearance::composed::stack::{PlateStack, StackElement};
use crate::evaluate::composed::distribution::distribution;
use crate::evaluate::composed::layer::{ComposedLayer, ratio};
use crate::evaluate::composed::level::{Change, Level};
use crate::evaluate::composed::spectral::{lights, spectral};
use crate::evaluate::composed::stacked::{KeptLayers, StackTask};
use crate::evaluate::quantities::{
    ComposedNumbers, DensityNumbers, Distribution, LayerNumbers, LeftOutNumbers, ThicknessNumbers,
};
use crate::input::study::Study;
use crate::wave::Wave;
use rayon::prelude::*;

/// A stack of one thickness.
struct StackNumbers {
    thickness: ThicknessNumbers<f64>,
    /// \[wavelength\]
    distributions: Vec<Distribution<f64>>,
    /// \[wavelength\]\[layer\]
    absorbed: Vec<Vec<f64>>,
}

impl LayerTask<'_> {
    /// All numbers of a stack.
    pub(super) fn numbers_of_stack(
        &self,
        task: &StackTask,
        level: &Level,
        change: Change,
    ) -> ComposedNumbers<f64> {
        let mut numbers = ComposedNumbers::of_requested(Vec::new());
        for um in &self.composed.thicknesses_um {
            // joints and portions are those of the report's first look at them
            let layers = task.layers(level, *um, change).unwrap_or_default();
            let numbers_of = |kept: KeptLayers| self.kept_numbers(task, kept, &layers, change);
            let all = numbers_of(KeptLayers::All);
            if self.extent != LayerExtent::Published {
                numbers.requested.push(all.thickness);
                continue;
            }
            numbers.left_out.extend(self.left_out(&all.thickness.spectra, |kept| numbers_of(kept).thickness));
            numbers.requested.push(all.thickness);
            numbers.distributions.push(all.distributions);
            numbers.absorbed.push(all.absorbed);
        }
        numbers
    }

    /// The numbers of the layers that are kept of a stack.
    fn kept_numbers(
        &self,
        task: &StackTask,
        kept: KeptLayers,
        layers: &[Vec<Vec<StackElement>>],
        change: Change,
    ) -> StackNumbers {
        let stacks = task.joined(kept, layers).unwrap_or_default();
        let Study { wave, output, .. } = self.study;
        let at_wavelength = |(stack, albedo): (&PlateStack, &f64)| {
            let film = stack.film(change.fewer_directions);
            let layer = ComposedLayer::of_stack(stack, &film, *wave);
            let own = spectral(&layer, *wave, output.mirrored_sky, *albedo);
            let absorbed = match kept {
                KeptLayers::All => absorbed_by_layers(stack, &film, *wave, &own.numbers),
                _ => Vec::new(),
            };
            (own, distribution(&layer.plate, layer.media), absorbed)
        };
        let all = stacks.par_iter().zip(&self.albedos).map(at_wavelength).collect::<Vec<_>>();
        let mut layers = Vec::new();
        let mut distributions = Vec::new();
        let mut absorbed = Vec::new();
        for (own, distribution, shares) in all {
            layers.push(own);
            distributions.push(distribution);
            absorbed.push(shares);
        }
        StackNumbers { thickness: self.coloured(self.brightened(layers)), distributions, absorbed }
    }

    /// What a stack of several layers is without each of them, and each by itself, where it has
    /// these spectra and `numbers_of` gives those of the layers that are kept.
    fn left_out(
        &self,
        stack: &[LayerNumbers<f64>],
        numbers_of: impl Fn(KeptLayers) -> ThicknessNumbers<f64>,
    ) -> Option<LeftOutNumbers<f64>> {
        let layers = self.study.stack.len();
        // plates of a library are no print: what any stack of them is, `inkwave compose` tells
        if layers < 2 || self.composed.joint_index.is_some() {
            return None;
        }
        let without: Vec<_> = (0..layers).map(|layer| numbers_of(KeptLayers::AllBut(layer))).collect();
        let alone: Vec<_> = match layers {
            2 => without.iter().rev().cloned().collect(),
            _ => (0..layers).map(|layer| numbers_of(KeptLayers::Only(layer))).collect(),
        };
        let bare = numbers_of(KeptLayers::None).spectra;
        let densities = stack.iter().zip(&bare).enumerate().map(|(w, (stack, bare))| {
            let density = |layer: &LayerNumbers<f64>| -(layer.lit_at_45 / bare.lit_at_45).log10();
            let layers: f64 = alone.iter().map(|layer| density(&layer.spectra[w])).sum();
            DensityNumbers { stack: density(stack), layers, ratio: density(stack) / layers }
        });
        let densities = densities.collect();
        Some(LeftOutNumbers { without, alone, densities })
    }
}

/// Shares of light at 0° that the layers of a stack absorb, without paper; in all what R and T
/// leave.
fn absorbed_by_layers(
    stack: &PlateStack,
    film: &StackFilm,
    wave: Wave,
    numbers: &LayerNumbers<f64>,
) -> Vec<f64> {
    let each = stack.absorbed_at_normal(&lights(stack.before(), wave)[0], film);
    let sum: f64 = each.iter().sum();
    let all = 1.0 - numbers.reflectance_normal - numbers.transmittance_normal;
    each.into_iter().map(|share| share * ratio(all, sum)).collect()
}
