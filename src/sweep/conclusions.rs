//! Conclusions as inequalities: statement, measured value with its standard error, verdict.

mod curve;
mod spectrum;

use super::claims::Claim;
use super::file::Quantity;
use super::outcome::Outcome;
use crate::numerics::estimate::Estimate;
use crate::numerics::linked::Linked;
use serde::Serialize;
use statrs::distribution::{ContinuousCDF, StudentsT};
use std::collections::BTreeMap;

/// Two-sided confidence of a verdict: 95 %.
const QUANTILE: f64 = 0.975;

/// What the sweep says about a claim.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Judged {
    /// Short name.
    pub id: String,
    /// The conclusion as one sentence.
    pub statement: String,
    /// In words, such as "C*(a) − C*(b) ≥ 5".
    pub inequality: String,
    /// What was measured, with its error; `None` when a variant is missing.
    pub measured: Option<Estimate>,
    /// What the numbers say.
    pub verdict: Verdict,
    /// Why it is undecided, and what a decision would take.
    pub remark: String,
}

/// Confirmed and refuted hold with 95 % confidence.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The inequality holds with 95 % confidence.
    Confirmed,
    /// It fails with 95 % confidence.
    Refuted,
    /// Neither is certain, or numbers are missing.
    Undecided,
}

impl Verdict {
    /// The verdict as a word.
    pub fn name(self) -> &'static str {
        match self {
            Self::Confirmed => "confirmed",
            Self::Refuted => "refuted",
            Self::Undecided => "undecided",
        }
    }
}

/// Judges a claim by the outcomes of all variants.
pub fn judge(claim: &Claim, outcomes: &[Outcome]) -> Judged {
    let (verdict, measured, remark) = match claim.range_nm {
        Some(range) => spectrum::judge(claim, outcomes, range),
        None => judge_one(claim, outcomes),
    };
    let (id, statement) = (claim.id.clone(), claim.statement.clone());
    Judged { id, statement, inequality: inequality(claim, outcomes), measured, verdict, remark }
}

fn judge_one(claim: &Claim, outcomes: &[Outcome]) -> (Verdict, Option<Estimate>, String) {
    let measured = measure(claim, outcomes).and_then(|(sum, fewest)| {
        let place = if claim.curve.is_empty() { sum } else { curve::place(claim, outcomes, &sum)? };
        Ok((place.estimate, fewest))
    });
    match measured {
        Err(missing) => (Verdict::Undecided, None, missing),
        Ok((estimate, fewest)) => {
            let (verdict, remark) = decide(claim, estimate, fewest, QUANTILE);
            (verdict, Some(estimate), remark)
        }
    }
}

/// What a verdict says of a variant that is not there.
fn no_value(name: &str) -> String {
    format!("no value of {name} yet: finish the sweep")
}

/// The measured value, and the fewest realisations behind it.
fn measure(claim: &Claim, outcomes: &[Outcome]) -> Result<(Linked, usize), String> {
    let all = || claim.plus.iter().chain(&claim.minus).map(|&v| &outcomes[v]);
    let several = all().map(|o| o.realisations).filter(|&n| n > 1).min().unwrap_or(0);
    if claim.quantity == Quantity::DeltaE {
        let (a, b) = (&outcomes[claim.plus[0]], &outcomes[claim.minus[0]]);
        let missing = || no_value(if a.colour.is_none() { &a.name } else { &b.name });
        let difference = a.delta_e_2000(b).ok_or_else(missing)?;
        return Ok((Linked { estimate: difference, deviations: BTreeMap::new() }, several));
    }
    let of = |outcome: &Outcome| {
        outcome.quantity(claim.quantity, claim.wavelength_nm).ok_or_else(|| no_value(&outcome.name))
    };
    let numbers = all().map(of).collect::<Result<Vec<Linked>, String>>()?;
    let signs = claim.plus.iter().map(|_| 1.0).chain(claim.minus.iter().map(|_| -1.0));
    Ok((Linked::sum(signs.zip(&numbers)), several))
}

