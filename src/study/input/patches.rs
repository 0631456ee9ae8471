//! Selects a sample of a CxF3 or CGATS.17 file, and refuses XML whose sizes would make the parser
//! slow: its time grows with their squares.

use roxmltree::{Document, Node};

pub(super) const CXF: &str = "http://colorexchangeformat.com/CxF3-core";
/// Maximum number of names in a message.
const MOST_NAMES: usize = 12;
/// Maximum number of attributes of one element.
const MOST_ATTRIBUTES: usize = 256;
/// Maximum nesting depth of elements.
const DEEPEST: usize = 64;
/// Maximum number of namespace declarations in the whole file.
const MOST_NAMESPACES: usize = 4096;

/// The rows of a sample, and its place among the samples of the file.
pub(super) struct Taken {
    /// (wavelength in nm, value) rows.
    pub rows: Vec<[f64; 2]>,
    /// Names of all samples, empty where they have none.
    pub names: Vec<String>,
    /// Index of this one.
    pub place: usize,
}

/// Index of the selected sample; the first unless one is named.
pub(super) fn place(names: &[String], patch: Option<&str>) -> Result<usize, String> {
    let Some(wanted) = patch else { return Ok(0) };
    let shown = names.iter().filter(|name| !name.is_empty()).take(MOST_NAMES);
    let found = shown.map(|name| format!("{name:?}")).collect::<Vec<_>>().join(", ");
    let more = if names.len() > MOST_NAMES { " …" } else { "" };
    let found = if found.is_empty() { "no names".to_owned() } else { found + more };
    let place = names.iter().position(|name| name.trim() == wanted.trim());
    place.ok_or_else(|| format!("no sample {wanted:?}; found {found}"))
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
    Ok(Taken { rows: rows.collect::<Result<_, String>>()?, names, place })
}

/// One data set of a CGATS.17 file.
pub(super) struct Set<'a> {
    /// Names of all fields.
    fields: Vec<&'a str>,
    /// Its values, one per field.
    cells: Vec<String>,
    /// Names of all sets.
    pub names: Vec<String>,
    /// Index of this one.
    place: usize,
}

impl Set<'_> {
    /// The number in a field.
    pub fn number(&self, field: &str) -> Result<f64, String> {
        let place = self.fields.iter().position(|name| *name == field);
        parsed(&self.cells[place.ok_or_else(|| format!("no field {field}"))?])
    }
}

/// The lines between two others.
fn between<'a>(text: &'a str, from: &str, to: &str) -> impl Iterator<Item = &'a str> {
    text.lines().map(str::trim).skip_while(move |l| *l != from).skip(1).take_while(move |l| *l != to)
}

/// Names of the fields of a CGATS.17 file; none for other files.
pub(super) fn cgats_fields(text: &str) -> Vec<&str> {
    between(text, "BEGIN_DATA_FORMAT", "END_DATA_FORMAT").flat_map(str::split_whitespace).collect()
}

/// Wavelength given by the name of a field, nm.
pub(super) fn band(name: &str) -> Option<f64> {
    let digits = ["SPEC_", "SPECTRAL_NM", "nm"].iter().find_map(|prefix| name.strip_prefix(prefix))?;
    digits.trim_start_matches('_').parse::<f64>().ok()
}

/// The set with this SAMPLE_NAME or SAMPLE_ID, or the first.
pub(super) fn cgats_set<'a>(text: &'a str, patch: Option<&str>) -> Result<Set<'a>, String> {
    let fields = cgats_fields(text);
    if fields.is_empty() {
        return Err("no BEGIN_DATA_FORMAT".into());
    }
    let data = between(text, "BEGIN_DATA", "END_DATA");
    let mut sets: Vec<Vec<String>> = data.map(words).filter(|w| !w.is_empty()).collect();
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
    let Set { names, place, .. } = set;
    if rows.is_empty() { Err("no fields SPEC_nnn".into()) } else { Ok(Taken { rows, names, place }) }
}

