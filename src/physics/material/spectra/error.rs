//! Errors of spectra.

use crate::numerics::allowed::shown;
use crate::numerics::files::FileError;
use thiserror::Error;

/// A wavelength outside a spectrum, or a table that is not a spectrum.
#[derive(Debug, Error)]
pub enum SpectrumError {
    /// A wavelength outside the table or the synthetic formula's range.
    #[error(
        "wavelength_nm = {value} is outside the spectrum {name}: {lo} to {hi} nm; choose wavelengths inside or extend the table"
    )]
    OutOfRange {
        /// Name of the spectrum.
        name: String,
        /// Wavelength asked for, nm.
        value: f64,
        /// Shortest wavelength known, nm.
        lo: f64,
        /// Longest wavelength known, nm.
        hi: f64,
    },
    /// A wavelength that is not a positive number.
    #[error("wavelength_nm = {}: must be finite and greater than 0", shown(*value))]
    BadWavelength {
        /// The wavelength, nm.
        value: f64,
    },
    /// An unknown name of a built-in pigment.
    #[error("unknown pigment spectrum {value:?}: one of red, yellow, blue, green, or a CSV file")]
    UnknownPigment {
        /// The name found.
        value: String,
    },
    /// A name that is not in the list of materials.
    #[error(
        "no material {value:?}; known are {known}. Organic pigments are in no open collection of indices: measure n and κ and give csv = \"…\""
    )]
    UnknownMaterial {
        /// The name found.
        value: String,
        /// The names of the list.
        known: String,
    },
    /// A listed material that is no uniaxial crystal with both rays.
    #[error("{value:?} is no uniaxial crystal whose two rays are recorded; give both as indices of your own")]
    NotUniaxial {
        /// The name found.
        value: String,
    },
    /// An invalid number in an index or a table.
    #[error("{field} = {}: allowed are finite values {allowed}; {remedy}", shown(*value))]
    BadValue {
        /// Name of the quantity, with its row.
        field: String,
        /// The number found.
        value: f64,
        /// What is allowed.
        allowed: &'static str,
        /// What to try.
        remedy: &'static str,
    },
    /// A table that cannot be interpolated.
    #[error("{name}: {rows} rows; at least 2 are needed to interpolate, or use a constant index")]
    TooFewRows {
        /// The file, or the name of the table.
        name: String,
        /// Rows found.
        rows: usize,
    },
    /// The real part n is given nowhere, or both in the file and beside it.
    #[error(transparent)]
    RealPart(FileError),
    /// A table of κ to which the relation of Kramers and Kronig gives no n.
    #[error(transparent)]
    KramersKronig(FileError),
    /// A file that is not a table of numbers, not a spectrum, or not a record of
    /// refractiveindex.info.
    #[error(transparent)]
    File(#[from] FileError),
}
