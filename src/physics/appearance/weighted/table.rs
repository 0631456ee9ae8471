//! Weights against wavelength.

use thiserror::Error;

/// Widest distance of rows that are summed as they are, nm: tables of densitometers are meant for
/// sums over their rows, 10 nm apart.
const ROWS_APART_NM: f64 = 10.0 + 1e-9;
/// Rows between which a spectrum is known at this many wavelengths are summed as closely.
const KNOWN_BETWEEN: usize = 3;
/// Step of the sum between rows that are farther apart, nm.
const STEP_NM: f64 = 5.0;

/// Weights per nm against wavelength, linear between their rows and nothing beyond them.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct WeightTable {
    /// Wavelength in nm, rising, and weight, at least 0.
    rows: Vec<[f64; 2]>,
}

/// Why rows are no table of weights.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum WeightError {
    /// Too few of them.
    #[error("{0} rows; two or more are needed")]
    TooFew(usize),
    /// Wavelengths that do not rise.
    #[error("row {row}: {after} nm after {before} nm; wavelengths must rise")]
    NotRising {
        /// Row, from 1.
        row: usize,
        /// Wavelength of the row before, nm.
        before: f64,
        /// Its own, nm.
        after: f64,
    },
    /// A weight that is negative or no number.
    #[error("row {row}: a weight of {weight} at {nm} nm; weights are 0 or more")]
    Negative {
        /// Row, from 1.
        row: usize,
        /// Wavelength, nm.
        nm: f64,
        /// The weight.
        weight: f64,
    },
    /// Nothing but zeros.
    #[error("all weights are 0")]
    AllZero,
}

impl WeightTable {
    /// A table of rows of wavelength in nm and weight.
    ///
    /// # Errors
    /// Fewer than two rows, wavelengths that do not rise, negative weights, or none above 0.
    pub fn new(rows: Vec<[f64; 2]>) -> Result<Self, WeightError> {
        if rows.len() < 2 {
            return Err(WeightError::TooFew(rows.len()));
        }
        for (row, pair) in (2..).zip(rows.windows(2)) {
            let before = pair[0][0];
            let after = pair[1][0];
            if after.partial_cmp(&before) != Some(std::cmp::Ordering::Greater) {
                return Err(WeightError::NotRising { row, before, after });
            }
        }
        for (row, &[nm, weight]) in (1..).zip(&rows) {
            if !(weight >= 0.0 && weight.is_finite()) {
                return Err(WeightError::Negative { row, nm, weight });
            }
        }
        let table = Self { rows };
        if table.total() > 0.0 { Ok(table) } else { Err(WeightError::AllZero) }
    }

    /// First and last wavelength, nm.
    pub fn range_nm(&self) -> [f64; 2] {
        [self.rows[0][0], self.rows[self.rows.len() - 1][0]]
    }

    /// The weight at a wavelength in nm.
    pub fn at(&self, nm: f64) -> f64 {
        let [first, last] = self.range_nm();
        if !(first..=last).contains(&nm) {
            return 0.0;
        }
        let after = self.rows.partition_point(|row| row[0] < nm).clamp(1, self.rows.len() - 1);
        let [[from, below], [to, above]] = [self.rows[after - 1], self.rows[after]];
        below + (above - below) * (nm - from) / (to - from)
    }

    /// The part of the table within a range of wavelengths, nm; `None` if there is no weight.
    pub fn within(&self, [from, to]: [f64; 2]) -> Option<Self> {
        let [first, last] = self.range_nm();
        let from = from.max(first);
        let to = to.min(last);
        if from >= to {
            return None;
        }
        let inner = self.rows.iter().copied().filter(|row| from < row[0] && row[0] < to);
        let rows = std::iter::once([from, self.at(from)]).chain(inner).chain([[to, self.at(to)]]);
        let part = Self { rows: rows.collect() };
        (part.total() > 0.0).then_some(part)
    }

    /// Wavelengths of neighbouring rows between which there is weight, nm.
    pub fn weighted_intervals(&self) -> impl Iterator<Item = [f64; 2]> + '_ {
        let pairs = self.rows.windows(2).filter(|pair| pair[0][1] > 0.0 || pair[1][1] > 0.0);
        pairs.map(|pair| [pair[0][0], pair[1][0]])
    }

    /// ∫ w dλ.
    pub fn total(&self) -> f64 {
        self.places(&[]).into_iter().map(|(_, weight)| weight).sum()
    }

    /// Wavelengths, nm, with the weights of the trapezoidal rule: the rows, and closer places where
    /// these are far apart or a spectrum is known much closer, as where it has fringes.
    pub(super) fn places(&self, known_nm: &[f64]) -> Vec<(f64, f64)> {
        let mut nm = vec![self.rows[0][0]];
        for pair in self.rows.windows(2) {
            let from = pair[0][0];
            let to = pair[1][0];
            let parts = if to - from > ROWS_APART_NM { ((to - from) / STEP_NM).ceil() } else { 1.0 };
            let known = known_nm.partition_point(|x| *x < to) - known_nm.partition_point(|x| *x <= from);
            let parts = if known >= KNOWN_BETWEEN { parts.max(1.0 + known as f64) } else { parts };
            nm.extend((1..parts as usize).map(|k| from + (to - from) * k as f64 / parts));
            nm.push(to);
        }
        let width = |k: usize| {
            let before = nm[k.saturating_sub(1)];
            let after = nm[(k + 1).min(nm.len() - 1)];
            0.5 * (after - before)
        };
        nm.iter().enumerate().map(|(k, &at)| (at, self.at(at) * width(k))).collect()
    }
}
