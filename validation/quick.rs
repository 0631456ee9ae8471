//! Every claim at its quick level: one test each, in `cargo test`.

use inkwave_validation::claim::{Claim, Findings, Level};
use inkwave_validation::claims;
use libtest_mimic::{Arguments, Failed, Trial};

fn trial(claim: &'static Claim) -> Trial {
    Trial::test(claim.id, || judge(claim))
}

fn judge(claim: &Claim) -> Result<(), Failed> {
    let mut findings = Findings::default();
    (claim.measure)(Level::Quick, &mut findings);
    for check in &findings.checks {
        let margin = check.margin();
        println!(
            "{}, {}: {}: {:.3e}, {}, margin {margin:.2}",
            claim.id,
            Level::Quick.name(),
            check.what,
            check.measured,
            check.bound
        );
    }
    let broken: Vec<String> = findings
        .checks
        .iter()
        .filter(|c| !c.holds())
        .map(|c| format!("{}: {:.3e}, allowed {} ({}: {})", c.what, c.measured, c.bound, c.reason, c.because))
        .collect();
    if let Some(gap) = findings.without_gaps() {
        return Err(gap.into());
    }
    if !findings.hold() {
        let broken = broken.join("\n  ");
        let statement = claim.statement;
        let because = claim.because;
        return Err(format!("{statement}\nbecause: {because}\n{}\n  {broken}", claim.file).into());
    }
    if let Some(plot) = findings.plots.iter().find(|plot| plot.is_empty()) {
        return Err(format!("the chart \"{}\" has nothing to show", plot.title).into());
    }
    // A report that cannot draw its plots would only fail at night.
    findings.plots.iter().try_for_each(|plot| plot.svg().map(drop)).map_err(Failed::from)
}

fn main() {
    static ALL: &[Claim] = &claims::ALL;
    let trials = ALL.iter().map(trial).collect();
    libtest_mimic::run(&Arguments::from_args(), trials).exit();
}
