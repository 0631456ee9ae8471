//! Errors of packing, its progress and its cancellation.

use crate::numerics::Draws;
use std::ops::ControlFlow;

/// All failures of a packing; the fields carry what is needed to correct them.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PackError {
    /// An invalid number in the request; found before any grain is placed.
    #[error("{field} = {found}: allowed is {allowed}; {remedy}")]
    BadInput {
        /// Path of the field in the request.
        field: String,
        /// The value found.
        found: String,
        /// What is allowed.
        allowed: String,
        /// What to try.
        remedy: String,
    },

    /// Random sequential addition found no free place for a grain.
    #[error(
        "volume fraction {requested:.4} not reached after {attempts} attempts: sequential addition is blocked \
         with {placed} of {wanted} grains in place (fraction {reached:.4}; spheres saturate at 0.384): use method = \
         \"relaxation\", raise sequential.attempts_per_grain or lower the volume fraction"
    )]
    Blocked {
        /// Volume fraction of all grains of the request.
        requested: f64,
        /// Volume fraction of the grains in place.
        reached: f64,
        /// Grains in place.
        placed: usize,
        /// Grains of the request.
        wanted: usize,
        /// Total number of attempts, including those of the placed grains.
        attempts: u64,
    },

    /// Relaxation stalled, or reached its limit of steps, with overlaps left.
    #[error(
        "volume fraction {requested:.4} not reached after {steps} steps: {}, largest overlap left \
         {largest_overlap_um:.2e} µm ({relative_overlap:.1e} of the radii's sum); lower the volume fraction to what was \
         reached, take smaller grains or a thicker layer (walls cost density), or allow more relaxation.max_steps",
        reached_part(reached, *wanted)
    )]
    NotReached {
        /// Volume fraction of all grains of the request.
        requested: f64,
        /// The largest arrangement without overlap after removing the worst grains; `None` if the
        /// search failed too.
        reached: Option<Reached>,
        /// Grains of the request.
        wanted: usize,
        /// Steps of relaxation.
        steps: u64,
        /// Largest remaining overlap, µm.
        largest_overlap_um: f64,
        /// Largest overlap over the sum of the two radii.
        relative_overlap: f64,
    },

    /// Two grains, or a grain and a wall, overlap in a packing that must have no overlap.
    #[error(
        "{first} and {second} overlap by {overlap_um:.3e} µm; a packing holds only grains that do not overlap"
    )]
    Overlap {
        /// One of the two, such as "grain 3".
        first: String,
        /// The other, or "a wall".
        second: String,
        /// Depth of the overlap, µm.
        overlap_um: f64,
    },

    /// The watch requested a stop.
    #[error("stopped on request during {stage} after {steps} steps; no packing is returned")]
    Stopped {
        /// Stage that was interrupted.
        stage: &'static str,
        /// Steps, attempts or sweeps completed.
        steps: u64,
    },
}

/// The densest arrangement without overlap found from a stuck relaxation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reached {
    /// Volume fraction of the arrangement.
    pub fraction: f64,
    /// Number of its grains.
    pub grains: usize,
}

fn reached_part(reached: &Option<Reached>, wanted: usize) -> String {
    match reached {
        Some(Reached { fraction, grains }) => {
            format!("{grains} of {wanted} grains fit without overlap (fraction {fraction:.4})")
        }
        None => format!("the number of the {wanted} grains that would fit could not be determined either"),
    }
}

impl PackError {
    pub(crate) fn input(
        field: impl ToString,
        found: impl ToString,
        allowed: impl ToString,
        remedy: impl ToString,
    ) -> Self {
        Self::BadInput {
            field: field.to_string(),
            found: found.to_string(),
            allowed: allowed.to_string(),
            remedy: remedy.to_string(),
        }
    }

    /// Refuses an input that is not sound.
    pub(crate) fn unless(
        sound: bool,
        field: impl ToString,
        found: impl ToString,
        allowed: impl ToString,
        remedy: impl ToString,
    ) -> Result<(), Self> {
        if sound { Ok(()) } else { Err(Self::input(field, found, allowed, remedy)) }
    }
}

/// Progress of a packing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PackProgress {
    /// "sequential addition", "relaxation" or "equilibration".
    pub stage: &'static str,
    /// Steps, attempts or sweeps so far.
    pub step: u64,
    /// Grains in place so far.
    pub grains_placed: usize,
    /// Grains of the request.
    pub grains_wanted: usize,
    /// Volume fraction of the grains placed so far.
    pub fraction: f64,
    /// Overlap energy ½ Σ L² in µm² (relaxation; zero otherwise).
    pub overlap_energy: f64,
    /// Largest overlap in µm (relaxation; zero otherwise).
    pub largest_overlap_um: f64,
}

impl PackProgress {
    /// Reports to the watch; the error is that it asks to stop.
    pub(crate) fn report(&self, course: &mut Course) -> Result<(), PackError> {
        match course.watch.progress(self) {
            ControlFlow::Continue(()) => Ok(()),
            ControlFlow::Break(()) => Err(PackError::Stopped { stage: self.stage, steps: self.step }),
        }
    }
}

/// What a packing goes on with: its random draws, and the watch that hears of its progress.
pub(crate) struct Course<'w> {
    pub draws: Draws,
    pub watch: &'w mut dyn PackWatch,
}

/// Receives progress reports and may stop the packing by returning `Break`.
pub trait PackWatch {
    /// Called at intervals; `Break` stops the packing with [`PackError::Stopped`].
    fn progress(&mut self, progress: &PackProgress) -> ControlFlow<()>;
}

/// Ignores progress and never stops.
impl PackWatch for () {
    fn progress(&mut self, _: &PackProgress) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}
