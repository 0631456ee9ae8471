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
        let (a, b) = (vector(len, 0.7), vector(len, 1.3));
        let plain: Complex64 = a.iter().zip(&b).map(|(a, b)| a.conj() * b).sum();
        assert!((dot(&a, &b) - plain).norm() <= budget(len), "{len}");
        let square: f64 = a.iter().map(|z| z.norm_sqr()).sum();
        assert!((norm(&a).powi(2) - square).abs() <= budget(len), "{len}");
        let basis = [a.clone(), b.clone()];
        assert!((dots(&basis, &b)[0] - plain).norm() <= budget(len), "{len}");
        let factors = [Complex64::new(0.3, -2.0), Complex64::new(-1.0, 0.5)];
        let mut w = vector(len, 2.1);
        let plain: Vec<Complex64> =
            w.iter().zip(a.iter().zip(&b)).map(|(w, (a, b))| w + factors[0] * a + factors[1] * b).collect();
        let length = add_combination(&mut w, &factors, &basis);
        assert!(w.iter().zip(&plain).all(|(a, b)| (a - b).norm() < 4e-15), "{len}");
        assert!((length - norm(&w)).abs() <= budget(len), "{len}");
        scale(&mut w, 0.5);
        assert!(w.iter().zip(&plain).all(|(a, b)| (a - 0.5 * b).norm() < 2e-15), "{len}");
    }
}

#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    let (a, b) = (vector(5 * CHUNK + 321, 0.7), vector(5 * CHUNK + 321, 1.3));
    let all = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| {
            let mut w = a.clone();
            let length = add_combination(&mut w, &[Complex64::new(0.1, 0.2)], std::slice::from_ref(&b));
            (norm(&a), dot(&a, &b), dots(&[a.clone(), b.clone()], &w), length, w)
        })
    };
    // Identity, to the last bit.
    assert_eq!(all(1), all(2));
    assert_eq!(all(1), all(5));
}
