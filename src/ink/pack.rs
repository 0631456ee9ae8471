//! From a request to a proven packing.

use super::bodies::{Bodies, Cell};
use super::draws::Draws;
use super::error::PackError;
use super::packing::{Account, Method, Packing};
use super::plan::Plan;
use super::request::{AUTO_LIMIT, MethodChoice, PackingRequest};
use super::watch::PackWatch;
use super::{relaxation, sequential};

/// Packs the grains of the request; the same request gives the same packing bit for bit, whatever the number of
/// threads. (Spheres use +, −, ×, ÷ and √ only; turned grains also sines, whose last bit may depend on the
/// platform's mathematical library.)
///
/// Errors: [`PackError::BadInput`] before any work, [`PackError::NotReached`] when the grains do not fit,
/// [`PackError::Stopped`] when the watch says so. Source: P1 section 3.
///
/// ```
/// use inkwave::ink::{PackingRequest, PigmentGrains, pack};
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
/// # Ok::<(), inkwave::ink::PackError>(())
/// ```
pub fn pack(request: &PackingRequest, watch: &mut dyn PackWatch) -> Result<Packing, PackError> {
    let mut draws = Draws::new(request.seed, request.stream);
    let mut plan = Plan::new(request, &mut draws)?;
    let method = choose(request, &plan);
    arrange(&mut plan, method, &mut draws);
    let cell = Cell::new(request.period_um, request.thickness_um, request.walls);
    let mut bodies = Bodies::new(cell, &plan.bodies);
    let mut account = Account {
        method,
        seed: request.seed,
        stream: request.stream,
        steps: 0,
        sweeps: 0,
        acceptance: None,
        smallest_gap_um: None,
        notes: Vec::new(),
    };
    account.steps = match method {
        Method::SequentialAddition => {
            let attempts = request.sequential.attempts_per_grain;
            sequential::add_all(&mut bodies, &plan, attempts, &mut draws, watch)?
        }
        _ => relaxation::relax_all(&mut bodies, &plan, &request.relaxation, &mut draws, watch)?,
    };
    let (period, thickness) = (request.period_um, request.thickness_um);
    Packing::proven(period, thickness, request.walls, bodies.grains(), plan.shares.clone(), account)
}

/// The automatic choice looks at the fraction of the volume that centres can use: walls crowd thick grains.
fn choose(request: &PackingRequest, plan: &Plan) -> Method {
    match request.method {
        MethodChoice::SequentialAddition => Method::SequentialAddition,
        MethodChoice::Relaxation => Method::Relaxation,
        MethodChoice::Auto if crowding(request, plan) <= AUTO_LIMIT => Method::SequentialAddition,
        MethodChoice::Auto => Method::Relaxation,
    }
}

fn crowding(request: &PackingRequest, plan: &Plan) -> f64 {
    let spheres = || plan.bodies.iter().flat_map(|b| &b.spheres);
    let widest = spheres().map(|s| 2.0 * s.radius_um).fold(0.0, f64::max);
    let lost = if request.walls { 0.5 * widest / request.thickness_um } else { 0.0 };
    plan.fraction() / (1.0 - lost)
}

/// Sequential addition places large bodies first (the order of equal ones does not matter); relaxation takes
/// them shuffled, so that every batch holds the same mixture.
fn arrange(plan: &mut Plan, method: Method, draws: &mut Draws) {
    match method {
        Method::SequentialAddition => plan.bodies.sort_by(|a, b| b.reach.total_cmp(&a.reach)),
        _ => draws.shuffle(&mut plan.bodies),
    }
}
