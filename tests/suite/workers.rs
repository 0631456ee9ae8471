//! Several processes in one folder: they share the work, outlive one another, and come to the same results as one alone.

use crate::sweep_support::{Place, TINY, inkwave, points, results, said, succeed};
use inkwave::store::{PointRecord, Record, Store};
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

fn start(place: &Place, output: &str) -> Child {
    let file = place.path("tiny.toml");
    let output = place.path(output);
    let mut command = inkwave(&["sweep", &file, "--jobs", "1", "--output", &output]);
    command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
}

fn wait_for_points(folder: &str, count: usize) {
    let since = Instant::now();
    while points(folder) < count {
        assert!(since.elapsed() < Duration::from_secs(120), "no points");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// What was said, without the frame and the line breaks of the terminal.
fn plain(output: &std::process::Output) -> String {
    said(output).replace('│', " ").split_whitespace().collect::<Vec<_>>().join(" ")
}

#[test]
fn workers_share_the_work_and_the_others_finish_what_a_killed_one_began() {
    let place = Place::new(
        &TINY.replace("step_nm = 100", "step_nm = 12").replace("realisations = 2", "realisations = 4"),
    );
    place.sweep("alone", &[]);
    let mut workers: Vec<Child> = (0..4).map(|_| start(&place, "shared")).collect();
    wait_for_points(&place.path("shared"), 100);
    workers[0].kill().unwrap();
    workers.remove(0).wait().unwrap();
    let ends: Vec<_> = workers.into_iter().map(|worker| worker.wait_with_output().unwrap()).collect();
    ends.iter().for_each(|end| assert!(end.status.success(), "{}", said(end)));
    let reports = ends.iter().filter(|end| said(end).contains("Report:")).count();
    assert!(reports >= 1, "a process that finds all units finished writes the report");
    for (alone, shared) in results(&place.path("alone")).iter().zip(&results(&place.path("shared"))) {
        assert!(alone == shared, "{} differs", alone.0.display());
    }
    assert_eq!(points(&place.path("alone")), points(&place.path("shared")));
    let files = std::fs::read_dir(place.path("shared/records")).unwrap();
    let files =
        files.filter(|f| f.as_ref().unwrap().path().extension().is_some_and(|e| e == "sqlite")).count();
    assert!(files >= 3, "{files} workers wrote");
}

#[test]
fn other_work_in_a_folder_where_processes_are_at_work_is_refused() {
    let place = Place::new(&TINY.replace("step_nm = 100", "step_nm = 2"));
    let mut worker = start(&place, "out");
    wait_for_points(&place.path("out"), 5);
    let file = place.path("tiny.toml");
    let other = inkwave(&["sweep", &file, "--grids-only", "--output", &place.path("out")]).output().unwrap();
    worker.kill().unwrap();
    worker.wait().unwrap();
    assert!(
        !other.status.success()
            && said(&other).contains("other processes are running another study or sweep"),
        "{}",
        said(&other)
    );
}

#[test]
fn shards_take_grids_that_were_chosen_before() {
    let place = Place::new(TINY);
    let file = place.path("tiny.toml");
    let grids = place.path("grids");
    succeed(&["sweep", &file, "--grids-only", "--output", &grids]);
    assert_eq!(points(&grids), 0);
    let count = |folder: &str| Store::<PointRecord>::open(folder).unwrap().database().keys("grid").len();
    let chosen = count(&grids);
    assert!(chosen > 0);
    let told = place.sweep("one", &["--shard", "1/2", "--grids", &grids]);
    assert!(told.contains(&format!("{chosen} grids taken")) && !told.contains("estimating"), "{told}");
    let wrong = inkwave(&["sweep", &file, "--grids", &place.path("."), "--output", &place.path("x")])
        .output()
        .unwrap();
    assert!(!wrong.status.success() && plain(&wrong).contains("no folder of a sweep"), "{}", said(&wrong));
    assert_eq!(PointRecord::KIND, "point");
}

#[test]
fn a_task_number_of_any_engine_is_heard_and_numbers_beyond_the_units_are_refused() {
    let place = Place::new(TINY);
    let run = |variable: &str, shard: &str, output: &str| {
        let file = place.path("tiny.toml");
        let output = place.path(output);
        let mut command = inkwave(&["sweep", &file, "--output", &output, "--shard", shard]);
        command.env(variable, "2").output().unwrap()
    };
    for variable in ["SLURM_ARRAY_TASK_ID", "PBS_ARRAYID", "PBS_ARRAY_INDEX", "HQ_TASK_ID"] {
        let done = run(variable, "4", variable);
        assert!(done.status.success() && said(&done).contains("Shard 2/4"), "{}", said(&done));
    }
    let most = usize::MAX;
    for shard in [format!("{most}/{most}"), "1/1000".into(), format!("{most}")] {
        let done = run("HQ_TASK_ID", &shard, "none");
        assert!(
            done.status.code() == Some(1) && plain(&done).contains("can be divided into 1 to 5"),
            "{}",
            said(&done)
        );
    }
}

#[test]
fn parts_without_a_task_number_are_told_where_it_was_looked_for() {
    let place = Place::new(TINY);
    let names = ["SLURM_ARRAY_TASK_ID", "PBS_ARRAYID", "PBS_ARRAY_INDEX", "HQ_TASK_ID"];
    let mut command =
        inkwave(&["sweep", &place.path("tiny.toml"), "--output", &place.path("out"), "--shard", "4"]);
    for name in names {
        command.env_remove(name);
    }
    let words = plain(&command.output().unwrap());
    let wanted = format!("--shard: found 4 alone, and none of {} is set", names.join(", "));
    assert!(words.contains(&wanted), "{words}");
}

/// One variant whose bar is reached at the first look, one that never reaches it.
fn bars() -> String {
    let base = TINY.split("[[axis]]").next().unwrap().replace("realisations = 2", "realisations = 20");
    // closer wavelengths: what lies between those 100 nm apart would be most of the bar
    let base = base.replace("step_nm = 100", "step_nm = 50");
    base + "[[axis]]\nname = \"bar\"\nfield = \"run.target_delta_e\"\nvalues = [50.0, 0.001]\n"
}

#[test]
fn variants_end_at_their_target_interval_with_any_number_of_processes() {
    let place = Place::new(&bars());
    place.sweep("alone", &[]);
    let table = std::fs::read_to_string(place.path("alone/sweep.csv")).unwrap();
    let finished = |line: &str| line.split(',').nth(5).unwrap().to_owned();
    assert_eq!(table.lines().skip(1).map(finished).collect::<Vec<_>>(), ["16", "20"], "{table}");
    assert_eq!(points(&place.path("alone")), 20 * 7 * 3);
    let workers: Vec<Child> = (0..3).map(|_| start(&place, "shared")).collect();
    for end in workers.into_iter().map(|worker| worker.wait_with_output().unwrap()) {
        assert!(end.status.success(), "{}", said(&end));
    }
    for (alone, shared) in results(&place.path("alone")).iter().zip(&results(&place.path("shared"))) {
        assert!(alone == shared, "{} differs", alone.0.display());
    }
    // Again, and each as a study of its own.
    place.sweep("shared", &[]);
    assert_eq!(points(&place.path("shared")), 20 * 7 * 3);
    for variant in std::fs::read_dir(place.path("alone/variants")).unwrap().flatten() {
        let own = place.path("own");
        succeed(&["run", &variant.path().join("study.toml").display().to_string(), "--output", &own]);
        let spectra = |folder: &str| std::fs::read(format!("{folder}/spectra.csv")).unwrap();
        assert!(spectra(&own) == spectra(&variant.path().display().to_string()), "{variant:?}");
        std::fs::remove_dir_all(own).unwrap();
    }
    let file = place.path("tiny.toml");
    let shard =
        inkwave(&["sweep", &file, "--shard", "1/2", "--output", &place.path("part")]).output().unwrap();
    assert!(
        !shard.status.success() && plain(&shard).contains("no shard knows the whole confidence interval"),
        "{}",
        said(&shard)
    );
}

#[test]
fn a_wanted_bar_may_speak_of_one_colour() {
    let first = Place::new(&bars().replace("[50.0, 0.001]", "[50.0]"));
    first.sweep("first", &[]);
    let variant = std::fs::read_dir(first.path("first/variants")).unwrap().flatten().next().unwrap();
    let text = std::fs::read_to_string(variant.path().join("results.json")).unwrap();
    let manifest: serde_json::Value = serde_json::from_str(&text).unwrap();
    let bar = |colour: usize| manifest["colours"][colour]["delta_e_2000_95"].as_f64().unwrap();
    let sky = bar(0);
    let print = bar(1);
    let between = 0.5 * (sky + print);
    let axis = "name = \"colour\"\nfield = \"run.target_colour\"\n";
    let colours = format!("{axis}values = [\"every\", \"natural_light\", \"lit_at_45\"]\n");
    let base = bars()
        .split("[[axis]]")
        .next()
        .unwrap()
        .replace("[base.run]\n", "[base.run]\ntarget_delta_e = BAR\n");
    let place = Place::new(&format!("{}[[axis]]\n{colours}", base.replace("BAR", &between.to_string())));
    place.sweep("out", &[]);
    let table = std::fs::read_to_string(place.path("out/sweep.csv")).unwrap();
    let finished = |line: &str| line.split(',').nth(5).unwrap().parse::<usize>().unwrap();
    let [every, natural, lit] = table.lines().skip(1).map(finished).collect::<Vec<_>>()[..] else {
        panic!("three variants in {table}")
    };
    let (narrow, wide) = if sky < print { (natural, lit) } else { (lit, natural) };
    assert!(narrow == 16 && wide > 16 && every == wide, "{sky} {print}: {table}");
}
