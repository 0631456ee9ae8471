//! Measured colours: Lab without a spectrum in a CxF3 or CGATS.17 file, which is a target.

use super::patches::{CXF, band, cgats_fields, cgats_set, elements, object_name, parsed, place, too_large};
use crate::appearance::viewing::{Summation, Viewing};

/// L*, a*, b* of a sample, with the illuminant and the observer stated in its file.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredColour {
    /// L*, a*, b*.
    pub lab: [f64; 3],
    /// Name of the illuminant as in the file.
    pub illuminant: Option<String>,
    /// Name of the observer, such as `2`.
    pub observer: Option<String>,
}

impl MeasuredColour {
    /// Reads the sample named `patch`, or the only one; `None` if the text is neither CxF3 nor
    /// CGATS.17, has spectra or no Lab.
    ///
    /// # Errors
    /// There is no sample of that name, there are several and no name is given, or values are not
    /// numbers.
    pub fn parse(text: &str, patch: Option<&str>) -> Result<Option<Self>, String> {
        let start = text.trim_start_matches('\u{feff}').trim_start();
        if start.starts_with('<') { from_cxf(start, patch) } else { from_cgats(start, patch) }
    }

    /// The conditions stated in the file.
    ///
    /// # Errors
    /// The file states none, or names that are unknown.
    pub fn viewing(&self, summation: Summation) -> Result<Viewing, String> {
        let (Some(illuminant), Some(observer)) = (&self.illuminant, &self.observer) else {
            return Err("its illuminant and observer are not stated".to_owned());
        };
        Viewing::new(illuminant, observer, summation).map_err(|error| error.to_string())
    }
}

fn from_cgats(text: &str, patch: Option<&str>) -> Result<Option<MeasuredColour>, String> {
    let fields = cgats_fields(text);
    let lab = ["LAB_L", "LAB_A", "LAB_B"];
    if !lab.iter().all(|field| fields.contains(field)) || fields.iter().any(|name| band(name).is_some()) {
        return Ok(None);
    }
    let set = cgats_set(text, patch)?;
    one_is_meant(&set.names, patch)?;
    let [l, a, b] = lab.map(|field| set.number(field));
    let stated = |words: [&str; 3]| words.iter().find_map(|word| after(text, word));
    Ok(Some(MeasuredColour {
        lab: [l?, a?, b?],
        illuminant: stated(["\"ILLUMINANT,", "ILLUMINATION_NAME", "Illumination="]),
        observer: stated(["\"OBSERVER,", "OBSERVER_ANGLE", "ObserverAngle="]),
    }))
}

/// The text after a word, up to the closing quote or the unit: `2` in `WEIGHTING_FUNCTION
/// "OBSERVER, 2 degree"`.
fn after(text: &str, word: &str) -> Option<String> {
    let value = text.lines().find_map(|line| line.split_once(word))?.1.trim_start_matches([' ', '\t', '"']);
    let value = value.split(['"', '\t', '°']).next()?.replace("degree", "").replace("2015, ", "2015_");
    value.split_whitespace().next().map(str::to_owned)
}

/// A target is a single colour: of several samples one must be named.
fn one_is_meant(names: &[String], patch: Option<&str>) -> Result<(), String> {
    if names.len() < 2 || patch.is_some() {
        return Ok(());
    }
    let first = names.iter().find(|name| !name.is_empty());
    let example = first.map_or(String::new(), |name| format!(", such as {name:?}"));
    Err(format!("{} samples, of which none is named: write compare.patch{example}", names.len()))
}

