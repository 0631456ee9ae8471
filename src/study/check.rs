//! From the file as written to a [`Study`]: every fault found at once, none let through.

mod index;

use super::angles::quadrature_angles;
use super::checked::{Layer, Output, Paper, Pigment, Study, WantedResolution, WantedSolver};
use super::fault::{Allowed, Fault, Faults};
use super::file::{AnglesTable, LayerTable, LightTable, PigmentTable, ResolutionTable, StudyFile};
use std::path::Path;

/// Concentration that no random packing exceeds; thin layers reach less and say so when packed.
const HIGHEST_FRACTION: f64 = 0.64;
/// More wavelengths or angles than this are a slip of the pen.
const LONGEST_LIST: usize = 10_000;

/// Checks every field of `file`. CSV paths are relative to `folder`; `name` titles a study without a title.
///
/// # Errors
/// All faults of the file, each with its field, what was found, what is allowed and what to try.
pub fn check(file: &StudyFile, folder: &Path, name: &str) -> Result<Study, Vec<Fault>> {
    let mut faults = Faults::default();
    let wavelengths_nm = wavelengths(&file.light, &mut faults);
    let layer = layer(&file.layer, &wavelengths_nm, folder, &mut faults);
    let pigments = pigments(file, &wavelengths_nm, folder, &mut faults);
    let polar_deg = angles(&file.angles, &mut faults);
    let resolution = resolution(&file.resolution, &mut faults);
    scalars(file, &mut faults);
    let study = Study {
        title: file.title.clone().unwrap_or_else(|| name.to_owned()),
        layer,
        pigments,
        paper: Paper { albedo: file.paper.albedo },
        wavelengths_nm,
        polar_deg,
        azimuth_deg: file.angles.azimuth_deg,
        realisations: file.run.realisations,
        seed: file.run.seed,
        resolution,
        solver: solver(file, &mut faults),
        output: Output { folder: file.output.folder.clone(), picture_pixels: file.output.picture_pixels },
    };
    if faults.0.is_empty() { Ok(study) } else { Err(faults.0) }
}

fn wavelengths(light: &LightTable, faults: &mut Faults) -> Vec<f64> {
    let list = match (&light.wavelengths_nm, light.from_nm, light.to_nm, light.step_nm) {
        (Some(list), None, None, None) => list.clone(),
        (None, Some(from), Some(to), Some(step)) => wavelength_range(from, to, step, faults),
        _ => {
            let allowed = "either wavelengths_nm, or all of from_nm, to_nm and step_nm";
            let remedy = "write for example from_nm = 400, to_nm = 700, step_nm = 20";
            faults.push(Fault::new("light", "another mixture of keys", allowed, remedy));
            return Vec::new();
        }
    };
    let field = if light.wavelengths_nm.is_some() { "light.wavelengths_nm" } else { "light.from_nm" };
    let allowed = Allowed::between(100.0, 10_000.0, "nm");
    check_list(field, &list, allowed, "give vacuum wavelengths in nm, 400 to 700 for the visible", faults);
    list
}

fn wavelength_range(from: f64, to: f64, step: f64, faults: &mut Faults) -> Vec<f64> {
    let before = faults.0.len();
    faults.number("light.step_nm", step, Allowed::above(0.0, 1e4, "nm"), "20 is usual");
    faults.number("light.from_nm", from, Allowed::between(100.0, 1e4, "nm"), "400 is usual");
    if !(to >= from && to <= 1e4) {
        let allowed = format!("from from_nm = {from} to 10000 nm");
        faults.push(Fault::new("light.to_nm", to, allowed, "700 is usual"));
    }
    let count = ((to - from) / step + 1e-9).floor();
    if faults.0.len() == before && count >= LONGEST_LIST as f64 {
        let allowed = format!("a step that gives fewer than {LONGEST_LIST} wavelengths");
        faults.push(Fault::new("light.step_nm", step, allowed, "20 is usual"));
    }
    if faults.0.len() > before {
        return vec![from];
    }
    (0..=count as usize).map(|i| from + i as f64 * step).collect()
}

