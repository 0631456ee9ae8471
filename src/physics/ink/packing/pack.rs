//! Packing of a request, with the final check for overlap.

use super::bodies::Bodies;
use super::hard_bodies::{add_all, equilibrate};
use super::neighbours::strain;
use super::placed::{Method, Packing, PackingAccount};
use super::plan::PackingPlan;
use super::relaxation::{OverlapRelaxation, relax_all};
use super::request::{AUTO_LIMIT, MethodChoice, PackingRequest};
use super::settle::settle;
use crate::ink::error::{Course, PackError, PackWatch, Reached};
use crate::numerics::Draws;
use crate::numerics::vector::{Rotation, V3};

/// Whether a small crowded cell jams is a matter of chance: of 50 % of upright cylinders, 18 of 40
/// cells with 90–160 bodies do, and 7 of 40 with 220–370. They start anew elsewhere. Cells with
/// many more bodies are alike, and another start would end as the first.
const BODIES_OF_ALL_STARTS: usize = 3000;
const MOST_STARTS: usize = 8;

/// Packs the grains of a request. Equal requests give packings that agree bit for bit, for any
/// number of threads. (Spheres use only +, −, ×, ÷ and √; rotated grains also sines, whose last bit
/// may depend on the platform's mathematical library.)
///
/// Errors: [`PackError::BadInput`] before any work, [`PackError::Blocked`] or
/// [`PackError::NotReached`] if the grains do not fit, [`PackError::Stopped`] if the watch requests
/// it. Source: P1 section 3.
///
/// ```
/// use inkwave_physics::ink::{PackingRequest, PigmentGrains, pack};
///
/// let request = PackingRequest {
///     period_um: [2.0, 2.0],
///     thickness_um: 1.0,
///     pigments: vec![PigmentGrains::spheres(250.0, 0.30)],
///     ..Default::default()
/// };
/// let packing = pack(&request, &mut ())?;
/// assert_eq!(packing.grains().len(), 147); // 0.30 × 4 µm³ over the volume of a sphere
/// assert!((packing.achieved_fraction(0) - 0.30).abs() < 0.002);
/// # Ok::<(), inkwave_physics::ink::PackError>(())
/// ```
pub fn pack(request: &PackingRequest, watch: &mut dyn PackWatch) -> Result<Packing, PackError> {
    if let Some(given) = Packing::given(request) {
        return given;
    }
    let asked = match request.method {
        MethodChoice::SequentialAddition => Some(Method::SequentialAddition),
        MethodChoice::Relaxation => Some(Method::Relaxation),
        MethodChoice::Auto => None,
    };
    let packing = match attempt(request, asked, watch) {
        Err(PackError::Blocked { .. }) if asked.is_none() => {
            let mut packing = attempt(request, Some(Method::Relaxation), watch)?;
            packing.account.notes.push("sequential addition was blocked, relaxation took over".into());
            packing
        }
        found => found?,
    };
    Ok(match request.cut_um {
        Some(heights) => packing.between(heights),
        None => packing,
    })
}

/// One attempt from the seed with a given method, or with the one suited to the volume fraction.
fn attempt(
    request: &PackingRequest,
    method: Option<Method>,
    watch: &mut dyn PackWatch,
) -> Result<Packing, PackError> {
    let mut draws = Draws::new(request.seed, request.stream);
    let mut plan = PackingPlan::new(request, &mut draws)?;
    let method = method.unwrap_or_else(|| suited(&plan));
    // Sequential addition places large bodies first (the order of equal ones is irrelevant);
    // relaxation shuffles them so that every batch holds the same mixture.
    match method {
        Method::SequentialAddition => plan.bodies.sort_by(|a, b| b.reach.total_cmp(&a.reach)),
        _ => draws.shuffle(&mut plan.bodies),
    }
    let notes = std::mem::take(&mut plan.notes);
    let mut account = PackingAccount { notes, ..PackingAccount::new(method, request) };
    let (mut bodies, mut course) = (Bodies::new(&plan), Course { draws, watch });
    if !plan.bodies.is_empty() {
        account.steps = match method {
            Method::SequentialAddition => add_all(&mut bodies, &mut course)?,
            _ => relax(&mut bodies, &mut course)?,
        };
        if let Some(settings) = &request.equilibration {
            account.sweeps = settings.sweeps;
            account.acceptance = Some(equilibrate(&mut bodies, settings.sweeps, &mut course)?);
        }
    }
    finish(&bodies, account)
}

