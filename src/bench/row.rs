//! One row of a comparison: result and cost of one solve of one case, or why it failed.

use crate::solve::Account;
use crate::wave::{Resolution, Scheme};
use std::fmt;

/// Parameters in which the cases of a matrix differ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Varied {
    /// Index [n, κ] of the first pigment.
    pub pigment: [f64; 2],
    /// Period of the square cell, µm.
    pub period_um: f64,
}

impl fmt::Display for Varied {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{}\u{a0}+\u{a0}{}i, {}\u{a0}µm", self.pigment[0], self.pigment[1], self.period_um)
    }
}

/// The discrete problem that a strategy was given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Discrete {
    /// Its grid and scheme.
    pub resolution: Resolution,
    /// Whether ⟨k²⟩ includes the absorption, or leaves it to the contrast.
    pub absorbing_mean: bool,
}

/// One solve of one case. What is specific to inkwave's discretisation is left out for programs
/// with another.
#[derive(Clone, Debug)]
pub struct Row {
    /// Case of a matrix; `None` if there is only one.
    pub case: Option<Varied>,
    /// Name of the case where several case files are compared.
    pub named: Option<String>,
    /// Name of the strategy.
    pub strategy: String,
    /// Value of the knob of a program that has one.
    pub knob: Option<f64>,
    /// The discrete problem; `None` if no grid was found.
    pub discrete: Option<Discrete>,
    /// Complex unknowns, where the problem could be set up.
    pub unknowns: Option<usize>,
    /// Largest amplitude error against the reference, or why there is no result.
    pub result: Result<f64, String>,
    /// Largest expected amplitude error, as `inkwave solve` estimates it; unknown where no coarser
    /// grid could be solved.
    pub error_estimate: Option<f64>,
    /// Steps, operator applications and residuals of the first solve, finished or not.
    pub account: Option<Account>,
    /// Median wall time of a solve, s.
    pub seconds: Option<f64>,
    /// Median processor time of a solve over all threads, s.
    pub processor_seconds: Option<f64>,
    /// What a program measured of its own solve, s.
    pub own_seconds: Option<f64>,
    /// Memory of problem and strategy.
    pub bytes: usize,
}

impl Row {
    /// A row that has no result yet.
    pub(super) fn new(case: Option<Varied>, strategy: &str, discrete: Option<Discrete>) -> Row {
        Row {
            case,
            named: None,
            strategy: strategy.to_owned(),
            knob: None,
            discrete,
            unknowns: None,
            result: Err("not solved".into()),
            error_estimate: None,
            account: None,
            seconds: None,
            processor_seconds: None,
            own_seconds: None,
            bytes: 0,
        }
    }

    /// Whether the row has a result.
    pub fn converged(&self) -> bool {
        self.result.is_ok()
    }

    /// "converged", or why not, in one line.
    pub fn outcome(&self) -> String {
        self.result.as_ref().map_or_else(|reason| reason.replace('\n', " "), |_| "converged".into())
    }

    /// Operator applications; 0 where none were counted.
    pub fn applications(&self) -> usize {
        self.account.as_ref().map_or(0, |account| account.operator_applications)
    }

    /// Recorded residuals: applications by then (spread evenly over the records), and the residual.
    pub(super) fn looks(&self) -> Vec<(f64, f64)> {
        let Some(account) = &self.account else { return Vec::new() };
        let per_look = account.operator_applications as f64 / (account.history.len().max(2) - 1) as f64;
        account.history.iter().enumerate().map(|(i, &residual)| (i as f64 * per_look, residual)).collect()
    }