/// A list must have entries, all allowed and rising.
fn check_list(field: &str, list: &[f64], allowed: Allowed, remedy: &str, faults: &mut Faults) {
    if list.is_empty() || list.len() > LONGEST_LIST {
        let found = format!("{} entries", list.len());
        faults.push(Fault::new(field, found, format!("1 to {LONGEST_LIST} entries, each {allowed}"), remedy));
    }
    let wrong = list.iter().position(|&value| !allowed.holds(value));
    if let Some(i) = wrong {
        faults.number(&format!("{field}[{i}]"), list[i], allowed, remedy);
    } else if let Some(i) = (1..list.len()).find(|&i| list[i] <= list[i - 1]) {
        let found = format!("{} after {}", list[i], list[i - 1]);
        faults.push(Fault::new(
            format!("{field}[{i}]"),
            found,
            "rising values",
            "sort the list, without repeats",
        ));
    }
}

fn layer(table: &LayerTable, wavelengths_nm: &[f64], folder: &Path, faults: &mut Faults) -> Layer {
    let period_um = table.period_um.0;
    let remedy = "2 to 10 µm is usual; larger cells cost more and average better";
    for period in period_um {
        faults.number("layer.period_um", period, Allowed::above(0.0, 1000.0, "µm"), remedy);
    }
    let allowed = Allowed::above(0.0, 1000.0, "µm");
    faults.number("layer.thickness_um", table.thickness_um, allowed, "a printed layer is about 1 µm thick");
    let allowed = Allowed::between(0.1, 10.0, "");
    let remedy = "give the real refractive index, 1 for air";
    faults.number("layer.index_above", table.index_above, allowed, remedy);
    faults.number("layer.index_below", table.index_below, allowed, remedy);
    Layer {
        period_um,
        thickness_um: table.thickness_um,
        index_above: table.index_above,
        index_below: table.index_below,
        binder: index::tabulate("layer.binder.index", &table.binder.index, wavelengths_nm, folder, faults),
    }
}

fn pigments(file: &StudyFile, wavelengths_nm: &[f64], folder: &Path, faults: &mut Faults) -> Vec<Pigment> {
    let tables = file.pigments.iter().enumerate();
    let pigments = tables.map(|(i, table)| {
        let field = |key: &str| format!("pigment[{i}].{key}");
        grain_size(&field, table, &file.layer, faults);
        let allowed = Allowed::above(0.0, HIGHEST_FRACTION, "");
        let remedy = "a share of the layer's volume, such as 0.3 for 30 %";
        faults.number(&field("volume_fraction"), table.volume_fraction, allowed, remedy);
        Pigment {
            name: table.name.clone(),
            diameter_nm: table.diameter_nm,
            diameter_spread: table.diameter_spread,
            volume_fraction: table.volume_fraction,
            index: index::tabulate(&field("index"), &table.index, wavelengths_nm, folder, faults),
        }
    });
    let pigments: Vec<Pigment> = pigments.collect();
    total_fraction(&pigments, faults);
    pigments
}

/// Grains fit between the walls and do not meet their own periodic images.
fn grain_size(
    field: &impl Fn(&str) -> String,
    table: &PigmentTable,
    layer: &LayerTable,
    faults: &mut Faults,
) {
    let [x, y] = layer.period_um.0;
    let half_period_nm = 500.0 * x.min(y);
    let (largest, limit) = if half_period_nm < 1e3 * layer.thickness_um {
        (half_period_nm, "half the layer's period")
    } else {
        (1e3 * layer.thickness_um, "the layer's thickness")
    };
    let diameter = table.diameter_nm;
    if !Allowed::above(0.0, largest, "nm").holds(diameter) {
        let allowed = format!("greater than 0 and at most {largest} nm ({limit})");
        let remedy = "pigment grains measure 50 to 500 nm; take smaller grains or a larger cell";
        faults.push(Fault::new(field("diameter_nm"), diameter, allowed, remedy));
    }
    let allowed = Allowed::between(0.0, 0.5, "");
    let remedy = "0 for equal grains, 0.2 for a spread of 20 %";
    faults.number(&field("diameter_spread"), table.diameter_spread, allowed, remedy);
}

