//! `inkwave export`: what the files hold. The programs that they are meant for are in `scripts/check-exports`.

use crate::run_support::{TINY, study, succeed};
use inkwave::appearance::tristimulus::Colorimeter;
use inkwave::appearance::viewing::{Summation, Viewing};
use ndarray::{Array1, Array2};
use ndarray_npy::NpzReader;
use num_complex::Complex64;
use serde_json::Value;
use std::collections::BTreeMap;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

/// Runs `inkwave export` on a folder.
fn export(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_inkwave")).arg("export").arg(folder).args(arguments).output().unwrap()
}

/// What a refused export says, in one line.
fn refusal(folder: &Path, arguments: &[&str]) -> String {
    let done = export(folder, arguments);
    assert!(!done.status.success());
    String::from_utf8_lossy(&done.stderr).split_whitespace().collect::<Vec<_>>().join(" ")
}

fn table(path: &Path) -> Vec<BTreeMap<String, String>> {
    csv::Reader::from_path(path).unwrap().deserialize().collect::<Result<_, _>>().unwrap()
}

/// A field of a tensor file, as its readers find it.
struct Tensor {
    shape: Vec<usize>,
    values: Vec<f32>,
}

fn tensors(path: &Path) -> BTreeMap<String, Tensor> {
    let file = fs::read(path).unwrap();
    assert_eq!(&file[..14], b"tensor_file\0\x01\x00");
    let number =
        |start: usize, bytes: usize| (0..bytes).map(|i| (file[start + i] as usize) << (8 * i)).sum::<usize>();
    let mut position = 18;
    let mut tensors = BTreeMap::new();
    for _ in 0..number(14, 4) {
        let length = number(position, 2);
        let name = String::from_utf8(file[position + 2..position + 2 + length].to_vec()).unwrap();
        position += 2 + length;
        let dimensions = number(position, 2);
        let kind = file[position + 2];
        let offset = number(position + 3, 8);
        let shape: Vec<usize> = (0..dimensions).map(|i| number(position + 11 + 8 * i, 8)).collect();
        position += 11 + 8 * dimensions;
        let count: usize = shape.iter().product();
        let float =
            |i: usize| f32::from_le_bytes(file[offset + 4 * i..offset + 4 * i + 4].try_into().unwrap());
        let values = match kind {
            10 => (0..count).map(float).collect(),
            _ => file[offset..offset + count].iter().map(|&b| f32::from(b)).collect(),
        };
        tensors.insert(name, Tensor { shape, values });
    }
    tensors
}

/// f cos θ_o as the renderer looks it up: half vector, bilinear, linear in θ_i.
fn looked_up(file: &BTreeMap<String, Tensor>, wave: usize, light: f64, view: f64, azimuth: f64) -> f64 {
    let theta_i = &file["theta_i"].values;
    let spectra = &file["spectra"];
    let n = spectra.shape[4];
    let out = [-view.sin() * azimuth.cos(), -view.sin() * azimuth.sin(), view.cos()];
    let half = [out[0] + light.sin(), out[1], out[2] + light.cos()];
    let theta = half[0].hypot(half[1]).atan2(half[2]);
    let phi = if theta > 0.0 { half[1].atan2(half[0]) } else { 0.0 };
    // the cell of the grid, and the place within it
    let place = |share: f64| {
        let x = share.clamp(0.0, 1.0) * (n - 1) as f64;
        let cell = (x as usize).min(n - 2);
        (cell, x - cell as f64)
    };
    let (row, s) = place((phi + PI) / TAU);
    let (column, t) = place((theta / FRAC_PI_2).sqrt());
    let plane = |k: usize| {
        let first_row = (k * spectra.shape[2] + wave) * n + row;
        let corner = |i, j| f64::from(spectra.values[(first_row + i) * n + column + j]);
        let upper = (1.0 - t) * corner(0, 0) + t * corner(0, 1);
        let lower = (1.0 - t) * corner(1, 0) + t * corner(1, 1);
        (1.0 - s) * upper + s * lower
    };
    let after = theta_i.partition_point(|&x| f64::from(x) < light).clamp(1, theta_i.len() - 1);
    let below = f64::from(theta_i[after - 1]);
    let above = f64::from(theta_i[after]);
    let share = ((light - below) / (above - below)).clamp(0.0, 1.0);
    (1.0 - share) * plane(after - 1) + share * plane(after)
}

