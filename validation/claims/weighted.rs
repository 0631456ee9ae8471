//! Weighted numbers of spectra, and spectra from the ultraviolet to the infrared, against other programs and sums by hand.

use crate::claim::{Claim, Findings, Level, Table, short};
use crate::studies::done;
use inkwave::appearance::weighted::{NamedWeights, NumberTransform, WeightTable, WeightedSum};
use serde_json::Value;

pub const NUMBERS: Claim = Claim {
    id: "44-weighted-numbers",
    statement: "Solar reflectances and their parts, densities of statuses E and T, CIE whiteness and tint and yellowness of five spectra are those of pvlib's table, colormath and colour-science; a study of a grey has the density of its albedo.",
    because: "The numbers of the other programs are in data/weighted_numbers.json (made by weighted_numbers.py). A layer of index 1 is invisible: what is seen is the paper, whose number is known.",
    file: file!(),
    measure: numbers,
};

pub const WIDE: Claim = Claim {
    id: "45-light-beyond-the-eye",
    statement: "A study from 300 to 2500 nm has the colours of the same study from 400 to 700 nm, and the error bar of a solar reflectance holds what closer wavelengths change.",
    because: "Colours take the wavelengths that eyes see, the same in both. A clear film is solved exactly at any wavelength, so that only the sum over wavelengths can be off.",
    file: file!(),
    measure: wide,
};

/// The reference's spectra, by the formulas of weighted_numbers.py.
fn spectrum(name: &str, nm: f64) -> f64 {
    let edge = |at: f64, width: f64| 1.0 / (1.0 + (-(nm - at) / width).exp());
    let bell = |at: f64, width: f64| (-0.5 * ((nm - at) / width).powi(2)).exp();
    match name {
        "grey_0.1" => 0.1,
        "grey_0.5" => 0.5,
        "white_paint" => 0.05 + 0.85 * edge(395.0, 8.0) - 0.15 * edge(1400.0, 200.0),
        "yellow_ink" => 0.04 + 0.85 * edge(505.0, 14.0),
        "blue_white" => 0.80 + 0.10 * bell(450.0, 25.0) - 0.03 * bell(600.0, 60.0),
        other => panic!("no formula for {other}"),
    }
}

/// The sums' own error: cubics over steps of 1 %.
const OWN: f64 = 1e-4;

fn grid(from: f64, to: f64, step: f64) -> Vec<f64> {
    (0..=((to - from) / step).round() as usize).map(|k| from + step * k as f64).collect()
}

/// The largest difference of each kind of number.
#[derive(Default)]
struct Largest {
    solar: f64,
    grey_density: f64,
    density: f64,
    whiteness: f64,
    yellowness: f64,
}

fn numbers(_: Level, findings: &mut Findings) {
    let file: Value = serde_json::from_str(include_str!("../data/weighted_numbers.json")).expect("JSON");
    let mut largest = Largest::default();
    for case in file["spectra"].as_array().expect("spectra") {
        compare(case, &mut largest);
    }
    findings.promise(
        "solar reflectance and parts",
        largest.solar,
        2e-4,
        "cubics between wavelengths 5 nm apart, at an edge 8 nm wide that the sun's rows every half nm weight",
    );
    findings.identity(
        "densities of greys",
        largest.grey_density,
        1e-9,
        "weights that add up to one: rounding",
    );
    findings.promise("densities", largest.density, 1e-3, "the last digit that densitometers show is 0.01");
    findings.promise(
        "whiteness and tint",
        largest.whiteness,
        0.02,
        "X, Y, Z every nm of two copies of the CIE's tables, times 1700",
    );
    findings.promise("yellowness", largest.yellowness, 0.02, "the same; coefficients with five digits");
    grey_study(findings);
}

fn compare(case: &Value, largest: &mut Largest) {
    let name = case["name"].as_str().expect("a name");
    let nm = grid(280.0, 2500.0, 5.0);
    let values: Vec<f64> = nm.iter().map(|nm| spectrum(name, *nm)).collect();
    let mean = |table: &WeightTable| WeightedSum::new(&nm, table).of(&values);
    let number = |value: &Value| value.as_f64().expect("a number");
    let sun = NamedWeights::find("solar_g173").expect("the sun").tables.remove(0);
    for (part, range) in [
        ("all", [280.0, 2500.0]),
        ("uv", [280.0, 400.0]),
        ("visible", [400.0, 700.0]),
        ("nir", [700.0, 2500.0]),
    ] {
        let off = mean(&sun.within(range).expect("a part")) - number(&case["solar_g173"][part]);
        largest.solar = largest.solar.max(off.abs());
    }
    for (table, want) in case["density"].as_object().expect("densities") {
        let weights = NamedWeights::find(table).expect("a status").tables.remove(0);
        let off = (NumberTransform::Density.of_mean(mean(&weights)) - number(want)).abs();
        largest.density = largest.density.max(off);
        if name.starts_with("grey") {
            largest.grey_density = largest.grey_density.max(off);
        }
    }
    let of_xyz = |condition: &str, transform: NumberTransform| {
        let named = NamedWeights::find(condition).expect("an observer");
        let white = named.white.expect("a white");
        let means = named.tables.iter().map(mean).collect::<Vec<f64>>();
        transform.of_xyz(std::array::from_fn(|c| white.xyz[c] * means[c]), &white)
    };
    for (condition, want) in case["whiteness"].as_object().expect("whitenesses") {
        for (k, transform) in [NumberTransform::Whiteness, NumberTransform::Tint].into_iter().enumerate() {
            let off = of_xyz(condition, transform) - number(&want[k]);
            // a large W of a colour that is no white scales with it
            largest.whiteness = largest.whiteness.max(off.abs() / (1.0 + 0.01 * number(&want[k]).abs()));
        }
    }
    for (condition, want) in case["yellowness"].as_object().expect("yellownesses") {
        let off = of_xyz(condition, NumberTransform::Yellowness) - number(want);
        largest.yellowness = largest.yellowness.max(off.abs());
    }
}

