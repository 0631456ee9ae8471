//! Golden numbers: everything that a run publishes, value by value, against values derived by other means.
//!
//! `validation/golden.py` (Python's standard library, nothing of this program) takes a study and its stored solves to every published
//! number: film, least squares, jackknife, paper, colour, error budget, picture. Here the program gets the same solves.
//! What the script has to be told again after the records changed is in its first lines.

use inkwave::evaluate::evaluated::FinishedSolves;
use inkwave::input::load::load;
use inkwave::report::publish::evaluate_and_publish;
use inkwave::run::collected::{Collected, Realisation};
use inkwave::run::resolve::Resolved;
use inkwave::store::folder::OutputFolder;
use inkwave::store::identity::METHOD_VERSION;
use inkwave::store::marker::Holds;
use inkwave::store::{PackingRecord, PointRecord};
use serde::Deserialize;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Relative and absolute: the same sums in another order, matrices instead of a recursion.
const ROUNDING: [f64; 2] = [1e-6, 2e-9];
/// The script interpolates the 5 nm rows of CIE's tables at the wavelengths solved, where the program reads rows of 1 nm. That
/// enters the colours' correction for what the spectra's fit leaves over, which is as large as 1 in Lab here.
const TABLES: [f64; 2] = [1e-3, 2e-4];

/// Columns that name a row.
const KEYS: [&str; 8] =
    ["wavelength_nm", "polar_deg", "from", "polar_in_deg", "azimuth_in_deg", "lobe", "m", "n"];

#[derive(Deserialize)]
struct Solves {
    grid: Resolved,
    realisations: Vec<Solved>,
}

#[derive(Deserialize)]
struct Solved {
    packing: PackingRecord,
    points: Vec<PointRecord>,
}

fn golden(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("validation/data/golden").join(name)
}

fn json(path: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(path).expect("a file")).expect("JSON")
}

/// What differs, with its place; a list of its own so that one run shows everything.
struct Ledger {
    faults: Vec<String>,
    tolerance: [f64; 2],
}

impl Ledger {
    fn new() -> Ledger {
        Ledger { faults: Vec::new(), tolerance: ROUNDING }
    }

    fn number(&mut self, place: &str, got: Option<f64>, want: Option<f64>) {
        let same = match (got, want) {
            (Some(got), Some(want)) => {
                let [relative, absolute] = self.tolerance;
                (got - want).abs() <= absolute + relative * got.abs().max(want.abs())
            }
            (None, None) => true,
            _ => false,
        };
        if !same {
            self.faults.push(format!("{place}: {got:?} instead of {want:?}"));
        }
    }

    /// Every value of `want` against that of the same name in `got`; an estimate is [value, standard error] in `want`.
    fn value(&mut self, place: &str, got: &Value, want: &Value) {
        match (got, want) {
            (_, Value::Object(fields)) => {
                fields
                    .iter()
                    .for_each(|(name, want)| self.value(&format!("{place}.{name}"), &got[name], want));
            }
            (Value::Object(estimate), Value::Array(pair)) => {
                self.value(place, &estimate["value"], &pair[0]);
                self.value(&format!("{place} error"), &estimate["standard_error"], &pair[1]);
            }
            (Value::Array(got), Value::Array(want)) if got.len() == want.len() => {
                got.iter().zip(want).for_each(|(got, want)| self.value(place, got, want));
            }
            (Value::Number(_) | Value::Null, Value::Number(_) | Value::Null) => {
                self.number(place, got.as_f64(), want.as_f64());
            }
            (got, want) if got == want => {}
            _ => self.faults.push(format!("{place}: {got} instead of {want}")),
        }
    }

    /// A table against rows of values in the order of its columns; rows may end early where the rest is empty.
    fn table(&mut self, path: &Path, want: &Value) {
        let mut table = csv::Reader::from_path(path).expect("a table");
        let header = table.headers().expect("a header").clone();
        let rows: Vec<csv::StringRecord> = table.records().map(|row| row.expect("a row")).collect();
        let want: Vec<&Vec<Value>> =
            want.as_array().expect("rows").iter().filter_map(Value::as_array).collect();
        let name = path.file_name().expect("a name").display().to_string();
        if rows.len() != want.len() {
            return self.faults.push(format!("{name}: {} rows instead of {}", rows.len(), want.len()));
        }
        let text = |value: &Value| value.as_str().map_or(value.to_string(), str::to_owned);
        let short = |text: &str| text.parse::<f64>().map_or(text.to_owned(), |x| format!("{x:.5}"));
        // The order of rows is no number: the first columns name them.
        let naming = header.iter().position(|c| KEYS.iter().all(|key| *key != c)).unwrap_or(0);
        let place_of = |cell: &dyn Fn(usize) -> String| {
            (0..naming).map(|i| short(&cell(i))).collect::<Vec<_>>().join("/")
        };
        for want in want {
            let place = place_of(&|i| text(&want[i]));
            let Some(row) = rows.iter().find(|row| place_of(&|i| row[i].to_owned()) == place) else {
                self.faults.push(format!("{name}: no row {place}"));
                continue;
            };
            for (i, column) in header.iter().enumerate() {
                let want = want.get(i).unwrap_or(&Value::Null);
                let place = format!("{name}, {column} at {place}");
                match row[i].parse::<f64>() {
                    Ok(number) => self.number(&place, Some(number), want.as_f64()),
                    Err(_) if row[i].is_empty() => self.number(&place, None, want.as_f64()),
                    Err(_) if row[i] == text(want) => {}
                    Err(_) => self.faults.push(format!("{place}: {} instead of {want}", &row[i])),
                }
            }
        }
    }

