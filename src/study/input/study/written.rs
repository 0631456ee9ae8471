//! A study as `results.json` and content hashes hold it: what it is a study of stands with the
//! layer, with the directions and beside them.

use super::{
    Angles, Composed, Dissolved, Judgement, Layer, Paper, Pigment, Portion, StackLayer, Study, StudyKind,
    TargetColour, WantedNumber, WantedResolution,
};
use crate::ink::PackingRequest;
use crate::input::file::OutputTable;
use crate::input::variation::Variation;
use crate::solve::{Goal, SolverChoice};
use crate::wave::Wave;
use serde::{Deserialize, Serialize};

/// A layer, and how it is composed.
#[derive(Clone, Serialize, Deserialize)]
pub(super) struct WrittenLayer {
    #[serde(flatten)]
    layer: Layer,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    composed: Option<Composed>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    stack: Vec<StackLayer>,
}

/// Directions, and why they allow no paper.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct WrittenAngles {
    #[serde(flatten)]
    angles: Angles,
    no_paper: Option<String>,
}

/// The fields of [`Study`] in the order in which they are written.
#[derive(Serialize, Deserialize)]
pub(super) struct WrittenStudy {
    title: String,
    layer: WrittenLayer,
    pigments: Vec<Pigment>,
    dissolved: Vec<Dissolved>,
    packing: PackingRequest,
    paper: Paper,
    wavelengths_nm: Vec<f64>,
    wave: Wave,
    angles: WrittenAngles,
    realisations: usize,
    target_delta_e: Option<f64>,
    target_colour: TargetColour,
    #[serde(default)]
    failed_packings: f64,
    variation: Variation,
    resolution: WantedResolution,
    solver: SolverChoice,
    goal: Goal,
    output: OutputTable,
    judgement: Judgement,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    numbers: Vec<WantedNumber>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    portion: Option<Portion>,
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    without_layers: bool,
}

impl Study {
    /// The layer, and how it is composed.
    pub(super) fn written_layer(&self) -> WrittenLayer {
        WrittenLayer {
            layer: self.layer.clone(),
            composed: self.composed().cloned(),
            stack: self.stack.clone(),
        }
    }

    /// The directions, and why they allow no paper, for content hashes.
    pub fn written_angles(&self) -> WrittenAngles {
        WrittenAngles { angles: self.angles.clone(), no_paper: self.no_paper().map(str::to_owned) }
    }
}

impl From<Study> for WrittenStudy {
    fn from(study: Study) -> Self {
        let layer = study.written_layer();
        let angles = study.written_angles();
        Self {
            layer,
            angles,
            portion: study.portion().cloned(),
            title: study.title,
            pigments: study.pigments,
            dissolved: study.dissolved,
            packing: study.packing,
            paper: study.paper,
            wavelengths_nm: study.wavelengths_nm,
            wave: study.wave,
            realisations: study.realisations,
            target_delta_e: study.target_delta_e,
            target_colour: study.target_colour,
            failed_packings: study.failed_packings,
            variation: study.variation,
            resolution: study.resolution,
            solver: study.solver,
            goal: study.goal,
            output: study.output,
            judgement: study.judgement,
            numbers: study.numbers,
            without_layers: study.without_layers,
        }
    }
}

impl From<WrittenStudy> for Study {
    fn from(written: WrittenStudy) -> Self {
        let kind = match (written.portion, written.layer.composed, written.angles.no_paper) {
            (Some(portion), _, _) => StudyKind::Slab(portion),
            (None, Some(composed), _) => StudyKind::Composed(composed),
            (None, None, Some(reason)) => StudyKind::LayerAlone(reason),
            (None, None, None) => StudyKind::InkOnPaper,
        };
        Self {
            kind,
            title: written.title,
            layer: written.layer.layer,
            stack: written.layer.stack,
            pigments: written.pigments,
            dissolved: written.dissolved,
            packing: written.packing,
            paper: written.paper,
            wavelengths_nm: written.wavelengths_nm,
            wave: written.wave,
            angles: written.angles.angles,
            realisations: written.realisations,
            target_delta_e: written.target_delta_e,
            target_colour: written.target_colour,
            failed_packings: written.failed_packings,
            variation: written.variation,
            resolution: written.resolution,
            solver: written.solver,
            goal: written.goal,
            output: written.output,
            judgement: written.judgement,
            numbers: written.numbers,
            without_layers: written.without_layers,
            remarks: Vec::new(),
        }
    }
}
