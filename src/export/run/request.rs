//! What to export.

/// A format, or a group of files that belong together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Measured material for the renderer Mitsuba 3, spectral and RGB, with scenes and tables to check it by.
    Mitsuba,
    /// CxF3: spectra with Lab.
    Cxf,
    /// CGATS.17 and ArgyllCMS's dialect of it.
    Cgats,
    /// Far fields as NumPy arrays.
    Npz,
    /// Contrast, and on request the wave inside the layer, as VTK images.
    Vti,
    /// The first packing as a page for the browser.
    Viewer,
    /// RO-Crate and Data Package with the tables they describe.
    Crate,
}

/// Light for a near field, which is computed anew: no run keeps it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearField {
    /// One of the study's wavelengths, nm.
    pub wavelength_nm: f64,
    /// Angle of incidence, degrees.
    pub polar_deg: f64,
}

/// What to export.
#[derive(Clone, Debug)]
pub struct Request {
    /// Formats, in any order.
    pub formats: Vec<Format>,
    /// A solve for `near-field.vti`; none unless asked.
    pub near_field: Option<NearField>,
    /// Date and time for the files that carry one, RFC 3339.
    pub created: String,
}
