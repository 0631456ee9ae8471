//! Transfer of a field from one grid to another as an initial guess.

use super::Problem;
use crate::wave::Field;
use ndarray::Array2;
use num_complex::Complex64;

impl Problem {
    /// The solution `field` of this problem on the grid of `other`, which is the same problem at
    /// another resolution.
    ///
    /// Harmonics keep their amplitudes, and those missing on this grid are zero; between planes
    /// each cell's Lagrange functions interpolate. A guess saves about half of the applications.
    pub fn transferred(&self, field: &Field, other: &Problem) -> Field {
        let planes = self.mean.to_planes(field);
        let columns = self.columns_of(other);
        let mut values: Field = Array2::zeros(other.shape());
        for (plane, mut row) in values.outer_iter_mut().enumerate() {
            for (source, share) in self.planes_around(other.plane_height_um(plane)) {
                let here = planes.row(source);
                for (value, column) in row.iter_mut().zip(&columns) {
                    *value += column.map_or(Complex64::default(), |i| here[i] * share);
                }
            }
        }
        other.mean.to_unknowns(&mut values);
        values
    }

    /// Column in this problem of each harmonic of `other`.
    fn columns_of(&self, other: &Problem) -> Vec<Option<usize>> {
        let here: std::collections::HashMap<[i32; 2], usize> =
            self.harmonics.orders.iter().enumerate().map(|(i, &order)| (order, i)).collect();
        other.harmonics.orders.iter().map(|order| here.get(order).copied()).collect()
    }

    /// Height of a plane, µm.
    fn plane_height_um(&self, plane: usize) -> f64 {
        let grid = &self.coverage.grid;
        let degree = grid.element.degree;
        let cell = (plane / degree).min(grid.cells() - 1);
        grid.nodes_um[cell] + grid.height_um(cell) * grid.element.points[plane - degree * cell]
    }

    /// Planes on which the value at a height depends, with the values of their basis functions
    /// there.
    fn planes_around(&self, z_um: f64) -> Vec<(usize, f64)> {
        let grid = &self.coverage.grid;
        let degree = grid.element.degree;
        let cell = grid.nodes_um.partition_point(|&node| node <= z_um).clamp(1, grid.cells()) - 1;
        let t = (z_um - grid.nodes_um[cell]) / grid.height_um(cell);
        let shares = grid.element.shape_functions(t);
        (0..=degree).map(|q| (degree * cell + q, shares[q])).collect()
    }
}
