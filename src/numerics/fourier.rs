//! Two-dimensional transforms of planes; spectra remain transposed, and only harmonics in use are
//! kept.

use multiversion::multiversion;
use num_complex::{Complex, Complex64};
use rustfft::num_traits::NumAssign;
use rustfft::{Fft, FftDirection, FftNum, FftPlanner};
use std::iter::once;
use std::ops::Range;
use std::sync::Arc;

/// Floating-point types of transforms: `f64`, and `f32` where its rounding is far below the
/// requested error.
pub trait Real: FftNum + NumAssign + PartialOrd + Default + bytemuck::Pod {
    /// Relative rounding residue of a vector that should vanish: some hundred rounding errors.
    const ROUNDING: f64;
    /// The nearest number of this type.
    fn of(x: f64) -> Self;
    /// Conversion to double precision.
    fn wide(self) -> f64;
    /// A transform of vectors of this length.
    fn plan(len: usize, direction: FftDirection) -> Arc<dyn Fft<Self>>;
}

impl Real for f64 {
    const ROUNDING: f64 = 1e-14;
    #[inline]
    fn of(x: f64) -> f64 {
        x
    }
    #[inline]
    fn wide(self) -> f64 {
        self
    }
    fn plan(len: usize, direction: FftDirection) -> Arc<dyn Fft<f64>> {
        FftPlanner::new().plan_fft(len, direction)
    }
}

impl Real for f32 {
    const ROUNDING: f64 = 1e-6;
    #[inline]
    fn of(x: f64) -> f32 {
        x as f32
    }
    #[inline]
    fn wide(self) -> f64 {
        self.into()
    }
    fn plan(len: usize, direction: FftDirection) -> Arc<dyn Fft<f32>> {
        FftPlanner::new().plan_fft(len, direction)
    }
}

/// A complex number in another precision.
pub fn narrow<T: Real>(z: Complex64) -> Complex<T> {
    Complex::new(T::of(z.re), T::of(z.im))
}

/// Transforms of an nx × ny plane (x runs fastest), unnormalised in both directions.
///
/// The spectrum remains transposed (n runs fastest): one transposition per transform instead of
/// two.
#[derive(Clone)]
pub struct PlaneFft<T: Real = f64> {
    nx: usize,
    ny: usize,
    forward: [Arc<dyn Fft<T>>; 2],
    inverse: [Arc<dyn Fft<T>>; 2],
}

/// Work arrays of one thread: a plane, its transposed spectrum, and the scratch space of the
/// transforms.
pub struct PlaneScratch<T: Real = f64> {
    /// Values at the points, x fastest.
    pub plane: Vec<Complex<T>>,
    /// Transposed spectrum, n fastest.
    pub spectrum: Vec<Complex<T>>,
    work: Vec<Complex<T>>,
}

impl<T: Real> PlaneFft<T> {
    /// Plans both directions of the transform.
    pub fn new(nx: usize, ny: usize) -> PlaneFft<T> {
        let plans = |direction| [nx, ny].map(|len| T::plan(len, direction));
        PlaneFft { nx, ny, forward: plans(FftDirection::Forward), inverse: plans(FftDirection::Inverse) }
    }

    /// Number of points along x.
    pub fn nx(&self) -> usize {
        self.nx
    }

    /// Allocates the work arrays of one thread.
    pub fn scratch(&self) -> PlaneScratch<T> {
        let plans = self.forward.iter().chain(&self.inverse);
        let work = plans.map(|p| p.get_inplace_scratch_len()).max().unwrap_or(0);
        let zero = Complex::<T>::default();
        let points = self.nx * self.ny;
        PlaneScratch { plane: vec![zero; points], spectrum: vec![zero; points], work: vec![zero; work] }
    }

    /// `plane` → `spectrum`; rows of the spectrum outside `used` (ranges of m mod nx) are
    /// undefined.
    pub fn forward(&self, s: &mut PlaneScratch<T>, used: &[Range<usize>]) {
        self.forward[0].process_with_scratch(&mut s.plane, &mut s.work);
        transpose(&s.plane, &mut s.spectrum, self.nx);
        for rows in used {
            let part = &mut s.spectrum[rows.start * self.ny..rows.end * self.ny];
            self.forward[1].process_with_scratch(part, &mut s.work);
        }
    }

    /// `spectrum` → `plane`; rows of the spectrum outside `used` must be zero.
    pub fn inverse(&self, s: &mut PlaneScratch<T>, used: &[Range<usize>]) {
        for rows in used {
            let part = &mut s.spectrum[rows.start * self.ny..rows.end * self.ny];
            self.inverse[1].process_with_scratch(part, &mut s.work);
        }
        transpose(&s.spectrum, &mut s.plane, self.ny);
        self.inverse[0].process_with_scratch(&mut s.plane, &mut s.work);
    }
}

