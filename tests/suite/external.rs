//! Programs of other projects as rows of a comparison, whatever they do.

use inkwave::schema::Document;
use inkwave::solve::{Registry, Silent};
use inkwave::store::folder::OutputFolder;
use inkwave::store::marker::Holds;
use inkwave::wave::{FarField, Incidence, Order, Side};
use inkwave_bench::experiment::ComparisonFile;
use inkwave_bench::external::judge::{ReadAnswer, expected};
use inkwave_bench::row::Row;
use num_complex::Complex64;
use proptest::prelude::*;
use serde_json::{Value, json};
use std::path::Path;
use std::time::Instant;

/// Solves films of one layer under normal light; the first argument says what else it does.
const ADAPTER: &str = r#"
import cmath, json, os, subprocess, sys, time
mood = sys.argv[1]
if sys.argv[-1] == "--describe" and mood in ("spheres", "busy"):
    shapes = ["spheres"] if mood == "spheres" else ["films", "bars"]
    print(json.dumps({"program": "own 1", "waves": ["scalar"], "shapes": shapes}))
    sys.exit(0)
if mood == "die":
    sys.exit("out of luck")
if mood == "hang":
    if os.fork() == 0:
        time.sleep(600)
    time.sleep(600)
if mood == "flood":
    while True:
        sys.stdout.write("x" * 1000000)
if mood == "eat":
    held = bytearray(os.urandom(1000) * 600000)
    time.sleep(600)
if mood == "babble":
    sys.stdout.buffer.write(bytes(range(256)) * 40)
    sys.exit(0)
if sys.argv[-1] == "--describe" and mood in ("daemon", "bare", "delegate"):
    sys.exit("no description")
BURN = "import os, time\nwhile time.process_time() < 0.4: pass\nopen('burnt', 'w').close()\ntime.sleep(600)"
if mood in ("daemon", "bare"):
    # Session, parent and, if bare, the environment are left behind.
    if os.fork() == 0:
        os.setsid()
        time.sleep(0.2 if mood == "bare" else 0)
        daemon = os.fork()
        if daemon:
            with open("daemon", "w") as file:
                file.write(str(daemon))
            os._exit(0)
        environment = {} if mood == "bare" else dict(os.environ)
        os.execve(sys.executable, [sys.executable, "-c", BURN], environment)
    while not os.path.exists("burnt"):
        time.sleep(0.01)
    # A look of the measurement between the daemon's work and the answer.
    time.sleep(0.2)
if mood == "delegate":
    # One after another, so that their sum is more than any of them has while it runs.
    burn = "import time\nwhile time.process_time() < 0.12: pass"
    for _ in range(4):
        subprocess.run([sys.executable, "-c", burn])
question = json.load(sys.stdin)
if mood == "other":
    print(json.dumps({"case": "another", "orders": []}))
    sys.exit(0)
if mood == "late":
    print(json.dumps({"seconds": -1, "orders": []}))
    sys.exit(0)
if mood == "refuse":
    print(json.dumps({"refusal": "no films,\nplease \x1b[31m"}))
    sys.exit(0)
case = question["inputs"]
film = case["layers_from_z0"][0]
n, k0, h = complex(*film["eta"]), 2 * cmath.pi / case["wavelength"], film["thickness"]
r, t = (1 - n) / (1 + n), 2 / (1 + n)
phase = cmath.exp(1j * n * k0 * h)
reflected = r * (1 - phase ** 2) / (1 - r ** 2 * phase ** 2)
transmitted = t * (2 * n / (1 + n)) * phase / (1 - r ** 2 * phase ** 2)
reflected += 0 if question["knob"] is None else 10 ** -question["knob"]
order = lambda side, a: {"m": 0, "n": 0, "side": side, "amplitude": [a.real, a.imag]}
orders = [order("reflected", reflected), order("transmitted", transmitted)]
if mood == "short":
    orders.pop()
if mood == "twice":
    orders.append(orders[0])
if mood == "nan":
    orders[0]["amplitude"][0] = float("nan")
if mood == "huge":
    print(json.dumps({"orders": orders}).replace("0.", "1e999", 1))
    sys.exit(0)
if mood == "busy":
    end = time.process_time() + 0.3
    while time.process_time() < end:
        pass
print(json.dumps({"orders": orders, "seconds": 0.25, "case": question["case"]}))
"#;

/// The largest error of a program's output.
fn judge(output: &[u8], truth: &[FarField]) -> Result<f64, String> {
    ReadAnswer::of(output, "")?.error(&expected(truth))
}

fn rows(mood: &str, more: &str) -> Vec<Row> {
    rows_in(tempfile::tempdir().expect("a folder").path(), mood, more)
}

