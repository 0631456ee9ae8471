//! Random sequential addition (P1 section 3, the dilute case): positions with an overlap are
//! redrawn.

use super::bodies::Bodies;
use super::buckets::Buckets;
use super::cell::CellBox;
use super::watch::PackWatch;
use crate::ink::error::{PackError, Reached};
use crate::numerics::Draws;
use crate::numerics::vector::{V3, dot};

/// Gaps below this fraction of the sum of radii count as overlap, so that rounding cannot fail the
/// final check.
pub(crate) const MARGIN: f64 = 1e-10;

/// Attempts between two reports to the watch.
const REPORT: u64 = 100_000;

/// Places all bodies of the plan in order; returns the number of attempts.
pub(crate) fn add_all(
    bodies: &mut Bodies,
    attempts_per_grain: u64,
    draws: &mut Draws,
    watch: &mut dyn PackWatch,
) -> Result<u64, PackError> {
    let plan = bodies.plan;
    let mut grid = grid(bodies);
    let mut attempts = 0;
    for b in 0..plan.bodies.len() {
        let limit = attempts + attempts_per_grain;
        loop {
            attempts += 1;
            if throw(bodies, &grid, b, draws) {
                break;
            }
            if attempts % REPORT == 0 {
                plan.progress("sequential addition", attempts, b).report(watch)?;
            }
            if attempts >= limit {
                let Reached { fraction: reached, grains: placed } = plan.reached(b);
                let (requested, wanted) = (plan.fraction(), plan.grains());
                return Err(PackError::Blocked { requested, reached, placed, wanted, attempts });
            }
        }
        bodies.range(b).for_each(|s| grid.insert(s, bodies.at[s]));
        bodies.placed = b + 1;
    }
    Ok(attempts)
}

/// The spheres of the placed bodies on a grid as wide as the largest.
pub(crate) fn grid(bodies: &Bodies) -> Buckets {
    let widest = bodies.radius.iter().copied().fold(0.0, f64::max);
    let mut grid = Buckets::new(&bodies.cell, 2.0 * widest * (1.0 + 1e-6), bodies.radius.len());
    (0..bodies.spheres()).for_each(|s| grid.insert(s, bodies.at[s]));
    grid
}

/// One attempt: a uniform position between the walls and a random orientation; returns whether it
/// is free.
fn throw(bodies: &mut Bodies, grid: &Buckets, b: usize, draws: &mut Draws) -> bool {
    let rotation = bodies.plan.draw_rotation(b, draws);
    bodies.put(b, bodies.cell.draw_place(draws), rotation);
    is_free(bodies, grid, b)
}

/// Whether body b overlaps neither a wall nor another body in the grid.
pub(crate) fn is_free(bodies: &Bodies, grid: &Buckets, b: usize) -> bool {
    if bodies.cell.walls && !between_walls(&bodies.cell, bodies.centre[b], bodies.span_z(b)) {
        return false;
    }
    bodies.range(b).all(|s| is_free_sphere(bodies, grid, b, s))
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

fn between_walls(cell: &CellBox, centre: V3, span: [f64; 2]) -> bool {
    let margin = MARGIN * cell.size[2];
    centre[2] + span[0] >= margin && centre[2] + span[1] <= cell.size[2] - margin
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
