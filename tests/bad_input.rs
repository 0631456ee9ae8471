//! Bad input: every fault is told with its field, what was found, what is allowed and what to try; the exit
//! code is not zero and nothing is written.

mod run_support;

use run_support::{TINY, run, study};
use std::path::Path;

/// A slip in the tiny study: what is replaced by what, and what the message must say.
struct Slip {
    from: &'static str,
    to: &'static str,
    /// Field, value found, allowed range, remedy.
    says: [&'static str; 4],
}

const fn slip(from: &'static str, to: &'static str, says: [&'static str; 4]) -> Slip {
    Slip { from, to, says }
}

const K: &str = "index = { built_in = \"yellow\" }";
const RANGE: &str = "from_nm = 400\nto_nm = 700\nstep_nm = 100";

const SLIPS: &[Slip] = &[
    // keys
    slip(
        "thickness_um",
        "thicknes_um",
        ["layer.thicknes_um", "unknown key", "`period_um`, `thickness_um`", "did you mean thickness_um?"],
    ),
    slip("[run]", "[runn]", ["runn", "unknown key", "`run`", "did you mean run?"]),
    slip(
        "built_in",
        "builtin",
        ["pigment[0].index.builtin", "unknown key", "`built_in`", "did you mean built_in?"],
    ),
    slip(
        "thickness_um = 0.5\n",
        "",
        ["layer.thickness_um", "found nothing", "no default", "add thickness_um"],
    ),
    slip("seed = 7", "seed = -7", ["run.seed", "-7", "a whole number from 0", "in that form"]),
    slip("seed = 7", "seed = \"7\"", ["run.seed", "string \"7\"", "a whole number from 0", "in that form"]),
    slip("[angles]", "[angles", ["[angles", "unclosed table", "expected `]`", "correct the TOML here"]),
    // layer
    slip(
        "period_um = 0.8",
        "period_um = [0.8, 0]",
        ["layer.period_um", "found 0", "greater than 0", "larger cells"],
    ),
    slip(
        "period_um = 0.8",
        "period_um = [1, 2, 3]",
        ["period_um", "3 entries", "two numbers [x, y]", "in that form"],
    ),
    slip(
        "thickness_um = 0.5",
        "thickness_um = nan",
        ["layer.thickness_um", "NaN", "at most 1000 µm", "about 1 µm"],
    ),
    slip(
        "thickness_um = 0.5",
        "thickness_um = inf",
        ["layer.thickness_um", "inf", "at most 1000 µm", "about 1 µm"],
    ),
    slip(
        "binder.index = 1.558",
        "binder.index = -1.5",
        ["layer.binder.index.n", "-1.5", "from 0.1 to 10", "refractive index"],
    ),
    slip(
        "thickness_um = 0.5",
        "thickness_um = 0.5\nindex_in = 1.5",
        ["layer.index_in", "1.5", "1, air above", "angles.polar_deg"],
    ),
    // pigments
    slip(
        K,
        "index = { n = 1.4, k = -0.1 }",
        ["pigment[0].index.k", "-0.1", "from 0 to 10", "change the sign"],
    ),
    slip(K, "index = { n = nan }", ["pigment[0].index.n", "NaN", "from 0.1 to 10", "refractive index"]),
    slip(
        K,
        "index = { k = 0.1 }",
        ["pigment[0].index", "found k alone", "{ n = …, k = … }", "index = { n = 1.4"],
    ),
    slip(
        K,
        "index = { built_in = \"mauve\" }",
        ["pigment[0].index.built_in", "mauve", "red, yellow, blue, green", "csv"],
    ),
    slip(
        K,
        "index = { csv = \"none.csv\" }",
        ["pigment[0].index.csv", "none.csv", "wavelength_nm,kappa", "relative to the study file"],
    ),
    slip(
        K,
        "index = { csv = \"negative.csv\" }",
        ["pigment[0].index.csv", "kappa = -0.2", "kappa ≥ 0", "correct the table"],
    ),
    slip(
        K,
        "index = { csv = \"empty.csv\" }",
        ["pigment[0].index.csv", "line 3, column kappa: an empty cell", "kappa ≥ 0", "correct the table"],
    ),
    slip(
        K,
        "index = { csv = \"micrometres.csv\" }",
        ["pigment[0].index.csv", "0.7: these look like µm", "the column wants nm", "multiply it by 1000"],
    ),
    slip(
        "[output]",
        "[paper]\nalbedo = [[0.4, 0.8], [0.7, 0.8]]\n[output]",
        ["paper.albedo", "up to 0.7, which look like µm", "wavelengths in nm", "by 1000"],
    ),
    slip(
        "[output]",
        "[compare]\nmeasured = \"comma.csv\"\n[output]",
        ["compare.measured", "line 2: 3 cells", "(wavelength_nm,reflectance)", "(wavelength_nm;reflectance)"],
    ),
    slip(
        K,
        "index = { csv = \"narrow.csv\" }",
        ["pigment[0].index", "400 nm", "from 500 to 600 nm", "[light]"],
    ),
    slip(
        "volume_fraction = 0.15",
        "volume_fraction = 1.5",
        ["pigment[0].volume_fraction", "1.5", "at most 0.64", "0.3 for 30 %"],
    ),
    slip(
        "volume_fraction = 0.15",
        "volume_fraction = 0.7",
        ["pigment[0].volume_fraction", "0.7", "at most 0.64", "0.3 for 30 %"],
    ),
    slip(
        "volume_fraction = 0.15",
        "volume_fraction = -0.1",
        ["pigment[0].volume_fraction", "-0.1", "greater than 0", "0.3 for 30 %"],
    ),
    slip(
        "diameter_nm = 200",
        "diameter_nm = -200",
        ["pigment[0].diameter_nm", "-200", "above 0", "50 to 500 nm"],
    ),
    slip(
        "diameter_nm = 200",
        "diameter_nm = 450",
        ["pigment[0].diameter_nm", "450", "half the shortest side that a varied cell gets", "larger cell"],
    ),
    slip(
        "thickness_um = 0.5",
        "thickness_um = 0.15",
        ["pigment[0].diameter_nm", "200", "150 nm, the layer's thickness", "smaller grains"],
    ),
    slip(
        "diameter_nm = 200",
        "diameter_nm = 1",
        ["pigment[0].diameter_nm", "may hold 1.2e8", "at most 5000000 grains in a cell", "sizes are in nm"],
    ),
    slip(
        "volume_fraction = 0.15",
        "volume_fraction = 1e-12",
        ["pigment[0].volume_fraction", "found 1e-12", "from 4.2e-9, which is half a grain", "smaller grains"],
    ),
    slip(
        "diameter_nm = 200",
        "diameter_nm = \"big\"",
        ["pigment[0].diameter_nm", "\"big\"", "a number of nm such as 250, or \"molecular\"", "in that form"],
    ),
    slip("diameter_nm = 200", "", ["pigment[0]", "neither", "diameter_nm or size", "diameter_nm = 250"]),
    slip(
        "name = \"yellow\"",
        "name = \" \"",
        ["pigment[0].name", "\" \"", "no other pigment", "another name"],
    ),
    slip(
        "name = \"yellow\"",
        "name = \"yellow\"\nshape = \"cube\"",
        ["shape", "cube", "`sphere`", "write one of"],
    ),
    // paper, light, angles
    slip(
        "[light]",
        "[paper]\nalbedo = 1.2\n[light]",
        ["paper.albedo", "1.2", "from 0 to 1", "0.9 is good paper"],
    ),
    slip("[light]", "[paper]\ncoupling = \"glue\"\n[light]", ["coupling", "glue", "`gap`", "write one of"]),
    slip(
        RANGE,
        "wavelengths_nm = []",
        ["light.wavelengths_nm", "0 entries", "1 to 10000 entries", "400 to 700"],
    ),
    slip(
        RANGE,
        "wavelengths_nm = [400, 300]",
        ["light.wavelengths_nm[1]", "300 after 400", "rising", "sort"],
    ),
    slip(
        RANGE,
        "wavelengths_nm = [450, nan]",
        ["light.wavelengths_nm[1]", "NaN", "from 100 to 10000 nm", "nm"],
    ),
    slip(
        RANGE,
        "wavelengths_nm = [0.45]",
        ["light.wavelengths_nm[0]", "0.45", "from 100 to 10000 nm", "in nm"],
    ),
    slip(RANGE, "from_nm = 400", ["light", "found from_nm alone", "wavelengths_nm", "from_nm = 400"]),
    slip(
        "from_nm = 400",
        "from_nm = 1",
        ["light.from_nm", "found 1", "from 100 to 10000 nm", "400 is usual"],
    ),
    slip("step_nm = 100", "step_nm = 0", ["light.step_nm", "found 0", "greater than 0", "20 is usual"]),
    slip("step_nm = 100", "step_nm = 1e-9", ["light.step_nm", "1e-9", "fewer than 10000", "20 is usual"]),
    slip(
        "step_nm = 100",
        "step_nm = 400",
        ["light.step_nm", "found 400", "at most to_nm - from_nm = 300 nm", "wavelengths_nm = [550]"],
    ),
    slip(
        "[light]\nfrom_nm = 400\nto_nm = 700\nstep_nm = 100",
        "[colour]\nsummation = \"e308\"\n[light]\nwavelengths_nm = [400, 500, 700]",
        ["colour.summation", "e308", "ASTM E308 has no weights", "from_nm, to_nm and step_nm"],
    ),
    slip("to_nm = 700", "to_nm = 300", ["light.to_nm", "300", "from_nm = 400", "700 is usual"]),
    slip("to_nm = 700", "to_nm = 900", ["pigment[0].index", "800 nm", "from 380 to 780 nm", "[light]"]),
    slip("count = 3", "polar_deg = [0, 90]", ["angles.polar_deg[1]", "90", "below 90°", "89"]),
    slip("count = 3", "polar_deg = [0, inf]", ["angles.polar_deg[1]", "inf", "below 90°", "89"]),
    slip("count = 3", "count = 3\npolar_deg = [0]", ["angles", "both", "either", "remove one"]),
    slip("count = 3", "count = 0", ["angles.count", "found 0", "3 to 64", "5 is usual"]),
    slip(
        "count = 3",
        "count = 3\npicture_max_deg = 95",
        ["angles.picture_max_deg", "95", "at most 89", "60 is usual"],
    ),
    // run, resolution, solver, output
    slip(
        "realisations = 2",
        "realisations = 0",
        ["run.realisations", "found 0", "from 1 to 100000", "24 small cells are a fair start"],
    ),
    slip(
        "points_per_um = 20\n",
        "",
        ["resolution", "found planes_per_um alone", "either accuracy", "accuracy = 1e-2"],
    ),
    slip(
        "points_per_um = 20",
        "per_wavelength = true\npoints_per_um = 20",
        ["resolution.per_wavelength", "which are one grid", "with accuracy", "instead of points and planes"],
    ),
    slip(
        "points_per_um = 20",
        "points_per_um = nan",
        ["resolution.points_per_um", "NaN", "from 2 to 400", "12 to 16"],
    ),
    slip(
        "[output]",
        "[solver]\ntolerance = 0\n[output]",
        ["solver.tolerance", "found 0", "to 0.01", "leave it out"],
    ),
    slip(
        "[output]",
        "[solver]\nstrategy = \"magic\"\n[output]",
        ["strategy", "magic", "`krylov`", "write one of"],
    ),
    slip(
        "picture_pixels = 61",
        "picture_pixels = 0",
        ["output.picture_pixels", "found 0", "from 16", "360 is usual"],
    ),
];

/// The message without the frame and the line breaks of the terminal.
fn plain(text: &[u8]) -> String {
    let text = String::from_utf8_lossy(text).replace('│', " ");
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

fn refused(study: &Path, output: &Path) -> String {
    let done = run(study, output, &[]);
    let said = plain(&done.stderr);
    assert!(!done.status.success(), "accepted");
    assert!(!said.contains("panicked"), "{said}");
    assert!(!output.exists(), "something was written: {said}");
    said
}

#[test]
fn every_slip_is_told_with_field_value_range_and_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let csv = |name: &str, rows: &str| {
        std::fs::write(folder.path().join(name), format!("wavelength_nm,kappa\n{rows}")).unwrap();
    };
    csv("negative.csv", "400,-0.2\n700,0.1\n");
    csv("narrow.csv", "500,0.1\n600,0.1\n");
    csv("empty.csv", "400,0.1\n550,\n700,0.1\n");
    csv("micrometres.csv", "0.4,0.1\n0.7,0.1\n");
    std::fs::write(folder.path().join("comma.csv"), "wavelength_nm,reflectance\n400,0,5\n").unwrap();
    let mut missed = Vec::new();
    for Slip { from, to, says } in SLIPS {
        assert!(TINY.contains(from), "{from}");
        let text = TINY.replacen(from, to, 1);
        let said = refused(&study(folder.path(), &text), &folder.path().join("out"));
        for part in says {
            if !said.contains(part) {
                missed.push(format!("{to:?} does not say {part:?}: {said}"));
            }
        }
        let line = to.lines().last().unwrap_or_default();
        if !line.is_empty() && !said.contains("study.toml:") {
            missed.push(format!("{to:?} does not show its line: {said}"));
        }
    }
    assert!(missed.is_empty(), "{}", missed.join("\n\n"));
}

#[test]
fn all_faults_are_told_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let text = TINY.replace("seed = 7", "seed = 7\n[paper]\nalbedo = 2").replace("count = 3", "count = 1000");
    let said = refused(&study(folder.path(), &text), &folder.path().join("out"));
    assert!(
        said.contains("2 fields") && said.contains("paper.albedo") && said.contains("angles.count"),
        "{said}"
    );
}

#[test]
fn a_fault_of_the_light_is_told_once() {
    let folder = tempfile::tempdir().unwrap();
    let text = TINY.replace("from_nm = 400", "from_nm = 1");
    let said = refused(&study(folder.path(), &text), &folder.path().join("out"));
    assert!(!said.contains("fields") && !said.contains("pigment[0].index"), "{said}");
    let text = TINY.replace("seed = 7", "seed = 7\ntarget_delta_e = 1e-300");
    let said = refused(&study(folder.path(), &text), &folder.path().join("out"));
    assert!(said.contains("run.target_delta_e: found 1e-300;"), "{said}");
}

#[test]
fn a_sweep_is_told_its_own_command() {
    let folder = tempfile::tempdir().unwrap();
    let path = study(
        folder.path(),
        "base = \"yellow.toml\"\n[[axis]]\nfield = \"paper.albedo\"\nvalues = [0.5, 0.9]\n",
    );
    let said = refused(&path, &folder.path().join("out"));
    assert!(said.contains("study.toml is a sweep") && said.contains("`inkwave sweep "), "{said}");
    // a slip in a study stays one
    let said = refused(&study(folder.path(), &TINY.replace("[run]", "[base]")), &folder.path().join("out"));
    assert!(said.contains("unknown key") && !said.contains("is a sweep"), "{said}");
}

#[test]
fn all_unknown_keys_are_told_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let text = TINY.replace("seed = 7", "sead = 7\nspeed = 3").replace("built_in", "builtin");
    let text = text.replace("[output]", "[ouput]");
    let said = refused(&study(folder.path(), &text), &folder.path().join("out"));
    for part in
        ["run.sead", "did you mean seed?", "run.speed", "pigment[0].index.builtin", "ouput", "4 fields"]
    {
        assert!(said.contains(part), "{part}: {said}");
    }
}

