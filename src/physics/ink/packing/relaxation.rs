//! Relaxation of overlaps (P1 section 3): elastic repulsion, overdamped motion, Euler steps.
//!
//! Overlapping spheres repel each other with F = L, L = (1 + ε)(R₁ + R₂) − distance; a wall acts
//! like the mirror image of the sphere. Convex bodies repel each other along the normal of their
//! contact by its depth. Bodies follow μ v = F, J ω = M = Σ rᵢ × Fᵢ. Only bodies on
//! the moving list are evaluated; bodies pushed by them join it. A batch ends when the true overlap
//! (ε = 0) vanishes. Where bodies jam they start anew (`starts`).

mod forces;
pub(super) mod starts;
mod steps;

use super::arrangement::Arrangement;
use super::plan::{PackingPlan, RigidBody};
use super::request::RelaxationSettings;
use crate::ink::error::{Course, PackError, PackProgress};
use crate::numerics::Draws;
use crate::numerics::vector::{V3, dot};
use forces::{BodyLoads, OverlapSums};
use std::ops::Range;
use steps::Gate;

/// Steps between checks that the energy still decreases.
const PATIENCE: u64 = 400;
/// Inflation below which a stalled relaxation is abandoned.
const LEAST_INFLATION: f64 = 2e-4;
/// Steps before interlocked clusters are reinserted.
const TANGLE_PATIENCE: u64 = 50;
/// Fraction of the bodies up to which those that overlap count as few.
const FEW: f64 = 0.02;
/// Reinsertions of interlocked clusters.
const MOST_REINSERTIONS: u64 = 100;
/// Motion along the depth, over that across, of bodies whose density varies with it, as long as
/// this removes overlaps: repulsion drives grains from where they are dense to where they are not.
const DEPTH_MOBILITY: f64 = 1.0 / 64.0;
/// Steps between two reports to the watch.
const REPORT: u64 = 20;

struct OverlapRelaxation<'a> {
    arrangement: Arrangement<'a>,
    plan: &'a PackingPlan<'a>,
    settings: &'a RelaxationSettings,
    /// Bodies whose forces are evaluated in this step.
    moving: Vec<u32>,
    /// Whether each body is one of them.
    moves: Vec<bool>,
    loads: BodyLoads,
    inflation: f64,
    step: f64,
    /// Motion along the depth over that across, where the density of a profile varies.
    depth_mobility: f64,
    gates: Vec<Gate>,
    steps: u64,
    batch_start: u64,
    /// Whether any body has more than one sphere.
    clusters: bool,
    reinsertions: u64,
    /// Step at which bodies last outran the lists of neighbours.
    listed: u64,
}

impl<'a> OverlapRelaxation<'a> {
    fn new(arrangement: Arrangement<'a>) -> Self {
        let plan = arrangement.plan;
        let settings = &plan.request.relaxation;
        let squared_arm = |body: &RigidBody| {
            let farthest = body.spheres.iter().map(|s| dot(s.center_um, s.center_um)).fold(0.0, f64::max);
            if body.solids.is_empty() { farthest } else { body.reach * body.reach }
        };
        let inertia = plan.bodies.iter().map(|b| settings.rotational_viscosity * squared_arm(b)).collect();
        Self {
            arrangement,
            plan,
            settings,
            moving: Vec::new(),
            moves: vec![false; plan.bodies.len()],
            loads: BodyLoads::new(inertia),
            inflation: settings.inflation,
            step: settings.step,
            depth_mobility: DEPTH_MOBILITY,
            gates: Gate::all(plan),
            steps: 0,
            batch_start: 0,
            clusters: plan.bodies.iter().any(|b| !b.single_sphere()),
            reinsertions: 0,
            listed: 0,
        }
    }

    /// Places all bodies of the plan in batches; stops at the first batch whose overlaps cannot be
    /// removed. Returns the overlaps left if the relaxation stalled or reached its limit of steps.
    fn place_all(&mut self, course: &mut Course) -> Result<Option<OverlapSums>, PackError> {
        let count = self.plan.bodies.len();
        let batches = self.settings.batches.min(count.max(1));
        for batch in 1..=batches {
            self.insert(count * batch / batches, &mut course.draws);
            let left = self.settle(self.settings.max_steps.saturating_sub(self.steps), course)?;
            if left.is_some() {
                return Ok(left);
            }
        }
        Ok(None)
    }

