//! Linear least squares over an ensemble, with all leave-one-out fits.
//!
//! Samples are rows of a tensor product: a few functions of the wavelength times a few of the
//! direction. Each realisation has its own normal equations; those of the ensemble are their sum,
//! and leaving one out is a subtraction. A small penalty on the roughness over the wavelength
//! regularises the fit where there are fewer samples than functions.

use super::wavelengths::{SpectralBasis, Weights};
use crate::numerics::dense::{MatrixEntry, cholesky, cholesky_solve};
use faer::Mat;
use ndarray::{Array2, s};

/// Penalty on second differences, relative to the mean diagonal of the normal equations: far below
/// the weight of the samples.
const ROUGHNESS: f64 = 1e-3;
/// Ridge on all coefficients, relative to the mean diagonal: of the order of rounding, it
/// determines what nothing else does.
const RIDGE: f64 = 1e-12;

/// Normal equations: AᵀA, and Aᵀy for several columns y.
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

    /// One sample of the values y without functions of the direction.
    pub fn plain(values: &[f64]) -> Self {
        let mut normal = Self::new(1, values.len());
        normal.sample(&[1.0], values);
        normal
    }

    /// Adds one sample: its functions d and the values y.
    pub fn sample(&mut self, functions: &[f64], values: &[f64]) {
        for (k, &d) in functions.iter().enumerate() {
            functions.iter().enumerate().for_each(|(l, &e)| self.matrix[[k, l]] += d * e);
            values.iter().enumerate().for_each(|(column, &y)| self.right[[k, column]] += d * y);
        }
    }

    /// Adds the samples of one wavelength: its functions, and the normal equations for the
    /// functions of the direction alone. Unknown (i, k) has the index i · width + k.
    fn add(&mut self, wavelength: &Weights, products: &Normal) {
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

/// Coefficients \[function, column\] of the ensemble and of all leave-one-out ensembles.
#[derive(Clone, Debug)]
pub struct Fits {
    /// Fit to all realisations.
    pub whole: Array2<f64>,
    /// Fits to all realisations but one; empty for a single realisation.
    pub without: Vec<Array2<f64>>,
    /// What each realisation adds to the whole fit, to first order: A⁻¹ of its residuals; empty
    /// unless made by [`Fits::with_influence`].
    pub influence: Vec<Array2<f64>>,
}

impl Fits {
    /// The fit to all realisations (`None`) or to all but one.
    pub fn coefficients(&self, without: Option<usize>) -> &Array2<f64> {
        without.map_or(&self.whole, |r| &self.without[r])
    }

    /// Solves for the whole ensemble and all leave-one-out ensembles; zero coefficients without
    /// any realisation. `ensemble` gives the samples of each wavelength, nm, of each realisation;
    /// `width` is the number of functions of the direction.
    pub fn new(
        ensemble: impl IntoIterator<Item: Iterator<Item = (f64, Normal)>>,
        basis: &SpectralBasis,
        width: usize,
        columns: usize,
    ) -> Self {
        let parts = normal_equations(ensemble, basis, width, columns);
        Self::of_parts(&parts, basis, width, columns)
    }

    /// The fit to all realisations alone; see [`Fits::new`].
    pub fn whole(
        ensemble: impl IntoIterator<Item: Iterator<Item = (f64, Normal)>>,
        basis: &SpectralBasis,
        width: usize,
        columns: usize,
    ) -> Array2<f64> {
        let mut sum = Normal::new(basis.count() * width, columns);
        for part in normal_equations(ensemble, basis, width, columns) {
            sum.matrix += &part.matrix;
            sum.right += &part.right;
        }
        solve(&sum, basis, width)
    }

    /// Like [`Fits::new`], and keeps what each realisation adds.
    pub fn with_influence(
        ensemble: impl IntoIterator<Item: Iterator<Item = (f64, Normal)>>,
        basis: &SpectralBasis,
        width: usize,
        columns: usize,
    ) -> Self {
        let parts = normal_equations(ensemble, basis, width, columns);
        let mut fits = Self::of_parts(&parts, basis, width, columns);
        let mut all = Normal::new(basis.count() * width, columns * parts.len());
        for (r, part) in parts.iter().enumerate() {
            all.matrix += &part.matrix;
            let residuals = &part.right - &part.matrix.dot(&fits.whole);
            all.right.slice_mut(s![.., r * columns..(r + 1) * columns]).assign(&residuals);
        }
        if !parts.is_empty() {
            let solved = solve(&all, basis, width);
            let of_part = |r: usize| solved.slice(s![.., r * columns..(r + 1) * columns]).to_owned();
            fits.influence = (0..parts.len()).map(of_part).collect();
        }
        fits
    }

    fn of_parts(parts: &[Normal], basis: &SpectralBasis, width: usize, columns: usize) -> Self {
        let mut sum = Normal::new(basis.count() * width, columns);
        for part in parts {
            sum.matrix += &part.matrix;
            sum.right += &part.right;
        }
        let all_but = |part: &Normal| {
            let rest = Normal { matrix: &sum.matrix - &part.matrix, right: &sum.right - &part.right };
            solve(&rest, basis, width)
        };
        let without = if parts.len() > 1 { parts.iter().map(all_but).collect() } else { Vec::new() };
        let whole = if parts.is_empty() { sum.right } else { solve(&sum, basis, width) };
        Self { whole, without, influence: Vec::new() }
    }
}

/// The normal equations of every realisation.
fn normal_equations(
    ensemble: impl IntoIterator<Item: Iterator<Item = (f64, Normal)>>,
    basis: &SpectralBasis,
    width: usize,
    columns: usize,
) -> Vec<Normal> {
    let of_realisation = |samples: &mut dyn Iterator<Item = (f64, Normal)>| {
        let mut part = Normal::new(basis.count() * width, columns);
        samples.for_each(|(nm, samples)| part.add(&basis.weights(nm), &samples));
        part
    };
    ensemble.into_iter().map(|mut samples| of_realisation(&mut samples)).collect()
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
    let x = match cholesky(&a) {
        Some(factors) => cholesky_solve(&factors, b.as_ref()),
        None => f64::solve(&f64::factors(a.as_ref()), b.as_ref()),
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
        let samples = |r: usize, j: usize| {
            let nm = 405.0 + 25.0 * j as f64 + 5.0 * r as f64;
            let mut samples = Normal::new(2, 1);
            for mu in [0.1 + 0.05 * r as f64, 0.9] {
                samples.sample(&[1.0, mu], &[truth(nm, mu)]);
            }
            (nm, samples)
        };
        let fits = Fits::new((0..4).map(|r| (0..12).map(move |j| samples(r, j))), &basis, 2, 1);
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
        let part = |v: [f64; 2]| [450.0, 550.0].into_iter().zip(v.map(|v| Normal::plain(&[v])));
        let fits = Fits::new(values.map(part), &basis, 1, 1);
        assert!((fits.whole[[0, 0]] - 3.0).abs() < 1e-10 && (fits.whole[[1, 0]] - 30.0).abs() < 1e-9);
        assert!((fits.without[2][[0, 0]] - 1.5).abs() < 1e-10);
    }
}
