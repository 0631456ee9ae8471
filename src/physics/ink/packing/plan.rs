//! The list of rigid bodies to place: number, sizes and agglomerates of the grains.

use super::cell::CellBox;
use super::depth::{DepthLaw, densest};
use crate::ink::Template;
use crate::ink::error::{PackError, PackProgress, Reached};
use crate::ink::grains::agglomeration::{Agglomeration, PlacedGrain};
use crate::ink::grains::orientation::AxisField;
use crate::ink::grains::sphere::{Sphere, reach_um};
use crate::ink::{PackingRequest, PigmentGrains, Share, Solid};
use crate::numerics::Draws;
use crate::numerics::vector::{Rotation, V3, dot, scale};
use std::ops::Range;

/// A rigid body in its own frame: one grain, or the grains of one agglomerate.
#[derive(Clone, Debug)]
pub(crate) struct RigidBody {
    pub pigment: usize,
    /// The spheres of the body, or the one around a convex body.
    pub spheres: Vec<Sphere>,
    /// Convex bodies, one in each sphere, about their centres; none in a body of spheres.
    pub solids: Vec<Solid>,
    /// Radius of the thinnest part, µm: the length by which steps and gaps are measured.
    pub thin: f64,
    pub parts: Vec<Part>,
    /// Radius of the sphere about the origin that encloses the body.
    pub reach: f64,
}

/// One grain of a body.
#[derive(Clone, Debug)]
pub(crate) struct Part {
    pub spheres: Range<usize>,
    pub axis: V3,
    pub volume_um3: f64,
}

/// Bodies, cell and settings, as the packing methods need them.
pub(crate) struct PackingPlan<'r> {
    pub request: &'r PackingRequest,
    pub cell: CellBox,
    pub bodies: Vec<RigidBody>,
    pub fields: Vec<Option<AxisField>>,
    /// Per pigment, where along the depth its bodies are.
    pub depths: Vec<Option<DepthLaw>>,
    pub shares: Vec<Share>,
    /// Notes to the user about a cell that is too small.
    pub notes: Vec<String>,
}

impl<'r> PackingPlan<'r> {
    /// Checks the request and draws the grains.
    pub fn new(request: &'r PackingRequest, draws: &mut Draws) -> Result<Self, PackError> {
        request.check()?;
        let cell = CellBox::new(request.period_um, request.thickness_um, request.walls);
        let mut plan = Self {
            request,
            cell,
            bodies: Vec::new(),
            fields: request.pigments.iter().map(|p| p.orientation.field()).collect(),
            depths: request.pigments.iter().map(|p| DepthLaw::of(&p.profile)).collect(),
            shares: Vec::new(),
            notes: Vec::new(),
        };
        let room_um3 = request.window_um3();
        for (k, pigment) in request.pigments.iter().enumerate() {
            let template = pigment.shape.template();
            check_size(request, k, pigment, &template)?;
            let (sizes, share) = pigment.draw_sizes(&template, room_um3, draws)?;
            pigment.check_presence(k, room_um3, &sizes)?;
            if !pigment.shell_nm.is_empty() {
                sizes.iter().try_for_each(|&radius| pigment.check_core(k, &template, radius))?;
            }
            let grains = sizes.into_iter().map(|radius| template.grain(radius)).collect();
            plan.bodies.extend(group(k, request, grains, draws)?);
            plan.notes.extend(pigment.unlike(k, &share));
            plan.shares.push(share);
        }
        Ok(plan)
    }

    /// The plan with fewer bodies in the same cell.
    pub fn subset(&self, kept: impl Iterator<Item = usize>) -> Self {
        Self {
            request: self.request,
            cell: self.cell,
            bodies: kept.map(|b| self.bodies[b].clone()).collect(),
            fields: self.fields.clone(),
            depths: self.depths.clone(),
            shares: self.shares.clone(),
            notes: Vec::new(),
        }
    }

    /// The profile along the depth of body b, if it has one.
    pub fn profile_of(&self, b: usize) -> Option<&DepthLaw> {
        self.depths[self.bodies[b].pigment].as_ref()
    }

    /// Whether a pigment has a profile along the depth.
    pub fn has_profiles(&self) -> bool {
        self.depths.iter().any(Option::is_some)
    }

