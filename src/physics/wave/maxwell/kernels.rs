//! Arithmetic of the mean operator, in one cell and between the nodes: plain loops over harmonics,
//! written so that they vectorise.
//!
//! Sums and differences of the two Gauss planes carry b and c of [`super::cell`]; l₊ = 1 + x²b, −l₋
//! = (1 + x²c)/√3.

use crate::numerics::fourier::{Real, narrow};
use crate::wave::operator::inverse::row_of;
use crate::wave::operator::mean::inverse_pivots;
use multiversion::multiversion;
use ndarray::Array2;
use num_complex::{Complex, Complex64};

/// Constants of a cell, common to all harmonics.
#[derive(Clone, Copy)]
pub(super) struct Constants<T: Real> {
    h: T,
    h2: T,
    k2: Complex<T>,
    inverse_k2: Complex<T>,
    /// Factor 2i/(k̄² h).
    slope: Complex<T>,
    /// Factor −1/(4k̄²).
    magnetic: Complex<T>,
    /// Factor 1/√3.
    third: T,
}

impl<T: Real> Constants<T> {
    pub fn new(h: f64, k2: Complex64) -> Constants<T> {
        Constants {
            h: T::of(h),
            h2: T::of(h * h),
            k2: narrow(k2),
            inverse_k2: narrow(1.0 / k2),
            slope: narrow(2.0 * Complex64::I / (k2 * h)),
            magnetic: narrow(-0.25 / k2),
            third: T::of(1.0 / 3f64.sqrt()),
        }
    }

    /// Node functions x²b, l₊ and −l₋ of a harmonic with lateral wavenumber q.
    #[inline(always)]
    fn node_functions(&self, q: T, b: Complex<T>, c: Complex<T>) -> [Complex<T>; 3] {
        let x2 = Complex::new(self.k2.re - q * q, self.k2.im).scale(self.h2); // x² = (k̄² − q²) h²
        let (x2b, x2c) = (x2 * b, x2 * c);
        let sum = Complex::new(T::one() + x2b.re, x2b.im); // l₊ = 1 + x²b
        // −l₋ = (1 + x²c)/√3
        let difference = Complex::new(T::one() + x2c.re, x2c.im).scale(self.third);
        [x2b, sum, difference]
    }
}

/// A cell's tables over a block of harmonics.
#[derive(Clone, Copy)]
pub(super) struct Tables<'a, T: Real> {
    pub lateral: &'a [T],
    pub b: &'a [Complex<T>],
    pub c: &'a [Complex<T>],
}

impl<'a, T: Real> Tables<'a, T> {
    /// All three tables, cut to a length known to the loops.
    #[inline(always)]
    fn cut(&self, width: usize) -> (&'a [T], &'a [Complex<T>], &'a [Complex<T>]) {
        (&self.lateral[..width], &self.b[..width], &self.c[..width])
    }
}

/// Product i z.
#[inline(always)]
fn turned<T: Real>(z: Complex<T>) -> Complex<T> {
    Complex::new(-z.im, z.re)
}

