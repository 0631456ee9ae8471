//! The axes of a matrix, as written.

use crate::compare::error::CompareError;
use crate::compare::row::Varied;
use crate::input::limits;
use crate::numerics::allowed::Allowed;
use schemars::JsonSchema;
use serde::Deserialize;

/// The axes around the comparison's study: one case for each pigment and period.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MatrixTable {
    /// Indices [n, κ] of the first pigment.
    #[schemars(length(min = 1), example = [[1.4, 0.1]])]
    pub pigments: Vec<[f64; 2]>,
    /// Periods of the square cell, µm.
    #[schemars(length(min = 1), example = [1.6])]
    pub periods_um: Vec<f64>,
}

impl MatrixTable {
    /// Refuses empty axes, and entries that no study could have.
    ///
    /// # Errors
    /// The field, what was found and what is allowed.
    pub fn check(&self) -> Result<(), CompareError> {
        let axes = [("pigments", self.pigments.is_empty()), ("periods_um", self.periods_um.is_empty())];
        if let Some((axis, _)) = axes.into_iter().find(|(_, empty)| *empty) {
            let remedy = "give pigments = [[1.4, 0.1]], periods_um = [1.6]";
            return Err(CompareError::field(format!("matrix.{axis}"), "empty", "at least one entry", remedy));
        }
        let wrong = self.numbers().into_iter().find(|(_, value, allowed)| !allowed.holds(*value));
        let Some((field, value, allowed)) = wrong else { return Ok(()) };
        let remedy = "pigments are pairs [n, κ], periods some µm";
        Err(CompareError::field(field, value, allowed, remedy))
    }

    /// Every number with its place and what is allowed there.
    fn numbers(&self) -> Vec<(String, f64, Allowed)> {
        let mut all = Vec::new();
        for (k, [n, kappa]) in self.pigments.iter().enumerate() {
            all.push((format!("matrix.pigments[{k}][0]"), *n, limits::INDEX));
            all.push((format!("matrix.pigments[{k}][1]"), *kappa, limits::ABSORPTION));
        }
        let period = |(k, um): (usize, &f64)| (format!("matrix.periods_um[{k}]"), *um, limits::PERIOD_UM);
        all.extend(self.periods_um.iter().enumerate().map(period));
        all
    }

    /// All cases, period by period.
    pub(super) fn cases(&self) -> impl Iterator<Item = Varied> {
        self.periods_um
            .iter()
            .flat_map(|&period_um| self.pigments.iter().map(move |&pigment| Varied { pigment, period_um }))
    }
}