/// The verdict at a one-sided confidence, and what a decision would take.
fn decide(claim: &Claim, measured: Estimate, fewest: usize, quantile: f64) -> (Verdict, String) {
    let Some(error) = measured.standard_error else {
        return (
            Verdict::Undecided,
            "the standard error is unknown: 2 or more realisations are needed".into(),
        );
    };
    let above = claim.at_least.map(|bound| measured.value - bound);
    let below = claim.at_most.map(|bound| bound - measured.value);
    let margin = above.into_iter().chain(below).fold(f64::INFINITY, f64::min);
    let reach = error * student(fewest, quantile);
    if margin.abs() > reach || error == 0.0 {
        return (if margin >= 0.0 { Verdict::Confirmed } else { Verdict::Refuted }, String::new());
    }
    let needed = fewest as f64 * (2.0 * error / margin).powi(2);
    let remark = if needed < 1e6 {
        format!(
            "about {:.0} realisations instead of {fewest}, if the value stays",
            needed.ceil().max(fewest as f64 + 1.0)
        )
    } else {
        "the value sits on the bound".into()
    };
    (Verdict::Undecided, remark)
}

/// Quantile of Student's t for a mean of n realisations; one where nothing varies.
fn student(realisations: usize, quantile: f64) -> f64 {
    let freedom = realisations.saturating_sub(1).max(1) as f64;
    StudentsT::new(0.0, 1.0, freedom).map_or(f64::INFINITY, |t| t.inverse_cdf(quantile))
}

fn inequality(claim: &Claim, outcomes: &[Outcome]) -> String {
    let at = match (claim.wavelength_nm, claim.range_nm) {
        (Some(nm), _) => format!("{nm:.0}"),
        (None, Some([from, to])) => format!("{from:.0}–{to:.0}"),
        (None, None) => String::new(),
    };
    let symbol = match claim.quantity {
        Quantity::Chroma => "C*".to_owned(),
        Quantity::Lightness => "L*".to_owned(),
        Quantity::Hue => "h".to_owned(),
        Quantity::Transmittance => format!("T{at}"),
        Quantity::Reflectance => format!("R{at}"),
        Quantity::DeltaE => {
            let name = |v: &[usize]| v.first().map_or_else(String::new, |&v| outcomes[v].labels.join(", "));
            return bounded(claim, &format!("ΔE₀₀({}; {})", name(&claim.plus), name(&claim.minus)));
        }
    };
    let term = |v: &usize| format!("{symbol}({})", outcomes[*v].labels.join(", "));
    let plus: Vec<String> = claim.plus.iter().map(term).collect();
    let minus: String = claim.minus.iter().map(|v| format!(" − {}", term(v))).collect();
    let sum = format!("{}{minus}", plus.join(" + "));
    bounded(claim, &if claim.curve.is_empty() { sum } else { format!("place with the same {sum}") })
}

fn bounded(claim: &Claim, what: &str) -> String {
    let bound = |x: f64| x.to_string().replace('-', "−");
    match (claim.at_least, claim.at_most) {
        (Some(low), Some(high)) => format!("{} ≤ {what} ≤ {}", bound(low), bound(high)),
        (Some(low), None) => format!("{what} ≥ {}", bound(low)),
        (_, high) => format!("{what} ≤ {}", bound(high.unwrap_or(f64::INFINITY))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn verdict(value: f64, error: f64, n: usize) -> Verdict {
        let claim = Claim {
            id: "1".into(),
            statement: String::new(),
            quantity: Quantity::Chroma,
            wavelength_nm: None,
            range_nm: None,
            plus: vec![],
            minus: vec![],
            at_least: Some(5.0),
            at_most: None,
            curve: vec![],
        };
        decide(&claim, Estimate { value, standard_error: Some(error) }, n, QUANTILE).0
    }

    #[test]
    fn a_verdict_needs_a_margin_beyond_students_t() {
        // t of 3 degrees of freedom is 3.18
        assert_eq!(verdict(8.3, 1.0, 4), Verdict::Confirmed);
        assert_eq!(verdict(8.0, 1.0, 4), Verdict::Undecided);
        assert_eq!(verdict(1.7, 1.0, 4), Verdict::Refuted);
        assert_eq!(verdict(7.1, 1.0, 100), Verdict::Confirmed);
        assert_eq!(verdict(5.1, 0.0, 0), Verdict::Confirmed);
    }
}
