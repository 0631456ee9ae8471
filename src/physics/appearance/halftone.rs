//! Dots: shares of area, how far a paper spreads light between them, and what printers call dot
//! gain.
//!
//! Light that enters the paper at one place leaves around it. With a spread exp(−r/ℓ)/(2πℓ²), whose
//! transform is (1 + (2πkℓ)²)^(−3/2), the light that enters under a kind of area of share a leaves
//! under the same kind with the probability 1 − w (1 − a), where
//!
//! ```text
//! w = 1 − Σ_{k≠0} |c_k|² (1 + (2πkℓ)²)^(−3/2) / (a (1 − a))
//! ```
//!
//! and c_k are the Fourier coefficients of the screen's pattern: round dots on a square lattice of
//! the ruling, up to a half, and round holes beyond. w is 0 without spread (Neugebauer) and 1 for a
//! spread far wider than a dot (Clapper and Yule). Rogers, J. Opt. Soc. Am. A 15, 1813 (1998);
//! Arney, J. Imaging Sci. Technol. 41, 633 (1997).

use std::f64::consts::{FRAC_PI_4, PI, TAU};

/// Shares of the overprints of inks that are placed at random (Demichel 1924): entry `i` bears the
/// inks whose bits are set in `i`, and entry 0 is bare. `coverages` are those of the inks.
pub fn demichel(coverages: &[f64]) -> Vec<f64> {
    let share = |set: usize| {
        let factor = |(ink, &c): (usize, &f64)| if set >> ink & 1 == 1 { c } else { 1.0 - c };
        coverages.iter().enumerate().map(factor).product()
    };
    (0..1_usize << coverages.len()).map(share).collect()
}

/// w of a print of several inks on screens of one ruling that do not know of each other: the mean
/// of theirs, each weighted by the variance c (1 − c) of its pattern; that of an ink alone is its
/// own. 1 where all areas are alike.
pub fn mean_spread_share(coverages: &[f64], ruling_per_um: f64, spread_um: f64) -> f64 {
    let mut weights = 0.0;
    let mut sum = 0.0;
    for &c in coverages.iter().filter(|c| **c > 0.0 && **c < 1.0) {
        weights += c * (1.0 - c);
        sum += c * (1.0 - c) * spread_share(c, ruling_per_um, spread_um);
    }
    if weights > 0.0 { sum / weights } else { 1.0 }
}

/// Most orders of the screen's pattern that are summed to either side.
const MOST_ORDERS: usize = 400;
/// Orders at which the spread's transform is negligible: (2πkℓ)² beyond this.
const NEGLIGIBLE: f64 = 900.0;

/// Spread lengths below this share of a dot's radius are short, if the sum has not their orders.
const SHORT: f64 = 0.1;

/// w of round dots of this coverage on a square lattice of `ruling_per_um` dots per µm, over a
/// paper of spread length ℓ, µm.
pub fn spread_share(coverage: f64, ruling_per_um: f64, spread_um: f64) -> f64 {
    let area = coverage.min(1.0 - coverage);
    if spread_um <= 0.0 || area.is_nan() {
        return 0.0;
    }
    // lengths in pitches of the screen
    let length = spread_um * ruling_per_um;
    let radius = (area.max(1e-6) / PI).sqrt();
    let area = PI * radius * radius;
    let orders = (NEGLIGIBLE.sqrt() / (TAU * length)).ceil();
    if orders > MOST_ORDERS as f64 && length < SHORT * radius {
        // only light beside the edge crosses it: 4 r ℓ pairs of places, of all that may differ
        return 4.0 * radius * length / (area * (1.0 - area));
    }
    let reach = orders.min(MOST_ORDERS as f64) as usize;
    let mut same = 0.0;
    for m in 0..=reach {
        for n in 0..=m {
            let images = match (m, n) {
                (0, 0) => continue,
                (m, n) if n == 0 || n == m => 4.0,
                _ => 8.0,
            };
            let order = ((m * m + n * n) as f64).sqrt();
            let z = TAU * radius * order;
            let coefficient = area * 2.0 * bessel_1(z) / z;
            same += images * coefficient * coefficient / (1.0 + (TAU * order * length).powi(2)).powf(1.5);
        }
    }
    (1.0 - same / (area * (1.0 - area))).clamp(0.0, 1.0)
}

/// J₁ by the mean of cos(τ − x sin τ) over a period, for which equal steps converge at once; by
/// Hankel's expansion where that needs many.
fn bessel_1(x: f64) -> f64 {
    if x > 40.0 {
        let y = 1.0 / (8.0 * x);
        let p = 1.0 + 7.5 * y * y - 590.625 * y.powi(4);
        let q = 3.0 * y - 52.5 * y.powi(3);
        let phase = x - 3.0 * FRAC_PI_4;
        return (2.0 / (PI * x)).sqrt() * (p * phase.cos() - q * phase.sin());
    }
    let steps = 24 + 2 * x.ceil() as usize;
    let value = |i: usize| {
        let tau = TAU * (i as f64 + 0.5) / steps as f64;
        (tau - x * tau.sin()).cos()
    };
    (0..steps).map(value).sum::<f64>() / steps as f64
}

/// Coverage after physical gain: the nominal one and 4 g c (1 − c), with g the gain at a half.
pub fn physical_coverage(nominal: f64, gain_at_half: f64) -> f64 {
    nominal + 4.0 * gain_at_half * nominal * (1.0 - nominal)
}

