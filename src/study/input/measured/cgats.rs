//! CGATS.17 and its relatives (ISO 28178, IT8.7, CTI3 and SPECT of Argyll, LGOROWLENGTH of
//! ProfileMaker): keywords, fields between `BEGIN_DATA_FORMAT` and `END_DATA_FORMAT`, sets of
//! values between `BEGIN_DATA` and `END_DATA`, and all of that again for a further table.

mod declared;

use super::fields::FieldTable;
use super::sample::{MeasuredFile, Written};
use declared::declared;

/// Most values in a file: 10 000 samples of 400 bands.
const MOST_VALUES: usize = 4_000_000;

/// Whether a text has the structure of CGATS, whatever its first line.
pub fn is_cgats(text: &str) -> bool {
    text.lines().any(|line| begins(line, "BEGIN_DATA_FORMAT") || begins(line, "BEGIN_DATA"))
}

/// Whether the first word of a line is this keyword.
fn begins(line: &str, keyword: &str) -> bool {
    line.split_whitespace().next().is_some_and(|word| word.eq_ignore_ascii_case(keyword))
}

/// The words of a line up to a remark; between quotes blanks and `#` belong to a word. A quote that
/// does not end ends with its line.
fn words_of(line: &str) -> Vec<String> {
    let mut words = Vec::new();
    let mut rest = line.trim_start();
    while let Some(first) = rest.chars().next() {
        if first == '#' {
            break;
        }
        if first == '"' {
            let (word, after) = quoted(&rest[1..]);
            words.push(word);
            rest = after.trim_start();
        } else {
            let end = rest.find(char::is_whitespace).unwrap_or(rest.len());
            words.push(rest[..end].to_owned());
            rest = rest[end..].trim_start();
        }
    }
    words
}

/// The text up to the closing quote, and what follows; a doubled quote stands for one.
fn quoted(text: &str) -> (String, &str) {
    let mut word = String::new();
    let mut rest = text;
    while let Some(at) = rest.find('"') {
        word.push_str(&rest[..at]);
        rest = &rest[at + 1..];
        match rest.strip_prefix('"') {
            Some(after) => {
                word.push('"');
                rest = after;
            }
            None => return (word, rest),
        }
    }
    word.push_str(rest);
    (word, "")
}

/// The cells of a line between tabs, where they are this many: cells may be empty, and names hold
/// blanks without quotes.
fn between_tabs(line: &str, width: usize) -> Option<Vec<String>> {
    let line = line.trim_end_matches(['\r', '\n']);
    let mut cells: Vec<String> =
        line.split('\t').map(|cell| cell.trim().trim_matches('"').to_owned()).collect();
    while cells.len() > width && cells.last().is_some_and(String::is_empty) {
        cells.pop();
    }
    (cells.len() == width && !line.trim_start().starts_with('#')).then_some(cells)
}

/// Part of a file that a line belongs to.
#[derive(PartialEq)]
enum Section {
    Header,
    Format,
    Data,
}

/// A table of a file while it is read.
#[derive(Default)]
struct CgatsTable {
    /// Keywords with their values, those of the tables before included.
    header: Vec<(String, String)>,
    fields: Vec<String>,
    lines: Vec<Vec<Written>>,
    /// Line of its `BEGIN_DATA`.
    line: usize,
}

