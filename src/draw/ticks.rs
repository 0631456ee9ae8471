//! Ticks of axes: round numbers, and as many as can be read.

use std::ops::Range;

/// Most ticks of a logarithmic axis that runs along the page.
pub(super) const MOST_ALONG: usize = 7;
/// Most ticks of one that runs up the page.
pub(super) const MOST_UP: usize = 12;
/// Slack of comparisons between round numbers.
const ROUNDING: f64 = 1e-9;

/// 1, 2 and 5 times the powers of ten within a range; of long ranges the powers alone, or every second of them, and so on.
pub(super) fn logarithmic(range: &Range<f64>, most: usize) -> Vec<f64> {
    let all = round_numbers(range, &[1.0, 2.0, 5.0]);
    if all.len() <= most {
        return all;
    }
    let powers = round_numbers(range, &[1.0]);
    let every = powers.len().div_ceil(most);
    powers.into_iter().step_by(every).collect()
}

fn round_numbers(range: &Range<f64>, leading: &[f64]) -> Vec<f64> {
    let (from, to) = (range.start.log10().floor() as i32, range.end.log10().ceil() as i32);
    let within = |v: &f64| *v >= range.start * (1.0 - ROUNDING) && *v <= range.end * (1.0 + ROUNDING);
    (from..=to).flat_map(|k| leading.iter().map(move |l| l * 10f64.powi(k))).filter(within).collect()
}

/// A logarithmic range with two ticks at least. It grows to the side where less is added.
pub(super) fn wide(low: f64, high: f64) -> Range<f64> {
    let there = |range: &Range<f64>| logarithmic(range, MOST_ALONG).len();
    let (mut down, mut up) = (low..high, low..high);
    while there(&down) < 2 && there(&up) < 2 {
        down.start /= 1.02;
        up.end *= 1.02;
    }
    if there(&down) < 2 { up } else { down }
}

/// A round number. `span` is the length of a linear axis: next to it, rounding is nothing.
pub(super) fn label(v: f64, log: bool, span: f64) -> String {
    let v = if !log && v.abs() < ROUNDING * span { 0.0 } else { v };
    if v == 0.0 || (0.01..100_000.0).contains(&v.abs()) {
        let text = format!("{v:.3}");
        return text.trim_end_matches('0').trim_end_matches('.').into();
    }
    // Ticks of linear axes differ in their second digits.
    if log { format!("{v:.0e}") } else { format!("{v:.1e}") }
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
            logarithmic(&(1e-12..1.0), MOST_UP),
            &(-12..=0).step_by(2).map(|k| 10f64.powi(k)).collect::<Vec<_>>(),
        );
        near(logarithmic(&(3e-9..2.0), MOST_UP), &(-8..=0).map(|k| 10f64.powi(k)).collect::<Vec<_>>());
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
        assert_eq!(label(1.25e6, false, 1e7), "1.2e6");
    }
}
