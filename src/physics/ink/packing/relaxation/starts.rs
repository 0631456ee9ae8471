//! Relaxation from random starts, and how many bodies would fit where none of them succeeds.

use super::OverlapRelaxation;
use crate::ink::error::{Course, PackError, Reached};
use crate::ink::packing::arrangement::{Arrangement, Pose};
use crate::ink::packing::plan::PackingPlan;

/// Whether a small crowded cell jams is a matter of chance: of 50 % of upright cylinders, 18 of 40
/// cells with 90–160 bodies do, and 7 of 40 with 220–370. They start anew elsewhere. Cells with
/// many more bodies are alike, and another start would end as the first.
const BODIES_OF_ALL_STARTS: usize = 3000;
const MOST_STARTS: usize = 8;

/// Bodies without overlap.
pub(crate) struct Relaxed<'a> {
    pub arrangement: Arrangement<'a>,
    /// Steps of all starts.
    pub steps: u64,
}

/// Relaxes all bodies of a plan, from other places if they jam. If they do not fit, the error
/// states how many would.
pub(crate) fn relax<'a>(plan: &'a PackingPlan<'a>, course: &mut Course) -> Result<Relaxed<'a>, PackError> {
    let starts = (BODIES_OF_ALL_STARTS / plan.bodies.len()).clamp(1, MOST_STARTS);
    let mut steps = 0;
    let mut start = 1;
    loop {
        let mut relaxation = OverlapRelaxation::new(Arrangement::new(plan));
        let overlaps = relaxation.place_all(course)?;
        let arrangement = relaxation.arrangement;
        steps += relaxation.steps;
        match overlaps {
            None => return Ok(Relaxed { arrangement, steps }),
            Some(_) if start < starts => start += 1,
            Some(overlaps) => {
                let Reached { fraction: requested, grains: wanted } = plan.whole();
                return Err(PackError::NotReached {
                    requested,
                    reached: fit_fewer(&arrangement, course)?,
                    wanted,
                    steps,
                    largest_overlap_um: overlaps.deepest,
                    relative_overlap: overlaps.deepest_relative,
                });
            }
        }
    }
}

/// Relaxation steps of each round.
const STEPS: u64 = 400;
/// Fraction of the bodies removed per round.
const REMOVED: f64 = 0.01;
const ROUNDS: usize = 60;

/// A body of the plan that is still in the cell.
#[derive(Clone, Copy)]
struct KeptBody {
    number: usize,
    pose: Pose,
}

/// The highest volume fraction reached from a stuck arrangement: the bodies with the largest
/// overlap are removed, a hundredth at a time, and the rest relaxes again until nothing overlaps.
/// `None` if that takes more than [`ROUNDS`].
fn fit_fewer(stuck: &Arrangement, course: &mut Course) -> Result<Option<Reached>, PackError> {
    let all = 0..stuck.placed();
    let mut kept: Vec<KeptBody> = all.map(|number| KeptBody { number, pose: stuck.pose(number) }).collect();
    for _ in 0..ROUNDS {
        let plan = stuck.plan.subset(kept.iter().map(|body| body.number));
        let mut arrangement = Arrangement::new(&plan);
        kept.iter().enumerate().for_each(|(b, body)| arrangement.put(b, body.pose));
        arrangement.set_placed(kept.len());
        let mut relaxation = OverlapRelaxation::new(arrangement);
        relaxation.inflation = relaxation.inflation.min(1e-3);
        relaxation.start_all();
        if relaxation.settle(STEPS, course)?.is_none() {
            return Ok(Some(plan.reached(kept.len())));
        }
        let arrangement = relaxation.arrangement;
        let strain = arrangement.strain();
        let mut by_strain: Vec<usize> = (0..kept.len()).collect();
        by_strain.sort_by(|a, b| strain[*b].total_cmp(&strain[*a]));
        let mut rest = by_strain.split_off((REMOVED * kept.len() as f64).ceil() as usize);
        rest.sort_unstable();
        let still_there = |b: usize| KeptBody { number: kept[b].number, pose: arrangement.pose(b) };
        kept = rest.into_iter().map(still_there).collect();
    }
    Ok(None)
}
