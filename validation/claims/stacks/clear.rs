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
    statement: "A study of [[layer]] without grains publishes R and T of the films in their order and what each of them absorbs, for scalar, s, p and unpolarised light; over a gap to a paper, whichever film is behind, what both send back.",
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
    over_a_gap(level, findings);
}

const ALBEDO: f64 = 0.85;
/// Cuts of the means over Lambertian light.
const CUTS: usize = 1000;

/// Two films, of which one absorbs, over a gap to a paper, in both orders.
fn over_a_gap(level: Level, findings: &mut Findings) {
    let mut draws = Draws::new(33, 1);
    let mut largest = 0.0_f64;
    let mut smallest_swap = f64::INFINITY;
    for case in 0..level.pick(2, 12) {
        let wave = ["scalar", "unpolarised"][case % 2];
        let ink = Film {
            index: Complex64::new(draws.between(1.4, 1.7), draws.between(0.04, 0.1)),
            thickness_um: draws.between(0.4, 0.8),
        };
        let clear = Film { index: draws.between(2.0, 2.5).into(), thickness_um: draws.between(0.05, 0.1) };
        let mut seen = Vec::new();
        for films in [[ink, clear], [clear, ink]] {
            let results = on_paper(wave, &films);
            for nm in WAVELENGTHS_NM {
                let row = row(&results, nm, 0.0);
                let factor = |key: &str| row[key]["value"].as_f64().expect("a factor");
                let [natural, lit_at_45] = series(wave, &films, nm);
                largest = largest
                    .max((factor("natural_light") - natural).abs())
                    .max((factor("lit_at_45") - lit_at_45).abs());
                seen.push(lit_at_45);
            }
        }
        let waves = WAVELENGTHS_NM.len();
        let moved = (0..waves).map(|w| (seen[w] - seen[waves + w]).abs()).fold(0.0, f64::max);
        smallest_swap = smallest_swap.min(moved);
    }
    findings.identity(
        "reflectance factors of two films over a gap to a paper, in both orders",
        largest,
        3e-6,
        "the midpoint rule of the means over Lambertian light",
    );
    findings.check(
        "the 45:0 factor moved by the reverse order, the least of all pairs: what is behind is seen",
        smallest_swap,
        crate::claim::Bound::AtLeast(1e-3),
        crate::claim::Reason::Identity,
        "a thousand times the bound above",
    );
}

/// What natural light and light from 45° come to along the normal: R + T̄ g T, and T(45°) g T, with g of light that goes back and
/// forth between paper and films.
fn series(wave: &str, films: &[Film], nm: f64) -> [f64; 2] {
    let behind: Vec<Film> = films.iter().rev().copied().collect();
    // ∫ 2 f cos θ d(cos θ) by the midpoint rule
    let mean = |films: &[Film]| {
        let cosines = (0..CUTS).map(|cut| (cut as f64 + 0.5) / CUTS as f64);
        cosines.fold([0.0; 2], |sum, cosine| {
            let at = in_light(wave, films, 1.0, nm, cosine.acos().to_degrees());
            [0, 1].map(|i| sum[i] + 2.0 * cosine * at[i] / CUTS as f64)
        })
    };
    let back = ALBEDO / (1.0 - ALBEDO * mean(&behind)[0]);
    let [reflected, passed] = in_light(wave, films, 1.0, nm, 0.0);
    let [_, passed_at_45] = in_light(wave, films, 1.0, nm, 45.0);
    [reflected + mean(films)[1] * back * passed, passed_at_45 * back * passed]
}

/// The results of a study of films over a gap to a paper.
fn on_paper(wave: &str, films: &[Film]) -> Value {
    let layers = layers_in_toml(films);
    let light = light_in_toml(wave);
    done(&format!("{layers}[paper]\nalbedo = {ALBEDO}\n{light}[angles]\ncount = 4\n")).results
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
    let layers = layers_in_toml(films);
    let light = light_in_toml(wave);
    let text = format!("[stack]\nindex_out = {exit}\n{layers}{light}[angles]\npolar_deg = {ANGLES_DEG:?}\n");
    done(&text).results
}

fn layers_in_toml(films: &[Film]) -> String {
    let mut text = String::new();
    for Film { index, thickness_um } in films {
        let binder = format!("{{ n = {}, k = {} }}", index.re, index.im);
        write!(text, "[[layer]]\nthickness_um = {thickness_um}\nbinder.index = {binder}\n").expect("text");
    }
    text
}

fn light_in_toml(wave: &str) -> String {
    format!("[light]\nwavelengths_nm = {WAVELENGTHS_NM:?}\nwave = '{wave}'\n")
}
