//! What files of measurements say in words: geometry, light, kind, illuminant and observer.

use super::MeasuredCondition;

/// Directions of light and view of a measurement.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum MeasuredGeometry {
    /// 45:0 or 0:45, which are equal by reciprocity.
    LitAt45,
    /// A sphere: diffuse light, seen at about 8°, or the reverse; whether specular light is
    /// included, where it is stated.
    Sphere(Option<bool>),
    /// Diffuse light, seen along the normal through a port: nothing is mirrored.
    DiffuseNormal,
    /// A uniform sky, seen along the normal.
    UniformSky,
    /// Any other, as the file calls it.
    Other(String),
}

impl MeasuredGeometry {
    /// In words.
    pub fn name(&self) -> String {
        match self {
            Self::LitAt45 => "45:0".into(),
            Self::Sphere(None) => "d:8 (a sphere)".into(),
            Self::Sphere(Some(true)) => "d:8 (a sphere), specular light included".into(),
            Self::Sphere(Some(false)) => "d:8 (a sphere), specular light excluded".into(),
            Self::DiffuseNormal => "d:0".into(),
            Self::UniformSky => "a uniform sky seen along the normal".into(),
            Self::Other(words) => words.clone(),
        }
    }
}

/// What was measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MeasuredKind {
    /// Reflected light; also where nothing is said.
    #[default]
    Reflectance,
    /// Transmitted light.
    Transmittance,
    /// Emitted light.
    Emission,
    /// An absorbance, another logarithm, or a density.
    Absorbance,
    /// The ratio K/S of Kubelka and Munk.
    KubelkaMunk,
}

impl MeasuredKind {
    /// In words.
    pub fn name(self) -> &'static str {
        match self {
            Self::Reflectance => "reflectance",
            Self::Transmittance => "transmittance (transmissive)",
            Self::Emission => "emission",
            Self::Absorbance => "an absorbance, a logarithm or a density",
            Self::KubelkaMunk => "K/S of Kubelka and Munk",
        }
    }

    /// The kind that a declaration names.
    pub fn of(text: &str) -> Option<Self> {
        let lower = text.to_lowercase();
        let has = |all: &[&str]| all.iter().any(|word| lower.contains(word));
        if has(&["transmi"]) {
            Some(Self::Transmittance)
        } else if has(&["emissi", "display", "ambient", "radiance"]) {
            Some(Self::Emission)
        } else if has(&["absorb", "optical density"]) {
            Some(Self::Absorbance)
        } else if has(&["reflect"]) {
            Some(Self::Reflectance)
        } else {
            None
        }
    }
}

/// Words of a text: runs of letters and digits, in lower case; degree signs are words.
pub fn word_list(text: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    for c in text.to_lowercase().chars() {
        match c {
            '°' | 'º' => words.extend(["°".to_owned(), String::new()]),
            c if c.is_alphanumeric() => words.last_mut().into_iter().for_each(|word| word.push(c)),
            _ => words.push(String::new()),
        }
    }
    words.retain(|word| !word.is_empty());
    words
}

/// Whether a text has a phrase that no letter or digit continues.
pub fn has_phrase(text: &str, phrase: &str) -> bool {
    text.match_indices(phrase).any(|(at, _)| {
        let continues = |c: char| c.is_alphanumeric() || c == ':' || c == '/';
        let before = text[..at].chars().next_back().is_some_and(continues);
        let after = text[at + phrase.len()..].chars().next().is_some_and(continues);
        !before && !after
    })
}

/// The conditions M0 to M3 of ISO 13655 that a text names.
pub fn conditions(text: &str) -> Vec<MeasuredCondition> {
    let lower = text.to_lowercase();
    let words = word_list(text);
    let mut found = Vec::new();
    for condition in MeasuredCondition::ALL {
        let name = condition.name().to_lowercase();
        let in_words = match condition {
            MeasuredCondition::M2 => ["uvcut", "uv-cut", "uv cut", "uvexcluded", "uv excluded", "filter=uv"]
                .iter()
                .any(|p| lower.contains(p)),
            MeasuredCondition::M3 => ["filter=pol", "m3_pol"].iter().any(|p| lower.contains(p)),
            _ => false,
        };
        if in_words || words.contains(&name) {
            found.push(condition);
        }
    }
    found
}

