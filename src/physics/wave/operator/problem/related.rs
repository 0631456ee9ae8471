//! Problems related to one: of other indices, for derivatives of the operator M = A + V, of the
//! opposite direction, for its transpose, and on other grids, for initial guesses.
//!
//! M(η) u = b with b independent of the grains. The operator itself is differenced, not the
//! solution: so the change of ⟨k²⟩, of the shape functions and of the folded harmonics is included.
//! With J the exchange of every harmonic and its opposite, M(q)ᵀ = J M(−q) J: the transposed
//! problem is the ordinary one of the opposite lateral direction.

use crate::wave::{Field, Incidence, Media, Problem, WaveError};
use ndarray::Array2;
use num_complex::Complex64;
use std::collections::HashMap;

/// Step of the differences in an index: the error of four points is its fourth power, and rounding
/// grows with its reciprocal.
const STEP: f64 = 1e-3;

impl Problem {
    /// Product M u = (A + V) u, in the rows of nodes and bubbles.
    pub fn applied(&self, u: &Field) -> Field {
        let mut loads = Field::zeros(self.shape());
        self.double().contrast_loads(u.view(), &mut loads);
        self.mean.inverse.load(&mut loads);
        self.mean.add_product(u, Some([&self.kappa[0], &self.kappa[1]]), &mut loads);
        loads
    }

    /// Product (∂M/∂η) u for the index η = n + iκ of one medium, on four points around η.
    ///
    /// # Errors
    /// A neighbouring index is refused, as by [`Problem::new`].
    pub fn derivative(&self, u: &Field, medium: Medium) -> Result<Field, WaveError> {
        let mut sum = Field::zeros(self.shape());
        for direction in DIRECTIONS {
            sum.scaled_add(0.25 / (STEP * direction), &self.moved(medium, STEP * direction)?.applied(u));
        }
        Ok(sum)
    }

    /// This problem with the index of one medium changed by `step`.
    ///
    /// # Errors
    /// The index is refused, as by [`Problem::new`].
    pub fn moved(&self, medium: Medium, step: Complex64) -> Result<Problem, WaveError> {
        Problem::new(&self.coverage, &self.media.moved(medium, step), &self.incidence, self.choice)
    }

    /// The problem of the opposite lateral direction.
    ///
    /// # Errors
    /// As [`Problem::new`].
    pub fn reversed(&self) -> Result<Problem, WaveError> {
        let incidence = Incidence { azimuth_deg: self.incidence.azimuth_deg + 180.0, ..self.incidence };
        Problem::new(&self.coverage, &self.media, &incidence, self.choice)
    }

    /// J u: every harmonic takes the column of its opposite.
    pub fn opposite(&self, u: &Field) -> Field {
        let orders = self.harmonics.orders.iter();
        let columns: Option<Vec<usize>> = orders.map(|&[m, n]| self.harmonics.find(-m, -n)).collect();
        let moved = u.select(ndarray::Axis(1), &columns.expect("harmonics are symmetric about zero"));
        // a selection of columns is laid out by columns, the tables' loops need rows
        moved.as_standard_layout().into_owned()
    }

    /// The solution `field` of this problem on the grid of `other`, which is the same problem at
    /// another resolution.
    ///
    /// Harmonics keep their amplitudes, and those missing on this grid are zero; between planes
    /// each cell's Lagrange functions interpolate. A guess saves about half of the applications.
    pub fn transferred(&self, field: &Field, other: &Problem) -> Field {
        let planes = self.mean.to_planes(field);
        let places: HashMap<[i32; 2], usize> =
            self.harmonics.orders.iter().enumerate().map(|(i, &order)| (order, i)).collect();
        // Column in this problem of each harmonic of the other.
        let columns: Vec<_> = other.harmonics.orders.iter().map(|order| places.get(order)).collect();
        let mut values: Field = Array2::zeros(other.shape());
        for (plane, mut row) in values.outer_iter_mut().enumerate() {
            for (source, share) in self.planes_around(other.plane_height_um(plane)) {
                let here = planes.row(source);
                for (value, column) in row.iter_mut().zip(&columns) {
                    *value += column.map_or(Complex64::default(), |&i| here[i] * share);
                }
            }
        }
        other.mean.to_unknowns(&mut values);
        values
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
        let shares = grid.element.shape_functions((z_um - grid.nodes_um[cell]) / grid.height_um(cell));
        (0..=degree).map(|q| (degree * cell + q, shares[q])).collect()
    }
}

/// Directions of four points around an index: the mean of f(η + s)/s over them is f′ up to s⁴.
pub const DIRECTIONS: [Complex64; 4] =
    [Complex64::ONE, Complex64::I, Complex64::new(-1.0, 0.0), Complex64::new(0.0, -1.0)];

/// A medium of the layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Medium {
    /// Number of a background, such as the binder.
    Background(usize),
    /// Number of an inclusion, such as a pigment.
    Inclusion(usize),
}

impl Media {
    /// These media with one index changed by `step`.
    pub fn moved(&self, medium: Medium, step: Complex64) -> Media {
        let mut moved = self.clone();
        match medium {
            Medium::Background(i) => moved.backgrounds[i] += step,
            Medium::Inclusion(i) => moved.inclusions[i] += step,
        }
        moved
    }
}
