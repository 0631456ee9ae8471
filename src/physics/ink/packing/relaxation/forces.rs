//! Repulsion between overlapping spheres or convex bodies, and from the walls.

use super::OverlapRelaxation;
use crate::ink::packing::loads::FoundLoads;
use crate::ink::packing::sequential::{CONVEX_MARGIN, MARGIN};
use crate::numerics::Draws;
use crate::numerics::vector::{V3, add, dot, scale, sub};

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
        let mut push = [0.0; 3];
        let mut pushed = false;
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
            let away = if distance > 1e-9 * sum {
                scale(d, depth / distance)
            } else {
                scale(draws.direction(), depth)
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
        if depth <= 0.0 {
            return;
        }
        let push = scale(contact.normal, depth);
        let arms = [s, t].map(|s| self.bodies.arm[s]);
        self.loads.act(own, add(arms[0], contact.arms[0]), scale(push, -1.0));
        self.loads.act(other, add(arms[1], contact.arms[1]), push);
        found.hear(0.5 * depth * depth, 1.5 * CONVEX_MARGIN * thin - contact.gap_um, thin);
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
