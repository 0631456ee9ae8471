//! Tables of a composed layer.

use crate::draw::cell::{numbers, table, with_errors};
use crate::evaluate::composed::manifest::{AbsorbedRow, ComposedManifest, DistributionRow};
use crate::report::numbers::numbers_table;
use crate::report::tables::{self, NamedTable};

/// All tables.
///
/// # Errors
/// One that cannot be written.
pub fn tables(manifest: &ComposedManifest) -> csv::Result<Vec<NamedTable>> {
    let spectra = tables::rows(manifest.spectra.iter().chain(&manifest.curve))?;
    let medium = tables::rows(&manifest.medium)?;
    let mut all = vec![
        ("spectra.csv", spectra, "R, T and what is seen on the paper at every thickness and wavelength"),
        ("medium.csv", medium, "what the packed medium is to light"),
        ("bdf.csv", distributions(&manifest.distributions)?, "where light at 0° goes, layer alone"),
    ];
    if !manifest.absorbed.is_empty() {
        all.push(("absorbed.csv", absorbed(&manifest.absorbed)?, "what every layer absorbs of light at 0°"));
    }
    let weighted: Vec<_> = manifest.numbers.iter().chain(&manifest.curve_numbers).cloned().collect();
    all.extend(numbers_table(&weighted)?);
    all.extend(tables::prints(manifest.prints.as_ref())?);
    all.extend(tables::print_spectra(manifest.prints.as_ref(), &manifest.study.wavelengths_nm)?);
    Ok(all)
}

fn absorbed(rows: &[AbsorbedRow]) -> csv::Result<Vec<u8>> {
    let place = ["thickness_um", "wavelength_nm", "layer"].map(str::to_owned);
    let line = |row: &AbsorbedRow| {
        let place = [row.thickness_um.to_string(), row.wavelength_nm.to_string(), row.layer.clone()];
        (place, numbers(Some(row.absorptance_normal.estimate())))
    };
    table(place.into_iter().chain(with_errors(["absorptance_normal"])), rows.iter().map(line))
}

fn distributions(rows: &[DistributionRow]) -> csv::Result<Vec<u8>> {
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
