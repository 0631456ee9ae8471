//! The type-1 transform against the sum it stands for.

use super::*;
use proptest::prelude::*;
use std::f64::consts::TAU;

fn transform(mmax: usize, nmax: usize, sources: &[([f64; 2], Complex64)]) -> (SourceTransform, PlaneScratch) {
    let transform = SourceTransform::new(mmax, nmax);
    let mut scratch = transform.scratch();
    scratch.plane.fill(Complex64::default());
    for &([x, y], value) in sources {
        let (fx, fy) = (transform.footprint(0, x), transform.footprint(1, y));
        transform.spread(&mut scratch.plane, &fx, &fy, value);
    }
    transform.transform(&mut scratch);
    (transform, scratch)
}

fn direct(m: i32, n: i32, sources: &[([f64; 2], Complex64)]) -> Complex64 {
    let term = |&([x, y], c): &([f64; 2], Complex64)| {
        c * Complex64::cis(-TAU * (f64::from(m) * x + f64::from(n) * y))
    };
    sources.iter().map(term).sum()
}

/// The rule of thumb for a kernel of width 11 is 10^{1−11} of the sources' sum; 6e-10 was seen at the largest orders.
const PROMISE: f64 = 1e-9;

fn sources() -> impl Strategy<Value = Vec<([f64; 2], Complex64)>> {
    let one = (-3.0..3.0f64, -3.0..3.0f64, -1.0..1.0f64, -1.0..1.0f64);
    prop::collection::vec(one.prop_map(|(x, y, re, im)| ([x, y], Complex64::new(re, im))), 1..20)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    #[test]
    fn agrees_with_the_direct_sum(mmax in 0usize..14, nmax in 0usize..14, sources in sources()) {
        let (transform, scratch) = transform(mmax, nmax, &sources);
        let total: f64 = sources.iter().map(|s| s.1.norm()).sum();
        for m in -(mmax as i32)..=mmax as i32 {
            for n in -(nmax as i32)..=nmax as i32 {
                let error = (transform.coefficient(&scratch, m, n) - direct(m, n, &sources)).norm();
                prop_assert!(error <= PROMISE * total, "({m}, {n}): {error:e} of {total}");
            }
        }
    }
}

#[test]
fn positions_count_modulo_the_period() {
    let value = Complex64::new(0.3, -0.7);
    for shift in [0.0, 1.0, -2.0] {
        let (transform, scratch) = transform(5, 3, &[([0.97 + shift, 0.02 - shift], value)]);
        let error = (transform.coefficient(&scratch, 4, -3) - direct(4, -3, &[([0.97, 0.02], value)])).norm();
        assert!(error < PROMISE, "{error:e}");
    }
}

#[test]
fn smooth_numbers_have_no_prime_factor_above_five() {
    let smooth: Vec<usize> = (1..=20).filter(|&n| is_smooth(n)).collect();
    assert_eq!(smooth, [1, 2, 3, 4, 5, 6, 8, 9, 10, 12, 15, 16, 18, 20]);
}
