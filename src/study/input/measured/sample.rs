//! Samples of a file of measurements, as far as the file declares what they are. Cells stay text
//! until a sample is chosen, so that a fault in another one blocks nothing.

use super::MeasuredCondition;
use super::words::{MeasuredGeometry, MeasuredKind};
use crate::appearance::viewing::{Summation, Viewing};
use crate::material::text_table::{TextLine, number};

/// A cell of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Written {
    /// Its text.
    pub text: String,
    /// Its line, from 1.
    pub line: usize,
}

impl Written {
    /// A cell of a line.
    pub(super) fn of(line: &TextLine, cell: &str) -> Self {
        Self { text: cell.to_owned(), line: line.line }
    }
}

impl Written {
    /// Its number; nothing for text.
    pub fn value(&self) -> Option<f64> {
        number(&self.text, true)
    }
}

/// One value of a spectrum.
#[derive(Clone, Debug, PartialEq)]
pub struct SpectralCell {
    /// Wavelength, nm, if it is a number.
    pub nm: Option<f64>,
    /// The value as written.
    pub value: Written,
}

/// Conditions of a colour, as a file names them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StatedViewing {
    /// Names of illuminants; a colour has one.
    pub illuminants: Vec<String>,
    /// Names of observers; a colour has one.
    pub observers: Vec<String>,
}

impl StatedViewing {
    /// The conditions.
    ///
    /// # Errors
    /// None or several are stated, or names that are unknown.
    pub fn viewing(&self, summation: Summation) -> Result<Viewing, String> {
        let (Some(illuminant), Some(observer)) = (self.illuminants.first(), self.observers.first()) else {
            return Err("its illuminant and observer are not stated".to_owned());
        };
        if self.illuminants.len() > 1 || self.observers.len() > 1 {
            let all = [self.illuminants.join(" and "), self.observers.join(" and ")];
            return Err(format!("it states several conditions: illuminant {}, observer {}", all[0], all[1]));
        }
        Viewing::new(illuminant, observer, summation).map_err(|error| error.to_string())
    }
}

/// What was measured of a sample.
#[derive(Clone, Debug, PartialEq)]
pub enum SampleContent {
    /// A spectrum.
    Spectrum(Vec<SpectralCell>),
    /// L*, a*, b*.
    Lab([Written; 3], StatedViewing),
    /// X, Y, Z.
    Xyz([Written; 3], StatedViewing),
}

impl SampleContent {
    /// Whether it is a colour, which holds less than a spectrum.
    pub fn is_colour(&self) -> bool {
        !matches!(self, Self::Spectrum(_))
    }
}

/// One measurement of one sample.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredSample {
    /// Its names in the file, the most telling first: name, number, place on the chart.
    pub names: Vec<String>,
    /// Its amounts of the inks, or other device values, in the file's order.
    pub device: Vec<f64>,
    /// Spectral content of the instrument's light.
    pub condition: Option<MeasuredCondition>,
    /// Directions of light and view.
    pub geometry: Option<MeasuredGeometry>,
    /// Reflected, transmitted or emitted.
    pub kind: MeasuredKind,
    /// Value of a perfect white, if the file declares it.
    pub white: Option<f64>,
    /// Its values.
    pub content: SampleContent,
}

impl MeasuredSample {
    /// Its most telling name.
    pub fn name(&self) -> &str {
        self.names.iter().find(|name| !name.is_empty()).map_or("", String::as_str)
    }

    /// Whether two measurements are of one sample: they share names and device values.
    pub fn is_same_sample(&self, other: &Self) -> bool {
        let named = self.names.iter().any(|name| !name.is_empty()) || !self.device.is_empty();
        named && self.names == other.names && self.device == other.device
    }
}

/// A file of measurements.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeasuredFile {
    /// Its samples in their order.
    pub samples: Vec<MeasuredSample>,
    /// What a reader should know of it.
    pub remarks: Vec<String>,
}
