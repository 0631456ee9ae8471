//! Stacks with grains against the same grains in one layer, and against a scene built by hand.

use crate::claim::{Claim, Findings, Level};
use crate::studies::{checked, done};
use inkwave::ink::{Grain, pack};
use inkwave::solve::{Gmres, Goal, Silent, Solver};
use inkwave::wave::{
    Body, BodyShape, Incidence, Mean, Media, Problem, Resolution, Scene, Scheme, Side, Stratum,
};
use num_complex::Complex64;
use std::fmt::Write;

pub const CLAIM: Claim = Claim {
    id: "34-placed-stacks",
    statement: "Layers of grains lie where [[layer]] puts them: over one binder a stack equals one layer with the same grains in a file, a varnish of the binder's index equals a thicker binder, and two inks in two binders equal a scene built by hand; what the layers absorb is absorbed where the absorbing grains are.",
    because: "A stack is one scene: a stratum and a background for every layer, and grains that are moved down by the layers before theirs.",
    file: file!(),
    measure,
};

const BINDER: f64 = 1.558;
const OTHER: f64 = 1.42;
const PERIOD_UM: f64 = 0.9;
const INKS: [(Complex64, f64, f64, f64); 2] =
    [(Complex64::new(1.4, 0.1), 200.0, 0.2, 0.4), (Complex64::new(2.0, 0.0), 240.0, 0.12, 0.5)];
const VARNISH_UM: f64 = 0.3;
const NM: f64 = 470.0;

/// Everything but the layers.
fn rest(seed: usize) -> String {
    format!(
        "[light]\nwavelengths_nm = [{NM}]\n[angles]\npolar_deg = [0, 40]\n[run]\nrealisations = 1\nseed = {seed}\n\
         [resolution]\npoints_per_um = 24\nplanes_per_um = 48\n"
    )
}

/// A clear layer over two inks.
fn stack(binders: [f64; 3], seed: usize) -> String {
    let mut text = format!("[stack]\ncell = 'fixed'\nperiod_um = {PERIOD_UM}\n");
    let clear =
        format!("[[layer]]\nname = 'varnish'\nthickness_um = {VARNISH_UM}\nbinder.index = {}\n", binders[0]);
    text.push_str(&clear);
    for (i, (index, nm, share, um)) in INKS.into_iter().enumerate() {
        let grains = format!("diameter_nm = {nm}\nvolume_fraction = {share}\nshare = 'scale_sizes'");
        let index = format!("index = {{ n = {}, k = {} }}", index.re, index.im);
        write!(
            text,
            "[[layer]]\nthickness_um = {um}\nbinder.index = {}\n[[layer.pigment]]\nname = 'p{i}'\n{grains}\n{index}\n",
            binders[i + 1]
        )
        .expect("text");
    }
    text + &rest(seed)
}

/// The grains of the stack, in the order of their packing.
fn grains(seed: usize) -> Vec<Grain> {
    let request = checked(&stack([BINDER; 3], seed)).packing_request(0);
    // each layer packed alone and moved by hand, in order not to trust what packs the stack
    let mut all = Vec::new();
    let mut top_um = 0.0;
    let mut first = 0;
    for layer in &request.layers {
        let packing = pack(&layer.request, &mut ()).expect("a packing");
        for grain in packing.grains() {
            let mut grain = grain.clone();
            grain.spheres.iter_mut().for_each(|sphere| sphere.center_um[2] += top_um);
            grain.pigment += first;
            all.push(grain);
        }
        top_um += layer.request.thickness_um;
        first += layer.request.pigments.len();
    }
    all
}

fn thickness_um() -> f64 {
    VARNISH_UM + INKS.iter().map(|ink| ink.3).sum::<f64>()
}

/// One layer of the binder with the same grains in a file.
fn one_layer(seed: usize, folder: &std::path::Path) -> String {
    let mut csv = "x_um,y_um,z_um,radius_um,pigment\n".to_owned();
    for grain in grains(seed) {
        let sphere = grain.spheres[0];
        let [x, y, z] = sphere.center_um;
        writeln!(csv, "{x},{y},{z},{},p{}", sphere.radius_um, grain.pigment).expect("text");
    }
    let path = folder.join("grains.csv");
    std::fs::write(&path, csv).expect("written");
    let mut text = format!(
        "[layer]\ncell = 'fixed'\nperiod_um = {PERIOD_UM}\nthickness_um = {}\nbinder.index = {BINDER}\nmicrostructure.spheres = '{}'\n",
        thickness_um(),
        path.display()
    );
    for (i, (index, ..)) in INKS.into_iter().enumerate() {
        let index = format!("index = {{ n = {}, k = {} }}", index.re, index.im);
        writeln!(text, "[[pigment]]\nname = 'p{i}'\n{index}").expect("text");
    }
    text + &rest(seed)
}

