//! Packing of a request, with the final check for overlap.

use super::bodies::Bodies;
use super::placed::{Method, Packing, PackingAccount};
use super::plan::PackingPlan;
use super::request::{AUTO_LIMIT, MethodChoice, PackingRequest, RelaxationSettings};
use super::watch::PackWatch;
use super::{fewer, monte_carlo, relaxation, sequential, settle};
use crate::ink::error::PackError;
use crate::numerics::draws::Draws;

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
    let method = method.unwrap_or_else(|| suited(request, &plan));
    arrange(&mut plan, method, &mut draws);
    let mut account = PackingAccount::new(method, request.seed, request.stream);
    account.notes.append(&mut plan.notes);
    let mut bodies = Bodies::new(&plan);
    if !plan.bodies.is_empty() {
        account.steps = if method == Method::SequentialAddition {
            sequential::add_all(&mut bodies, request.sequential.attempts_per_grain, &mut draws, watch)?
        } else {
            relax(&mut bodies, &request.relaxation, &mut draws, watch)?
        };
        if let Some(settings) = &request.equilibration {
            account.sweeps = settings.sweeps;
            let rate = monte_carlo::equilibrate(&mut bodies, settings.sweeps, &mut draws, watch)?;
            account.acceptance = Some(rate);
        }
    }
    finish(request, &bodies, account)
}

/// Relaxes all grains, from other places if they jam; returns the number of steps. If they do not
/// fit, the error states how many would.
fn relax(
    bodies: &mut Bodies,
    settings: &RelaxationSettings,
    draws: &mut Draws,
    watch: &mut dyn PackWatch,
) -> Result<u64, PackError> {
    let plan = bodies.plan;
    let mut steps = 0;
    let mut again = (BODIES_OF_ALL_STARTS / plan.bodies.len()).clamp(1, MOST_STARTS);
    let left = loop {
        let (taken, left) = relaxation::relax_all(bodies, settings, draws, watch)?;
        steps += taken;
        again -= 1;
        match left {
            None => return Ok(steps),
            Some(left) if again == 0 => break left,
            Some(_) => *bodies = Bodies::new(plan),
        }
    };
    Err(PackError::NotReached {
        requested: plan.fraction(),
        reached: fewer::fit_fewer(bodies, settings, draws, watch)?,
        wanted: plan.grains(),
        steps,
        largest_overlap_um: left.overlap,
        relative_overlap: left.relative,
    })
}

/// Checks for overlap, and computes the binder's surface if requested.
fn finish(request: &PackingRequest, bodies: &Bodies, account: PackingAccount) -> Result<Packing, PackError> {
    let (period, thickness) = (request.period_um, request.thickness_um);
    let parts = (bodies.plan.shares.clone(), account);
    let packing = Packing::proven(period, thickness, request.walls, bodies.grains(), parts)?;
    let mut packing = packing.with_shells(request.shells_um())?;
    if let Some(asked) = request.relief.filter(|_| !packing.grains.is_empty()) {
        packing.relief = Some(settle::settle(&packing, &asked));
    }
    Ok(packing)
}

/// Automatic choice of the method by the volume fraction accessible to centres: walls exclude part
/// of the layer for large grains.
fn suited(request: &PackingRequest, plan: &PackingPlan) -> Method {
    let spheres = plan.bodies.iter().flat_map(|b| &b.spheres);
    let widest = spheres.map(|s| 2.0 * s.radius_um).fold(0.0, f64::max);
    let lost = if request.walls { 0.5 * widest / request.thickness_um } else { 0.0 };
    let crowding = request.usual_fraction.unwrap_or(plan.fraction()) / (1.0 - lost);
    if crowding <= AUTO_LIMIT { Method::SequentialAddition } else { Method::Relaxation }
}

/// Order of placement. Sequential addition places large bodies first (the order of equal ones is
/// irrelevant); relaxation shuffles them so that every batch holds the same mixture.
fn arrange(plan: &mut PackingPlan, method: Method, draws: &mut Draws) {
    match method {
        Method::SequentialAddition => plan.bodies.sort_by(|a, b| b.reach.total_cmp(&a.reach)),
        _ => draws.shuffle(&mut plan.bodies),
    }
}
