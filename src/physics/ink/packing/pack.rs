//! Packing of a request, with the final check for overlap.

use super::arrangement::Arrangement;
use super::gradient;
use super::hard_bodies::{add_all, equilibrate};
use super::placed::{Method, Packing, PackingAccount};
use super::plan::PackingPlan;
use super::relaxation::starts::{Relaxed, relax};
use super::request::{AUTO_LIMIT, Joint, MethodChoice, PackingRequest, StackedRequest};
use super::settle::settle;
use super::stack::{Stack, in_layer, joined};
use crate::ink::error::{Course, PackError, PackWatch};
use crate::numerics::Draws;

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
    if !request.layers.is_empty() {
        return pack_stack(request, watch);
    }
    if let Some(given) = Packing::given(request) {
        return given;
    }
    let packing = match request.method {
        MethodChoice::SequentialAddition => attempt(request, Some(Method::SequentialAddition), watch)?,
        MethodChoice::Relaxation => attempt(request, Some(Method::Relaxation), watch)?,
        MethodChoice::Auto => match attempt(request, None, watch) {
            Err(PackError::Blocked { .. }) => {
                let mut packing = attempt(request, Some(Method::Relaxation), watch)?;
                let note = "sequential addition was blocked, relaxation took over";
                packing.account.notes.push(note.into());
                packing
            }
            packed => packed?,
        },
    };
    Ok(match request.cut_um {
        Some([from_um, to_um]) => packing.between(from_um, to_um),
        None => packing,
    })
}

/// Packs the layers of a request one above the other, in the order of the light.
fn pack_stack(request: &PackingRequest, watch: &mut dyn PackWatch) -> Result<Packing, PackError> {
    let mut stack = Stack::new(request);
    // layers with open joints are packed together
    for group in request.layers.chunk_by(|before, _| before.joint == Joint::Open) {
        let first = stack.layers();
        let packing = match group {
            [StackedRequest { request: layer, .. }] => pack(layer, watch),
            _ => pack(&joined(group), watch),
        };
        stack.add(group, packing.map_err(|error| in_layer(error, first))?);
    }
    stack.proven(request)
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
    let mut course = Course { draws, watch };
    let mut arrangement = Arrangement::new(&plan);
    if !plan.bodies.is_empty() {
        if method == Method::SequentialAddition {
            account.steps = add_all(&mut arrangement, &mut course)?;
        } else {
            Relaxed { arrangement, steps: account.steps } = relax(&plan, &mut course)?;
        }
        if let Some(settings) = &request.equilibration {
            account.sweeps = settings.sweeps;
            account.acceptance = Some(equilibrate(&mut arrangement, settings.sweeps, &mut course)?);
        }
    }
    let mut packing = Packing::proven(request, arrangement.grains(), plan.shares.clone(), account)?;
    let notes = gradient::notes(request, &packing);
    packing.account.notes.extend(notes);
    if let Some(relief) = request.relief.filter(|_| !packing.grains.is_empty()) {
        packing.relief = Some(settle(&packing, &relief));
    }
    Ok(packing)
}

/// Automatic choice of the method by the volume fraction accessible to centres: walls exclude part
/// of the layer for large grains.
fn suited(plan: &PackingPlan) -> Method {
    let spheres = plan.bodies.iter().flat_map(|body| &body.spheres);
    let widest = spheres.map(|s| 2.0 * s.radius_um).fold(0.0, f64::max);
    // Grains of a profile are where it is densest as crowded as an even layer of that share.
    let own = || if plan.has_profiles() { plan.densest() } else { plan.whole().fraction };
    let fraction = plan.request.usual_fraction.unwrap_or_else(own);
    let crowding = plan.request.accessible(fraction, widest);
    if crowding <= AUTO_LIMIT { Method::SequentialAddition } else { Method::Relaxation }
}