    /// Volume fraction of all grains at the depth where they are densest.
    pub fn densest(&self) -> f64 {
        let fractions: Vec<f64> = self.shares.iter().map(|share| share.achieved_fraction).collect();
        densest(&self.depths, &fractions)
    }

    /// A random rotation of body b, in its field if it has one.
    pub fn draw_rotation(&self, b: usize, draws: &mut Draws) -> Rotation {
        let body = &self.bodies[b];
        if body.single_sphere() {
            return Rotation::IDENTITY;
        }
        let axis = match &self.fields[body.pigment] {
            Some(field) => field.draw_axis(draws),
            None => draws.direction(),
        };
        draws.rotation_with_axis(axis)
    }

    /// Volume fraction and number of the grains of the first `placed` bodies.
    pub fn reached(&self, placed: usize) -> Reached {
        let bodies = &self.bodies[..placed];
        let volume_of = |body: &RigidBody| body.parts.iter().map(|p| p.volume_um3).sum::<f64>();
        let volume = bodies.iter().map(volume_of).fold(0.0, |sum, volume| sum + volume);
        let grains = bodies.iter().map(|b| b.parts.len()).sum();
        Reached { fraction: volume / self.cell.size.iter().product::<f64>(), grains }
    }

    /// What the watch hears when the first `placed` bodies are in place.
    pub fn progress(&self, stage: &'static str, step: u64, placed: usize) -> PackProgress {
        let reached = self.reached(placed);
        PackProgress {
            stage,
            step,
            grains_placed: reached.grains,
            grains_wanted: self.whole().grains,
            fraction: reached.fraction,
            ..PackProgress::default()
        }
    }

    /// Total pigment volume over cell volume, and number of all grains.
    pub fn whole(&self) -> Reached {
        self.reached(self.bodies.len())
    }
}

impl RigidBody {
    /// A body of grains in its frame.
    fn new(pigment: usize, grains: Vec<PlacedGrain>) -> Self {
        let mut spheres = Vec::new();
        let mut solids = Vec::new();
        let mut parts = Vec::new();
        for grain in grains {
            let start = spheres.len();
            spheres.extend(grain.spheres);
            let round = spheres.len() == start + 1 && grain.solid.is_none();
            let axis = if round { [0.0, 0.0, 1.0] } else { grain.axis };
            solids.extend(grain.solid);
            parts.push(Part { spheres: start..spheres.len(), axis, volume_um3: grain.volume_um3 });
        }
        let radii = spheres.iter().map(|s: &Sphere| s.radius_um);
        let thin = radii.chain(solids.iter().map(|s: &Solid| s.form.thin_um())).fold(f64::MAX, f64::min);
        Self { pigment, reach: reach_um(&spheres, [0.0; 3]), spheres, solids, thin, parts }
    }

    /// Extent along the unit vector n.
    fn extent(&self, n: V3) -> f64 {
        let arm = |i: usize, n| self.solids.get(i).map_or(self.spheres[i].radius_um, |s| dot(s.arm(n), n));
        let end = |n: V3| self.spheres.iter().enumerate().map(move |(i, s)| dot(s.center_um, n) + arm(i, n));
        end(n).fold(f64::MIN, f64::max) + end(scale(n, -1.0)).fold(f64::MIN, f64::max)
    }

    /// Axes of the grains of the body as rotated.
    pub fn axes(&self, rotation: Rotation) -> impl Iterator<Item = V3> + '_ {
        self.parts.iter().map(move |part| rotation.turn(part.axis))
    }

    pub fn single_sphere(&self) -> bool {
        self.solids.is_empty() && self.spheres.len() == 1 && self.spheres[0].center_um == [0.0; 3]
    }
}

/// Largest allowed extent of a body: half of the shortest period.
fn widest(request: &PackingRequest) -> f64 {
    let lateral = 0.5 * request.period_um[0].min(request.period_um[1]);
    if request.walls { lateral } else { lateral.min(0.5 * request.thickness_um) }
}

impl PackingRequest {
    /// Largest extent of a grain, µm; infinite with agglomerates, whose size is a matter of chance.
    pub fn widest_body_um(&self) -> f64 {
        let widest = |pigment: &PigmentGrains| match pigment.agglomeration {
            Some(_) => f64::INFINITY,
            None => largest_extent_um(pigment, &pigment.shape.template()),
        };
        self.pigments.iter().map(widest).fold(0.0, f64::max)
    }
}

