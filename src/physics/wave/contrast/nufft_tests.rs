//! The type-1 transform against the sum it stands for.

use super::*;
use num_complex::Complex64;
use proptest::prelude::*;
use std::f64::consts::TAU;

/// Coefficients of sources that share one patch around each of them, in the middle of a range of
/// orders.
fn transform(
    [mmax, nmax]: [usize; 2],
    spreading: Spreading,
    sources: &[([f64; 2], Complex64)],
) -> (SourceTransform, PlaneScratch) {
    let transform = SourceTransform::new(mmax, nmax, spreading);
    let mut scratch = transform.scratch();
    // The second pair of fields is a decoy.
    let mut spread = Sources::new(&transform, [1.0; 2], 4);
    for &([x, y], value) in sources {
        spread.open([[x; 2], [y; 2]]);
        spread.spread([x, y], &[value.re, value.im, 7.0, -7.0]);
        spread.close();
    }
    scratch.plane.copy_from_slice(&spread.grids[0]);
    transform.transform(&mut scratch);
    (transform, scratch)
}

fn coefficient(transform: &SourceTransform, scratch: &PlaneScratch, m: i32, n: i32) -> Complex64 {
    let row = transform.row(scratch, m);
    row[n.rem_euclid(row.len() as i32) as usize] * transform.correction(m, n)
}

fn direct(m: i32, n: i32, sources: &[([f64; 2], Complex64)]) -> Complex64 {
    let term = |&([x, y], c): &([f64; 2], Complex64)| {
        c * Complex64::cis(-TAU * (f64::from(m) * x + f64::from(n) * y))
    };
    sources.iter().map(term).sum()
}

/// The rule of thumb for a kernel of width 11 is 10^{1−11} of the sources' sum; 6e-10 is observed
/// at the largest orders.
const PROMISE: f64 = 1e-9;

fn sources() -> impl Strategy<Value = Vec<([f64; 2], Complex64)>> {
    let one = (-3.0..3.0f64, -3.0..3.0f64, -1.0..1.0f64, -1.0..1.0f64);
    prop::collection::vec(one.prop_map(|(x, y, re, im)| ([x, y], Complex64::new(re, im))), 1..20)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    #[test]
    fn agrees_with_the_direct_sum(mmax in 0usize..14, nmax in 0usize..14, sources in sources()) {
        let (transform, scratch) = transform([mmax, nmax], Spreading::within(1e-10), &sources);
        let total: f64 = sources.iter().map(|s| s.1.norm()).sum();
        for m in -(mmax as i32)..=mmax as i32 {
            for n in -(nmax as i32)..=nmax as i32 {
                let error = (coefficient(&transform, &scratch, m, n) - direct(m, n, &sources)).norm();
                prop_assert!(error <= PROMISE * total, "({m}, {n}): {error:e} of {total}");
            }
        }
    }
}

#[test]
fn positions_count_modulo_the_period() {
    let value = Complex64::new(0.3, -0.7);
    for shift in [0.0, 1.0, -2.0] {
        let sources = [([0.97 + shift, 0.02 - shift], value)];
        let (transform, scratch) = transform([5, 3], Spreading::within(1e-10), &sources);
        let error =
            (coefficient(&transform, &scratch, 4, -3) - direct(4, -3, &[([0.97, 0.02], value)])).norm();
        assert!(error < PROMISE, "{error:e}");
    }
}

#[test]
fn smooth_numbers_have_no_prime_factor_above_five() {
    let smooth: Vec<usize> = (1..=20).filter(|&n| is_smooth(n)).collect();
    assert_eq!(smooth, [1, 2, 3, 4, 5, 6, 8, 9, 10, 12, 15, 16, 18, 20]);
}

#[test]
fn narrow_kernels_keep_what_they_promise_on_the_inner_half() {
    let value = Complex64::new(0.6, 0.8);
    let sources: Vec<_> = (0..40).map(|i| ([0.31 * f64::from(i), 0.47 * f64::from(i * i)], value)).collect();
    for error in [1e-4, 1e-5, 1e-6, 1e-8, 1e-10] {
        let (transform, scratch) = transform([16, 12], Spreading::within(error), &sources);
        let mut largest = 0.0_f64;
        for (m, n) in (-8..=8).flat_map(|m| (-6..=6).map(move |n| (m, n))) {
            let difference = coefficient(&transform, &scratch, m, n) - direct(m, n, &sources);
            largest = largest.max(difference.norm() / sources.len() as f64);
        }
        // The promise, and that a wider kernel is what keeps it: no kernel is exact.
        assert!(largest <= error && largest > 1e-15, "{error:e}: {largest:e}");
    }
}
