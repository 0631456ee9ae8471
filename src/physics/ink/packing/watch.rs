//! Progress and cancellation of packing.

use crate::ink::error::PackError;
use std::ops::ControlFlow;

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
    /// Reports to a watch; the error is that it asks to stop.
    pub(super) fn report(&self, watch: &mut dyn PackWatch) -> Result<(), PackError> {
        match watch.progress(self) {
            ControlFlow::Continue(()) => Ok(()),
            ControlFlow::Break(()) => Err(PackError::Stopped { stage: self.stage, steps: self.step }),
        }
    }
}

/// Receives progress reports and may stop the packing by returning `Break`.
pub trait PackWatch {
    /// Called at intervals; `Break` stops the packing with [`crate::ink::PackError::Stopped`].
    fn progress(&mut self, progress: &PackProgress) -> ControlFlow<()>;
}

/// Ignores progress and never stops.
impl PackWatch for () {
    fn progress(&mut self, _: &PackProgress) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}