    /// The row of `comparison.csv`; cells are empty where something does not apply.
    pub(super) fn record(&self) -> [(&'static str, String); 22] {
        let case = self.case;
        let account = self.account.as_ref();
        let discrete = self.discrete;
        let grid = discrete.map(|d| d.resolution);
        [
            ("case", written(self.named.as_ref())),
            ("pigment_n", written(case.map(|c| c.pigment[0]))),
            ("pigment_kappa", written(case.map(|c| c.pigment[1]))),
            ("period_um", written(case.map(|c| c.period_um))),
            ("strategy", self.strategy.clone()),
            ("knob", written(self.knob)),
            ("mean", written(discrete.map(|d| mean_name(d.absorbing_mean)))),
            ("scheme", written(grid.map(|r| scheme_name(r.scheme)))),
            ("nx", written(grid.map(|r| r.nx))),
            ("ny", written(grid.map(|r| r.ny))),
            ("cells", written(grid.map(|r| r.cells))),
            ("unknowns", written(self.unknowns)),
            ("error", written(self.result.as_ref().ok())),
            ("error_estimate", written(self.error_estimate)),
            ("residual", written(account.map(|a| a.residual))),
            ("steps", written(account.map(|a| a.steps))),
            ("operator_applications", written(account.map(|a| a.operator_applications))),
            ("seconds", written(self.seconds)),
            ("processor_seconds", written(self.processor_seconds)),
            ("own_seconds", written(self.own_seconds)),
            ("bytes", self.bytes.to_string()),
            ("outcome", self.outcome()),
        ]
    }

    /// The row of the page's table with the names of its columns.
    pub(super) fn shown(&self) -> [(&'static str, String); 12] {
        let power = |x: Option<f64>| dash(x.map(|x| format!("{x:.1e}")));
        let seconds = |x: Option<f64>| dash(x.map(|x| format!("{x:.3}")));
        let account = self.account.as_ref();
        [
            ("strategy", self.strategy.clone()),
            ("case", self.case_name()),
            ("grid", self.grid()),
            ("unknowns", dash(self.unknowns)),
            ("error", power(self.result.clone().ok())),
            ("estimate", power(self.error_estimate)),
            ("residual", power(account.map(|a| a.residual))),
            ("applications", dash(account.map(|a| a.operator_applications))),
            ("seconds", seconds(self.seconds)),
            ("CPU seconds", seconds(self.processor_seconds)),
            ("own seconds", seconds(self.own_seconds)),
            ("MB", format!("{:.1}", self.bytes as f64 / 1e6)),
        ]
    }

    /// The case in words, where there are several.
    pub fn case_name(&self) -> String {
        self.named.clone().unwrap_or_else(|| dash(self.case))
    }

    /// Grid, scheme and mean in words.
    pub fn grid(&self) -> String {
        let mean = self.discrete.map(|d| format!(", {} mean", mean_name(d.absorbing_mean)));
        self.points() + &mean.unwrap_or_default()
    }

    /// Grid and scheme in words, or the knob.
    pub(super) fn points(&self) -> String {
        let Some(Discrete { resolution: r, .. }) = self.discrete else {
            return dash(self.knob.map(|knob| format!("knob {knob}")));
        };
        format!("{}\u{a0}×\u{a0}{}\u{a0}×\u{a0}{}, {}", r.nx, r.ny, r.cells, scheme_name(r.scheme))
    }
}

/// Rows that are alike in something, in the order of their first ones.
pub(super) fn grouped<'a, K: PartialEq>(
    rows: impl IntoIterator<Item = &'a Row>,
    key: impl Fn(&Row) -> K,
) -> Vec<(K, Vec<&'a Row>)> {
    let mut groups: Vec<(K, Vec<&Row>)> = Vec::new();
    for row in rows {
        let key = key(row);
        match groups.iter_mut().find(|(other, _)| *other == key) {
            Some((_, group)) => group.push(row),
            None => groups.push((key, vec![row])),
        }
    }
    groups
}

/// A value, or a dash where there is none.
pub(super) fn dash(value: Option<impl ToString>) -> String {
    value.map_or("–".into(), |value| value.to_string())
}

fn written(value: Option<impl ToString>) -> String {
    value.map_or_else(String::new, |value| value.to_string())
}

/// A scheme's name in words.
pub(super) fn scheme_name(scheme: Scheme) -> String {
    format!("{scheme:?}").to_lowercase().replace("seconddifference", "second difference")
}

/// A mean's name in words.
pub(super) fn mean_name(absorbing: bool) -> &'static str {
    if absorbing { "absorbing" } else { "real" }
}
