//! Weighted numbers: their weights, ranges and spectra, and whether the study has what they take.

use crate::appearance::weighted::{NumberTransform, WeightTable, WeightedSum, weight_names};
use crate::input::file::{NumberTable, WeightsWritten};
use crate::input::study::{Study, WantedNumber, WantedWeights};
use crate::input::{Faults, as_written, limits};
use crate::material::columns::{Columns, in_other_unit};
use std::path::Path;

/// Largest share of the weights that may lie beyond the wavelengths, where the spectrum is
/// continued by its ends.
const MOST_OUTSIDE: f64 = 0.1;
/// Share from which a remark tells of it.
const WORTH_TELLING: f64 = 1e-2;
/// A mean needs as many wavelengths.
const FEWEST: usize = 3;

/// The numbers of a file, as far as they are valid, for a study that is checked but for them.
pub(super) fn checked(
    written: &[NumberTable],
    study: &Study,
    folder: &Path,
    faults: &mut Faults,
) -> (Vec<WantedNumber>, Vec<String>) {
    let mut wanted: Vec<WantedNumber> = Vec::new();
    let mut remarks = Vec::new();
    for (i, table) in written.iter().enumerate() {
        let field = format!("number[{i}]");
        let others = written[..i].iter().map(|other| other.name.as_str());
        faults.name(format!("{field}.name"), &table.name, others, "number");
        let Some(weights) = weights(&field, &table.weights, folder, faults) else { continue };
        let Some(number) = ranged(&field, table, weights, faults) else { continue };
        check_transform(&field, &number, faults);
        check_spectra(&field, &number, study, faults);
        remarks.extend(check_wavelengths(&field, &number, study, faults));
        wanted.push(number);
    }
    (wanted, remarks)
}

/// Weights by name or from a file.
fn weights(
    field: &str,
    written: &WeightsWritten,
    folder: &Path,
    faults: &mut Faults,
) -> Option<WantedWeights> {
    match written {
        WeightsWritten::Named(name) => {
            let named = WantedWeights::Named(name.clone()).tables();
            if named.is_none() {
                let allowed = format!(
                    "one of {}; or an illuminant and an observer such as \"D65/10\", \"C/2\", \"A/2\"",
                    weight_names().join(", ")
                );
                let remedy = "write one of these, or bring a table: weights = { csv = \"weights.csv\" }";
                faults.add(format!("{field}.weights"), format!("{name:?}"), allowed, remedy);
            }
            named.map(|named| WantedWeights::Named(named.name))
        }
        WeightsWritten::Csv { csv, column } => {
            let read = read(&folder.join(csv), column.as_deref());
            let file_name = Path::new(csv).file_name().unwrap_or_default().to_string_lossy().into_owned();
            let source = match column {
                Some(column) => format!("{file_name}: {column}"),
                None => file_name,
            };
            match read {
                Ok(table) => Some(WantedWeights::Table { source, table }),
                Err(error) => {
                    let allowed =
                        "a readable table with the columns wavelength_nm (rising) and weight (0 or more)";
                    let remedy = "correct the file; its path is relative to the study file";
                    faults.add(format!("{field}.weights.csv"), error, allowed, remedy);
                    None
                }
            }
        }
    }
}

/// Words for spectra, by which no column of weights is named.
const MEASURED: [&str; 4] = ["reflect", "transmitt", "absor", "albedo"];

fn read(path: &Path, column: Option<&str>) -> Result<WeightTable, String> {
    let columns = Columns::read(path).map_err(|error| error.to_string())?;
    let of_file = |what: String| format!("{}: {what}", path.display());
    let nm = columns.find(&["wavelength_nm", "wavelength", "nm"]);
    let nm =
        nm.ok_or_else(|| of_file(format!("no column wavelength_nm among {}", columns.names.join(", "))))?;
    let others: Vec<&String> =
        columns.names.iter().enumerate().filter(|(k, _)| *k != nm).map(|(_, name)| name).collect();
    let wanted = match (column, others.as_slice()) {
        (Some(name), _) => name.to_lowercase(),
        (None, [only]) if MEASURED.iter().any(|name| only.to_lowercase().contains(name)) => {
            return Err(of_file(format!("a column {only}, which is a spectrum and no weights")));
        }
        (None, [only]) => (*only).clone(),
        (None, _) => "weight".to_owned(),
    };
    let place = columns.find(&[&wanted]).filter(|place| *place != nm);
    let names = columns.names.join(", ");
    let place = place
        .ok_or_else(|| of_file(format!("no column {wanted} among {names}: name one, column = \"…\"")))?;
    let nm = columns.wavelengths_nm(nm).map_err(|error| error.to_string())?;
    let weights = columns.numbers(place).map_err(|error| error.to_string())?;
    let rows = nm.into_iter().zip(weights).map(|(nm, weight)| [nm, weight]).collect();
    WeightTable::new(rows).map_err(|error| of_file(error.to_string()))
}

/// The number with its range of wavelengths.
fn ranged(
    field: &str,
    table: &NumberTable,
    weights: WantedWeights,
    faults: &mut Faults,
) -> Option<WantedNumber> {
    let tables = weights.tables()?;
    let [first, last] = tables.tables[0].range_nm();
    for (key, nm) in [("from_nm", table.from_nm), ("to_nm", table.to_nm)] {
        if let Some(nm) = nm {
            let remedy = "leave it out for all of the weights";
            faults.number(&format!("{field}.{key}"), nm, limits::WAVELENGTH_NM, remedy);
        }
    }
    let range_nm = [table.from_nm.unwrap_or(first).max(first), table.to_nm.unwrap_or(last).min(last)];
    let number = WantedNumber {
        name: table.name.clone(),
        weights,
        range_nm,
        of: table.of,
        over: table.over,
        transform: table.transform,
    };
    if number.tables().is_none() {
        let [from, to] = [table.from_nm.unwrap_or(first), table.to_nm.unwrap_or(last)];
        let found = format!("{from} to {to} nm, where {} has no weight", number.weights.source());
        let allowed = format!("a range within {first} to {last} nm, from_nm below to_nm");
        let remedy = "correct from_nm and to_nm, or leave them out";
        faults.add(format!("{field}.from_nm"), found, allowed, remedy);
        return None;
    }
    Some(number)
}

