//! Illuminant and observer of a colour, and why there is none.

use super::cie;
use thiserror::Error;

/// Why a spectrum has no colour.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum ColourError {
    /// Fewer wavelengths than an integral needs.
    #[error("wavelengths_nm has {count} {}; a colour needs at least 3, spread over 400 to 700 nm", if *count == 1 { "entry" } else { "entries" })]
    TooFewWavelengths {
        /// Wavelengths given.
        count: usize,
    },
    /// An unknown illuminant or observer.
    #[error("{what} = {value:?}: allowed are {allowed}")]
    UnknownName {
        /// Illuminant or observer.
        what: &'static str,
        /// The name found.
        value: String,
        /// The known names.
        allowed: String,
    },
    /// A wavelength outside the observer's table, or not increasing.
    #[error("wavelengths_nm[{index}] = {value}: must increase and lie in {lo} to {hi} nm (CIE tables)")]
    BadWavelength {
        /// Index in the list.
        index: usize,
        /// The wavelength, nm.
        value: f64,
        /// Shortest allowed, nm.
        lo: f64,
        /// Longest allowed, nm.
        hi: f64,
    },
    /// Wavelengths that cover too little of the visible range for a reliable colour.
    #[error(
        "wavelengths_nm from {first} to {last} nm leave white with {channel:.3} of its {name}, at least {least} needed: with less, the colour would be a guess; cover 400 to 700 nm (about 440 to 610 nm is the least), with tables that reach as far"
    )]
    WhiteNotCovered {
        /// First wavelength, nm.
        first: f64,
        /// Last wavelength, nm.
        last: f64,
        /// The tristimulus value that is not covered.
        name: &'static str,
        /// Fraction of it that the wavelengths cover.
        channel: f64,
        /// Smallest fraction allowed.
        least: f64,
    },
    /// A spectrum whose length differs from that of the list of wavelengths.
    #[error("the spectrum has {count} values for {expected} wavelengths")]
    WrongLength {
        /// Values given.
        count: usize,
        /// Values expected.
        expected: usize,
    },
    /// A value that is not finite.
    #[error("spectrum value at {wavelength_nm} nm = {value}: must be finite")]
    NotFinite {
        /// Wavelength of the value, nm.
        wavelength_nm: f64,
        /// The value.
        value: f64,
    },
}

/// Step of the tables of illuminants, nm.
const TABLE_STEP_NM: f64 = 1.0;

/// The illuminant of one power at all wavelengths.
const EVEN: &str = "E";

/// Illuminants without spectral lines.
const SMOOTH: [&str; 4] = ["D65", "D50", "E", "A"];

/// The standard observers by their usual names: CIE 1931, 1964, and both of 2015.
const OBSERVERS: [&str; 4] = ["2", "10", "2015_2", "2015_10"];

/// Rule by which spectra are summed to tristimulus values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum Summation {
    /// Every wavelength where these have one step of at most 10 nm, otherwise every 5 nm, under
    /// lamps every nm; nothing beyond the ends of their range (CIE 15).
    #[default]
    Plain,
    /// Weights as tabulated by ASTM E308: interpolated by the rule of ASTM E2022, and the ends of
    /// the grid stand for what lies beyond them, down to 380 and up to 780 nm.
    E308,
}

/// Illuminant, observer and summation.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Viewing {
    illuminant: String,
    observer: String,
    /// The rule by which spectra are summed.
    pub summation: Summation,
}

impl Default for Viewing {
    fn default() -> Self {
        Self { illuminant: "D65".into(), observer: "2".into(), summation: Summation::Plain }
    }
}

/// Names of illuminants for a file's schema; case does not matter.
#[cfg(feature = "schema")]
pub fn illuminants(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
    offered(cie::illuminant_names())
}

/// Names of observers for a file's schema; a degree sign is accepted.
#[cfg(feature = "schema")]
pub fn observers(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
    offered(&OBSERVERS)
}

/// Schema of a text with suggested values: editors offer them.
#[cfg(feature = "schema")]
fn offered(names: &[&str]) -> schemars::Schema {
    schemars::json_schema!({ "type": "string", "anyOf": [{ "enum": names }, {}] })
}