fn rows_in(folder: &Path, mood: &str, more: &str) -> Vec<Row> {
    let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).expect("written");
    write("adapter.py", ADAPTER);
    write(
        "film.json",
        r#"{ "wavelength": 0.5, "layers_from_z0": [{ "thickness": 0.2, "eta": [1.5, 0.1] }] }"#,
    );
    let lists = "strategies = ['krylov']\nschemes = ['cubic']\nresolutions = [{ points = 1, cells = 4 }]\nrepeats = 1\n";
    let external =
        format!("[[external]]\nname = 'own'\ncommand = ['python3', 'adapter.py', '{mood}']\n{more}\n");
    write("films.toml", &format!("case = 'film.json'\n{lists}{external}"));
    let file = ComparisonFile::read(&folder.join("films.toml")).expect("read");
    let comparison = file.run(&Registry::default(), &mut Silent, |_| ()).expect("compared");
    assert_eq!(comparison.asked, comparison.rows.len());
    comparison.rows.into_iter().filter(|row| row.strategy == "own").collect()
}

/// The knob's error is found again, and the cost of the whole process.
#[test]
fn programs_are_rows_with_their_errors_and_costs() {
    let knobs = rows("busy", "knob = [2, 4]");
    for (row, knob) in knobs.iter().zip([2.0, 4.0]) {
        let error = *row.result.as_ref().expect("a result");
        assert!((error - 10_f64.powf(-knob)).abs() < 1e-9, "knob {knob}: {error:.3e}");
        assert_eq!(row.knob, Some(knob));
        assert_eq!(row.own_seconds, Some(0.25));
        let wall = row.seconds.expect("s");
        let processors = row.processor_seconds;
        assert!(wall > 0.3, "{wall} s");
        // Python's own megabytes and its busy wait, to the ticks of 10 ms
        if cfg!(target_os = "linux") {
            assert!(processors.is_some_and(|s| s > 0.28), "{processors:?} s");
            assert!((1_000_000..500_000_000).contains(&row.bytes), "{} bytes", row.bytes);
        }
    }
    let [plain] = &rows("plain", "")[..] else { panic!("one row") };
    assert!(plain.result.as_ref().is_ok_and(|error| *error < 1e-9), "{:?}", plain.result);
}

#[test]
fn whatever_programs_do_is_a_row_with_its_reason() {
    let clock = Instant::now();
    for (mood, more, told) in [
        ("die", "", "out of luck"),
        ("hang", "time_limit_s = 1", "time_limit_s = 1 s"),
        ("flood", "", "printed more than"),
        ("babble", "", "the answer is not as"),
        ("refuse", "", "refused: no films, please"),
        ("other", "", "the answer is to another case"),
        ("late", "", "`seconds` is -1"),
        ("spheres", "", "not asked: it describes itself as without films"),
        ("short", "", "the transmitted order (0, 0)"),
        ("twice", "", "answered twice"),
        ("nan", "", "the answer is not as"),
        ("huge", "", "the answer is not as"),
    ] {
        let [row] = &rows(mood, more)[..] else { panic!("one row") };
        assert!(row.outcome().contains(told), "{mood}: {}", row.outcome());
        assert!(!row.outcome().contains('\u{1b}'), "{mood}: {}", row.outcome());
    }
    if cfg!(target_os = "linux") {
        let [row] = &rows("eat", "memory_gb = 0.2")[..] else { panic!("one row") };
        assert!(row.outcome().contains("memory_gb = 0.2 GB"), "{}", row.outcome());
    }
    assert!(clock.elapsed().as_secs() < 300, "nothing waits for a program that hangs");
}

/// What a program's children have used is its own, whether it waits for them or not. *Planted*: processor time without that
/// of children that have ended.
#[cfg(target_os = "linux")]
#[test]
fn a_program_costs_what_its_children_cost() {
    for mood in ["delegate", "daemon", "bare"] {
        let [row] = &rows(mood, "")[..] else { panic!("one row") };
        assert!(row.converged(), "{mood}: {}", row.outcome());
        // 0.4 s in a daemon, or 0.12 s in each of four children, to some ticks of 10 ms
        let seconds = row.processor_seconds.expect("a processor clock");
        assert!(seconds > 0.38, "{mood}: {seconds} s");
    }
}

/// A daemon leaves its parent, group and session, and may drop its environment. *Planted*: the end of the group alone.
#[cfg(target_os = "linux")]
#[test]
fn nothing_that_a_program_started_outlives_its_row() {
    for mood in ["daemon", "bare"] {
        let folder = tempfile::tempdir().expect("a folder");
        let [row] = &rows_in(folder.path(), mood, "")[..] else { panic!("one row") };
        assert!(row.converged(), "{mood}: {}", row.outcome());
        let number = std::fs::read_to_string(folder.path().join("daemon")).expect("a daemon was started");
        // A process that was killed is gone, or a zombie until its parent looks.
        let state = std::fs::read_to_string(format!("/proc/{number}/stat")).unwrap_or_default();
        let running = state.rsplit_once(')').is_some_and(|(_, rest)| !rest.trim_start().starts_with('Z'));
        assert!(!running, "{mood}: {state}");
    }
}

