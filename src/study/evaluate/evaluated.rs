//! A study evaluated: its published numbers, and what pictures and exports need beside them,
//! whichever evaluator made them.

use super::composed::level::SolvedPortion;
use super::composed::summary::summarise_slabs;
use super::composed::view::ComposedView;
use super::ink::InkError;
use super::manifest::Manifest;
use super::seen::{Seen, see};
use super::summary::summarise;
use crate::appearance::bdf::BdfError;
use crate::appearance::picture::InkPicture;
use crate::input::study::Study;
use crate::run::Collected;

/// The finished solves of a study.
#[derive(Debug)]
pub enum FinishedSolves {
    /// Of a layer that is solved as a whole.
    Whole(Box<Collected>),
    /// Of the slabs of a composed layer; those of which nothing is stored are missing.
    Slabs(Vec<SolvedPortion>),
}

impl FinishedSolves {
    /// The slabs of a composed layer; none of another.
    pub fn slabs(&self) -> &[SolvedPortion] {
        if let Self::Slabs(slabs) = self { slabs } else { &[] }
    }

    /// Number of solves and packings that failed.
    pub fn failures(&self) -> usize {
        let of_layer = |collected: &Collected| collected.refused.len() + collected.failures().count();
        match self {
            Self::Whole(collected) => of_layer(collected),
            Self::Slabs(slabs) => slabs.iter().map(|(_, collected)| of_layer(collected)).sum(),
        }
    }

    /// Number of solves that are finished.
    pub fn finished(&self) -> usize {
        match self {
            Self::Whole(collected) => collected.finished(),
            Self::Slabs(slabs) => slabs.iter().map(|(_, collected)| collected.finished()).sum(),
        }
    }
}

/// Why a study has no numbers.
#[derive(Debug, thiserror::Error)]
pub enum EvaluateError {
    /// Too few solves of a composed layer, or paper without an albedo.
    #[error("{0}")]
    Slabs(String),
    /// The ink on its paper.
    #[error(transparent)]
    Ink(#[from] InkError),
    /// A distribution function.
    #[error(transparent)]
    Bdf(#[from] BdfError),
}

/// A study with its published numbers.
#[derive(Debug)]
pub struct Evaluated<'a> {
    /// The published numbers.
    pub manifest: Manifest<'a>,
    /// What they were made from.
    pub from: Evaluation<'a>,
}

/// What published numbers were made from.
#[derive(Debug)]
pub enum Evaluation<'a> {
    /// The appearance of a layer that is solved as a whole.
    Whole(Box<Seen>),
    /// The solved slabs of a composed layer.
    Slabs(&'a [SolvedPortion]),
}

/// A picture of a layer.
#[derive(Clone, Debug)]
pub struct LayerPicture {
    /// Thickness of the layer in µm, where the study has layers of several thicknesses.
    pub thickness_um: Option<f64>,
    /// The picture.
    pub picture: InkPicture,
}

impl<'a> Evaluated<'a> {
    /// Evaluates the finished solves of a study.
    ///
    /// # Errors
    /// Slabs without a complete realisation, or records that do not belong together.
    pub fn new(study: &'a Study, solved: &'a FinishedSolves) -> Result<Self, EvaluateError> {
        match solved {
            FinishedSolves::Whole(collected) => {
                let seen = see(study, collected)?;
                Ok(Self::of_whole(summarise(study, collected, &seen), seen))
            }
            FinishedSolves::Slabs(slabs) => {
                let manifest = summarise_slabs(study, slabs).map_err(EvaluateError::Slabs)?;
                Ok(Self { manifest, from: Evaluation::Slabs(slabs) })
            }
        }
    }

    /// Of a layer that is solved as a whole, from its numbers.
    pub fn of_whole(manifest: Manifest<'a>, seen: Seen) -> Self {
        Self { manifest, from: Evaluation::Whole(Box::new(seen)) }
    }

    /// The appearance of a layer that is solved as a whole.
    pub fn seen(&self) -> Option<&Seen> {
        if let Evaluation::Whole(seen) = &self.from { Some(seen) } else { None }
    }

    /// The pictures of all layers that have a colour, at these angles from the normal, in degrees.
    ///
    /// # Errors
    /// Angles outside 0–90°, slabs that are missing.
    pub fn pictures(&self, angles_deg: &[f64]) -> Result<Vec<LayerPicture>, EvaluateError> {
        self.first_pictures(angles_deg, usize::MAX)
    }

    /// The picture of the first layer, if it has a colour.
    ///
    /// # Errors
    /// As [`Evaluated::pictures`].
    pub fn picture(&self, angles_deg: &[f64]) -> Result<Option<InkPicture>, EvaluateError> {
        Ok(self.first_pictures(angles_deg, 1)?.pop().map(|layer| layer.picture))
    }

    fn first_pictures(&self, angles_deg: &[f64], most: usize) -> Result<Vec<LayerPicture>, EvaluateError> {
        let study = self.manifest.study;
        let sky = study.output.mirrored_sky;
        let mut all = Vec::new();
        match &self.from {
            Evaluation::Whole(seen) => {
                let Ok(ink) = &seen.ink else { return Ok(all) };
                match ink.picture(angles_deg, sky) {
                    Err(InkError::Colour(_)) => (),
                    picture => all.push(LayerPicture { thickness_um: None, picture: picture? }),
                }
            }
            Evaluation::Slabs(slabs) => {
                for colours in self.manifest.colours.composed().iter().take(most) {
                    let view = ComposedView::new(study, slabs, colours.thickness_um);
                    let view = view.map_err(EvaluateError::Slabs)?;
                    let picture = view.picture(angles_deg, sky).map_err(InkError::from)?;
                    all.push(LayerPicture { thickness_um: Some(colours.thickness_um), picture });
                }
            }
        }
        Ok(all)
    }
}
