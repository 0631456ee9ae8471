//! Equilibration: Metropolis moves of grains as hard bodies, in the aligning field if there is one.
//!
//! A relaxed packing is neither random addition nor a fluid in equilibrium; after enough sweeps its statistics are
//! those of hard bodies in equilibrium, for which analytic truths exist (Percus–Yevick, Verlet–Weis).

use super::bodies::Bodies;
use super::buckets::Buckets;
use super::plan::PackingPlan;
use super::sequential::is_free;
use super::watch::{PackProgress, PackWatch};
use crate::ink::error::PackError;
use crate::numerics::Draws;
use crate::numerics::vector::{Rotation, V3, add, scale};
use std::ops::ControlFlow;

/// Acceptance at which the step length is aimed; anything between 0.2 and 0.6 mixes about as fast.
const AIM: f64 = 0.4;
/// Part of the sweeps during which the step is tuned; detailed balance holds exactly in the rest.
const TUNING: f64 = 0.2;

/// Runs `sweeps` sweeps of one trial move per body; returns the share of moves accepted after tuning.
pub(crate) fn equilibrate(
    bodies: &mut Bodies,
    plan: &PackingPlan,
    sweeps: u64,
    draws: &mut Draws,
    watch: &mut dyn PackWatch,
) -> Result<f64, PackError> {
    let widest = bodies.radius.iter().copied().fold(0.0, f64::max);
    let mut grid = Buckets::new(&bodies.cell, 2.0 * widest * (1.0 + 1e-6), bodies.radius.len());
    (0..bodies.spheres()).for_each(|s| grid.insert(s, grid.cell_of(bodies.at[s])));
    let mut walk = Walk { bodies, plan, grid, step: 0.2, old_cells: Vec::new() };
    let n = walk.bodies.placed;
    let tuned = (TUNING * sweeps as f64).ceil() as u64;
    let (mut accepted, mut tried) = (0, 0);
    for sweep in 0..sweeps {
        let hits = (0..n).filter(|_| walk.trial(draws)).count();
        if sweep < tuned {
            let rate = hits as f64 / n.max(1) as f64;
            walk.step = (walk.step * (1.0 + 0.5 * (rate - AIM))).clamp(1e-4, 1.0);
        } else {
            accepted += hits;
            tried += n;
        }
        if sweep % 10 == 0 {
            report(plan, sweep, watch)?;
        }
    }
    Ok(accepted as f64 / tried.max(1) as f64)
}

struct Walk<'w, 'a> {
    bodies: &'w mut Bodies<'a>,
    plan: &'w PackingPlan,
    grid: Buckets,
    /// Half the side of the cube of displacements, in radii of the body's first sphere.
    step: f64,
    old_cells: Vec<usize>,
}

impl Walk<'_, '_> {
    /// One move of a random body: a displacement and, for bodies of several spheres, a turn. True if accepted.
    fn trial(&mut self, draws: &mut Draws) -> bool {
        let b = draws.below(self.bodies.placed);
        let body = &self.plan.bodies[b];
        let (centre, rotation) = (self.bodies.centre[b], self.bodies.rotation[b]);
        let length = self.step * body.spheres[0].radius_um;
        let by: V3 = std::array::from_fn(|_| draws.between(-length, length));
        self.old_cells.clear();
        self.old_cells.extend(self.spheres(b).map(|s| self.grid.cell_of(self.bodies.at[s])));
        let before = self.exponent(b);
        if self.may_turn(b) {
            let turn = scale(draws.direction(), draws.between(0.0, length / body.reach));
            self.bodies.put(b, add(centre, by), rotation.then(Rotation::by(turn)));
        } else {
            self.bodies.shift(b, add(centre, by));
        }
        let change = self.exponent(b) - before;
        let allowed = change >= 0.0 || draws.uniform() < change.exp();
        if allowed && is_free(self.bodies, &self.grid, b) {
            self.follow(b);
            return true;
        }
        if self.may_turn(b) {
            self.bodies.put(b, centre, rotation);
        } else {
            self.bodies.shift(b, centre);
        }
        false
    }

    fn spheres(&self, b: usize) -> std::ops::Range<usize> {
        self.bodies.first[b]..self.bodies.first[b + 1]
    }

    /// Single spheres need no turning; perfectly aligned grains must not turn.
    fn may_turn(&self, b: usize) -> bool {
        let body = &self.plan.bodies[b];
        let frozen = self.plan.fields[body.pigment].is_some_and(|f| f.kappa.is_infinite());
        !body.single_sphere() && !frozen
    }

    /// The exponent of the Boltzmann weight in the aligning field.
    fn exponent(&self, b: usize) -> f64 {
        match &self.plan.fields[self.plan.bodies[b].pigment] {
            Some(field) if field.kappa.is_finite() => field.exponent(self.bodies.axes(b)),
            _ => 0.0,
        }
    }

    /// Carries the grid along after an accepted move.
    fn follow(&mut self, b: usize) {
        for (k, s) in self.spheres(b).enumerate() {
            let (old, new) = (self.old_cells[k], self.grid.cell_of(self.bodies.at[s]));
            if old != new {
                self.grid.remove(s, old);
                self.grid.insert(s, new);
            }
        }
    }
}

fn report(plan: &PackingPlan, sweep: u64, watch: &mut dyn PackWatch) -> Result<(), PackError> {
    let progress = PackProgress {
        stage: "equilibration",
        step: sweep,
        grains_placed: plan.grains(),
        grains_wanted: plan.grains(),
        fraction: plan.fraction(),
        overlap_energy: 0.0,
        largest_overlap_um: 0.0,
    };
    match watch.progress(&progress) {
        ControlFlow::Continue(()) => Ok(()),
        ControlFlow::Break(()) => Err(PackError::Stopped { stage: progress.stage, steps: sweep }),
    }
}
