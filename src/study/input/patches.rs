//! Selects a sample of a CxF3 or CGATS.17 file.

use super::xml_limits::too_large;
use roxmltree::{Document, Node};

pub(super) const CXF: &str = "http://colorexchangeformat.com/CxF3-core";
/// Maximum number of names in a message.
const MOST_NAMES: usize = 12;

/// The rows of a sample, and its number among the samples of the file.
pub(super) struct Taken {
    /// (wavelength in nm, value) rows.
    pub rows: Vec<[f64; 2]>,
    /// Its name in quotes, or a phrase if it has none.
    pub name: String,
    /// Number of the sample, from 1.
    pub number: usize,
    /// Number of samples in the file.
    pub of: usize,
}

/// Index of the selected sample; the first unless one is named.
pub(super) fn place(names: &[String], patch: Option<&str>) -> Result<usize, String> {
    let Some(wanted) = patch else { return Ok(0) };
    let shown = names.iter().filter(|name| !name.is_empty()).take(MOST_NAMES);
    let found = shown.map(|name| format!("{name:?}")).collect::<Vec<_>>().join(", ");
    let more = if names.len() > MOST_NAMES { " …" } else { "" };
    let found = if found.is_empty() { "no names".to_owned() } else { found + more };
    names
        .iter()
        .position(|name| name.trim() == wanted.trim())
        .ok_or_else(|| format!("no sample {wanted:?}; found {found}"))
}

fn taken(rows: Vec<[f64; 2]>, names: &[String], place: usize) -> Taken {
    let name = if names[place].is_empty() { "unnamed".to_owned() } else { format!("{:?}", names[place]) };
    Taken { rows, name, number: place + 1, of: names.len() }
}

/// Elements of CxF3 with a name.
pub(super) fn elements<'a>(document: &'a Document, name: &'a str) -> impl Iterator<Item = Node<'a, 'a>> {
    document.descendants().filter(move |node| node.has_tag_name((CXF, name)))
}

/// Name of the object that an element belongs to.
pub(super) fn object_name(node: &Node) -> String {
    let object = node.ancestors().find(|n| n.has_tag_name((CXF, "Object")));
    object.and_then(|o| o.attribute("Name").or(o.attribute("Id"))).unwrap_or("").to_owned()
}

/// The object with a reflectance spectrum that has this name, or the first.
pub(super) fn from_cxf(text: &str, patch: Option<&str>) -> Result<Taken, String> {
    if let Some(reason) = too_large(text) {
        return Err(reason);
    }
    let document = Document::parse(text.trim_start_matches('\u{feff}')).map_err(|e| e.to_string())?;
    let spectra: Vec<Node> = elements(&document, "ReflectanceSpectrum").collect();
    if spectra.is_empty() {
        return Err("no ReflectanceSpectrum of CxF3".into());
    }
    let names: Vec<String> = spectra.iter().map(object_name).collect();
    let place = place(&names, patch)?;
    let spectrum = spectra[place];
    let wanted = spectrum.attribute("ColorSpecification");
    let range = elements(&document, "WavelengthRange").find(|node| {
        let specification = node.ancestors().find(|n| n.has_tag_name((CXF, "ColorSpecification")));
        wanted.is_none() || specification.and_then(|s| s.attribute("Id")) == wanted
    });
    let number = |text: Option<&str>| text.and_then(|t| t.trim().parse::<f64>().ok());
    let start = number(spectrum.attribute("StartWL")).or(range.and_then(|r| number(r.attribute("StartWL"))));
    let step = range.and_then(|r| number(r.attribute("Increment")));
    let (Some(start), Some(step)) = (start, step) else {
        return Err("the spectrum's StartWL or its WavelengthRange with Increment is missing".into());
    };
    let words = spectrum.text().unwrap_or("").split_whitespace().enumerate();
    let rows = words.map(|(i, word)| Ok([start + step * i as f64, parsed(word)?]));
    Ok(taken(rows.collect::<Result<_, String>>()?, &names, place))
}

