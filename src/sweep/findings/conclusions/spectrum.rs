//! Conclusions about a range of wavelengths, which must hold at every one of them, at some, or for
//! their mean.

use super::{Claim, Finding, QUANTILE, Verdict, decide, margin, measure, no_value};
use crate::numerics::estimate::{Estimate, Linked};
use crate::sweep::definition::file::Over;
use crate::sweep::findings::outcome::Outcome;

/// The result at one wavelength.
struct AtWavelength {
    nm: f64,
    measured: Estimate,
    verdict: Verdict,
    /// Verdict with the Bonferroni correction for the number of wavelengths.
    together: Verdict,
    /// Distance to the nearer bound.
    margin: f64,
}

impl AtWavelength {
    /// The margin in standard errors, negative beyond the bound.
    fn clearness(&self) -> f64 {
        self.margin / self.measured.standard_error.unwrap_or(f64::INFINITY)
    }
}

/// Tests a conclusion on the selected wavelengths of its range.
pub(super) fn judge(claim: &Claim, outcomes: &[Outcome], range: [f64; 2]) -> Finding {
    let nm = wavelengths(claim, outcomes, range)?;
    if claim.table.over == Over::Mean {
        return on_mean(claim, outcomes, &nm);
    }
    let parts = nm.iter().map(|&one| at_wavelength(claim, outcomes, one, nm.len()));
    one_by_one(&parts.collect::<Result<Vec<_>, String>>()?, claim.table.over, range)
}

/// The selected wavelengths: the whole range, or those that a variant absorbs well.
fn wavelengths(claim: &Claim, outcomes: &[Outcome], [from, to]: [f64; 2]) -> Result<Vec<f64>, String> {
    let rows = claim.plus.iter().chain(&claim.minus).flat_map(|&v| &outcomes[v].spectra);
    let mut nm: Vec<f64> = rows.map(|row| row.wavelength_nm).filter(|nm| (from..=to).contains(nm)).collect();
    nm.sort_by(f64::total_cmp);
    nm.dedup();
    let Some(absorber) = claim.absorbed_by.map(|v| &outcomes[v]) else { return Ok(nm) };
    let rows = absorber.at_first_angle().iter().map(|row| (row.wavelength_nm, row.transmittance.value));
    let rows: Vec<(f64, f64)> = rows.filter(|(nm, _)| (from..=to).contains(nm)).collect();
    if rows.is_empty() {
        return Err(no_value(absorber));
    }
    let absorbed = absorbed(&rows);
    nm.retain(|nm| absorbed.iter().any(|other| (nm - other).abs() < 1e-6));
    Ok(nm)
}

/// Wavelengths at which the transmittance is below the mean of its smallest and largest value.
fn absorbed(rows: &[(f64, f64)]) -> Vec<f64> {
    let least = rows.iter().map(|row| row.1).fold(f64::INFINITY, f64::min);
    let most = rows.iter().map(|row| row.1).fold(f64::NEG_INFINITY, f64::max);
    rows.iter().filter(|row| row.1 <= 0.5 * (least + most)).map(|row| row.0).collect()
}

fn at(claim: &Claim, outcomes: &[Outcome], nm: f64) -> Result<(Linked, usize), String> {
    let mut one = claim.clone();
    one.table.wavelength_nm = Some(nm);
    measure(&one, outcomes)
}

/// Tests the mean over the wavelengths.
fn on_mean(claim: &Claim, outcomes: &[Outcome], nm: &[f64]) -> Finding {
    let parts = nm.iter().map(|&one| at(claim, outcomes, one)).collect::<Result<Vec<_>, String>>()?;
    let (Some(first), Some(last)) = (nm.first(), nm.last()) else {
        return Err("no wavelength of the study in the range".into());
    };
    let fewest = parts.iter().map(|(_, fewest)| *fewest).min().unwrap_or(0);
    let numbers: Vec<Linked> = parts.into_iter().map(|(number, _)| number).collect();
    let mean = mean(&numbers);
    let (verdict, remark) = decide(claim, &mean, fewest, QUANTILE);
    let over = format!("mean over {} wavelengths from {first:.0} to {last:.0} nm", nm.len());
    let remark = if remark.is_empty() { over } else { format!("{over}; {remark}") };
    Ok((verdict, Some(mean.estimate), remark))
}