/// Extent of a pigment's largest grain, µm.
fn largest_extent_um(pigment: &PigmentGrains, template: &Template) -> f64 {
    2.0 * pigment.size.radius_um(pigment.size.largest_nm(), template) * reach_um(&template.spheres, [0.0; 3])
}

fn check_size(request: &PackingRequest, k: usize, p: &PigmentGrains, t: &Template) -> Result<(), PackError> {
    let radius = p.size.radius_um(p.size.largest_nm(), t);
    let field = format!("pigment[{k}].size");
    let extent = largest_extent_um(p, t);
    let found = format!("{:.1} nm across for the largest grain", 1e3 * extent);
    let allowed = format!("at most half the period, {:.1} nm", 1e3 * widest(request));
    let remedy = "widen period_um or take smaller grains";
    PackError::unless(extent <= widest(request), &field, found, allowed, remedy)?;
    let thin = match &t.form {
        Some(form) => 2.0 * radius * form.thin_um(),
        None => thinnest(&RigidBody::new(k, vec![t.grain(radius)])),
    };
    let found = format!("{:.1} nm thick for the largest grain", 1e3 * thin);
    let allowed = format!("at most the layer, {:.1} nm", 1e3 * request.thickness_um);
    let sound = !request.walls || thin <= request.thickness_um;
    PackError::unless(sound, field, found, allowed, "thicken the layer or take smaller grains")
}

/// Number of directions sampled for the smallest extent.
const DIRECTIONS: usize = 400;

/// Smallest extent over a fine sampling of the half sphere: the least thickness of layer that can
/// hold the grain.
fn thinnest(body: &RigidBody) -> f64 {
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    (0..DIRECTIONS).map(direction).chain(axes).map(|n| body.extent(n)).fold(f64::MAX, f64::min)
}

/// Unit vector i of a golden spiral on the half sphere z > 0.
#[inline]
fn direction(i: usize) -> V3 {
    let golden = std::f64::consts::PI * (3.0 - 5f64.sqrt());
    let z = (i as f64 + 0.5) / DIRECTIONS as f64;
    let (sine, cosine) = (golden * i as f64).sin_cos();
    let planar = (1.0 - z * z).sqrt();
    [planar * cosine, planar * sine, z]
}

/// Glues the requested fraction of the grains into agglomerates, in the order of drawing.
fn group(
    k: usize,
    request: &PackingRequest,
    mut grains: Vec<PlacedGrain>,
    draws: &mut Draws,
) -> Result<Vec<RigidBody>, PackError> {
    let alone = |grain| RigidBody::new(k, vec![grain]);
    let Some(rule) = &request.pigments[k].agglomeration else {
        return Ok(grains.into_iter().map(alone).collect());
    };
    let sticky = (rule.degree * grains.len() as f64).round() as usize;
    let mut bodies: Vec<RigidBody> = grains.split_off(sticky).into_iter().map(alone).collect();
    let mut left = grains.as_slice();
    while !left.is_empty() {
        let (members, rest) = left.split_at(rule.draw_count(draws).min(left.len()));
        bodies.push(agglomerate(k, request, rule, members, draws)?);
        left = rest;
    }
    Ok(bodies)
}

/// Number of draws after which an agglomerate counts as too large.
const DRAWS_OF_AGGLOMERATE: usize = 200;

fn agglomerate(
    k: usize,
    request: &PackingRequest,
    rule: &Agglomeration,
    members: &[PlacedGrain],
    draws: &mut Draws,
) -> Result<RigidBody, PackError> {
    let mut best = f64::MAX;
    for _ in 0..DRAWS_OF_AGGLOMERATE {
        let body = RigidBody::new(k, rule.join(members, draws));
        let thick = if request.walls { thinnest(&body) } else { 0.0 };
        if 2.0 * body.reach <= widest(request) && thick <= request.thickness_um {
            return Ok(body);
        }
        best = best.min(2.0 * body.reach);
    }
    let found = format!("{} grains, {best:.3} µm across in the best of many draws", members.len());
    let limit = widest(request).min(request.thickness_um);
    let allowed = format!("agglomerates at most {limit:.3} µm across");
    let remedy = "take fewer or smaller grains per agglomerate, or a larger cell";
    Err(PackError::input(format!("pigment[{k}].agglomeration.grains"), found, allowed, remedy))
}
