use super::map::tests::{loaded, run_at, task};
use super::*;
use crate::design::surface::Eye;
use crate::store::marker::Holds;

/// A design of the dye, in a folder of its own.
fn judged(judge: impl Fn(&DesignRun)) {
    let folder = tempfile::tempdir().unwrap();
    let folder = OutputFolder::open(folder.path(), Holds::Design).unwrap();
    judge(&DesignRun { task: &task(), folder: &folder, settings: RunSettings::default(), watch: &() });
}

fn with(run: &Verified, delta_e: f64, standard_error: f64, cost: f64) -> Verified {
    let delta_e_2000 = Some(Estimate { value: delta_e, standard_error: Some(standard_error) });
    Verified { delta_e_2000, cost, ..run.clone() }
}

/// Of recipes that meet the wish of 1.0 the cheapest is first, of the others the nearest; a better
/// one is no farther, and no cost makes one that misses the wish the first. *Planted*: the dearest
/// first.
#[test]
fn the_cheapest_recipe_that_meets_the_wish_is_the_first() {
    judged(|design| {
        let run = run_at(design.task, &[0.5, 0.5], 0.0);
        let cheapest_first = [
            with(&run, 0.9, 0.1, -5.0),
            with(&run, 0.2, 0.1, 0.3),
            with(&run, 0.1, 0.1, 1e9),
            with(&run, 1.1, 0.1, -1e9),
            with(&run, 3.0, 0.1, 0.0),
        ];
        for (i, a) in cheapest_first.iter().enumerate() {
            for (j, b) in cheapest_first.iter().enumerate() {
                assert_eq!(design.order(a, b), i.cmp(&j), "{i} {j}");
            }
        }
        // of one cost, the nearer one
        let (near, far) = (with(&run, 0.1, 0.1, 0.3), with(&run, 0.2, 0.1, 0.3));
        assert_eq!(design.order(&near, &far), std::cmp::Ordering::Less);
    });
}

/// A run ends the verification where two standard errors above it are still within the wish of 1.0.
/// *Planted*: two standard errors below it.
#[test]
fn a_run_is_sure_at_the_far_end_of_its_bar() {
    judged(|design| {
        let run = run_at(design.task, &[0.5, 0.5], 0.0);
        for (delta_e, standard_error, sure) in
            [(0.5, 0.2, true), (0.9, 0.2, false), (0.7, 0.2, false), (1.1, 0.2, false), (1.1, 0.0, false)]
        {
            assert_eq!(design.is_sure(&with(&run, delta_e, standard_error, 0.0)), sure, "{delta_e}");
        }
    });
}

/// Verifying runs have as many packings as `design.realisations` says, and others than those behind
/// the surfaces. *Planted*: the base's number, or its seed.
#[test]
fn verifying_runs_have_packings_of_their_own() {
    judged(|design| {
        let study = |round| design.study(&[0.5, 0.5], round).unwrap();
        let base = study_at(design.task, &[0.5, 0.5]).unwrap();
        assert_eq!(
            (study(None).realisations, study(None).packing.seed),
            (base.realisations, base.packing.seed)
        );
        assert_ne!(base.realisations, 5, "the check is empty");
        assert_eq!(study(Some(1)).realisations, 5);
        let seeds = [None, Some(1), Some(2)].map(|round| study(round).packing.seed);
        assert!(seeds[0] != seeds[1] && seeds[1] != seeds[2] && seeds[2] != seeds[0], "{seeds:?}");
        assert_eq!(study(Some(2)).judgement.target_lab, Some([85.0, -10.0, 70.0]));
    });
}

/// Slabs that are solved in milliseconds.
const SLABS: &str = r#"
[target]
lab = [85, -10, 70]
[[vary]]
field = "layer.thickness_um"
from = 1.0
to = 2.0
[[vary]]
field = "pigment[0].volume_fraction"
from = 0.1
to = 0.2
[[vary]]
field = "paper.albedo"
from = 0.2
to = 0.9
[[target.number]]
name = "red"
at_least = 0.1
[base.layer]
thickness_um = 1
period_um = 0.8
binder.index = 1.5
composed = { slab_um = 0.5, directions = [2, 2] }
[[base.pigment]]
name = "grains"
diameter_nm = 200
volume_fraction = 0.15
share = "scale_sizes"
index = 2.0
[[base.number]]
name = "red"
weights = "status_t_red"
of = "lit_at_45"
[base.light]
wavelengths_nm = [430, 540, 660]
[base.run]
realisations = 2
seed = 7
[base.resolution]
points_per_um = 10
planes_per_um = 32
"#;

/// Solves of a layer that is solved as a whole, in milliseconds.
fn whole() -> String {
    let text = SLABS.replace("composed = { slab_um = 0.5, directions = [2, 2] }\n", "");
    let text = text.replace("[base.run]", "[base.angles]\ncount = 3\n[base.run]");
    text.replace("[[vary]]\nfield = \"layer.thickness_um\"\nfrom = 1.0\nto = 2.0\n", "")
}

/// A design on paper that fluoresces, seen under a lamp.
fn brightened(text: &str) -> String {
    let light = text.replace("[430, 540, 660]", "[380, 450, 520, 600, 680]");
    // less of chance: colours of few grains that scatter much are withheld
    let light = light.replace("realisations = 2", "realisations = 3").replace("index = 2.0", "index = 1.8");
    let light = light.replace("diameter_nm = 200", "diameter_nm = 150");
    format!(
        "{light}[base.colour]\nilluminant = \"A\"\n[base.paper.fluorescence]\nyield = 0.5\n\
         excitation = [[380, 0.1], [420, 0]]\nemission = [[400, 0], [435, 1], [520, 0]]\n"
    )
}

