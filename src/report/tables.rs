//! CSV tables for other programs: all of a study, rows of published numbers, and distributions.

use super::columns::NamedTable;
use super::numbers::numbers_table;
use crate::appearance::bdf::{Bdf, Lobe, OrderMean};
use crate::draw::cell::{numbers, records, table, with_errors};
use crate::evaluate::gate;
use crate::evaluate::ink_maker::InkMaker;
use crate::evaluate::manifest::composed::{AbsorbedRow, DistributionRow};
use crate::evaluate::manifest::left_out::{DensityRow, LeftOutRow};
use crate::evaluate::manifest::{AbsorbedNote, ComposedResults, Manifest, SpectrumRow};
use crate::evaluate::printed::{PrintNote, Prints};
use crate::evaluate::published::{PublishedRow, Quantity};
use crate::evaluate::seen::Seen;
use crate::input::measured::MeasuredCondition;
use crate::numerics::estimate::Estimate;
use crate::wave::Side;

/// A table of rows: the columns that tell which row it is, then every number with its standard
/// error. Withheld numbers and unknown errors are empty.
///
/// # Errors
/// A table that cannot be written.
pub fn rows<'a, R: PublishedRow + 'a>(rows: impl IntoIterator<Item = &'a R>) -> csv::Result<Vec<u8>> {
    let place = R::PLACE.iter().map(|name| (*name).to_owned());
    let lines = rows.into_iter().map(|row| {
        let place: Vec<String> = row.place().iter().map(f64::to_string).collect();
        let all: Vec<[String; 2]> = row.numbers().iter().map(|number| numbers(number.estimate)).collect();
        (place, all)
    });
    table(place.chain(with_errors(R::names())), lines)
}

/// All tables of a study, in the order in which they are described; `seen` has the distributions of
/// a layer that is solved as a whole.
///
/// # Errors
/// One that cannot be written.
pub fn of_study(manifest: &Manifest, seen: Option<&Seen>) -> csv::Result<Vec<NamedTable>> {
    let mut all = Vec::new();
    let mut weighted = manifest.numbers.clone();
    if let Some(ComposedResults { slabs, rows: of_thicknesses, .. }) = manifest.composed() {
        weighted.extend(slabs.curve_numbers.iter().cloned());
        let spectra = rows(of_thicknesses.iter().chain(&slabs.curve))?;
        let leaving = leaving_light(&slabs.distributions)?;
        all.extend([
            ("spectra.csv", spectra, "R, T and what is seen on the paper at every thickness and wavelength"),
            ("medium.csv", rows(&slabs.medium)?, "what the packed medium is to light"),
            ("bdf.csv", leaving, "where light at 0° goes, layer alone"),
        ]);
        if !slabs.absorbed.is_empty() {
            let about = "what every layer absorbs of light at 0°";
            all.push(("absorbed.csv", absorbed(&slabs.absorbed)?, about));
        }
    }
    if let Some((whole, seen)) = manifest.whole().zip(seen) {
        let certainty = &whole.ensemble.certainty;
        let index_out = manifest.study.layer.index_out;
        let bdf = distributions(&seen.bdfs, certainty.amplitude_error_estimate, index_out)?;
        all.extend([
            ("spectra.csv", rows(whole.rows)?, "spectra of the layer alone, and on its paper"),
            ("bdf.csv", bdf, "distributions of the layer alone, order by order"),
        ]);
        all.extend(instruments(whole.rows)?);
        all.extend(absorbed_by_layers(&manifest.absorbed)?);
        all.extend(ink_maker(manifest.ink_maker.as_ref(), certainty.coverage_factor_95)?);
    }
    if !manifest.left_out.rows.is_empty() {
        let about = "the stack on its paper without each of its layers, and each layer alone";
        all.push(("left-out.csv", left_out(&manifest.left_out.rows)?, about));
        let about = "densities at 45:0: of the stack, and of its layers alone";
        all.push(("densities.csv", densities(&manifest.left_out.densities)?, about));
    }
    all.extend(numbers_table(&weighted)?);
    all.extend(prints(manifest.prints.as_ref())?);
    all.extend(print_spectra(manifest.prints.as_ref(), &manifest.study.wavelengths_nm)?);
    Ok(all)
}

