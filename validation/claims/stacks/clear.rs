//! Clear stacks against characteristic matrices, for every light.

use crate::claim::{Claim, Findings, Level};
use crate::formulas::films::Film;
use crate::formulas::stacks::{absorbed, totals};
use crate::studies::{done, row};
use inkwave::numerics::Draws;
use num_complex::Complex64;
use serde_json::Value;
use std::fmt::Write;

pub const CLAIM: Claim = Claim {
    id: "33-clear-stacks",
    statement: "A study of [[layer]] without grains publishes R and T of the films in their order and what each of them absorbs, for scalar, s, p and unpolarised light.",
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
    let mut kept_wrongly = 0.0_f64;
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
        let results = published(wave, &films, exit);
        let mut moved = 0.0_f64;
        for (nm, deg) in places() {
            let row = row(&results, nm, deg);
            let row =
                ["reflectance", "transmittance"].map(|key| row[key]["value"].as_f64().expect("a number"));
            for (got, want) in kept_by_layers(&results, nm, deg).iter().zip(kept(wave, &films, exit, nm, deg))
            {
                kept_wrongly = kept_wrongly.max((got - want).abs());
            }
            let of = |films: &[Film]| in_light(wave, films, exit, nm, deg);
            let [r, t] = of(&films);
            largest = largest.max((row[0] - r).abs()).max((row[1] - t).abs());
            moved = moved.max((r - of(&swapped)[0]).abs());
        }
        smallest_swap = smallest_swap.min(moved);
    }
    findings.identity("R and T of random stacks of three films", largest, 1e-10, "rounding of both formulas");
    findings.identity(
        "what every film of these stacks absorbs",
        kept_wrongly,
        1e-10,
        "rounding of both formulas",
    );
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

/// What every film absorbs in a light.
fn kept(wave: &str, films: &[Film], exit: f64, nm: f64, deg: f64) -> Vec<f64> {
    let of = |is_p| absorbed([1.0, exit], films, 1e-3 * nm, deg, is_p);
    match wave {
        "p" => of(true),
        "unpolarised" => of(false).into_iter().zip(of(true)).map(|(s, p)| 0.5 * (s + p)).collect(),
        _ => of(false),
    }
}

/// What a study publishes of it, in the order of its layers.
fn kept_by_layers(results: &Value, nm: f64, deg: f64) -> Vec<f64> {
    let rows = results["absorbed"].as_array().expect("what layers absorb");
    let here = |row: &&Value| row["wavelength_nm"] == nm && row["polar_deg"] == deg;
    let share = |row: &Value| row["absorptance"]["value"].as_f64().expect("a number");
    let all: Vec<f64> = rows.iter().filter(here).map(share).collect();
    assert_eq!(all.len(), 3, "a row a layer");
    all
}

/// The results of a study of these films.
fn published(wave: &str, films: &[Film], exit: f64) -> Value {
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
    done(&text).results
}
