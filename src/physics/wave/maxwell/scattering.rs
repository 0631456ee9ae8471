//! One application of A⁻¹V, in double or in single precision: the main cost of every iterative
//! strategy.
//!
//! Per plane: s, p, z harmonics to x, y, z at the points, product with the tensor, and back; three
//! inverse and three forward transforms. Then the mean solve per harmonic. Small fields are
//! processed by one thread.

use super::mean::VectorMean;
use super::symmetric::Symmetric;
use crate::numerics::fourier::{Harmonics, PlaneFft, PlaneScratch, Real, narrow};
use crate::wave::operator::inverse::{Line, row, row_of};
use crate::wave::operator::scattering::Scatter;
use crate::wave::operator::sharing::Idle;
use multiversion::multiversion;
use ndarray::{Array2, ArrayView2, ArrayViewMut2, Axis};
use num_complex::{Complex, Complex64};
use rayon::prelude::*;
use std::sync::Arc;

/// The operator A⁻¹V as tables.
pub struct VectorScattering<T: Real> {
    pub(super) mean: VectorMean<T>,
    harmonics: Arc<Harmonics>,
    /// Unit vector p̂ of every harmonic; that of the incident azimuth if the wavevector has no
    /// lateral part.
    directions: Vec<[T; 2]>,
    fft: PlaneFft<T>,
    /// Tensor V of every plane: its six components (rows) at the points; no rows if it vanishes.
    contrast: Vec<Array2<Complex<T>>>,
    idle: Idle<PlaneWork<T>>,
}

impl VectorScattering<f64> {
    /// Built from the mean operator, p̂ of every harmonic, and V of every Gauss plane
    /// divided by its number of points.
    pub fn new(
        mean: VectorMean,
        harmonics: Arc<Harmonics>,
        directions: Vec<[f64; 2]>,
        fft: PlaneFft,
        contrast: &[Vec<Symmetric>],
    ) -> Self {
        let rows = |plane: &Vec<Symmetric>| {
            let count = if plane.is_empty() { 0 } else { 6 };
            Array2::from_shape_fn((count, plane.len()), |(component, point)| plane[point][component])
        };
        let contrast = contrast.par_iter().map(rows).collect();
        VectorScattering { mean, harmonics, directions, fft, contrast, idle: Idle::default() }
    }

    /// Unit vectors of the components s, p, z of a harmonic.
    pub(super) fn axes(&self, harmonic: usize) -> [[f64; 3]; 3] {
        let [x, y] = self.directions[harmonic];
        [[-y, x, 0.0], [x, y, 0.0], [0.0, 0.0, 1.0]]
    }

    /// Fourier coefficients of the components xx, xy, yy, xz, yz, zz of V on a plane at (m mod nx,
    /// n mod ny), n fastest; `None` if it vanishes.
    pub(super) fn spectrum(&self, plane: usize) -> Option<[Vec<Complex64>; 6]> {
        let tensor = self.contrast.get(plane).filter(|tensor| !tensor.is_empty())?;
        let mut scratch = self.fft.scratch();
        let rows = 0..self.fft.nx();
        Some(std::array::from_fn(|component| {
            scratch.plane.copy_from_slice(row_of(tensor, component));
            self.fft.forward(&mut scratch, std::slice::from_ref(&rows));
            scratch.spectrum.clone()
        }))
    }

    /// The operator in single precision.
    pub fn narrowed(&self, fft: PlaneFft<f32>) -> VectorScattering<f32> {
        let mean = self.mean.narrowed();
        let harmonics = self.harmonics.clone();
        let directions = self.directions.iter().map(|d| d.map(|x| x as f32)).collect();
        let contrast = self.contrast.par_iter().map(|plane| plane.mapv(narrow)).collect();
        VectorScattering { mean, harmonics, directions, fft, contrast, idle: Idle::default() }
    }
}

impl<T: Real> VectorScattering<T> {
    /// Whether there is contrast; layered media with an exact mean have none.
    pub fn has_contrast(&self) -> bool {
        self.contrast.iter().any(|plane| !plane.is_empty())
    }

    /// Memory held, bytes.
    pub fn bytes(&self) -> usize {
        let tensors: usize = self.contrast.iter().map(|plane| plane.len()).sum();
        self.mean.bytes() + tensors * size_of::<Complex<T>>()
    }

    /// Applies out ← V e: three inverse and three forward transforms per plane.
    pub fn contrast_product(&self, e: ArrayView2<Complex<T>>, out: &mut Array2<Complex<T>>) {
        let new = || PlaneWork::new(self);
        self.idle.in_chunks(out, Axis(0), 3, new, |plane, out, work| self.plane_product(e, plane, out, work));
    }