/// Adds the right-hand sides of both nodes of a cell, E_s (u) and h (w), due to its source F = V E
/// (J = −F): components s, p, z on the first and on the second Gauss plane. TE ±: h/4 (l₊F_s₊ ∓ …),
/// TM: −1/(4k̄²) [q h (l₊F_z₊ …) …].
#[multiversion(targets("x86_64+avx512f+avx512vl+avx2+fma", "x86_64+avx2+fma"))]
pub(super) fn add_loads<T: Real>(
    cell: &Constants<T>,
    tables: &Tables<T>,
    rows: &[&[Complex<T>]; 6],
    u0: &mut [Complex<T>],
    u1: &mut [Complex<T>],
    w0: &mut [Complex<T>],
    w1: &mut [Complex<T>],
) {
    let width = u0.len();
    let u1 = &mut u1[..width];
    let w0 = &mut w0[..width];
    let w1 = &mut w1[..width];
    let [s0, p0, z0, s1, p1, z1] = rows.map(|row| &row[..width]);
    let (lateral, b, c) = tables.cut(width);
    let cell = *cell;
    let Constants { h, magnetic, .. } = cell;
    let electric = T::of(0.25) * h;
    let root12 = T::of(12f64.sqrt());
    let two = T::of(2.0);
    for i in 0..width {
        let q = lateral[i];
        let [x2b, sum, difference] = cell.node_functions(q, b[i], c[i]);
        let even = (sum * (s0[i] + s1[i])).scale(electric); // h/4 l₊ F_s₊
        let odd = (difference * (s1[i] - s0[i])).scale(electric); // −h/4 l₋ F_s₋
        u0[i] += even - odd;
        u1[i] += even + odd;
        let qh = q * h;
        // q h l₊ F_z₊ + i√12 x²b F_p₋
        let even = (sum * (z0[i] + z1[i])).scale(qh) + turned(x2b * (p1[i] - p0[i])).scale(root12);
        // −q h l₋ F_z₋ − 2i F_p₊
        let odd = (difference * (z1[i] - z0[i])).scale(qh) - turned(p0[i] + p1[i]).scale(two);
        w0[i] += magnetic * (even - odd); // factor of −1/(4k̄²)
        w1[i] += magnetic * (even + odd);
    }
}

/// TE: replaces F by the moments of the field along s on the first and on the second Gauss plane,
/// given E_s at the cell's `nodes`.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx2+fma", "x86_64+avx2+fma"))]
pub(super) fn across<T: Real>(
    cell: &Constants<T>,
    tables: &Tables<T>,
    nodes: [&[Complex<T>]; 2],
    s0: &mut [Complex<T>],
    s1: &mut [Complex<T>],
) {
    let width = s0.len();
    let s1 = &mut s1[..width];
    let [u0, u1] = nodes.map(|node| &node[..width]);
    let (lateral, b, c) = tables.cut(width);
    let cell = *cell;
    let h2 = cell.h2;
    let half = T::of(0.5);
    for i in 0..width {
        let [_, sum, difference] = cell.node_functions(lateral[i], b[i], c[i]);
        // e_s₊ = l₊u₊ − h²b F_s₊
        let even = sum * (u0[i] + u1[i]) - (b[i] * (s0[i] + s1[i])).scale(h2);
        // e_s₋ = −l₋u₋ − h²c F_s₋
        let odd = difference * (u1[i] - u0[i]) - (c[i] * (s1[i] - s0[i])).scale(h2);
        s0[i] = (even - odd).scale(half); // e₁ = (e₊ − e₋)/2
        s1[i] = (even + odd).scale(half); // e₂ = (e₊ + e₋)/2
    }
}

