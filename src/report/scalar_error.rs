//! What the scalar wave gets wrong for inks like a study's, as measured: `scalar_error.csv` is written by
//! `examples/scalar_against_vector.rs` from the sweep `examples/scalar-against-vector.toml`, and kept in `reports/scalar-against-vector`
//! as `differences.csv`.

use crate::appearance::paper::Coupling;
use crate::input::study::{IndexSpectrum, Study};
use serde::Deserialize;

const DATA: &str = include_str!("scalar_error.csv");

/// One measured ink: what the scalar wave gives less what unpolarised light by Maxwell's equations does.
#[derive(Clone, Debug, Deserialize, PartialEq)]
struct MeasuredInk {
    ink: String,
    #[serde(flatten)]
    place: TablePlace,
    delta_e_sky: f64,
    delta_e_sky_standard_error: f64,
    delta_e_print: f64,
    reflectance: f64,
    reflectance_standard_error: f64,
    transmittance: f64,
    transmittance_standard_error: f64,
}

/// What decides whether two inks are alike.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq)]
struct TablePlace {
    /// Over wavelengths and pigments.
    largest_kappa: f64,
    /// Largest |Re η − Re η of the binder| over wavelengths and pigments.
    contrast: f64,
    /// All pigments together.
    volume_fraction: f64,
    /// Mean over the pigments by volume; 0 for pigments without grains.
    diameter_nm: f64,
    thickness_um: f64,
}

impl TablePlace {
    /// The study's ink; none of a layer without pigments.
    fn of(study: &Study) -> Option<TablePlace> {
        let materials: Vec<&IndexSpectrum> = (study.pigments.iter().map(|p| &p.material))
            .chain(study.dissolved.iter().map(|d| &d.material))
            .collect();
        let indices = materials.iter().flat_map(|m| study.wavelengths_nm.iter().zip(&m.index));
        let (mut largest_kappa, mut contrast) = (f64::NEG_INFINITY, 0.0_f64);
        for (nm, eta) in indices {
            let binder = study.layer.binder.spectrum.index(1e-3 * nm).ok()?;
            largest_kappa = largest_kappa.max(eta.im).max(binder.im);
            contrast = contrast.max((eta.re - binder.re).abs());
        }
        let dissolved: f64 = study.dissolved.iter().map(|d| d.volume_fraction).sum();
        let packed: f64 = study.pigments.iter().map(|p| p.grains.volume_fraction).sum();
        let sized: f64 =
            study.pigments.iter().map(|p| p.grains.volume_fraction * p.grains.size.largest_nm()).sum();
        let volume_fraction = dissolved + packed;
        let diameter_nm = sized / volume_fraction;
        let thickness_um = study.layer.thickness_um;
        (volume_fraction > 0.0).then_some(TablePlace {
            largest_kappa,
            contrast,
            volume_fraction,
            diameter_nm,
            thickness_um,
        })
    }

    /// How far two inks are apart in each respect, in units of the most by which they are still alike.
    fn apart(&self, other: &TablePlace) -> [f64; 5] {
        [
            (self.largest_kappa - other.largest_kappa) / 0.1,
            (self.contrast - other.contrast) / 0.05,
            (self.volume_fraction - other.volume_fraction) / 0.1,
            (self.diameter_nm - other.diameter_nm) / 100.0,
            (self.thickness_um / other.thickness_um).log2(),
        ]
    }

    fn distance(&self, other: &TablePlace) -> f64 {
        self.apart(other).iter().map(|x| x * x).sum()
    }

    /// Roundings of the file's four digits never decide.
    fn is_like(&self, other: &TablePlace) -> bool {
        self.apart(other).iter().all(|x| x.abs() <= 1.0 + 1e-3)
    }
}

/// One line for the page of a scalar study: the error measured on the nearest ink, or that none was measured; none for
/// Maxwell's equations.
pub(crate) fn line(study: &Study) -> Option<String> {
    if study.wave.is_vector() {
        return None;
    }
    let with_paper = study.angles.strata > 0;
    Some(nearest(study).map_or_else(|| UNKNOWN.to_owned(), |m| m.in_words(with_paper)))
}

