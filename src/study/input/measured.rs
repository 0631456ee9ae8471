//! Measured spectra: CSV, CxF3 or CGATS.17.

use super::patches::{self, Taken, place};
use crate::appearance::colour::{Colorimeter, Colour, ColourError};
use crate::appearance::tristimulus::TABLE_RANGE_NM;
use crate::appearance::viewing::Viewing;
use crate::material::columns::{Columns, micrometres};
use crate::numerics::files;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Value of a perfect white in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum MeasuredUnit {
    /// White is 1.
    Factor,
    /// White is 100.
    Percent,
}

/// Reflectance factors (white diffuser: 1) against wavelength, nm, increasing.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct MeasuredSpectrum {
    /// Name of the file, and of the sample if it has several.
    pub source: String,
    /// (wavelength in nm, reflectance factor) rows.
    pub rows: Vec<[f64; 2]>,
    /// Number of samples in the file.
    #[serde(default)]
    pub patches: usize,
}

/// Larger values are percentages; values between 1 and this are ambiguous, so that the unit is
/// required.
const LARGEST_FACTOR: f64 = 3.0;
/// Noise of an instrument at black; smaller values are not reflectance factors.
const LEAST_FACTOR: f64 = -0.1;

impl MeasuredSpectrum {
    /// Reads the first spectrum of a file, or that of the sample named `patch`: `.cxf` and `.mxf`
    /// as CxF3, files that begin with CGATS, CTI or SPECT as CGATS.17, all others as a table with
    /// the columns `wavelength_nm` and `reflectance`. Percentages are divided by 100, if `unit`
    /// says so or if they cannot be factors.
    ///
    /// # Errors
    /// The file cannot be read, has no spectrum or none of that name, its wavelengths do not
    /// increase, its values are not reflectance factors, or they are ambiguous without a unit.
    pub fn read(path: &Path, patch: Option<&str>, unit: Option<MeasuredUnit>) -> Result<Self, String> {
        let named = |reason: String| format!("{}: {reason}", path.display());
        let bytes = files::read_bytes(path, files::TABLE).map_err(|error| named(error.to_string()))?;
        let text = String::from_utf8_lossy(&bytes);
        let start = text.trim_start_matches('\u{feff}').trim_start();
        let taken = if start.starts_with('<') {
            patches::from_cxf(&text, patch)
        } else if ["CGATS", "CTI", "SPECT", "IT8"].iter().any(|word| start.starts_with(word)) {
            patches::from_cgats(&text, patch)
        } else {
            place(&[], patch).map_err(named)?;
            let columns = Columns::read(path).map_err(|error| error.to_string())?;
            let [nm, value] = places(&columns).map_err(named)?;
            let (nm, values) = (columns.wavelengths_nm(nm), columns.numbers(value));
            let rows = nm.and_then(|nm| Ok(nm.into_iter().zip(values?).map(<[f64; 2]>::from).collect()));
            Ok(Taken { rows: rows.map_err(|error| error.to_string())?, names: vec![String::new()], place: 0 })
        };
        let file = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        let Taken { rows, names, place } = taken.map_err(named)?;
        let source = match (names.len(), &names[place]) {
            (1, _) => file,
            (of, name) if name.is_empty() => format!("{file}: unnamed, sample {} of {of}", place + 1),
            (of, name) => format!("{file}: {name:?}, sample {} of {of}", place + 1),
        };
        Ok(Self { patches: names.len(), ..Self::checked(source, rows, unit).map_err(named)? })
    }

    fn checked(source: String, mut rows: Vec<[f64; 2]>, unit: Option<MeasuredUnit>) -> Result<Self, String> {
        if rows.len() < 2 {
            return Err(format!("{} rows; a spectrum has at least 2", rows.len()));
        }
        if let Some([nm, value]) = rows.iter().find(|row| row.iter().any(|x| !x.is_finite())) {
            return Err(format!("{value} at {nm} nm is not a number"));
        }
        if let Some(largest) = micrometres(rows.iter().map(|row| row[0])) {
            return Err(format!(
                "the largest wavelength is {largest}: these look like µm; write them in nm, times 1000"
            ));
        }
        if let Some(pair) = rows.windows(2).find(|pair| pair[1][0] <= pair[0][0]) {
            return Err(format!("wavelengths do not increase: {} nm after {} nm", pair[1][0], pair[0][0]));
        }
        let white = white(&rows, unit)?;
        let allowed = LEAST_FACTOR..=LARGEST_FACTOR;
        if let Some([nm, value]) = rows.iter().find(|row| !allowed.contains(&(row[1] / white))) {
            let white = "a perfect white is 1, or 100 in percent";
            return Err(format!("{value} at {nm} nm is not a reflectance factor; {white}"));
        }
        rows.iter_mut().for_each(|row| row[1] /= white);
        Ok(Self { source, rows, patches: 1 })
    }

