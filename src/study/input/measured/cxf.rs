//! CxF3 (ISO 17972): objects with spectra and colours, each under a colour specification that says
//! how it was measured. Elements are recognised by their local names, whatever the namespace's
//! prefix.

use super::MeasuredCondition;
use super::quantity::other_quantity;
use super::sample::{MeasuredFile, MeasuredSample, SampleContent, SpectralCell, StatedViewing, Written};
use super::words::{self, MeasuredGeometry, MeasuredKind};
use crate::material::text_table::number;
use roxmltree::{Document, Node, ParsingOptions};
use std::collections::HashMap;

/// Most nodes of a document: some hundred thousand measurements.
const MOST_NODES: u32 = 4_000_000;
/// Most values of spectra.
const MOST_VALUES: usize = 4_000_000;
/// Maximum number of attributes of one element.
const MOST_ATTRIBUTES: usize = 256;
/// Maximum nesting depth of elements.
const DEEPEST: usize = 64;
/// Maximum number of namespace declarations in the whole file.
const MOST_NAMESPACES: usize = 4096;

/// All samples of a file.
///
/// # Errors
/// It is no XML, its sizes would make the parser slow, or it is no CxF3.
pub fn read(text: &str) -> Result<MeasuredFile, String> {
    if let Some(reason) = too_large(text) {
        return Err(reason);
    }
    // a declaration stands at the very start
    let text = text.trim_start();
    let lines = LineEnds::new(text);
    let options = ParsingOptions { nodes_limit: MOST_NODES, ..ParsingOptions::default() };
    let document = Document::parse_with_options(text, options).map_err(|e| e.to_string())?;
    let root = document.root_element();
    if root.tag_name().name() != "CxF" {
        return Err(format!("the XML's root is {:?}, not CxF", root.tag_name().name()));
    }
    let mut specifications = HashMap::new();
    for node in named(root, "ColorSpecification") {
        let id = node.attribute("Id").unwrap_or_default();
        specifications.insert(id.to_owned(), Specification::new(node));
    }
    let lone = (specifications.len() == 1).then(|| specifications.values().next().cloned()).flatten();
    // without specifications a range of wavelengths may stand alone
    let alone = if specifications.is_empty() { range(root) } else { None };
    let apart = lone.unwrap_or_else(|| Specification { range: alone, ..Specification::default() });
    let mut file = MeasuredFile::default();
    let mut count = 0;
    for node in root.descendants().filter(Node::is_element) {
        let id = node.attribute("ColorSpecification").unwrap_or_default();
        let specification = specifications.get(id).unwrap_or(&apart);
        let content = match node.tag_name().name() {
            "ReflectanceSpectrum" | "TransmittanceSpectrum" | "EmissiveSpectrum" => {
                Some(SampleContent::Spectrum(spectrum(node, specification, lines.line_of(node))))
            }
            "CustomSpectrum" => Some(SampleContent::Spectrum(points(node, lines.line_of(node)))),
            "ColorCIELab" => three_values(node, ["L", "A", "B"], lines.line_of(node))
                .map(|lab| SampleContent::Lab(lab, specification.viewing.clone())),
            "ColorCIEXYZ" => three_values(node, ["X", "Y", "Z"], lines.line_of(node))
                .map(|xyz| SampleContent::Xyz(xyz, specification.viewing.clone())),
            _ => None,
        };
        let Some(content) = content else { continue };
        if let SampleContent::Spectrum(rows) = &content {
            count += rows.len();
        }
        if count > MOST_VALUES {
            return Err(format!("more than {MOST_VALUES} values of spectra"));
        }
        let kind = match node.tag_name().name() {
            "TransmittanceSpectrum" => MeasuredKind::Transmittance,
            "EmissiveSpectrum" => MeasuredKind::Emission,
            _ => specification.kind,
        };
        let (names, device) = object(node);
        let of_object = own_norm(node).or(specification.white);
        file.samples.push(MeasuredSample {
            names,
            device,
            condition: specification.condition,
            geometry: specification.geometry.clone(),
            kind,
            white: of_object,
            content,
        });
    }
    Ok(file)
}

/// Elements below a node with a local name.
fn named<'a>(node: Node<'a, 'a>, name: &'a str) -> impl Iterator<Item = Node<'a, 'a>> {
    node.descendants().filter(move |node| node.is_element() && node.tag_name().name() == name)
}

