//! The check of programs: a right one conforms, and every planted slip is found by its name.

use inkwave::input::wave_kind::WaveKind;
use inkwave::solve::Silent;
use inkwave_bench::check::{Conformity, ConformityVerdict, KNOWN, KnownCase, check};
use inkwave_bench::external::ExternalTable;
use inkwave_bench::external::judge::ReadAnswer;
use serde_json::Value;
use std::path::Path;

/// The adapter of inkwave with a slip, the first argument; the second one lists the waves.
const SLIPPING: &str = r#"
import cmath, json, math, os, subprocess, sys
slip, waves, adapter = sys.argv[1:4]
if "--describe" in sys.argv:
    print(json.dumps({"program": "slipping", "waves": waves.split(",")}))
    sys.exit()
question = json.load(sys.stdin)
case = question["inputs"]
if slip == "radians":
    sine = math.sin(case["sigma_deg"])
    case["phi_deg"] = math.degrees(case["phi_deg"]) + (180 if sine < 0 else 0)
    case["sigma_deg"] = math.degrees(math.asin(abs(sine)))
if slip == "no_exit":
    case["n_out"] = 1.0
kept = f"{question['case']}-{question['wave']}-{case['n_out']}-{case['sigma_deg']}.json"
if not os.path.exists(kept):
    done = subprocess.run([sys.executable, adapter], input=json.dumps(question), stdout=subprocess.PIPE, text=True)
    with open(kept, "w") as file:
        file.write(done.stdout)
with open(kept) as file:
    answer = json.load(file)
k0, height = 2 * math.pi / case["wavelength"], case["H"]
polar, azimuth = math.radians(case["sigma_deg"]), math.radians(case["phi_deg"])
own = math.cos(polar)
for order in answer["orders"]:
    out = order["side"] == "transmitted"
    index = case["n_out"] if out else 1.0
    x = math.sin(polar) * math.cos(azimuth) + order["m"] * case["wavelength"] / case["L"][0]
    y = math.sin(polar) * math.sin(azimuth) + order["n"] * case["wavelength"] / case["L"][1]
    kappa = math.sqrt(max(index**2 - x * x - y * y, 0))

    def act(a, pair):
        a = complex(*a)
        if slip == "conjugate":
            a = a.conjugate()
        if slip == "plane" and out:
            a *= cmath.exp(-1j * k0 * kappa * height)
        if slip == "power":
            a = kappa / own * abs(a) ** 2
        if slip == "no_cosine":
            a = kappa * abs(a) ** 2
        if slip == "no_index":
            a = kappa / index / own * abs(a) ** 2
        if slip == "flux":
            a *= math.sqrt(kappa / own)
        if slip == "whole" and not out and order["m"] == order["n"] == 0:
            a += 1
        if slip == "h_field" and pair[1] == "p":
            a *= index
        if slip == "p_sign" and not out and pair[1] == "p":
            a = -a
        return [a.real, a.imag]

    amplitude = order["amplitude"]
    if question["wave"] == "scalar":
        order["amplitude"] = act(amplitude, "ss")
    else:
        other = {"s": "p", "p": "s"} if slip == "swapped" else {"s": "s", "p": "p"}
        order["amplitude"] = {a: {b: act(amplitude[other[a]][other[b]], a + b) for b in "sp"} for a in "sp"}
    if slip == "sides":
        order["side"] = "reflected" if out else "transmitted"
    if slip == "transposed":
        order["m"], order["n"] = order["n"], order["m"]
    if slip == "signs":
        order["m"], order["n"] = -order["m"], -order["n"]
    if slip == "nonsense":
        order["amplitude"] = [0.3, 0.4]
if slip == "short":
    answer["orders"].pop()
print(json.dumps(answer))
"#;

/// Checks the adapter with a slip; answers without it are kept in the folder for the next one.
fn checked(folder: &Path, slip: &str, waves: &str) -> Conformity {
    std::fs::write(folder.join("slipping.py"), SLIPPING).expect("written");
    let adapter = concat!(env!("CARGO_MANIFEST_DIR"), "/python/adapters/inkwave_solve.py");
    let program = concat!("INKWAVE=", env!("CARGO_BIN_EXE_inkwave"));
    let command = ["env", program, "python3", "slipping.py", slip, waves, adapter].map(String::from).to_vec();
    let name = "slipping".into();
    let knob = vec![1e-3];
    let program = ExternalTable { name, command, knob, time_limit_s: 120.0, memory_gb: 4.0 };
    check(&program, folder, &mut Silent).expect("not stopped")
}

fn is_found(folder: &Path, slip: &str, waves: &str, name: &str) {
    match checked(folder, slip, waves).verdict {
        ConformityVerdict::Slips(found) => {
            let names: Vec<&str> = found.iter().map(|slip| slip[0].as_str()).collect();
            assert_eq!(names, [name], "{slip}");
        }
        other => panic!("{slip}: {other:?}"),
    }
}

#[test]
fn a_right_program_conforms_and_slips_of_the_scalar_wave_are_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let right = checked(folder.path(), "none", "scalar");
    assert_eq!(right.verdict, ConformityVerdict::Conforms, "{:?}", right.cases);
    assert_eq!(right.cases.iter().filter(|(_, result)| result.is_ok()).count(), 3);
    for (slip, name) in [
        ("conjugate", "complex conjugate"),
        ("plane", "transmitted phases referred to z = 0"),
        ("sides", "sides swapped"),
        ("power", "power instead of amplitude"),
        ("no_cosine", "power not divided by the cosine of incidence"),
        ("no_index", "power without the index of the exit medium"),
        ("flux", "amplitudes normalised by flux"),
        ("transposed", "orders transposed"),
        ("signs", "orders with the opposite sign"),
        ("whole", "incident wave left in the reflected order (0, 0)"),
        ("radians", "degrees read as radians"),
        ("no_exit", "exit medium ignored"),
    ] {
        is_found(folder.path(), slip, "scalar", name);
    }
    for slip in ["nonsense", "short"] {
        assert_eq!(checked(folder.path(), slip, "scalar").verdict, ConformityVerdict::Unknown, "{slip}");
    }
}

#[test]
fn slips_of_polarisations_are_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let right = checked(folder.path(), "none", "vector");
    assert_eq!(right.verdict, ConformityVerdict::Conforms, "{:?}", right.cases);
    for (slip, name) in [
        ("swapped", "s and p swapped"),
        ("h_field", "index left out of p light in the exit medium"),
        ("p_sign", "reflected p with the opposite sign"),
    ] {
        is_found(folder.path(), slip, "vector", name);
    }
}

/// inkwave's own answers, with which programs are compared, against other methods: see `check.json`.
#[test]
fn the_known_answers_are_those_of_other_programs() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/validation/data/check.json");
    let known: Value = serde_json::from_str(&std::fs::read_to_string(path).expect("read")).expect("JSON");
    for name in KNOWN {
        let other = &known[name];
        let wave = if other["wave"] == "vector" { WaveKind::Vector } else { WaveKind::Scalar };
        let own = KnownCase::new(name, wave).orders(&mut Silent).expect("solved");
        let answer = ReadAnswer::of(other["answer"].to_string().as_bytes(), "").expect("an answer");
        let error = answer.error(&own).expect("all orders");
        // 1e-3 is what the check asks of inkwave; the other program adds the change of its last refinement.
        let bound = 1e-3 + other["change_from_coarser"].as_f64().expect("a number");
        assert!(error < bound, "{name}: {error:.1e} above {bound:.1e}");
    }
}
