//! What the scalar wave gets wrong for inks like a study's, as measured: `scalar_error.csv` is written by
//! `examples/scalar_against_vector.rs` from the sweep `examples/scalar-against-vector.toml`.

use crate::input::study::{Material, Study};
use serde::Deserialize;

const DATA: &str = include_str!("scalar_error.csv");
/// Index of the binder in the measured inks.
const BINDER: f64 = 1.558;
/// Real parts of indices this far from the binder's are inks like the measured ones.
const INK: f64 = 0.25;

/// One measured ink: what the scalar wave gives less what unpolarised light does.
#[derive(Clone, Debug, Deserialize, PartialEq)]
struct Measured {
    ink: String,
    largest_kappa: f64,
    volume_fraction: f64,
    /// 0 for pigments without grains.
    diameter_nm: f64,
    delta_e_sky: f64,
    delta_e_sky_standard_error: f64,
    delta_e_print: f64,
    reflectance: f64,
    reflectance_standard_error: f64,
    transmittance: f64,
    transmittance_standard_error: f64,
}

/// One line for the pages of scalar studies; none where nothing but the binder is there, or for Maxwell's equations.
pub(crate) fn line(study: &Study) -> Option<String> {
    let materials =
        || study.pigments.iter().map(|p| &p.material).chain(study.dissolved.iter().map(|d| &d.material));
    let indices = || materials().flat_map(|material| &material.index);
    if study.wave.is_vector() || indices().next().is_none() {
        return None;
    }
    if indices().any(|eta| (eta.re - BINDER).abs() > INK) || study.packing.relief.is_some() {
        let line = "How far the scalar wave is off has been measured for inks alone, not for indices or surfaces like these: \
                    light.wave = \"unpolarised\" solves Maxwell's equations.";
        return Some(line.to_owned());
    }
    let nearest = nearest(&measured(), &place(study, materials()))?;
    Some(in_words(&nearest))
}

fn measured() -> Vec<Measured> {
    csv::Reader::from_reader(DATA.as_bytes()).deserialize().flatten().collect()
}

/// Largest κ, volume fraction, and mean diameter in nm by volume.
type Place = [f64; 3];

fn place<'a>(study: &Study, materials: impl Iterator<Item = &'a Material>) -> Place {
    let kappa = materials.flat_map(|material| &material.index).map(|eta| eta.im).fold(0.0, f64::max);
    let dissolved: f64 = study.dissolved.iter().map(|d| d.volume_fraction).sum();
    let packed: f64 = study.pigments.iter().map(|p| p.grains.volume_fraction).sum();
    let sized: f64 =
        study.pigments.iter().map(|p| p.grains.volume_fraction * p.grains.size.largest_nm()).sum();
    [kappa, dissolved + packed, sized / (dissolved + packed)]
}

/// The measured ink that is nearest: a κ of 0.1, a fifth of the volume and 200 nm count alike.
fn nearest(all: &[Measured], [kappa, fraction, diameter]: &Place) -> Option<Measured> {
    let distance = |m: &Measured| {
        let apart = [m.largest_kappa - kappa, m.volume_fraction - fraction, m.diameter_nm - diameter];
        (apart[0] / 0.1).powi(2) + (apart[1] / 0.2).powi(2) + (apart[2] / 200.0).powi(2)
    };
    all.iter().min_by(|a, b| distance(a).total_cmp(&distance(b))).cloned()
}

fn in_words(m: &Measured) -> String {
    let grains = match m.diameter_nm {
        0.0 => "without grains".to_owned(),
        nm => format!("of {nm:.0} nm"),
    };
    format!(
        "Measured on the nearest ink that was solved both ways ({}, κ up to {:.2}, {:.0} % {grains}): the scalar colour lies \
         ΔE₀₀ = {:.1} ± {:.1} from that of unpolarised light by Maxwell's equations under a uniform sky, {:.1} lit at 45° and \
         seen at 0°; R of the layer at 0° is off by up to {:+.3} ± {:.3}, T by up to {:+.3} ± {:.3}.",
        m.ink,
        m.largest_kappa,
        100.0 * m.volume_fraction,
        m.delta_e_sky,
        m.delta_e_sky_standard_error,
        m.delta_e_print,
        m.reflectance,
        m.reflectance_standard_error,
        m.transmittance,
        m.transmittance_standard_error
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_measured_row_is_read_and_found_by_its_own_place() {
        let all = measured();
        assert_eq!(all.len(), DATA.lines().count() - 1);
        assert!(all.len() >= 12, "two inks, three shares, two sizes");
        for m in &all {
            let found = nearest(&all, &[m.largest_kappa, m.volume_fraction, m.diameter_nm]).unwrap();
            assert_eq!(&found, m);
            assert!(in_words(m).contains("ΔE₀₀") && m.delta_e_sky.is_finite());
        }
    }
}
