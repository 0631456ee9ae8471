//! A finished study as exports read it, whichever evaluator made its numbers.

use super::print::Print;
use super::provenance::Described;
use super::request::ExportResult;
use crate::evaluate::directional::DirectionalPrint;
use crate::evaluate::printed::Prints;
use crate::input::study::Study;
use crate::wave::Resolution;

/// A study whose realisations are packings of the whole layer.
#[derive(Clone, Copy, Debug)]
pub struct PackedLayer<'a> {
    /// The study.
    pub study: &'a Study,
    /// Its grid.
    pub resolution: Resolution,
}

/// What exports need of a finished study. Errors are those of formats that its kind of layer does
/// not have, of missing numbers and of tables that cannot be written.
pub trait FinishedStudy {
    /// The study.
    fn study(&self) -> &Study;

    /// Thicknesses of the layers that it describes, µm.
    fn thicknesses_um(&self) -> Vec<f64> {
        self.study().requested_um()
    }

    /// Whether its distributions are means over the azimuth.
    fn is_isotropic(&self) -> bool;

    /// The layer of this thickness on its paper, from all directions.
    ///
    /// # Errors
    /// The study has no paper, or too few angles.
    fn directions(&self, thickness_um: f64) -> ExportResult<Box<dyn DirectionalPrint + '_>>;

    /// Spectra of the layer of this thickness on its paper, on a grid of 10 nm, for a format.
    ///
    /// # Errors
    /// Too few wavelengths, or numbers that are withheld.
    fn print(&self, thickness_um: f64, format: &str, created: &str) -> ExportResult<Print>;

    /// Prints in dots, if the study has any.
    ///
    /// # Errors
    /// The numbers cannot be made.
    fn prints(&self) -> ExportResult<Option<Prints>>;

    /// All orders of all solves.
    ///
    /// # Errors
    /// The archives cannot be made.
    fn far_fields(&self) -> ExportResult<Vec<Described>>;

    /// All numbers and their tables.
    ///
    /// # Errors
    /// A table that cannot be written.
    fn results(&self) -> ExportResult<Vec<Described>>;

    /// The study as one of packings of the whole layer, for a format that shows the first.
    ///
    /// # Errors
    /// The layer has no packing of its own.
    fn packed(&self, format: &str) -> ExportResult<PackedLayer<'_>>;
}
