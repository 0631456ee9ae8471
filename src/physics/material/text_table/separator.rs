//! What stands between the cells of a table, and how its numbers are written.

/// Lines that decide on the separator.
const DECIDING_LINES: usize = 400;

/// What is between two cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Separator {
    /// One character; only `,` excludes decimal commas.
    Character(char),
    /// Any number of blanks.
    Blanks,
}

impl Separator {
    /// The cells of a line, without blanks around them.
    pub(super) fn cells(self, line: &str) -> Vec<&str> {
        match self {
            Self::Character(character) => line.split(character).map(str::trim).collect(),
            Self::Blanks => line.split_whitespace().collect(),
        }
    }

    /// The number in a cell, with a decimal comma unless commas separate cells.
    pub fn number(self, cell: &str) -> Option<f64> {
        number(cell, self != Self::Character(','))
    }
}

/// A number with a decimal point, or, where allowed, with a decimal comma; a percent sign or `nm`
/// may follow. Words such as `nan` are numbers here, for the caller to refuse.
pub fn number(cell: &str, decimal_comma: bool) -> Option<f64> {
    let cell = cell.trim();
    let cell = cell.strip_suffix('%').or_else(|| cell.strip_suffix("nm")).unwrap_or(cell).trim_end();
    if decimal_comma && let Some((whole, decimals)) = cell.split_once(',') {
        let is_plain = !decimals.is_empty() && !decimals.contains(',') && !cell.contains('.');
        return is_plain.then(|| format!("{whole}.{decimals}").parse().ok()).flatten();
    }
    cell.parse().ok()
}

/// The separator under which most cells of the first lines are numbers; of equals the first listed.
pub(super) fn guessed(text: &str) -> Separator {
    let mut candidates = ['\t', ';', ','].map(Separator::Character).to_vec();
    candidates.push(Separator::Blanks);
    let lines = || text.lines().filter(|line| !line.trim_start().starts_with('#')).take(DECIDING_LINES);
    let score = |separator: Separator| -> usize {
        lines()
            .map(|line| {
                // a line that has far too many cells is refused later
                let cells = &line[..line.len().min(1 << 16).min(last_boundary(line))];
                let cells = separator.cells(cells);
                if cells.len() < 2 {
                    0
                } else {
                    cells.iter().filter(|cell| separator.number(cell).is_some()).count()
                }
            })
            .sum()
    };
    let mut best = Separator::Character(',');
    let mut most = 0;
    for candidate in candidates {
        let count = score(candidate);
        if count > most {
            (best, most) = (candidate, count);
        }
    }
    if most > 0 {
        return best;
    }
    // nothing but words: what the first line has
    let first = text.lines().find(|line| !line.trim().is_empty()).unwrap_or_default();
    let found = [';', '\t'].into_iter().find(|&character| first.contains(character));
    Separator::Character(found.unwrap_or(','))
}

/// A place near 65 536 bytes at which a text can be cut.
fn last_boundary(line: &str) -> usize {
    (0..=line.len().min(1 << 16)).rev().find(|&at| line.is_char_boundary(at)).unwrap_or(0)
}
