//! Fourier coefficients of point sources scattered in the plane (a type-1 non-uniform FFT).
//!
//! Spreading with the "exponential of semicircle" kernel on a grid finer than the harmonics:
//! Barnett, Magland, af Klinteberg, SIAM J. Sci. Comput. 41 (2019) C479; as there, the kernel is
//! evaluated by piecewise polynomials. The sources of one ball are accumulated in a small patch
//! that fits into the cache, for all planes of a cell together, and only the finished patch is
//! added to the grids.

use crate::numerics::fourier::{PlaneFft, PlaneScratch, Real};
use crate::wave::grid::element::MAX_DEGREE;
use gauss_quad::GaussLegendre;
use multiversion::multiversion;
use num_complex::Complex;
use std::f64::consts::PI;

/// Largest kernel width in fine-grid points.
const MOST: usize = 12;
/// Largest number of fields processed together: two per plane of a cell for the scalar wave, seven
/// per Gauss plane for the vector wave.
const MOST_FIELDS: usize = if 2 * (MAX_DEGREE + 1) > 14 { 2 * (MAX_DEGREE + 1) } else { 14 };
/// Ratio of β to the kernel's width in the kernel exp(β (√(1−t²) − 1)) (oversampling 2).
const SHAPE: f64 = 2.30;
/// Degree of the polynomials in excess of the kernel's width.
const EXTRA_DEGREE: usize = 5;

/// Transform from sources in the cell to the harmonics |m| ≤ mmax, |n| ≤ nmax.
pub struct SourceTransform<T: Real = f64> {
    fine: [usize; 2],
    fft: PlaneFft<T>,
    kernel: Kernel<T>,
    /// Reciprocal transform of the kernel at m (x) and n (y).
    correction: [Vec<f64>; 2],
}

/// Settings of the spreading: kernel width and fine grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spreading {
    /// Kernel width in fine-grid points: with an oversampling of two, the error is about 10^{1−w}
    /// relative to the sources' sum.
    pub width: usize,
    /// Fine-grid points per harmonic, |m| counted once: 4 is an oversampling of two.
    pub points_per_order: usize,
}

impl Spreading {
    /// The narrowest kernel for a relative error in the inner half of all harmonics; the outer half
    /// may have an error of some 10⁻³ if `error` is above 10⁻⁷.
    pub fn within(error: f64) -> Spreading {
        let width = (1.0 - error.log10()).ceil().clamp(4.0, 11.0) as usize;
        Spreading { width, points_per_order: if error > 1e-7 { 3 } else { 4 } }
    }
}

/// Kernel values at the `width` grid points around a source, as polynomials of its position between
/// two of them.
struct Kernel<T> {
    width: usize,
    /// Coefficients of descending powers of 2·fraction − 1.
    powers: Vec<[T; MOST]>,
}

/// Kernel of one source along one axis: index of the first grid point (not wrapped), and values.
struct Footprint<T> {
    first: i64,
    weight: [T; MOST],
}

/// Sources on one periodic fine grid per pair of fields (real, imaginary), body by body: those of
/// one are gathered in a patch around it, for all fields together (rows × columns × fields).
pub struct Sources<'a, T: Real> {
    transform: &'a SourceTransform<T>,
    period_um: [f64; 2],
    fields: usize,
    origin: [i64; 2],
    size: [usize; 2],
    patch: Vec<T>,
    /// The grids, x fastest; none before the first body.
    pub grids: Vec<Vec<Complex<T>>>,
}

impl<T: Real> SourceTransform<T> {
    /// Plans the transform.
    pub fn new(mmax: usize, nmax: usize, spreading: Spreading) -> SourceTransform<T> {
        let fine = [mmax, nmax].map(|m| fine_size(m, spreading));
        let width = spreading.width;
        let correction = [kernel_correction(mmax, fine[0], width), kernel_correction(nmax, fine[1], width)];
        let fft = PlaneFft::new(fine[0], fine[1]);
        let kernel = Kernel::new(width);
        SourceTransform { fine, fft, kernel, correction }
    }

    /// Work arrays of one thread; `plane` is the fine grid.
    pub fn scratch(&self) -> PlaneScratch<T> {
        self.fft.scratch()
    }

