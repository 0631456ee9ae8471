//! Conclusions as inequalities: statement, measured value with its standard error, verdict. The
//! place on a curve of variants that has a given value, such as the diameter of the spheres that
//! act like an agglomerate, is one of the values measured.

mod spectrum;

use super::outcome::Outcome;
use crate::numerics::estimate::{Estimate, Linked};
use crate::sweep::definition::claims::Claim;
use crate::sweep::definition::file::{ConclusionTable, MeasuredQuantity, Over};
use serde::Serialize;
use statrs::distribution::{ContinuousCDF, Normal, StudentsT};

/// Quantile for a two-sided confidence level of 95 %.
pub(super) const QUANTILE: f64 = 0.975;

/// The verdict on a conclusion.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Judged {
    /// The conclusion as written.
    #[serde(flatten)]
    pub table: ConclusionTable,
    /// The inequality, such as "C*(a) − C*(b) ≥ 5".
    pub inequality: String,
    /// The measured value with its error; `None` if a variant is missing.
    pub measured: Option<Estimate>,
    /// The verdict.
    pub verdict: Verdict,
    /// Why the conclusion is undecided, and what would decide it.
    pub remark: String,
}

/// Confirmed and refuted both hold with 95 % confidence.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The inequality holds with 95 % confidence.
    Confirmed,
    /// The inequality fails with 95 % confidence.
    Refuted,
    /// Neither is certain, or numbers are missing.
    Undecided,
}

impl Verdict {
    /// Name of the verdict.
    pub fn name(self) -> &'static str {
        match self {
            Self::Confirmed => "confirmed",
            Self::Refuted => "refuted",
            Self::Undecided => "undecided",
        }
    }
}

/// Verdict, measured value and remark; or what is missing.
type Finding = Result<(Verdict, Option<Estimate>, String), String>;

/// Tests a conclusion on the outcomes of all variants.
pub fn judge(claim: &Claim, outcomes: &[Outcome]) -> Judged {
    let finding = match claim.table.range_nm {
        Some(range) => spectrum::judge(claim, outcomes, range),
        None => judge_one(claim, outcomes),
    };
    let (verdict, measured, remark) = finding.unwrap_or_else(|missing| (Verdict::Undecided, None, missing));
    let table = claim.table.clone();
    let inequality = inequality(claim, outcomes);
    Judged { table, inequality, measured, verdict, remark }
}

fn judge_one(claim: &Claim, outcomes: &[Outcome]) -> Finding {
    let (mut measured, fewest) = measure(claim, outcomes)?;
    if !claim.among.is_empty() {
        measured = place(claim, outcomes, &measured)?;
    }
    let (verdict, remark) = decide(claim, &measured, fewest, QUANTILE);
    Ok((verdict, Some(measured.estimate), remark))
}

/// Remark for a variant without results.
fn no_value(outcome: &Outcome) -> String {
    match &outcome.reason {
        Some(reason) => format!("{} has no value: {reason}", outcome.name),
        None => format!("{} has no value yet: finish the sweep", outcome.name),
    }
}

/// The claim's quantity of one variant.
fn number(claim: &Claim, outcome: &Outcome) -> Result<Linked, String> {
    let found = match &claim.table.number {
        Some(name) => outcome.weighted(name),
        None => outcome.quantity(claim.table.quantity, claim.table.wavelength_nm),
    };
    found.ok_or_else(|| no_value(outcome))
}

/// The measured value, and the smallest number of realisations it depends on; 0 if there is no
/// randomness.
fn measure(claim: &Claim, outcomes: &[Outcome]) -> Result<(Linked, usize), String> {
    let all = || claim.plus.iter().chain(&claim.minus).map(|&v| &outcomes[v]);
    let behind = all().chain(claim.among.iter().map(|&v| &outcomes[v])).map(|o| o.realisations);
    let fewest = behind.filter(|&n| n > 1).min().unwrap_or(0);
    let quantity = claim.table.quantity;
    if quantity == MeasuredQuantity::DeltaE {
        let (a, b) = (&outcomes[claim.plus[0]], &outcomes[claim.minus[0]]);
        let missing = || no_value(if a.colour.is_none() { a } else { b });
        return Ok((a.difference(b).ok_or_else(missing)?, fewest));
    }
    let numbers = all().map(|outcome| number(claim, outcome)).collect::<Result<Vec<Linked>, String>>()?;
    let signs = claim.plus.iter().map(|_| 1.0).chain(claim.minus.iter().map(|_| -1.0));
    let mut sum = Linked::sum(signs.zip(&numbers));
    if quantity == MeasuredQuantity::Hue && claim.plus.len() == claim.minus.len() {
        // hues on both sides of red are close to each other
        sum.estimate.value = 180.0 - (180.0 - sum.estimate.value).rem_euclid(360.0);
    }
    Ok((sum, fewest))
}

