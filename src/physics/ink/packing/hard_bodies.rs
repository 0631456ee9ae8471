//! Hard bodies, moved one at a time.
//!
//! Random sequential addition (P1 section 3, the dilute case): positions with an overlap are
//! redrawn.
//!
//! Equilibration: Metropolis moves of grains as hard bodies, in the aligning field if there is one.
//! A relaxed packing is neither a random sequential addition nor an equilibrium fluid. After enough
//! sweeps its statistics are those of hard bodies in equilibrium, for which analytic results exist
//! (Percus–Yevick, Verlet–Weis).

use super::bodies::Bodies;
use super::cell::Buckets;
use crate::ink::error::{Course, PackError, Reached};
use crate::numerics::Draws;
use crate::numerics::vector::{Rotation, V3, add, dot, scale};

/// Gaps below this fraction of the sum of radii count as overlap, so that rounding cannot fail the
/// final check.
pub(crate) const MARGIN: f64 = 1e-10;

/// Attempts between two reports to the watch.
const REPORT: u64 = 100_000;

/// Places all bodies of the plan in order; returns the number of attempts.
pub(crate) fn add_all(bodies: &mut Bodies, course: &mut Course) -> Result<u64, PackError> {
    let plan = bodies.plan;
    let (mut grid, mut attempts) = (grid(bodies), 0);
    for b in 0..plan.bodies.len() {
        let limit = attempts + plan.request.sequential.attempts_per_grain;
        loop {
            attempts += 1;
            // A uniform position between the walls and a random orientation.
            let rotation = plan.draw_rotation(b, &mut course.draws);
            bodies.put(b, bodies.cell.draw_place(&mut course.draws), rotation);
            if is_free(bodies, &grid, b) {
                break;
            }
            if attempts % REPORT == 0 {
                plan.progress("sequential addition", attempts, b).report(course)?;
            }
            if attempts >= limit {
                let Reached { fraction: reached, grains: placed } = plan.reached(b);
                let Reached { fraction: requested, grains: wanted } = plan.whole();
                return Err(PackError::Blocked { requested, reached, placed, wanted, attempts });
            }
        }
        bodies.range(b).for_each(|s| grid.insert(s, bodies.at[s]));
        bodies.placed = b + 1;
    }
    Ok(attempts)
}

/// The spheres of the placed bodies on a grid as wide as the largest.
fn grid(bodies: &Bodies) -> Buckets {
    let widest = bodies.radius.iter().copied().fold(0.0, f64::max);
    let mut grid = Buckets::new(&bodies.cell, 2.0 * widest * (1.0 + 1e-6), bodies.radius.len());
    (0..bodies.spheres()).for_each(|s| grid.insert(s, bodies.at[s]));
    grid
}

/// Whether body b overlaps neither a wall nor another body in the grid.
fn is_free(bodies: &Bodies, grid: &Buckets, b: usize) -> bool {
    let (height, [low, high]) = (bodies.cell.size[2], bodies.span_z(b).map(|z| bodies.centre[b][2] + z));
    let between = !bodies.cell.walls || (low >= MARGIN * height && high <= height - MARGIN * height);
    between && bodies.range(b).all(|s| is_free_sphere(bodies, grid, b, s))
}

/// Whether sphere s of body b overlaps no sphere of another body in the grid.
#[inline]
fn is_free_sphere(bodies: &Bodies, grid: &Buckets, b: usize, s: usize) -> bool {
    let (p, r) = (bodies.at[s], bodies.radius[s]);
    grid.around(grid.cell_of(p)).all(|t| {
        let d = bodies.cell.delta(p, bodies.at[t]);
        let reach = (r + bodies.radius[t]) * (1.0 + MARGIN);
        dot(d, d) >= reach * reach || bodies.owner[t] == b as u32 || is_apart(bodies, s, t, d)
    })
}

/// Gaps between convex bodies below this fraction of the sum of their thinnest radii count as
/// overlap: the proof of their separation finds its direction by iteration.
pub(crate) const CONVEX_MARGIN: f64 = 1e-6;

/// Whether two bodies of which one is convex are apart although the spheres around them are not.
fn is_apart(bodies: &Bodies, s: usize, t: usize, d: V3) -> bool {
    let thin = |s: usize| bodies.plan.bodies[bodies.owner[s] as usize].thin;
    let margin = CONVEX_MARGIN * (thin(s) + thin(t));
    !bodies.are_spheres(s, t) && bodies.contact(s, t, d, margin).is_none_or(|c| c.gap_um > margin)
}

/// A random start for the relaxation, overlaps allowed: at `place`, with z rescaled to the range
/// accessible to the rotated grain between the walls.
pub(crate) fn scatter(bodies: &mut Bodies, b: usize, place: V3, draws: &mut Draws) {
    bodies.put(b, place, bodies.plan.draw_rotation(b, draws));
    if bodies.cell.walls {
        let [low, high] = bodies.span_z(b);
        let height = bodies.cell.size[2];
        let room = height - (high - low);
        // A grain too long for the layer in its orientation starts in the middle; the walls will
        // rotate it.
        let z = if room > 0.0 { place[2] / height * room - low } else { 0.5 * (height - high - low) };
        bodies.shift(b, [place[0], place[1], z]);
    }
}

/// Target acceptance rate of the step length; values between 0.2 and 0.6 mix about equally fast.
const TARGET_ACCEPTANCE: f64 = 0.4;
/// Fraction of the sweeps used to tune the step; detailed balance holds exactly in the rest.
const TUNING: f64 = 0.2;

/// Runs `sweeps` sweeps of one trial move per body; returns the acceptance rate after tuning.
pub(crate) fn equilibrate(bodies: &mut Bodies, sweeps: u64, course: &mut Course) -> Result<f64, PackError> {
    let (plan, n) = (bodies.plan, bodies.placed);
    let mut walk = Walk { grid: grid(bodies), bodies, step: 0.2 };
    let tuned = (TUNING * sweeps as f64).ceil() as u64;
    let (mut accepted, mut tried) = (0, 0);
    for sweep in 0..sweeps {
        let hits = (0..n).filter(|_| walk.trial(&mut course.draws)).count();
        if sweep < tuned {
            let rate = hits as f64 / n.max(1) as f64;
            walk.step = (walk.step * (1.0 + 0.5 * (rate - TARGET_ACCEPTANCE))).clamp(1e-4, 1.0);
        } else {
            accepted += hits;
            tried += n;
        }
        if sweep % 10 == 0 {
            plan.progress("equilibration", sweep, n).report(course)?;
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
        let accepted = allowed && is_free(self.bodies, &self.grid, b);
        match accepted {
            true => self.bodies.range(b).for_each(|s| self.grid.follow(s, self.bodies.at[s])),
            false if self.may_turn(b) => self.bodies.put(b, centre, rotation),
            false => self.bodies.shift(b, centre),
        }
        accepted
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
