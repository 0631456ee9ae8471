//! Guided modes of the mean slab, treated exactly: they make large transparent cells hard to solve.
//!
//! Near its guided modes the mean slab is almost singular, and their number grows with the cell.
//! Let Φ collect the near-null node profiles, Q = ΦᵀAΦ and S = Φᵀ(A + V)Φ. Replacing Q by S in the
//! mean operator's inverse multiplies it from the right by C = 1 + Φ (S⁻¹ − Q⁻¹) (AΦ)ᵀ: sparse
//! products, one small dense solve, no operator application, and the residual in GMRES remains the
//! true one (Galerkin coarse correction; V enters by its Fourier coefficients at differences of
//! harmonics). Q couples only modes of the same harmonic.

use crate::numerics::dense::{MatrixEntry, symmetric_eigen};
use crate::numerics::fourier::{Real, narrow};
use crate::solve::Size;
use crate::wave::Problem;
use faer::linalg::solvers::PartialPivLu;
use faer::{ColRef, Mat};
use ndarray::{Array2, ArrayView1};
use num_complex::{Complex, Complex64};
use rayon::prelude::*;
use std::f64::consts::TAU;
use std::ops::AddAssign;

/// Selection of the guided modes to treat.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(deny_unknown_fields, default)
)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct GuidedModes {
    /// Modes with |eigenvalue| below this multiple of k0² count as near-null; 0 switches the
    /// correction off.
    pub threshold: f64,
    /// Largest number of modes (those nearest to null): the dense block costs their cube once, and
    /// 16 bytes times their square.
    pub most: usize,
    /// Smallest number of harmonics with such modes for which the correction pays off: in cells of
    /// 2.4 µm or less the dense blocks cost more than the steps they save (measured at κ = 0: 20
    /// against 13 ms; at 4.8 µm 0.75 against 1.23 s).
    pub least_harmonics: usize,
    /// Mean absorption Im⟨k²⟩/k0² above which guided modes are damped and need no treatment.
    pub damped: f64,
}

impl Default for GuidedModes {
    fn default() -> GuidedModes {
        GuidedModes { threshold: 0.4, most: 4500, least_harmonics: 300, damped: 0.02 }
    }
}

/// One mode: a harmonic and values at the nodes.
struct Mode {
    harmonic: usize,
    /// |eigenvalue| of the mean operator, including damping.
    eigenvalue: f64,
    nodes: Vec<f64>,
}

impl Mode {
    /// The operator A applied to the mode, at the nodes.
    fn image(&self, problem: &Problem) -> Vec<Complex64> {
        let (diagonal, off) = problem.mean.node_matrix(self.harmonic, problem.end_conditions(self.harmonic));
        (0..diagonal.len()).map(|j| tridiagonal_row(&diagonal, &off, &self.nodes, j)).collect()
    }
}

/// Row j of a symmetric tridiagonal matrix times x.
#[inline]
fn tridiagonal_row(diagonal: &[Complex64], off: &[Complex64], x: &[f64], j: usize) -> Complex64 {
    let previous = if j > 0 { off[j - 1] * x[j - 1] } else { Complex64::default() };
    let next = if j < off.len() { off[j] * x[j + 1] } else { Complex64::default() };
    diagonal[j] * x[j] + previous + next
}

/// The operator C, ready to be applied to fields.
pub(crate) struct Correction {
    modes: Vec<Mode>,
    /// Products AΦ at the nodes.
    images: Vec<Vec<Complex64>>,
    /// The Galerkin matrix S, factorised.
    galerkin: PartialPivLu<Complex64>,
    /// First mode of each harmonic and its block of Q⁻¹.
    mean_inverses: Vec<(usize, Mat<Complex64>)>,
    harmonics: usize,
    stride: usize,
}

/// Factor on `threshold` in hard solves, where high contrast couples modes further from null
/// (measured, n = 2.6: 258 applications with 5, 300 with 2, 169 with 11, which costs more in dense
/// blocks than it saves).
const HARD: f64 = 5.0;
/// Upper limit on the number of modes in hard solves.
const MOST_HARD: usize = 1500;
/// Dense blocks held simultaneously: columns, the matrix, and both factors.
const BLOCKS: f64 = 4.0;

impl GuidedModes {
    /// Largest memory of the correction in bytes, including its construction.
    pub(super) fn most_bytes(&self, size: &Size) -> f64 {
        if self.threshold <= 0.0 || self.most == 0 {
            return 0.0;
        }
        let modes = size.near_null_modes(self.threshold).min(self.most as f64);
        // Profiles, images and values on planes for every mode; spectra of every plane.
        BLOCKS * 16.0 * modes * modes + 48.0 * modes * size.planes() + size.fields(1.0)
    }

