//! The bodies of a plan in their places: the one owner of places, grid and neighbour lists.
//!
//! Sequential addition and Monte Carlo ask for a place, and get it if it is free; the relaxation
//! moves bodies that may overlap. Both do it here, so that grid and lists are always of the places
//! that the bodies have.

use super::cell::CellGrid;
use super::neighbours::{CellSpheres, NeighbourLists};
use super::plan::PackingPlan;
use crate::ink::grains::contact::{self, Contact};
use crate::ink::{Grain, Solid, Sphere};
use crate::numerics::vector::{Rotation, V3, add, dot, norm, scale, sub, unit};
use std::ops::Range;

/// Gaps below this fraction of the sum of radii count as overlap, so that rounding cannot fail the
/// final check.
pub(crate) const MARGIN: f64 = 1e-10;

/// Gaps between convex bodies below this fraction of the sum of their thinnest radii count as
/// overlap: the proof of their separation finds its direction by iteration.
pub(crate) const CONVEX_MARGIN: f64 = 1e-6;

/// Place and rotation of a body.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pose {
    pub centre: V3,
    pub rotation: Rotation,
}

/// Bodies in the cell. Arrays over spheres are flat; `first[b]..first[b + 1]` belong to body b.
pub(crate) struct Arrangement<'a> {
    pub plan: &'a PackingPlan<'a>,
    /// Number of bodies in place: the first ones of the plan.
    placed: usize,
    poses: Vec<Pose>,
    first: Vec<usize>,
    spheres: CellSpheres,
    /// Rotated vectors from the body's centre to its spheres.
    arm: Vec<V3>,
    /// Per sphere, the convex body that it is around, about its centre and as rotated.
    solid: Vec<Option<Box<Solid>>>,
    /// The spheres of the placed bodies, as long as bodies come and move one at a time.
    grid: Option<CellGrid>,
    lists: NeighbourLists,
}

impl<'a> Arrangement<'a> {
    /// The empty cell of a plan.
    pub fn new(plan: &'a PackingPlan<'a>) -> Self {
        let mut first = vec![0];
        let mut owner = Vec::new();
        let mut radius = Vec::new();
        let mut solid = Vec::new();
        for (b, body) in plan.bodies.iter().enumerate() {
            radius.extend(body.spheres.iter().map(|s| s.radius_um));
            solid.extend((0..body.spheres.len()).map(|i| body.solids.get(i).cloned().map(Box::new)));
            owner.resize(radius.len(), b as u32);
            first.push(radius.len());
        }
        let mean_radius = radius.iter().sum::<f64>() / radius.len().max(1) as f64;
        Self {
            plan,
            placed: 0,
            poses: vec![Pose { centre: [0.0; 3], rotation: Rotation::IDENTITY }; plan.bodies.len()],
            first,
            arm: vec![[0.0; 3]; radius.len()],
            spheres: CellSpheres { cell: plan.cell, owner, centre: vec![[0.0; 3]; radius.len()], radius },
            solid,
            grid: None,
            lists: NeighbourLists::new(mean_radius),
        }
    }

    /// Number of bodies in place: the first ones of the plan.
    pub fn placed(&self) -> usize {
        self.placed
    }

    pub fn pose(&self, b: usize) -> Pose {
        self.poses[b]
    }

    /// The spheres of body b.
    pub fn spheres_of(&self, b: usize) -> Range<usize> {
        self.first[b]..self.first[b + 1]
    }

    /// Wrapped centre of sphere s.
    #[inline(always)]
    pub fn centre_of(&self, s: usize) -> V3 {
        self.spheres.centre[s]
    }

    /// Vector from the centre of sphere s to the nearest image of that of sphere t.
    #[inline(always)]
    pub fn delta(&self, s: usize, t: usize) -> V3 {
        self.spheres.cell.delta(self.spheres.centre[s], self.spheres.centre[t])
    }

