//! The list of rigid bodies to place: number, sizes and agglomerates of the grains.

use super::placed::Share;
use super::request::{PackingRequest, PigmentGrains};
use super::shell;
use super::sizes::{check_presence, draw_sizes, unlike};
use crate::ink::error::PackError;
use crate::ink::grains::agglomeration;
use crate::ink::grains::agglomeration::{Agglomeration, PlacedGrain};
use crate::ink::grains::orientation::AxisField;
use crate::ink::grains::shape::Template;
use crate::ink::grains::solid::{Form, Solid};
use crate::ink::grains::sphere::Sphere;
use crate::ink::relief;
use crate::numerics::Draws;
use crate::numerics::vector::{V3, dot, norm, scale};
use std::ops::Range;

/// A rigid body in its own frame: one grain, or the grains of one agglomerate.
#[derive(Clone, Debug)]
pub(crate) struct GrainSpheres {
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
pub(crate) struct PackingPlan {
    pub bodies: Vec<GrainSpheres>,
    pub fields: Vec<Option<AxisField>>,
    pub shares: Vec<Share>,
    /// Notes to the user about a cell that is too small.
    pub notes: Vec<String>,
    /// Cell volume, µm³.
    pub box_um3: f64,
}

impl PackingPlan {
    /// Checks the request and draws the grains.
    pub fn new(request: &PackingRequest, draws: &mut Draws) -> Result<Self, PackError> {
        request.check()?;
        let [lx, ly] = request.period_um;
        let dry = request
            .relief
            .as_ref()
            .map_or(request.thickness_um, |r| relief::dry_height_um(r, request.thickness_um));
        let mut bodies = Vec::new();
        let mut shares = Vec::new();
        let mut notes = Vec::new();
        for (k, pigment) in request.pigments.iter().enumerate() {
            let template = pigment.shape.template();
            check_size(request, k, pigment, &template)?;
            let (sizes, share) = draw_sizes(pigment, &template, lx * ly * dry, draws)?;
            check_presence(k, pigment, lx * ly * dry, &sizes)?;
            if !pigment.shell_nm.is_empty() {
                sizes
                    .iter()
                    .try_for_each(|&radius| shell::check_core(k, &pigment.shell_nm, &template, radius))?;
            }
            let grains = sizes.into_iter().map(|radius| grain(&template, radius)).collect();
            bodies.extend(group(k, request, grains, draws)?);
            notes.extend(unlike(k, pigment, &share));
            shares.push(share);
        }
        let fields = request.pigments.iter().map(|p| p.orientation.field()).collect();
        Ok(Self { bodies, fields, shares, notes, box_um3: lx * ly * request.thickness_um })
    }

    /// The plan with fewer bodies in the same cell.
    pub fn subset(&self, kept: &[usize]) -> Self {
        let bodies = kept.iter().map(|b| self.bodies[*b].clone()).collect();
        let (fields, shares) = (self.fields.clone(), self.shares.clone());
        Self { bodies, fields, shares, notes: Vec::new(), box_um3: self.box_um3 }
    }

    pub fn grains(&self) -> usize {
        self.bodies.iter().map(|b| b.parts.len()).sum()
    }

    /// Total pigment volume over cell volume.
    pub fn fraction(&self) -> f64 {
        self.bodies.iter().map(GrainSpheres::volume_um3).sum::<f64>() / self.box_um3
    }
}

impl GrainSpheres {
    pub fn volume_um3(&self) -> f64 {
        self.parts.iter().map(|p| p.volume_um3).sum()
    }