/// 95th percentile of the material's relative error at cos θ > 0.2, `with_cosine` of the view as it must be.
fn material_error(folder: &Path, with_cosine: bool) -> f64 {
    let file = tensors(&folder.join("ink-spectral.bsdf"));
    let waves = &file["wavelengths"].values;
    let mut errors: Vec<f64> = Vec::new();
    for row in table(&folder.join("brdf-samples.csv")) {
        let number = |name: &str| row[name].parse::<f64>().unwrap();
        let wave = waves.iter().position(|&nm| f64::from(nm) == number("wavelength_nm")).unwrap();
        let light = number("light_polar_deg").to_radians();
        let view = number("view_polar_deg").to_radians();
        let azimuth = number("azimuth_deg").to_radians();
        if light.cos() > 0.2 && view.cos() > 0.2 {
            let expected = number("brdf_per_sr") * if with_cosine { view.cos() } else { 1.0 };
            errors.push((looked_up(&file, wave, light, view, azimuth) / expected - 1.0).abs());
        }
    }
    errors.sort_by(f64::total_cmp);
    errors[errors.len() * 95 / 100]
}

#[test]
fn every_format_holds_the_runs_numbers_and_nothing_is_solved() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    succeed(&study(folder.path(), TINY), &out, &[]);
    let before = fs::read(out.join("results.json")).unwrap();
    let done = export(&out, &["--to", "mitsuba,cxf,cgats,npz,vti,crate"]);
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    assert_eq!(fs::read(out.join("results.json")).unwrap(), before);
    let files = out.join("export");

    // 3 %: bilinear in a grid of 96 half vectors, linear over 3° of incidence
    let right = material_error(&files, true);
    let wrong = material_error(&files, false);
    assert!(right <= 0.03, "{right}");
    assert!(wrong > 0.03, "a material without its cosine must not pass: {wrong}");
    assert_eq!(tensors(&files.join("ink-rgb.bsdf"))["rgb"].shape[2], 3);
    assert!(fs::read_to_string(files.join("scene-rgb.xml")).unwrap().contains("\"ink-rgb.bsdf\""));

    let spectra = table(&out.join("spectra.csv"));
    spectra_agree(&files, &spectra);
    far_fields_agree(&files);
    volume_agrees(&files);
    described(&files);
}

fn spectra_agree(files: &Path, spectra: &[BTreeMap<String, String>]) {
    let cxf = fs::read_to_string(files.join("spectra.cxf")).unwrap();
    let values = cxf.split("StartWL=\"400\">").nth(1).unwrap().split('<').next().unwrap();
    let values: Vec<f64> = values.split(' ').map(|x| x.parse().unwrap()).collect();
    assert_eq!(values.len(), 31);
    let sp = fs::read_to_string(files.join("spectra.sp")).unwrap();
    let row = sp.lines().find(|line| line.starts_with("1 \"45:0\"")).unwrap();
    // both geometries
    assert!(sp.contains("\nNUMBER_OF_SETS 2\n") && sp.contains("\n2 \"uniform sky, 0\" "), "{sp}");
    let percents: Vec<f64> = row.split_whitespace().skip(5).map(|x| x.parse().unwrap()).collect();
    let normal = spectra.iter().filter(|row| !row["lit_at_45"].is_empty());
    for (i, row) in normal.enumerate() {
        let lit: f64 = row["lit_at_45"].parse().unwrap();
        // both files' decimals
        assert!((values[10 * i] - lit).abs() < 1e-7 && (percents[10 * i] - 100.0 * lit).abs() < 1e-6);
    }
}