#[test]
fn concentrations_that_cannot_be_packed_leave_nothing_behind() {
    let folder = tempfile::tempdir().unwrap();
    let text = TINY.replace("volume_fraction = 0.15", "volume_fraction = 0.64");
    let text = text.replace("[output]", "[packing.relaxation]\nmax_steps = 200\n[output]");
    let said = refused(&study(folder.path(), &text), &folder.path().join("out"));
    for part in ["volume fraction", "0.64", "not reached", "volume_fraction"] {
        assert!(said.contains(part), "{said}");
    }
}

#[test]
fn paths_that_cannot_be_read_or_written_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let (good, out) = (study(folder.path(), TINY), folder.path().join("out"));
    let said = refused(&folder.path().join("none.toml"), &out);
    assert!(
        said.contains("none.toml") && said.contains("cannot read") && said.contains("give the path"),
        "{said}"
    );

    let below_a_file = good.join("out");
    let said = refused(&good, &below_a_file);
    assert!(said.contains("cannot write") && said.contains("--output DIR"), "{said}");

    std::fs::write(folder.path().join("thesis.txt"), "years of work").unwrap();
    let done = run(&good, folder.path(), &[]);
    let said = plain(&done.stderr);
    assert!(
        !done.status.success() && said.contains("holds other files") && said.contains("--output DIR"),
        "{said}"
    );
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2, "nothing was added");
}

/// Wide gaps between rows may be meant so: they are told of once, and the study goes on to its next fault, or runs.
#[test]
fn wide_gaps_between_rows_are_told_once() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("two.csv"), "wavelength_nm,kappa\n400,0.1\n700,0.2\n").unwrap();
    std::fs::write(folder.path().join("print.csv"), "wavelength_nm,reflectance\n400,0.1\n700,0.2\n").unwrap();
    let text = TINY.replacen(K, "index = { csv = \"two.csv\" }", 1);
    let text = text.replace("[output]", "[compare]\nmeasured = \"print.csv\"\n[output]");
    let done = run(&study(folder.path(), &text), &folder.path().join("out"), &["--plan"]);
    let said = plain(&done.stderr);
    assert!(done.status.success(), "{said}");
    for file in ["two.csv: no row between 400 and 700 nm", "print.csv: no row between 400 and 700 nm"] {
        assert_eq!(said.matches(file).count(), 1, "{said}");
    }
}