    /// Inserts bodies at random until the cell holds `count` of them; all of them move.
    fn insert(&mut self, count: usize, draws: &mut Draws) {
        // Bodies still in (inflated) contact stay on the moving list, without the forces of the
        // last evaluation.
        self.loads.clear();
        self.moves.fill(false);
        self.moving = std::mem::take(&mut self.loads.joined);
        for b in self.moving.iter().map(|b| *b as usize) {
            self.loads.touched[b] = false;
            self.moves[b] = true;
        }
        let placed = self.arrangement.placed();
        let places = random_places(self.plan, placed..count, draws);
        for (b, place) in (placed..count).zip(places) {
            self.arrangement.scatter(b, place, self.plan.draw_rotation(b, draws));
            self.moves[b] = true;
            self.moving.push(b as u32);
        }
        self.arrangement.set_placed(count);
        self.batch_start = self.steps;
        self.inflation = self.settings.inflation;
        self.step = self.settings.step;
        self.depth_mobility = DEPTH_MOBILITY;
        self.arrangement.list_neighbours(self.inflation);
    }

    /// Steps until no overlap is left (`None`), or until it stalls or reaches the limit (returns
    /// the overlaps left).
    fn settle(&mut self, limit: u64, course: &mut Course) -> Result<Option<OverlapSums>, PackError> {
        let start = self.steps;
        let mut energy_before = f64::INFINITY;
        let mut energy_at_check = f64::INFINITY;
        let mut energy_of_tangle = f64::INFINITY;
        loop {
            let overlaps = self.forces(&mut course.draws);
            if overlaps.deepest <= 0.0 {
                return Ok(None);
            }
            if self.steps.is_multiple_of(REPORT) {
                self.progress(&overlaps).report(course)?;
            }
            if self.steps - start >= limit {
                return Ok(Some(overlaps));
            }
            let step_of_batch = self.steps - self.batch_start + 1;
            if step_of_batch.is_multiple_of(PATIENCE) {
                if overlaps.energy > 0.8 * energy_at_check {
                    if self.plan.has_profiles() && self.depth_mobility < 1.0 {
                        self.depth_mobility = (4.0 * self.depth_mobility).min(1.0);
                    } else {
                        self.inflation *= 0.5;
                    }
                    if self.inflation < LEAST_INFLATION {
                        return Ok(Some(overlaps));
                    }
                }
                energy_at_check = overlaps.energy;
            }
            if self.clusters && step_of_batch.is_multiple_of(TANGLE_PATIENCE) {
                if overlaps.energy > 0.5 * energy_of_tangle {
                    self.untangle(&mut course.draws);
                }
                energy_of_tangle = overlaps.energy;
            }
            let factor = if overlaps.energy > energy_before { 0.7 } else { 1.03 };
            self.step = (factor * self.step).clamp(0.05, self.settings.step);
            energy_before = overlaps.energy;
            self.advance();
            self.steps += 1;
        }
    }

    /// Reinserts interlocked clusters at random: repulsion cannot separate them, so this applies
    /// when only a few bodies still overlap and do not come free.
    fn untangle(&mut self, draws: &mut Draws) {
        let strain = self.arrangement.strain();
        let interlocked: Vec<usize> = (0..strain.len()).filter(|b| strain[*b] > 0.0).collect();
        let few = (FEW * strain.len() as f64).max(4.0) as usize;
        if interlocked.len() > few || self.reinsertions >= MOST_REINSERTIONS {
            return;
        }
        self.reinsertions += 1;
        for b in interlocked {
            let place = self.plan.cell.draw_place(draws);
            self.arrangement.scatter(b, place, self.plan.draw_rotation(b, draws));
            self.loads.touch(b);
            if !self.moves[b] {
                self.moves[b] = true;
                self.moving.push(b as u32);
            }
        }
        // Forces at the old positions must not move the bodies at their new ones.
        self.loads.clear();
        self.arrangement.list_neighbours(self.inflation);
    }

    fn progress(&self, overlaps: &OverlapSums) -> PackProgress {
        let progress = self.plan.progress("relaxation", self.steps, self.arrangement.placed());
        PackProgress { overlap_energy: overlaps.energy, largest_overlap_um: overlaps.deepest, ..progress }
    }

