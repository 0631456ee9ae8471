//! Linear least squares over an ensemble, with all leave-one-out fits.
//!
//! Samples are rows of a tensor product: a few functions of the wavelength times a few of the
//! direction. Each realisation has its own normal equations; those of the ensemble are their sum,
//! and leaving one out is a subtraction. A small penalty on the roughness over the wavelength
//! regularises the fit where there are fewer samples than functions.

use super::wavelengths::{SpectralBasis, Weights};
use faer::Mat;
use faer::linalg::solvers::Solve;
use ndarray::{Array2, s};

/// Penalty on second differences, relative to the mean diagonal of the normal equations: far below
/// the weight of the samples.
const ROUGHNESS: f64 = 1e-3;
/// Ridge on all coefficients, relative to the mean diagonal: of the order of rounding, it
/// determines what nothing else does.
const RIDGE: f64 = 1e-12;

/// Normal equations of one realisation: AᵀA, and Aᵀy for several columns y.
#[derive(Clone, Debug)]
pub struct Normal {
    matrix: Array2<f64>,
    right: Array2<f64>,
}

impl Normal {
    /// Starts without samples: `functions` unknowns, `columns` quantities.
    pub fn new(functions: usize, columns: usize) -> Self {
        Self { matrix: Array2::zeros((functions, functions)), right: Array2::zeros((functions, columns)) }
    }

    /// Adds the samples of one wavelength: its functions, and the sums over the samples of ddᵀ and
    /// d yᵀ of the directions. Unknown (i, k) has the index i · width + k.
    pub fn add(&mut self, wavelength: &Weights, products: &Sums) {
        let width = products.matrix.nrows();
        for &(i, a) in wavelength {
            for &(j, b) in wavelength {
                let mut block =
                    self.matrix.slice_mut(s![i * width..(i + 1) * width, j * width..(j + 1) * width]);
                block.scaled_add(a * b, &products.matrix);
            }
            self.right.slice_mut(s![i * width..(i + 1) * width, ..]).scaled_add(a, &products.right);
        }
    }
}

/// Σ d dᵀ and Σ d yᵀ over samples with directional functions d and values y.
#[derive(Clone, Debug)]
pub struct Sums {
    matrix: Array2<f64>,
    right: Array2<f64>,
}

impl Sums {
    /// Starts without samples.
    pub fn new(width: usize, columns: usize) -> Self {
        Self { matrix: Array2::zeros((width, width)), right: Array2::zeros((width, columns)) }
    }

    /// Adds one sample.
    pub fn add(&mut self, direction: &[f64], values: &[f64]) {
        for (k, &d) in direction.iter().enumerate() {
            direction.iter().enumerate().for_each(|(l, &e)| self.matrix[[k, l]] += d * e);
            values.iter().enumerate().for_each(|(column, &y)| self.right[[k, column]] += d * y);
        }
    }

    /// Sums of one sample without a direction.
    pub fn plain(values: &[f64]) -> Self {
        let mut sums = Self::new(1, values.len());
        sums.add(&[1.0], values);
        sums
    }
}

/// Coefficients \[function, column\] of the ensemble and of all leave-one-out ensembles.
#[derive(Clone, Debug)]
pub struct Fits {
    /// Fit to all realisations.
    pub whole: Array2<f64>,
    /// Fits to all realisations but one; empty for a single realisation.
    pub without: Vec<Array2<f64>>,
}

impl Fits {
    /// Zero coefficients for `columns` quantities.
    pub fn nothing(basis: &SpectralBasis, width: usize, columns: usize) -> Self {
        Self { whole: Array2::zeros((basis.len() * width, columns)), without: Vec::new() }
    }

