//! What only one of the evaluators gives, together: readers that show all of a result ask once
//! which of them made it. What every print has is in the [`Manifest`] itself.

use super::composed::{ComposedColours, ComposedRow, SlabNotes};
use super::{ColourNote, EnsembleNotes, FailureNote, Manifest, SpectrumRow};

/// The results that only a layer has which is solved as a whole.
#[derive(Clone, Copy, Debug)]
pub struct WholeResults<'m> {
    /// Packings, grid and errors.
    pub ensemble: &'m EnsembleNotes,
    /// One row per wavelength and angle.
    pub rows: &'m [SpectrumRow],
    /// Its colours, one under each condition.
    pub colours: &'m [ColourNote],
}

/// The results that only a layer has which is composed of slabs.
#[derive(Clone, Copy, Debug)]
pub struct ComposedResults<'m> {
    /// The medium, and everything against thickness and depth.
    pub slabs: &'m SlabNotes<'m>,
    /// One row for each requested thickness and wavelength.
    pub rows: &'m [ComposedRow],
    /// Its colours, those of each requested thickness.
    pub colours: &'m [ComposedColours],
}

impl ComposedResults<'_> {
    /// The rows of the layer of one thickness, µm.
    pub fn rows_of(&self, thickness_um: f64) -> impl Iterator<Item = &ComposedRow> {
        self.rows.iter().filter(move |row| row.thickness_um == thickness_um)
    }

    /// The colours of the layer of one thickness, µm.
    pub fn colours_of(&self, thickness_um: f64) -> Option<&ComposedColours> {
        self.colours.iter().find(|colours| colours.thickness_um == thickness_um)
    }
}

impl Manifest<'_> {
    /// The results of a layer that is solved as a whole; `None` of another.
    pub fn whole(&self) -> Option<WholeResults<'_>> {
        let ensemble = self.ensemble.as_ref()?;
        Some(WholeResults { ensemble, rows: self.spectra.whole(), colours: self.colours.whole() })
    }

    /// The results of a composed layer; `None` of another.
    pub fn composed(&self) -> Option<ComposedResults<'_>> {
        let slabs = self.slabs.as_ref()?;
        Some(ComposedResults { slabs, rows: self.spectra.composed(), colours: self.colours.composed() })
    }

    /// What a reader of the results should know.
    pub fn remarks(&self) -> &[String] {
        self.slabs.as_ref().map_or(&[], |slabs| &slabs.remarks)
    }

    /// How many packings are missing and why, in words, if any are.
    pub fn missing_packings(&self) -> Option<String> {
        self.ensemble.as_ref()?.tried_packings.missing_in_words()
    }

    /// Number of solves that failed; of a layer that is solved as a whole, without packings.
    pub fn failed_solves(&self) -> usize {
        let is_packing = |note: &&FailureNote| matches!(note, FailureNote::Whole { wavelength_nm: None, .. });
        self.failures.iter().filter(|note| !is_packing(note)).count()
    }
}
