//! Hard bodies, moved one at a time.
//!
//! Random sequential addition (P1 section 3, the dilute case): positions with an overlap are
//! redrawn.
//!
//! Equilibration: Metropolis moves of grains as hard bodies, in the aligning field if there is one.
//! A relaxed packing is neither a random sequential addition nor an equilibrium fluid. After enough
//! sweeps its statistics are those of hard bodies in equilibrium, for which analytic results exist
//! (Percus–Yevick, Verlet–Weis).

use super::arrangement::{Arrangement, Pose};
use crate::ink::error::{Course, PackError, Reached};
use crate::numerics::Draws;
use crate::numerics::vector::{Rotation, V3, add, scale};

/// Attempts to place a body of a profile at one depth: redrawing the depth as well would thin out
/// where grains are dense. Three spheres of ten thousand tries fit where 30 % are taken.
const TRIES_AT_DEPTH: u64 = 10_000;
/// Attempts between two reports to the watch.
const REPORT: u64 = 100_000;

/// Places all bodies of the plan in order; returns the number of attempts.
pub(crate) fn add_all(arrangement: &mut Arrangement, course: &mut Course) -> Result<u64, PackError> {
    let plan = arrangement.plan;
    let mut attempts = 0;
    for b in 0..plan.bodies.len() {
        let mut kept = None;
        let first = attempts;
        let limit = attempts + plan.request.sequential.attempts_per_grain;
        loop {
            attempts += 1;
            // A uniform position between the walls and a random orientation.
            let rotation = plan.draw_rotation(b, &mut course.draws);
            let mut centre = plan.cell.draw_place(&mut course.draws);
            if plan.profile_of(b).is_some() {
                // where it is crowded, another place at the same depth is sought first
                let fresh = (attempts - first).is_multiple_of(TRIES_AT_DEPTH);
                centre[2] = kept.filter(|_| !fresh).unwrap_or(centre[2]);
                kept = Some(centre[2]);
            }
            if arrangement.add_if_free(Pose { centre, rotation }) {
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
    }
    Ok(attempts)
}

/// Target acceptance rate of the step length; values between 0.2 and 0.6 mix about equally fast.
const TARGET_ACCEPTANCE: f64 = 0.4;
/// Fraction of the sweeps used to tune the step; detailed balance holds exactly in the rest.
const TUNING: f64 = 0.2;

/// Runs `sweeps` sweeps of one trial move per body; returns the acceptance rate after tuning.
pub(crate) fn equilibrate(
    arrangement: &mut Arrangement,
    sweeps: u64,
    course: &mut Course,
) -> Result<f64, PackError> {
    let plan = arrangement.plan;
    let bodies = arrangement.placed();
    // Half the side of the cube of trial displacements, in radii of the body's first sphere.
    let mut step = 0.2;
    let tuning_sweeps = (TUNING * sweeps as f64).ceil() as u64;
    let mut accepted = 0;
    let mut tried = 0;
    for sweep in 0..sweeps {
        let moved = (0..bodies).filter(|_| trial_move(arrangement, step, &mut course.draws)).count();
        if sweep < tuning_sweeps {
            let rate = moved as f64 / bodies.max(1) as f64;
            step = (step * (1.0 + 0.5 * (rate - TARGET_ACCEPTANCE))).clamp(1e-4, 1.0);
        } else {
            accepted += moved;
            tried += bodies;
        }
        if sweep % 10 == 0 {
            plan.progress("equilibration", sweep, bodies).report(course)?;
        }
    }
    Ok(accepted as f64 / tried.max(1) as f64)
}

/// One trial move of a random body: a displacement and, for bodies of several spheres, a rotation.
/// Returns whether it was accepted.
fn trial_move(arrangement: &mut Arrangement, step: f64, draws: &mut Draws) -> bool {
    let b = draws.below(arrangement.placed());
    let body = &arrangement.plan.bodies[b];
    let field = arrangement.plan.fields[body.pigment];
    let Pose { centre, rotation } = arrangement.pose(b);
    let length = step * body.spheres[0].radius_um;
    let displacement: V3 = std::array::from_fn(|_| draws.between(-length, length));
    // Single spheres need no rotation, perfectly aligned grains allow none.
    let frozen = field.is_some_and(|field| field.kappa.is_infinite());
    let turned = if body.single_sphere() || frozen {
        rotation
    } else {
        let turn = scale(draws.direction(), draws.between(0.0, length / body.reach));
        rotation.then(Rotation::by(turn))
    };
    // Change of the exponent of the Boltzmann weight in the aligning field.
    let change = match field {
        Some(field) if field.kappa.is_finite() => {
            field.exponent(body.axes(turned)) - field.exponent(body.axes(rotation))
        }
        _ => 0.0,
    };
    let allowed = change >= 0.0 || draws.uniform() < change.exp();
    allowed && arrangement.move_if_free(b, Pose { centre: add(centre, displacement), rotation: turned })
}
