//! Open joints and gradients: where grains are, and what that does to light.

use crate::claim::{Bound, Claim, Findings, Level, Reason};
use crate::studies::{checked, done};
use inkwave::ink::statistics::profile;
use inkwave::ink::{Packing, pack};

pub const CLAIM: Claim = Claim {
    id: "35-open-joints",
    statement: "The same ink twice with an open joint is one layer of the double thickness, and with a wall it lacks grains there; away from the faces the shares of a gradient are in the ratio asked for.",
    because: "Layers with open joints are packed together without a wall between them: centres of grains begin in their own layers, and about as many pass the joint either way; centres of a gradient are drawn from its profile between the walls and keep their depths.",
    file: file!(),
    measure,
};

/// An ink that is added grain by grain, and one whose grains move apart.
struct Ink {
    share: f64,
    grains: &'static str,
}

const DILUTE: Ink =
    Ink { share: 0.2, grains: "diameter_nm = 160\nshare = 'scale_sizes'\nindex = { n = 1.4, k = 0.1 }\n" };
const CROWDED: Ink = Ink { share: 0.3, grains: "diameter_nm = 150\nindex = { n = 1.62, k = 0.0 }\n" };
const HALF_UM: f64 = 0.5;
const LIGHT: &str = "[light]\nwavelengths_nm = [460, 620]\n[angles]\npolar_deg = [0, 45]\n";
const GRID: &str = "[resolution]\npoints_per_um = 16\nplanes_per_um = 24\n";

fn twice(ink: &Ink, joint: &str, realisations: usize) -> String {
    let layer = format!("thickness_um = {HALF_UM}\nbinder.index = 1.558\n");
    let Ink { share, grains } = ink;
    let pigment = format!("[[layer.pigment]]\nname = 'ink'\nvolume_fraction = {share}\n{grains}");
    format!(
        "[stack]\nperiod_um = 1.1\n[[layer]]\njoint = '{joint}'\n{layer}{pigment}[[layer]]\n{layer}{pigment}{LIGHT}{GRID}\
         [run]\nrealisations = {realisations}\nseed = 3\n"
    )
}

/// One layer of both thicknesses, with its share in words of the study.
fn once(ink: &Ink, share: &str, realisations: usize, seed: usize) -> String {
    format!(
        "[layer]\nperiod_um = 1.1\nthickness_um = {}\nbinder.index = 1.558\n[[pigment]]\nname = 'ink'\n{share}\n{}{LIGHT}{GRID}\
         [run]\nrealisations = {realisations}\nseed = {seed}\n",
        2.0 * HALF_UM,
        ink.grains
    )
}

fn packings(text: &str, count: usize) -> Vec<Packing> {
    let study = checked(text);
    (0..count).map(|r| pack(&study.packing_request(r), &mut ()).expect("a packing")).collect()
}

/// R and T with their errors at both wavelengths and angles.
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
    packings.iter().map(at).sum::<f64>() / (packings.len() as f64 * DILUTE.share)
}

/// Number of grains that touch the outer walls.
fn grains_at_walls(packings: &[Packing]) -> f64 {
    const NEAR_UM: f64 = 0.003;
    let touches = |packing: &Packing| {
        let ends = packing.grains().iter().map(|grain| grain.extent_um(2));
        ends.filter(|[low, high]| *low < NEAR_UM || *high > 2.0 * HALF_UM - NEAR_UM).count() as f64
    };
    packings.iter().map(touches).sum()
}

fn measure(level: Level, findings: &mut Findings) {
    let count = level.pick(24, 96);
    let open = share_at_joint(&packings(&twice(&DILUTE, "open", count), count));
    let wall = share_at_joint(&packings(&twice(&DILUTE, "wall", count), count));
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
        let gradient = once(&DILUTE, &format!("profile = [[0.0, {first}], [1.0, {last}]]"), count, 5);
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
    for ink in [&DILUTE, &CROWDED] {
        let realisations = level.pick(16, 64);
        let share = format!("volume_fraction = {}", ink.share);
        let joined = twice(ink, "open", realisations);
        let one_layer = once(ink, &share, realisations, 4);
        let two = grains_at_walls(&packings(&joined, realisations));
        let one = grains_at_walls(&packings(&one_layer, realisations));
        findings.check(
            format!("grains at the walls, of {} % twice with an open joint over one layer of the double thickness, their difference in errors", 100.0 * ink.share),
            (two - one).abs() / (two + one).sqrt(),
            Bound::AtMost(4.0),
            Reason::Significance,
            "two counts; of crowded layers 150 and more, of which a tenth was there when grains kept the depths at which they began",
        );
        let pairs = published(&joined).into_iter().zip(published(&one_layer));
        let z = pairs.map(|([a, s], [b, t])| ((a - b) / s.hypot(t)).abs()).fold(0.0, f64::max);
        findings.check(
            format!(
                "R and T of {} % twice with an open joint and once of the double thickness, in errors",
                100.0 * ink.share
            ),
            z,
            Bound::AtMost(4.5),
            Reason::Significance,
            "the largest of eight of Student's t, once in thousands",
        );
    }
}
