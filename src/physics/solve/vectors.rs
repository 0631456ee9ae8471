//! Norms and products of long complex vectors, in parallel and independent of the number of
//! threads: sums run over fixed chunks and are added in order.

use multiversion::multiversion;
use num_complex::Complex64;
use rayon::prelude::*;

/// Entries per chunk: 64 KiB, within the second-level cache.
const CHUNK: usize = 4096;

/// Euclidean norm ‖v‖₂.
pub fn norm(v: &[Complex64]) -> f64 {
    let parts: Vec<f64> = v.par_chunks(CHUNK).map(square_chunk).collect();
    parts.iter().sum::<f64>().sqrt()
}

/// Inner product ⟨a, b⟩ = Σ ā b.
pub fn dot(a: &[Complex64], b: &[Complex64]) -> Complex64 {
    let chunks = a.par_chunks(CHUNK).zip(b.par_chunks(CHUNK));
    let parts: Vec<Complex64> = chunks.map(|(a, b)| dot_chunk(a, b)).collect();
    parts.iter().sum()
}

/// Entries per step of the kernels below: eight doubles, two AVX registers.
const LANES: usize = 8;

/// Exchanges real and imaginary parts within each pair.
fn swapped(v: &[f64; LANES]) -> [f64; LANES] {
    std::array::from_fn(|i| v[i ^ 1])
}

/// Inner product Σ ā b of one chunk. Lane-wise sums, written so that they vectorise on any machine.
#[multiversion(targets("x86_64+avx2"))]
fn dot_chunk(a: &[Complex64], b: &[Complex64]) -> Complex64 {
    let a = doubles(a);
    let b = doubles(b);
    let mut parallel = [0.0; LANES];
    let mut crossed = [0.0; LANES];
    let a8 = a.as_chunks::<LANES>();
    let b8 = b.as_chunks::<LANES>();
    for (a, b) in a8.0.iter().zip(b8.0) {
        let b_swapped = swapped(b);
        for i in 0..LANES {
            parallel[i] += a[i] * b[i];
            crossed[i] += a[i] * b_swapped[i];
        }
    }
    let mut sum =
        Complex64::new(parallel.iter().sum(), (0..LANES).map(|i| [1.0, -1.0][i % 2] * crossed[i]).sum());
    for (a, b) in a8.1.as_chunks::<2>().0.iter().zip(b8.1.as_chunks::<2>().0) {
        sum += Complex64::new(a[0], -a[1]) * Complex64::new(b[0], b[1]);
    }
    sum
}

/// Sum Σ |z|² over one chunk.
#[multiversion(targets("x86_64+avx2"))]
fn square_chunk(v: &[Complex64]) -> f64 {
    let v8 = doubles(v).as_chunks::<LANES>();
    let mut sums = [0.0; LANES];
    for v in v8.0 {
        (0..LANES).for_each(|i| sums[i] += v[i] * v[i]);
    }
    sums.iter().sum::<f64>() + v8.1.iter().map(|x| x * x).sum::<f64>()
}

fn doubles(v: &[Complex64]) -> &[f64] {
    bytemuck::cast_slice(v)
}

#[cfg(test)]
#[path = "vectors_tests.rs"]
mod tests;