/// The verdict at the given quantile, and what would decide the conclusion.
fn decide(claim: &Claim, measured: &Linked, fewest: usize, quantile: f64) -> (Verdict, String) {
    let Some(error) = measured.estimate.standard_error else {
        let unknown = "the standard error is unknown: 2 or more realisations are needed";
        return (Verdict::Undecided, unknown.into());
    };
    let margin = margin(claim, measured.estimate.value);
    if margin.abs() > (error * student(fewest, quantile)) || error == 0.0 {
        return (if margin >= 0.0 { Verdict::Confirmed } else { Verdict::Refuted }, String::new());
    }
    (Verdict::Undecided, what_it_takes(measured.chance_variance(), error, margin, fewest))
}

/// Distance to the nearer bound, negative beyond it.
fn margin(claim: &Claim, value: f64) -> f64 {
    let value = if claim.table.absolute { value.abs() } else { value };
    let below = claim.table.at_most.map(|bound| bound - value);
    claim.table.at_least.map(|bound| value - bound).into_iter().chain(below).fold(f64::INFINITY, f64::min)
}

/// Number of realisations that would bring two standard errors below the margin, if the part of the
/// error that they do not reduce allows it.
fn what_it_takes(chance: f64, error: f64, margin: f64, fewest: usize) -> String {
    let room = (0.5 * margin).powi(2) - (error * error - chance).max(0.0);
    let needed = fewest as f64 * chance / room;
    if room <= 0.0 && 2.0 * (error * error - chance).max(0.0).sqrt() > 1e-3 * margin.abs().max(error) {
        return "the grid leaves it open: a smaller resolution.accuracy, if the value stays".into();
    }
    if room > 0.0 && needed < 1e6 {
        let needed = needed.ceil().max(fewest as f64 + 1.0);
        return format!("about {needed:.0} realisations instead of {fewest}, if the value stays");
    }
    "the value lies on the bound".into()
}

/// Quantile of Student's t for a mean of n realisations, or of the normal distribution without
/// randomness.
pub(super) fn student(realisations: usize, quantile: f64) -> f64 {
    if realisations == 0 {
        return Normal::standard().inverse_cdf(quantile);
    }
    let freedom = realisations.saturating_sub(1).max(1) as f64;
    StudentsT::new(0.0, 1.0, freedom).map_or(f64::INFINITY, |t| t.inverse_cdf(quantile))
}

/// Abscissa of the value on the curve, interpolated linearly, with the errors of the value and of
/// the curve.
///
/// # Errors
/// Why there is no such place: values are missing, or the curve does not take the value exactly
/// once.
fn place(claim: &Claim, outcomes: &[Outcome], value: &Linked) -> Result<Linked, String> {
    let points = claim.curve().map(|(at, v)| Ok((at, number(claim, &outcomes[v])?)));
    on_curve(&points.collect::<Result<Vec<_>, String>>()?, value)
}

fn on_curve(points: &[(f64, Linked)], target: &Linked) -> Result<Linked, String> {
    let value = target.estimate.value;
    let crosses = |w: &&[(f64, Linked)]| {
        let a = w[0].1.estimate.value;
        let b = w[1].1.estimate.value;
        (a <= value && value < b) || (b < value && value <= a)
    };
    let crossings: Vec<&[(f64, Linked)]> = points.windows(2).filter(crosses).collect();
    match crossings[..] {
        [[start, end]] => Ok(within(start, end, target)),
        [] => Err(format!("the curve has {value:.4} nowhere")),
        _ => Err(format!("the curve has {value:.4} at {} places", crossings.len())),
    }
}

/// Interpolates between two points; an error of the value or of the curve moves the abscissa by
/// that error over the slope.
fn within((from, a): &(f64, Linked), (to, b): &(f64, Linked), target: &Linked) -> Linked {
    let [low, high, value] = [a, b, target].map(|number| number.estimate.value);
    let slope = (high - low) / (to - from);
    let share = (value - low) / (high - low);
    let mut place = Linked::sum([(1.0 / slope, target), ((share - 1.0) / slope, a), (-share / slope, b)]);
    place.estimate.value = from + share * (to - from);
    place
}

/// The inequality of a conclusion, such as "C*(a) − C*(b) ≥ 5".
fn inequality(claim: &Claim, outcomes: &[Outcome]) -> String {
    let nm = match (claim.table.wavelength_nm, claim.table.range_nm) {
        (Some(nm), _) => format!("{nm:.0}"),
        (None, Some([from, to])) => format!("{from:.0}–{to:.0}"),
        (None, None) => String::new(),
    };
    let symbol = match claim.table.quantity {
        MeasuredQuantity::Chroma => "C*".to_owned(),
        MeasuredQuantity::Lightness => "L*".to_owned(),
        MeasuredQuantity::Hue => "h".to_owned(),
        MeasuredQuantity::Transmittance => format!("T{nm}"),
        MeasuredQuantity::Reflectance => format!("R{nm}"),
        MeasuredQuantity::ContrastRatio => "contrast ratio".to_owned(),
        MeasuredQuantity::Number => claim.table.number.clone().unwrap_or_default(),
        MeasuredQuantity::DeltaEToTarget => "ΔE₀₀ to the target".to_owned(),
        MeasuredQuantity::DeltaE => {
            let name = |v: &[usize]| v.first().map_or_else(String::new, |&v| outcomes[v].labels.join(", "));
            return bounded(claim, &format!("ΔE₀₀({}; {})", name(&claim.plus), name(&claim.minus)));
        }
    };
    let term = |v: &usize| format!("{symbol}({})", outcomes[*v].labels.join(", "));
    let plus: Vec<String> = claim.plus.iter().map(term).collect();
    let minus: String = claim.minus.iter().map(|v| format!(" − {}", term(v))).collect();
    let sum = format!("{}{minus}", plus.join(" + "));
    let sum = if claim.table.absolute { format!("|{sum}|") } else { sum };
    let what = if claim.among.is_empty() { sum } else { format!("place with the same {sum}") };
    bounded(claim, &what) + &wavelengths(claim, outcomes)
}