/// Lab is what the spectrum beside it has under the study's light, whatever the step of its wavelengths. *Planted*: Lab of the study's
/// own sums is off by 0.1 to 1 at steps of 30 nm, Lab under D65 by 10.
#[test]
fn lab_is_that_of_the_spectrum_beside_it_under_the_studys_light() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let fitted = TINY.replace("step_nm = 100\nsampling = \"listed\"", "step_nm = 30");
    for (text, light, observer) in
        [(fitted.as_str(), "A", "10"), (TINY, "F11", "2"), (&fitted, "F1", "2015_2")]
    {
        let text = format!("{text}[colour]\nilluminant = \"{light}\"\nobserver = \"{observer}\"\n");
        succeed(&study(folder.path(), &text), &out, &[]);
        assert!(export(&out, &["--to", "cxf,cgats"]).status.success());
        let read = |name: &str| fs::read_to_string(out.join("export").join(name)).unwrap();
        let grid: Vec<f64> = (40..=70).map(|k| 10.0 * f64::from(k)).collect();
        let viewing = Viewing::new(light, observer, Summation::Plain).unwrap();
        let meter = Colorimeter::under(&grid, &viewing).unwrap();
        let apart = |values: &[f64], lab: &[f64]| {
            let again = meter.colour(values).unwrap().lab;
            again.iter().zip(lab).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
        };
        let numbers = |text: &str| text.split_whitespace().map(|x| x.parse().unwrap()).collect::<Vec<f64>>();
        let cxf = read("spectra.cxf");
        let between = |text: &str, from: &str, to: &str| {
            numbers(text.split(from).nth(1).unwrap().split(to).next().unwrap())
        };
        for object in cxf.split("<cc:Object ").skip(1) {
            let lab = ["L", "A", "B"].map(|c| between(object, &format!("<cc:{c}>"), "<")[0]);
            let values = between(object, "StartWL=\"400\">", "<");
            // both files' decimals, where L* rises by 9 a percent at black
            assert!(values.len() == 31 && apart(&values, &lab) < 1e-4, "{light} {lab:?}");
        }
        let known = if light == "F1" { "Custom" } else { light };
        assert!(
            cxf.contains(&format!("<cc:Illuminant Name=\"{light}\"")) && cxf.contains(&format!(">{known}<"))
        );
        let degree = if observer == "2015_2" { ">Custom_CMF<" } else { &format!(">{observer}_Degree<") };
        assert!(cxf.contains(degree), "{cxf}");
        for name in ["spectra.cgats", "spectra.sp"] {
            let cgats = read(name);
            assert!(cgats.contains(&format!("LAB_CONDITIONS \"{light}, ")), "{cgats}");
            for row in cgats.split("BEGIN_DATA\n").nth(1).unwrap().lines().take(2) {
                let cells = numbers(row.rsplit('"').next().unwrap());
                let values: Vec<f64> = cells[3..].iter().map(|x| x / 100.0).collect();
                assert!(apart(&values, &cells[..3]) < 1e-4, "{name} {row}");
            }
        }
        assert!(read("spectra.cgats").contains(&format!("WEIGHTING_FUNCTION \"ILLUMINANT, {light}\"")));
        fs::remove_dir_all(&out).unwrap();
    }
}

fn far_fields_agree(files: &Path) {
    let mut npz = NpzReader::new(fs::File::open(files.join("far-fields.npz")).unwrap()).unwrap();
    let first: Array1<i64> = npz.by_name("solve_first_order").unwrap();
    let totals: Array1<f64> = npz.by_name("solve_reflectance").unwrap();
    let reflected: Array1<f64> = npz.by_name("order_reflected_efficiency").unwrap();
    let amplitudes: Array1<Complex64> = npz.by_name("order_reflected").unwrap();
    let period: Array2<f64> = npz.by_name("solve_period_um").unwrap();
    assert_eq!((totals.len(), period.dim(), amplitudes.len()), (24, (24, 2), reflected.len()));
    for (s, total) in totals.iter().enumerate() {
        let sum: f64 = (first[s]..first[s + 1]).map(|k| reflected[k as usize]).sum();
        assert!((sum - total).abs() < 1e-12);
    }
    let nm: Array1<f64> = npz.by_name("solve_wavelength_nm").unwrap();
    let polar: Array1<f64> = npz.by_name("solve_polar_deg").unwrap();
    let azimuth: Array1<f64> = npz.by_name("solve_azimuth_deg").unwrap();
    let alpha: Array1<f64> = npz.by_name("order_alpha").unwrap();
    let beta: Array1<f64> = npz.by_name("order_beta").unwrap();
    let m: Array1<i32> = npz.by_name("order_m").unwrap();
    let n: Array1<i32> = npz.by_name("order_n").unwrap();
    for s in 0..totals.len() {
        // the law of gratings in vacuum; the wavelength has twelve digits
        let sin = polar[s].to_radians().sin();
        let azimuth = azimuth[s].to_radians();
        let steps = [0, 1].map(|axis| 1e-3 * nm[s] / period[[s, axis]]);
        for k in first[s] as usize..first[s + 1] as usize {
            let along_x = sin * azimuth.cos() + f64::from(m[k]) * steps[0];
            let along_y = sin * azimuth.sin() + f64::from(n[k]) * steps[1];
            assert!((alpha[k] - along_x).abs() < 1e-9 && (beta[k] - along_y).abs() < 1e-9, "solve {s}");
        }
    }
}

fn volume_agrees(files: &Path) {
    let text = fs::read_to_string(files.join("contrast.vti")).unwrap();
    assert!(text.contains("Name=\"share_yellow\"") && text.contains("Name=\"contrast_"));
    assert!(text.contains(" 0 24\" Origin="), "0.5 µm in steps of 20 nm");
}