/// `kubelka-munk.csv` where K and S are known, and `measured.csv` if there is a measurement.
/// `factor` times a standard error is half the width of a 95 % interval: with few realisations far
/// more than 2.
fn ink_maker(maker: Option<&InkMaker>, factor: Option<f64>) -> csv::Result<Vec<NamedTable>> {
    let Some(maker) = maker else { return Ok(Vec::new()) };
    let mut files = Vec::new();
    if !maker.kubelka_munk.is_empty() {
        let columns = ["absorption_per_um", "scattering_per_um"].into_iter().flat_map(|name| {
            [name.to_owned(), format!("{name}_standard_error"), format!("{name}_half_width_95")]
        });
        let rows = maker.kubelka_munk.iter().map(|row| {
            let both = [row.absorption_per_um, row.scattering_per_um];
            (row.wavelength_nm.to_string(), both.map(|e| with_half(e, factor)))
        });
        let header = std::iter::once("wavelength_nm".to_owned()).chain(columns);
        files.push(("kubelka-munk.csv", table(header, rows)?, "K and S of the layer without surfaces"));
    }
    if let Some(measured) = &maker.measured {
        let header = ["wavelength_nm", "measured", "predicted", "predicted_standard_error"];
        let rows = measured.rows.iter().map(|row| {
            ([row.wavelength_nm.to_string(), row.measured.to_string()], numbers(Some(row.predicted)))
        });
        files.push(("measured.csv", table(header, rows)?, "the measurement and its prediction"));
    }
    Ok(files)
}

/// `instruments.csv`, where there is a layer on paper: what instruments of diffuse light read, and
/// what the series of returns needs.
fn instruments(rows: &[SpectrumRow]) -> csv::Result<Option<NamedTable>> {
    let read = |row: &SpectrumRow| {
        let SpectrumRow { sphere_at_8, sphere_at_8_excluded, diffuse_normal, .. } = *row;
        [sphere_at_8, sphere_at_8_excluded, diffuse_normal, row.transmittance_diffuse, row.absorptance_behind]
    };
    let lines: Vec<_> = rows
        .iter()
        .filter(|row| read(row).iter().any(Option::is_some))
        .map(|row| (row.wavelength_nm.to_string(), read(row).map(numbers)))
        .collect();
    if lines.is_empty() {
        return Ok(None);
    }
    let names = ["sphere_at_8", "sphere_at_8_excluded", "diffuse_normal", "transmittance_diffuse"];
    let names = names.into_iter().chain(["absorptance_behind"]);
    let bytes = table(std::iter::once("wavelength_nm".to_owned()).chain(with_errors(names)), lines)?;
    let about = "what instruments of diffuse light read, and means for the series of returns from any paper";
    Ok(Some(("instruments.csv", bytes, about)))
}

/// `absorbed.csv`, where there are several layers.
fn absorbed_by_layers(rows: &[AbsorbedNote]) -> csv::Result<Option<NamedTable>> {
    if rows.is_empty() {
        return Ok(None);
    }
    let place = ["wavelength_nm", "polar_deg", "layer"].map(str::to_owned);
    let lines = rows.iter().map(|row| {
        let place = [row.wavelength_nm.to_string(), row.polar_deg.to_string(), row.layer.clone()];
        (place, numbers(Some(row.absorptance)))
    });
    let bytes = table(place.into_iter().chain(with_errors(["absorptance"])), lines)?;
    Ok(Some(("absorbed.csv", bytes, "what every layer of the stack absorbs, without paper")))
}

