//! How much 95 % intervals hold: many pigments and noises, on a layer that is a coherent film,
//! so that only the statistics of the inversion are judged.

use super::near;
use super::outcome::FitOutcome;
use crate::fit::data::Data;
use crate::fit::load::{FitTask, load};
use crate::fit::prior::IndexPrior;
use crate::fit::response::Origin;
use crate::numerics::Draws;
use num_complex::Complex64;

const FIT: &str = "[base]\n[base.layer]\nthickness_um = 1.0\nbinder.index = 1.5\n[[base.pigment]]\nname = \"a\"\n\
                   diameter_nm = 200\nvolume_fraction = 0.3\n[base.light]\nfrom_nm = 400\nto_nm = 700\nstep_nm = 20\n\
                   [base.run]\nrealisations = 6\n[[measured]]\nfile = \"white.csv\"\nbacking = 0.85\n\
                   [[measured]]\nfile = \"black.csv\"\nbacking = 0.04\n";
/// Pigments, with one noise each.
const PIGMENTS: usize = 40;
/// Linearisations of a fit that starts near the truth.
const ROUNDS: usize = 4;

pub(super) fn task() -> FitTask {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("fit.toml");
    for (card, factor) in [("white.csv", 0.5), ("black.csv", 0.1)] {
        let rows = format!("wavelength_nm,reflectance\n400,{factor}\n700,{factor}\n");
        std::fs::write(folder.path().join(card), rows).unwrap();
    }
    std::fs::write(&path, FIT).unwrap();
    load(&path).expect("sound")
}

/// Three Lorentz lines, in UV, blue and the visible: causal, and none of the prior's family.
pub(in crate::fit) fn pigment(nm: &[f64], draws: &mut Draws) -> Vec<[f64; 2]> {
    let mut between = |from: f64, to: f64| draws.between(from, to);
    let constant = between(2.0, 2.4);
    let lines = [[220.0, 320.0, 0.1, 0.3], [380.0, 500.0, 0.03, 0.12], [430.0, 640.0, 0.01, 0.1]];
    let lines = lines.map(|[a, b, c, d]| [1e3 / between(a, b), between(c, d), between(0.15, 0.4)]);
    let index = |nm: &f64| {
        let w = 1e3 / nm;
        let line =
            |[c, strength, width]: &[f64; 3]| strength * c * c / Complex64::new(c * c - w * w, -width * w);
        let eta = (constant + lines.iter().map(line).sum::<Complex64>()).sqrt();
        [eta.re, eta.im]
    };
    nm.iter().map(index).collect()
}

/// Gauss–Newton from the truth on.
pub(super) fn fitted(task: &FitTask, truth: &[[f64; 2]]) -> FitOutcome {
    let prior = IndexPrior::new(task.settings.prior, task.wavelengths_nm(), task.binder_index(), false);
    let mut point = near(&prior, truth).unwrap();
    for round in 1.. {
        let prior = prior.adapted(&point);
        let response = Origin::Film.response(task, &task.measured, &prior.index(&point), 0.0).unwrap();
        let data = Data::new(task, &prior, &point, &response, &[0.0]);
        let (strength, step) = data.chosen().unwrap();
        if round == ROUNDS {
            return data.outcome(strength, &step, round);
        }
        point = step.unknowns;
    }
    unreachable!()
}

#[test]
fn intervals_hold_what_they_promise() {
    let mut task = task();
    let nm = task.wavelengths_nm().to_vec();
    let mut draws = Draws::new(5, 0);
    let mut inside = [0.0; 2];
    let mut chi = 0.0;
    for _ in 0..PIGMENTS {
        let truth = pigment(&nm, &mut draws);
        let exact = Origin::Film.spectra(&task, &task.measured, &truth, ([0.0; 2], 0.0)).unwrap();
        for (drawdown, exact) in task.measured.iter_mut().zip(exact) {
            let noisy = exact.values.iter().map(|x| x + 0.003 * draws.normal()).collect();
            drawdown.values = Some(noisy);
        }
        let fit = fitted(&task, &truth);
        chi += fit.chi_squared / (PIGMENTS * fit.data) as f64;
        for (row, truth) in fit.index.iter().zip(&truth) {
            let off = [row.n - truth[0], row.kappa - truth[1]];
            let errors = [row.n_error, row.kappa_error].map(|e| e.unwrap_or(0.0));
            (0..2).for_each(|i| inside[i] += f64::from(u8::from(off[i].abs() < 1.96 * errors[i])));
        }
    }
    let inside = inside.map(|x| x / (PIGMENTS * nm.len()) as f64);
    // Found: 0.995 for n and 0.958 for κ, χ² 0.52 a datum; four other seeds 0.98 to 0.998 and 0.94
    // to 0.96. Intervals of n are too wide: their covariance does not know that κ beyond the data
    // is nowhere negative. 40 pigments of about 6 independent intervals each are uncertain by 0.02.
    assert!((0.9..=0.99).contains(&inside[1]) && inside[0] >= 0.9, "inside 95 %: {inside:?}, χ² {chi}");
    assert!(chi < 0.8, "χ² for each datum: {chi}");
}
