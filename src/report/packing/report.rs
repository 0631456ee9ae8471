//! The folder of a packing run: coordinates, pictures, statistics and a page that shows them.

use super::{grains_csv, packing_json, spheres_vtp};
use crate::draw::cell;
use crate::draw::chart::{self, Chart};
use crate::draw::page::rendered;
use crate::draw::{DrawResult, OutputError, cut_picture, perspective_picture, shape_sheet, top_picture};
use crate::ink::statistics::{StatisticCurve, Statistics, gather};
use crate::ink::{Method, Packing, Shape};
use crate::numerics::estimate::Estimate;
use crate::store::safely;
use minijinja::context;
use minijinja::value::Serde;
use std::path::{Path, PathBuf};

/// Writes everything about the realisations of one study into `folder`; every file is written
/// completely or not at all.
///
/// `pigments` gives the name and the shape of each. Returns the statistics and the page's path.
pub fn write_report(
    folder: &Path,
    title: &str,
    pigments: &[(String, Shape)],
    packings: &[Packing],
) -> DrawResult<(Statistics, PathBuf)> {
    std::fs::create_dir_all(folder).map_err(|source| OutputError::Write { path: folder.into(), source })?;
    for (k, packing) in packings.iter().enumerate() {
        save(folder, &format!("grains_{k:03}.csv"), &grains_csv(packing).map_err(no_table)?)?;
        save(folder, &format!("packing_{k:03}.json"), &packing_json(packing))?;
        save(folder, &format!("spheres_{k:03}.vtp"), spheres_vtp(packing).as_bytes())?;
    }
    if let Some(first) = packings.first() {
        save(folder, "top.png", &top_picture(first)?)?;
        save(folder, "cut.png", &cut_picture(first)?)?;
        save(folder, "perspective.png", &perspective_picture(first)?)?;
    }
    if have_shapes(packings) {
        save(folder, "shapes.png", &shape_sheet(pigments)?)?;
    }
    let statistics = gather(packings);
    save(folder, "statistics.csv", &scalars_csv(&statistics).map_err(no_table)?)?;
    for curve in &statistics.curves {
        save(folder, &format!("{}.csv", curve.name), &curve_csv(curve).map_err(no_table)?)?;
        if drawable(curve) {
            save(folder, &format!("{}.svg", curve.name), chart_of(curve, pigments).svg()?.as_bytes())?;
        }
    }
    save(folder, "index.html", html(title, pigments, packings, &statistics)?.as_bytes())?;
    Ok((statistics, folder.join("index.html")))
}

/// Whether grains have the shapes of their pigments: voxels have shapes of their own.
fn have_shapes(packings: &[Packing]) -> bool {
    packings.iter().all(|packing| packing.method() != Method::Voxels)
}

/// Writes one file, completely or not at all.
fn save(folder: &Path, name: &str, bytes: &[u8]) -> DrawResult {
    let path = folder.join(name);
    safely::write(&path, bytes).map_err(|source| OutputError::Write { path, source })
}

fn no_table(reason: csv::Error) -> OutputError {
    OutputError::making("a table")(reason)
}

/// Whether a file's name is that of one realisation in a folder of packings.
pub fn is_of_one_packing(name: &str) -> bool {
    let kinds = [("grains_", ".csv"), ("packing_", ".json"), ("spheres_", ".vtp")];
    let mut texts = kinds.into_iter().filter_map(|(head, tail)| name.strip_prefix(head)?.strip_suffix(tail));
    texts.any(|text| !text.is_empty() && text.chars().all(|c| c.is_ascii_digit()))
}

fn scalars_csv(statistics: &Statistics) -> csv::Result<Vec<u8>> {
    let rows = statistics.scalars.iter().map(|(name, unit, value)| {
        ([name, unit].map(|words| cell::text(words)), cell::numbers(Some(*value)))
    });
    cell::table(["quantity", "unit", "mean", "standard_error"], rows)
}

fn curve_csv(curve: &StatisticCurve) -> csv::Result<Vec<u8>> {
    let points = curve.x.iter().zip(&curve.y).map(|(x, y)| (x.to_string(), cell::numbers(Some(*y))));
    cell::table([curve.x_label.as_str(), &curve.y_label, "standard error"], points)
}

fn html(
    title: &str,
    pigments: &[(String, Shape)],
    packings: &[Packing],
    statistics: &Statistics,
) -> DrawResult<String> {
    let figures = statistics.scalars.iter().map(|(name, unit, value)| {
        let unit = if unit == "1" { "" } else { unit };
        context!(name => sided(&named(name, pigments)), value => rounded(*value), unit => unit.to_owned())
    });
    let plots = statistics.curves.iter().filter(|curve| drawable(curve)).map(|curve| {
        let y = named(&curve.y_label, pigments);
        let x = curve.x_label.clone();
        context!(file => format!("{}.svg", curve.name), y, x)
    });
    let page = context! {
        title => title.to_owned(),
        accounts => Serde(packings.iter().enumerate().map(|(k, packing)| account(k, packing)).collect::<Vec<_>>()),
        figures => figures.collect::<Vec<_>>(),
        plots => plots.collect::<Vec<_>>(),
        shapes => have_shapes(packings),
        remarks => statistics.remarks.clone(),
    };
    rendered(include_str!("packing.html"), page).map_err(OutputError::making("the page"))
}

