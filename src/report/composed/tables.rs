//! Tables of a composed layer.

use crate::evaluate::composed::manifest::{
    ComposedManifest, ComposedRow, DistributionRow, ErrorParts, MediumRow,
};
use crate::report::cell::{numbers, table, with_errors};

/// A table's name, bytes and description.
type NamedTable = (&'static str, Vec<u8>, &'static str);

/// All tables.
///
/// # Errors
/// One that cannot be written.
pub fn tables(manifest: &ComposedManifest) -> csv::Result<[NamedTable; 3]> {
    let rows = spectra(manifest.spectra.iter().chain(&manifest.curve))?;
    Ok([
        ("spectra.csv", rows, "R, T and what is seen on the paper at every thickness and wavelength"),
        ("medium.csv", medium(&manifest.medium)?, "what the packed medium is to light"),
        ("bdf.csv", distributions(&manifest.distributions)?, "where light at 0° goes, layer alone"),
    ])
}

/// Names and values of a row.
pub(super) fn shares(row: &ComposedRow) -> [(&'static str, ErrorParts); 12] {
    [
        ("reflectance_normal", row.reflectance_normal),
        ("transmittance_normal", row.transmittance_normal),
        ("reflectance_45", row.reflectance_45),
        ("transmittance_45", row.transmittance_45),
        ("reflectance_diffuse", row.reflectance_diffuse),
        ("transmittance_diffuse", row.transmittance_diffuse),
        ("coherent_transmittance", row.coherent_transmittance),
        ("mirrored", row.mirrored),
        ("natural_light", row.natural_light),
        ("lit_at_45", row.lit_at_45),
        ("over_black", row.over_black),
        ("over_white", row.over_white),
    ]
}

fn spectra<'a>(rows: impl Iterator<Item = &'a ComposedRow> + Clone) -> csv::Result<Vec<u8>> {
    let names = rows.clone().next().map(shares).into_iter().flatten().map(|(name, _)| name);
    let header = ["thickness_um", "wavelength_nm"].map(str::to_owned).into_iter().chain(with_errors(names));
    table(header, rows.map(|row| line(&[row.thickness_um, row.wavelength_nm], &shares(row))))
}

/// Names and values of a medium.
pub fn coefficients(row: &MediumRow) -> [(&'static str, ErrorParts); 8] {
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

fn medium(rows: &[MediumRow]) -> csv::Result<Vec<u8>> {
    let names = rows.first().map(coefficients).into_iter().flatten().map(|(name, _)| name);
    let header = std::iter::once("wavelength_nm".to_owned()).chain(with_errors(names));
    table(header, rows.iter().map(|row| line(&[row.wavelength_nm], &coefficients(row))))
}

fn distributions(rows: &[DistributionRow]) -> csv::Result<Vec<u8>> {
    let place = ["thickness_um", "wavelength_nm", "polar_in_deg", "lobe", "polar_out_deg", "projected_sr"];
    let header = place.map(str::to_owned).into_iter().chain(with_errors(["bdf_per_sr"]));
    table(header, rows.iter().map(leaving))
}

/// A line of the table of light that leaves.
fn leaving(row: &DistributionRow) -> Vec<String> {
    let lobe = if row.reflected { "reflected" } else { "transmitted" };
    let place = [row.thickness_um, row.wavelength_nm, 0.0].map(|x| x.to_string());
    let out = [row.polar_out_deg, row.projected_sr].map(|x| x.to_string());
    let place = place.into_iter().chain([lobe.to_owned()]).chain(out);
    place.chain(numbers(Some(row.bdf_per_sr.estimate()))).collect()
}

/// A line of a table: its place, and values with their errors.
fn line(place: &[f64], values: &[(&str, ErrorParts)]) -> Vec<String> {
    let values = values.iter().flat_map(|(_, judged)| numbers(Some(judged.estimate())));
    place.iter().map(f64::to_string).chain(values).collect()
}