fn described(files: &Path) {
    let json =
        |name: &str| -> Value { serde_json::from_slice(&fs::read(files.join(name)).unwrap()).unwrap() };
    let metadata = json("ro-crate-metadata.json");
    let graph = metadata["@graph"].as_array().unwrap();
    let listed: Vec<&str> =
        graph.iter().filter(|e| e["@type"] == "File").map(|e| e["@id"].as_str().unwrap()).collect();
    assert!(listed.contains(&"bdf.csv") && listed.iter().all(|name| files.join(name).exists()));
    for resource in json("datapackage.json")["resources"].as_array().unwrap() {
        let size = fs::metadata(files.join(resource["path"].as_str().unwrap())).unwrap().len();
        assert_eq!(resource["bytes"].as_u64(), Some(size));
    }
}

#[test]
fn what_cannot_be_exported_is_refused_with_a_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    assert!(refusal(&out, &["--to", "npz"]).contains("inkwave run STUDY.toml"));
    let listed = TINY.replace("count = 3", "polar_deg = [0, 30]");
    succeed(&study(folder.path(), &listed), &out, &[]);
    assert!(refusal(&out, &["--to", "mitsuba"]).contains("angles.count"));
    let boxes = folder.path().join("boxes");
    let shaped = "diameter_nm = 150\nshape = \"box\"";
    succeed(&study(folder.path(), &listed.replace("diameter_nm = 200", shaped)), &boxes, &[]);
    let positions = export(&boxes, &["--to", "positions"]);
    assert!(String::from_utf8_lossy(&positions.stdout).contains("no positions"), "{positions:?}");
    assert!(!boxes.join("export/grains.csv").exists());
    let early = refusal(&out, &["--to", "vti", "--near-field", "555"]);
    assert!(
        early.contains(" nm") && !early.contains("packing realisation"),
        "refused before working: {early}"
    );
    assert!(refusal(&out, &["--to", "vti", "--near-field", "550:91"]).contains("0 ≤ angle < 90"));
    assert!(export(&out, &["--to", "npz"]).status.success());
    let file = folder.path().join("study.toml").display().to_string();
    assert!(refusal(&out, &["--to", "npz", "--output", &file]).contains("--output"));
    fs::remove_dir_all(out.join("records")).unwrap();
    assert!(refusal(&out, &["--to", "npz"]).contains("to resume: inkwave run STUDY.toml --output"));
    fs::write(out.join("PARTIAL"), "Not finished:\n\n    inkwave run it.toml\n").unwrap();
    assert!(refusal(&out, &["--to", "npz"]).contains("to resume: inkwave run it.toml"));
    let results = fs::read_to_string(out.join("results.json")).unwrap();
    fs::write(out.join("results.json"), results.replace("\"seed\": 7", "\"seed\": 8")).unwrap();
    assert!(refusal(&out, &["--to", "npz"]).contains("the study has hash"));
}

/// The channels of the RGB material are red, green and blue of the spectra in the other file, in this order.
#[test]
fn the_rgb_material_is_the_colour_of_the_spectral_one_channel_by_channel() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    succeed(&study(folder.path(), TINY), &out, &[]);
    assert!(export(&out, &["--to", "mitsuba"]).status.success());
    let spectral = tensors(&out.join("export/ink-spectral.bsdf"));
    let rgb = tensors(&out.join("export/ink-rgb.bsdf"));
    let nm: Vec<f64> = spectral["wavelengths"].values.iter().map(|&x| f64::from(x)).collect();
    let meter = Colorimeter::new(&nm).unwrap();
    let cells = spectral["spectra"].shape[3..].iter().product::<usize>();
    let spectra = &spectral["spectra"].values;
    let channels = &rgb["rgb"].values;
    // every 97th cell of the second angle of incidence
    let mut coloured = 0;
    for cell in (0..cells).step_by(97) {
        let values: Vec<f64> =
            (0..nm.len()).map(|w| f64::from(spectra[(nm.len() + w) * cells + cell])).collect();
        let expected = meter.linear_rgb(meter.xyz(&values).unwrap()).map(|x| x.max(0.0));
        let rgb = [0, 1, 2].map(|c| f64::from(channels[(3 + c) * cells + cell]));
        // both files hold single precision, 6e-8 of sums of a few terms
        let near = |(a, b): (&f64, f64)| (a - b).abs() <= 1e-6 * (1.0 + b);
        assert!(rgb.iter().zip(expected).all(near), "{rgb:?} {expected:?}");
        coloured += usize::from((rgb[0] - rgb[2]).abs() > 0.1 * rgb[1]);
    }
    assert!(coloured > 10, "{coloured} cells that tell red from blue");
}
