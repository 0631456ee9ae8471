//! The layers of a study: one, or those of a stack.

use super::{IndexSpectrum, StackLayer, Study};
use crate::ink::{PackingRequest, StackedRequest};
use crate::wave::mean_of_rays;
use num_complex::Complex64;
use std::ops::Range;

/// Seeds of the layers of a stack differ by this: 2⁶⁴ over the golden ratio. The first has the
/// study's.
const NEXT_SEED: u64 = 0x9E37_79B9_7F4A_7C15;

impl Study {
    /// Binders of the layers, in the order of the light.
    pub fn binders(&self) -> Vec<&IndexSpectrum> {
        match self.stack.is_empty() {
            true => vec![&self.layer.binder],
            false => self.stack.iter().map(|layer| &layer.binder).collect(),
        }
    }

    /// The binder of a layer.
    pub(super) fn binder_mut(&mut self, layer: usize) -> &mut IndexSpectrum {
        if self.stack.is_empty() { &mut self.layer.binder } else { &mut self.stack[layer].binder }
    }

    /// Thicknesses of the layers where the whole is `thickness_um` thick, µm: what it has more or
    /// less than the mean is in the uneven layer.
    pub fn layers_um(&self, thickness_um: f64) -> Vec<f64> {
        let more_um = thickness_um - self.layer.thickness_um;
        let own = |layer: &StackLayer| match layer.thickness_std_um > 0.0 {
            true => layer.thickness_um + more_um,
            false => layer.thickness_um,
        };
        if self.stack.is_empty() { vec![thickness_um] } else { self.stack.iter().map(own).collect() }
    }

    /// Pigments with grains of each layer, as ranges of [`Study::pigments`].
    pub fn pigments_of_layers(&self) -> Vec<Range<usize>> {
        let of_layers: Vec<usize> = match self.stack.is_empty() {
            true => vec![self.pigments.len()],
            false => self.stack.iter().map(|layer| layer.pigments).collect(),
        };
        let mut first = 0;
        let mut ranges = Vec::new();
        for count in of_layers {
            ranges.push(first..first + count);
            first += count;
        }
        ranges
    }

    /// Layer of a pigment with grains, by its number.
    pub fn layer_of_pigment(&self, pigment: usize) -> usize {
        let ranges = self.pigments_of_layers();
        ranges.iter().position(|range| range.contains(&pigment)).unwrap_or(0)
    }

    /// Layer of every material in the order of [`Study::materials`].
    pub fn layers_of_materials(&self) -> Vec<usize> {
        let cores = (0..self.pigments.len()).map(|pigment| self.layer_of_pigment(pigment));
        let shells = self.pigments.iter().enumerate();
        let shells = shells.flat_map(|(k, pigment)| vec![self.layer_of_pigment(k); pigment.shell.len()]);
        cores.chain(shells).collect()
    }

    /// Thickness of the layer that holds each pigment, where the whole is `thickness_um` thick, µm.
    pub fn thicknesses_of_pigments_um(&self, thickness_um: f64) -> Vec<f64> {
        let ranges = self.pigments_of_layers().into_iter().zip(self.layers_um(thickness_um));
        ranges.flat_map(|(range, um)| vec![um; range.len()]).collect()
    }

    /// Volume of the layer that holds each pigment, in the nominal cell, µm³.
    pub fn volumes_of_pigments_um3(&self) -> Vec<f64> {
        let [x, y] = self.layer.period_um;
        let thicknesses_um = self.thicknesses_of_pigments_um(self.layer.thickness_um);
        thicknesses_um.into_iter().map(|um| x * y * um).collect()
    }

    /// Indices of the binders of all layers, and of all materials, at one wavelength; of
    /// birefringent pigments that of the mean over all directions of the axis.
    pub(super) fn binders_and_pigments(&self, wavelength_um: f64) -> (Vec<Complex64>, Vec<Complex64>) {
        let of_layers = self.layers_of_materials();
        let shares = self.material_shares();
        let mut inclusions: Vec<Complex64> = self.materials().map(|m| m.index_at(wavelength_um)).collect();
        for (inclusion, pigment) in inclusions.iter_mut().zip(&self.pigments) {
            let other = pigment.extraordinary.as_ref().map(|other| other.index_at(wavelength_um));
            *inclusion = mean_of_rays([*inclusion, other.unwrap_or(*inclusion)]);
        }
        let mut backgrounds = Vec::new();
        for (layer, binder) in self.binders().into_iter().enumerate() {
            let own: Vec<usize> = (0..of_layers.len()).filter(|&m| of_layers[m] == layer).collect();
            let own_shares: Vec<f64> = own.iter().map(|&m| shares[m]).collect();
            let own_indices: Vec<Complex64> = own.iter().map(|&m| inclusions[m]).collect();
            let binder = binder.index_at(wavelength_um);
            let (background, indices) = self.layer.contrast.of(binder, &own_shares, &own_indices);
            backgrounds.push(background);
            own.into_iter().zip(indices).for_each(|(m, index)| inclusions[m] = index);
        }
        (backgrounds, inclusions)
    }

    /// The packing of a stack in the cell of a realisation: every layer with its thickness and its
    /// own random stream, and `signs` of the deviations of its pigments' volumes from those
    /// requested, if cells come in pairs.
    pub(super) fn stacked(&self, whole: PackingRequest, signs: Option<&[f64]>) -> PackingRequest {
        let layers_um = self.layers_um(whole.thickness_um);
        let ranges = self.pigments_of_layers();
        let mut layers = Vec::with_capacity(whole.layers.len());
        for (i, StackedRequest { request, joint }) in whole.layers.iter().enumerate() {
            let request = PackingRequest {
                period_um: whole.period_um,
                thickness_um: layers_um[i],
                seed: whole.seed.wrapping_add(NEXT_SEED.wrapping_mul(i as u64)),
                stream: whole.stream,
                ..request.clone()
            };
            let signs = signs.map(|signs| &signs[ranges[i].clone()]).filter(|own| !own.is_empty());
            let request = signs.map_or_else(|| request.clone(), |own| request.fluctuating(own));
            layers.push(StackedRequest { request, joint: *joint });
        }
        let pigments = layers.iter().flat_map(|layer| layer.request.pigments.clone()).collect();
        PackingRequest { pigments, layers, ..whole }
    }
}