    /// Transforms the fine grid in `scratch.plane`; read the result with [`SourceTransform::row`].
    pub fn transform(&self, scratch: &mut PlaneScratch<T>) {
        let all = 0..self.fine[0];
        self.fft.forward(scratch, std::slice::from_ref(&all));
    }

    /// Coefficients of order m, order n at index n mod the length, to be multiplied by
    /// [`SourceTransform::correction`].
    pub fn row<'a>(&self, scratch: &'a PlaneScratch<T>, m: i32) -> &'a [Complex<T>] {
        let row = m.rem_euclid(self.fine[0] as i32) as usize;
        &scratch.spectrum[row * self.fine[1]..(row + 1) * self.fine[1]]
    }

    /// Factor that removes the kernel from order (m, n).
    pub fn correction(&self, m: i32, n: i32) -> f64 {
        self.correction[0][m.unsigned_abs() as usize] * self.correction[1][n.unsigned_abs() as usize]
    }
}

/// Adds values[row, column, field] += wy[row] wx[column] value[field].
#[multiversion(targets("x86_64+avx512f+avx512vl+avx2+fma", "x86_64+avx2+fma"))]
fn spread_rows<T: Real>(values: &mut [T], stride: usize, wx: &[T], wy: &[T], value: &[T]) {
    let mut line = [T::default(); MOST * MOST_FIELDS];
    let line = &mut line[..wx.len() * value.len()];
    for (part, &w) in line.chunks_exact_mut(value.len()).zip(wx) {
        part.iter_mut().zip(value).for_each(|(p, &v)| *p = w * v);
    }
    for (row, &w) in wy.iter().enumerate() {
        let target = &mut values[row * stride..row * stride + line.len()];
        target.iter_mut().zip(&*line).for_each(|(t, &l)| *t += w * l);
    }
}

impl<'a, T: Real> Sources<'a, T> {
    /// Without any source.
    pub fn new(transform: &'a SourceTransform<T>, period_um: [f64; 2], fields: usize) -> Self {
        let patch = Vec::new();
        let grids = Vec::new();
        Sources { transform, period_um, fields, origin: [0; 2], size: [0; 2], patch, grids }
    }

    /// Clears the patch and places it around a body of the given lateral extents, µm.
    pub fn open(&mut self, extents: [[f64; 2]; 2]) {
        let margin = self.transform.kernel.width as f64 / 2.0 + 1.0;
        for axis in 0..2 {
            let [from, to] = extents[axis];
            let fine = self.transform.fine[axis] as f64;
            let center = 0.5 * (from + to) / self.period_um[axis] * fine;
            let reach = 0.5 * (to - from) / self.period_um[axis] * fine + margin;
            let low = (center - reach).floor();
            let high = (center + reach).ceil();
            self.origin[axis] = low as i64;
            self.size[axis] = (high - low) as usize + 1;
        }
        self.patch.clear();
        self.patch.resize(self.size[0] * self.size[1] * self.fields, T::default());
    }

    /// Adds a source to the patch: strength `value` per field.
    #[inline]
    pub fn spread(&mut self, position_um: [f64; 2], value: &[T]) {
        let SourceTransform { kernel, fine, .. } = self.transform;
        let [x, y] =
            [0, 1].map(|axis| kernel.footprint(position_um[axis] / self.period_um[axis] * fine[axis] as f64));
        let column = (x.first - self.origin[0]) as usize;
        let row = (y.first - self.origin[1]) as usize;
        let stride = self.size[0] * self.fields;
        let part = &mut self.patch[row * stride + column * self.fields..];
        spread_rows(part, stride, &x.weight[..kernel.width], &y.weight[..kernel.width], value);
    }

    /// Adds the patch to the grids.
    pub fn close(&mut self) {
        let fields = self.fields;
        let fine = self.transform.fine;
        if self.grids.is_empty() {
            self.grids = vec![vec![Complex::default(); fine[0] * fine[1]]; fields / 2];
        }
        let start = [0, 1].map(|axis| self.origin[axis].rem_euclid(fine[axis] as i64) as usize);
        for (row, line) in self.patch.chunks_exact(self.size[0] * fields).enumerate() {
            let y = (start[1] + row) % fine[1] * fine[0];
            for (p, grid) in self.grids.iter_mut().enumerate() {
                let mut x = start[0];
                for pair in line.chunks_exact(fields) {
                    grid[y + x] += Complex::new(pair[2 * p], pair[2 * p + 1]);
                    x = if x + 1 == fine[0] { 0 } else { x + 1 };
                }
            }
        }
    }
}

