use super::map::tests::{run_at, task};
use super::*;

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