/// The geometries that a text names.
pub fn geometries(text: &str) -> Vec<MeasuredGeometry> {
    let mut plain = text.to_lowercase().replace(['°', 'º'], "");
    for degrees in ["degrees", "degree", "deg."] {
        plain = plain.replace(degrees, "");
    }
    plain = plain.split_whitespace().collect::<Vec<_>>().join(" ");
    for (from, to) in [(" :", ":"), (": ", ":"), (" /", "/"), ("/ ", "/")] {
        plain = plain.replace(from, to);
    }
    let mut found = Vec::new();
    let angles = [
        "45:0", "45/0", "0:45", "0/45", "45a:0", "45c:0", "45x:0", "0:45a", "0:45c", "0:45x", "45a/0",
        "45c/0", "45x/0", "0/45a", "0/45c", "0/45x", "45-0", "0-45",
    ];
    if angles.iter().any(|phrase| has_phrase(&plain, phrase)) {
        found.push(MeasuredGeometry::LitAt45);
    }
    let included = ["di:8", "di/8", "8:di", "8/di", "sci", "spin", "rsin"];
    let excluded = ["de:8", "de/8", "8:de", "8/de", "sce", "spex", "rsex"];
    let either = ["d:8", "d/8", "8:d", "8/d", "d8", "t:8", "8:t"];
    let normal = ["d:0", "d/0", "0:d", "0/d"];
    let has = |all: &[&str]| all.iter().any(|phrase| has_phrase(&plain, phrase));
    let specular = |word: &str| {
        ["specular", "gloss", "spec"].iter().any(|light| {
            plain.contains(&format!("{light} {word}"))
                || plain.contains(&format!("{light} component {word}"))
                || plain.contains(&format!("{light}_{word}"))
                || plain.contains(&format!("{light} light {word}"))
                || plain.contains(&format!("{word} {light}"))
        })
    };
    let (included, excluded) =
        (has(&included) || specular("included"), has(&excluded) || specular("excluded"));
    let is_sphere = has(&either) || plain.contains("sphere") || plain.contains("ulbricht");
    let is_normal = has(&normal) && !included;
    if is_normal {
        found.push(MeasuredGeometry::DiffuseNormal);
    }
    let is_sphere = is_sphere && !is_normal;
    match (included, excluded) {
        (true, false) => found.push(MeasuredGeometry::Sphere(Some(true))),
        // with a geometry of two directions specular light is left out by itself
        (false, true) if is_sphere || found.is_empty() => found.push(MeasuredGeometry::Sphere(Some(false))),
        _ if is_sphere => found.push(MeasuredGeometry::Sphere(None)),
        _ => {}
    }
    if plain.contains("uniform sky") || plain.contains("uniform hemisphere") {
        found.push(MeasuredGeometry::UniformSky);
    }
    if found.is_empty()
        && ["multi-angle", "multiangle", "45as", "as15", "as45"].iter().any(|word| plain.contains(word))
    {
        found.push(MeasuredGeometry::Other(text.trim().to_owned()));
    }
    found
}

/// Illuminants that a text may name without saying that they are ones.
const NAMED_LIGHTS: [&str; 16] = [
    "d50", "d55", "d60", "d65", "d75", "d93", "f1", "f2", "f4", "f7", "f8", "f9", "f10", "f11", "f12", "tl84",
];

/// The illuminants that a text names.
pub fn illuminants(text: &str) -> Vec<String> {
    let words = word_list(text);
    let mut found: Vec<String> = Vec::new();
    for (i, word) in words.iter().enumerate() {
        let after_light =
            i > 0 && ["illuminant", "illumination", "illum", "lightsource"].contains(&words[i - 1].as_str());
        let single = ["a", "c", "e"].contains(&word.as_str()) && after_light;
        let name = word.to_uppercase();
        if (single || NAMED_LIGHTS.contains(&word.as_str())) && !found.contains(&name) {
            found.push(name);
        }
    }
    found
}

/// The illuminant in the value of a keyword for it, such as `CIE D65`, `Illuminant A`, `LED_B3`.
pub fn stated_illuminant(text: &str) -> Option<String> {
    let skipped = ["cie", "illuminant", "illumination", "standard", "iso", "light", "simulator"];
    let words = text.split(|c: char| c.is_whitespace() || matches!(c, ',' | '=' | ':' | '"'));
    words
        .map(str::trim)
        .find(|word| !word.is_empty() && !skipped.contains(&word.to_lowercase().as_str()))
        .map(str::to_owned)
}

