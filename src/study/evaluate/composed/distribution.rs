//! The distribution functions of a composed layer lit at 0°, in the directions of its nodes.

use crate::appearance::composed::flux::Hemisphere;
use crate::appearance::composed::plate::Plate;
use crate::evaluate::quantities::Distribution;
use faer::Mat;
use std::f64::consts::PI;

/// BRDF and BTDF of light at 0° in the directions of the media in front and behind, per steradian.
/// The mirrored and the straight beam are left out, and what interference changes.
pub(super) fn distribution(layer: &Plate, [before, behind]: [&Hemisphere; 2]) -> Distribution<f64> {
    let per_sr = |fluxes: &Mat<f64>, medium: &Hemisphere| {
        let flux =
            |node| (0..medium.polarisations).map(|p| fluxes[(medium.state(node + 1, p), 0)]).sum::<f64>();
        (0..medium.ordinates.count()).map(|node| flux(node) / projected_sr(medium, node)).collect()
    };
    Distribution {
        reflected: per_sr(&layer.reflection[0], before),
        transmitted: per_sr(&layer.transmission[0], behind),
    }
}

/// Projected solid angle that a node stands for, ∫ cos θ dω, sr.
pub fn projected_sr(medium: &Hemisphere, node: usize) -> f64 {
    PI * medium.ordinates.weights[node] / medium.ordinates.index.powi(2)
}
