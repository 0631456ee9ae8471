//! The layer on a Lambertian substrate: light going back and forth between the layer and the paper (P1 section 5).
//!
//! With T(θ), R(θ) from the incident side, R_b(θ) from the exit side (totals, specular and diffuse), ρ the albedo of the paper:
//!
//! ```text
//! R̄_b = 2∫₀¹ R_b(μ) μ dμ     g = ρ/(1 − ρ R̄_b)     T̄ = 2∫₀¹ T(μ) μ dμ
//! f(i, o) = f_layer(i, o) + g T(i) T(o)/π           albedo(i) = R(i) + g T(i) T̄
//! uniform sky of radiance 1, seen at o:  R(o) + g T(o) T̄
//! ```
//!
//! T(o) of the light that leaves equals T from the incident side at o by reciprocity, with roughness and absorption too.
//! [`Coupling::Gap`] is the paper's model: a thin gap, no interference between layer and paper.
//! [`Coupling::OpticalContact`] has the paper's scatterers in a medium of index n that touches the layer: the solves
//! then have n behind the layer, R_b is taken over the angles inside that medium (total internal reflection included) and
//! radiance that leaves drops by n²: g → g/n². Its limit for a plane film matched to the medium is Williams & Clapper
//! (1953). A clear film of 1.558 on paper 0.9 has π f(0→0) = 0.910 with a (coherent) gap, 0.818 in contact.
//!
//! R̄_b is not taken from a quadrature of its own. Reciprocity gives the mean transmittance of the exit side as T̄/n², so
//!
//! ```text
//! R̄_b = 1 − T̄/n² − Ā_b        g = ρ/(1 − ρ (1 − T̄/n² − Ā_b))
//! ```
//!
//! and only the absorption Ā_b is asked from the exit side. A layer that absorbs nothing on a perfect white then has
//! R + g T T̄ = R + T = 1 exactly, whatever the directions solved for (the furnace); with two unrelated quadratures their
//! mismatch would be amplified by g.
//!
//! R, T and A are those of whatever light was solved: the scalar wave (s-polarised light), s, p, or unpolarised. What the paper
//! gives back is unpolarised.

pub use super::error::PaperError;
pub use super::substrate::{Albedo, Coupling, Substrate};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Illumination of print measurement (ISO 13655: 45°:0°), the second angle that every colour needs, degrees.
pub const PRINT_DEG: f64 = 45.0;
/// Light that never leaves: below this share a layer on paper is a closed box.
const LEAST_ESCAPE: f64 = 1e-12;

/// Whether light of the sky mirrored by the layer counts: P1 leaves it open.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum MirroredSky {
    /// R(o) + g T(o) T̄: all the light of a uniform sky.
    #[default]
    Included,
    /// Without the specular order, as when a viewer turns the print to avoid glare.
    Excluded,
}

/// g = ρ/(1 − ρ R̄_b) over n², with R̄_b = 1 − T̄/n² − Ā_b: `transmitted` is T̄ from the incident side, `absorbed` is Ā_b from the
/// exit side, `index` the medium's there (1 for a gap).
///
/// # Errors
/// An albedo outside 0–1, or light that never leaves.
pub fn returned(albedo: f64, transmitted: f64, absorbed: f64, index: f64) -> Result<f64, PaperError> {
    if !(0.0..=1.0).contains(&albedo) {
        return Err(PaperError::Albedo { value: albedo });
    }
    let escaping = transmitted / (index * index);
    let reflected = 1.0 - escaping - absorbed;
    // 1 − ρ R̄_b, written so that it is T̄/n² + Ā_b without rounding for a perfect white
    let lost = (1.0 - albedo) + albedo * (escaping + absorbed);
    if lost.is_nan() || lost < LEAST_ESCAPE {
        return Err(PaperError::TrapsAllLight { mean: reflected });
    }
    Ok(albedo / lost / (index * index))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// The furnace: no losses on a perfect white send back all light, whatever the means.
        #[test]
        fn a_lossless_layer_on_white_paper_sends_everything_back(t in 0.01..1.0f64, index in 1.0..2.0f64, at in 0.0..1.0f64) {
            let g = returned(1.0, t, 0.0, index).unwrap();
            // identity: rounding
            prop_assert!(((1.0 - at) + g * at * t - 1.0).abs() < 1e-14);
        }

        /// The geometric series: what enters, is reflected by the paper, comes back from the layer, and so on.
        #[test]
        fn the_returns_are_a_geometric_series(rho in 0.0..0.95f64, t in 0.05..0.6f64, a in 0.0..0.4f64, index in 1.0..1.6f64) {
            let back = 1.0 - t / (index * index) - a;
            let series: f64 = (0..2000).map(|k| rho * (rho * back).powi(k)).sum::<f64>() / (index * index);
            prop_assert!((returned(rho, t, a, index).unwrap() - series).abs() < 1e-12);
        }
    }

    #[test]
    fn what_cannot_be_is_refused() {
        assert!(matches!(returned(1.0, 0.0, 0.0, 1.0), Err(PaperError::TrapsAllLight { .. })));
        assert!(matches!(returned(1.5, 0.5, 0.0, 1.0), Err(PaperError::Albedo { .. })));
        assert!(returned(0.9, f64::NAN, 0.0, 1.0).is_err());
    }
}
