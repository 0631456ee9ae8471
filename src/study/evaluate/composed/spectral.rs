//! A composed layer or a stack at one wavelength: what it reflects and transmits, and what
//! instruments read of it on its paper.

use super::layer::{ComposedLayer, OnPaper, polarised, ratio};
use crate::appearance::composed::flux::Hemisphere;
use crate::appearance::composed::plate::{Plate, total};
use crate::appearance::paper::{MirroredSky, PRINT_DEG, lost_in_a_round};
use crate::appearance::paper_series::{AreaMix, AreaOptics};
use crate::evaluate::ink_maker::{BLACK, WHITE};
use crate::evaluate::prints::Brightened;
use crate::evaluate::quantities::LayerNumbers;
use crate::wave::Wave;
use faer::Mat;

/// A layer or a stack at one wavelength.
pub struct SpectralLayer {
    /// Its numbers.
    pub numbers: LayerNumbers<f64>,
    /// As light at 45:0 and light between it and the paper meet it.
    pub(super) at_45: AreaOptics,
    /// The parts of its factors under natural light and at 45:0 that the paper emits.
    pub(super) emitted: [f64; 2],
}

/// A layer or a stack at one wavelength, alone and on paper of this albedo.
pub fn spectral(layer: &ComposedLayer, wave: Wave, sky: MirroredSky, albedo: f64) -> SpectralLayer {
    let [before, behind] = layer.media;
    let oblique = before.ordinates.index * PRINT_DEG.to_radians().sin();
    let [at_normal, at_45, of_diffuse] = lights(before, wave);
    let normal = layer.of_light(&at_normal);
    let normal_changed = normal.changed(layer.change(0.0));
    let slanted = layer.of_light(&at_45).changed(layer.change_of_shared(oblique));
    let diffuse = layer.of_light(&of_diffuse).changed(layer.change_of_diffuse());
    let beam = layer.change_of_beam();
    let straight = layer.plate.transmission[0][(0, 0)] + beam.transmitted;
    let mirrored = layer.plate.reflection[0][(0, 0)] + beam.reflected;
    let mirrored = mirrored.max(0.0).min(normal_changed.reflected);
    // what returns from the paper has passed at 0°, and passes at 45°
    let through_normal = ratio(normal_changed.transmitted, normal.transmitted);
    let through_45 = ratio(slanted.transmitted, layer.transmitted_by_nodes(oblique));
    let paper = layer.on(albedo);
    let returned = total(&(&paper.plate.reflection[0] * &at_normal)) - normal.reflected;
    let natural = normal_changed.reflected + through_normal * paper.returned * paper.leaving * returned;
    let excluded = if sky == MirroredSky::Excluded { mirrored } else { 0.0 };
    let alone = lit_at_45(&layer.plate, before, wave);
    let lit = |on: &OnPaper| {
        let returned = lit_at_45(&on.plate, before, wave) - alone;
        alone + through_normal * through_45 * on.returned * returned
    };
    let on_paper = lit(&paper);
    let at_45 = AreaOptics {
        own: alone,
        entering: slanted.transmitted,
        leaving: normal_changed.transmitted / behind.ordinates.index.powi(2),
        lost: 1.0 - paper.back,
    };
    // fluxes go through the nodes, means do not: as a solid, dots give what the fluxes give
    let series = at_45.entering * at_45.leaving * albedo / lost_in_a_round(albedo, at_45.lost);
    let at_45 = AreaOptics { leaving: at_45.leaving * ratio(on_paper - alone, series), ..at_45 };
    let numbers = LayerNumbers {
        reflectance_normal: normal_changed.reflected,
        transmittance_normal: normal_changed.transmitted,
        reflectance_45: slanted.reflected,
        transmittance_45: slanted.transmitted,
        reflectance_diffuse: diffuse.reflected,
        transmittance_diffuse: diffuse.transmitted,
        absorptance_behind: paper.absorbed,
        coherent_transmittance: straight.max(0.0).min(normal_changed.transmitted),
        mirrored,
        natural_light: natural - excluded,
        lit_at_45: on_paper,
        over_black: lit(&layer.on(BLACK)),
        over_white: lit(&layer.on(WHITE)),
    };
    SpectralLayer { numbers, at_45, emitted: [0.0; 2] }
}

/// Layers at every wavelength on paper of these albedos, with what the paper emits under a light.
pub(super) fn brightened(
    mut all: Vec<SpectralLayer>,
    light: &Brightened,
    wavelengths_nm: &[f64],
    albedos: &[f64],
) -> Vec<SpectralLayer> {
    let at_45: Vec<AreaOptics> = all.iter().map(|layer| layer.at_45).collect();
    let of_sky =
        |layer: &SpectralLayer| AreaOptics { entering: layer.numbers.transmittance_diffuse, ..layer.at_45 };
    let natural: Vec<AreaOptics> = all.iter().map(of_sky).collect();
    let mix = AreaMix::whole();
    let lit = light.below(&mix, &[&at_45], wavelengths_nm).relative(wavelengths_nm);
    let sky = light.below(&mix, &[&natural], wavelengths_nm).relative(wavelengths_nm);
    for (((layer, lit), sky), albedo) in all.iter_mut().zip(lit).zip(sky).zip(albedos) {
        let leaving = layer.at_45.leaving / lost_in_a_round(*albedo, layer.at_45.lost);
        layer.emitted = [sky, lit].map(|kinds| leaving * kinds.iter().sum::<f64>());
        let [natural_light, lit_at_45] = layer.emitted;
        layer.numbers.lit_at_45 += lit_at_45;
        layer.numbers.natural_light += natural_light;
    }
    all
}

/// Unit fluxes of light at 0°, at 45° and of diffuse light.
pub fn lights(medium: &Hemisphere, wave: Wave) -> [Mat<f64>; 3] {
    let shares = polarised(medium, wave);
    let mut all: [Mat<f64>; 3] = std::array::from_fn(|_| Mat::zeros(medium.states(), 1));
    all[0][(0, 0)] = 1.0;
    let nodes = medium.ordinates.count();
    let sum = medium.ordinates.weights.iter().sum::<f64>();
    for (polarisation, share) in shares.into_iter().enumerate() {
        if medium.oblique_deg.is_some() {
            all[1][(medium.state(nodes + 1, polarisation), 0)] = share;
        }
        for node in 0..nodes {
            all[2][(medium.state(node + 1, polarisation), 0)] = share * medium.ordinates.weights[node] / sum;
        }
    }
    all
}

/// π × BRDF at 45:0, by reciprocity: light at 0° that leaves at 45°.
fn lit_at_45(plate: &Plate, medium: &Hemisphere, wave: Wave) -> f64 {
    let sine = medium.ordinates.index * PRINT_DEG.to_radians().sin();
    let shares = polarised(medium, wave);
    let brdf = |(node, share): (usize, f64)| {
        let flux = |p: usize| plate.reflection[0][(medium.state(node + 1, p), 0)];
        let reflected: f64 = shares.iter().enumerate().map(|(p, s)| shares.len() as f64 * s * flux(p)).sum();
        share * reflected / medium.ordinates.weights[node]
    };
    medium.ordinates.shares(sine).into_iter().map(brdf).sum()
}