/// `prints.csv`, where there are prints besides the solid on plain paper.
fn prints(prints: Option<&Prints>) -> csv::Result<Vec<NamedTable>> {
    let Some(Prints { prints, .. }) = prints else { return Ok(Vec::new()) };
    let place = |note: &PrintNote| {
        let condition = note.print.condition.map_or("", MeasuredCondition::name).to_owned();
        let thickness = note.thickness_um.map_or_else(String::new, |um| um.to_string());
        [condition, thickness, note.print.nominal.to_string()]
    };
    let names = ["condition", "thickness_um", "nominal_coverage"].map(str::to_owned);
    let rows = prints.iter().map(|note| {
        let [l, a, b] = note.lab.map(|number| numbers(Some(number)));
        let geometry = [note.print.coverage, note.print.spread].map(|x| x.to_string());
        let n = note.yule_nielsen.map_or_else(String::new, |n| n.to_string());
        (
            place(note),
            geometry,
            [
                l,
                a,
                b,
                numbers(note.apparent_coverage),
                numbers(note.optical_gain),
                numbers(Some(note.density)),
                numbers(note.additivity),
            ],
            [n, note.name()],
        )
    });
    let more = ["coverage", "spread_share"].map(str::to_owned);
    let bars = with_errors(["L", "a", "b", "apparent_coverage", "optical_gain", "density", "additivity"]);
    let last = ["yule_nielsen_n", "print"].map(str::to_owned);
    let colours = table(names.iter().cloned().chain(more).chain(bars).chain(last), rows)?;
    Ok(vec![("prints.csv", colours, "colours at 45:0 of every print, from bare paper to the solid")])
}

/// `print-spectra.csv`: radiance factors of all prints at the study's wavelengths.
fn print_spectra(prints: Option<&Prints>, wavelengths_nm: &[f64]) -> csv::Result<Vec<NamedTable>> {
    let Some(Prints { prints, .. }) = prints else { return Ok(Vec::new()) };
    let mut rows = Vec::new();
    for note in prints {
        let condition = note.print.condition.map_or("", MeasuredCondition::name);
        let thickness = note.thickness_um.map_or_else(String::new, |um| um.to_string());
        for (nm, factor) in wavelengths_nm.iter().zip(&note.factors) {
            let place =
                [condition.to_owned(), thickness.clone(), note.print.nominal.to_string(), nm.to_string()];
            rows.push((place, numbers(Some(*factor)), note.name()));
        }
    }
    let names = ["condition", "thickness_um", "nominal_coverage", "wavelength_nm"].map(str::to_owned);
    let last = std::iter::once("print".to_owned());
    let header = names.into_iter().chain(with_errors(["radiance_factor"])).chain(last);
    Ok(vec![("print-spectra.csv", table(header, rows)?, "radiance factors at 45:0 of every print")])
}

/// A number with its standard error and half the width of its 95 % interval.
fn with_half(e: Estimate, factor: Option<f64>) -> ([String; 2], String) {
    let half = e.standard_error.zip(factor).map_or_else(String::new, |(error, f)| (error * f).to_string());
    (numbers(Some(e)), half)
}

/// Distributions of the layer alone, one row per order: direction cosines, efficiency and BRDF or
/// BTDF. The specular order is marked: it is a mirror image, not a density per steradian. In a
/// medium of index n, dα dβ = n² cos θ dω, so that a steradian there holds n² times as many orders.
///
/// `amplitude_error` is the error of an order's complex amplitude a due to the grid; its efficiency
/// e = w|a|² then has an error of 2 √(e w) times that, where w = cos θ_out/cos θ_in is the order's
/// share of the flux.
fn distributions(bdfs: &[Bdf], amplitude_error: f64, index_out: f64) -> csv::Result<Vec<u8>> {
    let lobes = bdfs.iter().flat_map(|bdf| [(bdf, Lobe::Reflected), (bdf, Lobe::Transmitted)]);
    let orders = lobes.flat_map(|(bdf, lobe)| bdf.orders(lobe).iter().map(move |order| (bdf, lobe, order)));
    records(orders.map(|(bdf, lobe, order)| row(bdf, lobe, order, amplitude_error, index_out)))
}

