//! Equilibration: Metropolis moves of grains as hard bodies, in the aligning field if there is one.
//!
//! A relaxed packing is neither a random sequential addition nor an equilibrium fluid. After enough
//! sweeps its statistics are those of hard bodies in equilibrium, for which analytic results exist
//! (Percus–Yevick, Verlet–Weis).

use super::bodies::Bodies;
use super::buckets::Buckets;
use super::sequential::{grid, is_free};
use super::watch::PackWatch;
use crate::ink::error::PackError;
use crate::numerics::Draws;
use crate::numerics::vector::{Rotation, V3, add, scale};

/// Target acceptance rate of the step length; values between 0.2 and 0.6 mix about equally fast.
const TARGET_ACCEPTANCE: f64 = 0.4;
/// Fraction of the sweeps used to tune the step; detailed balance holds exactly in the rest.
const TUNING: f64 = 0.2;

/// Runs `sweeps` sweeps of one trial move per body; returns the acceptance rate after tuning.
pub(crate) fn equilibrate(
    bodies: &mut Bodies,
    sweeps: u64,
    draws: &mut Draws,
    watch: &mut dyn PackWatch,
) -> Result<f64, PackError> {
    let (plan, grid) = (bodies.plan, grid(bodies));
    let mut walk = Walk { bodies, grid, step: 0.2 };
    let n = walk.bodies.placed;
    let tuned = (TUNING * sweeps as f64).ceil() as u64;
    let (mut accepted, mut tried) = (0, 0);
    for sweep in 0..sweeps {
        let hits = (0..n).filter(|_| walk.trial(draws)).count();
        if sweep < tuned {
            let rate = hits as f64 / n.max(1) as f64;
            walk.step = (walk.step * (1.0 + 0.5 * (rate - TARGET_ACCEPTANCE))).clamp(1e-4, 1.0);
        } else {
            accepted += hits;
            tried += n;
        }
        if sweep % 10 == 0 {
            plan.progress("equilibration", sweep, n).report(watch)?;
        }
    }
    Ok(accepted as f64 / tried.max(1) as f64)
}

struct Walk<'w, 'a> {
    bodies: &'w mut Bodies<'a>,
    grid: Buckets,
    /// Half the side of the cube of trial displacements, in radii of the body's first sphere.
    step: f64,
}

impl Walk<'_, '_> {
    /// One trial move of a random body: a displacement and, for bodies of several spheres, a
    /// rotation. Returns whether it was accepted.
    fn trial(&mut self, draws: &mut Draws) -> bool {
        let b = draws.below(self.bodies.placed);
        let body = &self.bodies.plan.bodies[b];
        let (centre, rotation) = (self.bodies.centre[b], self.bodies.rotation[b]);
        let length = self.step * body.spheres[0].radius_um;
        let by: V3 = std::array::from_fn(|_| draws.between(-length, length));
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
            self.bodies.range(b).for_each(|s| self.grid.follow(s, self.bodies.at[s]));
            return true;
        }
        if self.may_turn(b) {
            self.bodies.put(b, centre, rotation);
        } else {
            self.bodies.shift(b, centre);
        }
        false
    }

    /// Whether rotations are tried: single spheres need none, perfectly aligned grains allow none.
    fn may_turn(&self, b: usize) -> bool {
        let body = &self.bodies.plan.bodies[b];
        let frozen = self.bodies.plan.fields[body.pigment].is_some_and(|f| f.kappa.is_infinite());
        !body.single_sphere() && !frozen
    }

    /// Exponent of the Boltzmann weight in the aligning field.
    fn exponent(&self, b: usize) -> f64 {
        match &self.bodies.plan.fields[self.bodies.plan.bodies[b].pigment] {
            Some(field) if field.kappa.is_finite() => field.exponent(self.bodies.axes(b)),
            _ => 0.0,
        }
    }
}
