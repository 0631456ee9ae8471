//! What to measure next where n is not determined: of the measurements that could be added, those
//! that tell two solutions apart, or that shrink the error of n. Other cards and geometries of the
//! layers measured are judged by the solves at hand; other layers by their coherent films, whose
//! scattering is not known.

use super::FitSolution;
use crate::appearance::paper::Albedo;
use crate::evaluate::seen::NoInk;
use crate::fit::data::derivative;
use crate::fit::file::FitGeometry;
use crate::fit::law::rms;
use crate::fit::load::{Drawdown, FitTask};
use crate::fit::response::{Origin, Response, thicker};
use crate::input::study::Study;
use faer::linalg::solvers::DenseSolveCore;
use faer::{Mat, Side};

/// Albedos of the cards considered: white and black.
const CARDS: [f64; 2] = [0.85, 0.04];
/// Albedos nearer than this are those of one card.
const SAME_CARD: f64 = 0.2;
/// Factors of the volume fraction and of the thickness of the other layers considered.
const FACTORS: [f64; 2] = [0.5, 2.0];
/// Largest volume fraction of them: a packing above is hard to make.
const DENSEST: f64 = 0.5;
/// Distance of two solutions' spectra, in standard deviations of all their values together, that
/// tells them apart.
const TELLS: f64 = 3.0;
/// Share of the error of n that a helpful measurement leaves at most.
const HELPS: f64 = 0.7;

/// What would help, in a sentence.
pub(super) struct Advice {
    pub sentence: String,
}

impl Advice {
    /// Where nothing that was considered helps.
    pub fn none(task: &FitTask) -> Self {
        let noise = task.settings.noise;
        let sentence = format!(
            "No other card, geometry, loading or thickness that was tried would help by itself: measure at more wavelengths, with less noise \
             than fit.noise = {noise}, or in a binder of another index"
        );
        Self { sentence }
    }
}

/// A measurement that could be added.
struct Further {
    words: String,
    drawdown: Drawdown,
}

/// What to measure next, from one solution or two.
///
/// # Errors
/// A layer on a card gives no spectrum.
pub(super) fn advice(
    task: &FitTask,
    best: &FitSolution,
    other: Option<&FitSolution>,
) -> Result<Advice, NoInk> {
    let same = same_layers(task);
    let helpful = judged(task, &same, [Some(best), other], |solution| Origin::Solved(&solution.linearised))?;
    if let Some(sentence) = helpful {
        return Ok(Advice { sentence: format!("Measure {sentence}") });
    }
    let (wider, layers) = other_layers(task);
    let helpful = judged(&wider, &layers, [Some(best), other], |_| Origin::Film)?;
    let Some(sentence) = helpful else { return Ok(Advice::none(task)) };
    let cards = if same.is_empty() {
        "All cards and geometries of these layers are measured already"
    } else {
        "No other card or geometry of these layers would help"
    };
    Ok(Advice {
        sentence: format!("{cards}; measure {sentence} (estimated by coherent films, without scattering)"),
    })
}

/// The most helpful one of some measurements, with what it does; none where none helps.
fn judged<'a>(
    task: &FitTask,
    all: &[Further],
    solutions: [Option<&'a FitSolution>; 2],
    origin: impl Fn(&'a FitSolution) -> Origin<'a>,
) -> Result<Option<String>, NoInk> {
    let [Some(best), other] = solutions else { return Ok(None) };
    let drawdowns: Vec<Drawdown> = all.iter().map(|further| further.drawdown.clone()).collect();
    let respond = |solution: &'a FitSolution| {
        origin(solution).response(task, &drawdowns, &solution.index, solution.log_thickness)
    };
    let response = respond(best)?;
    let noise = task.settings.noise;
    let Some(other) = other else {
        let before = n_error(best, None);
        let after = |k: usize| n_error(best, Some((&response, k, noise)));
        let strongest = (0..all.len()).min_by(|&a, &b| after(a).total_cmp(&after(b)));
        let helpful = strongest.filter(|&k| after(k) < HELPS * before);
        return Ok(helpful.map(|k| {
            format!("{}: it would leave {:.2} of the error of n", all[k].words, after(k) / before)
        }));
    };
    let others = respond(other)?;
    let distance = |k: usize| {
        let pairs = response.values[k].iter().zip(&others.values[k]);
        rms(pairs.map(|(a, b)| (a - b) / noise))
    };
    let together = |k: usize| distance(k) * (response.values[k].len() as f64).sqrt();
    let farthest = (0..all.len()).max_by(|&a, &b| distance(a).total_cmp(&distance(b)));
    let telling = farthest.filter(|&k| together(k) > TELLS);
    Ok(telling.map(|k| {
        format!(
            "{}: the two solutions differ there by {:.1} standard deviations of the noise (root mean square)",
            all[k].words,
            distance(k)
        )
    }))
}

