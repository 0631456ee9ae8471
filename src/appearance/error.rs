//! What can be wrong with the paper.

use thiserror::Error;

/// What is wrong with the paper, or with an angle asked of it.
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
    /// A wavelength that the table does not hold.
    #[error("paper albedo is given from {lo} to {hi} nm, asked at {value} nm; extend the table")]
    AlbedoRange {
        /// The wavelength, nm.
        value: f64,
        /// First wavelength of the table, nm.
        lo: f64,
        /// Last wavelength of the table, nm.
        hi: f64,
    },
    /// A table that does not rise.
    #[error("paper albedo table: wavelength_nm = {value} does not increase, or fewer than 2 rows")]
    AlbedoTable {
        /// The wavelength, nm.
        value: f64,
    },
    /// A closed box without losses.
    #[error(
        "the layer reflects all light from below (R̄_b = {mean}) on paper of albedo 1: the light never leaves; lower the albedo"
    )]
    TrapsAllLight {
        /// R̄_b.
        mean: f64,
    },
}
