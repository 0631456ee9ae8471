//! Nothing is lost between a layer that absorbs nothing and a perfect white, with grains and in every contact.

use crate::claim::{Bound, Claim, Findings, Level, Reason};
use crate::studies::{Done, done, estimate};

pub const CLAIM: Claim = Claim {
    id: "17-furnace",
    statement: "Clear grains in clear binder on paper of albedo 1 send back exactly the light they get, behind a gap, in optical contact and with a relief, at every angle.",
    because: "R̄ from the exit side is 1 − T̄/n² − Ā by reciprocity, so that g T̄ = 1 without losses, and R and T are fitted in the same functions about one film.",
    file: file!(),
    measure,
};

const ANGLES_DEG: [f64; 5] = [0.0, 25.0, 45.0, 60.0, 80.0];

fn study(layer: &str, paper: &str, realisations: usize) -> Done {
    done(&format!(
        "[layer]\nthickness_um = 0.5\nperiod_um = 1.2\nbinder.index = 1.558\n{layer}\n\
         [[pigment]]\nname = 'clear'\ndiameter_nm = 200\nvolume_fraction = 0.3\nindex = 1.4\n\
         [paper]\nalbedo = 1.0\n{paper}\n[light]\nwavelengths_nm = [450, 600]\n[angles]\ncount = 4\n\
         [run]\nrealisations = {realisations}\n[resolution]\npoints_per_um = 12\nplanes_per_um = 20\n[solver]\ntolerance = 1e-8\n"
    ))
}

/// Largest |albedo − 1| over angles and wavelengths.
fn lost(done: &Done) -> f64 {
    let ink = done.seen.ink.as_ref().expect("an ink on paper");
    let views = ANGLES_DEG.map(|deg| ink.at(deg).expect("below 90°"));
    let of = |layer: &inkwave::evaluate::on_paper::LayerOnPaper| {
        views.iter().map(|view| (layer.albedo(view) - 1.0).abs()).fold(0.0, f64::max)
    };
    ink.layers().iter().map(of).fold(0.0, f64::max)
}

/// Light that may be lost or invented.
fn allowed(done: &Done) -> f64 {
    10.0 * done.results["certainty"]["largest_energy_error"].as_f64().unwrap_or(f64::NAN) + 1e-9
}

fn measure(level: Level, findings: &mut Findings) {
    let realisations = level.pick(3, 12);
    let contact = "coupling = 'optical_contact'";
    let cases = [
        ("gap", study("", "", realisations)),
        ("optical contact", study("index_out = 1.558", contact, realisations)),
        ("relief", study("relief = { depth_um = 0.1 }", "", realisations)),
    ];
    for (name, case) in &cases {
        let because =
            "the solves' own imbalance of energy, which g and the curve's extrapolation may amplify tenfold";
        findings.identity(format!("{name}: light lost or invented"), lost(case), allowed(case), because);
    }
    for (name, case) in &cases[1..] {
        let [apart, error] = estimate(&case.results["certainty"]["exit_reflectance_difference"]);
        let because = "the power of the test above: two unrelated quadratures differ by their directions' chance, which the furnace would be off by, were R̄ taken from the exit side; ten times what it allows cannot be missed";
        findings.check(
            format!("{name}: R̄ from the exit side less 1 − T̄/n² − Ā, over what the furnace allows"),
            apart.abs() / allowed(case),
            Bound::AtLeast(10.0),
            Reason::Significance,
            because,
        );
        if level == Level::Full {
            let because = "Student's t of 11 degrees of freedom exceeds 4.4 once in a thousand";
            findings.check(
                format!("{name}: R̄ from the exit side less 1 − T̄/n² − Ā, in standard errors"),
                apart.abs() / error,
                Bound::AtMost(4.4),
                Reason::Significance,
                because,
            );
        }
    }
}