    /// One step of 255 is rounding.
    fn picture(&mut self, path: &Path, want: &Value) {
        let file = std::fs::File::open(path).expect("a picture");
        let mut reader = png::Decoder::new(std::io::BufReader::new(file)).read_info().expect("PNG");
        let mut pixels = vec![0; reader.output_buffer_size().expect("a size")];
        let frame = reader.next_frame(&mut pixels).expect("a frame");
        let samples = frame.line_size / frame.width as usize;
        let at = |x: usize, y: usize| &pixels[y * frame.line_size + x * samples..][..3];
        let rows = |key: &str| want[key].as_array().expect("rows").clone();
        let strip = rows("strip");
        let square = rows("square");
        let left = frame.width as usize - square.len();
        for (y, (strip, row)) in strip.iter().zip(&square).enumerate() {
            let row = row.as_str().expect("hexadecimal digits");
            let wanted = row.as_bytes().chunks(6).enumerate().map(|(x, colour)| (left + x, colour));
            for (x, colour) in wanted.chain([(0, strip.as_str().expect("a colour").as_bytes())]) {
                let colour = std::str::from_utf8(colour).expect("ASCII");
                let channel =
                    |c: usize| i32::from_str_radix(&colour[2 * c..2 * c + 2], 16).expect("two digits");
                if (0..3).any(|c| (i32::from(at(x, y)[c]) - channel(c)).abs() > 1) {
                    self.faults.push(format!("pixel ({x}, {y}): {:?} instead of {colour}", at(x, y)));
                }
            }
        }
    }

    fn close(self, name: &str) {
        let shown = self.faults.iter().take(60).cloned().collect::<Vec<_>>().join("\n");
        assert!(self.faults.is_empty(), "{name}: {} values differ, such as\n{shown}", self.faults.len());
    }
}

/// Publishes the kept solves of a study and compares all of it.
fn compare(name: &str, colours: [f64; 2]) {
    let study = load(&golden(&format!("{name}.toml"))).expect("a study");
    let solves: Solves = serde_json::from_value(json(&golden(&format!("{name}-solves.json"))))
        .expect("solves of today's form");
    let whole = |Solved { packing, points }: Solved| {
        assert_eq!(points.len(), study.solves_each());
        Realisation {
            packing,
            points: points.into_iter().map(Some).collect(),
            finer: Vec::new(),
            moved: Vec::new(),
            failures: Vec::new(),
        }
    };
    let realisations = solves.realisations.into_iter().map(whole).collect();
    let resolved = solves.grid;
    let refused = Vec::new();
    let damages = Vec::new();
    let collected =
        Collected { resolved, realisations, refused, enough: false, substacks: Vec::new(), damages };
    let place = tempfile::tempdir().expect("a folder");
    let out = place.path().join("out");
    let folder = OutputFolder::open(&out, Holds::Study).expect("a folder");
    evaluate_and_publish(&study, &FinishedSolves::Whole(Box::new(collected)), &folder).expect("published");
    let results = json(&out.join("results.json"));
    let want = json(&golden(&format!("{name}.json")));
    let mut ledger = Ledger::new();
    ledger.value("certainty", &results["certainty"], &want["certainty"]);
    ledger.tolerance = colours;
    ledger.value("colours", &results["colours"], &want["colours"]);
    let maker = &want["ink_maker"];
    for key in ["print", "over_black", "over_white", "contrast_ratio"] {
        ledger.value(key, &results["ink_maker"][key], &maker[key]);
    }
    if maker.get("target").is_some() {
        ledger.value("target", &results["ink_maker"]["target"]["delta_e_2000"], &maker["target"]);
    }
    ledger.tolerance = ROUNDING;
    // none of the layers scatters enough for K and S
    assert!(!out.join("kubelka-munk.csv").exists());
    ledger.table(&out.join("spectra.csv"), &want["spectra"]);
    ledger.table(&out.join("bdf.csv"), &want["bdf"]);
    ledger.picture(&out.join("picture.png"), &want["picture"]);
    ledger.close(name);
}

#[test]
fn a_film_has_its_golden_numbers() {
    compare("film", ROUNDING);
}

#[test]
fn fixed_cells_have_their_golden_numbers() {
    compare("fixed", ROUNDING);
}

#[test]
fn varied_cells_have_their_golden_numbers() {
    compare("varied", TABLES);
}

