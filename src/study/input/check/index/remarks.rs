//! Remarks on tables of indices that can be used: wide gaps, seams between records, former names.

use crate::input::study::Study;
use crate::material::columns::widest_gap_nm;
use crate::material::named::NamedMaterial;
use crate::material::spectra::{CutBand, Spectrum};
use std::collections::BTreeSet;

/// One remark for every file with a wide gap within the study's wavelengths, for every seam of
/// joined records there, and for every material under a former name.
pub(in crate::input::check) fn bridged(study: &Study) -> BTreeSet<String> {
    let Some(&from) = study.wavelengths_nm.first() else { return BTreeSet::new() };
    let Some(&to) = study.wavelengths_nm.last() else { return BTreeSet::new() };
    let dissolved = study.dissolved.iter().map(|dissolved| &dissolved.material);
    let materials = study.materials().chain(study.extraordinary_indices());
    let spectra = materials.chain(dissolved).chain([&study.layer.binder]).map(|m| &m.spectrum);
    let spectra: Vec<&Spectrum> = spectra.collect();
    let listed = spectra.iter().flat_map(|spectrum| of_listed(spectrum, [from, to]));
    let gaps = spectra.iter().filter_map(|s| Some(gap_in_words(&s.name(), s.widest_gap_nm([from, to])?)));
    let gap_measured = study.judgement.measured.as_ref().and_then(|measured| {
        let rows: Vec<f64> = measured.rows.iter().map(|row| row[0]).collect();
        Some(gap_in_words(&measured.source, widest_gap_nm(&rows, [from, to])?))
    });
    let cut =
        spectra.iter().flat_map(|s| s.cut_bands().into_iter().map(|band| cut_in_words(&s.name(), band)));
    gaps.chain(gap_measured).chain(listed).chain(cut).collect()
}

/// What is to be known of a listed material: seams between its records, and that its name changed.
fn of_listed(spectrum: &Spectrum, [from, to]: [f64; 2]) -> Vec<String> {
    let Spectrum::Named(named) = spectrum else { return Vec::new() };
    let called = spectrum.name();
    let within = |seam: &[f64; 2]| seam[1] > from && seam[0] < to && seam[0] < seam[1];
    let seams = named.seams_nm().into_iter().filter(within);
    let mut said: Vec<String> = seams
        .map(|[end, start]| {
            format!("{called}: two records are joined between {end:.0} and {start:.0} nm, where n and κ are straight lines")
        })
        .collect();
    if let Some(material) = NamedMaterial::find(&called)
        && material.name != called
    {
        said.push(format!("{called} is listed as {:?} ({})", material.name, material.what));
    }
    said
}

/// What κ at an end of a table leaves open of n.
fn cut_in_words(file: &str, CutBand { wavelength_nm, kappa, n_error }: CutBand) -> String {
    format!(
        "{file}: κ is {kappa:.3} at {wavelength_nm} nm, where the table ends, and may be the flank of a band beyond: \
         n by Kramers–Kronig is known to ± {n_error:.3} there, better away from it; measure κ further until it is small"
    )
}

fn gap_in_words(file: &str, [from, to]: [f64; 2]) -> String {
    let width = to - from;
    format!(
        "{file}: no row between {from} and {to} nm; these {width} nm are interpolated linearly: \
         add rows every 10 or 20 nm if the spectrum bends there"
    )
}