    /// Applies out ← V e on one plane.
    fn plane_product(
        &self,
        e: ArrayView2<Complex<T>>,
        plane: usize,
        mut out: ArrayViewMut2<Complex<T>>,
        work: &mut PlaneWork<T>,
    ) {
        if self.contrast[plane].is_empty() {
            return out.fill(Complex::default());
        }
        let rows = [0, 1, 2].map(|c| row(&e, 3 * plane + c));
        work.to_points(self, rows);
        let [x, y, z] = &mut work.scratch;
        let tensors = self.contrast[plane].as_slice().expect("tensors are contiguous");
        multiply(tensors, &mut x.plane, &mut y.plane, &mut z.plane); // E ← V E at every point
        work.to_harmonics(self, out.as_slice_mut().expect("rows are contiguous"));
    }
}

impl<T: Real> Scatter<T> for VectorScattering<T> {
    fn scatter(&self, e: ArrayView2<Complex<T>>, out: &mut Array2<Complex<T>>) {
        self.contrast_product(e, out);
        self.mean.solve(out);
    }
}

/// Work arrays of one thread: three components of one plane.
struct PlaneWork<T: Real> {
    scratch: [PlaneScratch<T>; 3],
    compact: [Vec<Complex<T>>; 2],
}

impl<T: Real> PlaneWork<T> {
    fn new(operator: &VectorScattering<T>) -> Self {
        let zeros = || vec![Complex::default(); operator.harmonics.len()];
        PlaneWork { scratch: [0, 1, 2].map(|_| operator.fft.scratch()), compact: [zeros(), zeros()] }
    }

    /// Transforms s, p, z harmonics to x, y, z at the points.
    fn to_points(&mut self, operator: &VectorScattering<T>, [s, p, z]: [&[Complex<T>]; 3]) {
        let [x, y] = &mut self.compact;
        rotate(&operator.directions, s, p, x, y);
        let spectra: [&[Complex<T>]; 3] = [x, y, z];
        for (scratch, spectrum) in self.scratch.iter_mut().zip(spectra) {
            operator.harmonics.spread(spectrum, &mut scratch.spectrum);
            operator.fft.inverse(scratch, &operator.harmonics.rows);
        }
    }

    /// Transforms x, y, z at the points to s, p, z harmonics, consecutively in `out`.
    fn to_harmonics(&mut self, operator: &VectorScattering<T>, out: &mut [Complex<T>]) {
        let count = operator.harmonics.len();
        let (plane, z) = out.split_at_mut(2 * count);
        let [x, y] = &mut self.compact;
        for (scratch, spectrum) in self.scratch.iter_mut().zip([&mut x[..], &mut y[..], z]) {
            operator.fft.forward(scratch, &operator.harmonics.rows);
            operator.harmonics.gather(&scratch.spectrum, spectrum);
        }
        let (s, p) = plane.split_at_mut(count);
        rotate(&operator.directions, x, y, s, p);
    }
}

/// Components (x, y) from (s, p): s = ẑ × p̂. This is a reflection, which is its own inverse.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx2+fma", "x86_64+avx2+fma"))]
fn rotate<T: Real>(directions: &[[T; 2]], s: &Line<T>, p: &Line<T>, x: &mut Line<T>, y: &mut Line<T>) {
    let inputs = directions.iter().zip(s.iter().zip(p));
    for ((x, y), (&[px, py], (s, p))) in x.iter_mut().zip(y.iter_mut()).zip(inputs) {
        *x = p.scale(px) - s.scale(py);
        *y = p.scale(py) + s.scale(px);
    }
}

/// Multiplies E ← V E; the tensor's components xx, xy, yy, xz, yz, zz are stored consecutively.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx2+fma", "x86_64+avx2+fma"))]
fn multiply<T: Real>(tensors: &Line<T>, x: &mut Line<T>, y: &mut Line<T>, z: &mut Line<T>) {
    let points = x.len();
    let y = &mut y[..points];
    let z = &mut z[..points];
    let component = |k: usize| &tensors[k * points..(k + 1) * points];
    let (xx, xy, yy) = (component(0), component(1), component(2));
    let (xz, yz, zz) = (component(3), component(4), component(5));
    for i in 0..points {
        let e = [x[i], y[i], z[i]];
        x[i] = xx[i] * e[0] + xy[i] * e[1] + xz[i] * e[2];
        y[i] = xy[i] * e[0] + yy[i] * e[1] + yz[i] * e[2];
        z[i] = xz[i] * e[0] + yz[i] * e[1] + zz[i] * e[2];
    }
}