/// The observers that a text names: `2`, `10`, `2015_2` or `2015_10`.
pub fn observers(text: &str) -> Vec<String> {
    let words = word_list(text);
    let degrees = ["°", "degree", "degrees", "deg"];
    let about = ["observer", "observerangle", "obs", "angle", "cmf"];
    let mut found: Vec<String> = Vec::new();
    let is_2015 = words.iter().any(|word| word == "2015" || word == "cie2015");
    for (i, word) in words.iter().enumerate() {
        let next = words.get(i + 1).map_or("", String::as_str);
        let previous = if i > 0 { words[i - 1].as_str() } else { "" };
        let angle = match word.as_str() {
            "2" | "10" if degrees.contains(&next) || about.contains(&previous) => word.as_str(),
            "2deg" | "2degree" | "2degrees" => "2",
            "10deg" | "10degree" | "10degrees" => "10",
            "1931" | "cie1931" if text.to_lowercase().contains("cie") => "2",
            "1964" | "cie1964" if text.to_lowercase().contains("cie") => "10",
            _ => continue,
        };
        let name = if is_2015 { format!("2015_{angle}") } else { angle.to_owned() };
        if !found.contains(&name) {
            found.push(name);
        }
    }
    found
}

/// The observer in the value of a keyword for it, such as `CIE 2 degree` or `2015_10`.
pub fn stated_observer(text: &str) -> Option<String> {
    let words = word_list(text);
    let is_2015 = words.iter().any(|word| word == "2015");
    let angle = words.iter().find(|word| ["2", "10"].contains(&word.as_str())).cloned();
    match (angle.or_else(|| observers(text).into_iter().next()), is_2015) {
        (Some(angle), true) if !angle.contains('_') => Some(format!("2015_{angle}")),
        (Some(angle), _) => Some(angle),
        (None, _) => Some(text.trim().to_owned()).filter(|text| !text.is_empty()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use MeasuredGeometry::{LitAt45, Sphere};

    #[test]
    fn geometries_are_recognised_in_words_and_times_of_day_are_none() {
        for (text, found) in [
            ("D50, 2 degree, geometry 45/0, no polarisation filter", vec![LitAt45]),
            ("45°:0°", vec![LitAt45]),
            ("0°/45° annular", vec![LitAt45]),
            ("45°a:0°", vec![LitAt45]),
            ("0°/45°c circumferential", vec![LitAt45]),
            ("45 degree / 0 degree", vec![LitAt45]),
            ("d/8, SCI", vec![Sphere(Some(true))]),
            ("d/0°, gloss excluded", vec![MeasuredGeometry::DiffuseNormal]),
            ("de:8°", vec![Sphere(Some(false))]),
            ("Diffuse 8°, integrating sphere", vec![Sphere(None)]),
            ("d:8, specular component excluded", vec![Sphere(Some(false))]),
            ("45:0 and uniform sky:0, simulated", vec![LitAt45, MeasuredGeometry::UniformSky]),
            ("12:45:00, 10/45/0, scientific", vec![]),
            ("spectrophotometer", vec![]),
        ] {
            assert_eq!(geometries(text), found, "{text}");
        }
    }

    #[test]
    fn conditions_illuminants_and_observers_are_recognised_in_words() {
        let fogra =
            "D50, 2 degree, geometry 45/0, no polarisation filter, white backing, according to ISO 13655";
        assert_eq!((illuminants(fogra), observers(fogra)), (vec!["D50".to_owned()], vec!["2".to_owned()]));
        assert!(conditions(fogra).is_empty());
        let maker = "Illumination=D65\tObserverAngle=10°\tWhiteBase=Abs\tFilter=UVcut";
        assert_eq!((illuminants(maker), observers(maker)), (vec!["D65".to_owned()], vec!["10".to_owned()]));
        assert_eq!(conditions(maker), [MeasuredCondition::M2]);
        assert_eq!(conditions("MeasurementCondition=M1 Filter=no"), [MeasuredCondition::M1]);
        assert_eq!(conditions("Filter=Polarizer"), [MeasuredCondition::M3]);
        assert_eq!(stated_illuminant("CIE Illuminant A").as_deref(), Some("A"));
        assert_eq!(stated_illuminant("LED_B3").as_deref(), Some("LED_B3"));
        for (text, name) in [
            ("CIE 2 degree", "2"),
            ("2", "2"),
            ("10°", "10"),
            ("CIE 1964", "10"),
            ("2015, 10 degree", "2015_10"),
            ("2_Degree", "2"),
            ("4", "4"),
        ] {
            assert_eq!(stated_observer(text).as_deref(), Some(name), "{text}");
        }
        assert_eq!(illuminants("tone value increase curves A and B, D50 and D65").len(), 2);
    }

    #[test]
    fn kinds_are_recognised() {
        assert_eq!(MeasuredKind::of("TRANSMISSIVE"), Some(MeasuredKind::Transmittance));
        assert_eq!(MeasuredKind::of("Spectrum_Reflectance"), Some(MeasuredKind::Reflectance));
        assert_eq!(MeasuredKind::of("EMISSION_FLASH"), Some(MeasuredKind::Emission));
        assert_eq!(MeasuredKind::of("other"), None);
    }
}
