//! `results.json`: the numbers and their provenance.

pub mod composed;
pub mod left_out;
pub mod main_numbers;
mod results;
mod whole;

use self::composed::{ComposedColours, ComposedRow, SlabNotes};
use self::left_out::LeftOutNotes;
pub use self::results::{ComposedResults, WholeResults};
pub use self::whole::{Certainty, ColourNote, EnsembleNotes, SpectrumReplicates, SpectrumRow};
use super::ink_maker::InkMaker;
use super::printed::Prints;
use super::published::{NumberNote, Withheld};
pub use super::uncertainty::Budget;
use crate::appearance::paper_series::LayerOptics;
use crate::input::study::{ScalarSurface, Study};
use crate::numerics::estimate::Estimate;
use crate::store::identity::METHOD_VERSION;
use crate::store::record::PointRecord;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;

/// Name of the standard geometry of print measurement, lit at 45° and viewed along the normal.
pub const LIT_AT_45: &str = "45:0";
/// Name of illumination by a uniform sky, viewed along the normal.
pub const NATURAL_LIGHT: &str = "natural light";

/// Whether the results include every solve of the study.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Status {
    /// All requested solves are included.
    Complete,
    /// Some solves are missing.
    Partial,
}

/// Where the numbers of a study come from, whichever evaluator made them.
#[derive(Clone, Debug, Serialize)]
pub struct Provenance {
    /// Whether the results are complete.
    pub status: Status,
    /// The study's title.
    pub title: String,
    /// Content hash of the checked study.
    pub study_hash: String,
    /// Name and version of the program.
    pub program: String,
    /// Builds that computed the solves; several if the results are mixed.
    pub builds: BTreeSet<String>,
    /// Version of the method that the results depend on.
    pub method_version: u32,
    /// Seed of the study.
    pub seed: u64,
}

impl Provenance {
    /// Of the numbers of a study that has these records.
    pub fn new<'a>(study: &Study, records: impl IntoIterator<Item = &'a PointRecord>, solves: Count) -> Self {
        Self {
            status: if solves.finished >= solves.asked { Status::Complete } else { Status::Partial },
            title: study.title.clone(),
            study_hash: study.key().to_string(),
            program: program(),
            builds: records.into_iter().map(|record| record.build.clone()).collect(),
            method_version: METHOD_VERSION,
            seed: study.packing.seed,
        }
    }
}

/// The program and its version.
pub fn program() -> String {
    concat!("inkwave ", env!("CARGO_PKG_VERSION")).to_owned()
}

/// Most packings and failures that `results.json` and pages list; the store has all.
pub const MOST_LISTED: usize = 200;

/// The first of a list, as many as are listed.
fn first_ones<T: Serialize, S: serde::Serializer>(list: &[T], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(list.iter().take(MOST_LISTED))
}

/// The published result of a print, whichever evaluator made it: the file `results.json`. What only
/// some prints have is an optional part; the keys of a part stand beside the others in the file.
///
/// Standard errors include randomness, cell, angles and wavelengths (by the jackknife over
/// realisations), the error of the grid and that of the residual, added in quadrature; `null` if a
/// single realisation leaves them unknown.
#[derive(Clone, Debug, Serialize)]
pub struct Manifest<'a> {
    /// Where the numbers come from.
    #[serde(flatten)]
    pub origin: Provenance,
    /// Requested and finished solves.
    pub solves: Count,
    /// Failures with their reasons; the file has the first [`MOST_LISTED`], and counts beside.
    #[serde(serialize_with = "first_ones")]
    pub failures: Vec<FailureNote>,
    /// Packings, grid and errors of a layer that is solved as a whole.
    #[serde(flatten)]
    pub ensemble: Option<EnsembleNotes>,
    /// Colours under all conditions.
    pub colours: PublishedColours,
    /// Why there are no colours.
    pub no_colour: Option<String>,
    /// Hiding power, Kubelka–Munk coefficients and differences of a layer that is solved as a
    /// whole, if there are colours.
    pub ink_maker: Option<InkMaker>,
    /// Why there are colours but no numbers for ink makers, such as an illuminant for which the
    /// wavelengths do not suffice.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub no_ink_maker: Option<String>,
    /// Weighted numbers that the study asks for.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub numbers: Vec<NumberNote>,
    /// Prints in dots, and under the lights of instruments on paper that fluoresces.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub prints: Option<Prints>,
    /// The layer as light between it and its paper meets it, lit at 45° and seen along the normal:
    /// what prints of other studies take of it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub optics: Option<LayerOptics>,
    /// What the scalar wave does to the surface of a paper whose bare factors enter the results.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scalar_surface: Option<ScalarSurface>,
    /// Numbers that were withheld because they are impossible, such as a negative contrast ratio.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub withheld: Vec<Withheld>,
    /// One row per wavelength, and per angle or thickness.
    pub spectra: PublishedSpectra,
    /// What every layer of a stack absorbs that is solved as a whole, without paper; empty for one
    /// layer.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub absorbed: Vec<AbsorbedNote>,
    /// What a stack is without each of its layers, and each alone.
    #[serde(flatten)]
    pub left_out: LeftOutNotes,
    /// What a layer composed of slabs has beside these.
    #[serde(flatten)]
    pub slabs: Option<SlabNotes<'a>>,
    /// Sum of the wall times of all solves, s; several solves may run in parallel, on several
    /// threads each.
    pub solve_seconds: f64,
    /// Processor time of the whole process that wrote this file, s, on all threads: packings,
    /// grids, solves and evaluation since its start. Absent in sweeps, where one process works on
    /// all variants.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub process_seconds: Option<f64>,
    /// The study with all defaults filled in.
    pub study: &'a Study,
}

