//! Warns of measured files whose rows are far apart, which may be intended.

use crate::input::study::Study;
use crate::material::columns::widest_gap_nm;
use std::collections::BTreeSet;

/// One remark for every file with a wide gap within the study's wavelengths.
pub fn bridged(study: &Study) -> BTreeSet<String> {
    let (Some(&from), Some(&to)) = (study.wavelengths_nm.first(), study.wavelengths_nm.last()) else {
        return BTreeSet::new();
    };
    let dissolved = study.dissolved.iter().map(|dissolved| &dissolved.material);
    let spectra = study.materials().chain(dissolved).chain([&study.layer.binder]).map(|m| &m.spectrum);
    let of_spectra = spectra.filter_map(|s| Some(words(&s.name(), s.widest_gap_nm([from, to])?)));
    let of_measured = study.judgement.measured.as_ref().and_then(|measured| {
        let rows: Vec<f64> = measured.rows.iter().map(|row| row[0]).collect();
        Some(words(&measured.source, widest_gap_nm(&rows, [from, to])?))
    });
    of_spectra.chain(of_measured).collect()
}

fn words(file: &str, [from, to]: [f64; 2]) -> String {
    let width = to - from;
    format!(
        "{file}: no row between {from} and {to} nm; these {width} nm are interpolated linearly: \
         add rows every 10 or 20 nm if the spectrum bends there"
    )
}
