//! Spectra that someone has measured: CSV, CxF3 or CGATS.17.

use crate::material::columns::{Columns, ColumnsError};
use crate::numerics::files;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Reflectance factors (white diffuser: 1) against wavelength, nm, rising.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct MeasuredSpectrum {
    /// The file's name, and which sample of it.
    pub source: String,
    /// (wavelength in nm, reflectance factor) rows.
    pub rows: Vec<[f64; 2]>,
}

/// A file without a usable spectrum.
#[derive(Debug, Error)]
pub enum MeasuredError {
    /// The file cannot be read.
    #[error("{}: {source}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// Why not.
        source: std::io::Error,
    },
    /// The table has faults.
    #[error(transparent)]
    Table(#[from] ColumnsError),
    /// The file has no spectrum, or one that makes no sense.
    #[error("{}: {reason}", path.display())]
    NoSpectrum {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
}

/// Reflectance factors above this are percentages.
const LARGEST_FACTOR: f64 = 3.0;
/// Noise of an instrument at its black; less is no reflectance factor.
const LEAST_FACTOR: f64 = -0.1;
const CXF: &str = "http://colorexchangeformat.com/CxF3-core";

impl MeasuredSpectrum {
    /// Reads the first spectrum of a file: `.cxf` and `.mxf` as CxF3, files that begin with CGATS, CTI or SPECT as
    /// CGATS.17, all others as a table with the columns `wavelength_nm` and `reflectance`. Values in percent are divided
    /// by 100.
    ///
    /// # Errors
    /// The file cannot be read, has no spectrum, or one with wavelengths that do not rise or values that are no reflectance
    /// factors.
    pub fn read(path: &Path) -> Result<Self, MeasuredError> {
        let unreadable = |source| MeasuredError::Unreadable { path: path.into(), source };
        let bytes = files::read_bytes(path, files::TABLE).map_err(unreadable)?;
        let text = String::from_utf8_lossy(&bytes);
        let no_spectrum = |reason: String| MeasuredError::NoSpectrum { path: path.into(), reason };
        let start = text.trim_start_matches('\u{feff}').trim_start();
        let rows = if start.starts_with('<') {
            from_cxf(&text).map_err(no_spectrum)?
        } else if ["CGATS", "CTI", "SPECT", "IT8"].iter().any(|word| start.starts_with(word)) {
            from_cgats(&text).map_err(no_spectrum)?
        } else {
            from_table(&Columns::read(path)?).map_err(no_spectrum)?
        };
        let source = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        Self::checked(source, rows).map_err(no_spectrum)
    }

    fn checked(source: String, mut rows: Vec<[f64; 2]>) -> Result<Self, String> {
        if rows.len() < 2 {
            return Err(format!("{} rows; a spectrum has at least 2", rows.len()));
        }
        if let Some([nm, value]) = rows.iter().find(|row| row.iter().any(|x| !x.is_finite())) {
            return Err(format!("{value} at {nm} nm is no number"));
        }
        if let Some(pair) = rows.windows(2).find(|pair| pair[1][0] <= pair[0][0]) {
            return Err(format!("wavelengths do not rise: {} nm after {} nm", pair[1][0], pair[0][0]));
        }
        let in_percent = rows.iter().any(|row| row[1] > LARGEST_FACTOR);
        let unit = if in_percent { 100.0 } else { 1.0 };
        let allowed = LEAST_FACTOR..=LARGEST_FACTOR;
        if let Some([nm, value]) = rows.iter().find(|row| !allowed.contains(&(row[1] / unit))) {
            let white = "a perfect white has 1, or 100 in percent";
            return Err(format!("{value} at {nm} nm is no reflectance factor; {white}"));
        }
        if !in_percent && rows.iter().all(|row| row[1] > 1.0) {
            return Err("all values are above 1, a perfect white; write percentages as shares of 1".into());
        }
        rows.iter_mut().for_each(|row| row[1] /= unit);
        Ok(Self { source, rows })
    }

    /// First and last wavelength, nm.
    pub fn range_nm(&self) -> [f64; 2] {
        [self.rows[0][0], self.rows[self.rows.len() - 1][0]]
    }

    /// The value at a wavelength, linear between rows; `None` outside.
    pub fn at(&self, nm: f64) -> Option<f64> {
        let [lo, hi] = self.range_nm();
        if !(lo..=hi).contains(&nm) {
            return None;
        }
        let after = self.rows.partition_point(|row| row[0] < nm).clamp(1, self.rows.len() - 1);
        let ([x0, y0], [x1, y1]) = (self.rows[after - 1], self.rows[after]);
        Some(y0 + (nm - x0) / (x1 - x0) * (y1 - y0))
    }
}

fn from_table(columns: &Columns) -> Result<Vec<[f64; 2]>, String> {
    let need = |names: &[&str]| {
        let found = columns.find(names);
        found.ok_or_else(|| format!("column {} is missing; found {}", names[0], columns.names.join(", ")))
    };
    let (nm, value) = (need(&["wavelength_nm", "wavelength", "nm"])?, need(&["reflectance", "r", "value"])?);
    Ok(columns.rows.iter().map(|row| [nm, value].map(|i| row[i].unwrap_or(f64::NAN))).collect())
}

/// The first object with a reflectance spectrum.
fn from_cxf(text: &str) -> Result<Vec<[f64; 2]>, String> {
    let document =
        roxmltree::Document::parse(text.trim_start_matches('\u{feff}')).map_err(|e| e.to_string())?;
    let named = |name: &'static str| document.descendants().filter(move |n| n.has_tag_name((CXF, name)));
    let spectrum = named("ReflectanceSpectrum").next().ok_or("no ReflectanceSpectrum of CxF3")?;
    let wanted = spectrum.attribute("ColorSpecification");
    let belongs = |node: &roxmltree::Node| {
        let specification = node.ancestors().find(|n| n.has_tag_name((CXF, "ColorSpecification")));
        wanted.is_none() || specification.and_then(|s| s.attribute("Id")) == wanted
    };
    let range = named("WavelengthRange").find(belongs);
    let number = |text: Option<&str>| text.and_then(|t| t.trim().parse::<f64>().ok());
    let start = number(spectrum.attribute("StartWL")).or(range.and_then(|r| number(r.attribute("StartWL"))));
    let step = range.and_then(|r| number(r.attribute("Increment")));
    let (Some(start), Some(step)) = (start, step) else {
        return Err("the spectrum's StartWL or its WavelengthRange with Increment is missing".into());
    };
    let words = spectrum.text().unwrap_or("").split_whitespace().enumerate();
    words.map(|(i, word)| Ok([start + step * i as f64, parsed(word)?])).collect()
}

/// The first set with fields SPEC_nnn (or nmnnn).
fn from_cgats(text: &str) -> Result<Vec<[f64; 2]>, String> {
    let between = |from: &str, to: &str| -> Option<Vec<&str>> {
        let lines = text.lines().map(str::trim);
        Some(lines.skip_while(|l| *l != from).skip(1).take_while(|l| *l != to).collect())
            .filter(|l: &Vec<_>| !l.is_empty())
    };
    let fields = between("BEGIN_DATA_FORMAT", "END_DATA_FORMAT").ok_or("no BEGIN_DATA_FORMAT")?;
    let fields: Vec<&str> = fields.iter().flat_map(|line| line.split_whitespace()).collect();
    let data = between("BEGIN_DATA", "END_DATA").ok_or("no BEGIN_DATA")?;
    let cells = words(data[0]);
    if cells.len() != fields.len() {
        return Err(format!("{} values in the first set under {} fields", cells.len(), fields.len()));
    }
    let band = |name: &str| {
        let digits =
            name.strip_prefix("SPEC_").or(name.strip_prefix("SPECTRAL_NM")).or(name.strip_prefix("nm"))?;
        digits.trim_start_matches('_').parse::<f64>().ok()
    };
    let bands = fields.iter().zip(&cells).filter_map(|(name, cell)| Some((band(name)?, cell)));
    let rows = bands.map(|(nm, cell)| Ok([nm, parsed(cell)?])).collect::<Result<Vec<_>, String>>()?;
    if rows.is_empty() { Err("no fields SPEC_nnn".into()) } else { Ok(rows) }
}

/// Words of a line; quotes keep blanks together.
fn words(line: &str) -> Vec<String> {
    let pieces = line.split('"').enumerate();
    let of = |(i, piece): (usize, &str)| -> Vec<String> {
        if i % 2 == 1 {
            vec![piece.to_owned()]
        } else {
            piece.split_whitespace().map(str::to_owned).collect()
        }
    };
    pieces.flat_map(of).collect()
}

fn parsed(word: &str) -> Result<f64, String> {
    word.parse().map_err(|_| format!("found {word:?} where a number is needed"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    fn read(text: &str) -> Result<MeasuredSpectrum, MeasuredError> {
        let mut file = tempfile::NamedTempFile::new().unwrap();
        file.write_all(text.as_bytes()).unwrap();
        MeasuredSpectrum::read(file.path())
    }

    #[test]
    fn the_same_spectrum_in_four_files() {
        let csv = "wavelength_nm,reflectance\n400,0.25\n410,0.5\n";
        let excel = "Wavelength;Reflectance\r\n400;25,0\r\n410;50,0\r\n";
        let cxf = format!(
            "<?xml version=\"1.0\"?><c:CxF xmlns:c=\"{CXF}\"><c:Resources><c:ObjectCollection><c:Object><c:ColorValues>\
             <c:ReflectanceSpectrum ColorSpecification=\"b\" StartWL=\"400\">0.25 0.5</c:ReflectanceSpectrum>\
             </c:ColorValues></c:Object></c:ObjectCollection><c:ColorSpecificationCollection>\
             <c:ColorSpecification Id=\"a\"><c:WavelengthRange StartWL=\"380\" Increment=\"5\"/></c:ColorSpecification>\
             <c:ColorSpecification Id=\"b\"><c:WavelengthRange StartWL=\"400\" Increment=\"10\"/></c:ColorSpecification>\
             </c:ColorSpecificationCollection></c:Resources></c:CxF>"
        );
        let cgats = "CGATS.17\nBEGIN_DATA_FORMAT\nSAMPLE_NAME LAB_L SPEC_400 SPEC_410\nEND_DATA_FORMAT\nBEGIN_DATA\n\"my ink\" 50 25.0 50.0\nEND_DATA\n";
        for text in [csv, excel, &cxf, cgats] {
            assert_eq!(read(text).unwrap().rows, vec![[400.0, 0.25], [410.0, 0.5]], "{text}");
        }
        let spectrum = read(csv).unwrap();
        assert_eq!((spectrum.at(405.0), spectrum.at(399.0)), (Some(0.375), None));
    }

    #[test]
    fn files_without_a_spectrum_are_refused_with_their_reason() {
        let reason = |text: &str| read(text).unwrap_err().to_string();
        assert!(reason("wavelength_nm,lab\n400,1\n").contains("column reflectance is missing"));
        assert!(reason("wavelength_nm,reflectance\n410,1\n400,1\n").contains("do not rise"));
        assert!(reason("wavelength_nm,reflectance\n410,\n420,1\n").contains("no number"));
        assert!(reason("<CxF/>").contains("no ReflectanceSpectrum"));
        assert!(reason("wavelength_nm,reflectance\n400,-0.5\n420,0.5\n").contains("-0.5 at 400 nm"));
        assert!(reason("wavelength_nm,reflectance\n400,30000\n420,0.5\n").contains("30000 at 400 nm"));
        assert!(reason("wavelength_nm,reflectance\n400,1.5\n420,2.5\n").contains("above 1"));
        let short =
            "CGATS.17\nBEGIN_DATA_FORMAT\nSPEC_400 SPEC_500\nEND_DATA_FORMAT\nBEGIN_DATA\n1\nEND_DATA\n";
        assert!(reason(short).contains("1 values in the first set under 2 fields"));
        assert!(
            reason("CGATS.17\nBEGIN_DATA_FORMAT\nRGB_R\nEND_DATA_FORMAT\nBEGIN_DATA\n1\nEND_DATA\n")
                .contains("SPEC_nnn")
        );
        assert!(MeasuredSpectrum::read(Path::new("none.cxf")).is_err());
    }
}
