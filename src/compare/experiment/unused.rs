//! Keys of the input files that have no effect on a comparison, for a note to the user.

use super::file::ComparisonFile;
use crate::compare::subject::StudyWritten;
use crate::input::locate::steps;
use crate::input::tree::{Node, parse_toml};
use crate::numerics::files;
use std::path::Path;

/// Study keys that a comparison replaces or does not use.
const OF_STUDIES: [&str; 15] = [
    "paper",
    "resolution",
    "solver",
    "output",
    "colour",
    "compare",
    "realisations",
    "run.realisations",
    "run.target_delta_e",
    "run.target_colour",
    "light.step_nm",
    "light.per_realisation",
    "light.sampling",
    "angles.count",
    "angles.picture_max_deg",
];
/// Study keys that a matrix replaces.
const OF_VARIED_STUDIES: [&str; 3] = ["layer.cell", "layer.period_um", "pigment[0].index"];

impl ComparisonFile {
    /// Keys of the comparison's study that are written and have no effect; none where a file cannot
    /// be read again.
    pub fn unused(&self) -> Vec<String> {
        let varied = if self.matrix.is_some() { &OF_VARIED_STUDIES[..] } else { &[] };
        let of_study = OF_STUDIES.iter().chain(varied);
        match &self.study {
            Some(StudyWritten::File(path)) => {
                written(&table(&self.folder().join(path)), &format!("{}: ", path.display()), of_study)
            }
            Some(StudyWritten::Table(table)) => written(&table.clone().into(), "study.", of_study),
            None => Vec::new(),
        }
    }
}

fn table(path: &Path) -> Node {
    parse_toml(&files::read_text(path, files::STUDY).unwrap_or_default()).map_or(Node::Null, Node::from)
}

/// Those keys of a list that a table has.
fn written<'a>(table: &Node, before: &str, keys: impl Iterator<Item = &'a &'a str>) -> Vec<String> {
    keys.filter(|key| has(table, key)).map(|key| format!("{before}{key}")).collect()
}

fn has(table: &Node, key: &str) -> bool {
    let found = steps(key).try_fold(table, |here, step| match here {
        Node::List(items) => items.get(step.parse::<usize>().ok()?),
        _ => here.get(step),
    });
    found.is_some()
}
