//! The slab that resembles a layer most: it carries the fringes, so that few angles suffice for the rest.

use super::angles::AngleRule;
use super::paper::LayerOptics;
use super::slab::Slab;
use num_complex::Complex64;

const ITERATIONS: usize = 25;
/// Step of the numerical derivatives in n and κ.
const STEP: f64 = 1e-6;

impl LayerOptics {
    /// Replaces the baseline by the slab whose R and T at the rule's angles are nearest to the layer's specular ones:
    /// the effective medium that the coherent wave sees, extinction by scattering included (least squares with the
    /// rule's weights, two unknowns n and κ ≥ 0, Levenberg–Marquardt from the baseline given).
    ///
    /// The baseline changes no result in the limit of many angles, only how fast it is reached. Nothing happens without
    /// a baseline.
    pub fn fit_baseline(&mut self, rule: &AngleRule) {
        if let Some(start) = self.baseline {
            self.baseline = Some(fit(rule, self, start));
        }
    }
}

fn fit(rule: &AngleRule, layer: &LayerOptics, start: Slab) -> Slab {
    let (mut best, mut residuals) = (start, residuals(rule, layer, start));
    let mut damping = 1e-3;
    for _ in 0..ITERATIONS {
        let trial = step(rule, layer, best, &residuals, damping);
        let moved = self::residuals(rule, layer, trial);
        if square(&moved) < square(&residuals) {
            let gain = 1.0 - square(&moved) / square(&residuals);
            (best, residuals, damping) = (trial, moved, damping / 10.0);
            if gain < 1e-9 {
                break;
            }
        } else {
            damping *= 10.0;
        }
    }
    best
}

/// Weighted differences layer − slab of the specular R and T.
fn residuals(rule: &AngleRule, layer: &LayerOptics, slab: Slab) -> Vec<f64> {
    let own = LayerOptics::homogeneous(rule, slab);
    let above = rule.above.iter().zip(&layer.specular).zip(&own.specular);
    let through = rule.above.iter().zip(&layer.specular_transmittance).zip(&own.specular_transmittance);
    above.chain(through).map(|((node, a), b)| node.weight.sqrt() * (a - b)).collect()
}

fn square(residuals: &[f64]) -> f64 {
    residuals.iter().map(|r| r * r).sum()
}

/// One damped Gauss–Newton step in (n, κ).
fn step(rule: &AngleRule, layer: &LayerOptics, slab: Slab, at: &[f64], damping: f64) -> Slab {
    let moved = |by: Complex64| residuals(rule, layer, Slab { index: slab.index + by, ..slab });
    let slope =
        |by: Complex64| -> Vec<f64> { moved(by).iter().zip(at).map(|(m, r)| (m - r) / STEP).collect() };
    let (dn, dk) = (slope(STEP.into()), slope(Complex64::new(0.0, STEP)));
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
    let (nn, nk, kk) = (dot(&dn, &dn) * (1.0 + damping), dot(&dn, &dk), dot(&dk, &dk) * (1.0 + damping));
    let (gn, gk) = (dot(&dn, at), dot(&dk, at));
    let determinant = nn * kk - nk * nk;
    if determinant.is_nan() || determinant <= 0.0 {
        return slab;
    }
    let n = slab.index.re - (kk * gn - nk * gk) / determinant;
    let kappa = slab.index.im - (nn * gk - nk * gn) / determinant;
    Slab { index: Complex64::new(n.clamp(0.5, 5.0), kappa.clamp(0.0, 5.0)), ..slab }
}