    /// Solves for the whole ensemble and all leave-one-out ensembles. `width` is the number of
    /// functions of the direction.
    pub fn new(parts: &[Normal], basis: &SpectralBasis, width: usize) -> Self {
        let Some(first) = parts.first() else { return Self::nothing(basis, width, 0) };
        let mut sum = Normal::new(first.matrix.nrows(), first.right.ncols());
        for part in parts {
            sum.matrix += &part.matrix;
            sum.right += &part.right;
        }
        let all_but = |part: &Normal| {
            let rest = Normal { matrix: &sum.matrix - &part.matrix, right: &sum.right - &part.right };
            solve(&rest, basis, width)
        };
        let without = if parts.len() > 1 { parts.iter().map(all_but).collect() } else { Vec::new() };
        Self { whole: solve(&sum, basis, width), without }
    }
}

fn solve(normal: &Normal, basis: &SpectralBasis, width: usize) -> Array2<f64> {
    let (n, columns) = normal.right.dim();
    let mut matrix = normal.matrix.clone();
    let scale = matrix.diag().sum() / n.max(1) as f64;
    for row in basis.roughness() {
        for (k, (i, a)) in (0..width).flat_map(|k| row.iter().map(move |&(i, a)| (k, (i, a)))) {
            for &(j, b) in &row {
                matrix[[i * width + k, j * width + k]] += ROUGHNESS * scale * a * b;
            }
        }
    }
    matrix.diag_mut().mapv_inplace(|x| x + RIDGE * scale.max(f64::MIN_POSITIVE));
    let a = Mat::from_fn(n, n, |i, j| matrix[[i, j]]);
    let b = Mat::from_fn(n, columns, |i, j| normal.right[[i, j]]);
    // rounding may make a matrix of few samples indefinite; elimination with pivots still works
    let x = match a.llt(faer::Side::Lower) {
        Ok(factors) => factors.solve(&b),
        Err(_) => a.partial_piv_lu().solve(&b),
    };
    Array2::from_shape_fn((n, columns), |(i, j)| x[(i, j)])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A function in the span of the basis is recovered, and leaving one out changes nothing.
    #[test]
    fn what_the_basis_holds_is_recovered() {
        let basis = SpectralBasis::Splines { range_nm: [400.0, 700.0], intervals: 3 };
        let truth = |nm: f64, mu: f64| (nm / 500.0 - 1.0) + mu * (2.0 - nm / 350.0);
        let mut parts = Vec::new();
        for r in 0..4 {
            let mut normal = Normal::new(basis.len() * 2, 1);
            for j in 0..12 {
                let nm = 405.0 + 25.0 * j as f64 + 5.0 * r as f64;
                let mut sums = Sums::new(2, 1);
                for mu in [0.1 + 0.05 * r as f64, 0.9] {
                    sums.add(&[1.0, mu], &[truth(nm, mu)]);
                }
                normal.add(&basis.weights(nm), &sums);
            }
            parts.push(normal);
        }
        let fits = Fits::new(&parts, &basis, 2);
        for fit in fits.without.iter().chain([&fits.whole]) {
            let weights = basis.weights(533.0);
            let value = |k: usize| SpectralBasis::at(&weights, |i| fit[[2 * i + k, 0]]);
            // The penalty does not affect straight lines; the ridge of 1e-12 and rounding remain.
            assert!((value(0) + 0.5 * value(1) - truth(533.0, 0.5)).abs() < 1e-8);
        }
    }

    /// With listed wavelengths the fit is the mean at each, and its jackknife is that of a mean.
    #[test]
    fn listed_wavelengths_give_means() {
        let basis = SpectralBasis::Listed(vec![450.0, 550.0]);
        let values = [[1.0, 10.0], [2.0, 20.0], [6.0, 60.0]];
        let part = |v: &[f64; 2]| {
            let mut normal = Normal::new(2, 1);
            (0..2).for_each(|w| normal.add(&basis.weights([450.0, 550.0][w]), &Sums::plain(&[v[w]])));
            normal
        };
        let fits = Fits::new(&values.iter().map(part).collect::<Vec<_>>(), &basis, 1);
        assert!((fits.whole[[0, 0]] - 3.0).abs() < 1e-10 && (fits.whole[[1, 0]] - 30.0).abs() < 1e-9);
        assert!((fits.without[2][[0, 0]] - 1.5).abs() < 1e-10);
    }
}
