//! Programs of other projects as rows of a comparison, whatever they do.

use inkwave::compare::experiment::ComparisonFile;
use inkwave::compare::external::protocol::judge;
use inkwave::compare::row::Row;
use inkwave::schema::Document;
use inkwave::solve::{Registry, Silent};
use inkwave::wave::{FarField, Incidence, Order, Side};
use num_complex::Complex64;
use proptest::prelude::*;
use serde_json::{Value, json};
use std::path::Path;
use std::time::Instant;

/// Solves films of one layer under normal light; the first argument says what else it does.
const ADAPTER: &str = r#"
import cmath, json, os, sys, time
mood = sys.argv[1]
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
question = json.load(sys.stdin)
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
print(json.dumps({"orders": orders}))
"#;

fn rows(mood: &str, more: &str) -> Vec<Row> {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("written");
    write("adapter.py", ADAPTER);
    write(
        "film.json",
        r#"{ "wavelength": 0.5, "layers_from_z0": [{ "thickness": 0.2, "eta": [1.5, 0.1] }] }"#,
    );
    let lists = "strategies = ['krylov']\nschemes = ['cubic']\nresolutions = [{ points = 1, cells = 4 }]\nrepeats = 1\n";
    let external =
        format!("[[external]]\nname = 'own'\ncommand = ['python3', 'adapter.py', '{mood}']\n{more}\n");
    write("films.toml", &format!("case = 'film.json'\n{lists}{external}"));
    let file = ComparisonFile::read(&folder.path().join("films.toml")).expect("read");
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
        let (wall, processors) = (row.seconds.expect("s"), row.processor_seconds);
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
    let (orders, period_um) = (vec![order], [1.0; 2]);
    FarField { incidence, period_um, orders, reflectance: 0.05, transmittance: 0.65, absorptance: 0.3 }
}

const GOOD: &str = r#"{"orders":[{"m":0,"side":"reflected","amplitude":[0.1,0.2]},{"m":0,"n":0,"side":"transmitted","amplitude":[0.8,0.1]}]}"#;

proptest! {
    /// Anything that a program can print is an error or a finite number.
    #[test]
    fn any_output_is_survived(bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
        let _ = judge(&bytes, &truth());
    }

    /// The same for a good answer with some bytes changed.
    #[test]
    fn any_damage_is_survived(changes in proptest::collection::vec((0..GOOD.len(), any::<u8>()), 0..4)) {
        let mut bytes = GOOD.as_bytes().to_vec();
        changes.iter().for_each(|(at, byte)| bytes[*at] = *byte);
        let judged = judge(&bytes, &truth());
        prop_assert!(judged.is_err() || judged.is_ok_and(f64::is_finite));
    }
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
    let [question, answer, refusal] = &blocks[..] else { panic!("question, answer and refusal") };
    let schema = Document::External.schema();
    let judge = jsonschema::validator_for(&schema).expect("a schema");
    for answer in [answer, refusal] {
        let both = json!({ "request": question, "answer": answer });
        assert!(judge.is_valid(&both), "{both}");
    }
    assert!(!judge.is_valid(&json!({ "request": question, "answer": { "orders": 3 } })));
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("schema/external.json");
    let committed = std::fs::read_to_string(path).unwrap_or_default();
    let committed: Value = serde_json::from_str(&committed).unwrap_or_default();
    assert_eq!(committed, schema, "inkwave schema external > schema/external.json");
}

#[test]
fn a_good_answer_is_judged() {
    assert_eq!(judge(GOOD.as_bytes(), &truth()), Ok(0.0));
    assert!(judge("[".repeat(100_000).as_bytes(), &truth()).is_err());
}
