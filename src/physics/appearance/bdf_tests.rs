//! Synthetic speckle: complex Gaussian amplitudes with a known variance.

use super::*;
use crate::wave::Side;
use proptest::prelude::*;
use rand::SeedableRng;
use rand_chacha_normal::complex_normal;

/// Complex Gaussian deviates from the generator the studies use.
mod rand_chacha_normal {
    use num_complex::Complex64;
    use rand::rngs::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    pub fn complex_normal(rng: &mut ChaCha8Rng) -> Complex64 {
        let mut draw = || -> f64 { StandardNormal.sample(rng) };
        Complex64::new(draw(), draw()) * 0.5f64.sqrt()
    }
}

pub(crate) const LAMBDA_UM: f64 = 0.5;
pub(crate) const PERIOD_UM: f64 = 5.0;

/// A far field with ⟨|a|²⟩ = `power` in every diffuse order (plus a coherent amplitude in the
/// specular one); e = cos θ |a|² at normal incidence, so f = power · cos θ · L²/λ².
pub fn speckle(rng: &mut rand::rngs::ChaCha8Rng, power: f64, coherent: f64) -> FarField {
    let reach = (PERIOD_UM / LAMBDA_UM) as i32 + 1;
    let mut orders = Vec::new();
    for m in -reach..=reach {
        for n in -reach..=reach {
            let direction = [m, n].map(|i| f64::from(i) * LAMBDA_UM / PERIOD_UM);
            let square = 1.0 - direction[0].powi(2) - direction[1].powi(2);
            let cos = square.max(0.0).sqrt();
            let shift = if (m, n) == (0, 0) { coherent } else { 0.0 };
            let draw = |rng: &mut _| complex_normal(rng) * power.sqrt() + shift;
            let reflected = draw(rng);
            let transmitted = draw(rng);
            orders.push(Order {
                m,
                n,
                direction,
                reflected_propagates: square > 0.0,
                transmitted_propagates: square > 0.0,
                reflected,
                transmitted,
                reflected_efficiency: cos * reflected.norm_sqr(),
                transmitted_efficiency: cos * transmitted.norm_sqr(),
                further: Default::default(),
            });
        }
    }
    let reflectance = orders.iter().map(|o| o.reflected_efficiency).sum();
    let transmittance = orders.iter().map(|o| o.transmitted_efficiency).sum();
    let incidence =
        Incidence { wavelength_um: LAMBDA_UM, polar_deg: 0.0, azimuth_deg: 0.0, from: Side::Incident };
    let absorptance = 1.0 - reflectance - transmittance;
    let absorbed = Vec::new();
    FarField {
        incidence,
        period_um: [PERIOD_UM; 2],
        orders,
        reflectance,
        transmittance,
        absorptance,
        absorbed,
    }
}

fn ensemble(rng: &mut rand::rngs::ChaCha8Rng, count: usize) -> Vec<FarField> {
    (0..count).map(|_| speckle(rng, 1e-3, 0.3)).collect()
}

pub(crate) fn rng(seed: u64) -> rand::rngs::ChaCha8Rng {
    rand::rngs::ChaCha8Rng::seed_from_u64(seed)
}

proptest! {
    #[test]
    fn orders_sum_to_the_totals_and_parts_to_the_whole(seed in any::<u64>(), count in 1usize..5) {
        let fields = ensemble(&mut rng(seed), count);
        let bdf = Bdf::from_ensemble(&fields).unwrap();
        let cell = LAMBDA_UM.powi(2) / PERIOD_UM.powi(2);
        let sum: f64 = bdf.orders(Lobe::Reflected).iter().map(|o| o.bdf.value * cell).sum();
        let mean = fields.iter().map(|f| f.reflectance).sum::<f64>() / count as f64;
        let totals = bdf.totals(Lobe::Reflected);
        // identities: ∫ f cos θ dω = Σ f λ²/L² = R; sums of 300 terms
        prop_assert!((sum - mean).abs() < 1e-13 && (totals.total.value - mean).abs() < 1e-13);
        prop_assert!((totals.specular.value + totals.diffuse.value - mean).abs() < 1e-13);
        for o in bdf.orders(Lobe::Transmitted) {
            prop_assert_eq!(o.coherent.is_some(), count > 1);
            prop_assert_eq!(o.bdf.standard_error.is_some(), count > 1);
            if let (Some(c), Some(d)) = (o.coherent, o.diffuse) {
                prop_assert!((c + d - o.efficiency.value).abs() < 1e-15);
            }
        }
    }
}

