//! Euler steps of bodies under load, with the aligning field.

use super::OverlapRelaxation;
use crate::ink::grains::orientation::AxisField;
use crate::ink::packing::arrangement::Pose;
use crate::ink::packing::depth::DepthLaw;
use crate::ink::packing::plan::PackingPlan;
use crate::numerics::vector::{Rotation, V3, add, dot, norm, scale};

/// Motion of a body in one step.
struct BodyStep {
    displacement: V3,
    /// Rotation vector, rad.
    turn: V3,
}

/// Bodies that may pass a gate one way, beyond one, without another that passes the other way, as a
/// share of all. Without this, those that must wait gather about the gate: 15 % more grains within
/// 30 nm of it.
const MOST_PASSED: f64 = 0.01;

/// A depth at which the density of a profile steps.
pub(super) struct Gate {
    /// Depth over the thickness.
    depth: f64,
    /// Bodies that have gone down through it, less those that have gone up.
    passed: i64,
}

impl Gate {
    /// The gates of all profiles of a plan.
    pub fn all(plan: &PackingPlan) -> Vec<Self> {
        let mut depths: Vec<f64> = plan.depths.iter().flatten().flat_map(DepthLaw::steps).collect();
        depths.sort_by(f64::total_cmp);
        depths.dedup();
        depths.into_iter().map(|depth| Self { depth, passed: 0 }).collect()
    }
}

impl OverlapRelaxation<'_> {
    /// One Euler step of all bodies under load, which then form the new moving list.
    pub(super) fn advance(&mut self) {
        let ramp = self.ramp();
        let aligning = self.aligning(ramp);
        let mut outrun = false;
        for k in 0..self.loads.joined.len() {
            let b = self.loads.joined[k] as usize;
            self.loads.touched[b] = false;
            let BodyStep { displacement, turn } = self.take_step(b, ramp, &aligning);
            let Pose { centre, rotation } = self.arrangement.pose(b);
            let centre = add(centre, displacement);
            if turn == [0.0; 3] {
                self.arrangement.shift(b, centre);
            } else {
                self.arrangement.put(b, Pose { centre, rotation: rotation.then(Rotation::by(turn)) });
            }
            outrun |= self.arrangement.has_outrun_lists(b);
        }
        self.moving.iter().for_each(|b| self.moves[*b as usize] = false);
        self.loads.joined.iter().for_each(|b| self.moves[*b as usize] = true);
        std::mem::swap(&mut self.moving, &mut self.loads.joined);
        self.loads.joined.clear();
        if outrun {
            self.arrangement.list_neighbours_after(self.steps - self.listed, self.inflation);
            self.listed = self.steps;
        }
    }

    /// Translation and rotation of a body in one step; clears its forces.
    fn take_step(&mut self, b: usize, ramp: f64, aligning: &[bool]) -> BodyStep {
        let h = self.step / self.settings.translational_viscosity;
        let force = std::mem::take(&mut self.loads.force[b]);
        let torque = std::mem::take(&mut self.loads.torque[b]);
        let mut displacement = scale(force, h); // Δx = F Δt/μ
        displacement[2] *= self.freedom_along_depth(b);
        let mut turn = [0.0; 3];
        if self.loads.inertia[b] > 0.0 {
            // Δφ = M Δt/J, plus the rotation by the aligning field
            turn = add(scale(torque, h / self.loads.inertia[b]), self.alignment(b, ramp, aligning));
        }
        // No point of the body moves by more than the limit per step.
        let body = &self.plan.bodies[b];
        let path = norm(displacement) + norm(turn) * body.reach;
        let limit = self.settings.step_limit_radii * body.thin;
        if path > limit {
            let part = limit / path;
            displacement = scale(displacement, part);
            turn = scale(turn, part);
        }
        if !self.may_pass(b, displacement[2]) {
            displacement[2] = 0.0;
        }
        BodyStep { displacement, turn }
    }

    /// Motion of a body along the depth over that across: little where the density of its profile
    /// varies; that of a layer without a profile where grains are evenly spread.
    fn freedom_along_depth(&self, b: usize) -> f64 {
        let depth = || self.arrangement.pose(b).centre[2] / self.plan.cell.size[2];
        match self.plan.profile_of(b) {
            Some(law) if !law.is_even_at(depth()) => self.depth_mobility,
            _ => 1.0,
        }
    }

    /// Whether a body may move along the depth by `step_um`: where a density steps, as at an open
    /// joint, about as many bodies pass one way as the other.
    fn may_pass(&mut self, b: usize, step_um: f64) -> bool {
        if self.depth_mobility >= 1.0 {
            return true;
        }
        let height = self.plan.cell.size[2];
        let from = self.arrangement.pose(b).centre[2] / height;
        let to = from + step_um / height;
        let way = if to > from { 1 } else { -1 };
        let passed = |gate: &&mut Gate| (from < gate.depth) != (to < gate.depth);
        let most = (MOST_PASSED * self.arrangement.placed() as f64) as i64;
        let may = self.gates.iter_mut().filter(passed).all(|gate| gate.passed * way <= most);
        if may {
            self.gates.iter_mut().filter(passed).for_each(|gate| gate.passed += way);
        }
        may
    }

    /// Strength of the aligning torque at this step of the batch: 1 falling linearly to 0.
    fn ramp(&self) -> f64 {
        let steps = self.settings.aligning_steps as f64;
        if steps > 0.0 { (1.0 - (self.steps - self.batch_start) as f64 / steps).max(0.0) } else { 0.0 }
    }

    /// Pigments whose order is still below that of their field.
    fn aligning(&self, ramp: f64) -> Vec<bool> {
        let active = |field: &AxisField| ramp > 0.0 && field.kappa != 0.0;
        let fields = self.plan.fields.iter().map(|field| field.filter(active)).enumerate();
        fields.map(|(k, field)| field.is_some_and(|field| self.falls_short(k, field))).collect()
    }

    /// Whether the mean square cosine between a pigment's axes and its field is below that of the
    /// distribution.
    fn falls_short(&self, pigment: usize, field: AxisField) -> bool {
        let mut axes = 0.0;
        let mut squares = 0.0;
        let bodies = self.plan.bodies[..self.arrangement.placed()].iter().enumerate();
        for (b, body) in bodies.filter(|(_, body)| body.pigment == pigment) {
            for axis in body.axes(self.arrangement.pose(b).rotation) {
                axes += 1.0;
                squares += dot(axis, field.axis).powi(2);
            }
        }
        axes > 0.0 && field.wants_more(squares / axes)
    }

    /// Rotation by the aligning field in one step.
    fn alignment(&self, b: usize, ramp: f64, aligning: &[bool]) -> V3 {
        let body = &self.plan.bodies[b];
        match &self.plan.fields[body.pigment] {
            Some(field) if aligning[body.pigment] => {
                let axes = body.axes(self.arrangement.pose(b).rotation);
                let torque = scale(field.torque(axes), 1.0 / body.parts.len() as f64);
                // The torque is ½ at 45°.
                scale(torque, 2.0 * ramp * self.settings.aligning_deg_per_step.to_radians())
            }
            _ => [0.0; 3],
        }
    }
}