/// Relaxes all grains, from other places if they jam; returns the number of steps. If they do not
/// fit, the error states how many would.
fn relax(bodies: &mut Bodies, course: &mut Course) -> Result<u64, PackError> {
    let (plan, mut steps) = (bodies.plan, 0);
    let mut again = (BODIES_OF_ALL_STARTS / plan.bodies.len()).clamp(1, MOST_STARTS);
    let left = loop {
        let (taken, left) = relax_all(bodies, course)?;
        steps += taken;
        again -= 1;
        match left {
            None => return Ok(steps),
            Some(left) if again == 0 => break left,
            Some(_) => *bodies = Bodies::new(plan),
        }
    };
    let Reached { fraction: requested, grains: wanted } = plan.whole();
    Err(PackError::NotReached {
        requested,
        reached: fit_fewer(bodies, course)?,
        wanted,
        steps,
        largest_overlap_um: left.overlap,
        relative_overlap: left.relative,
    })
}

/// Checks for overlap, and computes the binder's surface if requested.
fn finish(bodies: &Bodies, account: PackingAccount) -> Result<Packing, PackError> {
    let request = bodies.plan.request;
    let mut packing = Packing::proven(request, bodies.grains(), bodies.plan.shares.clone(), account)?;
    if let Some(asked) = request.relief.filter(|_| !packing.grains.is_empty()) {
        packing.relief = Some(settle(&packing, &asked));
    }
    Ok(packing)
}

/// Automatic choice of the method by the volume fraction accessible to centres: walls exclude part
/// of the layer for large grains.
fn suited(plan: &PackingPlan) -> Method {
    let widest = plan.bodies.iter().flat_map(|b| &b.spheres).map(|s| 2.0 * s.radius_um).fold(0.0, f64::max);
    let fraction = plan.request.usual_fraction.unwrap_or(plan.whole().fraction);
    let crowding = plan.request.accessible(fraction, widest);
    if crowding <= AUTO_LIMIT { Method::SequentialAddition } else { Method::Relaxation }
}

/// Relaxation steps of each round.
const STEPS: u64 = 400;
/// Fraction of the bodies removed per round.
const TAKEN_OUT: f64 = 0.01;
const ROUNDS: usize = 60;

/// The highest volume fraction reached from a stuck arrangement: the bodies with the largest
/// overlap are removed, a hundredth at a time, and the rest relaxes again until nothing overlaps.
/// `None` if that takes more than [`ROUNDS`].
fn fit_fewer(stuck: &Bodies, course: &mut Course) -> Result<Option<Reached>, PackError> {
    let mut kept: Vec<(usize, V3, Rotation)> =
        (0..stuck.placed).map(|b| (b, stuck.centre[b], stuck.rotation[b])).collect();
    for _ in 0..ROUNDS {
        let plan = stuck.plan.subset(kept.iter().map(|(b, ..)| *b));
        let mut bodies = Bodies::new(&plan);
        kept.iter().enumerate().for_each(|(b, (_, centre, rotation))| bodies.put(b, *centre, *rotation));
        bodies.placed = kept.len();
        let mut relaxation = OverlapRelaxation::new(&mut bodies);
        relaxation.inflation = relaxation.inflation.min(1e-3);
        relaxation.start_all();
        if relaxation.settle(STEPS, course)?.is_none() {
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
