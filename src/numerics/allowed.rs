//! Allowed ranges of numbers, each defined once for checks, error messages and schemas.

#[cfg(feature = "schema")]
use schemars::{Schema, transform::Transform};
use std::fmt;

/// Magnitude below which numbers are shown in scientific notation; see also [`LARGE`].
const SMALL: f64 = 1e-4;
/// Magnitude from which numbers are shown in scientific notation; see also [`SMALL`].
const LARGE: f64 = 1e15;

/// A number for display, without rows of zeros.
pub fn shown(value: f64) -> String {
    let size = value.abs();
    if size > 0.0 && !(SMALL..LARGE).contains(&size) && value.is_finite() {
        format!("{value:e}")
    } else {
        value.to_string()
    }
}

/// Longest number in a message, characters.
const LONGEST: usize = 24;

/// Significant digits of [`brief`] numbers.
const BRIEF: usize = 6;

/// A number with at most six significant digits, as messages write lengths.
pub fn brief(value: f64) -> String {
    let digits = BRIEF - 1;
    shown(format!("{value:.digits$e}").parse().unwrap_or(value))
}

/// Significant digits from which on a number with a decimal point is what binary fractions leave of
/// a shorter one: 0.39999999999999997 of 0.4.
const ARTEFACT: usize = 15;

/// Whether a written number has more digits than people write.
fn is_artefact(number: &str) -> bool {
    let digits = number.chars().filter(char::is_ascii_digit).skip_while(|c| *c == '0').count();
    number.contains('.') && digits >= ARTEFACT
}

/// A text whose very long numbers, such as all digits of 1e300, are written with a power of ten,
/// and numbers such as 0.39999999999999997 with six digits.
pub fn with_short_numbers(text: &str) -> String {
    let is_part = |c: char| c.is_ascii_digit() || c == '.';
    let mut short = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(start) = rest.find(is_part) {
        let (before, from) = rest.split_at(start);
        let (number, after) = from.split_at(from.find(|c| !is_part(c)).unwrap_or(from.len()));
        short += before;
        match number.parse::<f64>() {
            Ok(value) if is_artefact(number) => short += &brief(value),
            Ok(value) if number.len() > LONGEST => short += &format!("{value:e}"),
            _ => short += number,
        }
        rest = after;
    }
    short + rest
}

/// An allowed range of a number with its unit; displays itself in words.
#[derive(Clone, Copy, Debug)]
pub struct Allowed {
    low: f64,
    low_is_open: bool,
    high: f64,
    high_is_open: bool,
    unit: &'static str,
}

impl Allowed {
    /// low ≤ value ≤ high.
    pub const fn between(low: f64, high: f64, unit: &'static str) -> Self {
        Self { low, low_is_open: false, high, high_is_open: false, unit }
    }

    /// low < value ≤ high.
    pub const fn above(low: f64, high: f64, unit: &'static str) -> Self {
        Self { low, low_is_open: true, high, high_is_open: false, unit }
    }

    /// low ≤ value < high.
    pub const fn below(low: f64, high: f64, unit: &'static str) -> Self {
        Self { low, low_is_open: false, high, high_is_open: true, unit }
    }

    /// Attaches the range to the schema of a file's field.
    pub const fn mark(self) -> Self {
        self
    }

    /// Whether a value is allowed; false for NaN and infinities.
    pub fn holds(&self, value: f64) -> bool {
        let above = if self.low_is_open { value > self.low } else { value >= self.low };
        let below = if self.high_is_open { value < self.high } else { value <= self.high };
        value.is_finite() && above && below
    }
}