/// All text of a node: comments and character data part it, and it is one all the same.
fn full_text(node: Node) -> String {
    let parts: Vec<&str> = node.descendants().filter(Node::is_text).filter_map(|node| node.text()).collect();
    parts.concat().trim().to_owned()
}

/// Text of the first element below a node with a local name, if there is any.
fn text_of(node: Node, name: &str) -> Option<String> {
    let element = node.descendants().find(|node| node.is_element() && node.tag_name().name() == name)?;
    Some(full_text(element)).filter(|text| !text.is_empty())
}

/// Places of the line ends of a text.
struct LineEnds(Vec<usize>);

impl LineEnds {
    fn new(text: &str) -> Self {
        Self(text.match_indices('\n').map(|(at, _)| at).collect())
    }

    /// Line of a node, from 1.
    fn line_of(&self, node: Node) -> usize {
        let start = node.range().start;
        self.0.partition_point(|&end| end < start) + 1
    }
}

/// Names of the object that an element belongs to, and its amounts of ink.
fn object(node: Node) -> (Vec<String>, Vec<f64>) {
    let Some(object) = node.ancestors().find(|node| node.tag_name().name() == "Object") else {
        return (Vec::new(), Vec::new());
    };
    let names = ["Name", "Id"].map(|key| object.attribute(key).unwrap_or_default().trim().to_owned());
    let device = object
        .descendants()
        .find(|node| ["ColorCMYK", "ColorCMYKPlusN", "ColorRGB"].contains(&node.tag_name().name()));
    let parts = device.into_iter().flat_map(|node| node.children().filter(Node::is_element));
    let values = parts.filter(|node| node.tag_name().name() != "MaxRange");
    let values = values.filter_map(|node| number(&full_text(node), true)).collect();
    (names.to_vec(), values)
}

/// White of the object that an element belongs to, if a tag of it says so.
fn own_norm(node: Node) -> Option<f64> {
    let object = node.ancestors().find(|node| node.tag_name().name() == "Object")?;
    let tag = named(object, "Tag").find(|tag| tag.attribute("Name") == Some("SpectralNorm"))?;
    number(tag.attribute("Value")?, true).filter(|white| white.is_finite() && *white > 0.0)
}

/// How the values under a specification were measured.
#[derive(Clone, Debug, Default)]
struct Specification {
    kind: MeasuredKind,
    condition: Option<MeasuredCondition>,
    geometry: Option<MeasuredGeometry>,
    /// First wavelength, if stated, and step, nm.
    range: Option<(Option<f64>, f64)>,
    white: Option<f64>,
    viewing: StatedViewing,
}

impl Specification {
    fn new(node: Node) -> Self {
        let of_type = text_of(node, "MeasurementType").and_then(|text| MeasuredKind::of(&text));
        let light = text_of(node, "DeviceIllumination").unwrap_or_default();
        let mut condition = words::conditions(&light).first().copied();
        let is_true = |text: String| ["true", "1"].contains(&text.as_str());
        if condition.is_none() && text_of(node, "DevicePolarization").is_some_and(is_true) {
            condition = Some(MeasuredCondition::M3);
        }
        let unit = ["Unit", "Units", "Scale", "ValueRange"].iter().find_map(|name| text_of(node, name));
        let kind = unit.as_deref().and_then(other_quantity).or(of_type).unwrap_or_default();
        let norm = text_of(node, "SpectralNorm").and_then(|text| number(&text, true));
        let stated = unit.and_then(|unit| {
            let lower = unit.to_lowercase();
            let is_factor = lower.contains("factor") || number(&lower, true) == Some(1.0);
            let is_percent = lower.contains('%') || lower.contains("percent");
            is_percent.then_some(100.0).or(is_factor.then_some(1.0))
        });
        let white = norm.filter(|white| white.is_finite() && *white > 0.0).or(stated);
        let viewing = named(node, "TristimulusSpec").next().map(viewing).unwrap_or_default();
        Self { kind, condition, geometry: geometry(node), range: range(node), white, viewing }
    }
}

/// First wavelength and step of the first range below a node.
fn range(node: Node) -> Option<(Option<f64>, f64)> {
    let range = named(node, "WavelengthRange").next()?;
    let attribute = |name: &str| range.attribute(name).and_then(|text| number(text, true));
    Some((attribute("StartWL"), attribute("Increment")?))
}