    /// Extent along the unit vector n.
    fn extent(&self, n: V3) -> f64 {
        let arm =
            |i: usize, n: V3| self.solids.get(i).map_or(self.spheres[i].radius_um, |s| dot(s.arm(n), n));
        let end = |n: V3| self.spheres.iter().enumerate().map(move |(i, s)| dot(s.center_um, n) + arm(i, n));
        end(n).fold(f64::MIN, f64::max) + end(scale(n, -1.0)).fold(f64::MIN, f64::max)
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
        let of = |pigment: &PigmentGrains| match pigment.agglomeration {
            Some(_) => f64::INFINITY,
            None => largest_extent_um(pigment, &pigment.shape.template()),
        };
        self.pigments.iter().map(of).fold(0.0, f64::max)
    }
}

/// Extent of a pigment's largest grain, µm.
fn largest_extent_um(pigment: &PigmentGrains, template: &Template) -> f64 {
    2.0 * pigment.size.radius_um(pigment.size.largest_nm(), template) * reach(&template.spheres)
}

fn check_size(request: &PackingRequest, k: usize, p: &PigmentGrains, t: &Template) -> Result<(), PackError> {
    let radius = p.size.radius_um(p.size.largest_nm(), t);
    let field = format!("pigment[{k}].size");
    let extent = largest_extent_um(p, t);
    if extent > widest(request) {
        let found = format!("{:.1} nm across for the largest grain", 1e3 * extent);
        let allowed = format!("at most half the period, {:.1} nm", 1e3 * widest(request));
        return Err(PackError::input(field, found, allowed, "widen period_um or take smaller grains"));
    }
    let thin =
        t.form.as_ref().map_or_else(|| thinnest(&grain(t, radius)), |form| 2.0 * radius * form.thin_um());
    if request.walls && thin > request.thickness_um {
        let found = format!("{:.1} nm thick for the largest grain", 1e3 * thin);
        let allowed = format!("at most the layer, {:.1} nm", 1e3 * request.thickness_um);
        return Err(PackError::input(field, found, allowed, "thicken the layer or take smaller grains"));
    }
    Ok(())
}

fn reach(spheres: &[Sphere]) -> f64 {
    spheres.iter().map(|s| norm(s.center_um) + s.radius_um).fold(0.0, f64::max)
}

/// Radius of the thinnest part.
fn slimmest(spheres: &[Sphere], solids: &[Solid]) -> f64 {
    let radii = spheres.iter().map(|s| s.radius_um);
    radii.chain(solids.iter().map(|s| s.form.thin_um())).fold(f64::MAX, f64::min)
}

/// Number of directions sampled for the smallest extent.
const DIRECTIONS: usize = 400;

/// Smallest extent over a fine sampling of the half sphere: the least thickness of layer that can
/// hold the grain.
fn thinnest(body: &GrainSpheres) -> f64 {
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let directions = (0..DIRECTIONS).map(direction).chain(axes);
    directions.map(|n| body.extent(n)).fold(f64::MAX, f64::min)
}

/// Unit vector i of a golden spiral on the half sphere z > 0.
#[inline]
fn direction(i: usize) -> V3 {
    let golden = std::f64::consts::PI * (3.0 - 5f64.sqrt());
    let z = (i as f64 + 0.5) / DIRECTIONS as f64;
    let (s, c) = (golden * i as f64).sin_cos();
    let planar = (1.0 - z * z).sqrt();
    [planar * c, planar * s, z]
}

fn grain(template: &Template, radius: f64) -> GrainSpheres {
    let spheres: Vec<Sphere> = template
        .spheres
        .iter()
        .map(|s| Sphere { center_um: scale(s.center_um, radius), radius_um: s.radius_um * radius })
        .collect();
    let volume_um3 = template.volume.um3 * radius.powi(3);
    let part = Part { spheres: 0..spheres.len(), axis: [0.0, 0.0, 1.0], volume_um3 };
    let upright = |form: &Form| Solid::upright(form.scaled(radius), [0.0; 3]);
    let solids: Vec<Solid> = template.form.iter().map(upright).collect();
    let thin = slimmest(&spheres, &solids);
    GrainSpheres { pigment: 0, reach: reach(&spheres), spheres, solids, thin, parts: vec![part] }
}

/// Glues the requested fraction of the grains into agglomerates, in the order of drawing.
fn group(
    k: usize,
    request: &PackingRequest,
    mut grains: Vec<GrainSpheres>,
    draws: &mut Draws,
) -> Result<Vec<GrainSpheres>, PackError> {
    grains.iter_mut().for_each(|g| g.pigment = k);
    let Some(rule) = &request.pigments[k].agglomeration else { return Ok(grains) };
    let sticky = (rule.degree * grains.len() as f64).round() as usize;
    let mut bodies = grains.split_off(sticky);
    let mut left = grains.as_slice();
    while !left.is_empty() {
        let n = rule.draw_count(draws).min(left.len());
        bodies.push(agglomerate(k, request, &left[..n], draws)?);
        left = &left[n..];
    }
    Ok(bodies)
}

/// Number of draws after which an agglomerate counts as too large.
const DRAWS_OF_AGGLOMERATE: usize = 200;

fn agglomerate(
    k: usize,
    request: &PackingRequest,
    grains: &[GrainSpheres],
    draws: &mut Draws,
) -> Result<GrainSpheres, PackError> {
    let members: Vec<PlacedGrain> =
        grains.iter().map(|g| PlacedGrain::new(g.spheres.clone(), g.solids.first().cloned())).collect();
    let mut best = f64::MAX;
    for _ in 0..DRAWS_OF_AGGLOMERATE {
        let fractal = request.pigments[k].agglomeration.as_ref().and_then(|rule| rule.fractal);
        let glued = match fractal {
            Some(law) => law.aggregate(&members, draws),
            None => agglomeration::glue(&members, draws),
        };
        let body = joined(k, grains, glued);
        let thick = if request.walls { thinnest(&body) } else { 0.0 };
        if 2.0 * body.reach <= widest(request) && thick <= request.thickness_um {
            return Ok(body);
        }
        best = best.min(2.0 * body.reach);
    }
    Err(agglomeration::too_large(k, grains.len(), best, widest(request).min(request.thickness_um)))
}

fn joined(k: usize, grains: &[GrainSpheres], glued: Vec<PlacedGrain>) -> GrainSpheres {
    let (mut spheres, mut solids) = (Vec::<Sphere>::new(), Vec::new());
    let mut parts = Vec::new();
    for (grain, placed) in grains.iter().zip(glued) {
        let start = spheres.len();
        spheres.extend(placed.spheres);
        let volume_um3 = grain.volume_um3();
        let round = spheres.len() == start + 1 && placed.solid.is_none();
        let axis = if round { [0.0, 0.0, 1.0] } else { placed.axis };
        solids.extend(placed.solid.map(|solid| solid.placed([0.0; 3])));
        parts.push(Part { spheres: start..spheres.len(), axis, volume_um3 });
    }
    let total: f64 = spheres.iter().map(|s| s.radius_um.powi(3)).sum();
    let centre = spheres.iter().fold([0.0; 3], |c, s| {
        crate::numerics::vector::add(c, scale(s.center_um, s.radius_um.powi(3) / total))
    });
    spheres.iter_mut().for_each(|s| s.center_um = crate::numerics::vector::sub(s.center_um, centre));
    let thin = slimmest(&spheres, &solids);
    GrainSpheres { pigment: k, reach: reach(&spheres), spheres, solids, thin, parts }
}

impl Agglomeration {
    /// Agglomerates of exactly `grains` grains.
    pub fn of(grains: usize, degree: f64) -> Self {
        Self { degree, grains: agglomeration::GrainCount::Constant(grains), fractal: None }
    }
}