/// Rows transposed together: what is written at a time is a cache line of double precision.
const TOGETHER: usize = 4;

/// Transposes rows of `width` numbers: in small planes faster than a general transposition, whose
/// blocks are larger than they are.
#[multiversion(targets("x86_64+avx2"))]
fn transpose<T: Real>(from: &[Complex<T>], to: &mut [Complex<T>], width: usize) {
    let height = from.len() / width;
    for (band, rows) in from.chunks(TOGETHER * width).enumerate() {
        let first = band * TOGETHER;
        let columns = to.chunks_exact_mut(height).enumerate();
        if rows.len() == TOGETHER * width {
            let [a, b, c, d]: [_; TOGETHER] = std::array::from_fn(|i| &rows[i * width..][..width]);
            columns
                .for_each(|(x, to)| to[first..first + TOGETHER].copy_from_slice(&[a[x], b[x], c[x], d[x]]));
        } else {
            for (x, to) in columns {
                to[first..].iter_mut().zip(rows.chunks_exact(width)).for_each(|(to, row)| *to = row[x]);
            }
        }
    }
}

/// The harmonics in use, |m| < nx/2 and |n| < ny/2: the set is symmetric, so reciprocity holds on
/// the grid.
pub struct Harmonics {
    /// (m, n) of each compact index.
    pub orders: Vec<[i32; 2]>,
    /// Contiguous runs (position in the spectrum, compact index, length).
    runs: Vec<[usize; 3]>,
    /// What lies between the runs in the spectrum.
    gaps: Vec<Range<usize>>,
    /// Rows (m mod nx) of the transposed spectrum that hold harmonics.
    pub rows: Vec<Range<usize>>,
}

impl Harmonics {
    /// The harmonics of a grid of nx × ny points.
    pub fn new(nx: usize, ny: usize) -> Harmonics {
        let mmax = (nx as i32 - 1) / 2;
        let nmax = (ny as i32 - 1) / 2;
        let rows = once(0..mmax as usize + 1).chain((mmax > 0).then(|| nx - mmax as usize..nx)).collect();
        let mut harmonics = Harmonics { orders: Vec::new(), runs: Vec::new(), gaps: Vec::new(), rows };
        for m in (0..=mmax).chain(-mmax..0) {
            let row = m.rem_euclid(nx as i32) as usize * ny;
            harmonics.push_run(row, m, 0..nmax + 1);
            harmonics.push_run(row + ny - nmax as usize, m, -nmax..0);
        }
        let mut starts: Vec<[usize; 2]> = harmonics.runs.iter().map(|&[at, _, len]| [at, len]).collect();
        starts.sort_unstable();
        let ends = once(0).chain(starts.iter().map(|[at, len]| at + len));
        let next = starts.iter().map(|[at, _]| *at).chain([nx * ny]);
        harmonics.gaps = ends.zip(next).map(|(end, next)| end..next).filter(|gap| !gap.is_empty()).collect();
        harmonics
    }

    fn push_run(&mut self, position: usize, m: i32, n: Range<i32>) {
        if !n.is_empty() {
            self.runs.push([position, self.orders.len(), n.len()]);
            self.orders.extend(n.map(|n| [m, n]));
        }
    }

    /// Number of harmonics in use.
    #[inline]
    pub fn len(&self) -> usize {
        self.orders.len()
    }

    /// Never true: (0, 0) is always in use.
    pub fn is_empty(&self) -> bool {
        self.orders.is_empty()
    }

    /// Compact index of order (m, n), if it is in use.
    pub fn find(&self, m: i32, n: i32) -> Option<usize> {
        self.orders.iter().position(|&o| o == [m, n])
    }

    /// Spreads compact harmonics over a transposed spectrum, with zeros between them.
    pub fn spread<T: Copy + Default>(&self, compact: &[T], spectrum: &mut [T]) {
        self.gaps.iter().for_each(|gap| spectrum[gap.clone()].fill(T::default()));
        for &[position, index, len] in &self.runs {
            spectrum[position..position + len].copy_from_slice(&compact[index..index + len]);
        }
    }

    /// Gathers the harmonics in use from a transposed spectrum.
    pub fn gather<T: Copy>(&self, spectrum: &[T], compact: &mut [T]) {
        for &[position, index, len] in &self.runs {
            compact[index..index + len].copy_from_slice(&spectrum[position..position + len]);
        }
    }
}

#[cfg(test)]
#[path = "fourier_tests.rs"]
mod tests;