    /// Settings for hard solves, where the correction pays off in small cells too.
    pub(super) fn of_hard_solves(self) -> Self {
        Self { threshold: HARD * self.threshold, most: self.most.min(MOST_HARD), least_harmonics: 0, ..self }
    }

    /// Settings whose dense block takes at most `bytes`.
    pub(super) fn within(self, bytes: f64) -> Self {
        let most = (bytes.max(0.0) / (BLOCKS * 16.0)).sqrt() as usize;
        Self { most: self.most.min(most), ..self }
    }

    /// The correction for a problem, or `None` if it would not pay off.
    pub(crate) fn correction(&self, problem: &Problem) -> Option<Correction> {
        let k0_squared = (TAU / problem.incidence.wavelength_um).powi(2);
        if self.threshold <= 0.0 || problem.mean.mean_absorption() > self.damped * k0_squared {
            return None;
        }
        let limit = self.threshold * k0_squared;
        let harmonics = 0..problem.harmonics.len();
        let near: Vec<usize> = harmonics.filter(|&i| may_be_near_null(problem, i, limit)).collect();
        if near.len() < self.least_harmonics {
            return None;
        }
        let mut modes: Vec<_> = near.into_par_iter().flat_map_iter(|i| modes_of(problem, i, limit)).collect();
        modes.sort_by(|a, b| a.eigenvalue.total_cmp(&b.eigenvalue));
        modes.truncate(self.most);
        modes.sort_by_key(|m| m.harmonic);
        (!modes.is_empty()).then(|| Correction::new(problem, modes))
    }
}

/// Whether a harmonic may have modes near null. Strongly evanescent ones cannot: rows of the node
/// matrix over their masses sum to at most −2κ tanh(κh/2)/h with κ² = kx² + ky² − max k̄², which
/// decreases with the height of the cells.
fn may_be_near_null(problem: &Problem, harmonic: usize, limit: f64) -> bool {
    let highest = problem.mean.mean_k2.iter().map(|k2| k2.re).fold(f64::NEG_INFINITY, f64::max);
    let lateral: f64 = problem.lateral[harmonic].iter().map(|k| k * k).sum();
    let grid = &problem.coverage.grid;
    let h = (0..grid.cells()).map(|j| grid.height_um(j)).fold(0.0, f64::max);
    let decay = (lateral - highest).max(0.0).sqrt();
    2.0 * decay * (0.5 * decay * h).tanh() / h < limit
}

/// Near-null eigenvectors of one harmonic's mean operator on the nodes.
fn modes_of(problem: &Problem, harmonic: usize, limit: f64) -> Vec<Mode> {
    let ends = problem.end_conditions(harmonic);
    let (diagonal, off) = problem.mean.node_matrix(harmonic, ends);
    let mass = problem.mean.node_mass();
    let n = diagonal.len();
    let scaled = |i: usize, j: usize| {
        let value = if i == j { diagonal[i].re } else { off[i.min(j)].re };
        if i.abs_diff(j) <= 1 { value / (mass[i] * mass[j]).sqrt() } else { 0.0 }
    };
    let Some((values, vectors)) = symmetric_eigen(&Mat::from_fn(n, n, scaled)) else { return Vec::new() };
    // A mode that radiates into a half-space is as far from null as its damping.
    let damping = |e: usize| {
        let first = vectors[(0, e)].powi(2) / mass[0];
        let last = vectors[(n - 1, e)].powi(2) / mass[n - 1];
        ends[0].im * first + ends[1].im * last
    };
    let size = |e: usize| values[e].hypot(damping(e));
    let near = (0..n).filter(|&e| size(e) < limit).map(|e| {
        let nodes = (0..n).map(|j| vectors[(j, e)] / mass[j].sqrt()).collect();
        Mode { harmonic, eigenvalue: size(e), nodes }
    });
    near.collect()
}

