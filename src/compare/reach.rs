//! The cost of an accuracy: the cheapest row of each strategy and program that reaches it.

use super::row::{Row, dash, grouped};

/// Amplitude errors whose cost is tabulated.
pub(super) const TARGETS: [f64; 3] = [1e-2, 1e-3, 1e-4];

/// One line for each case and each strategy or program on it: case, name, the cost of every target,
/// the smallest error, and why there is no result at all.
pub(super) fn table(rows: &[Row]) -> Vec<Vec<String>> {
    let groups = grouped(rows, |row| (row.case_name(), row.strategy.clone()));
    groups.into_iter().map(|((case, strategy), group)| line([case, strategy], &group)).collect()
}

fn line(before: [String; 2], group: &[&Row]) -> Vec<String> {
    let costs = TARGETS.map(|target| dash(cheapest(group, target).map(cost)));
    let errors = group.iter().filter_map(|row| row.result.as_ref().ok().copied());
    let least = errors.reduce(f64::min).map(|error| format!("{error:.1e}"));
    let reason = if least.is_some() { String::new() } else { group[0].outcome() };
    before.into_iter().chain(costs).chain([dash(least), reason]).collect()
}

/// The row of least processor time (wall time where that is not known) within an error.
fn cheapest<'a>(group: &[&'a Row], target: f64) -> Option<&'a Row> {
    let within = group.iter().filter(|row| row.result.as_ref().is_ok_and(|error| *error <= target));
    within.copied().min_by(|a, b| seconds(a).total_cmp(&seconds(b)))
}

fn seconds(row: &Row) -> f64 {
    row.processor_seconds.or(row.seconds).unwrap_or(f64::INFINITY)
}

fn cost(row: &Row) -> String {
    let (seconds, megabytes) = (seconds(row), row.bytes as f64 / 1e6);
    let places = (2 - seconds.max(1e-4).log10().ceil() as i32).max(0) as usize;
    format!("{seconds:.places$}\u{a0}s, {megabytes:.0}\u{a0}MB")
}
