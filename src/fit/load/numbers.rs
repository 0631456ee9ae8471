//! Weighted numbers of samples as data of a fit: densities, whiteness and the like.

use super::FitReading;
use crate::appearance::paper::MirroredSky;
use crate::evaluate::numbers::AskedNumber;
use crate::fit::file::{FitGeometry, MeasuredTable, NUMBER_ERROR};
use crate::input::file::SeenLight;
use crate::input::study::{Study, WantedNumber};

/// Step of the derivatives with respect to the sums of a number.
const STEP: f64 = 1e-5;

/// A weighted number of a sample, as it was measured.
#[derive(Clone, Debug)]
pub struct MeasuredNumber {
    /// What it is made of.
    pub wanted: WantedNumber,
    /// Its value.
    pub value: f64,
    /// Standard error of the value.
    pub error: f64,
}

/// A number at a spectrum, to first order.
pub struct NumberThere {
    /// Its value.
    pub value: f64,
    /// Derivatives with respect to the spectrum's values.
    pub slopes: Vec<f64>,
    /// Standard error due to what the spectrum does between and beyond its wavelengths.
    pub wavelength_error: f64,
}

impl MeasuredNumber {
    /// The number of a spectrum at these wavelengths, nm; NaN where it has none.
    pub fn at(&self, wavelengths_nm: &[f64], spectrum: &[f64]) -> NumberThere {
        let waves = spectrum.len();
        let Some(asked) = AskedNumber::new(&self.wanted, wavelengths_nm) else {
            return NumberThere {
                value: f64::NAN,
                slopes: vec![f64::NAN; waves],
                wavelength_error: f64::NAN,
            };
        };
        let here = asked.sums_of(&[spectrum]);
        let moved = |k: usize, by: f64| {
            let mut sums = here.clone();
            sums[k] += by;
            asked.number(&sums)
        };
        let along: Vec<f64> =
            (0..here.len()).map(|k| (moved(k, STEP) - moved(k, -STEP)) / (2.0 * STEP)).collect();
        let mut slopes = Vec::new();
        for wave in 0..waves {
            let mut unit = vec![0.0; waves];
            unit[wave] = 1.0;
            slopes.push(asked.sums_of(&[&unit]).iter().zip(&along).map(|(sum, slope)| sum * slope).sum());
        }
        let wavelength_error = asked.wavelength_error(&[spectrum], &[], true);
        NumberThere { value: asked.number(&here), slopes, wavelength_error }
    }
}

/// The geometry in which the first number of a sample is defined.
pub(super) fn implied_geometry(table: &MeasuredTable, study: &Study) -> Option<FitGeometry> {
    let first = table.number.first()?;
    let wanted = study.numbers.iter().find(|number| number.name == first.name)?;
    geometries(wanted.of, study).first().copied()
}

/// Geometries whose readings are this spectrum, the usual one first; none where a fit has no such
/// reading.
fn geometries(of: SeenLight, study: &Study) -> Vec<FitGeometry> {
    let with_mirrored = vec![FitGeometry::Sphere, FitGeometry::UniformSky];
    match of {
        SeenLight::LitAt45 => vec![FitGeometry::LitAt45],
        SeenLight::Albedo => with_mirrored,
        SeenLight::NaturalLight if study.output.mirrored_sky == MirroredSky::Included => with_mirrored,
        SeenLight::NaturalLight => vec![FitGeometry::SphereExcluded],
        _ => Vec::new(),
    }
}

impl FitReading<'_> {
    /// The numbers of a sample that is read in a geometry.
    pub(super) fn numbers(
        &mut self,
        field: &str,
        table: &MeasuredTable,
        study: &Study,
        geometry: FitGeometry,
    ) -> Vec<MeasuredNumber> {
        let mut all: Vec<MeasuredNumber> = Vec::new();
        for (i, number) in table.number.iter().enumerate() {
            let field = format!("{field}.number[{i}]");
            let name = format!("{:?}", number.name);
            let usual = "0.01 is usual for a density, 0.3 for a whiteness";
            self.faults.number(&format!("{field}.error"), number.error, NUMBER_ERROR, usual);
            let Some(wanted) = study.numbers.iter().find(|wanted| wanted.name == number.name) else {
                let names: Vec<String> =
                    study.numbers.iter().map(|known| format!("{:?}", known.name)).collect();
                let allowed = match names.as_slice() {
                    [] => "the name of a [[number]] of the base, which has none".to_owned(),
                    names => format!("a number of the base: {}", names.join(", ")),
                };
                let remedy = "name one of these, or add a [[number]] to the base";
                self.faults.add(format!("{field}.name"), name, allowed, remedy);
                continue;
            };
            if all.iter().any(|other| other.wanted.name == number.name) {
                let remedy = "give the mean of both, with its error";
                self.faults.add(format!("{field}.name"), format!("{name} twice"), "each number once", remedy);
            }
            let suitable = geometries(wanted.of, study);
            if wanted.over.is_some() || suitable.is_empty() {
                let allowed = "a number of one spectrum on the card: of = \"lit_at_45\", \"natural_light\" or \"albedo\", without over";
                let remedy = "remove it: a fit compares what an instrument reads of a sample on its card";
                self.faults.add(format!("{field}.name"), wanted.in_words(), allowed, remedy);
            } else if !suitable.contains(&geometry) {
                let found = format!("{} under geometry = {:?}", wanted.in_words(), geometry.key());
                let keys: Vec<String> = suitable.iter().map(|known| format!("{:?}", known.key())).collect();
                let allowed = format!("geometry = {}", keys.join(" or "));
                let remedy = "put what another geometry gave under a [[measured]] of its own";
                self.faults.add(format!("{field}.name"), found, allowed, remedy);
            }
            if !number.value.is_finite() {
                self.faults.add(format!("{field}.value"), number.value, "a finite number", "correct it");
            }
            all.push(MeasuredNumber { wanted: wanted.clone(), value: number.value, error: number.error });
        }
        all
    }
}
