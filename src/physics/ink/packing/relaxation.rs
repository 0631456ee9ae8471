//! Relaxation of overlaps (P1 section 3): elastic repulsion, overdamped motion, Euler steps.
//!
//! Overlapping spheres repel each other with F = L, L = (1 + ε)(R₁ + R₂) − distance; a wall acts
//! like the mirror image of the sphere. Convex bodies repel each other along the normal of their
//! contact by its depth. Bodies follow μ v = F, J ω = M = Σ rᵢ × Fᵢ. Only bodies on
//! the moving list are evaluated; bodies pushed by them join it. A batch ends when the true overlap
//! (ε = 0) vanishes.

mod forces;
mod steps;

use super::bodies::Bodies;
use super::hard_bodies::scatter;
use super::neighbours::{Neighbours, strain};
use super::plan::{GrainSpheres, PackingPlan};
use super::request::RelaxationSettings;
use crate::ink::error::{Course, PackError, PackProgress};
use crate::numerics::Draws;
use crate::numerics::vector::{V3, dot};
use forces::{FoundLoads, OverlapLoads};

/// Skin of the neighbour lists in mean radii: wide enough for a few steps of the largest allowed
/// length (the time of 10 × 10 × 1 µm cases is constant between 0.7 and 1.0).
const SKIN_RADII: f64 = 0.9;
/// Steps between checks that the energy still decreases.
const PATIENCE: u64 = 400;
/// Inflation below which a stalled relaxation is abandoned.
const LEAST_INFLATION: f64 = 2e-4;
/// Steps before interlocked clusters are reinserted, the fraction of bodies that counts as few, and
/// the number of trials.
const TANGLE_PATIENCE: u64 = 50;
const FEW: f64 = 0.02;
const MOST_THROWS: u64 = 100;
const REPORT: u64 = 20;

/// Places all bodies of the plan in batches; stops at the first batch whose overlaps cannot be
/// removed. Returns the number of steps, and the overlaps left if the relaxation stalled or reached
/// its limit of steps.
pub fn relax_all(bodies: &mut Bodies, course: &mut Course) -> Result<(u64, Option<FoundLoads>), PackError> {
    let count = bodies.plan.bodies.len();
    let mut relaxation = OverlapRelaxation::new(bodies);
    let settings = relaxation.settings;
    let batches = settings.batches.min(count.max(1));
    for batch in 1..=batches {
        relaxation.insert(count * batch / batches, &mut course.draws);
        let left = relaxation.settle(settings.max_steps.saturating_sub(relaxation.steps), course)?;
        if left.is_some() {
            return Ok((relaxation.steps, left));
        }
    }
    Ok((relaxation.steps, None))
}

pub(crate) struct OverlapRelaxation<'r, 'a> {
    bodies: &'r mut Bodies<'a>,
    plan: &'a PackingPlan<'a>,
    settings: &'a RelaxationSettings,
    list: Neighbours,
    moving: Vec<u32>,
    moves: Vec<bool>,
    loads: OverlapLoads,
    pub inflation: f64,
    step: f64,
    steps: u64,
    batch_start: u64,
    /// Whether any body has more than one sphere.
    clusters: bool,
    thrown_again: u64,
    /// Step at which the neighbour lists were last built.
    listed: u64,
    mean_radius: f64,
}

impl<'r, 'a> OverlapRelaxation<'r, 'a> {
    pub fn new(bodies: &'r mut Bodies<'a>) -> Self {
        let (plan, settings) = (bodies.plan, &bodies.plan.request.relaxation);
        let mean = bodies.radius.iter().sum::<f64>() / bodies.radius.len().max(1) as f64;
        let arm2 = |b: &GrainSpheres| {
            let farthest = b.spheres.iter().map(|s| dot(s.center_um, s.center_um)).fold(0.0, f64::max);
            if b.solids.is_empty() { farthest } else { b.reach * b.reach }
        };
        let inertia = plan.bodies.iter().map(|b| settings.rotational_viscosity * arm2(b)).collect();
        Self {
            list: Neighbours::new(bodies, settings.inflation, SKIN_RADII * mean),
            bodies,
            plan,
            settings,
            moving: Vec::new(),
            moves: vec![false; plan.bodies.len()],
            loads: OverlapLoads::new(inertia),
            inflation: settings.inflation,
            step: settings.step,
            steps: 0,
            batch_start: 0,
            clusters: plan.bodies.iter().any(|b| !b.single_sphere()),
            thrown_again: 0,
            listed: 0,
            mean_radius: mean,
        }
    }

    /// Inserts bodies at random until the cell holds `upto` of them; all of them move.
    fn insert(&mut self, upto: usize, draws: &mut Draws) {
        self.rest();
        let places = scattered(self.bodies, upto - self.bodies.placed, draws);
        for (b, place) in (self.bodies.placed..upto).zip(places) {
            scatter(self.bodies, b, place, draws);
            self.moves[b] = true;
            self.moving.push(b as u32);
        }
        self.bodies.placed = upto;
        self.batch_start = self.steps;
        self.inflation = self.settings.inflation;
        self.step = self.settings.step;
        self.list.remake(self.bodies, self.inflation);
    }

    /// Clears the forces of the last evaluation; bodies still in (inflated) contact stay on the
    /// moving list.
    fn rest(&mut self) {
        self.loads.clear();
        self.moves.fill(false);
        self.moving = std::mem::take(&mut self.loads.joined);
        for b in self.moving.iter().map(|b| *b as usize) {
            (self.loads.touched[b], self.moves[b]) = (false, true);
        }
    }

