//! The highest concentration of a packing that was not reached: fewer of the same grains.

use super::bodies::Bodies;
use super::plan::PackingPlan;
use super::relaxation::OverlapRelaxation;
use super::request::RelaxationSettings;
use super::strain::strain;
use super::watch::PackWatch;
use crate::ink::error::{PackError, Reached};
use crate::numerics::Draws;
use crate::numerics::vector::{Rotation, V3};

/// Steps of each round.
const STEPS: u64 = 400;
/// Part of the bodies taken out at a time, and how often.
const TAKEN_OUT: f64 = 0.01;
const ROUNDS: usize = 60;

/// The highest concentration these grains reach from where they are stuck: the bodies that overlap most are
/// taken out, a hundredth at a time, and the rest relaxes again, until nothing overlaps. `None` when that does not happen
/// within [`ROUNDS`].
pub(crate) fn fit_fewer(
    stuck: &Bodies,
    plan: &PackingPlan,
    settings: &RelaxationSettings,
    draws: &mut Draws,
    watch: &mut dyn PackWatch,
) -> Result<Option<Reached>, PackError> {
    let mut kept: Vec<usize> = (0..stuck.placed).collect();
    let mut state: Vec<(V3, Rotation)> =
        kept.iter().map(|b| (stuck.centre[*b], stuck.rotation[*b])).collect();
    for _ in 0..ROUNDS {
        let plan = plan.subset(&kept);
        let mut bodies = Bodies::new(stuck.cell, &plan.bodies);
        state.iter().enumerate().for_each(|(b, (centre, rotation))| bodies.put(b, *centre, *rotation));
        bodies.placed = kept.len();
        let mut relaxation = OverlapRelaxation::new(&mut bodies, &plan, settings);
        relaxation.inflation = settings.inflation.min(1e-3);
        relaxation.start_all();
        if relaxation.settle(STEPS, draws, watch)?.is_none() {
            return Ok(Some(reached(&plan)));
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
    Ok(None)
}

fn reached(plan: &PackingPlan) -> Reached {
    Reached { fraction: plan.fraction(), grains: plan.grains() }
}