    /// First and last wavelength, nm.
    pub fn range_nm(&self) -> [f64; 2] {
        [self.rows[0][0], self.rows[self.rows.len() - 1][0]]
    }

    /// The value at a wavelength, linear between rows; `None` outside their range.
    pub fn at(&self, nm: f64) -> Option<f64> {
        let [lo, hi] = self.range_nm();
        if !(lo..=hi).contains(&nm) {
            return None;
        }
        let after = self.rows.partition_point(|row| row[0] < nm).clamp(1, self.rows.len() - 1);
        let ([x0, y0], [x1, y1]) = (self.rows[after - 1], self.rows[after]);
        Some(y0 + (nm - x0) / (x1 - x0) * (y1 - y0))
    }

    /// The colour, summed over the spectrum's own rows within a range of wavelengths, nm. At an end
    /// of the range without a row the value is interpolated. The steps of a study are no measure of
    /// how fine a spectrum was measured: a steep edge between them would be lost.
    ///
    /// # Errors
    /// The rows within the range carry no colour.
    pub fn colour(&self, viewing: &Viewing, range_nm: [f64; 2]) -> Result<Colour, ColourError> {
        let own = self.range_nm();
        let from = range_nm[0].max(own[0]).max(TABLE_RANGE_NM[0]);
        let to = range_nm[1].min(own[1]).min(TABLE_RANGE_NM[1]);
        let mut rows: Vec<[f64; 2]> =
            self.rows.iter().copied().filter(|[nm, _]| (from..=to).contains(nm)).collect();
        if rows.first().is_none_or(|[nm, _]| *nm > from) {
            rows.splice(0..0, self.at(from).map(|value| [from, value]));
        }
        if rows.last().is_none_or(|[nm, _]| *nm < to) {
            rows.extend(self.at(to).map(|value| [to, value]));
        }
        let nm: Vec<f64> = rows.iter().map(|row| row[0]).collect();
        let values: Vec<f64> = rows.iter().map(|row| row[1]).collect();
        Colorimeter::under(&nm, viewing)?.colour(&values)
    }
}

/// Value of a perfect white in these rows.
fn white(rows: &[[f64; 2]], unit: Option<MeasuredUnit>) -> Result<f64, String> {
    let largest = rows.iter().map(|row| row[1]).fold(f64::NEG_INFINITY, f64::max);
    match unit {
        Some(MeasuredUnit::Factor) => Ok(1.0),
        Some(MeasuredUnit::Percent) => Ok(100.0),
        None if largest > LARGEST_FACTOR => Ok(100.0),
        None if largest <= 1.0 => Ok(1.0),
        None => Err(format!(
            "the largest value is {largest}: a dark print in percent, or a factor above a perfect white; \
             say which by compare.unit = \"percent\" or \"factor\""
        )),
    }
}