fn row(
    bdf: &Bdf,
    lobe: Lobe,
    order: &OrderMean,
    amplitude_error: f64,
    index_out: f64,
) -> [(&'static str, String); 16] {
    let incidence = bdf.incidence;
    let (from, here, beyond) = match incidence.from {
        Side::Incident => ("incident", 1.0, index_out),
        Side::Exit => ("exit", index_out, 1.0),
    };
    let index = if lobe == Lobe::Reflected { here } else { beyond };
    let [x, y] = order.direction;
    // Power across a plane goes with k_z: index · cosine.
    let flux =
        (index * index - x * x - y * y).max(0.0).sqrt() / (here * incidence.polar_deg.to_radians().cos());
    let grid_error = 2.0 * (order.efficiency.value.max(0.0) * flux).sqrt() * amplitude_error;
    let lobe = if lobe == Lobe::Reflected { "reflected" } else { "transmitted" };
    let density = index * index;
    let in_medium = Estimate {
        value: density * order.bdf.value,
        standard_error: order.bdf.standard_error.map(|error| density * error),
    };
    let possible = |quantity, e: Estimate| Some(e).filter(|e| gate::impossible(quantity, *e).is_none());
    let [efficiency, efficiency_error] = numbers(possible(Quantity::Share, order.efficiency));
    let [per_sr, per_sr_error] = numbers(possible(Quantity::Size, in_medium));
    [
        // 0.41 µm is 410 nm, not 410.00000000000006
        ("wavelength_nm", ((1e12 * incidence.wavelength_um).round() / 1e9).to_string()),
        ("from", from.to_owned()),
        ("polar_in_deg", incidence.polar_deg.to_string()),
        ("azimuth_in_deg", incidence.azimuth_deg.to_string()),
        ("lobe", lobe.to_owned()),
        ("m", order.m.to_string()),
        ("n", order.n.to_string()),
        ("alpha", x.to_string()),
        ("beta", y.to_string()),
        ("specular", (order.m == 0 && order.n == 0).to_string()),
        ("efficiency", efficiency),
        ("efficiency_standard_error", efficiency_error),
        ("bdf_per_sr", per_sr),
        ("bdf_standard_error", per_sr_error),
        ("realisations", bdf.realisations.to_string()),
        ("efficiency_grid_error", grid_error.to_string()),
    ]
}

fn absorbed(rows: &[AbsorbedRow]) -> csv::Result<Vec<u8>> {
    let place = ["thickness_um", "wavelength_nm", "layer"].map(str::to_owned);
    let line = |row: &AbsorbedRow| {
        let place = [row.thickness_um.to_string(), row.wavelength_nm.to_string(), row.layer.clone()];
        (place, numbers(Some(row.absorptance_normal.estimate())))
    };
    table(place.into_iter().chain(with_errors(["absorptance_normal"])), rows.iter().map(line))
}

fn left_out(rows: &[LeftOutRow]) -> csv::Result<Vec<u8>> {
    let place = ["thickness_um", "wavelength_nm", "layer"].map(str::to_owned);
    let names = ["lit_at_45_without", "natural_light_without", "lit_at_45_alone", "natural_light_alone"];
    let line = |row: &LeftOutRow| {
        let place = [row.thickness_um.to_string(), row.wavelength_nm.to_string(), row.layer.clone()];
        let all =
            [row.lit_at_45_without, row.natural_light_without, row.lit_at_45_alone, row.natural_light_alone];
        (place, all.map(|number| numbers(number.map(|number| number.estimate()))))
    };
    table(place.into_iter().chain(with_errors(names)), rows.iter().map(line))
}

fn densities(rows: &[DensityRow]) -> csv::Result<Vec<u8>> {
    let place = ["thickness_um", "wavelength_nm"].map(str::to_owned);
    let line = |row: &DensityRow| {
        let all = [row.density_of_stack, row.density_of_layers, row.density_ratio];
        let place = [row.thickness_um, row.wavelength_nm].map(|x| x.to_string());
        (place, all.map(|number| numbers(number.map(|number| number.estimate()))))
    };
    let names = ["density_of_stack", "density_of_layers", "density_ratio"];
    table(place.into_iter().chain(with_errors(names)), rows.iter().map(line))
}

fn leaving_light(rows: &[DistributionRow]) -> csv::Result<Vec<u8>> {
    let place = ["thickness_um", "wavelength_nm", "polar_in_deg", "lobe", "polar_out_deg", "projected_sr"];
    table(place.map(str::to_owned).into_iter().chain(with_errors(["bdf_per_sr"])), rows.iter().map(leaving))
}

/// A line of the table of light that leaves.
fn leaving(row: &DistributionRow) -> ([String; 3], &'static str, [String; 2], [String; 2]) {
    let lobe = if row.reflected { "reflected" } else { "transmitted" };
    let place = [row.thickness_um, row.wavelength_nm, 0.0].map(|x| x.to_string());
    let out = [row.polar_out_deg, row.projected_sr].map(|x| x.to_string());
    (place, lobe, out, numbers(Some(row.bdf_per_sr.estimate())))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::manifest::SpectrumReplicates;
    use inkwave_validation::fixtures::two_orders;

    #[test]
    fn tables_are_rectangular_and_unknown_errors_are_empty() {
        let bdf = Bdf::from_ensemble(&[two_orders()]).unwrap();
        let csv = distributions(&[bdf], 1e-3, 1.5).unwrap();
        let mut reader = csv::Reader::from_reader(csv.as_slice());
        let rows: Vec<csv::StringRecord> = reader.records().collect::<Result<_, _>>().unwrap();
        assert_eq!(rows.len(), 2);
        assert_eq!((&rows[0][4], &rows[0][10], &rows[0][11]), ("reflected", "0.05", ""));
    }

    /// An order's share of the light is its distribution times the projected solid angle that it
    /// stands for, λ²/(Lx Ly n²) in a medium of index n, into which light leaves or is reflected
    /// back. *Planted*: the solid angle of vacuum.
    #[test]
    fn distributions_are_per_steradian_of_the_medium() {
        for (from, reflected, transmitted) in [(Side::Incident, 1.0, 1.5), (Side::Exit, 1.5, 1.0)] {
            let mut field = two_orders();
            field.incidence.from = from;
            let bdf = Bdf::from_ensemble(&[field.clone()]).unwrap();
            let csv = distributions(&[bdf], 1e-3, 1.5).unwrap();
            let mut reader = csv::Reader::from_reader(csv.as_slice());
            let rows: Vec<csv::StringRecord> = reader.records().collect::<Result<_, _>>().unwrap();
            for (row, index) in rows.iter().zip([reflected, transmitted]) {
                let cell = field.incidence.wavelength_um.powi(2) / (field.period_um[0] * field.period_um[1]);
                let efficiency = row[10].parse::<f64>().unwrap();
                let per_sr = row[12].parse::<f64>().unwrap();
                let share = per_sr * cell / f64::powi(index, 2);
                // An identity: rounding.
                assert!(
                    (share / efficiency - 1.0).abs() < 1e-12,
                    "{from:?} {}: {share} {efficiency}",
                    &row[4]
                );
            }
        }
    }

    #[test]
    fn a_spectrum_has_a_row_for_each_wavelength() {
        let of = |value| Estimate { value, standard_error: Some(0.125) };
        let row = SpectrumRow {
            wavelength_nm: 400.0,
            polar_deg: 0.0,
            reflectance: of(0.25),
            specular_reflectance: of(0.1),
            transmittance: of(0.5),
            specular_transmittance: of(0.4),
            coherent_transmittance: Some(of(0.375)),
            absorptance: of(0.25),
            natural_light: None,
            lit_at_45: Some(of(0.75)),
            sphere_at_8: None,
            sphere_at_8_excluded: None,
            diffuse_normal: None,
            transmittance_diffuse: Some(of(0.625)),
            absorptance_behind: None,
            deviations: Vec::new(),
            replicates: SpectrumReplicates::default(),
        };
        let text = String::from_utf8(rows(&[row]).unwrap()).unwrap();
        let last = text.lines().last().unwrap();
        assert_eq!(
            last,
            "400,0,0.25,0.125,0.1,0.125,0.5,0.125,0.4,0.125,0.25,0.125,,,0.75,0.125,0.375,0.125"
        );
    }
}
