//! Bodies in the cell: positions, rotations and the spheres they carry.

use super::cell::CellBox;
use super::plan::PackingPlan;
use crate::ink::grains::contact::{self, Contact};
use crate::ink::{Grain, Solid, Sphere};
use crate::numerics::vector::{Rotation, V3, add, norm, scale, sub, unit};
use std::ops::Range;

/// Positions of the first `placed` bodies. Arrays over spheres are flat; `first[b]..first[b + 1]`
/// belong to body b.
pub(crate) struct Bodies<'a> {
    pub cell: CellBox,
    pub plan: &'a PackingPlan<'a>,
    pub placed: usize,
    pub centre: Vec<V3>,
    pub rotation: Vec<Rotation>,
    pub first: Vec<usize>,
    pub owner: Vec<u32>,
    pub radius: Vec<f64>,
    /// Rotated vectors from the body's centre to its spheres.
    pub arm: Vec<V3>,
    /// Wrapped centres of the spheres.
    pub at: Vec<V3>,
    /// Per sphere, the convex body that it is around, about its centre and as rotated.
    solid: Vec<Option<Box<Solid>>>,
}

impl<'a> Bodies<'a> {
    pub fn new(plan: &'a PackingPlan<'a>) -> Self {
        let bodies = &plan.bodies;
        let mut first = vec![0];
        let mut owner = Vec::new();
        let (mut radius, mut solid) = (Vec::new(), Vec::new());
        for (b, body) in bodies.iter().enumerate() {
            radius.extend(body.spheres.iter().map(|s| s.radius_um));
            solid.extend((0..body.spheres.len()).map(|i| body.solids.get(i).cloned().map(Box::new)));
            owner.resize(radius.len(), b as u32);
            first.push(radius.len());
        }
        let (arm, at) = (vec![[0.0; 3]; radius.len()], vec![[0.0; 3]; radius.len()]);
        let (centre, rotation) = (vec![[0.0; 3]; bodies.len()], vec![Rotation::IDENTITY; bodies.len()]);
        Self { cell: plan.cell, plan, placed: 0, centre, rotation, first, owner, radius, arm, at, solid }
    }

    /// The spheres of body b.
    pub fn range(&self, b: usize) -> Range<usize> {
        self.first[b]..self.first[b + 1]
    }

    /// Places body b and updates its spheres.
    pub fn put(&mut self, b: usize, centre: V3, rotation: Rotation) {
        self.rotation[b] = rotation;
        let (body, range) = (&self.plan.bodies[b], self.range(b));
        for (arm, sphere) in self.arm[range.clone()].iter_mut().zip(&body.spheres) {
            *arm = rotation.turn(sphere.center_um);
        }
        for (solid, own) in self.solid[range].iter_mut().flatten().zip(&body.solids) {
            // A lone body has the rotation to its last bit, which a product would round.
            let lone = own.rotation == Rotation::IDENTITY;
            solid.rotation = if lone { rotation } else { own.rotation.then(rotation) };
        }
        self.shift(b, centre);
    }

    /// Translates body b.
    pub fn shift(&mut self, b: usize, centre: V3) {
        let centre = self.cell.wrap(centre);
        self.centre[b] = centre;
        for s in self.range(b) {
            self.at[s] = self.cell.wrap(add(centre, self.arm[s]));
        }
    }

    /// Number of spheres of the placed bodies.
    pub fn spheres(&self) -> usize {
        self.first[self.placed]
    }

    /// Lowest and highest z of body b, relative to its centre.
    pub fn span_z(&self, b: usize) -> [f64; 2] {
        let ends = self.range(b).map(|s| self.extent_z(s).map(|z| self.arm[s][2] + z));
        ends.fold([f64::MAX, f64::MIN], |e, [low, high]| [e[0].min(low), e[1].max(high)])
    }

    /// Lowest and highest z of what sphere s stands for, relative to its centre.
    pub fn extent_z(&self, s: usize) -> [f64; 2] {
        self.solid(s).map_or([-self.radius[s], self.radius[s]], |solid| solid.extent_um(2))
    }

    /// The convex body that sphere s is around, about its centre, if it is around one.
    pub fn solid(&self, s: usize) -> Option<&Solid> {
        self.solid[s].as_deref()
    }

    /// Whether both of two spheres are surfaces themselves, not the spheres around convex bodies.
    #[inline(always)]
    pub fn are_spheres(&self, s: usize, t: usize) -> bool {
        self.solid[s].is_none() && self.solid[t].is_none()
    }

    /// Contact of what spheres s and t stand for, with t at d from s, if nearer than `within_um`;
    /// its arms are relative to the spheres' centres.
    pub fn contact(&self, s: usize, t: usize, d: V3, within_um: f64) -> Option<Contact> {
        if self.are_spheres(s, t) {
            let normal = unit(d);
            let arms = [scale(normal, self.radius[s]), scale(normal, -self.radius[t])];
            let gap_um = norm(d) - self.radius[s] - self.radius[t];
            return (gap_um < within_um).then_some(Contact { gap_um, normal, arms });
        }
        let round = |s: usize| Sphere { center_um: [0.0; 3], radius_um: self.radius[s] }.solid();
        let [a, b] = [s, t].map(|s| self.solid(s).cloned().unwrap_or_else(|| round(s)));
        contact::contact(&a, &b, d, within_um)
    }

    /// Rotated axes of the grains of body b.
    pub fn axes(&self, b: usize) -> impl Iterator<Item = V3> + '_ {
        self.plan.bodies[b].parts.iter().map(move |p| self.rotation[b].turn(p.axis))
    }

    /// The grains of the placed bodies, with contiguous coordinates.
    pub fn grains(&self) -> Vec<Grain> {
        let mut agglomerates = 0;
        let mut grains = Vec::new();
        for (b, body) in self.plan.bodies[..self.placed].iter().enumerate() {
            let agglomerate = (body.parts.len() > 1).then_some(agglomerates);
            agglomerates += usize::from(agglomerate.is_some());
            for part in &body.parts {
                let range = self.first[b] + part.spheres.start..self.first[b] + part.spheres.end;
                let lead = add(self.centre[b], self.arm[range.start]);
                // In the periodic image that takes the first sphere into the cell.
                let by = sub(self.cell.wrap(lead), lead);
                let places = range.clone().map(|s| (add(self.centre[b], self.arm[s]), self.radius[s]));
                let spheres: Vec<Sphere> =
                    places.map(|(p, radius_um)| Sphere { center_um: add(p, by), radius_um }).collect();
                let solid = self.solid(range.start).map(|solid| solid.placed(spheres[0].center_um));
                let turned = solid.is_some() || spheres.len() > 1;
                let axis = if turned { self.rotation[b].turn(part.axis) } else { part.axis };
                let (pigment, volume_um3) = (body.pigment, part.volume_um3);
                grains.push(Grain { spheres, solid, pigment, axis, agglomerate, volume_um3 });
            }
        }
        grains
    }
}
