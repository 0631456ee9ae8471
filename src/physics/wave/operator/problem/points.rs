//! Conversion of fields between harmonics and the points of the planes.

use super::Problem;
use crate::numerics::fourier::PlaneScratch;
use crate::wave::Field;
use ndarray::Array2;
use num_complex::Complex64;
use rayon::prelude::*;

impl Problem {
    /// Row of the illuminated face, and b at its points.
    pub fn source_at_points(&self) -> (usize, Vec<Complex64>) {
        let (row, mut scratch) = (self.entry_row(), self.fft.scratch());
        self.to_points(self.source().row(row).to_slice().expect("rows are contiguous"), &mut scratch);
        (row, scratch.plane)
    }

    /// Converts harmonics of every plane to values at its points, unnormalised.
    pub fn planes_to_points(&self, harmonics: &Field, points: &mut Array2<Complex64>) {
        let rows = points.outer_iter_mut().into_par_iter().zip(harmonics.outer_iter());
        rows.for_each_init(
            || self.fft.scratch(),
            |scratch, (mut out, row)| {
                self.to_points(row.to_slice().expect("rows are contiguous"), scratch);
                out.as_slice_mut().expect("rows are contiguous").copy_from_slice(&scratch.plane);
            },
        );
    }

    /// Converts values at points to harmonics of every plane (inverse of
    /// [`Problem::planes_to_points`] on the harmonics in use).
    pub fn points_to_planes(&self, points: &Array2<Complex64>, harmonics: &mut Field) {
        let scale = 1.0 / self.coverage.grid.points() as f64;
        let rows = harmonics.outer_iter_mut().into_par_iter().zip(points.outer_iter());
        rows.for_each_init(
            || self.fft.scratch(),
            |scratch, (mut out, row)| {
                scratch.plane.iter_mut().zip(row).for_each(|(p, v)| *p = v * scale);
                self.fft.forward(scratch, &self.harmonics.rows);
                self.harmonics.gather(&scratch.spectrum, out.as_slice_mut().expect("rows are contiguous"));
            },
        );
    }

    fn to_points(&self, harmonics: &[Complex64], scratch: &mut PlaneScratch) {
        self.harmonics.scatter(harmonics, &mut scratch.spectrum);
        self.fft.inverse(scratch, &self.harmonics.rows);
    }
}