/// Columns of the wavelengths and values.
fn places(columns: &Columns) -> Result<[usize; 2], String> {
    let need = |names: &[&str]| {
        let found = columns.find(names);
        found.ok_or_else(|| format!("column {} is missing; found {}", names[0], columns.names.join(", ")))
    };
    Ok([need(&["wavelength_nm", "wavelength", "nm"])?, need(&["reflectance", "r", "value"])?])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::patches::CXF;
    use std::io::Write;

    fn read(text: &str) -> Result<MeasuredSpectrum, String> {
        read_patch(text, None)
    }

    fn read_patch(text: &str, patch: Option<&str>) -> Result<MeasuredSpectrum, String> {
        let mut file = tempfile::NamedTempFile::new().unwrap();
        file.write_all(text.as_bytes()).unwrap();
        MeasuredSpectrum::read(file.path(), patch, None)
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
        let wider = read(&cxf.replace("Increment=\"10\"", "Increment=\"20\"")).unwrap();
        assert_eq!(wider.rows, vec![[400.0, 0.25], [420.0, 0.5]]);
        let spectrum = read(csv).unwrap();
        assert_eq!((spectrum.at(405.0), spectrum.at(399.0)), (Some(0.375), None));
    }

    /// A dark print in percent has no value that distinguishes it from factors: the unit is
    /// required.
    #[test]
    fn a_dark_print_in_percent_needs_its_unit() {
        let rows = |values: [f64; 2], unit| {
            let rows = vec![[400.0, values[0]], [410.0, values[1]]];
            MeasuredSpectrum::checked("dark.csv".into(), rows, unit).map(|m| [m.rows[0][1], m.rows[1][1]])
        };
        let (dark, some) = ([0.8, 2.9], Some);
        let asked = rows(dark, None).unwrap_err();
        assert!(asked.contains("2.9") && asked.contains("compare.unit = \"percent\""), "{asked}");
        assert_eq!(rows(dark, some(MeasuredUnit::Percent)).unwrap(), dark.map(|x| x / 100.0));
        assert_eq!(rows(dark, some(MeasuredUnit::Factor)).unwrap(), dark);
        assert_eq!(
            rows([0.2, 0.9], some(MeasuredUnit::Percent)).unwrap(),
            [0.2, 0.9].map(|x: f64| x / 100.0)
        );
        assert_eq!(rows([0.2, 1.0], None).unwrap(), [0.2, 1.0]);
        assert!(
            rows([20.0, 90.0], some(MeasuredUnit::Factor)).unwrap_err().contains("not a reflectance factor")
        );
    }

    #[test]
    fn of_several_samples_the_one_that_is_named_is_taken() {
        let cgats = "CGATS.17\nBEGIN_DATA_FORMAT\nSAMPLE_ID SAMPLE_NAME SPEC_400 SPEC_410\nEND_DATA_FORMAT\nBEGIN_DATA\n\
                     1 \"paper\" 90 91\n\n2 \"my ink\" 25 50\nEND_DATA\n";
        let object = |name: &str, values: &str| {
            format!(
                "<c:Object Name=\"{name}\" Id=\"{name} id\"><c:ReflectanceSpectrum StartWL=\"400\">{values}</c:ReflectanceSpectrum></c:Object>"
            )
        };
        let cxf = format!(
            "<c:CxF xmlns:c=\"{CXF}\">{}{}<c:WavelengthRange StartWL=\"400\" Increment=\"10\"/></c:CxF>",
            object("paper", "0.90 0.91"),
            object("my ink", "0.25 0.50"),
        );
        for text in [cgats, &cxf] {
            let [first, named] = [None, Some("my ink")].map(|patch| read_patch(text, patch).unwrap());
            assert_eq!((first.rows[0], named.rows[0]), ([400.0, 0.9], [400.0, 0.25]));
            assert!(first.source.ends_with(": \"paper\", sample 1 of 2"), "{}", first.source);
            assert!(named.source.ends_with(": \"my ink\", sample 2 of 2") && named.patches == 2);
            let none = read_patch(text, Some("ink")).unwrap_err().to_string();
            assert!(none.contains("no sample \"ink\"; found \"paper\", \"my ink\""), "{none}");
        }
        let table = read_patch("wavelength_nm,reflectance\n400,0.25\n410,0.5\n", Some("ink"));
        assert!(table.unwrap_err().to_string().contains("no names"));
    }

    #[test]
    fn files_without_a_spectrum_are_refused_with_their_reason() {
        let reason = |text: &str| read(text).unwrap_err().to_string();
        assert!(reason("wavelength_nm,lab\n400,1\n").contains("column reflectance is missing"));
        assert!(reason("wavelength_nm,reflectance\n410,1\n400,1\n").contains("do not increase"));
        assert!(
            reason("wavelength_nm,reflectance\n410,\n420,1\n")
                .contains("line 2, column reflectance: an empty cell")
        );
        assert!(reason("wavelength_nm,reflectance\n410,NaN\n420,1\n").contains("not a number"));
        assert!(reason("wavelength_nm,reflectance\n0.41,1\n0.42,1\n").contains("these look like µm"));
        assert!(reason("wavelength_nm,reflectance\n410,0,5\n").contains("(wavelength_nm;reflectance)"));
        assert!(reason("<CxF/>").contains("no ReflectanceSpectrum"));
        assert!(reason("wavelength_nm,reflectance\n400,-0.5\n420,0.5\n").contains("-0.5 at 400 nm"));
        assert!(reason("wavelength_nm,reflectance\n400,30000\n420,0.5\n").contains("30000 at 400 nm"));
        let short =
            "CGATS.17\nBEGIN_DATA_FORMAT\nSPEC_400 SPEC_500\nEND_DATA_FORMAT\nBEGIN_DATA\n1\nEND_DATA\n";
        assert!(reason(short).contains("1 values in set 1 under 2 fields"));
        assert!(
            reason("CGATS.17\nBEGIN_DATA_FORMAT\nRGB_R\nEND_DATA_FORMAT\nBEGIN_DATA\n1\nEND_DATA\n")
                .contains("SPEC_nnn")
        );
        assert!(MeasuredSpectrum::read(Path::new("none.cxf"), None, None).is_err());
    }
}