impl Viewing {
    /// Conditions from an illuminant such as `D50`, `A`, `F11` and an observer `2`, `10`, `2015_2`
    /// or `2015_10`.
    ///
    /// # Errors
    /// Unknown names.
    pub fn new(illuminant: &str, observer: &str, summation: Summation) -> Result<Self, ColourError> {
        let unknown = |what, value: &str, allowed: &[&str]| {
            let value = value.to_owned();
            let allowed = allowed.join(", ");
            ColourError::UnknownName { what, value, allowed }
        };
        let lights = cie::illuminant_names();
        let light = lights.iter().find(|name| name.eq_ignore_ascii_case(illuminant.trim()));
        let light = light.ok_or_else(|| unknown("illuminant", illuminant, lights))?;
        let known = OBSERVERS.iter().find(|name| **name == observer.trim().trim_end_matches('°'));
        let known = known.ok_or_else(|| unknown("observer", observer, &OBSERVERS))?;
        Ok(Self { illuminant: (*light).to_owned(), observer: (*known).to_owned(), summation })
    }

    /// Name of the illuminant, such as `D50`.
    pub fn illuminant(&self) -> &str {
        &self.illuminant
    }

    /// Name of the observer: `2`, `10`, `2015_2` or `2015_10`.
    pub fn observer(&self) -> &str {
        &self.observer
    }

    /// Display name, such as `D50, 2° observer`.
    pub fn name(&self) -> String {
        let rule = if self.summation == Summation::E308 { ", ASTM E308" } else { "" };
        let observer = self.observer.replace("2015_", "2015, ");
        format!("{}, {observer}° observer{rule}", self.illuminant)
    }

    /// Whether the illuminant is a lamp with spectral lines.
    pub fn has_lines(&self) -> bool {
        !SMOOTH.contains(&self.illuminant.as_str())
    }

    /// This observer and summation in light of one power at all wavelengths.
    pub(super) fn in_even_light(&self) -> Self {
        Self { illuminant: EVEN.to_owned(), ..self.clone() }
    }

    /// Relative spectral power of the illuminant at a wavelength from 300 to 780 nm; 0 outside, and
    /// below 380 nm for lamps.
    pub fn power(&self, nm: f64) -> f64 {
        cie::power(&self.illuminant, nm)
    }

    /// Power that stands for the light about `at` nm in a sum over wavelengths of which `from` and
    /// `to` are the neighbours: of a lamp with lines the mean over whole nanometres, with weights
    /// that fall from 1 at `at` to 0 at its neighbours. Factors that are linear between wavelengths
    /// then meet the power of every line once. Of a smooth light it is the power there.
    pub fn mean_power(&self, [from, at, to]: [f64; 3]) -> f64 {
        if !self.has_lines() || (at - from).max(to - at) <= TABLE_STEP_NM {
            return self.power(at);
        }
        let below = |nm: f64| if at > from { (nm - from) / (at - from) } else { 1.0 };
        let above = |nm: f64| if to > at { (to - nm) / (to - at) } else { 1.0 };
        let mut light = 0.0;
        let mut all = 0.0;
        for nm in (from.ceil() as u32..=to.floor() as u32).map(f64::from) {
            let weight = below(nm).min(above(nm));
            light += weight * self.power(nm);
            all += weight;
        }
        if all > 0.0 { light / all } else { self.power(at) }
    }

    /// [`Viewing::mean_power`] at every wavelength of a list, whose rising parts are sums of their
    /// own.
    pub fn mean_powers(&self, wavelengths_nm: &[f64]) -> Vec<f64> {
        let mean = |i: usize| {
            let at = wavelengths_nm[i];
            let before = i.checked_sub(1).map(|k| wavelengths_nm[k]).filter(|nm| *nm < at);
            let behind = wavelengths_nm.get(i + 1).copied().filter(|nm| *nm > at);
            self.mean_power([before.unwrap_or(at), at, behind.unwrap_or(at)])
        };
        (0..wavelengths_nm.len()).map(mean).collect()
    }

