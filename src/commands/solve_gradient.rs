//! `inkwave solve --gradient`: derivatives of orders and totals with respect to every index.

use super::solve_report::by_polarisation;
use inkwave::solve::accuracy::{AccuracyError, Estimated, Solved, Task};
use inkwave::solve::gradient::{FarSlopes, Neighbour, Slopes, tangent};
use inkwave::solve::{Goal, Silent};
use inkwave::wave::{DIRECTIONS, Media, Medium, Order, WaveError};
use num_complex::Complex64;
use serde_json::{Value, json};

/// Step in an index; the error of four neighbours is its fourth power.
const STEP: f64 = 1e-4;
/// Largest residual of the solutions that are differentiated.
const RESIDUAL: f64 = 1e-8;

/// In an absorbing half-space the fluxes of s and p light have different factors, which a far field
/// does not keep apart.
const ABSORBING_EXIT: WaveError = WaveError::NotInVectorMode {
    what: "the gradient with an absorbing half-space",
    reason: "the fluxes of s and p light into it are not kept apart",
    remedy: "give the half-space k = 0, leave out --gradient, or use the scalar wave",
};

/// The derivatives with respect to one medium, one entry for each polarisation.
pub struct Gradient {
    medium: Medium,
    index: Complex64,
    slopes: Vec<FarSlopes>,
}

/// Derivatives with respect to all media of a case, on the grid of its solution.
///
/// # Errors
/// A solve does not reach the residual.
pub fn gradients(task: &Task, e: &Estimated) -> Result<Vec<Gradient>, AccuracyError> {
    let Media { backgrounds, inclusions, .. } = task.media;
    let backgrounds = backgrounds.iter().enumerate().map(|(i, &index)| (Medium::Background(i), index));
    let inclusions = inclusions.iter().enumerate().map(|(i, &index)| (Medium::Inclusion(i), index));
    let goal = Goal { tolerance: task.goal.tolerance.min(RESIDUAL), ..task.goal };
    let task = Task { goal, ..*task };
    if e.system().polarisation().is_some()
        && [task.media.incident, task.media.exit].iter().any(|eta| eta.im > 0.0)
    {
        return Err(ABSORBING_EXIT.into());
    }
    let (sharper, _) = task.solve(e.system().grid().resolution, &mut Silent)?;
    backgrounds.chain(inclusions).map(|(medium, index)| gradient(&task, &sharper, medium, index)).collect()
}

fn gradient(
    task: &Task,
    solved: &[Solved],
    medium: Medium,
    index: Complex64,
) -> Result<Gradient, AccuracyError> {
    let geometry = task.coverages.at(solved[0].system.grid().resolution)?;
    let mut moved = Vec::new();
    for step in DIRECTIONS.map(|direction| STEP * direction) {
        let systems = geometry.systems(&task.media.moved(medium, step), task.incidence, task.mean)?;
        moved.push((step, systems.into_iter()));
    }
    let mut slopes = Vec::new();
    for Solved { system, solution } in solved {
        let neighbours = moved.iter_mut();
        let neighbours: Vec<Neighbour> = neighbours
            .filter_map(|(step, systems)| Some(Neighbour { step: *step, system: systems.next()? }))
            .collect();
        let field = &solution.field;
        slopes.push(tangent((&**system, field), &neighbours, (task.solver, task.goal), &mut Silent)?);
    }
    Ok(Gradient { medium, index, slopes })
}

impl Gradient {
    fn name(&self) -> String {
        match self.medium {
            Medium::Background(i) => format!("background {i}"),
            Medium::Inclusion(i) => format!("inclusion {i}"),
        }
    }

    /// As an entry of the result; `orders` are those of the first polarisation.
    pub fn json(&self, orders: &[Order]) -> Value {
        let total = |of: fn(&FarSlopes) -> Slopes| self.by_polarisation(|s| pair(of(s)));
        json!({
            "medium": self.name(),
            "index": [self.index.re, self.index.im],
            "R_total": total(|s| s.reflectance),
            "T_total": total(|s| s.transmittance),
            "A_total": total(|s| s.absorptance),
            "orders": orders.iter().enumerate().map(|(k, order)| self.order(k, order)).collect::<Vec<_>>(),
        })
    }

    fn order(&self, k: usize, order: &Order) -> Value {
        let amplitude = |side: usize| {
            self.by_polarisation(|s| {
                let z = s.orders[k].amplitudes[0][side];
                json!([z.re, z.im])
            })
        };
        json!({
            "m": order.m,
            "n": order.n,
            "R": amplitude(0),
            "T": amplitude(1),
            "eff_R": self.by_polarisation(|s| pair(s.orders[k].reflected)),
            "eff_T": self.by_polarisation(|s| pair(s.orders[k].transmitted)),
        })
    }

    fn by_polarisation(&self, of: impl Fn(&FarSlopes) -> Value) -> Value {
        by_polarisation(&self.slopes.iter().map(of).collect::<Vec<_>>())
    }

    /// The totals' derivatives as lines of a table.
    pub fn text(&self) -> String {
        let mut lines = format!("{} (n = {}, k = {})\n", self.name(), self.index.re, self.index.im);
        for (slopes, light) in self.slopes.iter().zip(["s", "p"]) {
            let light = if self.slopes.len() == 1 { "" } else { light };
            let totals = [("R", slopes.reflectance), ("T", slopes.transmittance), ("A", slopes.absorptance)];
            for (name, [dn, dk]) in totals {
                lines += &format!("  {name} {light:1}  d/dn {dn:+.8e}  d/dk {dk:+.8e}\n");
            }
        }
        lines
    }
}

fn pair([dn, dk]: Slopes) -> Value {
    json!({ "dn": dn, "dk": dk })
}