/// All samples of a file.
///
/// # Errors
/// No fields or data, a file that ends within them, more values than a file of measurements has, or
/// sets whose values do not fit the fields in a way that leaves open which value is whose.
pub fn read(text: &str) -> Result<MeasuredFile, String> {
    let mut file = MeasuredFile::default();
    let mut table = CgatsTable::default();
    let mut section = Section::Header;
    let mut tables = 0;
    let mut count = 0;
    for (i, line) in text.lines().enumerate() {
        let mut words = words_of(line);
        if section == Section::Data && words.len() != table.fields.len() {
            words = between_tabs(line, table.fields.len()).unwrap_or(words);
        }
        let Some(first) = words.first() else { continue };
        let keyword = first.to_uppercase();
        match (keyword.as_str(), &section) {
            ("BEGIN_DATA_FORMAT", Section::Header) => {
                section = Section::Format;
                table.fields = words.split_off(1);
                if let Some(end) =
                    table.fields.iter().position(|word| word.eq_ignore_ascii_case("END_DATA_FORMAT"))
                {
                    table.fields.truncate(end);
                    section = Section::Header;
                }
            }
            ("END_DATA_FORMAT", Section::Format) => section = Section::Header,
            (_, Section::Format) => {
                let end = words.iter().position(|word| word.eq_ignore_ascii_case("END_DATA_FORMAT"));
                table.fields.extend(words.drain(..end.unwrap_or(words.len())));
                if end.is_some() {
                    section = Section::Header;
                }
            }
            ("BEGIN_DATA", Section::Header) => {
                section = Section::Data;
                table.line = i + 1;
            }
            ("END_DATA", Section::Data) => {
                take_table(&table, &mut file)?;
                tables += 1;
                section = Section::Header;
                table = CgatsTable { header: table.header, ..CgatsTable::default() };
            }
            (_, Section::Data) => {
                count += words.len();
                if count > MOST_VALUES {
                    return Err(format!("line {}: more than {MOST_VALUES} values", i + 1));
                }
                table.lines.push(words.into_iter().map(|text| Written { text, line: i + 1 }).collect());
            }
            (_, Section::Header) => {
                let value = words.split_off(1).join(" ");
                // of one keyword in two tables the later counts
                let adds =
                    ["KEYWORD", "WEIGHTING_FUNCTION", "COMPUTATIONAL_PARAMETER"].contains(&keyword.as_str());
                match table.header.iter_mut().find(|(known, _)| *known == keyword && !adds) {
                    Some((_, known)) => *known = value,
                    None => table.header.push((keyword, value)),
                }
            }
        }
    }
    match section {
        Section::Header if tables > 0 => Ok(file),
        Section::Header if table.fields.is_empty() => Err("no BEGIN_DATA_FORMAT".into()),
        Section::Header => Err("no BEGIN_DATA".into()),
        Section::Format => Err("it ends before END_DATA_FORMAT: the file is cut short".into()),
        Section::Data => {
            Err(format!("it ends before the END_DATA of line {}: the file is cut short", table.line))
        }
    }
}

/// Adds the samples of a table, if it holds spectra or colours.
fn take_table(table: &CgatsTable, into: &mut MeasuredFile) -> Result<(), String> {
    if table.fields.is_empty() {
        return Err(format!("line {}: no BEGIN_DATA_FORMAT before BEGIN_DATA", table.line));
    }
    let fields = FieldTable::new(&table.fields);
    if !fields.is_measured() {
        return Ok(());
    }
    let sets = sets(table, fields.names_end())?;
    let stated = table.header.iter().find(|(keyword, _)| keyword == "NUMBER_OF_SETS");
    if let Some(stated) = stated.and_then(|(_, value)| value.trim().parse::<usize>().ok())
        && stated != sets.len()
    {
        into.remarks.push(format!("NUMBER_OF_SETS is {stated}, and {} are there", sets.len()));
    }
    let declared = declared(&table.header);
    for set in &sets {
        fields.take(set, &declared, into);
    }
    Ok(())
}

/// The sets of a table: one a line, or several lines one set, or one line several. A line with
/// another number of values in a table of one set a line is kept with cells that hold no number:
/// a fault only where they are needed; the first `names_end` values are names.
fn sets(table: &CgatsTable, names_end: usize) -> Result<Vec<Vec<Written>>, String> {
    let width = table.fields.len();
    if let Some(sets) = regrouped(&table.lines, width) {
        return Ok(sets);
    }
    let fitting = table.lines.iter().filter(|line| line.len() == width).count();
    if 2 * fitting < table.lines.len() {
        let values: usize = table.lines.iter().map(Vec::len).sum();
        let first = table.lines.iter().find(|line| line.len() != width);
        let (count, line) = first.map_or((0, table.line), |line| (line.len(), line[0].line));
        return Err(format!(
            "{values} values from line {} on do not make whole sets of {width} fields: line {line} has {count} values \
             under {width} fields",
            table.line + 1
        ));
    }
    let padded = |line: &Vec<Written>| {
        let mut cells = line.clone();
        if cells.len() != width {
            // which value is whose is unknown: names before the values stay
            let number = line[0].line;
            let count = cells.len();
            cells.truncate(names_end);
            let text = format!("{count} values under {width} fields");
            cells.resize(width, Written { text, line: number });
        }
        cells
    };
    Ok(table.lines.iter().map(padded).collect())
}

