//! n from κ of a window of wavelengths, against oscillators that are known everywhere.

use crate::claim::{Bound, Claim, Findings, Level, Reason};
use inkwave::draw::chart::{Chart, Curve, Style};
use inkwave::material::kramers_kronig::{KnownIndex, real_part};
use num_complex::Complex64;

pub const CLAIM: Claim = Claim {
    id: "46-kramers-kronig",
    statement: "From κ between 380 and 780 nm and one n, the relation of Kramers and Kronig gives n within the stated errors.",
    because: "Lorentz's oscillators obey the relation exactly; those in the ultraviolet and the infrared are outside the window, as in measurements.",
    file: file!(),
    measure,
};

/// Oscillators (strength, centre, width in µm⁻¹) of one material.
struct Oscillators(Vec<[f64; 3]>);

impl Oscillators {
    /// √(1 + Σ f ω₀²/(ω₀² − ω² − iγω)).
    fn index(&self, w: f64) -> Complex64 {
        let line = |[strength, centre, width]: &[f64; 3]| {
            strength * centre * centre / Complex64::new(centre * centre - w * w, -width * w)
        };
        (1.0 + self.0.iter().map(line).sum::<Complex64>()).sqrt()
    }

    /// A pigment: far ultraviolet as in glasses and polymers (n of 1.4 to 1.65 far to the red), one band between 220 and 360 nm,
    /// and one to three in the visible, up to κ of about 0.5.
    fn drawn(draw: &mut dyn FnMut() -> f64) -> Self {
        let mut between = |from: f64, to: f64| from + (to - from) * draw();
        let far = between(1.4, 1.65f64).powi(2) - 1.0;
        let mut lines = vec![[far, between(8.0, 11.0), 0.5]];
        lines.push([between(0.0, 0.1), 1e3 / between(220.0, 360.0), between(0.2, 0.5)]);
        for _ in 0..1 + (3.0 * between(0.0, 0.999)) as usize {
            lines.push([between(0.0, 0.06), 1e3 / between(420.0, 700.0), between(0.1, 0.3)]);
        }
        Self(lines)
    }
}

/// Numbers of 0 to 1 that repeat (Knuth's linear congruence of 64 bits).
fn drawing(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    }
}

const ANCHOR_UM: f64 = 0.589;

fn rows(material: &Oscillators, step_nm: f64) -> Vec<[f64; 2]> {
    let count = (400.0 / step_nm).round() as usize;
    (0..=count)
        .map(|i| {
            let um = 1e-3 * (380.0 + step_nm * i as f64);
            [um, material.index(1.0 / um).im]
        })
        .collect()
}

fn measure(level: Level, findings: &mut Findings) {
    let mut draw = drawing(46);
    let mut within = 0usize;
    let mut twice = 0usize;
    let mut all = 0usize;
    let mut largest = 0.0f64;
    let mut squares = 0.0;
    let mut constant = 0.0;
    let pairs = level.pick(200, 2000);
    let mut shown = Vec::new();
    for pair in 0..pairs {
        let material = Oscillators::drawn(&mut draw);
        let rows = rows(&material, 5.0);
        let n = material.index(1.0 / ANCHOR_UM).re;
        let found = real_part(&rows, KnownIndex::At { wavelength_um: ANCHOR_UM, n });
        for (i, [um, _]) in rows.iter().enumerate() {
            let truth = material.index(1.0 / um).re;
            let error = found.n[i] - truth;
            let bar = found.ultraviolet[i].hypot(found.infrared[i]);
            squares += error * error;
            constant += (n - truth).powi(2);
            // at the anchor itself there is neither an error nor a bar
            if (um - ANCHOR_UM).abs() > 0.02 {
                all += 1;
                within += usize::from(error.abs() <= bar);
                twice += usize::from(error.abs() <= 2.0 * bar);
                largest = largest.max(error.abs() / bar);
            }
            if pair == 0 {
                shown.push([1e3 * um, truth, found.n[i], bar]);
            }
        }
    }
    let share = |count: usize| count as f64 / all as f64;
    let because = "a standard error holds 68 % of a normal law, and more of one with flat tops";
    findings.check(
        "share of n within one standard error",
        share(within),
        Bound::AtLeast(0.6),
        Reason::Significance,
        because,
    );
    let because = "two hold 95 % of a normal law";
    findings.check(
        "share of n within two standard errors",
        share(twice),
        Bound::AtLeast(0.9),
        Reason::Significance,
        because,
    );
    findings.promise(
        "largest error over its bar",
        largest,
        6.0,
        "bars stand for materials between silica and a dye",
    );
    let ratio = (squares / constant).sqrt();
    findings.promise(
        "rms error of n over that of one n for all wavelengths",
        ratio,
        0.35,
        "what the relation is for",
    );
    discretisation(findings);
    let curve = |of: usize, name: &str| {
        Curve::new(name, Style::Data, shown.iter().map(|row| (row[0], row[of])).collect::<Vec<_>>())
    };
    let curves = vec![curve(1, "oscillators"), curve(2, "from κ")];
    findings.plots.push(Chart::linear("n of the first pair", "wavelength, nm", "n", curves));
}

/// One band within the window, and n far from it: what is left is the distance of the rows, squared.
fn discretisation(findings: &mut Findings) {
    let material = Oscillators(vec![[0.03, 1e3 / 560.0, 0.06]]);
    let error = |step_nm: f64| {
        let rows = rows(&material, step_nm);
        let n = |wanted_um: f64| {
            let found = real_part(&rows, KnownIndex::Infinity(1.0));
            let place = rows.iter().position(|row| (row[0] - wanted_um).abs() < 1e-9).expect("a row");
            found.n[place]
        };
        // differences between two places cancel what lies beyond the window
        let truth = |um: f64| material.index(1.0 / um).re;
        ((n(0.54) - n(0.58)) - (truth(0.54) - truth(0.58))).abs()
    };
    let coarse = error(20.0);
    let fine = error(10.0);
    findings.promise(
        "dispersion across a band from rows every 10 nm, error",
        fine,
        5e-3,
        "rows every 10 nm are what instruments write",
    );
    findings.order_of_smallness(
        "the same over that of rows every 20 nm",
        fine / coarse,
        0.6,
        "κ is linear between rows: second order, less the pole's and the tails' share",
    );
}