/// TM: the same along p̂ and z, given h at the cell's `nodes`.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx2+fma", "x86_64+avx2+fma"))]
pub(super) fn within<T: Real>(
    cell: &Constants<T>,
    tables: &Tables<T>,
    nodes: [&[Complex<T>]; 2],
    p0: &mut [Complex<T>],
    z0: &mut [Complex<T>],
    p1: &mut [Complex<T>],
    z1: &mut [Complex<T>],
) {
    let width = p0.len();
    let z0 = &mut z0[..width];
    let p1 = &mut p1[..width];
    let z1 = &mut z1[..width];
    let [w0, w1] = nodes.map(|node| &node[..width]);
    let (lateral, b, c) = tables.cut(width);
    let cell = *cell;
    let Constants { h, h2, inverse_k2, slope, .. } = cell;
    let root3 = T::of(3f64.sqrt());
    let root12 = T::of(12f64.sqrt());
    let half = T::of(0.5);
    let twelve = T::of(12.0);
    for i in 0..width {
        let q = lateral[i];
        let [x2b, sum, difference] = cell.node_functions(q, b[i], c[i]);
        let (p_even, p_odd) = (p0[i] + p1[i], p1[i] - p0[i]);
        let (z_even, z_odd) = (z0[i] + z1[i], z1[i] - z0[i]);
        let (w_even, w_odd) = (w0[i] + w1[i], w1[i] - w0[i]);
        let cross = root12 * q * h;
        let share = Complex::new(T::one() - twelve * b[i].re, -twelve * b[i].im);
        // e_p₊ = F_p₊/k̄² − 2i/(k̄²h) w₋
        let e_even = inverse_k2 * p_even - slope * w_odd;
        // e_p₋ = 2i√3/(k̄²h) x²b w₊ + [i√12 q h b F_z₊ + (1 − 12b) F_p₋]/k̄²
        let e_odd = slope * (x2b * w_even).scale(root3)
            + inverse_k2 * (turned(b[i] * z_even).scale(cross) + share * p_odd);
        p0[i] = (e_even - e_odd).scale(half);
        p1[i] = (e_even + e_odd).scale(half);
        let q2h2 = q * q * h2;
        // e_z₊ = [(1 − q²h²b) F_z₊ − q l₊w₊ − i√12 q h b F_p₋]/k̄²
        let e_even = inverse_k2
            * (z_even
                - (b[i] * z_even).scale(q2h2)
                - (sum * w_even).scale(q)
                - turned(b[i] * p_odd).scale(cross));
        // e_z₋ = [(1 − q²h²c) F_z₋ + q l₋w₋]/k̄²
        let e_odd = inverse_k2 * (z_odd - (c[i] * z_odd).scale(q2h2) - (difference * w_odd).scale(q));
        z0[i] = (e_even - e_odd).scale(half);
        z1[i] = (e_even + e_odd).scale(half);
    }
}

/// What unit sources F in a cell and unit values at its nodes cause, harmonic by harmonic.
pub(super) struct UnitResponses {
    /// Loads of E_s and h at the first and at the second node, by each row of a cell's source.
    pub loads: [[Vec<Complex64>; 4]; 6],
    /// Rows of moments in the cell, by each row of its source.
    pub sources: [[Vec<Complex64>; 6]; 6],
    /// Rows of moments, by E_s and h at the first and at the second node.
    pub nodes: [[Vec<Complex64>; 6]; 4],
}

impl UnitResponses {
    /// The responses of a cell in the `width` harmonics of its tables.
    pub fn new(cell: &Constants<f64>, tables: &Tables<f64>, width: usize) -> UnitResponses {
        let zeros = || vec![Complex64::ZERO; width];
        let unit = |k: usize| move |row: usize| vec![Complex64::from(f64::from(u8::from(row == k))); width];
        let loads = |k: usize| {
            let source: [_; 6] = std::array::from_fn(unit(k));
            let mut loads: [_; 4] = std::array::from_fn(|_| zeros());
            let [u0, w0, u1, w1] = &mut loads;
            add_loads(cell, tables, &source.each_ref().map(Vec::as_slice), u0, u1, w0, w1);
            loads
        };
        let moments = |source: [Vec<Complex64>; 6], nodes: [Vec<Complex64>; 4]| {
            let mut rows = source;
            let [u0, w0, u1, w1] = &nodes;
            let [s0, p0, z0, s1, p1, z1] = &mut rows;
            across(cell, tables, [u0, u1], s0, s1);
            within(cell, tables, [w0, w1], p0, z0, p1, z1);
            rows
        };
        UnitResponses {
            loads: std::array::from_fn(loads),
            sources: std::array::from_fn(|k| {
                moments(std::array::from_fn(unit(k)), std::array::from_fn(|_| zeros()))
            }),
            nodes: std::array::from_fn(|k| {
                moments(std::array::from_fn(|_| zeros()), std::array::from_fn(unit(k)))
            }),
        }
    }
}

/// Harmonics treated together by one thread.
pub(super) const BLOCK: usize = 64;

