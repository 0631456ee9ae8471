//! The highest concentration of a packing that was not reached: fewer of the same grains.

use super::bodies::Bodies;
use super::neighbours::Neighbours;
use super::plan::Plan;
use super::relaxation::Relaxation;
use super::request::RelaxationSettings;
use super::watch::PackWatch;
use crate::ink::error::PackError;
use crate::numerics::Draws;
use crate::numerics::vector::{Rotation, V3, norm};

/// Steps of each round.
const STEPS: u64 = 400;
/// Part of the bodies taken out at a time, and how often.
const TAKEN_OUT: f64 = 0.01;
const ROUNDS: usize = 60;

/// The highest concentration these grains reach from where they are stuck: the bodies that overlap most are
/// taken out, a hundredth at a time, and the rest relaxes again, until nothing overlaps.
pub(crate) fn fit_fewer(
    stuck: &Bodies,
    plan: &Plan,
    settings: &RelaxationSettings,
    draws: &mut Draws,
    watch: &mut dyn PackWatch,
) -> Result<Vec<usize>, PackError> {
    let mut kept: Vec<usize> = (0..stuck.placed).collect();
    let mut state: Vec<(V3, Rotation)> =
        kept.iter().map(|b| (stuck.centre[*b], stuck.rotation[*b])).collect();
    for _ in 0..ROUNDS {
        let plan = plan.subset(&kept);
        let mut bodies = Bodies::new(stuck.cell, &plan.bodies);
        state.iter().enumerate().for_each(|(b, (centre, rotation))| bodies.put(b, *centre, *rotation));
        bodies.placed = kept.len();
        let mut relaxation = Relaxation::new(&mut bodies, &plan, settings);
        relaxation.inflation = settings.inflation.min(1e-3);
        relaxation.start_all();
        if relaxation.settle(STEPS, draws, watch)?.is_none() {
            return Ok(kept);
        }
        let strain = strain(&bodies);
        let mut order: Vec<usize> = (0..kept.len()).collect();
        order.sort_by(|a, b| strain[*b].total_cmp(&strain[*a]));
        let mut out: Vec<usize> = order[..(TAKEN_OUT * kept.len() as f64).ceil() as usize].to_vec();
        out.sort_unstable();
        state = (0..kept.len()).map(|b| (bodies.centre[b], bodies.rotation[b])).collect();
        for b in out.into_iter().rev() {
            kept.remove(b);
            state.remove(b);
        }
    }
    Ok(Vec::new())
}

/// Overlap energy of each body.
pub(crate) fn strain(bodies: &Bodies) -> Vec<f64> {
    let list = Neighbours::new(bodies, 0.0, 0.0);
    let mut strain = vec![0.0; bodies.placed];
    for s in 0..bodies.spheres() {
        let (p, r) = (bodies.at[s], bodies.radius[s]);
        let mut push = |depth: f64| strain[bodies.owner[s] as usize] += depth.max(0.0).powi(2);
        if bodies.cell.walls {
            push(2.0 * (r - p[2].min(bodies.cell.size[2] - p[2])));
        }
        for t in list.of(s).iter().map(|t| *t as usize) {
            push(r + bodies.radius[t] - norm(bodies.cell.delta(p, bodies.at[t])));
        }
    }
    strain
}