/// Directions of light and view.
fn geometry(node: Node) -> Option<MeasuredGeometry> {
    let choice = named(node, "GeometryChoice").next()?;
    let chosen = choice.children().find(Node::is_element)?;
    let all: Vec<&str> = chosen
        .descendants()
        .filter_map(|node| node.text())
        .map(str::trim)
        .filter(|text| !text.is_empty())
        .collect();
    let said = all.join(" ");
    let kind = chosen.tag_name().name();
    match kind {
        "SingleAngle" => {
            let angle = |name| text_of(chosen, name).and_then(|text| number(&text, true));
            match (angle("IlluminationAngle"), angle("MeasurementAngle")) {
                (Some(a), Some(b)) if (a.abs() == 45.0 && b == 0.0) || (a == 0.0 && b.abs() == 45.0) => {
                    Some(MeasuredGeometry::LitAt45)
                }
                (Some(a), Some(b)) => Some(MeasuredGeometry::Other(format!("{a}:{b}"))),
                _ => None,
            }
        }
        _ if kind.starts_with("Sphere") => {
            let lower = said.to_lowercase();
            let specular = match (
                lower.contains("inclu") || lower.contains("sci"),
                lower.contains("exclu") || lower.contains("sce"),
            ) {
                (true, false) => Some(true),
                (false, true) => Some(false),
                _ => None,
            };
            Some(MeasuredGeometry::Sphere(specular))
        }
        "MultiAngle" => Some(MeasuredGeometry::Other("several angles".into())),
        "EmissiveMode" => None,
        _ => {
            let found = words::geometries(&said).into_iter().next();
            found.or_else(|| {
                Some(MeasuredGeometry::Other(said.clone()))
                    .filter(|_| !said.is_empty() && !says_unknown(&said))
            })
        }
    }
}

/// Whether a geometry is stated to be unknown.
fn says_unknown(said: &str) -> bool {
    let lower = said.to_lowercase();
    ["unknown", "unspecified", "undefined", "none", "n/a", "other"].iter().any(|word| lower.contains(word))
}

/// Illuminant and observer of a specification.
fn viewing(node: Node) -> StatedViewing {
    let illuminant = named(node, "Illuminant").next().and_then(|light| {
        let name = full_text(light);
        let is_custom = name.eq_ignore_ascii_case("custom") || name.is_empty();
        if is_custom { light.attribute("Name").map(str::to_owned) } else { Some(name) }
    });
    let observer = named(node, "Observer").next().and_then(|eye| {
        let name = full_text(eye);
        let custom = || Some(format!("{}, {} degree", eye.attribute("Name")?, eye.attribute("Angle")?));
        let stated = if name.starts_with("Custom") { custom() } else { Some(name) };
        stated.as_deref().and_then(words::stated_observer)
    });
    StatedViewing { illuminants: illuminant.into_iter().collect(), observers: observer.into_iter().collect() }
}

/// Values in equal steps.
fn spectrum(node: Node, specification: &Specification, line: usize) -> Vec<SpectralCell> {
    let start = node.attribute("StartWL").and_then(|text| number(text, true));
    let step = node.attribute("Increment").and_then(|text| number(text, true));
    let start = start.or(specification.range.and_then(|(start, _)| start));
    let step = step.or(specification.range.map(|(_, step)| step));
    let cell = |(i, word): (usize, &str)| SpectralCell {
        nm: start.zip(step).map(|(start, step)| start + step * i as f64),
        value: Written { text: word.to_owned(), line },
    };
    full_text(node).split_whitespace().enumerate().map(cell).collect()
}

/// Values with a wavelength each.
fn points(node: Node, line: usize) -> Vec<SpectralCell> {
    let cell = |point: Node| SpectralCell {
        nm: point.attribute("WL").and_then(|text| number(text, true)),
        value: Written { text: full_text(point), line },
    };
    named(node, "SpectralPoint").map(cell).collect()
}

/// The values of a colour by the names of its coordinates.
fn three_values(node: Node, names: [&str; 3], line: usize) -> Option<[Written; 3]> {
    let part = |name| text_of(node, name).map(|text| Written { text, line });
    Some([part(names[0])?, part(names[1])?, part(names[2])?])
}

/// Describes what is too large, if anything. The text need not be well formed.
fn too_large(text: &str) -> Option<String> {
    let namespaces = text.matches("xmlns").count();
    if namespaces > MOST_NAMESPACES {
        return Some(format!("{namespaces} declarations of namespaces; at most {MOST_NAMESPACES} are read"));
    }
    let mut rest = text;
    let mut depth = 0usize;
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