/// How a realisation was packed, as cells of a table.
fn account(k: usize, packing: &Packing) -> [String; 6] {
    let a = packing.account();
    let gap = a.smallest_gap_um.map_or("above one radius".into(), |g| format!("{g:.2e}"));
    let method = a.method.in_words().to_string();
    let notes = a.notes.join("; ");
    [(k + 1).to_string(), method, a.steps.to_string(), a.sweeps.to_string(), gap, notes]
}

/// Terms for heights in the tables, and their wording on the page.
const SIDES: [(&str, &str); 4] = [
    ("the wall z = 0", "the free face, z = 0"),
    ("the wall z = H", "the paper side, z = H"),
    ("above the binder", "that sticks out of the binder's free face"),
    ("below the binder's surface", "under the binder's free face"),
];

fn sided(quantity: &str) -> String {
    SIDES.iter().fold(quantity.to_owned(), |name, (heights, sides)| name.replace(heights, sides))
}

/// Whether a curve has a point: a cell of few grains is too small for some statistics.
fn drawable(curve: &StatisticCurve) -> bool {
    curve.x.iter().zip(&curve.y).any(|(x, y)| x.is_finite() && y.value.is_finite())
}

/// Chart of one curve, with the name of the pigment on its axis.
fn chart_of(curve: &StatisticCurve, pigments: &[(String, Shape)]) -> Chart {
    let curves = vec![chart::Curve::measured("", curve.x.iter().copied().zip(curve.y.iter().copied()))];
    Chart { from_zero: true, ..Chart::linear("", &curve.x_label, &named(&curve.y_label, pigments), curves) }
}

/// Replaces the number of a pigment by its name.
fn named(quantity: &str, pigments: &[(String, Shape)]) -> String {
    let name = |(of, k): (&str, &str)| Some(format!("{of} of {}", pigments.get(k.parse::<usize>().ok()?)?.0));
    quantity.split_once(" of pigment ").and_then(name).unwrap_or_else(|| quantity.to_owned())
}

/// Spreads below this share of the mean are rounding, not statistics.
const ROUNDING: f64 = 1e-9;

/// Means below this are written with a power of ten.
const SMALL: f64 = 1e-4;

/// Rounds a value to the digits that its error justifies; without an error, to four digits without
/// trailing zeros.
fn rounded(Estimate { value, standard_error }: Estimate) -> String {
    let digits = if value == 0.0 { 0.0 } else { value.abs().log10().floor() };
    let standard_error = standard_error.filter(|error| *error > ROUNDING * value.abs());
    if value != 0.0 && value.abs() < SMALL {
        // 10.000 after rounding is 1.000 of the next power.
        let digits =
            if (1e3 * value.abs() / 10f64.powf(digits)).round() >= 1e4 { digits + 1.0 } else { digits };
        let unit = 10f64.powf(digits);
        let scaled = Estimate { value: value / unit, standard_error: standard_error.map(|e| e / unit) };
        let words = scaled.in_words(3);
        let words = if words.contains('±') { format!("({words})") } else { without_zeros(&words) };
        return format!("{words} · 10<sup>−{}</sup>", -digits);
    }
    let words = Estimate { value, standard_error }.in_words((3.0 - digits).clamp(0.0, 12.0) as usize);
    if words.contains('±') || !words.contains('.') {
        return words;
    }
    without_zeros(&words)
}

fn without_zeros(words: &str) -> String {
    words.trim_end_matches('0').trim_end_matches('.').to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_means_have_a_power_of_ten_and_rounding_is_no_error() {
        let words = |mean: f64, error: f64| rounded(Estimate { value: mean, standard_error: Some(error) });
        assert_eq!(words(7.5e-8, 1e-23), "7.5 · 10<sup>−8</sup>");
        // *Planted*: a gap of 10⁻⁸ less a rounding was 10.000 · 10⁻⁹.
        assert_eq!(words(1e-8 - 1e-17, 1e-24), "1 · 10<sup>−8</sup>");
        assert_eq!(words(7.5e-8, 1.2e-9), "(7.50 ± 0.12) · 10<sup>−8</sup>");
        assert_eq!(words(0.2, 1e-17), "0.2");
        assert_eq!(words(0.2, 1.2e-3), "0.2000 ± 0.0012");
        assert_eq!(words(0.0, 0.0), "0");
    }

    #[test]
    fn sides_have_their_names() {
        assert_eq!(sided("grains touching the wall z = 0"), "grains touching the free face, z = 0");
        let out = sided("share of the pigment above the binder");
        assert_eq!(out, "share of the pigment that sticks out of the binder's free face");
        assert_eq!(sided("smallest gap"), "smallest gap");
    }
}
