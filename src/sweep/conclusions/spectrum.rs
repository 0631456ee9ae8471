//! A conclusion about a range of wavelengths: it must hold at every one of them.

use super::{Claim, QUANTILE, Verdict, decide, measure};
use crate::numerics::estimate::Estimate;
use crate::sweep::outcome::Outcome;

/// One wavelength's part.
struct AtWavelength {
    nm: f64,
    measured: Estimate,
    verdict: Verdict,
    /// Refuted even where all wavelengths had their chance to err (Bonferroni).
    refuted: bool,
    /// Distance to the nearer bound.
    margin: f64,
}

impl AtWavelength {
    /// The distance in standard errors: negative beyond the bound.
    fn clearness(&self) -> f64 {
        self.margin / self.measured.standard_error.unwrap_or(f64::INFINITY)
    }
}

/// Confirmed where every wavelength confirms it (the intersection of tests needs no correction), refuted where one of
/// them does although all had their chance; measured is the value where it is refuted most clearly, or else nearest to that.
pub(super) fn judge(
    claim: &Claim,
    outcomes: &[Outcome],
    [from, to]: [f64; 2],
) -> (Verdict, Option<Estimate>, String) {
    let rows = claim.plus.iter().chain(&claim.minus).flat_map(|&v| &outcomes[v].spectra);
    let mut nm: Vec<f64> = rows.map(|row| row.wavelength_nm).filter(|nm| (from..=to).contains(nm)).collect();
    nm.sort_by(f64::total_cmp);
    nm.dedup();
    let parts: Result<Vec<AtWavelength>, String> =
        nm.iter().map(|&one| at_wavelength(claim, outcomes, one, nm.len())).collect();
    match parts {
        Err(missing) => (Verdict::Undecided, None, missing),
        Ok(parts) => join(&parts, [from, to]),
    }
}

fn at_wavelength(claim: &Claim, outcomes: &[Outcome], nm: f64, count: usize) -> Result<AtWavelength, String> {
    let (measured, fewest) = measure(&Claim { wavelength_nm: Some(nm), ..claim.clone() }, outcomes)?;
    let together = 1.0 - (1.0 - QUANTILE) / count as f64;
    let (verdict, _) = decide(claim, &measured, fewest, QUANTILE);
    let refuted = decide(claim, &measured, fewest, together).0 == Verdict::Refuted;
    let measured = measured.estimate;
    let above = claim.at_least.map_or(f64::INFINITY, |bound| measured.value - bound);
    let below = claim.at_most.map_or(f64::INFINITY, |bound| bound - measured.value);
    Ok(AtWavelength { nm, measured, verdict, refuted, margin: above.min(below) })
}

fn join(parts: &[AtWavelength], [from, to]: [f64; 2]) -> (Verdict, Option<Estimate>, String) {
    let clearest =
        parts.iter().filter(|part| part.refuted).min_by(|a, b| a.clearness().total_cmp(&b.clearness()));
    let nearest = || parts.iter().min_by(|a, b| a.margin.total_cmp(&b.margin));
    let Some(worst) = clearest.or_else(nearest) else {
        return (Verdict::Undecided, None, format!("no wavelength of the study from {from} to {to} nm"));
    };
    let verdict = match parts {
        _ if parts.iter().all(|part| part.verdict == Verdict::Confirmed) => Verdict::Confirmed,
        _ if parts.iter().any(|part| part.refuted) => Verdict::Refuted,
        _ => Verdict::Undecided,
    };
    let why = if clearest.is_some() { "refuted most clearly" } else { "worst" };
    let mut remark = format!("measured at {:.0} nm, where it is {why}", worst.nm);
    for (word, which) in [("refuted", Verdict::Refuted), ("undecided", Verdict::Undecided)] {
        let there: Vec<String> =
            parts.iter().filter(|part| part.verdict == which).map(|part| format!("{:.0}", part.nm)).collect();
        if !there.is_empty() && there.len() < parts.len() {
            remark += &format!("; {word} at {} nm", there.join(", "));
        }
    }
    (verdict, Some(worst.measured), remark)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn part(nm: f64, margin: f64, verdict: Verdict) -> AtWavelength {
        let measured = Estimate { value: margin, standard_error: Some(0.1) };
        AtWavelength { nm, measured, verdict, refuted: verdict == Verdict::Refuted, margin }
    }

    #[test]
    fn one_wavelength_refutes_what_others_confirm() {
        let parts = [part(500.0, 1.0, Verdict::Confirmed), part(520.0, -1.0, Verdict::Refuted)];
        let (verdict, measured, remark) = join(&parts, [500.0, 520.0]);
        assert_eq!(verdict, Verdict::Refuted);
        assert_eq!(measured.map(|m| m.value), Some(-1.0));
        assert!(remark.contains("refuted at 520 nm"), "{remark}");
        // The farther value may be the less certain one.
        let uncertain = AtWavelength { refuted: false, ..part(540.0, -2.0, Verdict::Undecided) };
        let measured = join(&[part(520.0, -1.0, Verdict::Refuted), uncertain], [520.0, 540.0]).1;
        assert_eq!(measured.map(|m| m.value), Some(-1.0));
        assert_eq!(join(&parts[..1], [500.0, 500.0]).0, Verdict::Confirmed);
        assert_eq!(join(&[part(500.0, 0.1, Verdict::Undecided)], [500.0, 500.0]).0, Verdict::Undecided);
        assert_eq!(join(&[], [1.0, 2.0]).0, Verdict::Undecided);
    }
}