impl fmt::Display for Allowed {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        if [self.low, self.high] == [f64::MIN, f64::MAX] {
            return write!(f, "any finite number");
        }
        let low = if self.low_is_open { "greater than" } else { "from" };
        let high = match (self.low_is_open, self.high_is_open) {
            (true, false) => "and at most",
            (_, true) => "to below",
            (false, false) => "to",
        };
        let space = if self.unit.is_empty() || self.unit == "°" { "" } else { " " };
        if self.high == f64::MAX {
            return write!(f, "finite and {low} {}{space}{}", self.low, self.unit);
        }
        write!(f, "{low} {} {high} {}{space}{}", self.low, self.high, self.unit)
    }
}

/// Adds the range to a schema, which has no place for units.
#[cfg(feature = "schema")]
impl Transform for Allowed {
    fn transform(&mut self, schema: &mut Schema) {
        let low = if self.low_is_open { "exclusiveMinimum" } else { "minimum" };
        let high = if self.high_is_open { "exclusiveMaximum" } else { "maximum" };
        schema.insert(low.into(), self.low.into());
        if self.high < f64::MAX {
            schema.insert(high.into(), self.high.into());
        }
    }
}

/// An allowed range of a whole number, both ends included.
#[derive(Clone, Copy, Debug)]
pub struct Whole {
    /// Smallest allowed value.
    pub low: usize,
    /// Largest allowed value.
    pub high: usize,
}

impl Whole {
    /// low ≤ value ≤ high.
    pub const fn between(low: usize, high: usize) -> Self {
        Self { low, high }
    }

    /// Attaches the range to the schema of a file's field.
    pub const fn mark(self) -> Self {
        self
    }

    /// Whether a value is allowed.
    pub fn holds(&self, value: usize) -> bool {
        (self.low..=self.high).contains(&value)
    }
}

impl fmt::Display for Whole {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "whole numbers from {} to {}", self.low, self.high)
    }
}

#[cfg(feature = "schema")]
impl Transform for Whole {
    fn transform(&mut self, schema: &mut Schema) {
        schema.insert("minimum".into(), self.low.into());
        schema.insert("maximum".into(), self.high.into());
    }
}

/// A list of 1 to `most` entries, each in an allowed range.
#[derive(Clone, Copy, Debug)]
pub struct Each<T> {
    /// Allowed range of each entry.
    pub entry: T,
    /// Largest number of entries.
    pub most: usize,
}

impl<T: Copy> Each<T> {
    /// Attaches the range to the schema of a file's field.
    pub const fn mark(self) -> Self {
        self
    }
}

#[cfg(feature = "schema")]
impl<T: Transform> Transform for Each<T> {
    fn transform(&mut self, schema: &mut Schema) {
        schema.insert("minItems".into(), 1.into());
        schema.insert("maxItems".into(), self.most.into());
        if let Some(items) = schema.get_mut("items").and_then(|items| items.try_into().ok()) {
            self.entry.transform(items);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{brief, shown, with_short_numbers};

    #[test]
    fn very_small_and_very_large_numbers_have_a_power_of_ten() {
        let all = [1e-300, -2.5e-5, 1e-4, 0.3, 0.0, 700.0, 1e300, f64::INFINITY];
        assert_eq!(all.map(shown), ["1e-300", "-2.5e-5", "0.0001", "0.3", "0", "700", "1e300", "inf"]);
    }

    /// *Planted*: numbers cut at six digits although they were written with seven.
    #[test]
    fn rounding_of_binary_fractions_is_not_shown() {
        assert_eq!(with_short_numbers("slabs of 0.39999999999999997 µm"), "slabs of 0.4 µm");
        assert_eq!(
            with_short_numbers("0.6666666666666666, seed 18446744073709551"),
            "0.666667, seed 18446744073709551"
        );
        assert_eq!(with_short_numbers("550.1234567 nm, 1.2345678901234567e-7"), "550.1234567 nm, 1.23457e-7");
        assert_eq!(
            [0.1 + 0.2, 2.0 / 3.0, 1.0, 0.0, -1e-7 / 3.0].map(brief),
            ["0.3", "0.666667", "1", "0", "-3.33333e-8"]
        );
    }
}
