//! The axes of a matrix, as written.

use crate::compare::row::Varied;
use crate::input::fault::Faults;
use crate::input::limits;
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
    /// Reports empty axes, and entries that no study could have.
    pub fn check(&self, faults: &mut Faults) {
        let empty = [("pigments", self.pigments.is_empty()), ("periods_um", self.periods_um.is_empty())];
        for (axis, _) in empty.into_iter().filter(|(_, empty)| *empty) {
            let remedy = "give pigments = [[1.4, 0.1]], periods_um = [1.6]";
            faults.add(format!("matrix.{axis}"), "empty", "at least one entry", remedy);
        }
        let remedy = "pigments are pairs [n, κ], periods some µm";
        for (k, [n, kappa]) in self.pigments.iter().enumerate() {
            faults.number(&format!("matrix.pigments[{k}][0]"), *n, limits::INDEX, remedy);
            faults.number(&format!("matrix.pigments[{k}][1]"), *kappa, limits::ABSORPTION, remedy);
        }
        for (k, um) in self.periods_um.iter().enumerate() {
            faults.number(&format!("matrix.periods_um[{k}]"), *um, limits::PERIOD_UM, remedy);
        }
    }

    /// All cases, period by period.
    pub(super) fn cases(&self) -> impl Iterator<Item = Varied> {
        self.periods_um
            .iter()
            .flat_map(|&period_um| self.pigments.iter().map(move |&pigment| Varied { pigment, period_um }))
    }
}
