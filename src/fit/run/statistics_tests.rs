//! Statistics of a fit: what is minimised, the data left for a verdict, and errors of few cells.

use super::coverage_tests::{fitted, pigment, task};
use super::outcome::{FitOutcome, Trust};
use super::{Forecast, near, on_card};
use crate::appearance::weighted::{NumberTransform, WeightTable};
use crate::fit::data::{Data, few_cells};
use crate::fit::file::PriorName;
use crate::fit::load::{FitTask, MeasuredNumber};
use crate::fit::prior::IndexPrior;
use crate::fit::response::{Origin, Response};
use crate::input::file::SeenLight;
use crate::input::study::{WantedNumber, WantedWeights};
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
/// gradient, by central differences of the cost itself, of spectra and of a density. *Planted*: a
/// cost with the diagonal of the covariance alone; a density's derivatives of the wrong sign.
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
    let flat: Vec<[f64; 2]> = nm.iter().map(|nm| [*nm, 1.0]).collect();
    task.measured[1].numbers = vec![number(flat, NumberTransform::Density, 1.3)];
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

/// A number of the sample on the black card: the mean reflectance factor at 45:0 with these weights, or what is made of it.
fn number(rows: Vec<[f64; 2]>, transform: NumberTransform, value: f64) -> MeasuredNumber {
    let range_nm = [rows[0][0], rows[rows.len() - 1][0]];
    let table = WeightTable::new(rows).expect("sound weights");
    let wanted = WantedNumber {
        name: "number".into(),
        weights: WantedWeights::Table { source: "weights.csv".into(), table },
        range_nm,
        of: SeenLight::LitAt45,
        over: None,
        transform,
    };
    MeasuredNumber { wanted, value, error: 0.003 }
}

/// A mean over so narrow a band that it is the value at one wavelength is to a fit what this value is:
/// residual, derivatives and covariances alike. *Planted*: a number with the replicates of the other
/// sample; predicted less measured.
#[test]
fn a_number_of_one_wavelength_is_the_value_there() {
    let mut task = task();
    let nm = task.wavelengths_nm().to_vec();
    let truth = pigment(&nm, &mut Draws::new(3, 0));
    let waves = nm.len();
    let wave = 5;
    for (card, drawdown) in task.measured.iter_mut().enumerate() {
        drawdown.values = Some((0..waves).map(|w| 0.1 + 0.3 * card as f64 + 0.01 * w as f64).collect());
    }
    let band = [-0.5, 0.0, 0.5].map(|by| [nm[wave] + by, 1.0 - f64::abs(2.0 * by)]).to_vec();
    let value = task.measured[1].measured(wave);
    task.measured[1].numbers = vec![number(band, NumberTransform::Mean, value)];
    let prior = IndexPrior::new(PriorName::Smooth, &nm, task.binder_index(), false);
    let point = near(&prior, &truth).unwrap();
    let response =
        scattered(Origin::Film.response(&task, &task.measured, &prior.index(&point), 0.0).unwrap());
    let data = Data::new(&task, &prior, &point, &response, &[0.002]);
    let (spectral, of_number) = (waves + wave, 2 * waves);
    assert_eq!(data.residual.len(), 2 * waves + 1);
    // the spectrum bends within the band
    let close = |a: f64, b: f64| (a - b).abs() < 1e-3 * b.abs() + 1e-7;
    assert!(close(data.residual[of_number], data.residual[spectral]));
    let elsewhere: Vec<f64> = point.iter().enumerate().map(|(j, x)| x + 0.01 * (j as f64).cos()).collect();
    let left = data.left(&elsewhere);
    assert!(close(left[of_number], left[spectral]), "{} for {}", left[of_number], left[spectral]);
    for other in (0..2 * waves).filter(|other| *other != spectral) {
        let (found, expected) = (data.errors[(of_number, other)], data.errors[(spectral, other)]);
        assert!(close(found, expected), "{other}: {found} for {expected}");
    }
    assert!(close(data.weights[(of_number, of_number)], data.weights[(spectral, spectral)]));
}

/// The density of the sample on the black card tells n and κ better than the white card's spectrum
/// alone, and a wrong one is seen. *Planted*: the mean's derivatives for a density's.
#[test]
fn a_density_is_a_datum_of_its_own() {
    let mut task = task();
    let nm = task.wavelengths_nm().to_vec();
    let truth = pigment(&nm, &mut Draws::new(3, 0));
    let exact = Origin::Film.spectra(&task, &task.measured, &truth, ([0.0; 2], 0.0)).unwrap();
    let flat: Vec<[f64; 2]> = nm.iter().map(|nm| [*nm, 1.0]).collect();
    let mut density = number(flat, NumberTransform::Density, 0.0);
    density.value = density.at(&nm, &exact[1].values).value;
    let mean: f64 = exact[1].values.iter().sum::<f64>() / nm.len() as f64;
    // another rule of the mean over a smooth spectrum
    assert!((density.value + mean.log10()).abs() < 0.05, "{} for a mean of {mean}", density.value);
    task.measured[0].values = Some(exact[0].values.clone());
    task.measured[1].values = None;
    let fit = |task: &FitTask| fitted(task, &truth);
    let without = fit(&task);
    task.measured[1].numbers = vec![density.clone()];
    let with = fit(&task);
    let n_error = |fit: &FitOutcome| fit.index.iter().filter_map(|row| row.n_error).sum::<f64>();
    assert!(n_error(&with) < 0.95 * n_error(&without), "{} for {}", n_error(&with), n_error(&without));
    let found = &with.numbers[0];
    assert!((found.fitted - found.measured).abs() < found.sigma, "{found:?}");
    assert!(without.numbers.is_empty() && with.data == without.data + 1);
    task.measured[1].numbers[0].value = density.value + 1.0;
    let wrong = fit(&task);
    assert!(wrong.chi_squared > with.chi_squared + 10.0, "{} for {}", wrong.chi_squared, with.chi_squared);
}
