use super::*;
use crate::design::recipe::load;
use crate::design::wish::ReachedNumber;
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
    loaded(DESIGN)
}

pub(in crate::design::run) fn loaded(text: &str) -> DesignTask {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("design.toml");
    std::fs::write(&path, text).unwrap();
    load(&path).unwrap()
}

/// A run whose spectra are those of the film, and a constant.
pub(in crate::design::run) fn run_at(task: &DesignTask, places: &[f64], beyond_film: f64) -> Verified {
    let spectra: Vec<f64> = FilmResponse::new(task, places)
        .unwrap()
        .at(places)
        .unwrap()
        .iter()
        .map(|film| film + beyond_film)
        .collect();
    let (lab, ratio) = Eye::new(&study_at(task, places).unwrap()).unwrap().sees(&spectra).unwrap();
    let numbers = FilmResponse::new(task, places).unwrap().numbers(&spectra);
    let reached = |(wish, value): (&NumberWish, &f64)| ReachedNumber {
        name: wish.name.clone(),
        estimate: Estimate { value: *value, standard_error: Some(1e-3) },
        predicted: None,
    };
    Verified {
        recipe: task.in_words(places),
        values: task.values(places),
        lab,
        hex: String::new(),
        delta_e_2000: task
            .lab
            .map(|target| Estimate { value: ciede2000(lab, target), standard_error: Some(0.1) }),
        predicted: None,
        surface_error: None,
        contrast_ratio: Estimate { value: ratio, standard_error: None },
        numbers: task.numbers.iter().zip(&numbers).map(reached).collect(),
        realisations: 3,
        cost: task.cost(places),
        places: places.to_vec(),
        spectra,
        solved: None,
    }
}

fn ground(task: &DesignTask) -> Ground<'_> {
    Ground { task, watch: &(), interpolated: Interpolated::BeyondFilm }
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
    let map = Map::new(ground(&task), &runs, variants).unwrap();
    let (here, surface) = (map.at(&[0.4, 0.6]).unwrap().lab, map.surface(&[0.4, 0.6]).unwrap().lab);
    assert!(ciede2000(surface, verified) > 0.5, "the check is empty: {surface:?} {verified:?}");
    // An identity: rounding.
    assert!(here.iter().zip(&verified).all(|(a, b)| (a - b).abs() < 1e-9), "{here:?} {verified:?}");
    let share = |places: &[f64]| {
        let moved = map.at(places).unwrap().lab[0] - map.surface(places).unwrap().lab[0];
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
    task.lab = Some(run_at(&task, &secret, 0.0).lab);
    let runs = even_runs(&task);
    let map = Map::new(ground(&task), &runs, runs.len()).unwrap();
    assert!(map.leave_one_out(&runs).unwrap() < 1e-6, "films have no differences from themselves");
    let best = &map.search(None)[0];
    // Steps end at 0.1/2⁶ of the range.
    let distance = best.delta_e_2000.unwrap();
    assert!(distance < 0.05, "{best:?}");
    let lab = map.at(&best.places).unwrap().lab;
    assert!((ciede2000(lab, task.lab.unwrap()) - distance).abs() < 1e-12);
}

/// Recipes that are listed lie apart by a distance, not by its square. *Planted*: the square.
#[test]
fn recipes_that_are_listed_lie_apart_by_a_distance() {
    let task = task();
    let answer = |x: f64| DesignAnswer {
        recipe: String::new(),
        values: task.values(&[x, 0.5]),
        delta_e_2000: Some(x),
        contrast_ratio: 0.5,
        numbers: Vec::new(),
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

/// The dye with a range of its density to blue light, and the colour taken away.
fn of_density(range: &str) -> DesignTask {
    let number = "[[base.number]]\nname = \"blue density\"\nweights = \"status_t_blue\"\nof = \"lit_at_45\"\n\
                  transform = \"density\"\n";
    let wish = format!("[target]\n[[target.number]]\nname = \"blue density\"\n{range}\n");
    loaded(&format!("{}{number}", DESIGN.replace("[target]\nlab = [85, -10, 70]\n", &wish)))
}

/// A density is found again without a colour: the films' numbers are those of their sums, and of the
/// recipes in the range the cheapest is the first. *Planted*: the dearest first; sums of the wrong
/// number; the surfaces' sums left out.
#[test]
fn a_density_is_found_at_the_least_cost() {
    let task = of_density("at_least = 0.6\nat_most = 0.7");
    let runs = even_runs(&task);
    let map = Map::new(ground(&task), &runs, runs.len()).unwrap();
    let answers = map.search(None);
    let aim = task.numbers[0].narrowed(2.0 * map.number_errors(&runs)[0]);
    let meets: Vec<&DesignAnswer> = answers
        .iter()
        .filter(|answer| aim.holds(answer.numbers[0]) && answer.delta_e_2000.is_none())
        .collect();
    assert!(meets.len() > 10 && answers[0] == *meets[0], "{:?}", &answers[..2]);
    let cheapest = meets.iter().map(|answer| task.cost(&answer.places)).fold(f64::INFINITY, f64::min);
    assert_eq!(task.cost(&answers[0].places), cheapest);
    // a run of the answer has the number that was answered
    let run = run_at(&task, &answers[0].places, 0.0);
    assert!((run.numbers[0].estimate.value - answers[0].numbers[0]).abs() < 1e-6, "{run:?}");
}

/// What a verified run has shown of a number is answered there. *Planted*: taken off.
#[test]
fn the_number_at_a_verified_recipe_is_its_run() {
    let task = of_density("at_least = 0.6");
    let mut runs = even_runs(&task);
    let variants = runs.len();
    runs.push(run_at(&task, &[0.4, 0.6], 0.02));
    runs[variants].numbers[0].estimate.value += 0.2;
    let map = Map::new(ground(&task), &runs, variants).unwrap();
    let here = map.at(&[0.4, 0.6]).unwrap().numbers[0];
    assert!((here - runs[variants].numbers[0].estimate.value).abs() < 1e-9, "{here}");
    assert!((map.surface(&[0.4, 0.6]).unwrap().numbers[0] - here).abs() > 0.1, "the check is empty");
}