/// (χ² of the smoothed value against its own standard error, mean standard error) over repeated
/// ensembles.
fn calibration(count: usize, repeats: usize) -> (f64, f64) {
    let direction = [0.3, 0.2];
    let truth = 1e-3 * PERIOD_UM.powi(2) / LAMBDA_UM.powi(2);
    let mut chi2 = 0.0;
    let mut error = 0.0;
    for r in 0..repeats {
        let bdf = Bdf::from_ensemble(&ensemble(&mut rng(1000 * count as u64 + r as u64), count)).unwrap();
        let f = bdf.at(Lobe::Reflected, direction, 0.15).unwrap();
        // f ∝ cos θ: the kernel mean of cos θ over the same orders is the expectation
        let weights = bdf.orders(Lobe::Reflected).iter().map(|o| {
            let [a, b] = o.direction;
            let specular = (o.m, o.n) == (0, 0);
            let d = (a - direction[0]).hypot(b - direction[1]) / 0.15;
            (if specular { 0.0 } else { (1.0 - d * d).max(0.0) }, (1.0 - a * a - b * b).sqrt())
        });
        let (sum, cos) = weights.fold((0.0, 0.0), |(s, c), (w, x)| (s + w, c + w * x));
        let standard_error = f.bdf.standard_error.unwrap();
        chi2 += ((f.bdf.value - truth * cos / sum) / standard_error).powi(2);
        error += standard_error / repeats as f64;
    }
    (chi2, error)
}

#[test]
fn standard_errors_are_calibrated_and_fall_as_one_over_root_n() {
    let repeats = 400;
    let (chi2, error_8) = calibration(8, repeats);
    let (_, error_32) = calibration(32, repeats);
    // significance: t² with 7 degrees of freedom has mean 7/5 and variance 2·49·6/(25·3) = 7.84;
    // within 4σ of 400
    let mean = 7.0 / 5.0 * repeats as f64;
    let sigma = (7.84 * repeats as f64).sqrt();
    assert!((chi2 - mean).abs() < 4.0 * sigma, "χ² = {chi2}, expected {mean} ± {sigma}");
    // c4(8)/c4(32) = 0.965/0.992 and 4σ of the spread 1/√(2·7·400)
    let ratio = error_8 / error_32;
    assert!((ratio - 2.0 * 0.965 / 0.992).abs() < 4.0 * 2.0 / (14.0 * repeats as f64).sqrt(), "{ratio}");
}

#[test]
fn coherent_and_diffuse_parts_are_unbiased() {
    let repeats = 2000;
    let parts: Vec<(f64, f64)> = (0..repeats)
        .map(|r| {
            let bdf = Bdf::from_ensemble(&ensemble(&mut rng(7_000_000 + r), 3)).unwrap();
            let specular = bdf.orders(Lobe::Reflected).iter().find(|o| (o.m, o.n) == (0, 0)).unwrap();
            assert_eq!(bdf.totals(Lobe::Reflected).coherent.map(|c| c.value), specular.coherent);
            (specular.coherent.unwrap(), specular.diffuse.unwrap())
        })
        .collect();
    let coherent = Estimate::of_mean(&parts.iter().map(|p| p.0).collect::<Vec<_>>());
    let diffuse = Estimate::of_mean(&parts.iter().map(|p| p.1).collect::<Vec<_>>());
    // significance: 4 standard errors of 2000 ensembles of 3
    assert!((coherent.value - 0.09).abs() < 4.0 * coherent.standard_error.unwrap(), "{coherent:?}");
    assert!((diffuse.value - 1e-3).abs() < 4.0 * diffuse.standard_error.unwrap(), "{diffuse:?}");
}

