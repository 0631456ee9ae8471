//! Statistics of a fit: what is minimised, the data left for a verdict, and errors of few cells.

use super::coverage_tests::{pigment, task};
use super::outcome::Trust;
use super::{Forecast, near, on_card};
use crate::fit::file::PriorName;
use crate::fit::law::{Data, few_cells};
use crate::fit::prior::IndexPrior;
use crate::fit::response::{Origin, Response};
use crate::numerics::Draws;
use crate::solve::accuracy::grid_error::GridError;
use faer::Mat;
use faer::linalg::solvers::Solve;
use statrs::distribution::StudentsT;
use statrs::statistics::Distribution;

/// Six replicates of every value that scatter alike on both cards: strongly correlated errors.
fn scattered(mut response: Response) -> Response {
    for (card, replicates) in response.replicates.iter_mut().enumerate() {
        *replicates = (0..6)
            .map(|r| {
                let common = 0.004 * (1.7 * f64::from(r)).sin();
                let own = |w: usize| 0.001 * (2.3 * f64::from(r) + w as f64 + card as f64).sin();
                response.values[card].iter().enumerate().map(|(w, x)| x + common + own(w)).collect()
            })
            .collect();
    }
    response
}

/// The step is the minimum of the cost: its normal matrix times the step is minus half the
/// gradient, by central differences of the cost itself. *Planted*: a cost with the diagonal of the
/// covariance alone.
#[test]
fn the_step_minimises_the_cost() {
    let mut task = task();
    let nm = task.wavelengths_nm().to_vec();
    let truth = pigment(&nm, &mut Draws::new(3, 0));
    let exact = Origin::Film.spectra(&task, &task.measured, &truth, ([0.0; 2], 0.0)).unwrap();
    for (drawdown, exact) in task.measured.iter_mut().zip(exact) {
        drawdown.values =
            Some(exact.values.iter().enumerate().map(|(w, x)| x + 0.004 * (w as f64).cos()).collect());
    }
    let prior = IndexPrior::new(PriorName::Smooth, &nm, task.binder_index(), false);
    let point: Vec<f64> = near(&prior, &truth).unwrap().iter().map(|x| x + 0.01).collect();
    let strength = 0.06;
    // replicates stay those of the point: the covariance is that of the step
    let here = scattered(Origin::Film.response(&task, &task.measured, &prior.index(&point), 0.0).unwrap());
    let spread: Vec<Vec<Vec<f64>>> = here.replicates.clone();
    let cost = |unknowns: &[f64]| {
        let moved = Origin::Film.response(&task, &task.measured, &prior.index(unknowns), 0.0).unwrap();
        let moved = Response { replicates: spread.clone(), ..moved };
        Data::new(&task, &prior, unknowns, &moved, &[0.002]).cost(strength).unwrap()
    };
    let data = Data::new(&task, &prior, &point, &here, &[0.002]);
    let step = data.step(strength).unwrap();
    assert!(step.unknowns.iter().zip(&prior.positive).all(|(x, held)| !held || *x > 0.0), "no bound acts");
    let moved = Mat::from_fn(point.len(), 1, |i, _| step.unknowns[i] - point[i]);
    let expected = step.posterior.partial_piv_lu().solve(&moved); // H (x − x₀)
    let h = 1e-4;
    let gradient: Vec<f64> = (0..point.len())
        .map(|i| {
            let moved_cost = |sign: f64| {
                let mut moved = point.clone();
                moved[i] += sign * h;
                cost(&moved)
            };
            (moved_cost(1.0) - moved_cost(-1.0)) / (2.0 * h)
        })
        .collect();
    let largest = gradient.iter().fold(0.0_f64, |most, g| most.max(g.abs()));
    for (i, slope) in gradient.iter().enumerate() {
        let off = (expected[(i, 0)] + 0.5 * slope).abs();
        // the response's slopes are forward differences of 1e-4
        assert!(off < 3e-3 * largest, "unknown {i}: {} against {}", expected[(i, 0)], -0.5 * slope);
    }
}