/// The spectra of a print.
#[derive(Clone, Debug, Serialize)]
#[serde(untagged)]
pub enum PublishedSpectra {
    /// Of a layer that is solved as a whole: one row per wavelength and angle.
    Whole(Vec<SpectrumRow>),
    /// Of a composed layer: one row for each requested thickness and wavelength.
    Composed(Vec<ComposedRow>),
}

impl PublishedSpectra {
    /// Rows of a layer that is solved as a whole; none of another.
    pub fn whole(&self) -> &[SpectrumRow] {
        if let Self::Whole(rows) = self { rows } else { &[] }
    }

    /// Rows of a composed layer; none of another.
    pub fn composed(&self) -> &[ComposedRow] {
        if let Self::Composed(rows) = self { rows } else { &[] }
    }
}

/// The colours of a print.
#[derive(Clone, Debug, Serialize)]
#[serde(untagged)]
pub enum PublishedColours {
    /// Of a layer that is solved as a whole: one under each condition.
    Whole(Vec<ColourNote>),
    /// Of a composed layer: those of each requested thickness.
    Composed(Vec<ComposedColours>),
}

impl PublishedColours {
    /// Colours of a layer that is solved as a whole; none of another.
    pub fn whole(&self) -> &[ColourNote] {
        if let Self::Whole(notes) = self { notes } else { &[] }
    }

    /// Colours of a composed layer; none of another.
    pub fn composed(&self) -> &[ComposedColours] {
        if let Self::Composed(colours) = self { colours } else { &[] }
    }
}

impl Manifest<'_> {
    /// Thicknesses of the layers that the study is about, µm.
    pub fn thicknesses_um(&self) -> Vec<f64> {
        self.study.requested_um()
    }

    /// Why nothing is published, where more packings failed than the study allows.
    pub fn refusal(&self) -> Option<String> {
        self.ensemble.as_ref()?.tried_packings.refusal(self.study.failed_packings)
    }

    /// The first invalid number: NaN, infinite, or a total outside 0–1 by more than its error.
    pub fn unphysical(&self) -> Option<String> {
        let certainty = self.ensemble.as_ref().and_then(|ensemble| ensemble.certainty.unphysical());
        let spectrum = || self.spectra.whole().iter().find_map(SpectrumRow::unphysical);
        certainty.or_else(spectrum).or_else(|| self.unphysical_colour())
    }

    fn unphysical_colour(&self) -> Option<String> {
        let wrong = self.colours.whole().iter().find(|note| !note.colour.lab.iter().all(|x| x.is_finite()));
        wrong.map(|note| format!("Lab under {} is {:?}", note.conditions, note.colour.lab))
    }
}

/// Numbers of requested and finished items.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Count {
    /// Number requested.
    pub asked: usize,
    /// Number finished.
    pub finished: usize,
}

/// What one layer of a stack absorbs at one wavelength and angle; all layers together absorb A.
#[derive(Clone, Debug, Serialize)]
pub struct AbsorbedNote {
    /// Name of the layer.
    pub layer: String,
    /// Wavelength, nm.
    pub wavelength_nm: f64,
    /// Polar angle, degrees.
    pub polar_deg: f64,
    /// Share of the light that it absorbs, without paper.
    pub absorptance: Estimate,
}

/// A solve without a result, or a realisation without a packing.
#[derive(Clone, Debug, Serialize)]
#[serde(untagged)]
pub enum FailureNote {
    /// Of a layer that is solved as a whole.
    Whole {
        /// Number of the realisation, from 0.
        realisation: usize,
        /// Wavelength, nm; absent for a packing.
        wavelength_nm: Option<f64>,
        /// Polar angle, degrees; absent for a packing.
        polar_deg: Option<f64>,
        /// The error's message.
        reason: String,
    },
    /// Of a slab, or of a part of a stack: which, the realisation and the error's message.
    Slab(String),
}

impl FailureNote {
    /// The realisation and the light, as far as they do not stand in the message.
    pub fn place(&self) -> String {
        let Self::Whole { realisation, wavelength_nm, polar_deg, .. } = self else { return String::new() };
        let light = wavelength_nm.zip(*polar_deg).map(|(nm, deg)| format!("{nm} nm, {deg:.1}°"));
        format!("realisation {}, {}", realisation + 1, light.unwrap_or_else(|| "packing".to_owned()))
    }

    /// The error's message.
    pub fn reason(&self) -> &str {
        match self {
            Self::Whole { reason, .. } | Self::Slab(reason) => reason,
        }
    }
}