fn bounded(claim: &Claim, what: &str) -> String {
    let bound = |x: f64| x.to_string().replace('-', "−");
    match (claim.table.at_least, claim.table.at_most) {
        (Some(low), Some(high)) => format!("{} ≤ {what} ≤ {}", bound(low), bound(high)),
        (Some(low), None) => format!("{what} ≥ {}", bound(low)),
        (_, high) => format!("{what} ≤ {}", bound(high.unwrap_or(f64::INFINITY))),
    }
}

/// Describes the selected wavelengths; empty if the whole range counts.
fn wavelengths(claim: &Claim, outcomes: &[Outcome]) -> String {
    let over = match claim.table.over {
        Over::Every => "",
        Over::Some => ", at some wavelength",
        Over::Mean => ", on the mean",
    };
    let absorbed = claim.absorbed_by.map(|v| outcomes[v].labels.join(", "));
    let absorbed = absorbed.map(|name| format!(", where {name} absorbs well (lower half of its T)"));
    format!("{over}{}", absorbed.unwrap_or_default())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::estimate::Estimate;

    fn verdict(value: f64, error: f64, n: usize) -> Verdict {
        let mut claim = Claim::example();
        claim.table.at_least = Some(5.0);
        let estimate = Estimate { value, standard_error: Some(error) };
        let measured = Linked { estimate, deviations: [(0, error)].into() };
        decide(&claim, &measured, n, QUANTILE).0
    }

    #[test]
    fn a_verdict_needs_a_margin_beyond_students_t() {
        // t for 3 degrees of freedom is 3.18
        assert_eq!(verdict(8.3, 1.0, 4), Verdict::Confirmed);
        assert_eq!(verdict(8.0, 1.0, 4), Verdict::Undecided);
        assert_eq!(verdict(1.7, 1.0, 4), Verdict::Refuted);
        assert_eq!(verdict(7.1, 1.0, 100), Verdict::Confirmed);
        assert_eq!(verdict(5.1, 0.0, 0), Verdict::Confirmed);
        // no randomness: 1.96 of the normal distribution
        assert_eq!(verdict(7.0, 1.0, 0), Verdict::Confirmed);
        assert_eq!(verdict(6.9, 1.0, 0), Verdict::Undecided);
    }

    #[test]
    fn what_a_decision_takes_depends_on_what_leaves_it_open() {
        // two standard errors, all random, against a margin of 1: four times the realisations
        assert!(what_it_takes(1.0, 1.0, 1.0, 10).starts_with("about 40 realisations instead of 10"));
        // with a grid error of 0.8 no number of realisations brings two standard errors below 1
        assert!(what_it_takes(0.36, 1.0, 1.0, 10).contains("resolution.accuracy"));
        assert_eq!(what_it_takes(1.0, 1.0, 0.0, 10), "the value lies on the bound");
    }

    fn number(value: f64) -> Linked {
        let estimate = Estimate { value, standard_error: Some(0.3) };
        Linked { estimate, deviations: [(0, 0.0)].into() }
    }

    #[test]
    fn a_value_is_found_between_two_points_with_its_error() {
        let points = [(100.0, number(50.0)), (200.0, number(40.0)), (300.0, number(38.0))];
        let found = on_curve(&points, &number(45.0)).unwrap().estimate;
        assert!((found.value - 150.0).abs() < 1e-12);
        // heights 0.3 and twice 0.15 add up to 0.367, over a slope of 0.1
        assert!((found.standard_error.unwrap() - 3.674).abs() < 1e-3);
        assert!(on_curve(&points, &number(37.0)).is_err());
        let twice = [(1.0, number(0.0)), (2.0, number(2.0)), (3.0, number(0.5))];
        assert!(on_curve(&twice, &number(1.0)).is_err());
    }

    #[test]
    fn what_moves_the_value_and_the_curve_alike_leaves_the_place() {
        let moved = |value: f64| Linked { deviations: [(0, 0.3)].into(), ..number(value) };
        let points = [(100.0, moved(50.0)), (200.0, moved(40.0))];
        let found = on_curve(&points, &moved(45.0)).unwrap().estimate;
        // rounding errors of a few additions, over the slope
        assert!(found.standard_error.unwrap() < 1e-12, "{found:?}");
    }
}