    #[inline(always)]
    pub fn radius(&self, s: usize) -> f64 {
        self.spheres.radius[s]
    }

    /// Rotated vector from the body's centre to its sphere s.
    #[inline(always)]
    pub fn arm(&self, s: usize) -> V3 {
        self.arm[s]
    }

    /// The body that sphere s belongs to.
    #[inline(always)]
    pub fn body_of(&self, s: usize) -> usize {
        self.spheres.owner[s] as usize
    }

    /// Radius of the thinnest part of the body that sphere s belongs to, µm.
    pub fn thin_um(&self, s: usize) -> f64 {
        self.plan.bodies[self.body_of(s)].thin
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
            let arms = [scale(normal, self.radius(s)), scale(normal, -self.radius(t))];
            let gap_um = norm(d) - self.radius(s) - self.radius(t);
            return (gap_um < within_um).then_some(Contact { gap_um, normal, arms });
        }
        let body = |s: usize| {
            let around = Sphere { center_um: [0.0; 3], radius_um: self.radius(s) };
            self.solid(s).cloned().unwrap_or_else(|| around.solid())
        };
        contact::contact(&body(s), &body(t), d, within_um)
    }

    /// Lowest and highest z of body b, relative to its centre.
    fn span_z(&self, b: usize) -> [f64; 2] {
        let ends = self.spheres_of(b).map(|s| self.extent_z(s).map(|z| self.arm[s][2] + z));
        ends.fold([f64::MAX, f64::MIN], |e, [low, high]| [e[0].min(low), e[1].max(high)])
    }

    /// Lowest and highest z of what sphere s stands for, relative to its centre.
    fn extent_z(&self, s: usize) -> [f64; 2] {
        self.solid(s).map_or([-self.radius(s), self.radius(s)], |solid| solid.extent_um(2))
    }

    /// The grains of the placed bodies, with contiguous coordinates.
    pub fn grains(&self) -> Vec<Grain> {
        let mut agglomerates = 0;
        let mut grains = Vec::new();
        for (b, body) in self.plan.bodies[..self.placed].iter().enumerate() {
            let agglomerate = (body.parts.len() > 1).then_some(agglomerates);
            agglomerates += usize::from(agglomerate.is_some());
            let Pose { centre, rotation } = self.poses[b];
            for part in &body.parts {
                let range = self.first[b] + part.spheres.start..self.first[b] + part.spheres.end;
                let lead = add(centre, self.arm[range.start]);
                // In the periodic image that takes the first sphere into the cell.
                let shift = sub(self.spheres.cell.wrap(lead), lead);
                let sphere = |s: usize| Sphere {
                    center_um: add(add(centre, self.arm[s]), shift),
                    radius_um: self.radius(s),
                };
                let spheres: Vec<Sphere> = range.clone().map(sphere).collect();
                let solid = self.solid(range.start).map(|solid| solid.placed(spheres[0].center_um));
                let turned = solid.is_some() || spheres.len() > 1;
                grains.push(Grain {
                    axis: if turned { rotation.turn(part.axis) } else { part.axis },
                    spheres,
                    solid,
                    pigment: body.pigment,
                    agglomerate,
                    optic_axis: None,
                    volume_um3: part.volume_um3,
                });
            }
        }
        grains
    }
}

