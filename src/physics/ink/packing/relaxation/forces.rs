//! Repulsion between overlapping spheres or convex bodies, and from the walls: forces and torques,
//! with overlap statistics collected during their summation.

use super::OverlapRelaxation;
use crate::ink::packing::hard_bodies::{CONVEX_MARGIN, MARGIN};
use crate::numerics::Draws;
use crate::numerics::vector::{V3, add, cross, dot, scale, sub};

/// Overlap statistics of one evaluation of the forces.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct FoundLoads {
    pub energy: f64,
    pub overlap: f64,
    pub relative: f64,
}

/// Forces and torques of one step, and the bodies on which they act.
pub(crate) struct OverlapLoads {
    pub force: Vec<V3>,
    pub torque: Vec<V3>,
    pub touched: Vec<bool>,
    pub joined: Vec<u32>,
    /// Squared lever arm that represents J/μ; zero for single spheres.
    pub inertia: Vec<f64>,
}

impl OverlapLoads {
    pub fn new(inertia: Vec<f64>) -> Self {
        let n = inertia.len();
        let (force, torque) = (vec![[0.0; 3]; n], vec![[0.0; 3]; n]);
        Self { force, torque, touched: vec![false; n], joined: Vec::new(), inertia }
    }

    /// Takes all forces and torques away.
    pub fn clear(&mut self) {
        for b in self.joined.iter().map(|b| *b as usize) {
            (self.force[b], self.torque[b]) = ([0.0; 3], [0.0; 3]);
        }
    }

    /// Applies a force at a point relative to the centre of body b.
    #[inline(always)]
    pub fn act(&mut self, b: usize, arm: V3, force: V3) {
        self.force[b] = add(self.force[b], force);
        if self.inertia[b] > 0.0 {
            self.torque[b] = add(self.torque[b], cross(arm, force));
        }
        self.touch(b);
    }

    #[inline(always)]
    pub fn touch(&mut self, b: usize) {
        if !self.touched[b] {
            self.touched[b] = true;
            self.joined.push(b as u32);
        }
    }
}

impl FoundLoads {
    #[inline(always)]
    pub fn hear(&mut self, energy: f64, overlap: f64, sum: f64) {
        self.energy += energy;
        self.overlap = self.overlap.max(overlap);
        self.relative = self.relative.max(overlap / sum);
    }
}

impl OverlapRelaxation<'_, '_> {
    /// Forces and torques on the bodies of the moving list and on the bodies they push.
    pub(super) fn forces(&mut self, draws: &mut Draws) -> FoundLoads {
        let mut found = FoundLoads::default();
        for k in 0..self.moving.len() {
            let b = self.moving[k] as usize;
            for s in self.bodies.range(b) {
                self.wall(b, s, &mut found);
                self.pairs(b, s, &mut found, draws);
            }
        }
        found
    }

    fn pairs(&mut self, b: usize, s: usize, found: &mut FoundLoads, draws: &mut Draws) {
        let (p, r, wider) = (self.bodies.at[s], self.bodies.radius[s], 1.0 + self.inflation);
        let (mut push, mut pushed) = ([0.0; 3], false);
        for k in 0..self.list.of(s).len() {
            let (t, bodies) = (self.list.of(s)[k] as usize, &*self.bodies);
            let d = bodies.cell.delta(p, bodies.at[t]);
            let sum = r + bodies.radius[t];
            let reach = sum * wider;
            let d2 = dot(d, d);
            if d2 >= reach * reach {
                continue;
            }
            let other = bodies.owner[t] as usize;
            if other < b && self.moves[other] {
                continue; // the pair is handled from the other sphere
            }
            if !bodies.are_spheres(s, t) {
                self.press([s, t], d, found);
                continue;
            }
            let distance = d2.sqrt();
            let depth = reach - distance; // L = (1 + ε)(R₁ + R₂) − distance
            // Coincident centres define no direction: any will do.
            let away = match distance > 1e-9 * sum {
                true => scale(d, depth / distance),
                false => scale(draws.direction(), depth),
            };
            push = sub(push, away); // F = −L on this sphere, summed over its neighbours
            pushed = true;
            self.loads.act(other, bodies.arm[t], away); // +L on the other
            found.hear(0.5 * depth * depth, sum * (1.0 + MARGIN) - distance, sum); // energy L²/2
        }
        if pushed {
            self.loads.act(b, self.bodies.arm[s], push);
        }
    }

    /// Repulsion of two bodies of which one is convex: by the depth of their contact, with both
    /// inflated by their thinnest radii.
    fn press(&mut self, [s, t]: [usize; 2], d: V3, found: &mut FoundLoads) {
        let [own, other] = [s, t].map(|s| self.bodies.owner[s] as usize);
        let thin = self.plan.bodies[own].thin + self.plan.bodies[other].thin;
        let gap = (self.inflation * thin).max(2.0 * CONVEX_MARGIN * thin);
        let Some(contact) = self.bodies.contact(s, t, d, gap) else { return };
        let depth = gap - contact.gap_um;
        if depth > 0.0 {
            let push = scale(contact.normal, depth);
            self.loads.act(own, add(self.bodies.arm[s], contact.arms[0]), scale(push, -1.0));
            self.loads.act(other, add(self.bodies.arm[t], contact.arms[1]), push);
            found.hear(0.5 * depth * depth, 1.5 * CONVEX_MARGIN * thin - contact.gap_um, thin);
        }
    }

    /// Repulsion from a wall as from the mirror image, L = 2 (R (1 + ε) − distance to the wall),
    /// of a convex body at its lowest and highest point.
    fn wall(&mut self, b: usize, s: usize, found: &mut FoundLoads) {
        if !self.bodies.cell.walls {
            return;
        }
        let (z, top, from) = (self.bodies.at[s][2], self.bodies.cell.size[2], self.bodies.arm[s]);
        let (ends, reach, edge, radius) = match self.bodies.solid(s) {
            Some(solid) => {
                let thin = self.plan.bodies[b].thin;
                let ends = [-1.0, 1.0].map(|side| solid.arm([0.0, 0.0, side]));
                let reach = (self.inflation * thin).max(2.0 * CONVEX_MARGIN * thin);
                (ends, reach, MARGIN * (thin + top), thin)
            }
            None => {
                let r = self.bodies.radius[s];
                ([[0.0; 3]; 2], r * (1.0 + self.inflation), r + MARGIN * (r + top), r)
            }
        };
        for (arm, distance, sign) in [(ends[0], z + ends[0][2], 1.0), (ends[1], top - z - ends[1][2], -1.0)] {
            let depth = reach - distance;
            if depth > 0.0 {
                self.loads.act(b, add(from, arm), [0.0, 0.0, sign * 2.0 * depth]);
                found.hear(depth * depth, edge - distance, radius);
            }
        }
    }
}