/// One data set of a CGATS.17 file.
pub(super) struct Set<'a> {
    /// Names of all fields.
    fields: Vec<&'a str>,
    /// Its values, one per field.
    cells: Vec<String>,
    /// Names of all sets, and the index of this one.
    names: Vec<String>,
    place: usize,
}

impl Set<'_> {
    /// The number in a field; `None` if the file lacks the field.
    pub fn number(&self, field: &str) -> Option<Result<f64, String>> {
        self.fields.iter().position(|name| *name == field).map(|i| parsed(&self.cells[i]))
    }

    /// Names of all sets.
    pub fn names(&self) -> &[String] {
        &self.names
    }
}

/// Whether a CGATS.17 file has fields of a spectrum.
pub(super) fn has_bands(text: &str) -> bool {
    let format = text.lines().map(str::trim).skip_while(|l| *l != "BEGIN_DATA_FORMAT");
    format.take_while(|l| *l != "END_DATA_FORMAT").flat_map(str::split_whitespace).any(|w| band(w).is_some())
}

/// Wavelength given by the name of a field, nm.
fn band(name: &str) -> Option<f64> {
    let prefixes = ["SPEC_", "SPECTRAL_NM", "nm"];
    let digits = prefixes.iter().find_map(|prefix| name.strip_prefix(prefix))?;
    digits.trim_start_matches('_').parse::<f64>().ok()
}

/// The set with this SAMPLE_NAME or SAMPLE_ID, or the first.
pub(super) fn cgats_set<'a>(text: &'a str, patch: Option<&str>) -> Result<Set<'a>, String> {
    let between = |from: &str, to: &str| -> Option<Vec<&'a str>> {
        let lines = text.lines().map(str::trim);
        Some(lines.skip_while(|l| *l != from).skip(1).take_while(|l| *l != to).collect())
            .filter(|l: &Vec<_>| !l.is_empty())
    };
    let fields = between("BEGIN_DATA_FORMAT", "END_DATA_FORMAT").ok_or("no BEGIN_DATA_FORMAT")?;
    let fields: Vec<&str> = fields.iter().flat_map(|line| line.split_whitespace()).collect();
    let data = between("BEGIN_DATA", "END_DATA").ok_or("no BEGIN_DATA")?;
    let mut sets: Vec<Vec<String>> = data.iter().map(|line| words(line)).filter(|w| !w.is_empty()).collect();
    let title = ["SAMPLE_NAME", "SAMPLE_ID"].iter().find_map(|key| fields.iter().position(|f| f == key));
    let names: Vec<String> =
        sets.iter().map(|set| title.and_then(|t| set.get(t)).cloned().unwrap_or_default()).collect();
    let place = place(&names, patch)?;
    if place >= sets.len() {
        return Err("no BEGIN_DATA".into());
    }
    let cells = sets.swap_remove(place);
    if cells.len() != fields.len() {
        let (found, number) = (cells.len(), place + 1);
        return Err(format!("{found} values in set {number} under {} fields", fields.len()));
    }
    Ok(Set { fields, cells, names, place })
}

/// The spectrum of the selected set.
pub(super) fn from_cgats(text: &str, patch: Option<&str>) -> Result<Taken, String> {
    let set = cgats_set(text, patch)?;
    let bands = set.fields.iter().zip(&set.cells).filter_map(|(name, cell)| Some((band(name)?, cell)));
    let rows = bands.map(|(nm, cell)| Ok([nm, parsed(cell)?])).collect::<Result<Vec<_>, String>>()?;
    if rows.is_empty() { Err("no fields SPEC_nnn".into()) } else { Ok(taken(rows, &set.names, set.place)) }
}

/// Words of a line; quoted words may contain blanks.
fn words(line: &str) -> Vec<String> {
    line.split('"').enumerate().flat_map(words_of_piece).collect()
}

/// Words in the `i`-th piece between quotes: one word if it is quoted.
fn words_of_piece((i, piece): (usize, &str)) -> Vec<String> {
    if i % 2 == 1 {
        return vec![piece.to_owned()];
    }
    piece.split_whitespace().map(str::to_owned).collect()
}

pub(super) fn parsed(word: &str) -> Result<f64, String> {
    word.parse().map_err(|_| format!("found {word:?} where a number is needed"))
}
