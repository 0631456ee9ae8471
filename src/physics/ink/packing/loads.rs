//! Forces and torques on the bodies of a packing, and what was found while they were summed.

use crate::numerics::vector::{V3, add, cross};

/// What one evaluation of the forces found.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct FoundLoads {
    pub energy: f64,
    pub overlap: f64,
    pub relative: f64,
}

/// Forces and torques of one step, and the bodies that feel any.
pub(crate) struct OverlapLoads {
    pub force: Vec<V3>,
    pub torque: Vec<V3>,
    pub touched: Vec<bool>,
    pub joined: Vec<u32>,
    /// The squared arm that stands for J/μ; zero for single spheres.
    pub inertia: Vec<f64>,
}

impl OverlapLoads {
    pub fn new(inertia: Vec<f64>) -> Self {
        let n = inertia.len();
        let (force, torque) = (vec![[0.0; 3]; n], vec![[0.0; 3]; n]);
        Self { force, torque, touched: vec![false; n], joined: Vec::new(), inertia }
    }

    /// Adds a force at an arm from the centre of body b.
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