/// A run at other places of the composed axes is composed of the same solves: spectra, contrast and
/// sums are those of a run there with the same packings, and surfaces through these are those of
/// there, to rounding. *Planted*: a run's own spectra at every place; the paper of the variant; a
/// surface of the middle for all thicknesses; spectra under D65.
#[test]
fn surfaces_on_composed_axes_are_those_of_runs_there() {
    for text in [brightened(&whole()), brightened(SLABS)] {
        let folder = tempfile::tempdir().unwrap();
        let task = loaded(&text);
        let at = |thickness: f64, share: f64, albedo: f64| match task.variables.len() {
            2 => vec![share, albedo],
            _ => vec![thickness, share, albedo],
        };
        let output = OutputFolder::open(folder.path(), Holds::Design).unwrap();
        let run = DesignRun { task: &task, folder: &output, settings: RunSettings::default(), watch: &() };
        let of = |places: Vec<f64>| run.run(&places, None).unwrap().unwrap_or_else(|why| panic!("{why}"));
        let middle = [0.1, 0.9].map(|share| of(at(0.5, share, 0.5)));
        // 1.21 µm is no whole number of slabs
        for [thickness, albedo] in [[0.27, 0.83]] {
            let there = [0.1, 0.9].map(|share| of(at(thickness, share, albedo)));
            for (run, direct) in middle.iter().zip(&there) {
                let eye = Eye::new(&study_at(&task, &direct.places).unwrap()).unwrap();
                let (seen, _) = eye.sees(&direct.spectra).unwrap();
                assert!((0..3).all(|i| (seen[i] - direct.lab[i]).abs() < 1e-9), "{seen:?} {direct:?}");
                let composed = run.solved.as_ref().unwrap().at(&task, &direct.places).unwrap();
                let apart = composed.layer.iter().zip(&direct.spectra).map(|(a, b)| (a - b).abs());
                assert!(apart.fold(0.0, f64::max) < 1e-12, "{:?} {:?}", composed.layer, direct.spectra);
                assert!(run.spectra.iter().zip(&direct.spectra).any(|(a, b)| (a - b).abs() > 1e-3), "empty");
            }
            let ground = run.ground(&middle).unwrap();
            let here = Map::new(ground, &middle, 2).unwrap().at(&at(thickness, 0.4, albedo)).unwrap();
            let of_runs = Map::new(ground, &there, 2).unwrap().at(&at(thickness, 0.4, albedo)).unwrap();
            let apart = here.lab.iter().zip(of_runs.lab).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(apart < 1e-8, "{here:?} {of_runs:?}");
            assert!((here.contrast_ratio - of_runs.contrast_ratio).abs() < 1e-10, "{here:?} {of_runs:?}");
            assert!((here.numbers[0] - of_runs.numbers[0]).abs() < 1e-10, "{here:?} {of_runs:?}");
        }
    }
}

/// Colours, contrast and numbers of a composed recipe are those of its published results, and its
/// spectra give the same colour. *Planted*: the colour under natural light.
#[test]
fn a_composed_recipe_has_the_numbers_of_its_run() {
    let folder = tempfile::tempdir().unwrap();
    let task = loaded(SLABS);
    let output = OutputFolder::open(folder.path(), Holds::Design).unwrap();
    let run = DesignRun { task: &task, folder: &output, settings: RunSettings::default(), watch: &() };
    let places = [0.27, 0.5, 0.5];
    let own = run.run(&places, None).unwrap().unwrap();
    let study = run.study(&places, None).unwrap();
    let runs =
        OutputFolder::open(&folder.path().join("runs").join(study.key().short()), Holds::Study).unwrap();
    let solved = crate::work::alone::stored(&study, &crate::run::Stores::open(&runs).unwrap()).unwrap();
    let evaluated = crate::evaluate::evaluated::Evaluated::new(&study, &solved).unwrap();
    let published = &evaluated.manifest.colours.composed()[0];
    let lab = published.lit_at_45.unwrap();
    assert!((0..3).all(|i| (own.lab[i] - lab[i].value).abs() < 1e-12), "{own:?} {lab:?}");
    let ratio = published.contrast_ratio.unwrap().estimate();
    let same = |a: Estimate, b: Estimate| {
        let errors = a.standard_error.unwrap() - b.standard_error.unwrap();
        (a.value - b.value).abs() < 1e-12 && errors.abs() < 1e-12
    };
    assert!(same(own.contrast_ratio, ratio), "{own:?} {ratio:?}");
    assert!(same(own.numbers[0].estimate, evaluated.manifest.numbers[0].estimate().unwrap()), "{own:?}");
    let (seen, contrast) = Eye::new(&study).unwrap().sees(&own.spectra).unwrap();
    assert!((0..3).all(|i| (own.lab[i] - seen[i]).abs() < 1e-9), "{own:?} {seen:?}");
    assert!((contrast - ratio.value).abs() < 1e-9);
    // of the error along L*, a* and b* the distance has no more than all of it
    let distance = own.delta_e_2000.unwrap().standard_error.unwrap();
    let all = lab.iter().map(|part| part.standard_error.powi(2)).sum::<f64>().sqrt();
    assert!(distance > 0.0 && distance < 2.0 * all, "{distance} {all}");
}

/// *Planted*: a stop unheard while spectra are composed.
#[test]
fn a_stop_ends_the_search() {
    struct Stop;
    impl RunWatch for Stop {
        fn stop(&self) -> bool {
            true
        }
    }
    let task = task();
    let run = run_at(&task, &[0.5, 0.5], 0.0);
    let ground = Ground { task: &task, watch: &Stop, interpolated: Interpolated::BeyondFilm };
    let error = Map::new(ground, &[run], 1).err().map(|error| error.to_string());
    assert!(error.is_some_and(|error| error.contains("stopped")));
}
