//! Clear stacks against characteristic matrices, for every light.

use crate::claim::{Claim, Findings, Level};
use crate::formulas::films::Film;
use crate::formulas::stacks::totals;
use crate::studies::{done, row};
use inkwave::numerics::Draws;
use num_complex::Complex64;
use std::fmt::Write;

pub const CLAIM: Claim = Claim {
    id: "33-clear-stacks",
    statement: "A study of [[layer]] without grains publishes R and T of the films in their order, for scalar, s, p and unpolarised light.",
    because: "Every layer is a stratum with its own binder, solved exactly, and its coherent film is the same stack (Born and Wolf 1.6).",
    file: file!(),
    measure,
};

const WAVELENGTHS_NM: [f64; 2] = [430.0, 610.0];
const ANGLES_DEG: [f64; 3] = [0.0, 35.0, 70.0];

fn measure(level: Level, findings: &mut Findings) {
    let mut draws = Draws::new(33, 0);
    let mut largest = 0.0_f64;
    let mut smallest_swap = f64::INFINITY;
    for case in 0..level.pick(4, 40) {
        let wave = ["scalar", "s", "p", "unpolarised"][case % 4];
        let films: Vec<Film> = (0..3)
            .map(|_| Film {
                index: Complex64::new(draws.between(1.3, 2.2), draws.between(0.0, 0.2)),
                thickness_um: draws.between(0.05, 0.8),
            })
            .collect();
        let exit = draws.between(1.0, 1.6);
        let mut swapped = films.clone();
        swapped.reverse();
        let published = published(wave, &films, exit);
        let mut moved = 0.0_f64;
        for (row, (nm, deg)) in published.iter().zip(places()) {
            let of = |films: &[Film]| in_light(wave, films, exit, nm, deg);
            let [r, t] = of(&films);
            largest = largest.max((row[0] - r).abs()).max((row[1] - t).abs());
            moved = moved.max((r - of(&swapped)[0]).abs());
        }
        smallest_swap = smallest_swap.min(moved);
    }
    findings.identity("R and T of random stacks of three films", largest, 1e-10, "rounding of both formulas");
    findings.check(
        "R moved by the reverse order, the least of all stacks: the order is seen",
        smallest_swap,
        crate::claim::Bound::AtLeast(1e-4),
        crate::claim::Reason::Identity,
        "a million times the bound above",
    );
}

fn places() -> impl Iterator<Item = (f64, f64)> {
    WAVELENGTHS_NM.into_iter().flat_map(|nm| ANGLES_DEG.map(|deg| (nm, deg)))
}

fn in_light(wave: &str, films: &[Film], exit: f64, nm: f64, deg: f64) -> [f64; 2] {
    let of = |is_p| totals([1.0, exit], films, 1e-3 * nm, deg, is_p);
    match wave {
        "p" => of(true),
        "unpolarised" => [0, 1].map(|i| 0.5 * (of(false)[i] + of(true)[i])),
        _ => of(false),
    }
}

/// R and T that a study of these films publishes, in the order of [`places`].
fn published(wave: &str, films: &[Film], exit: f64) -> Vec<[f64; 2]> {
    let mut text = format!("[stack]\nindex_out = {exit}\n");
    for Film { index, thickness_um } in films {
        let binder = format!("{{ n = {}, k = {} }}", index.re, index.im);
        write!(text, "[[layer]]\nthickness_um = {thickness_um}\nbinder.index = {binder}\n").expect("text");
    }
    write!(
        text,
        "[light]\nwavelengths_nm = {WAVELENGTHS_NM:?}\nwave = '{wave}'\n[angles]\npolar_deg = {ANGLES_DEG:?}\n"
    )
    .expect("text");
    let results = done(&text).results;
    let of = |(nm, deg): (f64, f64)| {
        let row = row(&results, nm, deg);
        ["reflectance", "transmittance"].map(|key| row[key]["value"].as_f64().expect("a number"))
    };
    places().map(of).collect()
}