/// One line for a page of many studies: the range of the errors measured on the inks nearest to its scalar ones.
pub(crate) fn line_of_many<'a>(studies: impl Iterator<Item = &'a Study>) -> Option<String> {
    let found: Vec<Option<MeasuredInk>> = studies.filter(|s| !s.wave.is_vector()).map(nearest).collect();
    let known: Vec<&MeasuredInk> = found.iter().flatten().collect();
    match (found.len(), known.len()) {
        (0, _) => None,
        (_, 0) => Some(UNKNOWN.to_owned()),
        (all, some) => {
            let range = |of: fn(&MeasuredInk) -> f64| {
                let values = || known.iter().map(|m| of(m));
                let [low, high] = [values().fold(f64::INFINITY, f64::min), values().fold(0.0, f64::max)];
                format!("{low:.1} to {high:.1}")
            };
            Some(format!(
                "The scalar wave's error: inks like {some} of the {all} scalar variants were solved by Maxwell's equations, too, in the \
                 same packings; the colour of unpolarised light lay ΔE₀₀ {} away under a uniform sky and {} lit at 45° and seen \
                 at 0°. An indication, not a correction; {UNLIKE}.",
                range(|m| m.delta_e_sky),
                range(|m| m.delta_e_print)
            ))
        }
    }
}

const UNKNOWN: &str = "The scalar wave's error: no ink like this one has been solved by Maxwell's equations beside it, so its size is not \
     known here; light.wave = \"unpolarised\" solves them.";
const UNLIKE: &str = "nothing is known of the others";

/// The measured ink that is nearest, where it is alike. All were between air and air, on paper behind a gap, flat.
fn nearest(study: &Study) -> Option<MeasuredInk> {
    let layer = &study.layer;
    let air = layer.index_in == 1.0 && layer.index_out == 1.0 && study.paper.coupling == Coupling::Gap;
    if !air || study.packing.relief.is_some() || !layer.contrast.is_full() {
        return None;
    }
    nearest_to(&TablePlace::of(study)?, &measured())
}

fn nearest_to(place: &TablePlace, all: &[MeasuredInk]) -> Option<MeasuredInk> {
    let found = all.iter().min_by(|a, b| a.place.distance(place).total_cmp(&b.place.distance(place)))?;
    found.place.is_like(place).then(|| found.clone())
}

fn measured() -> Vec<MeasuredInk> {
    csv::Reader::from_reader(DATA.as_bytes()).deserialize().flatten().collect()
}

impl MeasuredInk {
    fn in_words(&self, with_paper: bool) -> String {
        let TablePlace { largest_kappa, volume_fraction, diameter_nm, thickness_um, .. } = self.place;
        let grains = match diameter_nm {
            0.0 => "without grains".to_owned(),
            nm => format!("of {nm:.0} nm"),
        };
        let colour = format!(
            "the colour of unpolarised light lay ΔE₀₀ = {:.1} ± {:.1} away on white paper under a uniform sky and {:.1} lit at 45° and seen at 0°; ",
            self.delta_e_sky, self.delta_e_sky_standard_error, self.delta_e_print
        );
        format!(
            "The scalar wave's error: on the most similar ink that was solved by Maxwell's equations, too ({}, κ up to {largest_kappa:.2}, \
             {:.0} % {grains}, {thickness_um} µm), {}the scalar R of the layer at 0° was off by up to {:+.3} ± {:.3} and T by up to \
             {:+.3} ± {:.3}. An indication, not a correction: other shapes, sizes and angles differ.",
            self.ink,
            100.0 * volume_fraction,
            if with_paper { colour.as_str() } else { "" },
            self.reflectance,
            self.reflectance_standard_error,
            self.transmittance,
            self.transmittance_standard_error
        )
    }
}

#[cfg(test)]
#[path = "scalar_error_tests.rs"]
mod tests;
