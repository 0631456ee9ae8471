//! Layers composed of slabs against the same layers solved at once.

use super::{FARTHEST, Ink};
use crate::claim::{Bound, Findings, Level, Reason, Table};
use crate::studies::{done, estimate, row};
use inkwave::numerics::estimate::coverage_factor_95;

/// Angles that both ways report, degrees, with the name of the composed number's end.
const ANGLES: [(f64, &str); 2] = [(0.0, "normal"), (45.0, "45")];
/// Share of 95 % intervals that should hold at least, less what chance does to sixty numbers, some of which go
/// together: twice √(.9 × .1/60).
const COVERED: f64 = 0.82;

/// Composed less solved at once, in units of what both 95 % intervals allow, and in standard errors.
#[derive(Default)]
pub struct Compared {
    halves: Vec<f64>,
    errors: Vec<f64>,
    rows: Vec<Vec<String>>,
}

impl Compared {
    /// R and T of a layer at its wavelengths and both angles.
    pub fn add(&mut self, ink: Ink, realisations: usize) {
        let um = ink.thickness_um;
        let stack = ink.composed(&[], realisations);
        let whole = done(&format!("{}[angles]\ncount = 3\n", ink.layer(&um.to_string(), "", realisations)));
        let factor = coverage_factor_95(realisations - 1).expect("several realisations");
        for (nm, own) in ink.wavelengths_nm.iter().zip(stack["spectra"].as_array().expect("rows")) {
            for (deg, name) in ANGLES {
                let truth = row(&whole.results, f64::from(*nm), deg);
                for lobe in ["reflectance", "transmittance"] {
                    let pair = [estimate(&own[format!("{lobe}_{name}")]), estimate(&truth[lobe])];
                    self.note(format!("{} {um} µm, {nm} nm, {deg}°: {lobe}", ink.name), pair, factor);
                }
            }
        }
    }

    fn note(&mut self, what: String, [[a, a_error], [b, b_error]]: [[f64; 2]; 2], factor: f64) {
        let errors = (a - b) / a_error.hypot(b_error);
        let numbers = [(a, 5), (a_error, 5), (b, 5), (b_error, 5), (errors, 2)];
        let shown = numbers.map(|(x, digits)| format!("{x:.digits$}"));
        self.rows.push([what].into_iter().chain(shown).collect());
        self.errors.push(errors);
        self.halves.push(errors / factor);
    }

    /// None is far off, and as many are within their intervals as these say.
    pub fn judge(self, level: Level, findings: &mut Findings) {
        let farthest = self.errors.iter().fold(0.0, |most: f64, z| most.max(z.abs()));
        findings.check(
            "composed less solved at once, largest difference in standard errors",
            farthest,
            Bound::AtMost(FARTHEST),
            Reason::Significance,
            "a dozen comparisons of few realisations, or sixty of more",
        );
        if level == Level::Full {
            let held = |width: f64| {
                self.halves.iter().filter(|x| x.abs() <= width).count() as f64 / self.halves.len() as f64
            };
            let what = format!("share of {} differences within the 95 % interval of both", self.halves.len());
            let because =
                "90 to 99 % are meant; chance takes up to 8 % of sixty numbers that are not independent";
            findings.check(what, held(1.0), Bound::AtLeast(COVERED), Reason::Significance, because);
            let because = "the power of the test above";
            let what = "share of them within two fifths of it, which would be noticed";
            findings.check(what, held(0.4), Bound::AtMost(COVERED), Reason::Significance, because);
        }
        let head = ["layer", "composed", "error", "solved at once", "error", "difference in errors"];
        findings.tables.push(Table {
            title: "Layers composed and solved at once".to_string(),
            columns: head.map(str::to_string).to_vec(),
            rows: self.rows,
        });
    }
}