/// χ² of 7 for 16 data and 14.9 unknowns says nothing; of 7 for 32 data and 17 unknowns it agrees;
/// a large one contradicts with any number. *Planted*: a verdict with a single degree of freedom.
#[test]
fn a_verdict_needs_degrees_of_freedom() {
    for (chi_squared, freedom, expected) in [
        (7.0, 1.1, Trust::Untested),
        (0.0, 0.0, Trust::Untested),
        (3.0, 4.0, Trust::Untested),
        (7.0, 15.0, Trust::Consistent),
        (50.0, 15.0, Trust::Inflated),
        (90.0, 15.0, Trust::Contradicted),
        (90.0, 1.1, Trust::Contradicted),
        (90.0, 0.0, Trust::Contradicted),
    ] {
        assert_eq!(Trust::of(chi_squared, freedom), expected, "{chi_squared} with {freedom}");
    }
}

/// Errors estimated from few cells have Student's law, whose variance is this much larger.
#[test]
fn few_cells_widen_errors_as_students_law_does() {
    for cells in [6_u8, 8, 20] {
        let law = StudentsT::new(0.0, 1.0, f64::from(cells) - 1.0).unwrap();
        assert!((few_cells(usize::from(cells)) - law.variance().unwrap()).abs() < 1e-12, "{cells}");
    }
}

/// R + ρ T²: T is crossed twice.
#[test]
fn errors_of_the_grid_on_a_card_hold_both_ways_through_the_layer() {
    let error = GridError { reflectance: 3e-3, transmittance: 4e-3 };
    assert!((on_card(error, 0.0) - 3e-3).abs() < 1e-15);
    assert!((on_card(error, 0.5) - 5e-3).abs() < 1e-15);
}

/// Kubelka and Munk's closed form for a layer on a card: scattering power `s`, absorbing `k`.
fn over_card(s: f64, k: f64, card: f64) -> f64 {
    let a = 1.0 + k / s;
    let b = (a * a - 1.0).sqrt();
    let coth = 1.0 / (b * s).tanh();
    (1.0 - card * (a - b * coth)) / (a - card + b * coth)
}

/// Twice the share in half of three times the thickness is three times the pigment. *Planted*: the
/// ratio of the shares upside down.
#[test]
fn kubelka_and_munk_predict_in_proportion_to_the_pigment() {
    let mut task = task();
    let waves = task.wavelengths_nm().len();
    let card = |drawdown: &crate::fit::load::Drawdown| drawdown.albedo(550.0).unwrap();
    for drawdown in &mut task.measured {
        drawdown.values = Some(vec![over_card(0.4, 0.15, card(drawdown)); waves]);
    }
    let mut other = task.measured[0].clone();
    other.study.pigments[task.pigment].grains.volume_fraction *= 2.0;
    other.study.layer.thickness_um *= 1.5;
    let truth = pigment(task.wavelengths_nm(), &mut Draws::new(3, 0));
    let response = Origin::Film.response(&task, &task.measured, &truth, 0.0).unwrap();
    let prior = IndexPrior::new(PriorName::Smooth, task.wavelengths_nm(), 1.5, false);
    let point = near(&prior, &truth).unwrap();
    let data = Data::new(&task, &prior, &point, &response, &[0.0]);
    let (strength, step) = data.chosen().unwrap();
    let outcome = data.outcome(strength, &step, 1);
    let forecast = Forecast::new(&task, &other, 0, &response, &outcome.index, None);
    let expected = over_card(3.0 * 0.4, 3.0 * 0.15, card(&other));
    // a closed form inverted and evaluated: rounding
    assert!(forecast.kubelka_munk.unwrap().iter().all(|x| (x - expected).abs() < 1e-9));
}

/// A predicted factor that no layer can have is not published. *Planted*: no gate for predictions.
#[test]
fn impossible_predictions_are_withheld() {
    let forecast = |value: f64, error: f64| Forecast {
        name: "drawdown".to_owned(),
        values: vec![0.4, value],
        errors: vec![0.01, error],
        kubelka_munk: None,
        measured: None,
        delta_e_2000: None,
        delta_e_2000_kubelka_munk: None,
    };
    let reason = |value, error| forecast(value, error).impossible(&[500.0, 510.0]);
    // within its error, and a fringe on white paper
    assert_eq!([reason(-0.01, 0.02), reason(1.5, 0.05)], [None, None]);
    for (value, error) in [(-0.1, 0.01), (3.0, 0.1), (0.5, 0.8), (f64::NAN, 0.01)] {
        let said = reason(value, error).unwrap();
        assert!(said.contains("drawdown") && said.contains("510 nm"), "{said}");
    }
}
