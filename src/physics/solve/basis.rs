//! The orthonormal vectors of a Krylov space, in double or single precision.
//!
//! Real and imaginary parts are stored separately, so that sums over many vectors are plain loops
//! over real numbers. Sums run over fixed chunks, which are added in order and in double precision:
//! results do not depend on the number of threads.

use crate::numerics::fourier::Real;
use multiversion::multiversion;
use num_complex::{Complex, Complex64};
use rayon::prelude::*;

/// Entries per chunk: in single precision, real and imaginary parts of a chunk fit into the
/// first-level cache.
const CHUNK: usize = 2048;
/// Number of chunks below which a single thread is faster.
const FEW: usize = 16;
/// A second orthogonalisation pays off when the first removed nearly everything (Kahan, Parlett).
const REORTHOGONALISE: f64 = 0.05;
/// Numbers per step of the kernels.
const LANES: usize = 16;
/// Vectors added per pass over a chunk, each of which reads and writes it.
const TOGETHER: usize = 4;

/// Orthonormal vectors of one length.
pub(crate) struct Basis<T: Real> {
    length: usize,
    /// Real parts followed by imaginary parts of each vector.
    vectors: Vec<Vec<T>>,
}

impl<T: Real> Basis<T> {
    /// A basis of one vector: `first` over its norm.
    pub fn new(first: &[Complex64], norm: f64) -> Basis<T> {
        Basis { length: first.len(), vectors: vec![scaled(first, norm)] }
    }

    /// Number of vectors.
    pub fn len(&self) -> usize {
        self.vectors.len()
    }

    /// Bytes of all vectors.
    pub fn bytes(&self) -> usize {
        self.len() * 2 * self.length * size_of::<T>()
    }

    /// Copies the latest vector to `out`.
    pub fn last(&self, out: &mut [Complex<T>]) {
        let (re, im) = self.vectors[self.len() - 1].split_at(self.length);
        out.iter_mut().zip(re.iter().zip(im)).for_each(|(z, (&re, &im))| *z = Complex::new(re, im));
    }

    /// Linear combination Σ a_i v_i of the first vectors.
    pub fn combine(&self, factors: &[Complex64], out: &mut [Complex<T>]) {
        let mut sum = vec![T::zero(); 2 * self.length];
        add_combination(&mut sum, factors, &self.vectors);
        let (re, im) = sum.split_at(self.length);
        out.iter_mut().zip(re.iter().zip(im)).for_each(|(z, (&re, &im))| *z = Complex::new(re, im));
    }

    /// Orthogonalises `applied` + `image` and appends it; returns its column of the Hessenberg
    /// matrix, which ends with its norm. If only rounding is left, no vector is appended.
    pub fn expand(&mut self, applied: &[Complex<T>], image: &[Complex<T>]) -> (Vec<Complex64>, bool) {
        let mut w: Vec<T> = Vec::with_capacity(2 * self.length);
        w.extend(applied.iter().zip(image).map(|(a, b)| a.re + b.re));
        w.extend(applied.iter().zip(image).map(|(a, b)| a.im + b.im));
        let mut column = self.dots(&w); // h_i = ⟨v_i, w⟩
        let (before, mut after) = self.subtract(&mut w, &column); // w ← w − Σ h_i v_i
        if after < REORTHOGONALISE * before {
            let correction = self.dots(&w);
            (_, after) = self.subtract(&mut w, &correction);
            column.iter_mut().zip(correction).for_each(|(c, d)| *c += d);
        }
        column.push(after.into());
        let grows = after > T::ROUNDING * before;
        if grows {
            let factor = T::of(1.0 / after);
            w.par_chunks_mut(CHUNK).with_min_len(FEW).for_each(|c| c.iter_mut().for_each(|x| *x *= factor));
            self.vectors.push(w);
        }
        (column, grows)
    }

    /// Inner products ⟨v_i, w⟩ for all i, reading each chunk of w once.
    fn dots(&self, w: &[T]) -> Vec<Complex64> {
        let product = |from: usize| {
            let w = part(w, from);
            self.vectors.iter().map(|v| dot(part(v, from), w)).collect::<Vec<_>>()
        };
        let starts = (0..self.length.div_ceil(CHUNK)).into_par_iter().with_min_len(FEW);
        let parts: Vec<Vec<Complex64>> = starts.map(|c| product(c * CHUNK)).collect();
        (0..self.len()).map(|i| parts.iter().map(|p| p[i]).sum()).collect()
    }

    /// Subtracts w ← w − Σ c_i v_i; returns the norms of w before and after.
    fn subtract(&self, w: &mut [T], column: &[Complex64]) -> (f64, f64) {
        let negative: Vec<Complex64> = column.iter().map(|c| -c).collect();
        let after = add_combination(w, &negative, &self.vectors);
        let removed: f64 = column.iter().map(|c| c.norm_sqr()).sum();
        ((after * after + removed).sqrt(), after)
    }
}

/// Real parts followed by imaginary parts of v / `unit`.
pub(super) fn scaled<T: Real>(v: &[Complex64], unit: f64) -> Vec<T> {
    let part = |value: fn(&Complex64) -> f64| v.iter().map(move |z| T::of(value(z) / unit));
    part(|z| z.re).chain(part(|z| z.im)).collect()
}

/// Inner product ⟨a, b⟩ of vectors stored as real parts followed by imaginary parts.
pub(super) fn split_dot<T: Real>(a: &[T], b: &[T]) -> Complex64 {
    let starts = (0..(a.len() / 2).div_ceil(CHUNK)).into_par_iter().with_min_len(FEW);
    let parts: Vec<Complex64> = starts.map(|c| dot(part(a, c * CHUNK), part(b, c * CHUNK))).collect();
    parts.iter().sum()
}