    /// Puts all placed bodies on the moving list.
    fn start_all(&mut self) {
        self.moving = (0..self.arrangement.placed() as u32).collect();
        self.moves.fill(true);
        self.batch_start = self.steps;
        self.arrangement.list_neighbours(self.inflation);
    }
}

/// Uniform positions in the cell, sorted by region so that neighbours in space are neighbours in
/// memory. (The bodies are shuffled, hence the position of each is still uniform.)
fn random_places(plan: &PackingPlan, bodies: Range<usize>, draws: &mut Draws) -> Vec<V3> {
    let count = bodies.len();
    let mut places: Vec<V3> = bodies.map(|_| plan.cell.draw_place(draws)).collect();
    let side = (plan.cell.size.iter().product::<f64>() / count.max(1) as f64).cbrt() * 2.0;
    places.sort_by_cached_key(|p: &V3| [p[1], p[0], p[2]].map(|c| (c / side) as u64));
    places
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ink::grains::agglomeration::{Agglomeration, GrainCount};
    use crate::ink::packing::arrangement::Pose;
    use crate::ink::{PackingRequest, PigmentGrains, Shape};
    use crate::numerics::vector::Rotation;

    /// Energy, and force and torque on body `b`, of bodies in given places.
    fn loads(plan: &PackingPlan, poses: &[Pose], b: usize) -> (f64, [V3; 2]) {
        let mut arrangement = Arrangement::new(plan);
        poses.iter().enumerate().for_each(|(b, pose)| arrangement.put(b, *pose));
        arrangement.set_placed(poses.len());
        let mut relaxation = OverlapRelaxation::new(arrangement);
        relaxation.start_all();
        let overlaps = relaxation.forces(&mut Draws::new(1, 1));
        (overlaps.energy, [relaxation.loads.force[b], relaxation.loads.torque[b]])
    }

    /// Forces and torques are the negative gradient of the energy, of pairs and of walls.
    /// *Planted*: a wall's force on a body of an agglomerate without its lever arm.
    #[test]
    fn loads_are_the_gradient_of_the_energy() {
        for shape in [Shape::CYLINDER, Shape::Box { edges: [1.0, 1.5, 0.7] }, Shape::Sphere] {
            let grains = GrainCount::Constant(3);
            let agglomeration = Some(Agglomeration { degree: 1.0, grains, fractal: None });
            let pigment = PigmentGrains { agglomeration, ..PigmentGrains::of(shape.clone(), 90.0, 0.3) };
            let request = PackingRequest {
                period_um: [1.2; 2],
                thickness_um: 0.3,
                pigments: vec![pigment],
                ..Default::default()
            };
            let mut draws = Draws::new(3, 0);
            let plan = PackingPlan::new(&request, &mut draws).unwrap();
            let poses = random_poses(&plan, &mut draws);
            // the step of central differences: kinks of a thousandth of a grain are passed by few
            let h = 1e-6;
            let mut wrong = 0;
            for b in 0..12 {
                let (_, [force, torque]) = loads(&plan, &poses, b);
                let scale = force.iter().chain(&torque).fold(0.0, |m: f64, x| m.max(x.abs()));
                for axis in 0..6 {
                    let energy = |by: f64| {
                        let mut moved = poses.clone();
                        let mut along = [0.0; 3];
                        along[axis % 3] = by;
                        match axis < 3 {
                            true => moved[b].centre[axis] += by,
                            false => moved[b].rotation = moved[b].rotation.then(Rotation::by(along)),
                        }
                        loads(&plan, &moved, b).0
                    };
                    let slope = (energy(h) - energy(-h)) / (2.0 * h);
                    let load = if axis < 3 { force[axis] } else { torque[axis - 3] };
                    wrong += usize::from((load + slope).abs() > 1e-3 * scale + 1e-8);
                }
            }
            // a body's edge may pass another one's within the step
            assert!(wrong <= 2, "{}: {wrong} of 72", shape.name());
        }
    }

    fn random_poses(plan: &PackingPlan, draws: &mut Draws) -> Vec<Pose> {
        let pose = |_| {
            let centre = plan.cell.draw_place(draws);
            let axis = draws.direction();
            Pose { centre, rotation: draws.rotation_with_axis(axis) }
        };
        (0..plan.bodies.len()).map(pose).collect()
    }
}
