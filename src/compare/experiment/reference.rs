//! The geometry that is compared on, and the amplitudes that every row is held against.

use super::file::{ComparisonFile, Points};
use super::resolution;
use crate::compare::error::CompareError;
use crate::input::case::Case;
use crate::numerics::files;
use crate::run::memory;
use crate::solve::accuracy::{AccuracyError, Task};
use crate::solve::{Coverages, Gmres, Goal, Watch};
use crate::wave::{FarField, Mean, Order, Physical, Resolution, Scheme, TotalErrors};
use num_complex::Complex64;

/// The geometry, and the reference amplitudes if its file has them.
pub(super) struct Subject {
    pub case: Case,
    known: Option<serde_json::Value>,
}

impl ComparisonFile {
    /// Reads or packs the geometry.
    pub(super) fn subject(&self) -> Result<Subject, CompareError> {
        if let Some(path) = &self.case {
            let path = self.folder().join(path);
            let case = Case::read(&path)?;
            let json = files::read_text(&path, files::CASE).ok().and_then(|t| serde_json::from_str(&t).ok());
            let known =
                json.and_then(|v: serde_json::Value| v.get("outputs").and_then(|o| o.get("orders")).cloned());
            return Ok(Subject { case, known });
        }
        let packed = self.packed()?.expect("checked: a study, a case or a layer");
        Ok(Subject { case: packed.case()?, known: None })
    }

    /// The grid of the reference.
    fn finer(&self, case: &Case) -> Resolution {
        let most = |f: fn(&Points) -> usize| self.resolutions.iter().map(f).max().unwrap_or(1);
        let finer = Points { points: 3 * most(|p| p.points) / 2, cells: 3 * most(|p| p.cells) / 2 };
        resolution(&case.scene, finer, Scheme::Cubic)
    }

    /// All that [`ComparisonFile::reference`] asks for before it solves.
    ///
    /// # Errors
    /// No memory for the grid; a geometry or a direction that makes no problem on it.
    pub(super) fn check_reference(&self, Subject { case, .. }: &Subject) -> Result<(), CompareError> {
        let (resolution, coverages) = (self.finer(case), Coverages::of(&case.scene));
        let solver = Gmres::default();
        let task = task(case, &coverages, &solver);
        task.admitted(resolution).map_err(AccuracyError::Memory)?;
        task.systems(resolution)?;
        Ok(())
    }

    /// Amplitudes to compare with: those of the case file, or a solve at half as many points and cells again.
    pub(super) fn reference(
        &self,
        subject: &Subject,
        watch: &mut dyn Watch,
    ) -> Result<(FarField, String), CompareError> {
        let (resolution, coverages) = (self.finer(&subject.case), Coverages::of(&subject.case.scene));
        let (solved, _) = task(&subject.case, &coverages, &Gmres::default()).solve(resolution, watch)?;
        let errors = TotalErrors::of_totals([1.0; 2], solved[0].solution.account.residual);
        let mut far =
            Physical::judge(solved[0].far_field(), errors).map_err(AccuracyError::Unphysical)?.into_inner();
        if let Some(known) = subject.known.as_ref().and_then(|k| k.as_array()) {
            far.orders.retain_mut(|o| replace(o, known));
            return Ok((far, "the case file's own amplitudes".into()));
        }
        let name = format!(
            "krylov on {} × {} points and {} cubic cells",
            resolution.nx, resolution.ny, resolution.cells
        );
        Ok((far, name))
    }
}

/// The reference's solve, but for its grid.
fn task<'a>(case: &'a Case, coverages: &'a Coverages<'a>, solver: &'a Gmres) -> Task<'a> {
    Task {
        coverages,
        media: &case.media,
        incidence: &case.incidence,
        mean: Mean::default(),
        scheme: Scheme::Cubic,
        solver,
        goal: Goal { tolerance: 1e-9, ..Goal::default() },
        memory: memory::usable(),
    }
}

/// Puts a reference order's amplitudes in place; false where the reference does not list it.
fn replace(order: &mut Order, known: &[serde_json::Value]) -> bool {
    let same = |k: &&serde_json::Value| {
        k["m"] == order.m && (k["n"] == order.n || (k["n"].is_null() && order.n == 0))
    };
    let Some(found) = known.iter().find(same) else { return false };
    let amplitude = |key: &str| Some(Complex64::new(found[key][0].as_f64()?, found[key][1].as_f64()?));
    order.reflected = amplitude("R").unwrap_or(order.reflected);
    order.transmitted = amplitude("T").unwrap_or(order.transmitted);
    true
}
