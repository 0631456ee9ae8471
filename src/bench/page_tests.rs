use super::*;
use crate::row::Discrete;
use crate::solve::Account;
use crate::store::marker::Holds;
use crate::wave::{Resolution, Scheme};

fn row(case: &str, strategy: &str, knob: Option<f64>, result: Result<f64, &str>, seconds: f64) -> Row {
    let discrete = knob.is_none().then(|| Discrete {
        resolution: Resolution { nx: 8, ny: 8, cells: 4, scheme: Scheme::default() },
        absorbing_mean: false,
    });
    Row {
        named: Some(case.into()),
        knob,
        account: knob.is_none().then(Account::default),
        result: result.map_err(str::to_owned),
        seconds: Some(2.0 * seconds),
        processor_seconds: Some(seconds),
        bytes: 1_000_000,
        ..Row::new(None, strategy, discrete)
    }
}

fn comparison(cases: &[&str], externals: &[&str], rows: Vec<Row>) -> Comparison {
    let machine = Machine { processor: "a processor".into(), threads: 2, transforms_per_second: None };
    Comparison {
        title: "Two kinds of seconds".into(),
        file: "peers.toml".into(),
        reference: "the reference of each case".into(),
        cases: cases.iter().map(|case| [*case, "scalar", "its own"].map(str::to_owned)).collect(),
        accuracy: Some(1e-3),
        goal: Goal { tolerance: 1e-5, max_applications: 2000 },
        strategies: vec!["krylov".into()],
        externals: externals.iter().map(|name| (*name).to_owned()).collect(),
        programs: externals.iter().map(|_| ProgramDescription::default()).collect(),
        registry: vec!["krylov".into()],
        machine,
        asked: rows.len(),
        rows,
    }
}

/// A solve inside a running process and a whole process stand in tables and plots of their own, each saying which
/// seconds it has; what is not reached is so within the settings tried, with the best one. *Planted*: one table for both.
#[test]
fn seconds_of_solves_and_of_processes_are_kept_apart() {
    let rows = vec![
        row("film", "krylov", None, Ok(1e-5), 0.001),
        row("film", "treams", Some(3.0), Ok(2e-3), 10.0),
        row("film", "treams", Some(5.0), Ok(5e-4), 40.0),
        row("film", "meanas", Some(20.0), Err("killed: too slow"), 300.0),
    ];
    let comparison = comparison(&["film"], &["treams", "meanas"], rows);
    let place = tempfile::tempdir().unwrap();
    let folder = OutputFolder::open(&place.path().join("out"), Holds::Comparison).unwrap();
    comparison.write(&folder).unwrap();
    let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
    let page = read("README.md");
    let section = page.split("## Cost of an accuracy").nth(1).unwrap();
    let section = section.split("\n## ").next().unwrap();
    let (processes, solves) = section.split_once("Strategies of inkwave are the solve alone").unwrap();
    assert!(processes.contains("whole processes") && solves.contains("do not\ncompare"), "{section}");
    let reached =
        "| film | treams | 10.0\u{a0}s, 1\u{a0}MB | 40\u{a0}s, 1\u{a0}MB | not within those tried | 5.0e-4 |";
    assert!(processes.contains(reached), "{processes}");
    assert!(processes.contains("| film | meanas | – | – | – | – | killed: too slow |"), "{processes}");
    assert!(solves.contains("| film | krylov | ") && !solves.contains("treams"), "{solves}");
    assert!(!processes.contains("krylov"), "{processes}");
    let whole = read("error_against_cpu_seconds-1.svg");
    let alone = read("error_against_solve_seconds-1.svg");
    assert!(whole.contains("of the whole process") && whole.contains("treams") && !whole.contains("krylov"));
    assert!(alone.contains("of the solve alone") && alone.contains("krylov") && !alone.contains("treams"));
    let html = read("comparison.html");
    let tables = html.matches("<th>no result because</th>").count();
    assert_eq!(tables, 2, "one for each kind of seconds");
}