/// Hard bodies, which come and move one at a time.
impl Arrangement<'_> {
    /// Places the next body of the plan, unless it overlaps a wall or another body; returns whether
    /// it did. The depth of a body with a profile is a quantile of it, over the thickness.
    pub fn add_if_free(&mut self, pose: Pose) -> bool {
        let b = self.placed;
        let mut grid = self.take_grid();
        self.set_pose(b, pose);
        self.follow_profile(b, pose.centre);
        let free = self.is_free(b, &grid);
        if free {
            self.spheres_of(b).for_each(|s| grid.insert(s, self.spheres.centre[s]));
            self.placed += 1;
        }
        self.grid = Some(grid);
        free
    }

    /// Moves a placed body, unless it then overlaps a wall or another body; returns whether it did.
    pub fn move_if_free(&mut self, b: usize, pose: Pose) -> bool {
        let before = self.poses[b];
        let mut grid = self.take_grid();
        self.set_pose(b, pose);
        let free = self.is_free(b, &grid);
        match free {
            true => self.spheres_of(b).for_each(|s| grid.follow(s, self.spheres.centre[s])),
            false => self.set_pose(b, before),
        }
        self.grid = Some(grid);
        free
    }

    /// The spheres of the placed bodies on a grid as wide as the largest.
    fn take_grid(&mut self) -> CellGrid {
        self.grid.take().unwrap_or_else(|| {
            let radii = &self.spheres.radius;
            let widest = radii.iter().copied().fold(0.0, f64::max);
            let mut grid = CellGrid::new(&self.spheres.cell, 2.0 * widest * (1.0 + 1e-6), radii.len());
            (0..self.first[self.placed]).for_each(|s| grid.insert(s, self.spheres.centre[s]));
            grid
        })
    }

    /// Whether body b overlaps neither a wall nor another body in the grid.
    fn is_free(&self, b: usize, grid: &CellGrid) -> bool {
        let height = self.spheres.cell.size[2];
        let [low, high] = self.span_z(b).map(|z| self.poses[b].centre[2] + z);
        let between = low >= MARGIN * height && high <= height - MARGIN * height;
        (between || !self.spheres.cell.walls) && self.spheres_of(b).all(|s| self.is_free_sphere(s, grid))
    }

    /// Whether sphere s overlaps no sphere of another body in the grid.
    #[inline]
    fn is_free_sphere(&self, s: usize, grid: &CellGrid) -> bool {
        let owner = self.spheres.owner[s];
        let r = self.spheres.radius[s];
        grid.around(grid.cell_of(self.spheres.centre[s])).all(|t| {
            let d = self.delta(s, t);
            let reach = (r + self.spheres.radius[t]) * (1.0 + MARGIN);
            dot(d, d) >= reach * reach || self.spheres.owner[t] == owner || self.are_apart(s, t, d)
        })
    }

    /// Whether two bodies of which one is convex are apart although the spheres around them
    /// overlap.
    fn are_apart(&self, s: usize, t: usize, d: V3) -> bool {
        let margin = CONVEX_MARGIN * (self.thin_um(s) + self.thin_um(t));
        !self.are_spheres(s, t) && self.contact(s, t, d, margin).is_none_or(|c| c.gap_um > margin)
    }
}

