//! Warns of measured files whose rows are far apart, which may be intended.

use crate::input::study::{IndexSpectrum, Study};
use crate::material::gaps::widest_gap_nm;

/// One remark for every file with a wide gap within the study's wavelengths.
pub fn bridged(study: &Study) -> Vec<String> {
    let (Some(&from), Some(&to)) = (study.wavelengths_nm.first(), study.wavelengths_nm.last()) else {
        return Vec::new();
    };
    let range = [from, to];
    let spectra = materials(study).map(|material| &material.spectrum);
    let mut remarks: Vec<String> = spectra
        .filter_map(|spectrum| Some(words(&spectrum.name(), spectrum.widest_gap_nm(range)?)))
        .collect();
    remarks.extend(of_measured(study, range));
    remarks.sort();
    remarks.dedup();
    remarks
}

fn materials(study: &Study) -> impl Iterator<Item = &IndexSpectrum> {
    let grains = study.materials();
    let dissolved = study.dissolved.iter().map(|dissolved| &dissolved.material);
    grains.chain(dissolved).chain([&study.layer.binder])
}

fn of_measured(study: &Study, range: [f64; 2]) -> Option<String> {
    let measured = study.judgement.measured.as_ref()?;
    let rows: Vec<f64> = measured.rows.iter().map(|row| row[0]).collect();
    Some(words(&measured.source, widest_gap_nm(&rows, range)?))
}

fn words(file: &str, [from, to]: [f64; 2]) -> String {
    let width = to - from;
    format!(
        "{file}: no row between {from} and {to} nm; these {width} nm are interpolated linearly: \
         add rows every 10 or 20 nm if the spectrum bends there"
    )
}
