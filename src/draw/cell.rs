//! Cells of tables for other programs: free text, and numbers with their errors.

use crate::numerics::estimate::Estimate;
use serde::Serialize;

/// Text for a CSV cell; what a spreadsheet would take for a formula starts with an apostrophe,
/// which marks it as text.
pub fn text(words: &str) -> String {
    let formula = words.starts_with(['=', '+', '-', '@', '\t', '\r']) && words.parse::<f64>().is_err();
    if formula { format!("'{words}") } else { words.to_owned() }
}

/// A text without control characters.
pub fn plain(words: &str) -> String {
    words.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}

/// Escapes text for a line or table cell of Markdown.
pub fn markdown(words: &str) -> String {
    words.replace('|', "\\|").replace('<', "&lt;").replace(['\n', '\r'], " ")
}

/// Value and standard error in a CSV table; empty where unknown.
pub fn numbers(estimate: Option<Estimate>) -> [String; 2] {
    let known = |x: Option<f64>| x.filter(|x| x.is_finite()).map_or_else(String::new, |x| x.to_string());
    [known(estimate.map(|e| e.value)), known(estimate.and_then(|e| e.standard_error))]
}

/// The column of each name, and that of its standard error.
pub fn with_errors<'a>(names: impl IntoIterator<Item = &'a str>) -> impl Iterator<Item = String> {
    names.into_iter().flat_map(|name| [name.to_owned(), format!("{name}_standard_error")])
}

/// A CSV table of a header and rows.
///
/// # Errors
/// Rows of different lengths.
pub fn table(
    header: impl IntoIterator<Item: AsRef<[u8]>>,
    rows: impl IntoIterator<Item: Serialize>,
) -> csv::Result<Vec<u8>> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(header)?;
    rows.into_iter().try_for_each(|row| writer.serialize(row))?;
    writer.into_inner().map_err(|error| error.into_error().into())
}

/// A table of records whose cells carry the names of their columns.
///
/// # Errors
/// What [`csv`] refuses.
pub fn records(rows: impl IntoIterator<Item: AsRef<[(&'static str, String)]>>) -> csv::Result<Vec<u8>> {
    let mut rows = rows.into_iter().peekable();
    let header = rows.peek().map(|row| row.as_ref().iter().map(|cell| cell.0).collect::<Vec<_>>());
    let Some(header) = header else { return Ok(Vec::new()) };
    table(header, rows.map(|row| row.as_ref().iter().map(|cell| text(&cell.1)).collect::<Vec<_>>()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formulas_become_text_and_numbers_stay_numbers() {
        for formula in ["=1+1", "+A1", "-A1", "@SUM(A1)", "\t=1", "=HYPERLINK(\"x\")"] {
            assert_eq!(text(formula), format!("'{formula}"));
        }
        for harmless in ["yellow", "-0.5", "+3e4", "15 %", "a=b", ""] {
            assert_eq!(text(harmless), harmless);
        }
        assert_eq!(markdown("a|b\n<i>"), "a\\|b &lt;i>");
    }
}
