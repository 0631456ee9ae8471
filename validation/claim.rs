//! A claim: one sentence about the program, why it must hold, how it is measured, and how far it may be off.

use inkwave::draw::chart::Chart;
use serde::{Deserialize, Serialize};
use std::fmt;

/// How much is measured: `Quick` belongs to every test run, `Full` to the nightly report.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Level {
    Quick,
    Full,
}

impl Level {
    pub fn name(self) -> &'static str {
        self.pick("quick", "full")
    }

    /// One of two sizes.
    pub fn pick<T>(self, quick: T, full: T) -> T {
        if self == Self::Quick { quick } else { full }
    }
}

/// A statement about the program with its measurement.
pub struct Claim {
    pub id: &'static str,
    pub statement: &'static str,
    /// Derivation or source.
    pub because: &'static str,
    /// Where to read the measurement.
    pub file: &'static str,
    pub measure: fn(Level, &mut Findings),
}

/// What a bound rests on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Reason {
    /// Holds exactly but for rounding or the solver's residual.
    Identity,
    /// An order of convergence by theory.
    Order,
    /// A sample of this size deviates more only with a stated small probability.
    Significance,
    /// The accuracy or cost that the program promises.
    Promise,
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Self::Identity => "identity",
            Self::Order => "order",
            Self::Significance => "significance",
            Self::Promise => "promise",
        })
    }
}

/// The values that a measurement may take.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Bound {
    AtMost(f64),
    AtLeast(f64),
    Within([f64; 2]),
}

impl Bound {
    /// Bound ÷ measured: at least 1 when the claim holds, 0 when the measurement is no number.
    pub fn margin(self, measured: f64) -> f64 {
        let margin = match self {
            Self::AtMost(bound) => bound / measured.abs(),
            Self::AtLeast(bound) => measured / bound,
            Self::Within([low, high]) => 0.5 * (high - low) / (measured - 0.5 * (low + high)).abs(),
        };
        // An exact hit has no finite margin; beyond 1e6 it says nothing more.
        if margin.is_nan() { 0.0 } else { margin.clamp(0.0, 1e6) }
    }
}

impl fmt::Display for Bound {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::AtMost(b) => write!(f, "≤ {}", short(*b)),
            Self::AtLeast(b) => write!(f, "≥ {}", short(*b)),
            Self::Within([a, b]) => write!(f, "{} … {}", short(*a), short(*b)),
        }
    }
}

/// Three significant digits.
pub fn short(value: f64) -> String {
    match value.abs() {
        0.0 => "0".into(),
        x if (0.01..10_000.0).contains(&x) => {
            let decimals = (2 - x.log10().floor() as i32).max(0) as usize;
            format!("{value:.decimals$}")
        }
        _ => format!("{value:.1e}"),
    }
}

/// Whether a number differs from an earlier one by more than a factor, either way; not where a ratio means nothing.
pub fn has_changed(now: f64, before: f64, factor: f64) -> bool {
    let ratio = now / before;
    ratio.is_finite() && !(1.0 / factor..=factor).contains(&ratio)
}

/// One number with its bound and the reason for it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Check {
    pub what: String,
    pub measured: f64,
    pub bound: Bound,
    pub reason: Reason,
    pub because: String,
}

impl Check {
    pub fn margin(&self) -> f64 {
        self.bound.margin(self.measured)
    }

    pub fn holds(&self) -> bool {
        self.margin() >= 1.0
    }
}

/// A table of the report.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Table {
    pub title: String,
    pub columns: Vec<String>,
    pub rows: Vec<Vec<String>>,
}

/// What a measurement found.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Findings {
    pub checks: Vec<Check>,
    pub plots: Vec<Chart>,
    pub tables: Vec<Table>,
}

impl Findings {
    pub fn check(
        &mut self,
        what: impl Into<String>,
        measured: f64,
        bound: Bound,
        reason: Reason,
        because: &str,
    ) {
        let because = because.into();
        self.checks.push(Check { what: what.into(), measured, bound, reason, because });
    }

    /// An equality that only rounding or a residual may disturb.
    pub fn identity(&mut self, what: impl Into<String>, error: f64, bound: f64, because: &str) {
        self.check(what, error, Bound::AtMost(bound), Reason::Identity, because);
    }

    /// An observed order of convergence.
    pub fn order(&mut self, what: impl Into<String>, slope: f64, range: [f64; 2], because: &str) {
        self.check(what, slope, Bound::Within(range), Reason::Order, because);
    }

    /// A remainder that theory says is no larger.
    pub fn order_of_smallness(&mut self, what: impl Into<String>, remainder: f64, bound: f64, because: &str) {
        self.check(what, remainder, Bound::AtMost(bound), Reason::Order, because);
    }

    /// A statistic that exceeds `bound` only with a small stated probability.
    pub fn significance(&mut self, what: impl Into<String>, statistic: f64, bound: f64, because: &str) {
        self.check(what, statistic, Bound::AtMost(bound), Reason::Significance, because);
    }

    /// A number that the program promises to stay below.
    pub fn promise(&mut self, what: impl Into<String>, measured: f64, bound: f64, because: &str) {
        self.check(what, measured, Bound::AtMost(bound), Reason::Promise, because);
    }

    /// Drops what JSON cannot hold, and says which check was no number; a report needs the others.
    pub fn without_gaps(&mut self) -> Option<String> {
        for curve in self.plots.iter_mut().flat_map(|p| &mut p.curves) {
            curve.points.retain(|p| p.iter().all(|x| x.is_finite()));
        }
        let lost = self.checks.iter().find(|c| !c.measured.is_finite());
        let failure = lost.map(|c| format!("{}: not a finite number", c.what));
        self.checks.retain(|c| c.measured.is_finite());
        failure
    }

    /// The check nearest to its bound, or beyond it; none when nothing was measured.
    pub fn tightest(&self) -> Option<&Check> {
        self.checks.iter().min_by(|a, b| a.margin().total_cmp(&b.margin()))
    }

    /// True when something was measured and all of it holds.
    pub fn hold(&self) -> bool {
        self.tightest().is_some_and(Check::holds)
    }
}
