//! Axis ticks at round numbers, as many as are legible.

use plotters::coord::ranged1d::{BoldPoints, KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};
use plotters::coord::types::RangedCoordf64;
use std::ops::Range;

/// Most ticks of a horizontal axis.
const MOST_ALONG: usize = 7;
/// Most ticks of a vertical axis: linear and logarithmic.
const MOST_UP: [usize; 2] = [8, 12];
/// Slack of comparisons between round numbers.
const ROUNDING: f64 = 1e-9;

/// Round ticks of the horizontal axis, 0, or the vertical one, 1, with their labels.
pub(super) fn round_ticks(range: &Range<f64>, axis: usize, log: bool) -> Vec<(f64, String)> {
    let most = if axis == 0 { MOST_ALONG } else { MOST_UP[usize::from(log)] };
    let places = if log {
        logarithmic(range, most)
    } else {
        RangedCoordf64::from(range.clone()).key_points(BoldPoints(most))
    };
    places.into_iter().map(|v| (v, label(v, log, range.end - range.start))).collect()
}

/// 1, 2 and 5 times the powers of ten within a range; for long ranges the powers alone, or every
/// second, third … of them.
fn logarithmic(range: &Range<f64>, most: usize) -> Vec<f64> {
    let all = round_numbers(range, &[1.0, 2.0, 5.0]);
    if all.len() <= most {
        return all;
    }
    let powers = round_numbers(range, &[1.0]);
    let every = powers.len().div_ceil(most);
    powers.into_iter().step_by(every).collect()
}

fn round_numbers(range: &Range<f64>, leading: &[f64]) -> Vec<f64> {
    let from = range.start.log10().floor() as i32;
    let to = range.end.log10().ceil() as i32;
    let within = range.start * (1.0 - ROUNDING)..=range.end * (1.0 + ROUNDING);
    let all = (from..=to).flat_map(|k| leading.iter().map(move |l| l * 10f64.powi(k)));
    all.filter(|v| within.contains(v)).collect()
}

/// Steps by which a logarithmic range is widened at most: over two decades, which hold two ticks.
const MOST_WIDENED: usize = 240;

/// Widens a logarithmic range until it has at least two ticks, on the side where this adds less.
pub(super) fn wide(low: f64, high: f64) -> Range<f64> {
    let there = |range: &Range<f64>| logarithmic(range, MOST_ALONG).len();
    let mut down = low..high;
    let mut up = low..high;
    for _ in 0..MOST_WIDENED {
        if there(&down) >= 2 || there(&up) >= 2 {
            break;
        }
        down.start /= 1.02;
        up.end *= 1.02;
    }
    if there(&down) < 2 { up } else { down }
}

/// Label of a tick. `span` is the length of the axis: ticks of a linear axis differ by at least a
/// tenth of it, which determines the decimal places.
fn label(v: f64, log: bool, span: f64) -> String {
    if log { round(v) } else { linear(v, span) }
}

/// Label of a round number on a logarithmic axis.
fn round(v: f64) -> String {
    if (0.01..100_000.0).contains(&v) { trimmed(format!("{v:.3}")) } else { format!("{v:.0e}") }
}

/// Smallest and largest decimal exponent of numbers written without a power of ten.
const PLAIN: (i32, i32) = (-5, 5);

fn linear(v: f64, span: f64) -> String {
    if v.abs() < ROUNDING * span {
        return "0".into();
    }
    let last = span.abs().log10().floor() as i32 - 1;
    let first = v.abs().log10().floor() as i32;
    if first < PLAIN.1 && (last >= PLAIN.0 || first >= -2) {
        return trimmed(format!("{v:.*}", (-last).clamp(0, 15) as usize));
    }
    format!("{v:.*e}", (first - last).clamp(0, 15) as usize)
}

/// Strips trailing zeros.
fn trimmed(text: String) -> String {
    let short = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if short == "-0" { "0".into() } else { short.into() }
}

/// Label of a data value: three digits.
fn of_data(v: f64) -> String {
    let digits = (2 - v.abs().log10().floor() as i32).clamp(0, 12) as usize;
    if (1e-4..100_000.0).contains(&v) { trimmed(format!("{v:.digits$}")) } else { format!("{v:.2e}") }
}

/// Least distance between ticks at the data, as a share of the axis.
const APART: f64 = 0.08;

/// Ticks of a logarithmic axis at the data themselves, where these are few and far enough apart to
/// be read.
pub(super) fn at_data(values: impl Iterator<Item = f64>, range: &Range<f64>) -> Option<Vec<(f64, String)>> {
    let mut all: Vec<f64> = values.collect();
    all.sort_by(f64::total_cmp);
    all.dedup_by(|a, b| (*a / *b - 1.0).abs() < ROUNDING);
    let length = (range.end / range.start).ln();
    let apart = all.windows(2).all(|pair| (pair[1] / pair[0]).ln() >= APART * length);
    let named: Vec<(f64, String)> = all.iter().map(|&v| (v, of_data(v))).collect();
    let told = named.windows(2).all(|pair| pair[0].1 != pair[1].1);
    ((2..=MOST_ALONG).contains(&named.len()) && apart && told).then_some(named)
}

