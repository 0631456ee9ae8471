//! The dense reference: the assembled matrix 1 + A⁻¹V by LU, for tiny grids only.

use crate::solve::{Demand, Ledger, Size, Solution, SolveError, Solver, flat};
use crate::wave::{Field, System};
use num_complex::Complex64;

/// Dense LU; rejects problems above `max_unknowns` (memory: 16 bytes times their square; time:
/// their cube).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(deny_unknown_fields, default)
)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Direct {
    /// Largest number of complex unknowns.
    pub max_unknowns: usize,
}

impl Default for Direct {
    fn default() -> Direct {
        Direct { max_unknowns: 4000 }
    }
}

impl Solver for Direct {
    fn name(&self) -> &'static str {
        "direct"
    }

    fn most_unknowns(&self) -> Option<usize> {
        Some(self.max_unknowns)
    }

    fn run(&self, mut ledger: Ledger, _start: Option<&Field>) -> Result<Solution, SolveError> {
        let problem = ledger.problem;
        let n = problem.unknowns();
        if n > self.max_unknowns {
            let allowed = format!("at most {}", self.max_unknowns);
            let remedy = "use a coarser grid, another solver, or raise direct.max_unknowns";
            return Err(SolveError::setting("unknowns for strategy = \"direct\"", n, &allowed, remedy));
        }
        let matrix = assemble(problem, &mut ledger);
        ledger.account.bytes = 2 * n * n * size_of::<Complex64>();
        let solved = dense_solve(&matrix, flat(&ledger.background));
        let field = Field::from_shape_vec(problem.shape(), solved).expect("as many values as unknowns");
        let residual = ledger.measure(&field, &mut Field::zeros(problem.shape()));
        ledger.account.steps = 1;
        ledger.note(residual)?;
        if !ledger.reached() {
            return Err(ledger.not_converged("the matrix is nearly singular; change the grid a little"));
        }
        Ok(ledger.finish(field))
    }

    fn demand(&self, size: &Size, _bytes: f64) -> Demand {
        // Larger problems are rejected before the matrix is assembled.
        let unknowns = size.unknowns().min(self.max_unknowns as f64);
        Demand::fixed(3.0 * 16.0 * unknowns * unknowns + size.fields(6.0))
    }
}

/// Columns of 1 + A⁻¹V in turn, by application to unit vectors.
fn assemble(problem: &dyn System, ledger: &mut Ledger) -> Vec<Complex64> {
    let n = problem.unknowns();
    let mut unit = Field::zeros(problem.shape());
    let mut column = Field::zeros(problem.shape());
    let mut matrix = Vec::with_capacity(n * n);
    for j in 0..n {
        unit.as_slice_mut().expect("fields are contiguous")[j] = Complex64::ONE;
        problem.scatter(unit.view(), &mut column);
        ledger.account.operator_applications += 1;
        matrix.extend_from_slice(flat(&column));
        matrix[j * n + j] += 1.0;
        unit.as_slice_mut().expect("fields are contiguous")[j] = Complex64::default();
    }
    matrix
}

#[cfg(feature = "lapack")]
use by_lapack as dense_solve;

#[cfg(not(feature = "lapack"))]
use by_faer as dense_solve;

/// Stack size for LAPACK, bytes.
#[cfg(feature = "lapack")]
const LAPACK_STACK: usize = 64 << 20;

/// Solves a system with a column-major matrix by LAPACK.
#[cfg(feature = "lapack")]
fn by_lapack(matrix: &[Complex64], right: &[Complex64]) -> Vec<Complex64> {
    use ndarray::{ArrayView1, ArrayView2};
    use ndarray_linalg::Solve;
    let n = right.len();
    let transposed = ArrayView2::from_shape((n, n), matrix).expect("a square matrix");
    let solve = || transposed.t().to_owned().solve(&ArrayView1::from(right).to_owned());
    // OpenBLAS keeps work arrays on the stack: the 2 MB of an ordinary thread occasionally
    // overflow.
    let solved = std::thread::scope(|scope| {
        let roomy = std::thread::Builder::new().stack_size(LAPACK_STACK).spawn_scoped(scope, solve);
        roomy.expect("a thread for LAPACK").join().expect("LAPACK does not panic")
    });
    solved.map_or_else(|_| vec![Complex64::new(f64::NAN, f64::NAN); n], |x| x.to_vec())
}

/// Solves a system with a column-major matrix by faer.
#[cfg(any(test, not(feature = "lapack")))]
fn by_faer(matrix: &[Complex64], right: &[Complex64]) -> Vec<Complex64> {
    use crate::numerics::dense::MatrixEntry;
    use faer::{ColRef, MatRef};
    let n = right.len();
    let factors = Complex64::factors(MatRef::from_column_major_slice(matrix, n, n));
    Complex64::solve(&factors, ColRef::from_slice(right).as_mat()).col(0).iter().copied().collect()
}

#[cfg(all(test, feature = "lapack"))]
mod tests {
    use super::*;
    use crate::numerics::Draws;

    #[test]
    fn lapack_and_faer_agree() {
        let mut draws = Draws::new(1, 0);
        let mut number = || Complex64::new(draws.normal(), draws.normal());
        let n = 40;
        let matrix: Vec<Complex64> = (0..n * n).map(|_| number()).collect();
        let right: Vec<Complex64> = (0..n).map(|_| number()).collect();
        let pairs = by_lapack(&matrix, &right).into_iter().zip(by_faer(&matrix, &right));
        // Random matrices of this size have condition numbers of some hundreds.
        pairs.for_each(|(a, b)| assert!((a - b).norm() < 1e-11 * (1.0 + b.norm()), "{a} {b}"));
    }
}
