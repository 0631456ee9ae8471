//! Euler steps of bodies under load, with the aligning field.

use super::OverlapRelaxation;
use crate::ink::grains::orientation::AxisField;
use crate::numerics::vector::{Rotation, V3, add, dot, norm, scale};

impl OverlapRelaxation<'_, '_> {
    /// One Euler step of all bodies under load, which then form the new moving list.
    pub(super) fn advance(&mut self) {
        let h = self.step / self.settings.translational_viscosity;
        let (ramp, mut outrun) = (self.ramp(), false);
        let aligning = self.aligning(ramp);
        for k in 0..self.loads.joined.len() {
            let b = self.loads.joined[k] as usize;
            self.loads.touched[b] = false;
            let [by, turn] = self.motion(b, h, ramp, &aligning);
            let centre = add(self.bodies.centre[b], by);
            if turn == [0.0; 3] {
                self.bodies.shift(b, centre);
            } else {
                self.bodies.put(b, centre, self.bodies.rotation[b].then(Rotation::by(turn)));
            }
            outrun |= self.bodies.range(b).any(|s| self.list.outrun(self.bodies, s));
        }
        self.moving.iter().for_each(|b| self.moves[*b as usize] = false);
        self.loads.joined.iter().for_each(|b| self.moves[*b as usize] = true);
        std::mem::swap(&mut self.moving, &mut self.loads.joined);
        self.loads.joined.clear();
        if outrun {
            self.list.adapt(self.steps - self.listed, self.mean_radius);
            self.list.remake(self.bodies, self.inflation);
            self.listed = self.steps;
        }
    }

    /// Translation and rotation of a body in one step; clears its forces.
    fn motion(&mut self, b: usize, h: f64, ramp: f64, aligning: &[bool]) -> [V3; 2] {
        let torque = std::mem::take(&mut self.loads.torque[b]);
        let by = scale(std::mem::take(&mut self.loads.force[b]), h); // Δx = F Δt/μ
        let mut turn = [0.0; 3];
        if self.loads.inertia[b] > 0.0 {
            // Δφ = M Δt/J, plus the rotation by the aligning field
            turn = add(scale(torque, h / self.loads.inertia[b]), self.alignment(b, ramp, aligning));
        }
        // No point of the body moves by more than the limit per step.
        let body = &self.plan.bodies[b];
        let (path, limit) = (norm(by) + norm(turn) * body.reach, self.settings.step_limit_radii * body.thin);
        if path > limit { [by, turn].map(|part| scale(part, limit / path)) } else { [by, turn] }
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
        let own = (0..self.bodies.placed).filter(|b| self.plan.bodies[*b].pigment == pigment);
        let squares = own.flat_map(|b| self.bodies.axes(b)).map(|u| dot(u, field.axis).powi(2));
        let (n, sum) = squares.fold((0.0, 0.0), |(n, s), q| (n + 1.0, s + q));
        n > 0.0 && field.wants_more(sum / n)
    }

    /// Rotation by the aligning field in one step.
    fn alignment(&self, b: usize, ramp: f64, aligning: &[bool]) -> V3 {
        let body = &self.plan.bodies[b];
        match &self.plan.fields[body.pigment] {
            Some(field) if aligning[body.pigment] => {
                let torque = scale(field.torque(self.bodies.axes(b)), 1.0 / body.parts.len() as f64);
                // The torque is ½ at 45°.
                scale(torque, 2.0 * ramp * self.settings.aligning_deg_per_step.to_radians())
            }
            _ => [0.0; 3],
        }
    }
}
