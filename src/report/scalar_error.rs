//! Error of the scalar wave for inks similar to a study's, as measured: `scalar_error.csv` is
//! written by `examples/scalar_against_vector.rs` from the sweep
//! `examples/scalar-against-vector.toml`; `reports/scalar-against-vector/differences.csv` is a
//! copy.

use crate::appearance::paper::Coupling;
use crate::input::study::{IndexSpectrum, Study};
use serde::Deserialize;

const DATA: &str = include_str!("scalar_error.csv");

/// One measured ink: results of the scalar wave minus those of unpolarised light by Maxwell's
/// equations.
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

/// Properties by which the similarity of two inks is judged.
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
    /// Properties of a study's ink; `None` for a layer without pigments.
    fn of(study: &Study) -> Option<TablePlace> {
        let materials: Vec<&IndexSpectrum> =
            study.materials().chain(study.dissolved.iter().map(|d| &d.material)).collect();
        let mut largest_kappa = f64::NEG_INFINITY;
        let mut contrast = 0.0_f64;
        for (nm, eta) in materials.iter().flat_map(|m| study.wavelengths_nm.iter().zip(&m.index)) {
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
        let place = TablePlace { largest_kappa, contrast, volume_fraction, diameter_nm, thickness_um };
        (volume_fraction > 0.0).then_some(place)
    }

    /// Differences of two inks in each property, in units of the largest at which they still count
    /// as similar.
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

    /// Rounding to the file's four digits must not decide.
    fn is_like(&self, other: &TablePlace) -> bool {
        self.apart(other).iter().all(|x| x.abs() <= 1.0 + 1e-3)
    }
}

/// Note for the page of a scalar study: the error measured on the most similar ink, or that none
/// was measured; `None` for Maxwell's equations.
pub(crate) fn line(study: &Study) -> Option<String> {
    if study.wave.is_vector() {
        return None;
    }
    Some(nearest(study).map_or_else(|| UNKNOWN.to_owned(), |m| m.in_words(study.angles.strata > 0)))
}

/// Note for a page of many studies: the range of the errors measured on the inks most similar to
/// the scalar ones.
pub(crate) fn line_of_many<'a>(studies: impl Iterator<Item = &'a Study>) -> Option<String> {
    let similar: Vec<Option<MeasuredInk>> = studies.filter(|s| !s.wave.is_vector()).map(nearest).collect();
    let known: Vec<&MeasuredInk> = similar.iter().flatten().collect();
    match (similar.len(), known.len()) {
        (0, _) => None,
        (_, 0) => Some(UNKNOWN.to_owned()),
        (all, some) => {
            let range = |error: fn(&MeasuredInk) -> f64| {
                let values = || known.iter().map(|m| error(m));
                let low = values().fold(f64::INFINITY, f64::min);
                let high = values().fold(0.0, f64::max);
                format!("{low:.1} to {high:.1}")
            };
            Some(format!(
                "Error of the scalar wave: inks similar to {some} of the {all} scalar variants were also solved with Maxwell's equations, \
                 in the same packings; the colour in unpolarised light differed by ΔE₀₀ {} under a uniform sky and by {} lit at \
                 45° and seen at 0°. An indication, not a correction; for the others it is unknown.",
                range(|m| m.delta_e_sky),
                range(|m| m.delta_e_print)
            ))
        }
    }
}

const UNKNOWN: &str = "Error of the scalar wave: unknown here, as no similar ink has been solved with Maxwell's equations for comparison; \
     light.wave = \"unpolarised\" solves them.";

/// The most similar measured ink, if it is similar enough. All were measured flat, in air, on paper
/// behind an air gap.
fn nearest(study: &Study) -> Option<MeasuredInk> {
    let layer = &study.layer;
    let air = layer.index_in == 1.0 && layer.index_out == 1.0 && study.paper.coupling == Coupling::Gap;
    if !air || !study.stack.is_empty() || study.packing.relief.is_some() || !layer.contrast.is_full() {
        return None;
    }
    nearest_to(&TablePlace::of(study)?, &measured())
}

fn nearest_to(place: &TablePlace, all: &[MeasuredInk]) -> Option<MeasuredInk> {
    let nearest = all.iter().min_by(|a, b| a.place.distance(place).total_cmp(&b.place.distance(place)))?;
    nearest.place.is_like(place).then(|| nearest.clone())
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
            "the colour in unpolarised light differed by ΔE₀₀ = {:.1} ± {:.1} on white paper under a uniform sky and by {:.1} lit at 45° and seen at 0°; ",
            self.delta_e_sky, self.delta_e_sky_standard_error, self.delta_e_print
        );
        format!(
            "Error of the scalar wave: for the most similar ink that was also solved with Maxwell's equations ({}, κ up to \
             {largest_kappa:.2}, {:.0} % {grains}, {thickness_um} µm), {}the scalar R of the layer at 0° was off by up to {:+.3} ± {:.3} and T by up to \
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
