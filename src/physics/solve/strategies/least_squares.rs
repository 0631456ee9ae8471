//! The small least-squares problem of GMRES.

use num_complex::Complex64;

/// Solves min ‖β e₁ − H y‖ by Givens rotations, one column at a time.
pub(crate) struct LeastSquares {
    columns: Vec<Vec<Complex64>>,
    rotations: Vec<(f64, Complex64)>,
    right: Vec<Complex64>,
}

impl LeastSquares {
    pub fn new(beta: f64) -> LeastSquares {
        LeastSquares { columns: Vec::new(), rotations: Vec::new(), right: vec![beta.into()] }
    }

    /// Adds a Hessenberg column (its last entry the new norm) and returns the residual's norm.
    pub fn add_column(&mut self, mut column: Vec<Complex64>) -> f64 {
        for (i, &(c, s)) in self.rotations.iter().enumerate() {
            // [h_i; h_{i+1}] ← [[c, s], [−s̄, c]] [h_i; h_{i+1}]
            let (a, b) = (column[i], column[i + 1]);
            column[i] = c * a + s * b;
            column[i + 1] = -s.conj() * a + c * b;
        }
        let k = self.rotations.len();
        let below = column.pop().expect("a column ends with its norm");
        let diagonal = column[k];
        let length = diagonal.norm().hypot(below.norm());
        let (c, s) = match diagonal.norm() {
            0.0 => (0.0, Complex64::ONE),
            d => (d / length, diagonal / d * below.conj() / length),
        };
        column[k] = c * diagonal + s * below; // the rotation that eliminates h_{k+1,k}
        self.rotations.push((c, s));
        let last = self.right[k];
        self.right[k] = c * last;
        self.right.push(-s.conj() * last);
        self.columns.push(column);
        self.right[k + 1].norm() // the minimum of ‖β e₁ − H y‖
    }

    pub fn solve(&self) -> Vec<Complex64> {
        let n = self.columns.len();
        let mut y = self.right[..n].to_vec();
        for i in (0..n).rev() {
            y[i] /= self.columns[i][i]; // R y = Qᴴ β e₁ by back substitution
            let yi = y[i];
            (0..i).for_each(|r| y[r] -= self.columns[i][r] * yi);
        }
        y
    }
}