    /// S(λ) (x̄, ȳ, z̄)(λ) at a whole number of nm, 380 to 780.
    pub(super) fn row(&self, nm: usize) -> [f64; 3] {
        // names are checked where a `Viewing` is made, and all callers stay inside the tables
        let power = cie::illuminant(&self.illuminant, nm).or_else(|| cie::illuminant("D65", nm));
        let functions = cie::matching_functions(&self.observer, nm);
        let functions = functions.or_else(|| cie::matching_functions("2", nm)).unwrap_or_default();
        let power = power.unwrap_or_default();
        functions.map(|function| power * function)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of a lamp with lines the means over every wavelength of a sum hold all of its light, however
    /// coarse the sum; those of daylight are its power. *Planted*: the power at the wavelength.
    #[test]
    fn means_hold_the_light_of_all_lines() {
        for name in ["F2", "F11", "F12"] {
            let lamp = Viewing::new(name, "2", Summation::Plain).unwrap();
            let all: f64 = (400..=700).map(|nm| lamp.power(f64::from(nm))).sum();
            for step in [5_u32, 12, 20] {
                let nm: Vec<f64> = (400..=700).step_by(step as usize).map(f64::from).collect();
                let inner = lamp.mean_powers(&nm)[1..nm.len() - 1].iter().sum::<f64>() * f64::from(step);
                // the first and the last wavelength have half of the weights on one side
                let half = |from: u32, to: u32| {
                    let weight = |nm: u32| 1.0 - f64::from(nm.abs_diff(from)) / f64::from(step);
                    (from.min(to)..=from.max(to))
                        .map(|nm| weight(nm) * lamp.power(f64::from(nm)))
                        .sum::<f64>()
                };
                let ends = half(400, 400 + step) + half(700, 700 - step);
                // identity: rounding of 300 terms
                assert!(((inner + ends) / all - 1.0).abs() < 1e-12, "{name} {step}: {inner} {ends} {all}");
            }
        }
        let daylight = Viewing::default();
        assert_eq!(daylight.mean_power([400.0, 420.0, 440.0]), daylight.power(420.0));
    }

    #[test]
    fn names_are_found_in_any_case_and_others_are_refused_with_a_list() {
        let viewing = Viewing::new("f11", "10°", Summation::E308).unwrap();
        assert_eq!(viewing.name(), "F11, 10° observer, ASTM E308");
        let message = Viewing::new("D95", "2", Summation::Plain).unwrap_err().to_string();
        assert!(message.contains("\"D95\"") && message.contains("D65, D50"), "{message}");
        assert!(Viewing::new("A", "4", Summation::Plain).is_err());
    }

    /// 32 spectra under D50, D65, A and F11 for both observers against colour-science: its E308
    /// sums, and its sums over 1 nm.
    #[test]
    fn sums_are_those_of_an_independent_library() {
        use crate::appearance::tristimulus::Colorimeter;
        let text = include_str!("../../../validation/data/colour_conditions.json");
        let json: serde_json::Value = serde_json::from_str(text).unwrap();
        let cases = json["cases"].as_array().unwrap();
        for case in cases {
            let list = |key: &str| -> Vec<f64> { serde_json::from_value(case[key].clone()).unwrap() };
            let name = case["illuminant"].as_str().unwrap();
            let observer = case["observer"].as_str().unwrap();
            let step = case["step_nm"].as_f64().unwrap();
            let values = list("values");
            let grid: Vec<f64> = (0..values.len()).map(|i| 400.0 + step * i as f64).collect();
            let viewing = Viewing::new(name, observer, Summation::E308).unwrap();
            let xyz = Colorimeter::under(&grid, &viewing).unwrap().xyz(&values).unwrap();
            for (have, want) in xyz.iter().zip(list("xyz_e308")) {
                // Both interpolate the tables by E2022; they differ in rounding and in the tables'
                // last digits, and in how they spread the narrow lines of F11 between its 5 nm
                // entries: 0.1 of Y = 100 is 0.04 of L*.
                let allowed = if name == "F11" { 0.1 } else { 0.02 };
                assert!((have - want).abs() < allowed, "{name} {observer} {step}: {have} {want}");
            }
            // Plain sums end at 400 and 700 nm, theirs at 360 and 830: 0.5 of Y = 100 in blue.
            // Lines summed at every tenth nm are off by 40.
            let plain = Viewing::new(name, observer, Summation::Plain).unwrap();
            let meter = Colorimeter::under(&grid, &plain).unwrap();
            for (have, want) in meter.white_xyz.iter().zip(list("white_1nm")) {
                assert!((have - want).abs() < 1.5, "white {name} {observer} {step}: {have} {want}");
            }
        }
        assert_eq!(cases.len(), 32);
    }

    /// White stays white on every screen, whatever the light.
    #[test]
    fn white_is_white_under_every_light() {
        use crate::appearance::tristimulus::Colorimeter;
        let grid: Vec<f64> = (0..31).map(|i| 400.0 + 10.0 * f64::from(i)).collect();
        for name in cie::illuminant_names() {
            let viewing = Viewing::new(name, "10", Summation::Plain).unwrap();
            let meter = Colorimeter::under(&grid, &viewing).unwrap();
            assert_eq!(meter.colour(&[1.0; 31]).unwrap().srgb8, [255; 3], "{name}");
            let grey = meter.colour(&[0.5; 31]).unwrap().lab;
            assert!(grey[1].abs() < 1e-9 && grey[2].abs() < 1e-9, "{name}: {grey:?}");
        }
    }
}
