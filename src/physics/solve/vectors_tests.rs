//! Sums against plain loops, on lengths around the lanes and chunks, and on any number of threads.

use super::*;

fn vector(len: usize, seed: f64) -> Vec<Complex64> {
    (0..len).map(|i| Complex64::new((i as f64 * seed).sin(), (i as f64 + seed).cos())).collect()
}

const LENGTHS: [usize; 9] = [0, 1, 3, 4, 5, 11, CHUNK - 1, CHUNK + 1, 3 * CHUNK + 7];

/// Identity: n roundings of partial sums of size up to n, which add up like a random walk.
fn budget(len: usize) -> f64 {
    1e-15 * (1.0 + (len as f64).powf(1.5))
}

#[test]
fn kernels_agree_with_plain_loops() {
    for len in LENGTHS {
        let a = vector(len, 0.7);
        let b = vector(len, 1.3);
        let plain: Complex64 = a.iter().zip(&b).map(|(a, b)| a.conj() * b).sum();
        assert!((dot(&a, &b) - plain).norm() <= budget(len), "{len}");
        let square: f64 = a.iter().map(|z| z.norm_sqr()).sum();
        assert!((norm(&a).powi(2) - square).abs() <= budget(len), "{len}");
    }
}

#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    let a = vector(5 * CHUNK + 321, 0.7);
    let b = vector(5 * CHUNK + 321, 1.3);
    let all = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| (norm(&a), dot(&a, &b)))
    };
    // Identity, to the last bit.
    assert_eq!(all(1), all(2));
    assert_eq!(all(1), all(5));
}
