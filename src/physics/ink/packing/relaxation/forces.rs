//! Repulsion between overlapping spheres or convex bodies, and from the walls: forces and torques,
//! with the overlaps collected during their summation.

use super::OverlapRelaxation;
use crate::ink::packing::arrangement::{CONVEX_MARGIN, MARGIN};
use crate::numerics::Draws;
use crate::numerics::vector::{V3, add, cross, dot, scale, sub};

/// The overlaps of one evaluation of the forces.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct OverlapSums {
    /// Overlap energy ½ Σ L², µm².
    pub energy: f64,
    /// Depth of the deepest overlap, µm; not above 0 if there is none.
    pub deepest: f64,
    /// Largest depth over the sum of the two radii.
    pub deepest_relative: f64,
}

impl OverlapSums {
    #[inline(always)]
    fn add(&mut self, energy: f64, depth: f64, radii: f64) {
        self.energy += energy;
        self.deepest = self.deepest.max(depth);
        self.deepest_relative = self.deepest_relative.max(depth / radii);
    }
}

/// Forces and torques of one step, and the bodies on which they act.
pub(super) struct BodyLoads {
    pub force: Vec<V3>,
    pub torque: Vec<V3>,
    pub touched: Vec<bool>,
    /// The touched bodies in the order in which they were.
    pub joined: Vec<u32>,
    /// Squared lever arm that represents J/μ; zero for single spheres.
    pub inertia: Vec<f64>,
}

impl BodyLoads {
    pub fn new(inertia: Vec<f64>) -> Self {
        let bodies = inertia.len();
        Self {
            force: vec![[0.0; 3]; bodies],
            torque: vec![[0.0; 3]; bodies],
            touched: vec![false; bodies],
            joined: Vec::new(),
            inertia,
        }
    }

    /// Takes all forces and torques away.
    pub fn clear(&mut self) {
        for b in self.joined.iter().map(|b| *b as usize) {
            self.force[b] = [0.0; 3];
            self.torque[b] = [0.0; 3];
        }
    }

    /// Applies a force at a point relative to the centre of body b.
    #[inline(always)]
    fn apply(&mut self, b: usize, arm: V3, force: V3) {
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

/// What a wall meets of a sphere or of the convex body in it.
struct WallContact {
    /// The lowest and the highest point, relative to the sphere's centre; the centre itself of a
    /// sphere.
    lowest: V3,
    highest: V3,
    /// Distance from a wall, of those points, below which it repels.
    reach: f64,
    /// Distance below which there is an overlap.
    overlap_from: f64,
    /// Radius, or that of the thinnest part.
    radius: f64,
}

impl OverlapRelaxation<'_> {
    /// Forces and torques on the bodies of the moving list and on the bodies they push.
    pub(super) fn forces(&mut self, draws: &mut Draws) -> OverlapSums {
        let mut sums = OverlapSums::default();
        for k in 0..self.moving.len() {
            let b = self.moving[k] as usize;
            for s in self.arrangement.spheres_of(b) {
                if self.plan.cell.walls {
                    self.push_from_walls(b, s, &mut sums);
                }
                self.push_pairs(b, s, draws, &mut sums);
            }
        }
        sums
    }

    /// Repulsion of sphere s of body b and its neighbours.
    fn push_pairs(&mut self, b: usize, s: usize, draws: &mut Draws, sums: &mut OverlapSums) {
        let radius = self.arrangement.radius(s);
        let wider = 1.0 + self.inflation;
        let mut push = [0.0; 3];
        let mut pushed = false;
        for k in 0..self.arrangement.neighbours(s).len() {
            let arrangement = &self.arrangement;
            let t = arrangement.neighbours(s)[k] as usize;
            let d = arrangement.delta(s, t);
            let sum = radius + arrangement.radius(t);
            let reach = sum * wider;
            let d2 = dot(d, d);
            if d2 >= reach * reach {
                continue;
            }
            let other = arrangement.body_of(t);
            if other < b && self.moves[other] {
                continue; // the pair is handled from the other sphere
            }
            if !arrangement.are_spheres(s, t) {
                self.push_convex(s, t, d, sums);
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
            self.loads.apply(other, arrangement.arm(t), away); // +L on the other
            sums.add(0.5 * depth * depth, sum * (1.0 + MARGIN) - distance, sum); // energy L²/2
        }
        if pushed {
            self.loads.apply(b, self.arrangement.arm(s), push);
        }
    }

    /// Repulsion of two bodies of which one is convex: by the depth of their contact, with both
    /// inflated by their thinnest radii.
    fn push_convex(&mut self, s: usize, t: usize, d: V3, sums: &mut OverlapSums) {
        let arrangement = &self.arrangement;
        let thin = arrangement.thin_um(s) + arrangement.thin_um(t);
        let gap = (self.inflation * thin).max(2.0 * CONVEX_MARGIN * thin);
        let Some(contact) = arrangement.contact(s, t, d, gap) else { return };
        let depth = gap - contact.gap_um;
        if depth > 0.0 {
            let push = scale(contact.normal, depth);
            let first_arm = add(arrangement.arm(s), contact.arms[0]);
            let second_arm = add(arrangement.arm(t), contact.arms[1]);
            self.loads.apply(arrangement.body_of(s), first_arm, scale(push, -1.0));
            self.loads.apply(arrangement.body_of(t), second_arm, push);
            sums.add(0.5 * depth * depth, 1.5 * CONVEX_MARGIN * thin - contact.gap_um, thin);
        }
    }

    /// Repulsion from the walls as from the mirror image, L = 2 (R (1 + ε) − distance to the wall),
    /// of a convex body at its lowest and highest point.
    fn push_from_walls(&mut self, b: usize, s: usize, sums: &mut OverlapSums) {
        let height = self.plan.cell.size[2];
        let contact = self.wall_contact(s, height);
        let WallContact { lowest, highest, reach, overlap_from, radius } = contact;
        let from = self.arrangement.arm(s);
        let z = self.arrangement.centre_of(s)[2];
        for (arm, distance, sign) in [(lowest, z + lowest[2], 1.0), (highest, height - z - highest[2], -1.0)]
        {
            let depth = reach - distance;
            if depth > 0.0 {
                self.loads.apply(b, add(from, arm), [0.0, 0.0, sign * 2.0 * depth]);
                sums.add(depth * depth, overlap_from - distance, radius);
            }
        }
    }

    fn wall_contact(&self, s: usize, height: f64) -> WallContact {
        match self.arrangement.solid(s) {
            Some(solid) => {
                let thin = self.arrangement.thin_um(s);
                WallContact {
                    lowest: solid.arm([0.0, 0.0, -1.0]),
                    highest: solid.arm([0.0, 0.0, 1.0]),
                    reach: (self.inflation * thin).max(2.0 * CONVEX_MARGIN * thin),
                    overlap_from: MARGIN * (thin + height),
                    radius: thin,
                }
            }
            None => {
                let radius = self.arrangement.radius(s);
                WallContact {
                    lowest: [0.0; 3],
                    highest: [0.0; 3],
                    reach: radius * (1.0 + self.inflation),
                    overlap_from: radius + MARGIN * (radius + height),
                    radius,
                }
            }
        }
    }
}