/// Root mean square error of n of a solution by its posterior, with the data of one more drawdown.
fn n_error(solution: &FitSolution, further: Option<(&Response, usize, f64)>) -> f64 {
    let prior = &solution.prior;
    let mut posterior = solution.step.posterior.clone();
    if let Some((response, drawdown, noise)) = further {
        let waves = response.values[drawdown].len();
        let jacobian =
            Mat::from_fn(waves, prior.count(), |w, j| derivative(prior, response, (drawdown, w), j) / noise);
        let inverse = posterior.llt(Side::Lower).map(|factors| factors.inverse());
        let Ok(precision) = inverse else { return f64::INFINITY };
        let Ok(factors) = (precision + jacobian.transpose() * &jacobian).llt(Side::Lower) else {
            return f64::INFINITY;
        };
        posterior = factors.inverse();
    }
    rms(prior.n.iter().map(|row| {
        let row = Mat::from_fn(row.len(), 1, |i, _| row[i]);
        (row.transpose() * (&posterior * &row))[(0, 0)].max(0.0).sqrt()
    }))
}

/// Whether a layer is measured in this geometry on such a card.
fn is_measured(task: &FitTask, coat: usize, geometry: FitGeometry, card: f64) -> bool {
    let nm = task.wavelengths_nm();
    let middle = nm[nm.len() / 2];
    task.measured.iter().any(|drawdown| {
        let near = drawdown.albedo(middle).is_some_and(|albedo| (albedo - card).abs() < SAME_CARD);
        drawdown.coat == coat && drawdown.geometry == geometry && near
    })
}

/// The layers measured, in other geometries and on other cards.
fn same_layers(task: &FitTask) -> Vec<Further> {
    let mut all = Vec::new();
    for coat in 0..task.coats_measured {
        let measured = task.measured.iter().find(|drawdown| drawdown.coat == coat);
        let Some(measured) = measured else { continue };
        for geometry in [FitGeometry::LitAt45, FitGeometry::Sphere, FitGeometry::UniformSky] {
            for card in CARDS.into_iter().filter(|&card| !is_measured(task, coat, geometry, card)) {
                let mut drawdown = measured.clone();
                drawdown.study.paper.albedo = Albedo::Constant(card);
                drawdown.geometry = geometry;
                let layer = if task.coats_measured == 1 {
                    "the same layer".to_owned()
                } else {
                    format!("the layer of {}", measured.name)
                };
                let words = format!("{layer} {} on {}", geometry.in_words(), card_in_words(card));
                all.push(Further { words, drawdown });
            }
        }
    }
    all
}

/// Layers of other volume fractions and thicknesses on the first spectrum's card and on the
/// opposite one, and the task with their coats.
fn other_layers(task: &FitTask) -> (FitTask, Vec<Further>) {
    let mut wider = task.clone();
    let mut all = Vec::new();
    let measured = &task.measured[0];
    let base = &task.coats[measured.coat];
    let share = base.pigments[task.pigment].grains.volume_fraction;
    let mut layers: Vec<(String, Study)> = Vec::new();
    for factor in FACTORS {
        let mut loaded = base.clone();
        loaded.pigments[task.pigment].grains.volume_fraction = share * factor;
        if share * factor <= DENSEST {
            layers.push((format!("a layer with {:.1} % of the pigment", 100.0 * share * factor), loaded));
        }
        let thick = thicker(base, task.pigment, factor);
        let um = thick.thicknesses_of_pigments_um(thick.layer.thickness_um)[task.pigment];
        layers.push((format!("a layer of {um:.2} µm"), thick));
    }
    for (words, study) in layers {
        for card in CARDS {
            let mut drawdown = measured.clone();
            drawdown.coat = wider.coats.len();
            drawdown.study = study.clone();
            drawdown.study.paper.albedo = Albedo::Constant(card);
            let geometry = drawdown.geometry.in_words();
            all.push(Further { words: format!("{words} {geometry} on {}", card_in_words(card)), drawdown });
        }
        wider.coats.push(study);
    }
    (wider, all)
}

fn card_in_words(albedo: f64) -> String {
    let name = if albedo > 0.5 { "white" } else { "black" };
    format!("a {name} card (albedo {albedo})")
}

impl FitGeometry {
    /// How the light comes and is seen.
    fn in_words(self) -> &'static str {
        match self {
            Self::LitAt45 => "at 45:0",
            Self::Sphere => "at d:8, specular light included,",
            Self::SphereExcluded => "at d:8, specular light excluded,",
            Self::UniformSky => "under a uniform sky",
            Self::Transmitted => "in transmission",
        }
    }
}
