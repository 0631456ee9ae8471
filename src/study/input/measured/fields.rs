//! Meaning of the fields of a table with one row a sample, by their names: CGATS, and spreadsheets
//! of that form.

use super::MeasuredCondition;
use super::sample::{MeasuredFile, MeasuredSample, SampleContent, SpectralCell, StatedViewing, Written};
use super::words::{self, MeasuredGeometry, MeasuredKind};
use crate::material::text_table::number;

/// Wavelengths that the name of a field may give, nm.
const FIELD_NM: std::ops::RangeInclusive<f64> = 200.0..=2600.0;

/// What a file declares for all its samples.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Declared {
    /// Spectral content of the instrument's light.
    pub condition: Option<MeasuredCondition>,
    /// Directions, where one is stated; with several the sample's name decides.
    pub geometries: Vec<MeasuredGeometry>,
    /// Reflected, transmitted or emitted.
    pub kind: MeasuredKind,
    /// Value of a perfect white.
    pub white: Option<f64>,
    /// Conditions of colours.
    pub viewing: StatedViewing,
}

/// A field that holds a value of a spectrum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BandField {
    /// Wavelength, nm.
    nm: f64,
    condition: Option<MeasuredCondition>,
    kind: MeasuredKind,
    white: Option<f64>,
}

/// Words beside the wavelength in the name of a field.
const BAND_WORDS: [&str; 20] = [
    "nm",
    "spec",
    "spectral",
    "spectrum",
    "r",
    "refl",
    "reflectance",
    "reflection",
    "s",
    "wl",
    "wavelength",
    "lambda",
    "pct",
    "percent",
    "%",
    "dec",
    "factor",
    "t",
    "trans",
    "transmittance",
];

/// The band that a name stands for: `SPEC_400`, `nm400`, `NM_400`, `400_NM`, `R_400`,
/// `SPECTRAL_NM400`, `SPECTRAL_PCT_400`, `M1_SPEC_400`, `400`.
pub fn band(name: &str) -> Option<BandField> {
    let lower = name.trim().to_lowercase();
    let (condition, rest) = condition_of_field(&lower);
    let mut found = None;
    let mut parts: Vec<&str> = Vec::new();
    let mut rest = rest;
    while let Some(first) = rest.chars().next() {
        let is_number = |c: char| c.is_ascii_digit() || c == '.';
        if first.is_ascii_digit() {
            let (digits, after) = rest.split_at(rest.find(|c| !is_number(c)).unwrap_or(rest.len()));
            let nm: f64 = digits.parse().ok()?;
            if found.replace(nm).is_some() {
                return None;
            }
            rest = after;
        } else if first.is_alphabetic() {
            let (word, after) = rest.split_at(rest.find(|c: char| !c.is_alphabetic()).unwrap_or(rest.len()));
            parts.push(word);
            rest = after;
        } else {
            let (mark, after) = rest.split_at(first.len_utf8());
            if mark == "%" {
                parts.push(mark);
            }
            rest = after;
        }
    }
    let nm = found.filter(|nm| FIELD_NM.contains(nm))?;
    // `SPECTRALNM` in one word
    let known = |word: &&str| {
        BAND_WORDS.contains(word) || ["spectralnm", "spectralpct", "spectraldec", "specnm"].contains(word)
    };
    if !parts.iter().all(known) {
        return None;
    }
    let has = |all: &[&str]| parts.iter().any(|word| all.contains(word));
    let kind = if has(&["t", "trans", "transmittance"]) {
        MeasuredKind::Transmittance
    } else {
        MeasuredKind::Reflectance
    };
    let white = if has(&["pct", "percent", "%", "spectralpct"]) {
        Some(100.0)
    } else if has(&["dec", "factor", "spectraldec"]) {
        Some(1.0)
    } else {
        None
    };
    Some(BandField { nm, condition, kind, white })
}

/// The condition at the start or the end of a field's name, and the rest of it.
fn condition_of_field(lower: &str) -> (Option<MeasuredCondition>, &str) {
    for condition in MeasuredCondition::ALL {
        let name = condition.name().to_lowercase();
        let separates = |c: char| !c.is_alphanumeric();
        if let Some(rest) = lower.strip_prefix(&name).filter(|rest| rest.starts_with(separates)) {
            return (Some(condition), rest);
        }
        if let Some(rest) = lower.strip_suffix(&name).filter(|rest| rest.ends_with(separates)) {
            return (Some(condition), rest);
        }
    }
    (None, lower)
}

/// A name without case and marks: `SAMPLE_ID`, `SampleID` and `Sample ID` are one.
fn bare(name: &str) -> String {
    name.chars().filter(|c| c.is_alphanumeric()).collect::<String>().to_uppercase()
}

/// Fields that name a sample, by rank.
const NAMES: [&[&str]; 3] = [
    &[
        "SAMPLENAME",
        "NAME",
        "PATCHNAME",
        "COLORNAME",
        "COLOURNAME",
        "SAMPLE",
        "PATCH",
        "LABEL",
        "COLOR",
        "COLOUR",
    ],
    &["SAMPLEID", "ID", "SAMPLENO", "SAMPLENUMBER", "PATCHID", "INDEX", "NO", "NR"],
    &["SAMPLELOC", "SAMPLELOCATION", "LOC", "LOCATION", "STRING"],
];