/// Sets of this width from lines that each begin or continue one; nothing if one ends elsewhere
/// than a line.
fn regrouped(lines: &[Vec<Written>], width: usize) -> Option<Vec<Vec<Written>>> {
    let mut sets = Vec::new();
    let mut open: Vec<Written> = Vec::new();
    for line in lines {
        open.extend(line.iter().cloned());
        if open.len().is_multiple_of(width) {
            let mut cells = std::mem::take(&mut open).into_iter().peekable();
            while cells.peek().is_some() {
                sets.push(cells.by_ref().take(width).collect());
            }
        } else if open.len() > width {
            return None;
        }
    }
    open.is_empty().then_some(sets)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::measured::sample::SampleContent;
    use crate::input::measured::words::{self, MeasuredKind};

    fn values(file: &MeasuredFile) -> Vec<Vec<f64>> {
        let of = |content: &SampleContent| match content {
            SampleContent::Spectrum(rows) => rows.iter().filter_map(|row| row.value.value()).collect(),
            SampleContent::Lab(..) | SampleContent::Xyz(..) => Vec::new(),
        };
        file.samples.iter().map(|sample| of(&sample.content)).collect()
    }

    #[test]
    fn words_quotes_and_remarks() {
        assert_eq!(words_of("a \"b c\"  d # e"), ["a", "b c", "d"]);
        assert_eq!(words_of("\"a \"\"b\"\" # c\" d#e"), ["a \"b\" # c", "d#e"]);
        assert_eq!(words_of("ORIGINATOR \"never closed"), ["ORIGINATOR", "never closed"]);
        assert_eq!(words_of("  # all"), Vec::<String>::new());
    }

    #[test]
    fn sets_by_lines_wrapped_or_side_by_side_are_the_same() {
        let head = "ISO28178\nBEGIN_DATA_FORMAT\nSAMPLE_NAME SPEC_400 SPEC_410 # two\nSPEC_420\nEND_DATA_FORMAT\nBEGIN_DATA\n";
        let all = vec![vec![1.0, 2.0, 3.0], vec![4.0, 5.0, 6.0]];
        for data in [
            "a 1 2 3\nb 4 5 6\n",
            "a 1\n2 3\n\nb\n4 5\n6\n",
            "a 1 2 3 b 4 5 6\n",
            "# first\na\t1,0 2,0 3.0 # end\n# second\n\"b\" 4 5 6\n",
            "a dark ink\t1\t2\t3\nb\t4\t5\t6\t\n",
        ] {
            assert_eq!(values(&read(&format!("{head}{data}END_DATA\n")).unwrap()), all, "{data}");
        }
        let ragged = read(&format!("{head}a 1 2 3\nb 4 5\nc 7 8 9\nEND_DATA\n")).unwrap();
        assert_eq!(values(&ragged), [vec![1.0, 2.0, 3.0], vec![], vec![7.0, 8.0, 9.0]]);
        assert_eq!(ragged.samples[1].names, ["b"]);
        for (cut, says) in [("a 1 2 3\n", "cut short"), ("a 1\n2\nb 3\n4 5 6\nEND_DATA\n", "whole sets")] {
            let error = read(&format!("{head}{cut}")).unwrap_err();
            assert!(error.contains(says), "{error}");
        }
    }

    #[test]
    fn keywords_are_believed() {
        let of = |text: &str| {
            let header: Vec<(String, String)> =
                text.lines().map(words_of).map(|mut words| (words.remove(0), words.join(" "))).collect();
            declared(&header)
        };
        assert_eq!(of("SPECTRAL_NORM \"100.0\"").white, Some(100.0));
        assert_eq!(of("MEAS_TYPE \"TRANSMISSIVE\"").kind, MeasuredKind::Transmittance);
        let named =
            of("ILLUMINANT \"D65\"\nOBSERVER \"CIE 2 degree\"\nMEASUREMENT_SOURCE \"Illumination=D50\"")
                .viewing;
        assert_eq!((named.illuminants, named.observers), (vec!["D65".to_owned()], vec!["2".to_owned()]));
        let both =
            of("WEIGHTING_FUNCTION \"ILLUMINANT, A\"\nWEIGHTING_FUNCTION \"OBSERVER, 2015, 10 degree\"")
                .viewing;
        assert_eq!((both.illuminants, both.observers), (vec!["A".to_owned()], vec!["2015_10".to_owned()]));
        let words = of(
            "COMPUTATIONAL_PARAMETER \"D50, 2 degree, geometry 45/0\"\nPRINT_CONDITIONS \"curves A, D65\"",
        );
        assert_eq!(words.viewing.illuminants, ["D50"]);
        assert_eq!(words.geometries, [words::MeasuredGeometry::LitAt45]);
    }
}
