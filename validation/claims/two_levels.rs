//! Results corrected for the grid by a few packings on a finer one lie within the bar that follows.

use crate::claim::{Bound, Claim, Findings, Level, Reason};
use crate::studies::done;
use serde_json::Value;

pub const CLAIM: Claim = Claim {
    id: "30-two-levels",
    statement: "Without an accuracy of its own, a study's L*, a*, b* under natural light differ from those of the same packings on a much finer grid by no more than the grid's part of its bar says, which is less than half of the part without correction.",
    because: "Four of the packings are solved on two grids; the mean difference corrects all, its scatter and 0.6 of it are the error (multilevel Monte Carlo; Giles 2008). Seeds are equal, so chance drops out.",
    file: file!(),
    measure,
};

/// Built-in ink, diameter in nm and volume fraction.
const INKS: [(&str, f64, f64); 4] =
    [("yellow", 250.0, 0.3), ("red", 150.0, 0.4), ("blue", 300.0, 0.15), ("green", 200.0, 0.2)];
const TARGET: &str = "target_delta_e = 0.01\ntarget_colour = 'natural_light'\n";

/// L*, a*, b* under natural light, and the grid's part of its error, all in ΔE*ab.
fn colour((ink, nm, fraction): (&str, f64, f64), seed: usize, rest: &str) -> ([f64; 3], f64) {
    let results = done(&format!(
        "[layer]\nthickness_um = 0.6\nperiod_um = 1.2\nbinder.index = 1.558\n\
         [[pigment]]\nname = '{ink}'\ndiameter_nm = {nm}\nvolume_fraction = {fraction}\nshare = 'scale_sizes'\nindex = {{ built_in = '{ink}' }}\n\
         [light]\nfrom_nm = 400\nto_nm = 700\nstep_nm = 25\nper_realisation = 6\n[angles]\ncount = 3\n\
         [run]\nrealisations = 8\nseed = {seed}\n{rest}"
    ))
    .results;
    let colours = results["colours"].as_array().expect("colours");
    let natural = |c: &&Value| c["conditions"].to_string().contains("natural");
    let colour = colours.iter().find(natural).expect("natural light");
    let lab = [0, 1, 2].map(|i| colour["lab"][i].as_f64().expect("a number"));
    (lab, colour["budget"]["grid"].as_f64().expect("the grid's part"))
}

fn measure(level: Level, findings: &mut Findings) {
    let seeds = level.pick(1, 6);
    let mut squares = 0.0;
    let mut count = 0.0_f64;
    for (ink, seed) in INKS.into_iter().flat_map(|ink| (1..=seeds).map(move |seed| (ink, seed))) {
        let (lab, bar) = colour(ink, seed, TARGET);
        let (fine, fine_bar) = colour(ink, seed, &format!("{TARGET}[resolution]\naccuracy = 2e-3\n"));
        let moved = (0..3).map(|i| (lab[i] - fine[i]).powi(2)).sum::<f64>().sqrt() / bar.hypot(fine_bar);
        findings.check(
            format!("{}, seed {seed}: moved by a fine grid, in the grid's parts", ink.0),
            moved,
            Bound::AtMost(4.5),
            Reason::Significance,
            "Student's t of three degrees of freedom exceeds 4.5 in one of fifty",
        );
        (squares, count) = (squares + moved * moved, count + 1.0);
        if seed == 1 {
            let (_, plain) = colour(ink, seed, "[resolution]\naccuracy = 3e-2\n");
            let because = "a difference that is measured need not be covered whole";
            let what = format!("{}: the grid's part over the one without correction", ink.0);
            findings.check(what, bar / plain, Bound::AtMost(0.5), Reason::Promise, because);
        }
    }
    findings.check(
        "all inks: moved by the fine grid, in errors, rms",
        (squares / count).sqrt(),
        Bound::AtMost(1.7),
        Reason::Significance,
        "Student's t of three degrees of freedom has a standard deviation of √3",
    );
}