/// Groups of device values.
const DEVICES: [&[&str]; 6] = [
    &["CMYKC", "CMYKM", "CMYKY", "CMYKK"],
    &["C", "M", "Y", "K"],
    &["CYAN", "MAGENTA", "YELLOW", "BLACK"],
    &["CMYC", "CMYM", "CMYY"],
    &["RGBR", "RGBG", "RGBB"],
    &["R", "G", "B"],
];

/// Groups of L*, a*, b*.
const LABS: [[&str; 3]; 4] = [
    ["LABL", "LABA", "LABB"],
    ["CIELABL", "CIELABA", "CIELABB"],
    ["LSTAR", "ASTAR", "BSTAR"],
    ["L", "A", "B"],
];

/// Groups of X, Y, Z.
const XYZS: [[&str; 3]; 3] = [["XYZX", "XYZY", "XYZZ"], ["CIEXYZX", "CIEXYZY", "CIEXYZZ"], ["X", "Y", "Z"]];

/// A wavelength in one field, and the value at it in another.
#[derive(Clone, Copy)]
struct PairField {
    /// Places in the row.
    nm: usize,
    value: usize,
    /// Value of a perfect white, if the field's name declares it.
    white: Option<f64>,
}

/// Where in a row the meanings are.
pub struct FieldTable {
    names: Vec<usize>,
    device: Vec<usize>,
    lab: Option<[usize; 3]>,
    xyz: Option<[usize; 3]>,
    bands: Vec<(usize, BandField)>,
    pairs: Vec<PairField>,
    condition: Option<usize>,
    geometry: Option<usize>,
}

impl FieldTable {
    /// The meanings of fields.
    pub fn new(fields: &[String]) -> Self {
        let names_bare: Vec<String> = fields.iter().map(|name| bare(name)).collect();
        let place = |name: &str| names_bare.iter().position(|other| other == name);
        let all = |group: &[&str]| group.iter().map(|name| place(name)).collect::<Option<Vec<usize>>>();
        let names = NAMES.iter().filter_map(|rank| rank.iter().find_map(|name| place(name))).collect();
        let mut device = DEVICES.iter().find_map(|group| all(group)).unwrap_or_default();
        if device.is_empty() {
            // inks beyond four: `5CLR_1`
            let is_ink = |name: &&String| {
                name.split_once("CLR").is_some_and(|(n, i)| [n, i].iter().all(|d| d.parse::<u8>().is_ok()))
            };
            device = names_bare.iter().enumerate().filter(|(_, name)| is_ink(name)).map(|(i, _)| i).collect();
        }
        let three = |places: Vec<usize>| [places[0], places[1], places[2]];
        let lab = LABS.iter().find_map(|group| all(group)).map(three);
        let xyz = XYZS.iter().find_map(|group| all(group)).map(three);
        let bands = fields.iter().enumerate().filter_map(|(i, name)| Some((i, band(name)?))).collect();
        let columns = |known: &[&str]| -> Vec<usize> {
            (0..fields.len()).filter(|&i| known.contains(&names_bare[i].as_str())).collect()
        };
        let wavelengths = columns(&["SPECTRALNM", "WAVELENGTH", "WAVELENGTHNM", "NM"]);
        let values =
            columns(&["SPECTRALPCT", "SPECTRALDEC", "SPECTRALVALUE", "REFLECTANCE", "SPECTRALREFLECTANCE"]);
        let white = |i: usize| match names_bare[i].as_str() {
            "SPECTRALPCT" => Some(100.0),
            "SPECTRALDEC" => Some(1.0),
            _ => None,
        };
        let pair = |(nm, value): (usize, usize)| PairField { nm, value, white: white(value) };
        let pairs = wavelengths.into_iter().zip(values).map(pair).collect();
        let has = |word: &str| names_bare.iter().position(|name| name.contains(word));
        let condition = has("CONDITION").or(place("FILTER")).or(place("MEASUREMENTMODE")).or(place("MODE"));
        Self { names, device, lab, xyz, bands, pairs, condition, geometry: has("GEOMETRY") }
    }

    /// Whether rows under these fields hold a spectrum or a colour.
    pub fn is_measured(&self) -> bool {
        self.has_spectra() || self.lab.is_some() || self.xyz.is_some()
    }

    /// Whether rows under these fields hold spectra.
    pub fn has_spectra(&self) -> bool {
        !self.bands.is_empty() || !self.pairs.is_empty()
    }

    /// Number of fields before the first value of a spectrum or a colour.
    pub fn names_end(&self) -> usize {
        let bands = self.bands.iter().map(|(i, _)| *i);
        let pairs = self.pairs.iter().map(|pair| pair.nm.min(pair.value));
        let colours = self.lab.into_iter().chain(self.xyz).flatten();
        bands.chain(pairs).chain(colours).min().unwrap_or(0)
    }