#[test]
fn tables_that_cannot_be_run_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("slip.toml");
    for (table, told) in [
        ("name = 'krylov'\ncommand = ['true']", "external.name"),
        ("name = 'own'\ncommand = []", "external.command"),
        ("name = 'own'\ncommand = ['true']\ntime_limit_s = 0", "external.time_limit_s"),
        ("name = 'own'\ncommand = ['true']\nmemory_gb = -1", "external.memory_gb"),
        ("name = 'own'\ncommand = ['true']\nknob = [nan]", "external.knob"),
    ] {
        std::fs::write(&path, format!("case = 'film.json'\n[[external]]\n{table}\n")).expect("written");
        let error = match ComparisonFile::read(&path) {
            Ok(file) => file.plan(&Registry::default()).map(drop),
            Err(error) => Err(error),
        };
        let error = error.expect_err(table).to_string();
        assert!(error.contains(told), "{table}: {error}");
    }
}

#[test]
fn a_program_that_is_not_there_is_a_row() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("written");
    write(
        "film.json",
        r#"{ "wavelength": 0.5, "layers_from_z0": [{ "thickness": 0.2, "eta": [1.5, 0.1] }] }"#,
    );
    let lists = "strategies = ['krylov']\nresolutions = [{ points = 1, cells = 4 }]\nrepeats = 1\n";
    let external = "[[external]]\nname = 'own'\ncommand = ['./no such program']\n";
    write("films.toml", &format!("case = 'film.json'\n{lists}{external}"));
    let run = |path: &Path| {
        let file = ComparisonFile::read(path).expect("read");
        file.run(&Registry::default(), &mut Silent, |_| ()).expect("compared")
    };
    let comparison = run(&folder.path().join("films.toml"));
    let last = comparison.rows.last().expect("a row");
    assert!(last.outcome().contains("cannot be started"), "{}", last.outcome());
}

/// Maxwell's equations: a program's four amplitudes beside inkwave's strategies, of a film in s and p light, and a
/// strategy without them as a row with the reason.
#[test]
fn vector_cases_have_amplitudes_of_each_polarisation() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("written");
    let film = r#"{ "wavelength": 0.5, "sigma_deg": 40, "layers_from_z0": [{ "thickness": 0.2, "eta": [1.5, 0.1] }] }"#;
    write("film.json", film);
    let adapter = concat!(env!("CARGO_MANIFEST_DIR"), "/python/adapters/inkwave_solve.py");
    let command = format!("['env', 'INKWAVE={}', 'python3', '{adapter}']", env!("CARGO_BIN_EXE_inkwave"));
    let cases = ["scalar", "vector"]
        .map(|wave| format!("[[cases]]\nfile = 'film.json'\nname = '{wave}'\nwave = '{wave}'\n"));
    let lists =
        "strategies = ['krylov', 'relaxation']\nresolutions = [{ points = 1, cells = 4 }]\nrepeats = 1\n";
    write(
        "films.toml",
        &format!("{lists}{}[[external]]\nname = 'own'\ncommand = {command}\n", cases.concat()),
    );
    let file = ComparisonFile::read(&folder.path().join("films.toml")).expect("read");
    let plan = file.plan(&Registry::default()).expect("planned");
    let comparison = file.run(&Registry::default(), &mut Silent, |_| ()).expect("compared");
    assert_eq!((plan.rows, comparison.rows.len()), (comparison.asked, comparison.asked));
    let of = |name: &str, case: &str| -> Vec<&Row> {
        let own = |row: &&Row| row.strategy == name && row.named.as_deref() == Some(case);
        comparison.rows.iter().filter(own).collect()
    };
    for case in ["scalar", "vector"] {
        for name in ["krylov", "own"] {
            let rows = of(name, case);
            // Identity: films are exact with the absorbing mean; the program prints all digits.
            let exact = |row: &&Row| row.result.as_ref().is_ok_and(|error| *error < 1e-9);
            assert!(rows.iter().any(exact), "{name}, {case}: {rows:?}");
        }
    }
    assert!(of("relaxation", "vector")[0].outcome().contains("moments"));
    let output = OutputFolder::open(&folder.path().join("out"), Holds::Comparison).expect("a folder");
    comparison.write(&output).expect("written");
    let page = std::fs::read_to_string(folder.path().join("out/README.md")).expect("the page");
    assert!(page.contains("## Cost of an accuracy") && page.contains("inkwave solve"), "{page}");
}

