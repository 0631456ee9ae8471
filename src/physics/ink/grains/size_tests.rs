//! Tests of [`super`].

use super::*;
use crate::numerics::estimate::Estimate;

#[test]
fn draws_follow_their_moments_and_never_leave_the_cut() {
    let law = SizeDistribution::LogNormal {
        median_nm: 200.0,
        sigma: 0.3,
        by: By::Number,
        cut_at_sigmas: 3.0,
        of: Measure::EffectiveDiameter,
    };
    let mut draws = Draws::new(3, 0);
    let logs: Vec<f64> = (0..40_000).map(|_| law.draw_nm(&mut draws).ln()).collect();
    let mean = logs.iter().sum::<f64>() / 4e4;
    // Significance: four standard errors 0.3/√40000 = 0.0015 of the mean.
    assert!((mean - 200f64.ln()).abs() < 4.0 * 0.0015);
    let widest = logs.iter().map(|l| (l - 200f64.ln()).abs()).fold(0.0, f64::max);
    assert!(widest <= 0.9 + 1e-12 && law.largest_nm() >= 200.0 * widest.exp() * (1.0 - 1e-12));
}

/// Percentiles out of order, or of no log-normal distribution, are rejected; a slight skew is
/// accepted.
#[test]
fn percentiles_have_to_be_those_of_a_log_normal_law() {
    let law = |[d10_nm, d50_nm, d90_nm]: [f64; 3]| SizeDistribution::Percentiles {
        d10_nm,
        d50_nm,
        d90_nm,
        by: By::Volume,
        of: Measure::EffectiveDiameter,
    };
    assert_eq!(law([100.0, 200.0, 400.0]).defect(), None);
    assert_eq!(law([104.0, 200.0, 400.0]).defect(), None);
    for unordered in [[200.0, 100.0, 400.0], [100.0, 100.0, 100.0], [f64::NAN, 1.0, 2.0], [-1.0, 1.0, 2.0]] {
        assert!(law(unordered).defect().unwrap().2.contains("d10_nm below d50_nm"), "{unordered:?}");
    }
    let (_, found, allowed) = law([150.0, 200.0, 400.0]).defect().unwrap();
    assert!(found.contains("the log-normal law has d10 122.5, d90 326.6 nm"), "{found}");
    assert!(allowed.contains("within 5 %"), "{allowed}");
    assert!(law([1.0, 1000.0, 1e6]).defect().is_some());
}

#[test]
fn list_weights_set_the_frequencies() {
    let values_nm = vec![100.0, 300.0];
    let law = SizeDistribution::List { values_nm, weights: vec![1.0, 3.0], of: Measure::Radius };
    let mut draws = Draws::new(3, 0);
    let large = (0..10_000).filter(|_| law.draw_nm(&mut draws) == 300.0).count() as f64;
    // Significance: four standard deviations √(n p q) = 43.
    assert!((large - 7500.0).abs() < 4.0 * 43.4, "{large}");
}

#[test]
fn mass_at_zero_is_refused() {
    let law = |standard_deviation_nm| SizeDistribution::Normal {
        mean_nm: 100.0,
        standard_deviation_nm,
        cut_at_sigmas: 3.0,
        of: Measure::Radius,
    };
    assert!(law(40.0).defect().is_some());
    assert!(law(30.0).defect().is_none());
}

/// Quantile of the sizes by number or by volume, from many evenly spaced quantiles.
fn reached(law: &SizeDistribution, share: f64, power: i32) -> f64 {
    let steps = 400_000;
    let sizes: Vec<f64> = (0..steps).map(|i| law.quantile_nm((i as f64 + 0.5) / f64::from(steps))).collect();
    let mut left = share * sizes.iter().map(|d| d.powi(power)).sum::<f64>();
    let below = |d: &&f64| {
        left -= d.powi(power);
        left < 0.0
    };
    *sizes.iter().find(below).unwrap()
}

