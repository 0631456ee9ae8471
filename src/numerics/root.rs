//! The root of two functions of two unknowns by Broyden's method: derivatives once, by differences,
//! then a correction from every step (C. G. Broyden, Math. Comp. 19 (1965) 577).

/// How the root of two functions is looked for.
#[derive(Clone, Copy, Debug)]
pub struct RootSearch {
    /// Step of the first differences.
    pub difference: f64,
    /// Bounds of each unknown, from and to.
    pub bounds: [[f64; 2]; 2],
    /// Steps of each unknown below which it ends.
    pub enough: [f64; 2],
    /// Most steps.
    pub rounds: usize,
}

impl RootSearch {
    /// The last unknowns, and the step that led there; `None` where the functions have no value.
    pub fn root(
        &self,
        start: [f64; 2],
        value: impl Fn([f64; 2]) -> Option<[f64; 2]>,
    ) -> Option<([f64; 2], [f64; 2])> {
        let mut at = start;
        let mut here = value(at)?;
        let by = |there: [f64; 2]| less(there, here).map(|change| change / self.difference);
        let by_first = by(value([at[0] + self.difference, at[1]])?);
        let by_second = by(value([at[0], at[1] + self.difference])?);
        let determinant = by_first[0] * by_second[1] - by_first[1] * by_second[0];
        // the inverse of the derivatives, in rows
        let mut inverse = [[by_second[1], -by_second[0]], [-by_first[1], by_first[0]]]
            .map(|row| row.map(|entry| entry / determinant));
        let mut step = [f64::INFINITY; 2];
        for round in 1..=self.rounds {
            step = inverse.map(|row| -dot(row, here));
            let next = [0, 1].map(|i| (at[i] + step[i]).clamp(self.bounds[i][0], self.bounds[i][1]));
            let moved = less(next, at);
            at = next;
            if round == self.rounds || (0..2).all(|i| step[i].abs() < self.enough[i]) {
                break;
            }
            let there = value(at)?;
            let expected = inverse.map(|row| dot(row, less(there, here)));
            let across = [0, 1].map(|j| moved[0] * inverse[0][j] + moved[1] * inverse[1][j]);
            let scale = dot(moved, expected);
            for (row, (moved, expected)) in inverse.iter_mut().zip(moved.into_iter().zip(expected)) {
                (0..2).for_each(|j| row[j] += (moved - expected) * across[j] / scale);
            }
            here = there;
        }
        Some((at, step))
    }
}

fn less(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

#[cfg(test)]
mod tests {
    use super::*;

    const SEARCH: RootSearch = RootSearch {
        difference: 1e-4,
        bounds: [[f64::NEG_INFINITY, f64::INFINITY], [-2.0, 2.0]],
        enough: [1e-10; 2],
        rounds: 30,
    };

    /// A circle and a hyperbola cross at known places; functions without a value have no root.
    #[test]
    fn a_circle_and_a_hyperbola_cross() {
        let value = |[x, y]: [f64; 2]| Some([x * x + y * y - 4.0, x * y - 1.0]);
        let (at, step) = SEARCH.root([2.0, 0.4], value).unwrap();
        let [x, y] = [(2.0 + 3.0_f64.sqrt()).sqrt(), (2.0 - 3.0_f64.sqrt()).sqrt()];
        assert!((at[0] - x).abs() < 1e-10 && (at[1] - y).abs() < 1e-10, "{at:?}");
        assert!(step.iter().all(|step| step.abs() < 1e-10), "{step:?}");
        assert!(SEARCH.root([2.0, 0.4], |_| None).is_none());
    }

    /// Where nothing is a root, the last step is not small.
    #[test]
    fn functions_without_a_root_do_not_settle() {
        let value = |[x, y]: [f64; 2]| Some([x * x + 1.0, y]);
        let (_, step) = SEARCH.root([0.5, 0.1], value).unwrap();
        assert!(!step.iter().all(|step| step.abs() < 1e-6), "{step:?}");
    }
}