/// Words of a line; quoted words may contain blanks.
fn words(line: &str) -> Vec<String> {
    line.split('"').enumerate().flat_map(words_of_piece).map(str::to_owned).collect()
}

/// Words in the `i`-th piece between quotes: one word if it is quoted.
fn words_of_piece((i, piece): (usize, &str)) -> Vec<&str> {
    if i % 2 == 1 { vec![piece] } else { piece.split_whitespace().collect() }
}

pub(super) fn parsed(word: &str) -> Result<f64, String> {
    word.parse().map_err(|_| format!("found {word:?} where a number is needed"))
}

/// Describes what is too large, if anything. The text need not be well formed.
pub(super) fn too_large(text: &str) -> Option<String> {
    let namespaces = text.matches("xmlns").count();
    if namespaces > MOST_NAMESPACES {
        return Some(format!("{namespaces} declarations of namespaces; at most {MOST_NAMESPACES} are read"));
    }
    let (mut rest, mut depth) = (text, 0usize);
    while let Some(start) = rest.find('<') {
        rest = &rest[start + 1..];
        let (tag, after) = tag(rest);
        rest = after;
        depth = match tag.as_bytes().first() {
            Some(b'!' | b'?') => depth,
            Some(b'/') => depth.saturating_sub(1),
            _ if tag.ends_with('/') => depth,
            _ => depth + 1,
        };
        let attributes =
            tag.split(['"', '\'']).step_by(2).map(|part| part.matches('=').count()).sum::<usize>();
        if !tag.starts_with('!') && attributes > MOST_ATTRIBUTES {
            return Some(format!(
                "{attributes} attributes of one element; at most {MOST_ATTRIBUTES} are read"
            ));
        }
        if depth > DEEPEST {
            return Some(format!("more than {DEEPEST} elements inside one another"));
        }
    }
    None
}

/// The text between `<` and its end, and the rest; comments and character data have their own ends.
fn tag(rest: &str) -> (&str, &str) {
    let end =
        |words: &str| rest.find(words).map_or((rest, ""), |at| (&rest[..at], &rest[at + words.len()..]));
    if rest.starts_with("!--") {
        return end("-->");
    }
    if rest.starts_with("![CDATA[") {
        return end("]]>");
    }
    let mut quote = None;
    for (at, c) in rest.char_indices() {
        match (quote, c) {
            (None, '>') => return (&rest[..at], &rest[at + 1..]),
            (None, '"' | '\'') => quote = Some(c),
            (Some(open), c) if c == open => quote = None,
            _ => {}
        }
    }
    (rest, "")
}

#[cfg(test)]
mod tests {
    use super::too_large;

    #[test]
    fn what_would_take_a_parser_long_is_refused_and_the_usual_is_not() {
        let usual = "<?xml version=\"1.0\"?><!-- < a = 'b' --><c:CxF xmlns:c=\"x\"><c:O Name=\"a > b = c\" Id='1'/></c:CxF>";
        assert_eq!(too_large(usual), None);
        let many: String = (0..60_000).map(|i| format!(" a{i}=\"1\"")).collect();
        assert!(too_large(&format!("<CxF{many}/>")).unwrap().contains("60000 attributes"));
        let nested: String = (0..3000).map(|i| format!("<a xmlns:n{i}=\"u{i}\">")).collect();
        assert!(too_large(&nested).unwrap().contains("inside one another"));
        let side_by_side: String = (0..5000).map(|i| format!("<a xmlns:n{i}=\"u{i}\"/>")).collect();
        assert!(too_large(&side_by_side).unwrap().contains("5000 declarations"));
        for unfinished in ["<", "<a b=\"", "<!-- ", "<![CDATA[ <a>", "a < b"] {
            assert_eq!(too_large(unfinished), None, "{unfinished}");
        }
    }
}