/// Mean over wavelengths: contributions of realisations are added with their signs; the other
/// errors, mainly of the grid, have the same sign at all wavelengths.
fn mean(numbers: &[Linked]) -> Linked {
    let share = 1.0 / numbers.len() as f64;
    let mut mean = Linked::sum(numbers.iter().map(|number| (share, number)));
    let not_by_chance = |number: &Linked| {
        let error = number.estimate.standard_error?;
        Some((error * error - number.chance_variance()).max(0.0).sqrt())
    };
    let sum: Option<f64> = numbers.iter().map(not_by_chance).sum();
    mean.estimate.standard_error = sum.map(|sum| (share * sum).hypot(mean.chance_variance().sqrt()));
    mean
}

/// Quantile with the Bonferroni correction for this number of wavelengths.
fn corrected(count: usize) -> f64 {
    1.0 - (1.0 - QUANTILE) / count as f64
}

fn at_wavelength(claim: &Claim, outcomes: &[Outcome], nm: f64, count: usize) -> Result<AtWavelength, String> {
    let (measured, fewest) = at(claim, outcomes, nm)?;
    let (verdict, _) = decide(claim, &measured, fewest, QUANTILE);
    let together = decide(claim, &measured, fewest, corrected(count)).0;
    let measured = measured.estimate;
    Ok(AtWavelength { nm, measured, verdict, together, margin: margin(claim, measured.value) })
}

/// What is said of every wavelength is confirmed if all confirm it (an intersection of tests needs
/// no correction), refuted if one refutes it after the Bonferroni correction; what is said of some
/// is refuted if all refute it, confirmed if one confirms it after the correction. The measured
/// value is the one that decides most clearly, or the nearest to it.
fn one_by_one(parts: &[AtWavelength], over: Over, [from, to]: [f64; 2]) -> Finding {
    let mut order: Vec<&AtWavelength> = parts.iter().collect();
    let (sign, one, all, otherwise) = match over {
        Over::Some => (-1.0, Verdict::Confirmed, Verdict::Refuted, "nearest to its bound"),
        Over::Every | Over::Mean => (1.0, Verdict::Refuted, Verdict::Confirmed, "worst"),
    };
    if over == Over::Some {
        order.reverse();
    }
    let least = |a: f64, b: f64| (sign * a).total_cmp(&(sign * b));
    let deciding = order.iter().filter(|part| part.together == one);
    let clearest = deciding.min_by(|a, b| least(a.clearness(), b.clearness()));
    let shown = clearest.or_else(|| order.iter().min_by(|a, b| least(a.margin, b.margin)));
    let shown = shown.ok_or_else(|| format!("no wavelength of the study from {from} to {to} nm"))?;
    let (verdict, why) = match clearest {
        Some(_) => (one, format!("{} most clearly", one.name())),
        None if parts.iter().all(|part| part.verdict == all) => (all, otherwise.to_owned()),
        None => (Verdict::Undecided, otherwise.to_owned()),
    };
    let others: &[Verdict] = if over == Over::Some { &[one] } else { &[one, Verdict::Undecided] };
    let remark = format!("measured at {:.0} nm, where it is {why}{}", shown.nm, listed(parts, others));
    Ok((verdict, Some(shown.measured), remark))
}

/// Lists the wavelengths of each verdict that only some of them have: "; refuted at 500, 520 nm".
fn listed(parts: &[AtWavelength], verdicts: &[Verdict]) -> String {
    let mut text = String::new();
    for which in verdicts {
        let there = parts.iter().filter(|part| part.verdict == *which);
        let there: Vec<String> = there.map(|part| format!("{:.0}", part.nm)).collect();
        if !there.is_empty() && there.len() < parts.len() {
            text += &format!("; {} at {} nm", which.name(), there.join(", "));
        }
    }
    text
}

#[cfg(test)]
#[path = "spectrum_tests.rs"]
mod tests;