/// Factors of one tridiagonal matrix per harmonic between the nodes, TE for E_s, TM for h with each
/// cell divided by its k̄²: rows are cells or nodes, columns harmonics.
pub(super) struct NodeSystem<T: Real> {
    /// Coupling of a cell's two nodes.
    off: Array2<Complex<T>>,
    /// Reciprocal pivot of each node.
    inverse_pivot: Array2<Complex<T>>,
}

impl NodeSystem<f64> {
    /// Factorises the exact difference scheme of every harmonic; see [`inverse_pivots`].
    pub fn new(off: Array2<Complex64>, diagonal: &Array2<Complex64>, ends: [Vec<Complex64>; 2]) -> Self {
        NodeSystem { inverse_pivot: inverse_pivots(&off, diagonal, ends), off }
    }

    /// The factors of some of the harmonics.
    pub fn restricted(&self, columns: &[usize]) -> Self {
        NodeSystem {
            off: selected(&self.off, columns),
            inverse_pivot: selected(&self.inverse_pivot, columns),
        }
    }

    /// Coupling of a cell's two nodes in a harmonic.
    pub fn off(&self, cell: usize, harmonic: usize) -> Complex64 {
        self.off[[cell, harmonic]]
    }

    /// Diagonal entry of a node in a harmonic, from the pivots: d_j = 1/p_j + o² p_{j−1}.
    pub fn diagonal(&self, node: usize, harmonic: usize) -> Complex64 {
        let pivot = |j: usize| self.inverse_pivot[[j, harmonic]];
        let before = node.checked_sub(1).map(|j| self.off(j, harmonic).powi(2) * pivot(j));
        1.0 / pivot(node) + before.unwrap_or_default()
    }

    /// The factors in another precision.
    pub fn narrowed<T: Real>(&self) -> NodeSystem<T> {
        NodeSystem { off: self.off.mapv(narrow), inverse_pivot: self.inverse_pivot.mapv(narrow) }
    }
}

impl<T: Real> NodeSystem<T> {
    /// Solves in place for the harmonics from `first`; `nodes` holds `width` of them, node by node.
    pub fn solve(&self, nodes: &mut [Complex<T>], first: usize, width: usize) {
        let cells = self.off.nrows();
        let off = |cell: usize| &row_of(&self.off, cell)[first..first + width];
        let pivot = |node: usize| &row_of(&self.inverse_pivot, node)[first..first + width];
        nodes[..width].iter_mut().zip(pivot(0)).for_each(|(y, p)| *y *= *p);
        for j in 1..=cells {
            let (before, here) = nodes[(j - 1) * width..(j + 1) * width].split_at_mut(width);
            forward(here, before, off(j - 1), pivot(j));
        }
        for j in (0..cells).rev() {
            let (here, after) = nodes[j * width..(j + 2) * width].split_at_mut(width);
            backward(here, after, off(j), pivot(j));
        }
    }

    /// Memory held, bytes.
    pub fn bytes(&self) -> usize {
        (self.off.len() + self.inverse_pivot.len()) * size_of::<Complex<T>>()
    }
}

/// Some columns of a table.
pub(super) fn selected(table: &Array2<Complex64>, columns: &[usize]) -> Array2<Complex64> {
    Array2::from_shape_fn((table.nrows(), columns.len()), |(row, i)| table[[row, columns[i]]])
}

/// Forward elimination y ← (y − o b) p.
#[multiversion(targets("x86_64+avx2"))]
fn forward<T: Real>(y: &mut [Complex<T>], b: &[Complex<T>], off: &[Complex<T>], pivot: &[Complex<T>]) {
    y.iter_mut().zip(b).zip(off.iter().zip(pivot)).for_each(|((y, b), (o, p))| *y = (*y - o * b) * p);
}

/// Back substitution y ← y − o p a.
#[multiversion(targets("x86_64+avx2"))]
fn backward<T: Real>(y: &mut [Complex<T>], a: &[Complex<T>], off: &[Complex<T>], pivot: &[Complex<T>]) {
    y.iter_mut().zip(a).zip(off.iter().zip(pivot)).for_each(|((y, a), (o, p))| *y -= o * a * p);
}
