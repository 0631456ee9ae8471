//! Open joints and gradients: where grains are, and what that does to light.

use crate::claim::{Bound, Claim, Findings, Level, Reason};
use crate::studies::{checked, done};
use inkwave::ink::statistics::profile;
use inkwave::ink::{Packing, pack};

pub const CLAIM: Claim = Claim {
    id: "35-open-joints",
    statement: "The same ink twice with an open joint is one layer of the double thickness, and with a wall it lacks grains there; away from the faces the shares of a gradient are in the ratio asked for.",
    because: "Layers with open joints are packed together, with the centres of their grains in their own layers and no wall between them; centres of a gradient are drawn from its profile between the walls and keep their depths.",
    file: file!(),
    measure,
};

const SHARE: f64 = 0.2;
const HALF_UM: f64 = 0.5;
const INK: &str = "diameter_nm = 160\nshare = 'scale_sizes'\nindex = { n = 1.4, k = 0.1 }\n";
const LIGHT: &str = "[light]\nwavelengths_nm = [460, 600]\n[angles]\npolar_deg = [0]\n";
const GRID: &str = "[resolution]\npoints_per_um = 16\nplanes_per_um = 24\n";

fn twice(joint: &str, realisations: usize) -> String {
    let layer = format!("thickness_um = {HALF_UM}\nbinder.index = 1.558\n");
    let pigment = format!("[[layer.pigment]]\nname = 'ink'\nvolume_fraction = {SHARE}\n{INK}");
    format!(
        "[stack]\nperiod_um = 1.1\n[[layer]]\njoint = '{joint}'\n{layer}{pigment}[[layer]]\n{layer}{pigment}{LIGHT}{GRID}\
         [run]\nrealisations = {realisations}\nseed = 3\n"
    )
}

fn once(pigment: &str, realisations: usize, seed: usize) -> String {
    format!(
        "[layer]\nperiod_um = 1.1\nthickness_um = {}\nbinder.index = 1.558\n[[pigment]]\n{pigment}\n{INK}{LIGHT}{GRID}\
         [run]\nrealisations = {realisations}\nseed = {seed}\n",
        2.0 * HALF_UM
    )
}

fn packings(text: &str, count: usize) -> Vec<Packing> {
    let study = checked(text);
    (0..count).map(|r| pack(&study.packing_request(r), &mut ()).expect("a packing")).collect()
}

/// R and T with their errors at both wavelengths.
fn published(text: &str) -> Vec<[f64; 2]> {
    let results = done(text).results;
    let rows = results["spectra"].as_array().expect("spectra");
    let number = |value: &serde_json::Value| value.as_f64().expect("a number");
    let of = |row: &serde_json::Value| {
        ["reflectance", "transmittance"]
            .map(|key| [number(&row[key]["value"]), number(&row[key]["standard_error"])])
    };
    rows.iter().flat_map(of).collect()
}

/// Mean share of all grains within a tenth of a layer of the joint, over the mean of the layers.
fn share_at_joint(packings: &[Packing]) -> f64 {
    const SLICES: usize = 10;
    let at = |packing: &Packing| {
        let slices = profile(packing, SLICES);
        let total = |slice: &Vec<f64>| slice.iter().sum::<f64>();
        0.5 * (total(&slices[SLICES - 1]) + total(&slices[SLICES]))
    };
    packings.iter().map(at).sum::<f64>() / (packings.len() as f64 * SHARE)
}

fn measure(level: Level, findings: &mut Findings) {
    let count = level.pick(24, 96);
    let open = share_at_joint(&packings(&twice("open", count), count));
    let wall = share_at_joint(&packings(&twice("wall", count), count));
    findings.check(
        "share of grains at an open joint, over that of the layers",
        open,
        Bound::Within([0.85, 1.3]),
        Reason::Significance,
        "24 cells hold some 200 grains there, ± 7 %; walls elsewhere push up to a tenth of the grains inwards",
    );
    findings.check(
        "share of grains at a wall",
        wall,
        Bound::AtMost(0.6),
        Reason::Identity,
        "the outermost 50 nm of spheres of 160 nm hold less than half of their share",
    );
    for [first, last] in [[0.1, 0.3], [0.4, 0.2]] {
        let gradient = once(&format!("name = 'ink'\nprofile = [[0.0, {first}], [1.0, {last}]]"), count, 5);
        let all = packings(&gradient, count);
        // sixths away from the walls, where a sphere's volume about its centre leaves a linear profile as it is
        let share = |sixth: usize| all.iter().map(|packing| profile(packing, 6)[sixth][0]).sum::<f64>();
        let asked = |sixth: f64| first + (last - first) * (sixth + 0.5) / 6.0;
        let most = level.pick(0.15, 0.09);
        findings.check(
            format!("shares of a gradient from {first} to {last} in the fifth and the second sixth of its depth, their ratio over that asked for"),
            share(4) / share(1) * asked(1.0) / asked(4.0),
            Bound::Within([1.0 - most, 1.0 + most]),
            Reason::Significance,
            "24 cells hold some 400 and 700 grains there, whose depths are drawn one by one: 6 % of the ratio, 3 % in 96 cells",
        );
    }
    let realisations = level.pick(16, 64);
    let two = published(&twice("open", realisations));
    let one = published(&once(&format!("name = 'ink'\nvolume_fraction = {SHARE}"), realisations, 4));
    let z = two.iter().zip(&one).map(|([a, s], [b, t])| ((a - b) / s.hypot(*t)).abs()).fold(0.0, f64::max);
    findings.check(
        "R and T of the ink twice with an open joint and once of the double thickness, in errors",
        z,
        Bound::AtMost(4.5),
        Reason::Significance,
        "the largest of four of Student's t, once in thousands",
    );
}