/// A layer of index 1 on a paper of albedo 0.1: density 1, and a haze of nothing scattered.
fn grey_study(findings: &mut Findings) {
    let text = r#"
[layer]
thickness_um = 1.0
binder.index = 1.0
[paper]
albedo = 0.1
[light]
from_nm = 350
to_nm = 780
step_nm = 10
sampling = "listed"
[[number]]
name = "red"
weights = "status_t_red"
of = "natural_light"
transform = "density"
[[number]]
name = "blue"
weights = "status_e_blue"
of = "albedo"
transform = "density"
[[number]]
name = "haze"
weights = "C/2"
of = "scattered_transmittance"
over = "transmittance"
"#;
    let results = done(text).results;
    let value = |k: usize| results["numbers"][k]["value"].as_f64().unwrap_or(f64::NAN);
    let off = (value(0) - 1.0).abs().max((value(1) - 1.0).abs());
    findings.promise("density of a grey study", off, 1e-3, "the last digit that densitometers show is 0.01");
    findings.promise("haze of nothing", value(2).abs(), 1e-9, "a film scatters nothing: rounding");
}

/// A film of index 1.5 on grey paper at these wavelengths, and its reflectance of the sun's light over a range, nm.
fn film(light: &str, [from, to]: [f64; 2]) -> Value {
    done(&format!(
        "[layer]\nthickness_um = 0.8\nbinder.index = 1.5\n[paper]\nalbedo = 0.4\n[light]\n{light}\n\
         [[number]]\nname = 'solar'\nweights = 'solar_g173'\nfrom_nm = {from}\nto_nm = {to}\nof = 'albedo'\n"
    ))
    .results
}

fn wide(_: Level, findings: &mut Findings) {
    let list = |nm: &[f64]| {
        format!("wavelengths_nm = [{}]", nm.iter().map(f64::to_string).collect::<Vec<_>>().join(", "))
    };
    let visible = grid(400.0, 700.0, 20.0);
    let beyond = [grid(300.0, 375.0, 25.0), visible.clone(), grid(800.0, 2500.0, 100.0)].concat();
    let lab = |results: &Value| -> Vec<f64> {
        let all = results["colours"].as_array().expect("colours").iter();
        all.flat_map(|c| c["lab"].as_array().expect("Lab").clone()).filter_map(|x| x.as_f64()).collect()
    };
    let eye = film(&list(&visible), [400.0, 700.0]);
    let sun = [300.0, 2500.0];
    let all = film(&list(&beyond), sun);
    let off = lab(&eye).iter().zip(lab(&all)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let off = if lab(&eye).len() == 6 && lab(&all).len() == 6 { off } else { f64::NAN };
    findings.identity(
        "Lab of 300 to 2500 nm less that of 400 to 700 nm",
        off,
        1e-9,
        "the same wavelengths: rounding",
    );
    // sums of lists of three densities, and of shifted wavelengths, against one of 5 nm
    let number = |results: &Value| {
        let note = &results["numbers"][0];
        [note["value"].as_f64().unwrap_or(f64::NAN), note["standard_error"].as_f64().unwrap_or(f64::NAN)]
    };
    let [truth, _] = number(&film(&list(&grid(300.0, 2500.0, 5.0)), sun));
    let mut rows = Vec::new();
    let mut worst: f64 = 0.0;
    let mut widest: f64 = 0.0;
    for light in [
        list(&beyond),
        list(&grid(300.0, 2500.0, 20.0)),
        list(&grid(300.0, 2500.0, 50.0)),
        "from_nm = 300\nto_nm = 2500\nstep_nm = 20".to_owned(),
    ] {
        let [value, error] = number(&film(&light, sun));
        worst = worst.max((value - truth).abs() / error.max(OWN));
        widest = widest.max(error);
        let kind = light.split([' ', '\n']).next().unwrap_or_default();
        rows.push(vec![kind.to_owned(), format!("{value:.5}"), short(error), short(value - truth)]);
    }
    findings.promise("solar reflectance, in standard errors", worst, 3.0, "bars of three standard errors");
    findings.promise("largest bar", widest, 0.02, "a bar that holds everything tells nothing");
    findings.tables.push(Table {
        title: "A clear film on grey paper, 300 to 2500 nm".to_owned(),
        columns: ["wavelengths", "solar reflectance", "standard error", "off"].map(str::to_owned).to_vec(),
        rows,
    });
}