/// Adds w ← w + Σ a_i v_i, writing each chunk of w once; returns ‖w‖ afterwards.
pub(super) fn add_combination<T: Real, V: AsRef<[T]> + Sync>(
    w: &mut [T],
    factors: &[Complex64],
    vectors: &[V],
) -> f64 {
    let (re, im) = w.split_at_mut(w.len() / 2);
    let chunks = re.par_chunks_mut(CHUNK).zip(im.par_chunks_mut(CHUNK)).with_min_len(FEW).enumerate();
    let parts: Vec<f64> =
        chunks.map(|(c, (re, im))| add_to_chunk([re, im], factors, vectors, c * CHUNK)).collect();
    parts.iter().sum::<f64>().sqrt()
}

/// Adds w ← w + Σ a_i v_i on the chunk that begins at `from`, as real and imaginary part; returns
/// its Σ |w|² afterwards.
fn add_to_chunk<T: Real, V: AsRef<[T]>>(
    [re, im]: [&mut [T]; 2],
    factors: &[Complex64],
    vectors: &[V],
    from: usize,
) -> f64 {
    let numbers = |a: &Complex64| [T::of(a.re), T::of(a.im)];
    for (a, v) in factors.chunks(TOGETHER).zip(vectors.chunks(TOGETHER)) {
        let part = |k: usize| part(v[k.min(v.len() - 1)].as_ref(), from);
        if let ([a], [_]) = (a, v) {
            add_scaled([&mut *re, &mut *im], numbers(a), part(0));
        } else {
            // the last vector stands in for those that are missing, times 0
            let factors = std::array::from_fn(|k| a.get(k).map_or([T::zero(); 2], numbers));
            add_together([&mut *re, &mut *im], factors, std::array::from_fn(part));
        }
    }
    dot((re, im), (re, im)).re
}

/// Real and imaginary parts of the chunk that begins at `from`.
fn part<T>(v: &[T], from: usize) -> (&[T], &[T]) {
    let (re, im) = v.split_at(v.len() / 2);
    let to = re.len().min(from + CHUNK);
    (&re[from..to], &im[from..to])
}

/// Inner product Σ ā b of one chunk.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx2+fma", "x86_64+avx2+fma"))]
pub(super) fn dot<T: Real>(a: (&[T], &[T]), b: (&[T], &[T])) -> Complex64 {
    let (a_re, a_im) = a;
    let (b_re, b_im) = b;
    let mut parallel = [T::zero(); LANES];
    let mut crossed = [T::zero(); LANES];
    let ar = a_re.as_chunks::<LANES>();
    let ai = a_im.as_chunks::<LANES>();
    let br = b_re.as_chunks::<LANES>();
    let bi = b_im.as_chunks::<LANES>();
    for ((ar, ai), (br, bi)) in ar.0.iter().zip(ai.0).zip(br.0.iter().zip(bi.0)) {
        for i in 0..LANES {
            parallel[i] += ar[i] * br[i] + ai[i] * bi[i];
            crossed[i] += ar[i] * bi[i] - ai[i] * br[i];
        }
    }
    for ((&ar, &ai), (&br, &bi)) in ar.1.iter().zip(ai.1).zip(br.1.iter().zip(bi.1)) {
        parallel[0] += ar * br + ai * bi;
        crossed[0] += ar * bi - ai * br;
    }
    let sum = |lanes: [T; LANES]| lanes.iter().map(|x| x.wide()).sum();
    Complex64::new(sum(parallel), sum(crossed))
}

/// Adds w ← w + Σ factor v on one chunk; every operand as real and imaginary part.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx2+fma", "x86_64+avx2+fma"))]
fn add_together<T: Real>([re, im]: [&mut [T]; 2], factors: [[T; 2]; TOGETHER], v: [(&[T], &[T]); TOGETHER]) {
    let whole = re.len() / LANES * LANES;
    let re = re.as_chunks_mut::<LANES>();
    let im = im.as_chunks_mut::<LANES>();
    let lanes = v.map(|(x, y)| [x.as_chunks::<LANES>().0, y.as_chunks::<LANES>().0]);
    for (j, (re, im)) in re.0.iter_mut().zip(im.0).enumerate() {
        let mut sum_re = *re;
        let mut sum_im = *im;
        for k in 0..TOGETHER {
            let [a_re, a_im] = factors[k];
            let x = &lanes[k][0][j];
            let y = &lanes[k][1][j];
            for i in 0..LANES {
                sum_re[i] += a_re * x[i] - a_im * y[i];
                sum_im[i] += a_re * y[i] + a_im * x[i];
            }
        }
        *re = sum_re;
        *im = sum_im;
    }
    for (factor, (x, y)) in factors.into_iter().zip(v) {
        add_scaled([&mut *re.1, &mut *im.1], factor, (&x[whole..], &y[whole..]));
    }
}

/// Adds w ← w + factor v on one chunk; every operand as real and imaginary part.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx2+fma", "x86_64+avx2+fma"))]
fn add_scaled<T: Real>([re, im]: [&mut [T]; 2], [a_re, a_im]: [T; 2], (v_re, v_im): (&[T], &[T])) {
    for ((re, im), (&x, &y)) in re.iter_mut().zip(im).zip(v_re.iter().zip(v_im)) {
        *re += a_re * x - a_im * y;
        *im += a_re * y + a_im * x;
    }
}

#[cfg(test)]
#[path = "basis_tests.rs"]
mod tests;