    /// Steps until no overlap is left (`None`), or until it stalls or reaches the limit (returns
    /// the overlaps left).
    pub fn settle(&mut self, limit: u64, course: &mut Course) -> Result<Option<FoundLoads>, PackError> {
        let start = self.steps;
        let (mut before, mut milestone, mut mark) = (f64::INFINITY, f64::INFINITY, f64::INFINITY);
        loop {
            let found = self.forces(&mut course.draws);
            if found.overlap <= 0.0 {
                return Ok(None);
            }
            if self.steps.is_multiple_of(REPORT) {
                self.progress(&found).report(course)?;
            }
            if self.steps - start >= limit {
                return Ok(Some(found));
            }
            if (self.steps - self.batch_start + 1).is_multiple_of(PATIENCE) {
                if found.energy > 0.8 * milestone {
                    self.inflation *= 0.5;
                    if self.inflation < LEAST_INFLATION {
                        return Ok(Some(found));
                    }
                }
                milestone = found.energy;
            }
            if self.clusters && (self.steps - self.batch_start + 1).is_multiple_of(TANGLE_PATIENCE) {
                if found.energy > 0.5 * mark {
                    self.untangle(&mut course.draws);
                }
                mark = found.energy;
            }
            let factor = if found.energy > before { 0.7 } else { 1.03 };
            self.step = (factor * self.step).clamp(0.05, self.settings.step);
            before = found.energy;
            self.advance();
            self.steps += 1;
        }
    }

    /// Reinserts interlocked clusters at random: repulsion cannot separate them, so this applies
    /// when only a few bodies still overlap and do not come free.
    fn untangle(&mut self, draws: &mut Draws) {
        let strain = strain(self.bodies);
        let hooked: Vec<usize> = (0..strain.len()).filter(|b| strain[*b] > 0.0).collect();
        let few = (FEW * strain.len() as f64).max(4.0) as usize;
        if hooked.len() > few || self.thrown_again >= MOST_THROWS {
            return;
        }
        self.thrown_again += 1;
        for b in hooked {
            let place = self.bodies.cell.draw_place(draws);
            scatter(self.bodies, b, place, draws);
            self.loads.touch(b);
            if !self.moves[b] {
                self.moves[b] = true;
                self.moving.push(b as u32);
            }
        }
        // Forces at the old positions must not move the bodies at their new ones.
        self.loads.clear();
        self.list.remake(self.bodies, self.inflation);
    }

    fn progress(&self, found: &FoundLoads) -> PackProgress {
        let progress = self.plan.progress("relaxation", self.steps, self.bodies.placed);
        PackProgress { overlap_energy: found.energy, largest_overlap_um: found.overlap, ..progress }
    }

    /// Puts all placed bodies on the moving list.
    pub fn start_all(&mut self) {
        self.moving = (0..self.bodies.placed as u32).collect();
        self.moves.fill(true);
        self.batch_start = self.steps;
        self.list.remake(self.bodies, self.inflation);
    }
}

/// Uniform positions in the cell, sorted by region so that neighbours in space are neighbours in
/// memory. (The bodies are shuffled, hence the position of each is still uniform.)
fn scattered(bodies: &Bodies, n: usize, draws: &mut Draws) -> Vec<V3> {
    let mut places: Vec<V3> = (0..n).map(|_| bodies.cell.draw_place(draws)).collect();
    let side = (bodies.cell.size.iter().product::<f64>() / n.max(1) as f64).cbrt() * 2.0;
    places.sort_by_cached_key(|p: &V3| [p[1], p[0], p[2]].map(|c| (c / side) as u64));
    places
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ink::grains::agglomeration::{Agglomeration, GrainCount};
    use crate::ink::{PackingRequest, PigmentGrains, Shape};
    use crate::numerics::vector::Rotation;

    /// Energy, and force and torque on body `b`, of bodies in given places.
    fn loads(plan: &PackingPlan, places: &[(V3, Rotation)], b: usize) -> (f64, [V3; 2]) {
        let mut bodies = Bodies::new(plan);
        places.iter().enumerate().for_each(|(b, (centre, rotation))| bodies.put(b, *centre, *rotation));
        bodies.placed = places.len();
        let mut relaxation = OverlapRelaxation::new(&mut bodies);
        relaxation.start_all();
        let found = relaxation.forces(&mut Draws::new(1, 1));
        (found.energy, [relaxation.loads.force[b], relaxation.loads.torque[b]])
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
            let places: Vec<(V3, Rotation)> = scattered_at(&plan, &mut draws);
            // the step of central differences: kinks of a thousandth of a grain are passed by few
            let h = 1e-6;
            let mut wrong = 0;
            for b in 0..12 {
                let (_, [force, torque]) = loads(&plan, &places, b);
                let scale = force.iter().chain(&torque).fold(0.0, |m: f64, x| m.max(x.abs()));
                for axis in 0..6 {
                    let energy = |by: f64| {
                        let mut moved = places.clone();
                        let mut along = [0.0; 3];
                        along[axis % 3] = by;
                        match axis < 3 {
                            true => moved[b].0[axis] += by,
                            false => moved[b].1 = moved[b].1.then(Rotation::by(along)),
                        }
                        loads(&plan, &moved, b).0
                    };
                    let slope = (energy(h) - energy(-h)) / (2.0 * h);
                    let own = if axis < 3 { force[axis] } else { torque[axis - 3] };
                    wrong += usize::from((own + slope).abs() > 1e-3 * scale + 1e-8);
                }
            }
            // a body's edge may pass another one's within the step
            assert!(wrong <= 2, "{}: {wrong} of 72", shape.name());
        }
    }

    fn scattered_at(plan: &PackingPlan, draws: &mut Draws) -> Vec<(V3, Rotation)> {
        let place = |_| {
            let (centre, axis) = (plan.cell.draw_place(draws), draws.direction());
            (centre, draws.rotation_with_axis(axis))
        };
        (0..plan.bodies.len()).map(place).collect()
    }
}