fn from_cxf(text: &str, patch: Option<&str>) -> Result<Option<MeasuredColour>, String> {
    if too_large(text).is_some() {
        return Ok(None);
    }
    let Ok(document) = roxmltree::Document::parse(text) else { return Ok(None) };
    let colours: Vec<roxmltree::Node> = elements(&document, "ColorCIELab").collect();
    if colours.is_empty() || elements(&document, "ReflectanceSpectrum").next().is_some() {
        return Ok(None);
    }
    let names: Vec<String> = colours.iter().map(object_name).collect();
    one_is_meant(&names, patch)?;
    let colour = colours[place(&names, patch)?];
    let part = |name: &str| {
        let text = colour.children().find(|n| n.has_tag_name((CXF, name))).and_then(|n| n.text());
        parsed(text.unwrap_or("").trim())
    };
    let wanted = colour.attribute("ColorSpecification");
    let mut specifications = elements(&document, "ColorSpecification");
    let specification = specifications.find(|n| wanted.is_some() && n.attribute("Id") == wanted);
    let stated = |name: &str| {
        let node = specification?.descendants().find(|n| n.has_tag_name((CXF, name)))?;
        Some(node.text()?.trim().trim_end_matches("_Degree").to_owned())
    };
    Ok(Some(MeasuredColour {
        lab: [part("L")?, part("A")?, part("B")?],
        illuminant: stated("Illuminant"),
        observer: stated("Observer"),
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    const CGATS: &str = "CGATS.17\nCONDITIONS\nBEGIN_DATA_FORMAT\nSAMPLE_NAME LAB_L LAB_A LAB_B\nEND_DATA_FORMAT\n\
                         BEGIN_DATA\n\"paper\" 95 0 -2\n\"my ink\" 85.5 -10 80\nEND_DATA\n";

    fn cxf(specification: &str) -> String {
        format!(
            "<c:CxF xmlns:c=\"{CXF}\"><c:Object Name=\"my ink\"><c:ColorCIELab ColorSpecification=\"s\"><c:L>85.5</c:L>\
             <c:A>-10</c:A><c:B>80</c:B></c:ColorCIELab></c:Object><c:ColorSpecification Id=\"s\">{specification}\
             </c:ColorSpecification></c:CxF>"
        )
    }

    #[test]
    fn lab_alone_is_a_colour_under_the_conditions_that_the_file_states() {
        let spec = "<c:TristimulusSpec><c:Illuminant>D50</c:Illuminant><c:Observer>2_Degree</c:Observer></c:TristimulusSpec>";
        let conditions = [
            "WEIGHTING_FUNCTION \"ILLUMINANT, D50\"\nWEIGHTING_FUNCTION \"OBSERVER, 2 degree\"",
            "ILLUMINATION_NAME \"D50\"\nOBSERVER_ANGLE \"2\"",
            "MEASUREMENT_SOURCE \"Illumination=D50\tObserverAngle=2°\tWhiteBase=Abs\"",
        ];
        let texts = conditions.map(|stated| CGATS.replace("CONDITIONS", stated));
        for text in texts.iter().chain([&cxf(spec)]) {
            let colour = MeasuredColour::parse(text, Some("my ink")).unwrap().unwrap();
            assert_eq!(colour.lab, [85.5, -10.0, 80.0]);
            let viewing = colour.viewing(Summation::Plain).unwrap();
            assert_eq!((viewing.illuminant(), viewing.observer()), ("D50", "2"), "{text}");
        }
        let wide = CGATS.replace(
            "CONDITIONS",
            "WEIGHTING_FUNCTION \"ILLUMINANT, A\"\nWEIGHTING_FUNCTION \"OBSERVER, 2015, 10 degree\"",
        );
        let wide = MeasuredColour::parse(&wide, Some("paper")).unwrap().unwrap();
        assert_eq!((wide.lab[0], wide.viewing(Summation::Plain).unwrap().observer()), (95.0, "2015_10"));
    }

    #[test]
    fn conditions_that_are_not_stated_or_not_known_are_errors_and_spectra_are_left_alone() {
        for text in [CGATS.to_owned(), cxf("")] {
            let colour = MeasuredColour::parse(&text, Some("my ink")).unwrap().unwrap();
            assert!(colour.viewing(Summation::Plain).unwrap_err().contains("not stated"));
        }
        let odd = CGATS.replace("CONDITIONS", "ILLUMINATION_NAME \"D93\"\nOBSERVER_ANGLE \"2\"");
        let odd = MeasuredColour::parse(&odd, Some("paper")).unwrap().unwrap();
        assert!(odd.viewing(Summation::Plain).unwrap_err().contains("D93"));
        let unnamed = MeasuredColour::parse(CGATS, None).unwrap_err();
        assert!(unnamed.contains("2 samples") && unnamed.contains("compare.patch"), "{unnamed}");
        assert!(MeasuredColour::parse(CGATS, Some("none")).unwrap_err().contains("no sample"));
        assert!(MeasuredColour::parse(&CGATS.replace("85.5", "x"), Some("my ink")).is_err());
        let spectral =
            CGATS.replace("LAB_B", "LAB_B SPEC_400").replace("-2\n", "-2 90\n").replace("80\n", "80 50\n");
        assert_eq!(MeasuredColour::parse(&spectral, None).unwrap(), None);
        assert_eq!(MeasuredColour::parse("wavelength_nm,reflectance\n400,0.5\n", None).unwrap(), None);
    }
}