/// Transforms of X, Y, Z take weights that have them, under the conditions of their definition.
fn check_transform(field: &str, number: &WantedNumber, faults: &mut Faults) {
    let transform = number.transform;
    if !transform.of_tristimulus() {
        return;
    }
    let mut wrong = |key: &str, found: String, allowed: &str, remedy: &str| {
        faults.add(format!("{field}.{key}"), found, allowed, remedy);
    };
    let name = transform.name();
    let white = number.weights.tables().and_then(|named| named.white);
    let is_defined = white.as_ref().is_some_and(|white| match transform {
        NumberTransform::Yellowness => white.yellowness().is_some(),
        _ => white.illuminant == "D65" && matches!(white.observer.as_str(), "2" | "10"),
    });
    if !is_defined {
        let allowed = match transform {
            NumberTransform::Yellowness => {
                "\"C/2\", \"C/10\", \"D65/2\" or \"D65/10\" with transform = \"yellowness\" (ASTM E313)"
            }
            _ => "\"D65/10\" or \"D65/2\" with transform = \"whiteness\" and \"tint\" (CIE 15)",
        };
        let found = format!("{:?} with transform = {name:?}", number.weights.source());
        wrong("weights", found, allowed, "write weights = \"D65/10\"");
    }
    if let Some(over) = number.over {
        let remedy = "leave it out, or take transform = \"mean\"";
        wrong(
            "over",
            format!("{} with transform = {name:?}", as_written(&over)),
            "transforms of a single mean",
            remedy,
        );
    }
    let [first, last] = number.weights.tables().map_or(number.range_nm, |named| named.tables[0].range_nm());
    if number.range_nm != [first, last] {
        let [from, to] = number.range_nm;
        let remedy = "leave out from_nm and to_nm";
        wrong("from_nm", format!("{from} to {to} nm"), "all wavelengths of X, Y, Z", remedy);
    }
}

/// The study has the spectra.
fn check_spectra(field: &str, number: &WantedNumber, study: &Study, faults: &mut Faults) {
    let keys = [Some(("of", number.of)), number.over.map(|over| ("over", over))];
    for (key, light) in keys.into_iter().flatten() {
        let mut wrong = |allowed: String, remedy: &str| {
            faults.add(format!("{field}.{key}"), format!("{:?}", light.name()), allowed, remedy);
        };
        if let Some(reason) = study.no_ink().filter(|_| light.on_paper()) {
            let remedy = "take reflectance or transmittance, or angles.count instead of a list";
            wrong(format!("spectra of the layer alone, which has no paper: {reason}"), remedy);
        } else if !light.on_paper() && !study.angles.exact_deg.iter().any(|deg| deg.abs() < 1e-9) {
            let listed: Vec<String> = study.angles.exact_deg.iter().map(f64::to_string).collect();
            let allowed = format!("angles with 0°, found {}°", listed.join(", "));
            wrong(allowed, "add 0 to angles.polar_deg");
        } else if light.is_coherent() && study.variation.thickness_std_um > 0.0 {
            let allowed =
                "transmittance where the thickness varies: areas of different thickness have no common phase";
            wrong(allowed.to_owned(), "take transmittance, or one thickness");
        }
    }
}

/// The wavelengths cover the weights but for a small part; a remark where they do not quite.
fn check_wavelengths(
    field: &str,
    number: &WantedNumber,
    study: &Study,
    faults: &mut Faults,
) -> Option<String> {
    let nm = &study.wavelengths_nm;
    let (first, last) = (*nm.first()?, *nm.last()?);
    let mut wrong = |found: String, allowed: String, remedy: &str| {
        faults.add(format!("{field}.weights"), found, allowed, remedy);
    };
    let [from, to] = number.range_nm;
    let source = number.weights.source();
    if nm.len() < FEWEST {
        let found = format!("{source} over {} wavelengths", nm.len());
        wrong(found, format!("{FEWEST} or more wavelengths in [light]"), "a mean needs a spectrum");
        return None;
    }
    let tables = number.tables()?;
    let outside = tables.sums(nm).iter().map(WeightedSum::outside).fold(0.0, f64::max);
    if outside > MOST_OUTSIDE {
        let found = format!(
            "{source} from {from} to {to} nm, of which {:.0} % lie beyond the wavelengths, {first} to {last} nm",
            100.0 * outside
        );
        let allowed = format!("at most {:.0} % beyond them", 100.0 * MOST_OUTSIDE);
        let usual = "widen light.from_nm and light.to_nm, or count a part of the weights: from_nm and to_nm beside them";
        let remedy = in_other_unit([from, to], [first, last]).unwrap_or_else(|| usual.to_owned());
        wrong(found, allowed, &remedy);
        return None;
    }
    let words = format!(
        "{field} ({}): {:.1} % of the weights of {source} lie beyond the wavelengths, {first} to {last} nm: the spectrum is \
         continued by its values at the ends, and the error bar includes what the rest could be",
        number.name,
        100.0 * outside
    );
    (outside > WORTH_TELLING).then_some(words)
}
