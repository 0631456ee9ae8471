//! Errors of the paper model and of colorimetry.

use thiserror::Error;

/// Invalid paper, or an invalid angle.
#[derive(Debug, Error, PartialEq)]
pub enum PaperError {
    /// An angle outside the hemisphere.
    #[error("polar angle {value}°: allowed are 0° to below 90°")]
    AngleOutOfRange {
        /// The angle, degrees.
        value: f64,
    },
    /// An albedo outside 0–1.
    #[error("paper albedo = {value}: allowed 0 to 1")]
    Albedo {
        /// The albedo.
        value: f64,
    },
    /// A wavelength outside the table.
    #[error("paper albedo is given from {lo} to {hi} nm, requested at {value} nm; extend the table")]
    AlbedoRange {
        /// The wavelength, nm.
        value: f64,
        /// First wavelength of the table, nm.
        lo: f64,
        /// Last wavelength of the table, nm.
        hi: f64,
    },
    /// A table that does not increase in wavelength.
    #[error("paper albedo table: wavelength_nm = {value} does not increase, or fewer than 2 rows")]
    AlbedoTable {
        /// The wavelength, nm.
        value: f64,
    },
    /// A lossless closed cavity.
    #[error(
        "the layer reflects all light from the exit side (R̄_b = {mean}) on paper of albedo 1: the light never leaves; lower the albedo"
    )]
    TrapsAllLight {
        /// R̄_b, the mean reflectance from the exit side.
        mean: f64,
    },
}

/// Why a spectrum has no colour.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum ColourError {
    /// Fewer wavelengths than an integral needs.
    #[error("wavelengths_nm has {count} entries; a colour needs at least 3, spread over 400 to 700 nm")]
    TooFewWavelengths {
        /// Wavelengths given.
        count: usize,
    },
    /// An unknown illuminant or observer.
    #[error("{what} = {value:?}: allowed are {allowed}")]
    UnknownName {
        /// Illuminant or observer.
        what: &'static str,
        /// The name found.
        value: String,
        /// The known names.
        allowed: String,
    },
    /// A wavelength outside the observer's table, or not increasing.
    #[error(
        "wavelengths_nm[{index}] = {value}: must increase and lie in {lo} to {hi} nm (CIE tables); leave it out of the colour"
    )]
    BadWavelength {
        /// Index in the list.
        index: usize,
        /// The wavelength, nm.
        value: f64,
        /// Shortest allowed, nm.
        lo: f64,
        /// Longest allowed, nm.
        hi: f64,
    },
    /// Wavelengths that cover too little of the visible range for a reliable colour.
    #[error(
        "wavelengths_nm from {first} to {last} nm leave white with {channel:.3} of its {name}, at least {least} needed: with less, the colour would be a guess; cover 400 to 700 nm (about 440 to 610 nm is the least), with tables that reach as far"
    )]
    WhiteNotCovered {
        /// First wavelength, nm.
        first: f64,
        /// Last wavelength, nm.
        last: f64,
        /// The tristimulus value that is not covered.
        name: &'static str,
        /// Fraction of it that the wavelengths cover.
        channel: f64,
        /// Smallest fraction allowed.
        least: f64,
    },
    /// A spectrum whose length differs from that of the list of wavelengths.
    #[error("the spectrum has {count} values for {expected} wavelengths")]
    WrongLength {
        /// Values given.
        count: usize,
        /// Values expected.
        expected: usize,
    },
    /// A value that is not finite.
    #[error("spectrum value at {wavelength_nm} nm = {value}: must be finite")]
    NotFinite {
        /// Wavelength of the value, nm.
        wavelength_nm: f64,
        /// The value.
        value: f64,
    },
}
