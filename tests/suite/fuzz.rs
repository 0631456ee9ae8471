//! Slips of the pen by the thousand, with a fixed budget and fixed seeds: parsers and solves give a result or say why not,
//! and never panic.

use inkwave::input::case::Case;
use inkwave::input::check::check;
use inkwave::input::file::StudyFile;
use inkwave::input::read::read;
use inkwave::input::tree::{parse_json, parse_toml};
use inkwave::material::spectra::Spectrum;
use inkwave::solve::accuracy::Task;
use inkwave::solve::{Coverages, Goal, Registry, Silent};
use inkwave::wave::{Mean, Resolution, Scheme};
use proptest::prelude::*;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};
use serde_json::json;
use std::path::Path;

const STUDY: &str = include_str!("../../examples/yellow.toml");

/// Runs `test` on `cases` inputs, the same ones every time.
fn fuzz<S: Strategy>(cases: u32, inputs: S, test: impl Fn(S::Value) -> Result<(), TestCaseError>) {
    let config = Config { cases, failure_persistence: None, ..Config::default() };
    let mut runner = TestRunner::new_with_rng(config, TestRng::deterministic_rng(RngAlgorithm::ChaCha));
    runner.run(&inputs, test).unwrap_or_else(|failure| panic!("{failure}"));
}

/// Pieces that documents are made of, and some that they are not.
fn piece() -> impl Strategy<Value = String> {
    let words = [
        "",
        "=",
        "[",
        "]",
        "[[",
        "{",
        "}",
        "\"",
        "'",
        "\n",
        ",",
        "-",
        ".",
        "0",
        "1e308",
        "-1e308",
        "nan",
        "inf",
        "1e-320",
        "99999999999999999999",
        "true",
        "null",
        "pigment",
        "layer",
        "index",
        "k",
        "n_in",
        "csv",
        "\u{0}",
        "é",
        "\u{301}",
        "\u{feff}",
        "0x10",
        "1979-05-27",
        "[[pigment]]",
        "# ",
        "\\u0000",
    ];
    prop_oneof![prop::sample::select(words.to_vec()).prop_map(str::to_owned), ".{0,4}"]
}

/// A text with some stretches replaced by pieces.
fn slips(text: &'static str) -> impl Strategy<Value = String> {
    prop::collection::vec((any::<prop::sample::Index>(), 0..12usize, piece()), 1..5).prop_map(move |slips| {
        let mut letters: Vec<char> = text.chars().collect();
        for (place, length, piece) in slips {
            let start = place.index(letters.len().max(1)).min(letters.len());
            let end = (start + length).min(letters.len());
            letters.splice(start..end, piece.chars());
        }
        letters.into_iter().collect()
    })
}

#[test]
fn studies_with_slips_are_read_or_refused_with_words() {
    fuzz(3000, slips(STUDY), |text| {
        let faults = match parse_toml(&text) {
            Err(fault) => return Ok(prop_assert!(!fault.in_words(&text).is_empty())),
            Ok(table) => match read::<StudyFile>(table.into()) {
                Ok(file) => check(&file, Path::new("."), "fuzz").err().unwrap_or_default(),
                Err(faults) => faults,
            },
        };
        for fault in faults {
            prop_assert!(
                !fault.found.is_empty() && !fault.allowed.is_empty() && !fault.remedy.is_empty(),
                "{fault:?}"
            );
        }
        Ok(())
    });
}

const CASE: &str = r#"{ "wavelength": 0.55, "sigma_deg": 20, "phi_deg": 5, "L": 0.5, "H": 0.6, "n_in": 1.0, "n_out": 1.2,
  "eta_binder": [1.558, 0.01], "spheres": [{ "center": [0.2, 0.2, 0.3], "radius": 0.15, "eta": [1.4, 0.1] }],
  "cylinders": [{ "x": 0.1, "z": 0.55, "radius": 0.01, "eta": [1.4, 0.1] }] }"#;

#[test]
fn cases_with_slips_are_read_or_refused_with_words() {
    fuzz(3000, slips(CASE), |text| {
        for toml in [false, true] {
            if let Err(error) = Case::parse(&text, toml) {
                prop_assert!(error.to_string().len() > 10);
            }
        }
        Ok(prop_assert!(
            parse_json(&text).map_err(|fault| fault.in_words(&text)).err() != Some(String::new())
        ))
    });
}

#[test]
fn tables_with_slips_are_read_or_refused_with_words() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("table.csv");
    fuzz(500, slips("# mine\nwavelength_nm,kappa,n\n400,0.1,1.4\n500,0.3,1.5\n600,0.2,1.5\n"), |text| {
        std::fs::write(&path, &text).expect("a writable folder");
        match Spectrum::from_csv(&path, None) {
            Ok(spectrum) => prop_assert!(
                spectrum.index(0.5).is_ok_and(|eta| eta.is_finite()) || spectrum.index(0.5).is_err()
            ),
            Err(error) => prop_assert!(!error.to_string().is_empty()),
        }
        Ok(())
    });
}

/// Numbers of every size, usual ones more often.
fn number(usual: std::ops::Range<f64>) -> impl Strategy<Value = f64> {
    prop_oneof![8 => usual, 1 => -12.0..12.0f64, 1 => prop::sample::select(vec![0.0, 1e-300, 1e-9, 1e9, 1e300])]
}

#[test]
fn solves_of_wild_cases_are_physical_or_refused() {
    let numbers = (
        (number(0.3..1.0), number(0.0..80.0), number(0.2..0.8), number(0.3..0.8), number(1.0..2.0)),
        (number(1.0..2.5), number(0.0..0.5), number(0.05..0.15), number(0.0..0.5), number(0.2..0.4)),
        (number(0.3..3.0), number(0.0..4.0), 0..6usize, 0..5usize, 3..9usize, 3..9usize),
    );
    fuzz(
        150,
        numbers,
        |(
            (wavelength, sigma, period, height, outside),
            (n, k, radius, x, z),
            (gn, gk, solver, scheme, nx, cells),
        )| {
            let case = json!({
                "wavelength": wavelength, "sigma_deg": sigma, "L": period, "H": height, "n_out": outside,
                "eta_binder": [n, k], "spheres": [{ "center": [x, 0.1, z], "radius": radius, "eta": [gn, gk] }],
            });
            let Ok(case) = Case::parse(&case.to_string(), false) else { return Ok(()) };
            let scheme =
                [Scheme::Tents, Scheme::Quadratic, Scheme::Cubic, Scheme::Quartic, Scheme::SecondDifference]
                    [scheme];
            let solver =
                Registry::default().build(inkwave::solve::SolverChoice::NAMES[solver]).expect("a name");
            let task = Task {
                coverages: &Coverages::of(&case.scene),
                media: &case.media,
                incidence: &case.incidence,
                mean: Mean { depends_on_z: true, absorbing: solver.name() != "relaxation" },
                scheme,
                solver: &*solver,
                goal: Goal { tolerance: 1e-5, max_applications: 300 },
                memory: 5e8,
            };
            if let Ok(done) = task.solve_with_estimate(Resolution { nx, ny: nx, cells, scheme }, &mut Silent)
            {
                let totals = {
                    let far = done.far_field();
                    [far.reflectance, far.transmittance, far.absorptance]
                };
                prop_assert!(totals.iter().all(|t| (-0.06..=1.06).contains(t)), "{totals:?}");
                prop_assert!(done.error_estimate.is_finite());
            }
            Ok(())
        },
    );
}