impl Correction {
    fn new(problem: &Problem, modes: Vec<Mode>) -> Correction {
        let images: Vec<Vec<Complex64>> = modes.iter().map(|mode| mode.image(problem)).collect();
        // Called for modes of one harmonic only: A does not couple different ones.
        let mean_block =
            |i: usize, j: usize| modes[i].nodes.iter().zip(&images[j]).map(|(a, b)| a * b).sum::<Complex64>();
        let mut galerkin = contrast_block(problem, &modes);
        let mut mean_inverses = Vec::new();
        let mut first = 0;
        for group in modes.chunk_by(|a, b| a.harmonic == b.harmonic) {
            let block = Mat::from_fn(group.len(), group.len(), |i, j| mean_block(first + i, first + j));
            galerkin.as_mut().submatrix_mut(first, first, group.len(), group.len()).add_assign(&block);
            mean_inverses.push((first, Complex64::inverse(block.as_ref())));
            first += group.len();
        }
        let harmonics = problem.harmonics.len();
        let stride = problem.coverage.grid.element.degree;
        Correction {
            galerkin: Complex64::factors(galerkin.as_ref()),
            modes,
            images,
            mean_inverses,
            harmonics,
            stride,
        }
    }

    /// Memory held, bytes.
    pub fn bytes(&self) -> usize {
        let nodes: usize = self.images.iter().map(|image| image.len()).sum();
        (self.modes.len().pow(2) + nodes) * size_of::<Complex64>() + nodes * size_of::<f64>()
    }

    /// Applies v ← C v.
    pub fn apply<T: Real>(&self, v: &mut [Complex<T>]) {
        let parts = self.modes.iter().zip(&self.images);
        let projected: Vec<Complex64> = parts.map(|(mode, image)| self.product(mode, image, v)).collect();
        let projected = ColRef::from_slice(&projected);
        let mut change = Complex64::solve(&self.galerkin, projected.as_mat());
        for (first, inverse) in &self.mean_inverses {
            let group = projected.subrows(*first, inverse.nrows());
            let part = Complex64::product(inverse.as_ref(), group.as_mat());
            part.col(0).iter().enumerate().for_each(|(i, p)| change[(first + i, 0)] -= p);
        }
        for (mode, c) in self.modes.iter().zip(change.col(0).iter()) {
            for (j, a) in mode.nodes.iter().enumerate() {
                v[self.place(j, mode.harmonic)] += narrow(a * c);
            }
        }
    }

    /// Index of a node's value for one harmonic in a field.
    #[inline]
    fn place(&self, node: usize, harmonic: usize) -> usize {
        node * self.stride * self.harmonics + harmonic
    }

    /// Product (Aφ)ᵀ v for one mode φ; `image` is Aφ.
    #[inline]
    fn product<T: Real>(&self, mode: &Mode, image: &[Complex64], v: &[Complex<T>]) -> Complex64 {
        let products = image.iter().enumerate().map(|(j, a)| {
            let z = v[self.place(j, mode.harmonic)];
            a * Complex64::new(z.re.wide(), z.im.wide())
        });
        products.sum()
    }
}

/// Σ_p w(p) f(p) g(p) over the planes.
#[inline]
fn coupling(f: &[Complex64], g: &[Complex64], w: ArrayView1<Complex64>) -> Complex64 {
    f.iter().zip(g).zip(w).map(|((f, g), w)| w * f * g).sum()
}

/// The block ΦᵀVΦ: Σ_p Ŵ_p(l − l') f_i(p) f_j(p), with the mean solution's values f on the planes.
fn contrast_block(problem: &Problem, modes: &[Mode]) -> Mat<Complex64> {
    let planes = problem.shape().0;
    let profiles: Vec<Vec<Complex64>> =
        modes.iter().map(|m| problem.mean.profile_on_planes(m.harmonic, &m.nodes)).collect();
    let nx = problem.coverage.grid.resolution.nx;
    let ny = problem.coverage.grid.resolution.ny;
    // Planes run fastest, so that a pair of harmonics reads contiguous memory.
    let mut spectra = Array2::zeros((nx * ny, planes));
    for p in 0..planes {
        spectra.column_mut(p).iter_mut().zip(problem.contrast_spectrum(p)).for_each(|(s, w)| *s = w);
    }
    let spectrum_of = |i: usize, j: usize| {
        let order = |mode: usize| problem.harmonics.orders[modes[mode].harmonic];
        let a = order(i);
        let b = order(j);
        let wrap = |axis: usize, n: usize| (a[axis] - b[axis]).rem_euclid(n as i32) as usize;
        spectra.row(wrap(0, nx) * ny + wrap(1, ny))
    };
    let column = |j: usize| {
        let entry = |i: usize| coupling(&profiles[i], &profiles[j], spectrum_of(i, j));
        (0..modes.len()).map(entry).collect::<Vec<_>>()
    };
    let columns: Vec<Vec<Complex64>> = (0..modes.len()).into_par_iter().map(column).collect();
    Mat::from_fn(modes.len(), modes.len(), |i, j| columns[j][i])
}
