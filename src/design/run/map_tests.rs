use super::*;
use crate::design::recipe::load;
use crate::numerics::estimate::Estimate;

/// A dye in a film, whose volume fraction and thickness vary.
const DESIGN: &str = r#"
title = "a dye"
[target]
lab = [85, -10, 70]
[[vary]]
field = "pigment[0].volume_fraction"
from = 0.05
to = 0.3
cost = 2.0
[[vary]]
field = "layer.thickness_um"
from = 0.8
to = 1.2
[design]
delta_e = 1.0
realisations = 5
[base.layer]
thickness_um = 1.0
binder.index = 1.5
[[base.pigment]]
name = "dye"
diameter_nm = "molecular"
volume_fraction = 0.1
index = { built_in = "yellow" }
[base.paper]
albedo = 0.9
[base.light]
from_nm = 400
to_nm = 700
step_nm = 50
[base.angles]
count = 5
[base.run]
realisations = 3
"#;

pub(in crate::design::run) fn task() -> DesignTask {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("design.toml");
    std::fs::write(&path, DESIGN).unwrap();
    load(&path).unwrap()
}

/// A run whose spectra are those of the film, and a constant.
pub(in crate::design::run) fn run_at(task: &DesignTask, places: &[f64], beyond_film: f64) -> Verified {
    let spectra: Vec<f64> = film(task, places).unwrap().iter().map(|film| film + beyond_film).collect();
    let (lab, ratio) = Eye::new(&study_at(task, places).unwrap()).unwrap().sees(&spectra).unwrap();
    Verified {
        recipe: task.in_words(places),
        values: task.values(places),
        lab,
        hex: String::new(),
        delta_e_2000: Estimate { value: ciede2000(lab, task.lab), standard_error: Some(0.1) },
        predicted: None,
        surface_error: None,
        contrast_ratio: Estimate { value: ratio, standard_error: None },
        realisations: 3,
        cost: task.cost(places),
        places: places.to_vec(),
        spectra,
    }
}

fn even_runs(task: &DesignTask) -> Vec<Verified> {
    (0..12).map(|r| run_at(task, &even_point(1, 2, r), 0.0)).collect()
}

/// Where a recipe was verified, the answer is what the run has shown, and far away it is that of
/// the surfaces. *Planted*: what the run has shown taken off instead of added.
#[test]
fn the_answer_at_a_verified_recipe_is_its_run() {
    let task = task();
    let mut runs = even_runs(&task);
    let variants = runs.len();
    runs.push(run_at(&task, &[0.4, 0.6], 0.05));
    let verified = runs[variants].lab;
    let map = Map::new(&task, &runs, variants).unwrap();
    let (here, surface) = (map.at(&[0.4, 0.6]).unwrap().0, map.surface(&[0.4, 0.6]).unwrap().0);
    assert!(ciede2000(surface, verified) > 0.5, "the check is empty: {surface:?} {verified:?}");
    // An identity: rounding.
    assert!(here.iter().zip(&verified).all(|(a, b)| (a - b).abs() < 1e-9), "{here:?} {verified:?}");
    let share = |places: &[f64]| {
        let moved = map.at(places).unwrap().0[0] - map.surface(places).unwrap().0[0];
        moved / (verified[0] - surface[0])
    };
    // What a run has shown fades as exp(−½ (distance/0.3)²).
    for places in [[0.4, 0.9], [0.1, 0.2], [1.0, 1.0]] {
        let faded = (-0.5 * (distance(&places, &[0.4, 0.6]) / 0.3).powi(2)).exp();
        assert!((share(&places) - faded).abs() < 1e-9, "{places:?}: {} {faded}", share(&places));
    }
}

/// The colour of a film is found again. *Planted*: a search that stays where it began.
#[test]
fn a_film_is_found_again() {
    let mut task = task();
    let secret = [0.37, 0.5];
    task.lab = run_at(&task, &secret, 0.0).lab;
    let runs = even_runs(&task);
    let map = Map::new(&task, &runs, runs.len()).unwrap();
    assert!(map.leave_one_out(&runs).unwrap() < 1e-6, "films have no differences from themselves");
    let best = &map.search(None)[0];
    // Steps end at 0.1/2⁶ of the range.
    assert!(best.delta_e_2000 < 0.05, "{best:?}");
    let (lab, _) = map.at(&best.places).unwrap();
    assert!((ciede2000(lab, task.lab) - best.delta_e_2000).abs() < 1e-12);
}

/// Recipes that are listed lie apart by a distance, not by its square. *Planted*: the square.
#[test]
fn recipes_that_are_listed_lie_apart_by_a_distance() {
    let task = task();
    let answer = |x: f64| DesignAnswer {
        recipe: String::new(),
        values: task.values(&[x, 0.5]),
        delta_e_2000: x,
        contrast_ratio: 0.5,
        places: vec![x, 0.5],
    };
    // Pairs 0.001 apart, of which one is enough, and 0.03 between them: more than 0.02, whose root
    // is 0.14.
    let all: Vec<DesignAnswer> =
        (0..5).flat_map(|k| [0.0, 0.001].map(|more| answer(0.3 + 0.03 * f64::from(k) + more))).collect();
    let mut listed: Vec<f64> = spread(&all).iter().map(|answer| answer.places[0]).collect();
    assert_eq!(listed[0], 0.3, "the best one is the first");
    listed.sort_by(f64::total_cmp);
    assert_eq!(listed.len(), 5, "{listed:?}");
    assert!(listed.windows(2).all(|pair| pair[1] - pair[0] > 0.02), "{listed:?}");
}