/// Bodies that may overlap, with lists of their neighbours.
impl Arrangement<'_> {
    /// Counts the first bodies of the plan as placed; each has its place already.
    pub fn set_placed(&mut self, placed: usize) {
        self.grid = None;
        self.placed = placed;
    }

    /// Puts body b into a place, whatever is there.
    pub fn put(&mut self, b: usize, pose: Pose) {
        self.grid = None;
        self.set_pose(b, pose);
    }

    /// Moves body b to another centre, whatever is there.
    pub fn shift(&mut self, b: usize, centre: V3) {
        self.grid = None;
        self.set_centre(b, centre);
    }

    /// Puts body b at `place`, with z rescaled to the range accessible to the rotated body between
    /// the walls, or to its profile there, whatever is there.
    pub fn scatter(&mut self, b: usize, place: V3, rotation: Rotation) {
        self.put(b, Pose { centre: place, rotation });
        if self.follow_profile(b, place) {
            return;
        }
        if self.spheres.cell.walls {
            let height = self.spheres.cell.size[2];
            let [low, high] = self.span_z(b);
            let room = height - (high - low);
            // A grain too long for the layer in its orientation starts in the middle; the walls
            // will rotate it.
            let z = if room > 0.0 { place[2] / height * room - low } else { 0.5 * (height - high - low) };
            self.shift(b, [place[0], place[1], z]);
        }
    }

    /// Builds the lists of neighbours of all placed bodies' spheres.
    pub fn list_neighbours(&mut self, inflation: f64) {
        self.lists.build(&self.spheres, self.first[self.placed], inflation);
    }

    /// As [`Self::list_neighbours`], with the skin adapted to the steps since the last time.
    pub fn list_neighbours_after(&mut self, steps: u64, inflation: f64) {
        self.lists.adapt_skin(steps);
        self.list_neighbours(inflation);
    }

    /// Spheres of other bodies near sphere s when the lists were built.
    #[inline(always)]
    pub fn neighbours(&self, s: usize) -> &[u32] {
        self.lists.of_sphere(s)
    }

    /// Whether body b has moved so far that the lists may lack neighbours of it.
    pub fn has_outrun_lists(&self, b: usize) -> bool {
        self.spheres_of(b).any(|s| self.lists.is_outrun(&self.spheres, s))
    }

    /// Overlap energy of each placed body.
    pub fn strain(&self) -> Vec<f64> {
        let in_place = self.first[self.placed];
        let contacts = NeighbourLists::of_contacts(&self.spheres, in_place);
        let mut strain = vec![0.0; self.placed];
        for s in 0..in_place {
            let mut add_overlap = |depth: f64| strain[self.body_of(s)] += depth.max(0.0).powi(2);
            if self.spheres.cell.walls {
                let [low, high] = self.extent_z(s);
                let z = self.spheres.centre[s][2];
                add_overlap(-2.0 * (z + low).min(self.spheres.cell.size[2] - z - high));
            }
            for &t in contacts.of_sphere(s) {
                let t = t as usize;
                let contact = self.contact(s, t, self.delta(s, t), 0.0);
                add_overlap(contact.map_or(0.0, |c| -c.gap_um));
            }
        }
        strain
    }

    /// Places body b and updates its spheres.
    fn set_pose(&mut self, b: usize, pose: Pose) {
        let rotation = pose.rotation;
        self.poses[b].rotation = rotation;
        let body = &self.plan.bodies[b];
        let range = self.spheres_of(b);
        for (arm, sphere) in self.arm[range.clone()].iter_mut().zip(&body.spheres) {
            *arm = rotation.turn(sphere.center_um);
        }
        for (solid, part) in self.solid[range].iter_mut().flatten().zip(&body.solids) {
            // A lone body has the rotation to its last bit, which a product would round.
            let lone = part.rotation == Rotation::IDENTITY;
            solid.rotation = if lone { rotation } else { part.rotation.then(rotation) };
        }
        self.set_centre(b, pose.centre);
    }

    /// Moves a body with a profile to the depth whose share of the grains above is that of z over
    /// the thickness; walls cut the profile off where they cut off an even layer. Returns whether
    /// it has a profile.
    fn follow_profile(&mut self, b: usize, place: V3) -> bool {
        let Some(law) = self.plan.profile_of(b) else { return false };
        let height = self.spheres.cell.size[2];
        let [low, high] = if self.spheres.cell.walls { self.span_z(b) } else { [0.0; 2] };
        let from = -low / height;
        let to = 1.0 - high / height;
        let margin = 2.0 * MARGIN;
        // A body too long for the layer in its orientation starts in the middle.
        let within =
            if to - from > 2.0 * margin { [from + margin, to - margin] } else { [0.5 * (from + to); 2] };
        let depth = law.quantile_within(within, place[2] / height);
        self.set_centre(b, [place[0], place[1], height * depth]);
        true
    }

    /// Translates body b.
    fn set_centre(&mut self, b: usize, centre: V3) {
        let centre = self.spheres.cell.wrap(centre);
        self.poses[b].centre = centre;
        for s in self.spheres_of(b) {
            self.spheres.centre[s] = self.spheres.cell.wrap(add(centre, self.arm[s]));
        }
    }
}