    /// Number of fields whose names are wavelengths.
    pub fn bands(&self) -> usize {
        self.bands.len()
    }

    /// Takes one row in: its spectra, or its colour. The cells are as many as the fields.
    pub fn take(&self, cells: &[Written], declared: &Declared, into: &mut MeasuredFile) {
        let names: Vec<String> = self.names.iter().map(|&i| cells[i].text.trim().to_owned()).collect();
        let device: Option<Vec<f64>> = self.device.iter().map(|&i| number(&cells[i].text, true)).collect();
        let text = |place: Option<usize>| place.map(|i| cells[i].text.as_str()).unwrap_or_default();
        let geometry =
            words::geometries(text(self.geometry)).into_iter().next().or_else(|| declared.geometry(&names));
        let plain = MeasuredSample {
            names,
            device: device.unwrap_or_default(),
            condition: words::conditions(text(self.condition)).first().copied().or(declared.condition),
            geometry,
            kind: declared.kind,
            white: declared.white,
            content: SampleContent::Spectrum(Vec::new()),
        };
        let mut conditions: Vec<Option<MeasuredCondition>> = Vec::new();
        for (_, band) in &self.bands {
            if !conditions.contains(&band.condition) {
                conditions.push(band.condition);
            }
        }
        for condition in conditions {
            let bands = self.bands.iter().filter(|(_, band)| band.condition == condition);
            let spectrum = bands
                .clone()
                .map(|(i, band)| SpectralCell { nm: Some(band.nm), value: cells[*i].clone() })
                .collect();
            let first = bands.map(|(_, band)| *band).next();
            let kind = first.map(|band| band.kind).filter(|kind| *kind != MeasuredKind::Reflectance);
            into.samples.push(MeasuredSample {
                condition: condition.or(plain.condition),
                kind: kind.unwrap_or(plain.kind),
                white: first.and_then(|band| band.white).or(plain.white),
                content: SampleContent::Spectrum(spectrum),
                ..plain.clone()
            });
        }
        if let Some(first) = self.pairs.first() {
            let cell = |pair: &PairField| SpectralCell {
                nm: cells[pair.nm].value(),
                value: cells[pair.value].clone(),
            };
            let spectrum: Vec<SpectralCell> = self.pairs.iter().map(cell).collect();
            // with one pair a row, the rows of a sample are its spectrum
            let same = |known: &&mut MeasuredSample| {
                let is_spectrum = matches!(known.content, SampleContent::Spectrum(_));
                is_spectrum && known.names == plain.names && known.condition == plain.condition
            };
            let known = into.samples.iter_mut().rev().find(same).filter(|_| self.pairs.len() == 1);
            match known.map(|known| &mut known.content) {
                Some(SampleContent::Spectrum(rows)) => rows.extend(spectrum),
                _ => into.samples.push(MeasuredSample {
                    white: first.white.or(plain.white),
                    content: SampleContent::Spectrum(spectrum),
                    ..plain.clone()
                }),
            }
        }
        if let Some(lab) = self.lab {
            let content = SampleContent::Lab(lab.map(|i| cells[i].clone()), declared.viewing.clone());
            into.samples.push(MeasuredSample { content, ..plain });
        } else if let Some(xyz) = self.xyz {
            let content = SampleContent::Xyz(xyz.map(|i| cells[i].clone()), declared.viewing.clone());
            into.samples.push(MeasuredSample { content, ..plain });
        }
    }
}

impl Declared {
    /// The geometry of a sample: the only one that the file states, or that of the sample's name.
    fn geometry(&self, names: &[String]) -> Option<MeasuredGeometry> {
        if let [one] = &self.geometries[..] {
            return Some(one.clone());
        }
        let mut found = words::geometries(&names.join(", "));
        if found.len() == 1 { found.pop() } else { None }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_fields_give_their_wavelengths() {
        for name in [
            "SPEC_400",
            "SPECTRAL_NM400",
            "SPECTRAL_NM_400",
            "SPECTRAL_400",
            "nm400",
            "NM_400",
            "400_NM",
            "400nm",
            "R_400",
            "R400",
            "400",
            "400.0",
            "SPECTRAL_PCT_400",
            "SPECTRAL_DEC400",
            "M1_SPEC_400",
            "spec_400_m2",
            "R% 400",
            "Reflectance 400 nm",
        ] {
            assert_eq!(band(name).map(|band| band.nm), Some(400.0), "{name}");
        }
        for name in [
            "LAB_L",
            "RGB_R",
            "CMYK_C",
            "SAMPLE_ID",
            "5CLR_1",
            "D50_400",
            "XYZ_X",
            "SPECTRAL_NM",
            "12",
            "STDEV_400",
        ] {
            assert_eq!(band(name), None, "{name}");
        }
        let percent = band("SPECTRAL_PCT_400").unwrap();
        assert_eq!((percent.white, percent.kind), (Some(100.0), MeasuredKind::Reflectance));
        assert_eq!(band("M1_SPEC_400").unwrap().condition, Some(MeasuredCondition::M1));
        assert_eq!(band("T_400").unwrap().kind, MeasuredKind::Transmittance);
    }
}
