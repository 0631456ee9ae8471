//! Coefficients of one cell of the grid.

use crate::numerics::fourier::Real;
use crate::wave::grid::element::Element;
use num_complex::Complex;

/// Coefficients of one channel in one cell: plane of the cell → wide harmonics, and their means in
/// full precision.
pub(crate) struct CellCoefficients<T: Real> {
    pub spectra: Vec<Vec<Complex<T>>>,
    pub means: Vec<f64>,
}

/// Coefficients in all cells of all channels, where they are present.
pub(crate) type CellTable<T> = [Vec<Option<CellCoefficients<T>>>];

/// Geometry and grid of one cell for the integration over columns.
pub(crate) struct CellColumns<'a> {
    pub range_um: [f64; 2],
    pub element: &'a Element,
    pub orders: &'a [[i32; 2]],
    /// Largest |m| and |n| of the harmonics.
    pub widest: [usize; 2],
}
