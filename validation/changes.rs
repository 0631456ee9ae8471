//! What tonight has changed against the last night, for the top of the report.

use crate::Judged;
use crate::claim::{has_changed, short};
use crate::history::Night;
use serde::Serialize;

/// The last night, and what is different; nothing before there was one.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Changes {
    /// Date and commit of the last night.
    pub since: Option<String>,
    /// One line a difference, the most important first.
    pub lines: Vec<String>,
}

/// Margins that change by less than this factor are the same.
const SAME_MARGIN: f64 = 1.2;
/// Times that change by less than this factor are the same, and so are those below a second.
const SAME_TIME: f64 = 2.0;

/// Tonight against the last night of the same level.
pub fn changes(judged: &[Judged], nights: &[Night]) -> Changes {
    let Some(last) = nights.last() else { return Changes::default() };
    let before: Vec<&Night> = nights.iter().filter(|n| n.date == last.date).collect();
    let find = |id: &str| before.iter().find(|n| n.claim == id);
    let gone = before.iter().filter(|n| judged.iter().all(|j| j.claim.id != n.claim));
    let mut ranked: Vec<(u8, String)> =
        gone.map(|n| (1, format!("{} is no longer judged", n.claim))).collect();
    for j in judged {
        match find(j.claim.id) {
            None => ranked.push((1, format!("{} is new", j.claim.id))),
            Some(night) => ranked.extend(differences(j, night)),
        }
    }
    ranked.sort_by_key(|(rank, _)| *rank);
    let since = Some(format!("{}, commit {}", last.date, last.commit));
    Changes { since, lines: ranked.into_iter().map(|(_, line)| line).collect() }
}

fn differences(judged: &Judged, night: &Night) -> Vec<(u8, String)> {
    let id = judged.claim.id;
    let measured = &judged.measured;
    let margin = measured.margin();
    let seconds = measured.seconds;
    let mut found = Vec::new();
    if measured.holds() != night.holds {
        let words = if measured.holds() { "holds again" } else { "fails; it held the last time" };
        found.push((0, format!("{id} {words}")));
    }
    if has_changed(margin, night.margin, SAME_MARGIN) {
        found.push((2, format!("{id}: margin {} after {}", short(margin), short(night.margin))));
    }
    if seconds.max(night.seconds) > 1.0 && has_changed(seconds, night.seconds, SAME_TIME) {
        found.push((3, format!("{id}: {} s after {} s", short(seconds), short(night.seconds))));
    }
    found
}
