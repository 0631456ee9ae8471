//! Weighted numbers that a design is to reach: ranges of numbers of the base.

use super::file::NumberTargetTable;
use crate::appearance::weighted::NumberTransform;
use crate::input::fault::{Fault, Faults};
use crate::input::study::{Study, WantedNumber};
use crate::numerics::estimate::Estimate;
use serde::Serialize;

/// Largest mean of a spectrum relative to a perfect white that a wish may ask for: brightened
/// papers exceed 1.
const MOST_MEAN: f64 = 2.0;
/// Share of a reciprocal that counts as much as a ΔE₀₀ of 1.
const OF_RECIPROCAL: f64 = 0.02;

/// A weighted number of the base and the range that it is to have.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct NumberWish {
    /// Its name.
    pub name: String,
    /// Least value.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at_least: Option<f64>,
    /// Largest value.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at_most: Option<f64>,
    /// What it is made of.
    #[serde(skip)]
    pub wanted: WantedNumber,
}

/// A wanted number as a run gives it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ReachedNumber {
    /// Its name.
    pub name: String,
    /// The number with its standard error.
    #[serde(flatten)]
    pub estimate: Estimate,
    /// What the surfaces answered; none for variants of the design.
    pub predicted: Option<f64>,
}

impl NumberWish {
    /// Whether a value is in the range.
    pub fn holds(&self, value: f64) -> bool {
        self.at_least.is_none_or(|least| value >= least) && self.at_most.is_none_or(|most| value <= most)
    }

    /// How far a value is outside the range, in the number's unit.
    pub fn distance(&self, value: f64) -> f64 {
        let below = self.at_least.map_or(0.0, |least| (least - value).max(0.0));
        let above = self.at_most.map_or(0.0, |most| (value - most).max(0.0));
        below.max(above)
    }

    /// Its distance from the range in steps that count as much as a ΔE₀₀ of 1.
    pub fn lack(&self, value: f64) -> f64 {
        self.distance(value) / self.step()
    }

    /// How far a value is within the range, in the same steps; 0 outside.
    pub fn depth(&self, value: f64) -> f64 {
        let above = self.at_least.map_or(f64::INFINITY, |least| value - least);
        let below = self.at_most.map_or(f64::INFINITY, |most| most - value);
        above.min(below).max(0.0) / self.step()
    }

    /// The range less a margin at each end; its middle where nothing is left.
    pub fn narrowed(&self, by: f64) -> Self {
        let by = match (self.at_least, self.at_most) {
            (Some(least), Some(most)) => by.min(0.5 * (most - least)),
            _ => by,
        };
        let (at_least, at_most) = (self.at_least.map(|least| least + by), self.at_most.map(|most| most - by));
        Self { at_least, at_most, ..self.clone() }
    }

    /// What counts as much as a ΔE₀₀ of 1: a hundredth of a mean or a density, a unit of whiteness,
    /// tint or yellowness, a share of a reciprocal.
    fn step(&self) -> f64 {
        match self.wanted.transform {
            NumberTransform::Mean | NumberTransform::Density => 1e-2,
            NumberTransform::Reciprocal => {
                let wanted = self.at_least.or(self.at_most).unwrap_or(1.0);
                OF_RECIPROCAL * wanted.abs().max(1.0)
            }
            NumberTransform::Whiteness | NumberTransform::Tint | NumberTransform::Yellowness => 1.0,
        }
    }

    /// The range in words.
    pub fn in_words(&self) -> String {
        match (self.at_least, self.at_most) {
            (Some(least), Some(most)) => format!("{least} to {most}"),
            (Some(least), None) => format!("at least {least}"),
            (None, Some(most)) => format!("at most {most}"),
            (None, None) => "any".to_owned(),
        }
    }
}

/// Decimals that tell apart what counts as a ΔE₀₀ of a tenth.
pub fn decimals(wish: &NumberWish) -> usize {
    match wish.wanted.transform {
        NumberTransform::Mean | NumberTransform::Density => 3,
        _ => 2,
    }
}

/// The wishes of a file, of the numbers of a checked study.
///
/// # Errors
/// Names that the study has no number of, ranges that are none or that no number has.
pub(super) fn wishes(tables: &[NumberTargetTable], study: &Study) -> Result<Vec<NumberWish>, Vec<Fault>> {
    let mut faults = Faults::default();
    let mut all = Vec::new();
    for (i, table) in tables.iter().enumerate() {
        let field = format!("target.number[{i}]");
        let Some(wanted) = study.numbers.iter().find(|number| number.name == table.name) else {
            let names: Vec<String> =
                study.numbers.iter().map(|number| format!("{:?}", number.name)).collect();
            let allowed = match names.as_slice() {
                [] => "the name of a [[number]] of the base, which has none".to_owned(),
                names => format!("a number of the base: {}", names.join(", ")),
            };
            let remedy = "name one of these, or add a [[base.number]] ([[number]] in the file of the base)";
            faults.add(format!("{field}.name"), format!("{:?}", table.name), allowed, remedy);
            continue;
        };
        let NumberTargetTable { name, at_least, at_most } = table.clone();
        all.push(NumberWish { name, at_least, at_most, wanted: wanted.clone() });
    }
    if faults.0.is_empty() { Ok(all) } else { Err(faults.0) }
}

