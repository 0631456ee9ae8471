//! The highest volume fraction attainable when a packing fails: fewer of the same grains.

use super::bodies::Bodies;
use super::relaxation::OverlapRelaxation;
use super::request::RelaxationSettings;
use super::strain::strain;
use super::watch::PackWatch;
use crate::ink::error::{PackError, Reached};
use crate::numerics::Draws;
use crate::numerics::vector::{Rotation, V3};

/// Relaxation steps of each round.
const STEPS: u64 = 400;
/// Fraction of the bodies removed per round.
const TAKEN_OUT: f64 = 0.01;
const ROUNDS: usize = 60;

/// The highest volume fraction reached from a stuck arrangement: the bodies with the largest
/// overlap are removed, a hundredth at a time, and the rest relaxes again until nothing overlaps.
/// `None` if that takes more than [`ROUNDS`].
pub(crate) fn fit_fewer(
    stuck: &Bodies,
    settings: &RelaxationSettings,
    draws: &mut Draws,
    watch: &mut dyn PackWatch,
) -> Result<Option<Reached>, PackError> {
    let mut kept: Vec<(usize, V3, Rotation)> =
        (0..stuck.placed).map(|b| (b, stuck.centre[b], stuck.rotation[b])).collect();
    for _ in 0..ROUNDS {
        let plan = stuck.plan.subset(kept.iter().map(|(b, ..)| *b));
        let mut bodies = Bodies::new(&plan);
        kept.iter().enumerate().for_each(|(b, (_, centre, rotation))| bodies.put(b, *centre, *rotation));
        bodies.placed = kept.len();
        let mut relaxation = OverlapRelaxation::new(&mut bodies, settings);
        relaxation.inflation = settings.inflation.min(1e-3);
        relaxation.start_all();
        if relaxation.settle(STEPS, draws, watch)?.is_none() {
            return Ok(Some(plan.reached(kept.len())));
        }
        let strain = strain(&bodies);
        let mut order: Vec<usize> = (0..kept.len()).collect();
        order.sort_by(|a, b| strain[*b].total_cmp(&strain[*a]));
        let mut left = order.split_off((TAKEN_OUT * kept.len() as f64).ceil() as usize);
        left.sort_unstable();
        kept = left.into_iter().map(|b| (kept[b].0, bodies.centre[b], bodies.rotation[b])).collect();
    }
    Ok(None)
}