/// One order on both sides.
fn truth() -> FarField {
    let incidence = Incidence { wavelength_um: 0.5, polar_deg: 0.0, azimuth_deg: 0.0, from: Side::Incident };
    let order = Order {
        m: 0,
        n: 0,
        direction: [0.0; 2],
        reflected_propagates: true,
        transmitted_propagates: true,
        reflected: Complex64::new(0.1, 0.2),
        transmitted: Complex64::new(0.8, 0.1),
        reflected_efficiency: 0.05,
        transmitted_efficiency: 0.65,
        further: Default::default(),
    };
    let orders = vec![order];
    let period_um = [1.0; 2];
    FarField {
        incidence,
        period_um,
        orders,
        reflectance: 0.05,
        transmittance: 0.65,
        absorptance: 0.3,
        absorbed: Vec::new(),
    }
}

const GOOD: &str = r#"{"orders":[{"m":0,"side":"reflected","amplitude":[0.1,0.2]},{"m":0,"n":0,"side":"transmitted","amplitude":[0.8,0.1]}]}"#;

proptest! {
    /// Anything that a program can print is an error or a finite number.
    #[test]
    fn any_output_is_survived(bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
        let _ = judge(&bytes, &[truth()]);
    }

    /// The same for a good answer with some bytes changed.
    #[test]
    fn any_damage_is_survived(changes in proptest::collection::vec((0..GOOD.len(), any::<u8>()), 0..4)) {
        let mut bytes = GOOD.as_bytes().to_vec();
        changes.iter().for_each(|(at, byte)| bytes[*at] = *byte);
        let judged = judge(&bytes, &[truth()]);
        prop_assert!(judged.is_err() || judged.is_ok_and(f64::is_finite));
    }
}

/// The same order of the vector wave, s and p light.
const GOOD_VECTOR: &str = r#"{"seconds":0.5,"orders":[{"m":0,"side":"reflected","amplitude":{"s":{"s":[0.1,0.2],"p":[0,0]},"p":{"s":[0,0],"p":[0.1,0.2]}}},{"m":0,"n":0,"side":"transmitted","amplitude":{"s":{"s":[0.8,0.1],"p":[0,0]},"p":{"s":[0,0],"p":[0.8,0.1]}}}]}"#;

proptest! {
    /// Damaged answers to vector cases, judged as either wave.
    #[test]
    fn any_damage_of_polarised_answers_is_survived(
        changes in proptest::collection::vec((0..GOOD_VECTOR.len(), any::<u8>()), 0..4),
    ) {
        let mut bytes = GOOD_VECTOR.as_bytes().to_vec();
        changes.iter().for_each(|(at, byte)| bytes[*at] = *byte);
        for truth in [&[truth()][..], &[truth(), truth()]] {
            let judged = judge(&bytes, truth);
            prop_assert!(judged.is_err() || judged.is_ok_and(f64::is_finite));
        }
    }
}

#[test]
fn answers_with_the_amplitudes_of_the_other_wave_are_refused() {
    assert_eq!(judge(GOOD_VECTOR.as_bytes(), &[truth(), truth()]), Ok(0.0));
    let four = judge(GOOD_VECTOR.as_bytes(), &[truth()]).expect_err("four for one");
    assert!(four.contains("has 4 complex amplitude(s) instead of 1"), "{four}");
    assert!(judge(GOOD.as_bytes(), &[truth(), truth()]).is_err_and(|told| told.contains("instead of 4")));
}

/// The committed schema is what the program prints, and question and answer of the page fit it.
#[test]
fn the_page_of_the_protocol_is_true() {
    let page = Document::External.every_key();
    let blocks: Vec<Value> = page
        .split("```json\n")
        .skip(1)
        .map(|rest| serde_json::from_str(rest.split("```").next().expect("its end")).expect("JSON"))
        .collect();
    let [question, answer, vector, refusal, description] = &blocks[..] else { panic!("five examples") };
    let schema = Document::External.schema();
    let judge = jsonschema::validator_for(&schema).expect("a schema");
    for answer in [answer, vector, refusal] {
        let both = json!({ "request": question, "answer": answer, "description": description });
        assert!(judge.is_valid(&both), "{both}");
    }
    assert!(!judge.is_valid(&json!({ "request": question, "answer": { "orders": 3 }, "description": {} })));
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("schema/external.json");
    let committed = std::fs::read_to_string(path).unwrap_or_default();
    let committed: Value = serde_json::from_str(&committed).unwrap_or_default();
    assert_eq!(committed, schema, "inkwave schema external > schema/external.json");
}

#[test]
fn a_good_answer_is_judged() {
    assert_eq!(judge(GOOD.as_bytes(), &[truth()]), Ok(0.0));
    assert!(judge("[".repeat(100_000).as_bytes(), &[truth()]).is_err());
}
