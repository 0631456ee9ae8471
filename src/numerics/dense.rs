//! Dense linear algebra of `faer`, compiled here once for the element types in use: its generic
//! functions would be compiled anew in every crate that calls them.

use faer::linalg::matmul::matmul;
use faer::linalg::solvers::{DenseSolveCore, Llt, PartialPivLu, Solve};
use faer::traits::ComplexField;
use faer::{Accum, Mat, MatMut, MatRef, Par, Side, c32, c64};

/// Element types of dense matrices.
pub trait MatrixEntry: ComplexField {
    /// LU factors of a square matrix, with partial pivoting.
    fn factors(matrix: MatRef<'_, Self>) -> PartialPivLu<Self>;

    /// The solution x of A x = b for every column b of `right`.
    fn solve(factors: &PartialPivLu<Self>, right: MatRef<'_, Self>) -> Mat<Self>;

    /// Inverse of a square matrix.
    fn inverse(matrix: MatRef<'_, Self>) -> Mat<Self>;

    /// a · b.
    fn product(a: MatRef<'_, Self>, b: MatRef<'_, Self>) -> Mat<Self>;

    /// Adds out ← out + factor · a · b, on one thread.
    fn add_product(out: MatMut<'_, Self>, factor: Self, a: MatRef<'_, Self>, b: MatRef<'_, Self>);
}

macro_rules! entries {
    ($($number:ty),*) => { $(
        impl MatrixEntry for $number {
            fn factors(matrix: MatRef<'_, Self>) -> PartialPivLu<Self> {
                matrix.partial_piv_lu()
            }

            fn solve(factors: &PartialPivLu<Self>, right: MatRef<'_, Self>) -> Mat<Self> {
                factors.solve(right)
            }

            fn inverse(matrix: MatRef<'_, Self>) -> Mat<Self> {
                matrix.partial_piv_lu().inverse()
            }

            fn product(a: MatRef<'_, Self>, b: MatRef<'_, Self>) -> Mat<Self> {
                a * b
            }

            fn add_product(out: MatMut<'_, Self>, factor: Self, a: MatRef<'_, Self>, b: MatRef<'_, Self>) {
                matmul(out, Accum::Add, a, b, factor, Par::Seq);
            }
        }
    )* };
}

entries!(f64, c32, c64);

/// Eigenvalues in rising order, and the eigenvectors in columns, of a symmetric matrix; `None` if
/// the iteration does not converge.
pub fn symmetric_eigen(matrix: &Mat<f64>) -> Option<(Vec<f64>, Mat<f64>)> {
    let eigen = matrix.self_adjoint_eigen(Side::Lower).ok()?;
    Some((eigen.S().column_vector().iter().copied().collect(), eigen.U().to_owned()))
}

/// Cholesky factors; `None` if the matrix is not positive definite.
pub fn cholesky(matrix: &Mat<f64>) -> Option<Llt<f64>> {
    matrix.llt(Side::Lower).ok()
}

/// The solution x of A x = b for every column b of `right`, from Cholesky factors.
pub fn cholesky_solve(factors: &Llt<f64>, right: MatRef<'_, f64>) -> Mat<f64> {
    factors.solve(right)
}