/// Coverage that Murray and Davies read from luminances: (Y_paper − Y)/(Y_paper − Y_solid).
pub fn murray_davies(paper: f64, tint: f64, solid: f64) -> f64 {
    (paper - tint) / (paper - solid)
}

/// Largest n of Yule and Nielsen that is looked for.
const MOST_N: f64 = 20.0;

/// n of Yule and Nielsen, with which Y^(1/n) of a tint is the mean of those of solid and paper
/// (J. Opt. Soc. Am. 41, 1951); `None` where no n from 1 to 20 gives this tint.
pub fn yule_nielsen(coverage: f64, paper: f64, tint: f64, solid: f64) -> Option<f64> {
    let mean =
        |n: f64| (coverage * solid.powf(1.0 / n) + (1.0 - coverage) * paper.powf(1.0 / n)).powf(n) - tint;
    let usable = (1e-9..1.0 - 1e-9).contains(&coverage) && solid > 0.0 && paper > solid;
    // darker with growing n; rounding of a tint without spread is n = 1
    if usable && mean(1.0).abs() < 1e-9 * paper {
        return Some(1.0);
    }
    if !usable || mean(1.0) < 0.0 || mean(MOST_N) > 0.0 {
        return None;
    }
    let mut low = 1.0;
    let mut high = MOST_N;
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if mean(middle) > 0.0 { low = middle } else { high = middle }
    }
    Some(0.5 * (low + high))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn overprints_of_independent_inks_share_the_area() {
        let shares = demichel(&[0.3, 0.5]);
        assert_eq!(shares, [0.7 * 0.5, 0.3 * 0.5, 0.7 * 0.5, 0.3 * 0.5]);
        let three = demichel(&[0.1, 0.6, 0.9]);
        assert!(
            (three.iter().sum::<f64>() - 1.0).abs() < 1e-15 && (three[7] - 0.1 * 0.6 * 0.9).abs() < 1e-15
        );
    }

    /// Solid inks beside an ink in dots do not move its w.
    #[test]
    fn the_spread_of_several_inks_is_between_theirs() {
        let few = spread_share(0.1, 0.006, 40.0);
        let many = spread_share(0.5, 0.006, 40.0);
        assert_eq!(mean_spread_share(&[0.5, 1.0, 0.0], 0.006, 40.0), many);
        let both = mean_spread_share(&[0.1, 0.5], 0.006, 40.0);
        assert!(both > few.min(many) && both < few.max(many), "{few} {both} {many}");
        assert_eq!(mean_spread_share(&[0.0, 1.0], 0.006, 40.0), 1.0);
    }

    #[test]
    fn bessel_functions_are_those_of_tables() {
        for (x, want) in [(1.0, 0.440_050_585_7), (10.0, 0.043_472_746_2), (39.9, bessel_1(39.9))] {
            assert!((bessel_1(x) - want).abs() < 1e-9, "{x}");
        }
        // both branches meet: what the expansion leaves out is of the order x⁻⁵
        let by_steps = {
            let steps = 200;
            let value = |i: usize| {
                let tau = TAU * (f64::from(i as u32) + 0.5) / f64::from(steps as u32);
                (tau - 50.0 * tau.sin()).cos()
            };
            (0..steps).map(value).sum::<f64>() / f64::from(steps as u32)
        };
        assert!((bessel_1(50.0) - by_steps).abs() < 1e-8);
    }

    /// No spread is Neugebauer's limit, a wide one Clapper and Yule's; in between w rises with the
    /// ruling, and dots and holes of equal size are alike.
    #[test]
    fn spread_runs_from_none_to_all() {
        assert_eq!(spread_share(0.5, 0.006, 0.0), 0.0);
        assert!((spread_share(0.5, 0.006, 1e6) - 1.0).abs() < 1e-9);
        let rising: Vec<f64> = [20.0, 60.0, 120.0, 300.0].map(|cm| spread_share(0.3, 1e-4 * cm, 30.0)).into();
        assert!(rising.windows(2).all(|pair| pair[0] < pair[1]), "{rising:?}");
        assert_eq!(spread_share(0.25, 0.01, 20.0), spread_share(0.75, 0.01, 20.0));
        // short lengths count in proportion; *planted*: the sum of orders alone
        let short = spread_share(0.5, 0.006, 1e-6);
        assert!((3e-8..5e-8).contains(&short), "{short}");
        let [below, above] = [0.0118, 0.0121].map(|pitches| spread_share(0.5, 1.0, pitches) / pitches);
        assert!((below / above - 1.0).abs() < 0.02, "{below} {above}");
    }

    /// The n of Yule and Nielsen is 1 without spread, and that of a tint made with n = 1.7.
    #[test]
    fn the_n_of_yule_and_nielsen_is_found() {
        let paper = 0.85;
        let solid = 0.2;
        let a = 0.4;
        let made = |n: f64| (a * f64::powf(solid, 1.0 / n) + (1.0 - a) * f64::powf(paper, 1.0 / n)).powf(n);
        assert_eq!(yule_nielsen(a, paper, made(1.0), solid), Some(1.0));
        assert!((yule_nielsen(a, paper, made(1.7), solid).unwrap() - 1.7).abs() < 1e-9);
        assert_eq!(yule_nielsen(a, paper, 0.9, solid), None);
        assert!((murray_davies(paper, made(1.0), solid) - a).abs() < 1e-12);
    }
}
