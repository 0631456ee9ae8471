//! Norms and products of long complex vectors, in parallel and independent of the number of threads:
//! sums run over fixed chunks and are added in order.

use num_complex::Complex64;
use rayon::prelude::*;

/// Entries a chunk: 64 KiB, within second-level cache.
const CHUNK: usize = 4096;

/// ‖v‖₂.
pub fn norm(v: &[Complex64]) -> f64 {
    let parts: Vec<f64> = v.par_chunks(CHUNK).map(|c| c.iter().map(|z| z.norm_sqr()).sum()).collect();
    parts.iter().sum::<f64>().sqrt()
}

/// ⟨a, b⟩ = Σ ā b.
pub fn dot(a: &[Complex64], b: &[Complex64]) -> Complex64 {
    let chunks = a.par_chunks(CHUNK).zip(b.par_chunks(CHUNK));
    let parts: Vec<Complex64> = chunks.map(|(a, b)| dot_chunk(a, b)).collect();
    parts.iter().sum()
}

/// ⟨v_i, w⟩ for all i, reading each chunk of w once.
pub fn dots(basis: &[Vec<Complex64>], w: &[Complex64]) -> Vec<Complex64> {
    let chunks = w.par_chunks(CHUNK).enumerate();
    let product = |c: usize, w: &[Complex64]| {
        let from = c * CHUNK;
        basis.iter().map(|v| dot_chunk(&v[from..from + w.len()], w)).collect::<Vec<_>>()
    };
    let parts: Vec<Vec<Complex64>> = chunks.map(|(c, w)| product(c, w)).collect();
    (0..basis.len()).map(|i| parts.iter().map(|p| p[i]).sum()).collect()
}

/// w ← w + Σ a_i v_i, writing each chunk of w once; returns ‖w‖ afterwards.
pub fn add_combination(w: &mut [Complex64], factors: &[Complex64], basis: &[Vec<Complex64>]) -> f64 {
    let chunks = w.par_chunks_mut(CHUNK).enumerate();
    let add = |(c, w): (usize, &mut [Complex64])| {
        let from = c * CHUNK;
        for (&a, v) in factors.iter().zip(basis) {
            w.iter_mut().zip(&v[from..]).for_each(|(w, v)| *w += a * v);
        }
        w.iter().map(|z| z.norm_sqr()).sum::<f64>()
    };
    let parts: Vec<f64> = chunks.map(add).collect();
    parts.iter().sum::<f64>().sqrt()
}

/// w ← factor · w.
pub fn scale(w: &mut [Complex64], factor: f64) {
    w.par_chunks_mut(CHUNK).for_each(|c| c.iter_mut().for_each(|z| *z *= factor));
}

/// Four partial sums let the additions overlap; complex products written out so that they vectorise.
fn dot_chunk(a: &[Complex64], b: &[Complex64]) -> Complex64 {
    let mut sums = [[0.0; 4]; 2];
    let (a4, b4) = (a.chunks_exact(4), b.chunks_exact(4));
    let rest = a4.remainder().iter().zip(b4.remainder()).map(|(a, b)| a.conj() * b).sum::<Complex64>();
    for (a, b) in a4.zip(b4) {
        for i in 0..4 {
            sums[0][i] += a[i].re * b[i].re + a[i].im * b[i].im;
            sums[1][i] += a[i].re * b[i].im - a[i].im * b[i].re;
        }
    }
    rest + Complex64::new(sums[0].iter().sum(), sums[1].iter().sum())
}