/// Films of two shares on two papers, through the program: solved, collected, compared with the reference variant.
#[test]
fn a_sweep_has_its_golden_numbers() {
    let place = tempfile::tempdir().expect("a folder");
    let out = place.path().join("out");
    let mut inkwave = Command::new(env!("CARGO_BIN_EXE_inkwave"));
    inkwave
        .env_remove("SLURM_ARRAY_TASK_ID")
        .arg("sweep")
        .arg(golden("sweep.toml"))
        .arg("--output")
        .arg(&out);
    let done = inkwave.output().expect("the program starts");
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let want = json(&golden("sweep.json"));
    let mut table = csv::Reader::from_path(out.join("sweep.csv")).expect("a table");
    let header = table.headers().expect("a header").clone();
    let mut ledger = Ledger::new();
    let rows: Vec<csv::StringRecord> = table.records().map(|row| row.expect("a row")).collect();
    assert_eq!(rows.len(), want["variants"].as_array().expect("variants").len());
    for (row, want) in rows.iter().zip(want["variants"].as_array().expect("variants")) {
        for (column, cell) in header.iter().zip(row) {
            // Solved to a residual of 1e-12 with an exact scheme; ten digits remain.
            if let Some(want) = want.get(column) {
                ledger.number(&format!("{}, {column}", &row[0]), cell.parse().ok(), want.as_f64());
            }
        }
    }
    let mut conclusions = csv::Reader::from_path(out.join("conclusions.csv")).expect("conclusions");
    let measured: Vec<csv::StringRecord> = conclusions.records().map(|row| row.expect("a row")).collect();
    let wanted = want["conclusions"].as_array().expect("conclusions");
    assert_eq!(measured.len(), wanted.len());
    for (row, want) in measured.iter().zip(wanted) {
        ledger.number(&row[2], row[3].parse().ok(), want.as_f64());
    }
    ledger.close("sweep");
}

/// The golden numbers of every method: the version, and the digest of the files that hold them. A line is added, never changed.
// Method 3 draws other cells, method 4 corrects for the grid where a target is wanted, method 5 packs crowded cells that jammed,
// method 6 fits spectra of many cells with narrower splines: what follows from given solves is as in method 2. Method 7 takes the
// derivatives of colours from the whole ensemble, and the profile of a relief refers to the whole height.
// Method 8 cuts the slabs of composed layers out of packings. Method 10 follows the fringes of composed layers at any thickness and in
// the series of the paper, takes Maxwell Garnett's index between their slabs, holds in every bar what listed wavelengths miss and the errors
// of index tables, publishes coherent transmittances, and gives distributions per steradian of the medium. Method 13 lets light from a paper
// in contact with a composed layer interfere beyond the critical angle. Method 16 gives the mean wave in composed layers no steps
// between an absorbing medium and the half-spaces that its slabs are solved between.
const METHODS: [(u32, &str); 18] = [
    (1, "f8549ee6fb120b47"),
    (2, "69a87c405875bd13"),
    (3, "69a87c405875bd13"),
    (4, "69a87c405875bd13"),
    (5, "69a87c405875bd13"),
    (6, "69a87c405875bd13"),
    (7, "02541369558a446c"),
    (8, "02541369558a446c"),
    (9, "02541369558a446c"),
    (10, "117470018adbff9c"),
    (11, "08d326a797070f78"),
    (12, "df5549a0389ca305"),
    (13, "df5549a0389ca305"),
    (14, "df5549a0389ca305"),
    (15, "df5549a0389ca305"),
    (16, "df5549a0389ca305"),
    (17, "b58296bd7fbca6ab"),
    (18, "b58296bd7fbca6ab"),
];

/// The script still reads the solves and comes to the numbers beside them. `varied` takes it a minute: by hand.
#[test]
fn the_script_comes_to_the_golden_numbers() {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("validation/golden.py");
    let done = Command::new("python3").arg(script).args(["--check", "film", "fixed", "sweep"]).output();
    let done = done.expect("python3");
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
}

/// Published numbers and the method's version change together, so that stored results of an older method are never taken for new ones.
#[test]
fn golden_numbers_change_with_the_version_of_the_method() {
    let mut hasher = blake3::Hasher::new();
    for name in ["film.json", "fixed.json", "varied.json", "sweep.json"] {
        let text = std::fs::read_to_string(golden(name)).expect("a file");
        hasher.update(text.replace("\r\n", "\n").as_bytes());
    }
    let digest = hasher.finalize().to_hex()[..16].to_owned();
    let versions: Vec<u32> = METHODS.iter().map(|(version, _)| *version).collect();
    assert!(versions.iter().copied().eq(1..=METHODS.len() as u32), "one line for each version: {versions:?}");
    assert_eq!(
        METHODS.last().map(|(version, digest)| (*version, (*digest).to_owned())),
        Some((METHOD_VERSION, digest)),
        "golden numbers and METHOD_VERSION (src/study/store/identity.rs) change together: count it up and add its line to METHODS"
    );
}
