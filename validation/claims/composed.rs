//! Layers composed of slabs against layers solved at once, and what they may not lose.

mod compared;
mod medium;

use crate::claim::{Bound, Claim, Findings, Level, Reason};
use crate::studies::{composed_between, estimate};
use compared::Compared;
use inkwave::material::mixing::MixingRule;
use serde_json::Value;

pub const CLAIM: Claim = Claim {
    id: "26-composed",
    statement: "A layer composed of slabs is the layer solved at once, within both error bars, in either wave equation; its medium scatters, fades and lags as hard spheres do; and at 100 µm no light is lost.",
    because: "Flux matrices are reciprocal and conserve energy column by column; the surfaces are solved together with the outermost slabs.",
    file: file!(),
    measure,
};

/// Largest distance in standard errors: a dozen comparisons exceed it by chance in 3 % of all runs at eight realisations, with
/// Student's law of as many degrees of freedom as there are realisations, and sixty in 1 % at 24.
const FARTHEST: f64 = 4.5;

/// An ink of grains of 250 nm and its layers, µm: as thick as they are composed, and the slabs.
#[derive(Clone, Copy)]
struct Ink {
    name: &'static str,
    index: &'static str,
    binder: f64,
    share: f64,
    thickness_um: f64,
    slab_um: f64,
    wavelengths_nm: &'static [u32],
    wave: &'static str,
    period_um: f64,
}

const CLEAR: Ink = Ink {
    name: "clear grains",
    index: "2.0",
    binder: 1.5,
    share: 0.15,
    thickness_um: 2.0,
    slab_um: 1.0,
    wavelengths_nm: &[550],
    wave: "scalar",
    period_um: 1.0,
};
const DYED: Ink = Ink {
    name: "dyed grains",
    index: "{ n = 1.4, k = 0.02 }",
    binder: 1.558,
    share: 0.3,
    thickness_um: 4.0,
    slab_um: 2.0,
    ..CLEAR
};
const DARK: Ink = Ink { name: "dark grains", index: "{ n = 1.8, k = 0.1 }", share: 0.2, ..CLEAR };
const STRONG: Ink = Ink { name: "rutile-like grains", index: "2.5", share: 0.08, ..CLEAR };

/// As white paint, in Maxwell's equations; small, since these solves cost more.
const PAINT: Ink = Ink {
    name: "white paint, Maxwell",
    index: "2.5",
    share: 0.15,
    thickness_um: 1.2,
    slab_um: 0.6,
    wavelengths_nm: &[620],
    wave: "unpolarised",
    period_um: 0.8,
    ..CLEAR
};

impl Ink {
    fn layer(&self, thickness: &str, rest: &str, realisations: usize) -> String {
        let Ink { index, binder, share, wavelengths_nm, wave, period_um, .. } = self;
        format!(
            "[layer]\nthickness_um = {thickness}\nperiod_um = {period_um}\nbinder.index = {binder}\n{rest}\n\
             [[pigment]]\nname = 'grains'\ndiameter_nm = 250\nvolume_fraction = {share}\nshare = 'scale_sizes'\n\
             index = {index}\n[paper]\nalbedo = 1.0\n[light]\nwavelengths_nm = {wavelengths_nm:?}\nwave = '{wave}'\n\
             [run]\nrealisations = {realisations}\n[resolution]\naccuracy = 3e-2\n"
        )
    }

    /// Rows of the spectra of layers composed of its slabs, its own thickness first.
    fn composed(&self, more_um: &[f64], realisations: usize) -> Value {
        self.composed_between(more_um, realisations, None)
    }

    /// As [`Ink::composed`], between half-spaces by a mixing rule.
    fn composed_between(&self, more_um: &[f64], realisations: usize, mixing: Option<MixingRule>) -> Value {
        let all: Vec<f64> = [self.thickness_um].iter().chain(more_um).copied().collect();
        let slabs = format!("composed = {{ slab_um = {} }}", self.slab_um);
        composed_between(&self.layer(&format!("{all:?}"), &slabs, realisations), mixing)
    }

    fn at(self, wavelengths_nm: &'static [u32]) -> Ink {
        Ink { wavelengths_nm, ..self }
    }
}

