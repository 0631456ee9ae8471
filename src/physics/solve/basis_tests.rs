//! The basis against plain loops, on lengths around lanes and chunks, and on any number of threads.

use super::*;

fn vector<T: Real>(len: usize, seed: f64) -> Vec<Complex<T>> {
    (0..len).map(|i| Complex::new(T::of((i as f64 * seed).sin()), T::of((i as f64 + seed).cos()))).collect()
}

/// A basis of `count` vectors from arbitrary ones, and the Hessenberg columns.
fn basis<T: Real>(len: usize, count: usize) -> (Basis<T>, Vec<Vec<Complex64>>) {
    let first: Vec<Complex64> = vector(len, 0.7);
    let norm = first.iter().map(|z| z.norm_sqr()).sum::<f64>().sqrt();
    let mut basis = Basis::new(&first, norm);
    let add = |k: usize| basis.expand(&vector(len, 1.3 + k as f64), &vector(len, 2.9 * k as f64)).0;
    let columns = (1..count).map(add).collect();
    (basis, columns)
}

fn plain<T: Real>(v: &[T]) -> Vec<Complex64> {
    let (re, im) = v.split_at(v.len() / 2);
    re.iter().zip(im).map(|(re, im)| Complex64::new(re.wide(), im.wide())).collect()
}

fn check<T: Real>(rounding: f64) {
    for len in [9, LANES - 1, LANES, 3 * LANES + 1, CHUNK - 1, CHUNK, 2 * CHUNK + 7] {
        let (basis, columns) = basis::<T>(len, 7);
        assert_eq!(basis.len(), 7, "{len}");
        let vectors: Vec<_> = basis.vectors.iter().map(|v| plain(v)).collect();
        let dot =
            |a: &[Complex64], b: &[Complex64]| a.iter().zip(b).map(|(a, b)| a.conj() * b).sum::<Complex64>();
        for (i, a) in vectors.iter().enumerate() {
            for (j, b) in vectors.iter().enumerate() {
                let expected = if i == j { 1.0 } else { 0.0 };
                // Rounding of sums over the length, amplified where a vector was nearly in the
                // span.
                assert!((dot(a, b) - expected).norm() < rounding, "{len}: {i}, {j}");
            }
        }
        // Each vector added is the column's combination of the basis.
        for (k, column) in columns.iter().enumerate() {
            let applied = vector::<T>(len, 2.3 + k as f64);
            let image = vector::<T>(len, 2.9 * (k + 1) as f64);
            for i in 0..len {
                let sum = applied[i] + image[i];
                let combined: Complex64 = column.iter().zip(&vectors).map(|(c, v)| c * v[i]).sum();
                let difference = combined - Complex64::new(sum.re.wide(), sum.im.wide());
                assert!(difference.norm() < 10.0 * rounding, "{len}, {k}, {i}");
            }
        }
        let factors = [Complex64::new(0.3, -2.0), Complex64::I];
        let mut out = vector::<T>(len, 0.0);
        basis.combine(&factors, &mut out);
        let expected = factors[0] * vectors[0][len - 1] + factors[1] * vectors[1][len - 1];
        assert!(
            (Complex64::new(out[len - 1].re.wide(), out[len - 1].im.wide()) - expected).norm() < rounding
        );
    }
}

#[test]
fn vectors_are_orthonormal_and_columns_are_their_combinations() {
    check::<f64>(1e-12);
    check::<f32>(1e-4);
}

#[test]
fn what_is_in_the_span_adds_nothing() {
    let (mut basis, _) = basis::<f64>(100, 3);
    let mut last = vector(100, 0.0);
    basis.last(&mut last);
    let (column, grows) = basis.expand(&last, &vec![Complex64::default(); 100]);
    assert!(!grows && basis.len() == 3 && (column[2] - 1.0).norm() < 1e-13);
}

#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    let all = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| {
            let (basis, columns) = basis::<f32>(70 * CHUNK + 321, 3);
            (basis.vectors, columns)
        })
    };
    // Identity, to the last bit.
    assert!(all(1) == all(3));
}