fn total_fraction(pigments: &[Pigment], faults: &mut Faults) {
    let total: f64 = pigments.iter().map(|pigment| pigment.volume_fraction).sum();
    if pigments.len() > 1 && total > HIGHEST_FRACTION {
        let allowed = format!("a sum of at most {HIGHEST_FRACTION} over all pigments");
        let last = format!("pigment[{}].volume_fraction", pigments.len() - 1);
        let found = format!("{total} in all");
        faults.push(Fault::new(last, found, allowed, "lower the volume fractions"));
    }
}

fn angles(table: &AnglesTable, faults: &mut Faults) -> Vec<f64> {
    let allowed = Allowed::between(-360.0, 360.0, "°");
    faults.number("angles.azimuth_deg", table.azimuth_deg, allowed, "0 is the x direction");
    match (&table.polar_deg, table.count) {
        (Some(list), None) => {
            let remedy = "give angles from the normal; 89 is nearly grazing";
            check_list("angles.polar_deg", list, Allowed::below(0.0, 90.0, "°"), remedy, faults);
            list.clone()
        }
        (None, count) => quadrature_angles(count.unwrap_or(5), faults),
        (Some(_), Some(_)) => {
            let allowed = "either angles.count or angles.polar_deg";
            faults.push(Fault::new("angles", "both count and polar_deg", allowed, "remove one of them"));
            Vec::new()
        }
    }
}

fn resolution(table: &ResolutionTable, faults: &mut Faults) -> WantedResolution {
    match (table.accuracy, table.points_per_um, table.planes_per_um) {
        (accuracy, None, None) => {
            let accuracy = accuracy.unwrap_or(1e-2);
            let remedy = "1e-2 for pictures, 1e-3 for numbers to publish";
            faults.number("resolution.accuracy", accuracy, Allowed::between(1e-6, 0.3, ""), remedy);
            WantedResolution::Accuracy(accuracy)
        }
        (None, Some(points_per_um), Some(planes_per_um)) => {
            let allowed = Allowed::between(2.0, 400.0, "per µm");
            faults.number("resolution.points_per_um", points_per_um, allowed, "12 to 16 is usual");
            faults.number("resolution.planes_per_um", planes_per_um, allowed, "20 to 40 is usual");
            WantedResolution::Grid { points_per_um, planes_per_um }
        }
        _ => {
            let allowed = "either accuracy alone, or both points_per_um and planes_per_um";
            faults.push(Fault::new(
                "resolution",
                "another mixture of keys",
                allowed,
                "write accuracy = 1e-2",
            ));
            WantedResolution::Accuracy(1e-2)
        }
    }
}

fn solver(file: &StudyFile, faults: &mut Faults) -> WantedSolver {
    let table = &file.solver;
    let remedy = "1e-6 is ample: the discretisation's error is larger";
    faults.number("solver.tolerance", table.tolerance, Allowed::between(1e-13, 1e-2, ""), remedy);
    whole("solver.max_steps", table.max_steps, 1..=1_000_000, "2000 is usual", faults);
    WantedSolver { method: table.method.clone(), tolerance: table.tolerance, max_steps: table.max_steps }
}

fn scalars(file: &StudyFile, faults: &mut Faults) {
    let remedy = "0 is black, 1 is a perfect white, 0.9 is good paper";
    faults.number("paper.albedo", file.paper.albedo, Allowed::between(0.0, 1.0, ""), remedy);
    whole("run.realisations", file.run.realisations, 1..=100_000, "4 is a fair start", faults);
    whole("output.picture_pixels", file.output.picture_pixels, 16..=8192, "360 is usual", faults);
}

fn whole(
    field: &str,
    value: usize,
    allowed: std::ops::RangeInclusive<usize>,
    remedy: &str,
    faults: &mut Faults,
) {
    if !allowed.contains(&value) {
        let range = format!("whole numbers from {} to {}", allowed.start(), allowed.end());
        faults.push(Fault::new(field, value, range, remedy));
    }
}