#[test]
fn one_realisation_has_values_but_no_standard_errors() {
    let bdf = Bdf::from_ensemble(&ensemble(&mut rng(1), 1)).unwrap();
    let f = bdf.azimuthal_mean(Lobe::Reflected, 30.0, 0.1).unwrap();
    assert!(f.bdf.value > 0.0 && f.bdf.standard_error.is_none() && f.effective_orders > 10.0);
    let totals = bdf.totals(Lobe::Transmitted);
    assert!(totals.total.standard_error.is_none() && totals.coherent.is_none());
}

#[test]
fn a_lambertian_lobe_is_flat_after_smoothing() {
    // e = cos θ |a|² with |a|² = ρ λ²/(π L² cos θ): f = ρ/π everywhere, no speckle
    let mut field = speckle(&mut rng(3), 1.0, 0.0);
    let cell = LAMBDA_UM.powi(2) / PERIOD_UM.powi(2);
    for o in &mut field.orders {
        o.reflected_efficiency = if o.reflected_propagates { 0.8 / std::f64::consts::PI * cell } else { 0.0 };
    }
    let bdf = Bdf::from_ensemble(&[field]).unwrap();
    for deg in [0.0, 20.0, 45.0, 60.0] {
        let direction = [deg_sin(deg), 0.0];
        for f in [bdf.azimuthal_mean(Lobe::Reflected, deg, 0.12), bdf.at(Lobe::Reflected, direction, 0.12)] {
            approx::assert_relative_eq!(
                f.unwrap().bdf.value,
                0.8 / std::f64::consts::PI,
                max_relative = 1e-13
            );
        }
    }
    // 305 lattice points lie inside the circle of radius 10, whose area is 314.16 (Gauss)
    let counted = 0.8 * 305.0 / (100.0 * std::f64::consts::PI);
    approx::assert_relative_eq!(bdf.totals(Lobe::Reflected).total.value, counted, max_relative = 1e-13);
}

fn deg_sin(deg: f64) -> f64 {
    deg.to_radians().sin()
}

#[test]
fn mixed_or_broken_ensembles_are_refused() {
    let fields = ensemble(&mut rng(5), 2);
    assert_eq!(Bdf::from_ensemble(&[]).unwrap_err(), BdfError::Empty);
    let mut other = fields.clone();
    other[1].incidence.polar_deg = 10.0;
    assert_eq!(Bdf::from_ensemble(&other).unwrap_err(), BdfError::Mixed { index: 1, field: "incidence" });
    let mut short = fields.clone();
    short[1].orders.pop();
    assert_eq!(Bdf::from_ensemble(&short).unwrap_err(), BdfError::Mixed { index: 1, field: "orders" });
    let mut broken = fields.clone();
    broken[1].orders[0].reflected.re = f64::NAN;
    assert!(matches!(Bdf::from_ensemble(&broken).unwrap_err(), BdfError::NotFinite { index: 1, .. }));
    let bdf = Bdf::from_ensemble(&fields).unwrap();
    assert!(bdf.at(Lobe::Reflected, [0.0, 0.0], 0.0).is_err());
    assert!(bdf.at(Lobe::Reflected, [1.2, 0.0], 0.5).is_err());
    assert!(bdf.at(Lobe::Reflected, [0.05, 0.05], 0.01).unwrap_err().to_string().contains("no order"));
    assert!(bdf.azimuthal_mean(Lobe::Reflected, f64::NAN, 0.1).is_err());
}