/// Checks what the ranges say by themselves.
pub(super) fn check_ranges(tables: &[NumberTargetTable], faults: &mut Faults) {
    for (i, table) in tables.iter().enumerate() {
        let field = format!("target.number[{i}]");
        if tables[..i].iter().any(|other| other.name == table.name) {
            let remedy = "write at_least and at_most in one [[target.number]]";
            faults.add(
                format!("{field}.name"),
                format!("{:?} twice", table.name),
                "each number once",
                remedy,
            );
        }
        let bounds = [("at_least", table.at_least), ("at_most", table.at_most)];
        for (key, bound) in bounds {
            if let Some(bound) = bound.filter(|bound| !bound.is_finite()) {
                faults.add(format!("{field}.{key}"), bound, "a finite number", "leave it out for no bound");
            }
        }
        let found = match (table.at_least, table.at_most) {
            (None, None) => "neither".to_owned(),
            (Some(least), Some(most)) if least > most => format!("{least} to {most}"),
            _ => continue,
        };
        let allowed = "at_least, at_most, or both with at_least up to at_most";
        faults.add(field, found, allowed, "write at_least = 0.6 for no less than 0.6");
    }
}

/// Checks that the ranges can be reached by numbers of their kind.
pub(super) fn check_kinds(wishes: &[NumberWish], faults: &mut Faults) {
    for (i, wish) in wishes.iter().enumerate() {
        let [least, most] = match wish.wanted.transform {
            NumberTransform::Mean if wish.wanted.over.is_none() => [0.0, MOST_MEAN],
            NumberTransform::Mean => [0.0, f64::INFINITY],
            NumberTransform::Reciprocal => [0.0, f64::INFINITY],
            _ => [f64::NEG_INFINITY, f64::INFINITY],
        };
        let wrong = match (wish.at_least, wish.at_most) {
            (Some(bound), _) if bound > most => Some(("at_least", bound)),
            (_, Some(bound)) if bound < least => Some(("at_most", bound)),
            _ => None,
        };
        if let Some((key, bound)) = wrong {
            let allowed = format!("shares of one for {}: 0 to 1", wish.wanted.in_words());
            let remedy = "write 0.6 for 60 %";
            faults.add(format!("target.number[{i}].{key}"), bound, allowed, remedy);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::file::SeenLight;
    use crate::input::study::WantedWeights;

    fn wish(at_least: Option<f64>, at_most: Option<f64>, transform: NumberTransform) -> NumberWish {
        let wanted = WantedNumber {
            name: "number".into(),
            weights: WantedWeights::Named("solar_g173".into()),
            range_nm: [400.0, 700.0],
            of: SeenLight::Albedo,
            over: None,
            transform,
        };
        NumberWish { name: "number".into(), at_least, at_most, wanted }
    }

    /// A hundredth of a mean, a unit of whiteness and 2 % of a reciprocal count alike. *Planted*:
    /// what is within the range counted as lacking.
    #[test]
    fn what_lacks_is_the_distance_from_the_range_in_steps() {
        let range = wish(Some(0.6), Some(0.7), NumberTransform::Mean);
        for (value, lack, depth) in [(0.57, 3.0, 0.0), (0.6, 0.0, 0.0), (0.66, 0.0, 4.0), (0.72, 2.0, 0.0)] {
            assert!((range.lack(value) - lack).abs() < 1e-9, "{value}: {}", range.lack(value));
            assert!((range.depth(value) - depth).abs() < 1e-9, "{value}: {}", range.depth(value));
            assert_eq!(range.holds(value), lack == 0.0);
        }
        let white = wish(Some(80.0), None, NumberTransform::Whiteness);
        assert!((white.lack(77.5) - 2.5).abs() < 1e-9 && white.holds(1e3));
        let protection = wish(Some(50.0), None, NumberTransform::Reciprocal);
        assert!((protection.lack(48.0) - 2.0).abs() < 1e-9);
    }

    /// Narrow ranges end in their middle, not beyond it. *Planted*: without that bound.
    #[test]
    fn a_range_is_narrowed_to_its_middle_at_most() {
        let range = wish(Some(0.6), Some(0.7), NumberTransform::Mean);
        let some = range.narrowed(0.02);
        assert!(
            (some.at_least.unwrap() - 0.62).abs() < 1e-12 && (some.at_most.unwrap() - 0.68).abs() < 1e-12
        );
        let all = range.narrowed(1.0);
        assert!((all.at_least.unwrap() - 0.65).abs() < 1e-12 && (all.at_most.unwrap() - 0.65).abs() < 1e-12);
        assert_eq!(wish(Some(0.6), None, NumberTransform::Mean).narrowed(0.1).at_most, None);
    }
}