impl<T: Real> Kernel<T> {
    fn new(width: usize) -> Kernel<T> {
        let degree = width + EXTRA_DEGREE;
        let mut powers = vec![[T::default(); MOST]; degree + 1];
        for i in 0..width {
            let value = |fraction: f64| {
                kernel((i as f64 + fraction - width as f64 / 2.0) / (width as f64 / 2.0), width)
            };
            for (power, c) in polynomial(degree, value).into_iter().enumerate() {
                powers[degree - power][i] = T::of(c);
            }
        }
        Kernel { width, powers }
    }

    /// Footprint of a source at `x` in grid points.
    fn footprint(&self, x: f64) -> Footprint<T> {
        let edge = x - self.width as f64 / 2.0;
        let first = edge.ceil();
        Footprint { first: first as i64, weight: horner(&self.powers, T::of(2.0 * (first - edge) - 1.0)) }
    }
}

#[multiversion(targets("x86_64+avx512f+avx512vl+avx2+fma", "x86_64+avx2+fma"))]
fn horner<T: Real>(powers: &[[T; MOST]], t: T) -> [T; MOST] {
    let mut sum = powers[0];
    for coefficients in &powers[1..] {
        for i in 0..MOST {
            sum[i] = sum[i] * t + coefficients[i];
        }
    }
    sum
}

/// Coefficients of ascending powers of s = 2t − 1 that interpolate f(t) at Chebyshev points of 0 ≤
/// t ≤ 1.
fn polynomial(degree: usize, f: impl Fn(f64) -> f64) -> Vec<f64> {
    let count = degree + 1;
    let angle = |q: usize| PI * (q as f64 + 0.5) / count as f64;
    let samples: Vec<f64> = (0..count).map(|q| f(0.5 * (angle(q).cos() + 1.0))).collect();
    let mut sum = vec![0.0; count];
    let mut before = vec![0.0; count];
    let mut here = vec![0.0; count];
    here[0] = 1.0;
    for k in 0..count {
        let projection: f64 = samples.iter().enumerate().map(|(q, s)| s * (k as f64 * angle(q)).cos()).sum();
        let c = projection * if k == 0 { 1.0 } else { 2.0 } / count as f64;
        sum.iter_mut().zip(&here).for_each(|(s, h)| *s += c * h);
        // T_{k+1} = 2 s T_k − T_{k−1}, T_1 = s.
        let twice = if k == 0 { 1.0 } else { 2.0 };
        let shifted = |i: usize| if i > 0 { twice * here[i - 1] } else { 0.0 };
        let next: Vec<f64> = (0..count).map(|i| shifted(i) - before[i]).collect();
        (before, here) = (here, next);
    }
    sum
}

fn kernel(t: f64, width: usize) -> f64 {
    (SHAPE * width as f64 * ((1.0 - t * t).max(0.0).sqrt() - 1.0)).exp()
}

/// Smallest product of 2, 3 and 5 that holds the harmonics with the requested oversampling, and the
/// kernel.
fn fine_size(mmax: usize, spreading: Spreading) -> usize {
    let least = (spreading.points_per_order * mmax + 2).max(2 * spreading.width);
    (least..).find(|&n| is_smooth(n)).expect("smooth numbers are unbounded")
}

/// Whether a number is a product of 2, 3 and 5, a size with a fast transform.
pub fn is_smooth(mut n: usize) -> bool {
    for p in [2, 3, 5] {
        while n.is_multiple_of(p) {
            n /= p;
        }
    }
    n == 1
}

fn kernel_correction(mmax: usize, size: usize, width: usize) -> Vec<f64> {
    let half = width as f64 / 2.0;
    let rule = GaussLegendre::new(4 * width + 20).expect("at least two nodes");
    let transform = |m: usize| {
        let k = 2.0 * PI * m as f64 / size as f64 * half;
        half * rule.integrate(-1.0, 1.0, |t| kernel(t, width) * (k * t).cos())
    };
    (0..=mmax).map(|m| 1.0 / transform(m)).collect()
}

#[cfg(test)]
#[path = "nufft_tests.rs"]
mod tests;
