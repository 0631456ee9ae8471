//! Which mean medium ⟨k²⟩ a strategy is compared with.

use super::file::ComparisonFile;
use crate::solve::Solver;
use crate::wave::{Mean, Media};

impl ComparisonFile {
    /// The means that a strategy is tried with: the one asked for, or else the one that suits it
    /// best and, where absorption makes a difference, the real one too.
    pub(super) fn means(&self, solver: &dyn Solver, absorbs: bool) -> Vec<Mean> {
        let depends_on_z = self.mean_depends_on_z.unwrap_or(true);
        let mean = |absorbing| Mean { depends_on_z, absorbing: absorbing && absorbs };
        match self.absorbing_mean {
            Some(asked) => vec![mean(asked)],
            None if absorbs && solver.suited_mean().absorbing => vec![mean(true), mean(false)],
            None => vec![mean(false)],
        }
    }
}

/// Whether any medium of the layer absorbs: where none does, both means are one.
pub(super) fn absorbs(media: &Media) -> bool {
    media.backgrounds.iter().chain(&media.inclusions).any(|eta| (eta * eta).im != 0.0)
}
