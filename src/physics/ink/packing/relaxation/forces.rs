//! Repulsion of overlapping spheres, of each other and of the walls.

use super::OverlapRelaxation;
use crate::ink::packing::loads::FoundLoads;
use crate::ink::packing::sequential::MARGIN;
use crate::numerics::Draws;
use crate::numerics::vector::{dot, scale, sub};

impl OverlapRelaxation<'_, '_> {
    /// Forces and torques on the bodies of the moving list and on those they push.
    pub(super) fn forces(&mut self, draws: &mut Draws) -> FoundLoads {
        let mut found = FoundLoads::default();
        for k in 0..self.moving.len() {
            let b = self.moving[k] as usize;
            for s in self.bodies.first[b]..self.bodies.first[b + 1] {
                self.wall(b, s, &mut found);
                self.pairs(b, s, &mut found, draws);
            }
        }
        found
    }

    fn pairs(&mut self, b: usize, s: usize, found: &mut FoundLoads, draws: &mut Draws) {
        let bodies = &*self.bodies;
        let (p, r, wider) = (bodies.at[s], bodies.radius[s], 1.0 + self.inflation);
        let mut push = [0.0; 3];
        let mut pushed = false;
        for t in self.list.of(s).iter().map(|t| *t as usize) {
            let d = bodies.cell.delta(p, bodies.at[t]);
            let sum = r + bodies.radius[t];
            let reach = sum * wider;
            let d2 = dot(d, d);
            if d2 >= reach * reach {
                continue;
            }
            let other = bodies.owner[t] as usize;
            if other < b && self.moves[other] {
                continue; // met from the other side
            }
            let distance = d2.sqrt();
            let depth = reach - distance; // L = (1 + ε)(R₁ + R₂) − distance
            // Coincident centres have no line of action: any direction will do.
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
            self.loads.act(b, bodies.arm[s], push);
        }
    }

    /// A wall repels like the sphere's own image behind it: L = 2 (R (1 + ε) − distance to the wall).
    fn wall(&mut self, b: usize, s: usize, found: &mut FoundLoads) {
        if !self.bodies.cell.walls {
            return;
        }
        let (z, r, top) = (self.bodies.at[s][2], self.bodies.radius[s], self.bodies.cell.size[2]);
        for (distance, sign) in [(z, 1.0), (top - z, -1.0)] {
            let depth = r * (1.0 + self.inflation) - distance;
            if depth > 0.0 {
                self.loads.act(b, self.bodies.arm[s], [0.0, 0.0, sign * 2.0 * depth]);
                let margin = MARGIN * (r + top);
                found.hear(depth * depth, r + margin - distance, r);
            }
        }
    }
}