fn measure(level: Level, findings: &mut Findings) {
    let realisations = level.pick(8, 24);
    let stack = CLEAR.composed(&[20.0, 50.0, 75.0, 100.0], realisations);
    conserves(&stack, findings);
    half_spaces(CLEAR, stack, MixingRule::MaxwellGarnett, realisations, findings);
    let mut compared = Compared::default();
    let [both, red]: [&[u32]; 2] = level.pick([&[550], &[]], [&[450, 650], &[650]]);
    for ink in [CLEAR.at(both), DYED.at(both)] {
        compared.add(ink, realisations);
    }
    if level == Level::Full {
        let thick = [
            Ink { thickness_um: 4.0, slab_um: 2.0, ..CLEAR.at(both) },
            Ink { thickness_um: 8.0, ..DYED.at(both) },
            DARK.at(both),
            Ink { thickness_um: 4.0, ..DARK.at(both) },
            STRONG.at(both),
            Ink { thickness_um: 4.0, ..STRONG.at(red) },
        ];
        thick.into_iter().for_each(|ink| compared.add(ink, realisations));
        compared.add(Ink { thickness_um: 2.4, slab_um: 1.2, ..PAINT }, realisations);
        compared.add(PAINT, realisations);
        let paint = PAINT.composed(&[20.0], realisations);
        half_spaces(PAINT, paint, MixingRule::VolumeAverage, realisations, findings);
    }
    compared.judge(level, findings);
    for share in level.pick(&[0.02][..], &[0.02, 0.05, 0.1, 0.2]) {
        let stack =
            Ink { share: *share, thickness_um: 4.0, slab_um: 2.0, ..CLEAR }.composed(&[], realisations);
        medium::of_clear_spheres(*share, &stack["medium"][0], findings);
    }
}

/// The same slabs between half-spaces of another index: R and T of the layer of its own thickness and of 20 µm, which come
/// first in `own`, stay within their bars.
fn half_spaces(ink: Ink, own: Value, other: MixingRule, realisations: usize, findings: &mut Findings) {
    let both = [own, ink.composed_between(&[20.0], realisations, Some(other))];
    let index = both.each_ref().map(|own| own["medium"][0]["embedding_index"].as_f64().unwrap_or(f64::NAN));
    let mut farthest = 0.0_f64;
    for k in 0..2 {
        for light in ["normal", "45", "diffuse"] {
            for lobe in ["reflectance", "transmittance"] {
                let [[a, error], [b, _]] =
                    both.each_ref().map(|own| estimate(&own["spectra"][k][format!("{lobe}_{light}")]));
                farthest = farthest.max((a - b).abs() / error);
            }
        }
    }
    let [own, other] = index;
    findings.check(
        format!(
            "{}, half-spaces of index {own:.3} and {other:.3}: largest change of R or T over its bar",
            ink.name
        ),
        farthest,
        Bound::AtMost(HALF_SPACES),
        Reason::Significance,
        "the packings are the same, so that most of their scatter is common; the error bars include the cost of composing",
    );
    let [here, there] =
        both.each_ref().map(|own| estimate(&own["medium"][0]["kubelka_munk_scattering_per_um"]));
    findings.check(
        format!("{}: change of Kubelka and Munk's S over its bar", ink.name),
        (here[0] - there[0]).abs() / here[1],
        Bound::AtMost(HALF_SPACES),
        Reason::Significance,
        "S is counted with the n² of the medium itself, not with that of the half-spaces",
    );
    findings.check(
        format!("{}: distance of these half-spaces in index", ink.name),
        (own - other).abs(),
        Bound::AtLeast(0.01),
        Reason::Promise,
        "otherwise the comparison above says nothing",
    );
}

/// Change of a number over its bar that half-spaces may cause.
const HALF_SPACES: f64 = 2.0;

/// No light is lost in clear layers, however thick.
fn conserves(stack: &Value, findings: &mut Findings) {
    let rows = stack["spectra"].as_array().cloned().unwrap_or_default();
    let value = |row: &Value, name: &str| estimate(&row[name])[0];
    for row in &rows {
        let um = &row["thickness_um"];
        for light in ["normal", "45", "diffuse"] {
            let sum =
                value(row, &format!("reflectance_{light}")) + value(row, &format!("transmittance_{light}"));
            let because = "columns are scaled to R + T = 1 − A, and composing loses nothing: rounding of some hundred products";
            findings.identity(format!("R + T − 1 of {um} µm, {light}"), (sum - 1.0).abs(), 1e-7, because);
        }
        let because = "the furnace, through a layer that transmits little: rounding over T";
        let lost = (value(row, "natural_light") - 1.0).abs();
        findings.identity(format!("light lost on white paper, {um} µm"), lost, 1e-6, because);
    }
    let through: Vec<f64> = rows.iter().map(|row| 1.0 / value(row, "transmittance_diffuse")).collect();
    if let [.., a, b, c] = through[..] {
        let because = "clear grains: 1/T of diffuse light grows by the same for every slab; rounding of some hundred products";
        findings.identity(
            "1/T from 50 to 75 µm less that from 75 to 100 µm, relative",
            ((c - b) / (b - a) - 1.0).abs(),
            1e-5,
            because,
        );
    }
}