/// R, T and A at normal incidence of a study, and what of A its layers absorb.
fn published(text: &str) -> ([f64; 3], Vec<f64>) {
    let results = done(text).results;
    let row = &results["spectra"][0];
    assert_eq!(row["polar_deg"], 0.0);
    let totals = ["reflectance", "transmittance", "absorptance"];
    let totals = totals.map(|key| row[key]["value"].as_f64().expect("a number"));
    let rows = results["absorbed"].as_array().cloned().unwrap_or_default();
    let normal = rows.iter().filter(|row| row["polar_deg"] == 0.0);
    (totals, normal.map(|row| row["absorptance"]["value"].as_f64().expect("a number")).collect())
}

/// R and T at normal incidence of a scene built by hand, on a grid of its own.
fn by_hand(binders: [f64; 3], seed: usize) -> [f64; 2] {
    let thicknesses = [VARNISH_UM, INKS[0].3, INKS[1].3];
    let strata = thicknesses.into_iter().enumerate();
    let strata = strata.map(|(background, thickness_um)| Stratum { thickness_um, background }).collect();
    let body = |grain: Grain| Body::new(BodyShape::Balls(grain.spheres), grain.pigment);
    let bodies = grains(seed).into_iter().map(body).collect();
    let scene = Scene { period_um: [PERIOD_UM; 2], strata, bodies, cut: false };
    let media = Media {
        incident: 1.0.into(),
        exit: 1.0.into(),
        backgrounds: binders.map(Complex64::from).to_vec(),
        inclusions: INKS.map(|ink| ink.0).to_vec(),
    };
    let incidence =
        Incidence { wavelength_um: 1e-3 * NM, polar_deg: 0.0, azimuth_deg: 0.0, from: Side::Incident };
    let resolution = Resolution { nx: 25, ny: 25, cells: 24, scheme: Scheme::default() };
    let problem =
        Problem::from_scene(&scene, &media, &incidence, resolution, Mean::default()).expect("a stack");
    let goal = Goal { tolerance: 1e-7, ..Goal::default() };
    let field = Gmres::default().solve(&problem, goal, &mut Silent).expect("converges").field;
    let far = problem.far_field(&field);
    [far.reflectance, far.transmittance]
}

fn totals([r, t, _]: [f64; 3]) -> [f64; 2] {
    [r, t]
}

fn difference(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).abs().max((a[1] - b[1]).abs())
}

fn measure(level: Level, findings: &mut Findings) {
    let folder = tempfile::tempdir().expect("a folder");
    let mut one = 0.0_f64;
    let mut two = 0.0_f64;
    let mut swapped = f64::INFINITY;
    let mut unkept = 0.0_f64;
    let mut unbalanced = 0.0_f64;
    for seed in 1..=level.pick(1, 6) {
        let (in_stack, _) = published(&stack([BINDER; 3], seed));
        one = one.max(difference(totals(in_stack), totals(published(&one_layer(seed, folder.path())).0)));
        let binders = [BINDER, OTHER, 1.6];
        let (all, layers) = published(&stack(binders, seed));
        // the first ink absorbs, the varnish and the second ink do not
        unkept = unkept.max((layers[1] - all[2]).abs()).max(layers[0].abs()).max(layers[2].abs());
        unbalanced = unbalanced.max((all.iter().sum::<f64>() - 1.0).abs());
        let of_two = totals(all);
        two = two.max(difference(of_two, by_hand(binders, seed)));
        let order = by_hand([BINDER, 1.6, OTHER], seed);
        swapped = swapped.min(difference(of_two, order));
    }
    findings.check(
        "a varnish and two inks over one binder, against one layer with the same grains in a file",
        one,
        crate::claim::Bound::AtMost(1e-4),
        crate::claim::Reason::Promise,
        "nodes of the grid lie on the joints of the stack, not on those of the layer: the grid's error",
    );
    findings.check(
        "two inks in two binders, against a scene built by hand on another grid",
        two,
        crate::claim::Bound::AtMost(2e-3),
        crate::claim::Reason::Promise,
        "both grids' errors",
    );
    findings.check(
        "absorptance of the layers, where only the first ink absorbs",
        unkept,
        crate::claim::Bound::AtMost(1e-10),
        crate::claim::Reason::Identity,
        "losses are summed cell by cell, and a cell has one binder: rounding",
    );
    findings.check(
        "R + T + A of the stack, less 1",
        unbalanced,
        crate::claim::Bound::AtMost(1e-4),
        crate::claim::Reason::Identity,
        "the solver's residual, 1e-5 and less, amplified tenfold at most",
    );
    findings.check(
        "the binders in the wrong order, against the same scene",
        swapped,
        crate::claim::Bound::AtLeast(5e-3),
        crate::claim::Reason::Identity,
        "the order is seen beyond the grids' errors",
    );
}
