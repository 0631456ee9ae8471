//! Stacks of films against the transfer matrix, and the solves that the claims on plane layers share.

use crate::claim::{Claim, Findings, Level};
use crate::formulas::films::{Film, amplitudes};
use crate::support::references;
use inkwave::numerics::Draws;
use inkwave::solve::{Gmres, Goal, Silent, Solver};
use inkwave::wave::Stratum;
use inkwave::wave::{Incidence, Mean, Media, Problem, Resolution, Scene, Scheme, Side};
use num_complex::Complex64;

pub const CLAIM: Claim = Claim {
    id: "02-multilayer",
    statement: "Any stack of absorbing films reflects and transmits as the transfer matrix says.",
    because: "Cells follow the films' faces, and each cell is solved exactly (P2 section 3; Born and Wolf 1.6).",
    file: file!(),
    measure,
};

/// (r, t) of films as the program solves them.
pub fn solved(half_spaces: [f64; 2], films: &[Film], wavelength_um: f64, polar_deg: f64) -> [Complex64; 2] {
    let strata = films
        .iter()
        .enumerate()
        .map(|(i, f)| Stratum { thickness_um: f.thickness_um, background: i })
        .collect();
    let scene = Scene { period_um: [0.5; 2], strata, bodies: Vec::new(), cut: false };
    let media = Media {
        incident: half_spaces[0].into(),
        exit: half_spaces[1].into(),
        backgrounds: films.iter().map(|f| f.index).collect(),
        inclusions: Vec::new(),
    };
    let incidence = Incidence { wavelength_um, polar_deg, azimuth_deg: 0.0, from: Side::Incident };
    let resolution = Resolution { nx: 1, ny: 1, cells: films.len().max(3), scheme: Scheme::default() };
    let problem =
        Problem::from_scene(&scene, &media, &incidence, resolution, Mean::default()).expect("films");
    let field =
        Gmres::default().solve(&problem, Goal::default(), &mut Silent).expect("nothing to iterate").field;
    let far = problem.far_field(&field);
    [far.specular().reflected, far.specular().transmitted]
}

fn measure(level: Level, findings: &mut Findings) {
    let mut draws = Draws::new(2, 0);
    let mut largest = 0.0f64;
    for _ in 0..level.pick(60, 1000) {
        let mut film = || Film {
            index: Complex64::new(draws.between(1.0, 2.6), draws.below(2) as f64 * draws.between(0.0, 0.5)),
            thickness_um: draws.between(0.001, 1.0),
        };
        let films: Vec<Film> = (0..6).map(|_| film()).collect();
        let below = draws.between(1.0, 2.0);
        let polar_deg = draws.between(0.0, 85.0);
        let want = amplitudes(1.0, &films, below.into(), 0.5, polar_deg);
        let got = solved([1.0, below], &films, 0.5, polar_deg);
        largest = largest.max((got[0] - want[0]).norm()).max((got[1] - want[1]).norm());
    }
    findings.identity("random stacks of six films", largest, 1e-12, "rounding of some 1000 operations");
    let uniform = references().iter().filter(|r| r.is_uniform());
    let error = uniform.map(|r| {
        let resolution = r.resolution(1, 12, Scheme::default());
        r.largest_error(&crate::support::solve_at(&r.case, resolution, 1e-12).far)
    });
    let error = error.fold(0.0, f64::max);
    findings.identity(
        "slabs and stacks of the references",
        error,
        1e-13,
        "rounding; the references have 15 digits",
    );
}