/// Axis coordinate of a number.
pub(super) fn on(log: bool, v: f64) -> f64 {
    if log { v.log10() } else { v }
}

/// An axis over numbers or their logarithms, with labelled ticks.
pub(super) struct Scale {
    axis: RangedCoordf64,
    ticks: Vec<(f64, String)>,
}

impl Scale {
    /// The axis over a range of numbers, with ticks at numbers.
    pub fn new(log: bool, range: Range<f64>, ticks: Vec<(f64, String)>) -> Self {
        let ticks = ticks.into_iter().map(|(v, words)| (on(log, v), words)).collect();
        Self { axis: (on(log, range.start)..on(log, range.end)).into(), ticks }
    }
}

impl Ranged for Scale {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        self.axis.map(value, limit)
    }

    fn key_points<H: KeyPointHint>(&self, hint: H) -> Vec<f64> {
        let light = hint.weight().allow_light_points();
        if light { Vec::new() } else { self.ticks.iter().map(|tick| tick.0).collect() }
    }

    fn range(&self) -> Range<f64> {
        self.axis.range()
    }
}

impl ValueFormatter<f64> for Scale {
    fn format_ext(&self, value: &f64) -> String {
        self.ticks.iter().find(|tick| tick.0 == *value).map_or_else(String::new, |tick| tick.1.clone())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_ranges_have_ticks_below_and_above_a_power_of_ten() {
        let near = |found: Vec<f64>, wanted: &[f64]| {
            assert_eq!(found.len(), wanted.len(), "{found:?}");
            found.iter().zip(wanted).for_each(|(a, b)| assert!((a / b - 1.0).abs() < 1e-12, "{found:?}"));
        };
        near(logarithmic(&(0.15..12.0), MOST_ALONG), &[0.2, 0.5, 1.0, 2.0, 5.0, 10.0]);
        near(
            logarithmic(&(1e-12..1.0), MOST_UP[1]),
            &(-12..=0).step_by(2).map(|k| 10f64.powi(k)).collect::<Vec<_>>(),
        );
        near(logarithmic(&(3e-9..2.0), MOST_UP[1]), &(-8..=0).map(|k| 10f64.powi(k)).collect::<Vec<_>>());
    }

    #[test]
    fn a_range_has_two_ticks_at_least() {
        for (low, high) in [(2.1, 4.4), (1.1, 1.2), (0.9, 1.9), (3.0, 30.0)] {
            let range = wide(low, high);
            assert!(range.start <= low && range.end >= high, "{range:?}");
            assert!(logarithmic(&range, MOST_ALONG).len() >= 2, "{range:?}");
            assert!(range.end / range.start < 6.0 * high / low, "{range:?}");
        }
    }

    #[test]
    fn labels_are_short() {
        assert_eq!(label(0.5, true, 1.0), "0.5");
        assert_eq!(label(2e-7, true, 1.0), "2e-7");
        assert_eq!(label(1e-17, false, 1.0), "0");
        assert_eq!(label(2e6, false, 1e7), "2e6");
        assert_eq!(label(-0.05, false, 0.3), "-0.05");
    }

    /// Ticks of linear axes of all lengths, as the drawing library places them. *Planted*: three
    /// decimals write 0.092 twice.
    #[test]
    fn labels_of_an_axis_differ() {
        let mut draws = crate::numerics::Draws::new(3, 0);
        for _ in 0..2000 {
            let span = 10f64.powf(12.0 * draws.uniform() - 6.0);
            let start = (2.0 * draws.uniform() - 1.0) * span * 10f64.powf(5.0 * draws.uniform() - 1.0);
            let axis = RangedCoordf64::from(start..start + span);
            let ticks = axis.key_points(BoldPoints(8));
            let labels: Vec<String> = ticks.iter().map(|v| label(*v, false, span)).collect();
            let read = |text: &String| text.parse::<f64>().unwrap();
            let off = |(v, text): (&f64, &String)| (read(text) - v).abs() < 1e-3 * span;
            assert!(ticks.iter().zip(&labels).all(off), "{ticks:?} {labels:?}");
            assert!(labels.windows(2).all(|pair| pair[0] != pair[1]), "{ticks:?} {labels:?}");
        }
        assert_eq!([0.0915, 0.092, 0.0925].map(|v| label(v, false, 0.0016)), ["0.0915", "0.092", "0.0925"]);
    }

    /// *Planted*: periods of 0.8, 1.2 and 1.6 µm had ticks at 1 and 2.
    #[test]
    fn few_data_have_ticks_of_their_own() {
        let words = |values: &[f64]| {
            let range = values[0] / 1.25..values[values.len() - 1] * 1.25;
            Some(at_data(values.iter().copied(), &range)?.into_iter().map(|t| t.1).collect::<Vec<_>>())
        };
        assert_eq!(words(&[0.8, 1.2, 0.8, 1.2, 1.6]).unwrap(), ["0.8", "1.2", "1.6"]);
        assert_eq!(words(&[1.0, 1.01, 1.6]), None);
        assert_eq!(words(&[1.0]), None);
        assert_eq!(words(&[9472.0, 1.125e6]).unwrap(), ["9472", "1.12e6"]);
    }
}