/// The grains' volumes reproduce d10, d50 and d90 as given, and their number the percentiles of
/// Hatch and Choate.
/// *Planted*: percentiles by volume taken for those by number differ by 3σ² = 0.69 in ln(size).
#[test]
fn percentiles_come_back_by_volume_and_by_number() {
    let of = Measure::EffectiveDiameter;
    let d10_nm = 108.0;
    let d50_nm = 200.0;
    let d90_nm = 370.0;
    let sigma = LogNormalLaw::sigma_of(d10_nm, d90_nm);
    for (by, power, other) in [(By::Volume, 3, -1.0), (By::Number, 0, 1.0)] {
        let laws = [
            SizeDistribution::Percentiles { d10_nm, d50_nm, d90_nm, by, of },
            SizeDistribution::LogNormal { median_nm: d50_nm, sigma, by, cut_at_sigmas: 3.0, of },
        ];
        for law in laws {
            for (share, want) in [(0.1, d10_nm), (0.5, d50_nm), (0.9, d90_nm)] {
                let got = reached(&law, share, power);
                // truncation at three deviations shifts d10 and d90 by 0.4 % of a deviation
                assert!((got / want - 1.0).abs() < 4e-3, "{law:?}: {got} {want}");
            }
            let shifted = d50_nm * (other * 3.0 * sigma * sigma).exp();
            let got = reached(&law, 0.5, 3 - power);
            // truncated by the other weighting: sizes beyond 3 − 3σ deviations are missing
            assert!((got / shifted).ln().abs() < 0.12 * 3.0 * sigma * sigma, "{law:?}: {got} {shifted}");
        }
    }
    assert!((sigma * sigma * 3.0 - 0.69).abs() < 0.01, "{sigma}");
}

fn laws() -> Vec<SizeDistribution> {
    let of = Measure::Radius;
    let log = |sigma, cut_at_sigmas| SizeDistribution::LogNormal {
        median_nm: 90.0,
        sigma,
        by: By::Number,
        cut_at_sigmas,
        of,
    };
    let volume = |sigma, cut_at_sigmas| SizeDistribution::LogNormal {
        median_nm: 90.0,
        sigma,
        by: By::Volume,
        cut_at_sigmas,
        of,
    };
    let normal = |standard_deviation_nm, cut_at_sigmas| SizeDistribution::Normal {
        mean_nm: 100.0,
        standard_deviation_nm,
        cut_at_sigmas,
        of,
    };
    let list = |weights| SizeDistribution::List { values_nm: vec![300.0, 100.0, 200.0], weights, of };
    vec![
        log(0.5, 3.0),
        log(0.2, 10.0),
        log(1.0, 0.5),
        volume(0.3, 3.0),
        volume(0.5, 2.0),
        normal(20.0, 3.0),
        normal(9.0, 10.0),
        normal(60.0, 0.5),
        list(Vec::new()),
        list(vec![1.0, 0.0, 2.0]),
    ]
}

#[test]
fn means_of_cubes_are_those_of_the_quantiles_and_of_the_draws() {
    for law in laws() {
        let steps = 300_000;
        let cubes = (0..steps).map(|i| law.quantile_nm((i as f64 + 0.5) / f64::from(steps)).powi(3));
        let by_quantiles = cubes.sum::<f64>() / f64::from(steps);
        // order: the midpoint rule of steps that are steep at the ends of the law
        assert!((law.mean_cube_nm3() / by_quantiles - 1.0).abs() < 1e-4, "{law:?}");
        let mut draws = Draws::new(2, 0);
        let drawn: Vec<f64> = (0..20_000).map(|_| law.draw_nm(&mut draws).powi(3)).collect();
        let drawn = Estimate::of_mean(&drawn);
        let sigmas = (drawn.value - law.mean_cube_nm3()) / drawn.standard_error.unwrap();
        // Significance: four standard errors.
        assert!(sigmas.abs() < 4.0, "{law:?}: {sigmas}");
    }
}

#[test]
fn every_share_of_the_law_gives_one_size() {
    for law in laws() {
        let mut sizes = law.strata_nm(12, &mut Draws::new(2, 0));
        let ends = |i: usize| [i, i + 1].map(|i| law.quantile_nm(i as f64 / 12.0));
        if matches!(law, SizeDistribution::List { .. }) {
            let hundreds = sizes.iter().filter(|s| **s == 300.0).count();
            assert_eq!(hundreds, 4, "{law:?}");
            continue;
        }
        sizes.sort_by(f64::total_cmp);
        for (i, size) in sizes.iter().enumerate() {
            let [from, to] = ends(i);
            assert!((from..=to).contains(size), "{law:?}: {size} {from} {to}");
        }
        let end = law.quantile_nm(1.0) / law.largest_nm();
        // order: the digits of the inverse in a tail of 1e-23, where the law is cut at ten
        // deviations
        assert!((end - 1.0).abs() < 1e-4, "{law:?}: {end}");
    }
}
