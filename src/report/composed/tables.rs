//! Tables of a composed layer.

use crate::draw::cell::{numbers, table, with_errors};
use crate::evaluate::composed::manifest::{
    ComposedManifest, ComposedRow, DistributionRow, ErrorParts, MediumRow,
};
use crate::report::tables::NamedTable;

/// All tables.
///
/// # Errors
/// One that cannot be written.
pub fn tables(manifest: &ComposedManifest) -> csv::Result<[NamedTable; 3]> {
    let layers = manifest.spectra.iter().chain(&manifest.curve);
    let layers = layers.map(|row| {
        let numbers = row.numbers();
        let named: [_; 12] = std::array::from_fn(|k| (ComposedRow::NAMES[k], numbers[k]));
        ([row.thickness_um, row.wavelength_nm], named)
    });
    let spectra = rows(["thickness_um", "wavelength_nm"], layers)?;
    let medium = manifest.medium.iter().map(|row| ([row.wavelength_nm], coefficients(row)));
    Ok([
        ("spectra.csv", spectra, "R, T and what is seen on the paper at every thickness and wavelength"),
        ("medium.csv", rows(["wavelength_nm"], medium)?, "what the packed medium is to light"),
        ("bdf.csv", distributions(&manifest.distributions)?, "where light at 0° goes, layer alone"),
    ])
}

/// Names and values of a medium; `None` for those withheld.
pub fn coefficients(row: &MediumRow) -> [(&'static str, Option<ErrorParts>); 8] {
    [
        ("effective_index", row.effective_index),
        ("coherent_path_um", row.coherent_path_um),
        ("scattering_per_um", row.scattering_per_um),
        ("absorption_per_um", row.absorption_per_um),
        ("asymmetry", row.asymmetry),
        ("transport_path_um", row.transport_path_um),
        ("kubelka_munk_absorption_per_um", row.kubelka_munk_absorption_per_um),
        ("kubelka_munk_scattering_per_um", row.kubelka_munk_scattering_per_um),
    ]
}

/// A table of rows, each a place and values with their errors.
fn rows<const P: usize, const N: usize>(
    place: [&str; P],
    rows: impl Iterator<Item = ([f64; P], [(&'static str, Option<ErrorParts>); N])>,
) -> csv::Result<Vec<u8>> {
    let mut rows = rows.peekable();
    let names = rows.peek().map(|(_, values)| values.map(|(name, _)| name));
    let lines = rows.map(|(place, values)| {
        let values = values.map(|(_, judged)| numbers(judged.map(|number| number.estimate())));
        [place.map(|x| x.to_string()).to_vec(), values.concat()].concat()
    });
    table(place.map(str::to_owned).into_iter().chain(with_errors(names.into_iter().flatten())), lines)
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
