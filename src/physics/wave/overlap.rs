//! Check that bodies do not overlap: their contrasts would be counted twice.
//!
//! Bodies of every kind are inserted one by one into a grid of cells whose volume is a body's share
//! of the layer, and compared with those already in the same cells. Bodies that do not overlap
//! cannot crowd a cell, so the work is proportional to their number. Nothing here is shared with
//! the packing methods but the proof that two convex bodies are apart.

use super::{Body, BodyShape, Scene, WaveError};
use crate::ink::Sphere;
use crate::ink::grains::contact::{excess_um, proven_gap_um};
use crate::ink::{Form, Solid};
use crate::numerics::vector::Rotation;
use crate::numerics::vector::sub;
use std::collections::HashMap;

/// Tolerance for touching bodies due to the rounding of their coordinates, in periods along x.
const ROUNDING: f64 = 1e-9;
/// Range along an axis on which a body does not depend.
const ENDLESS: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];

impl Scene {
    /// The scene with every sphere or convex body that lies wholly inside another one as a body
    /// within it. Rejects bodies that otherwise overlap each other or their own periodic images;
    /// the space beyond a relief is exempt, which is cut around the grains.
    ///
    /// # Errors
    /// [`WaveError::Overlap`] and [`WaveError::OverlapsImage`], for the first pair found.
    pub fn nested(mut self) -> Result<Scene, WaveError> {
        let hosts = self.hosts()?;
        self.bodies.iter_mut().zip(hosts).for_each(|(body, host)| body.within = host);
        Ok(self)
    }

    /// The smallest body around every body, or the one given as around it.
    fn hosts(&self) -> Result<Vec<Option<usize>>, WaveError> {
        let [lx, ly] = self.period_um;
        let slack = ROUNDING * lx;
        let images = self.bodies.iter().map(|body| image_overlap_um(body, [lx, ly])).enumerate();
        if let Some((body, overlap_um)) = images.into_iter().find(|&(_, overlap)| overlap > slack) {
            return Err(WaveError::OverlapsImage { body, overlap_um });
        }
        let pieces: Vec<_> =
            self.bodies.iter().enumerate().flat_map(|(index, body)| pieces_of(index, body, ly)).collect();
        let mut cells = Cells::new(self, &pieces);
        pieces.iter().try_for_each(|piece| cells.enter(piece, slack))?;
        let within = self.bodies.iter().map(|body| body.within).enumerate();
        Ok(within.map(|(body, given)| given.or_else(|| Some(cells.around.get(&body)?.0))).collect())
    }

    /// Whether one of two bodies is given as around the other, directly or not.
    fn is_around(&self, one: usize, other: usize) -> bool {
        let up = |body: usize| std::iter::successors(Some(body), |&b| self.bodies[b].within);
        up(one).any(|b| b == other) || up(other).any(|b| b == one)
    }
}

/// A convex part of a body: a box rounded by a radius, or a convex body in such a box.
struct Piece {
    body: usize,
    /// Ranges of the box along x, y and z, µm: a point of a ball, a line of a cylinder.
    ranges: [[f64; 2]; 3],
    /// Radius of its rounding, µm.
    radius: f64,
    /// The piece as a convex body, if it is finite in the plane; cylinders and bars are cut three
    /// periods long.
    solid: Option<Solid>,
    /// Whether it is a whole body that may lie in others: a sphere or a convex body.
    whole: bool,
}

fn pieces_of(index: usize, body: &Body, ly: f64) -> Vec<Piece> {
    let piece = |ranges, radius, solid, whole| vec![Piece { body: index, ranges, radius, solid, whole }];
    match &body.shape {
        BodyShape::Balls(balls) => {
            let whole = balls.len() == 1;
            let ball = |b: &Sphere| piece(b.center_um.map(|c| [c; 2]), b.radius_um, Some(b.solid()), whole);
            balls.iter().flat_map(ball).collect()
        }
        BodyShape::Solid(solid) => {
            piece([0, 1, 2].map(|axis| solid.extent_um(axis)), 0.0, Some(solid.clone()), true)
        }
        &BodyShape::CylinderY { x_um, z_um, radius_um } => {
            let form = Form::Disc { radius_um, half_length_um: 1.5 * ly };
            let rotation = Rotation::from_z_to([0.0, 1.0, 0.0]);
            let rod = Solid { form, center_um: [x_um, 0.0, z_um], rotation };
            piece([[x_um; 2], ENDLESS, [z_um; 2]], radius_um, Some(rod), false)
        }
        &BodyShape::BarY { x_um, z_um } => {
            let form = Form::cuboid([width(x_um), 3.0 * ly, width(z_um)]);
            let bar = Solid::upright(form, [middle(x_um), 0.0, middle(z_um)]);
            piece([x_um, ENDLESS, z_um], 0.0, Some(bar), false)
        }
        BodyShape::Sheet { z_um } => piece([ENDLESS, ENDLESS, *z_um], 0.0, None, false),
        BodyShape::Open { .. } => Vec::new(),
    }
}

impl Piece {
    /// From the middle of another piece to that of the nearest image of this one, µm; 0 along an
    /// axis on which one of them does not depend.
    fn centre_from(&self, other: &Piece, [lx, ly]: [f64; 2]) -> [f64; 3] {
        [(0, lx), (1, ly), (2, f64::INFINITY)].map(|(axis, period)| {
            let range = self.ranges[axis];
            let other_range = other.ranges[axis];
            let apart = middle(range) - middle(other_range);
            if range == ENDLESS || other_range == ENDLESS { 0.0 } else { nearest(apart, period) }
        })
    }

    /// Whether another sphere or convex body lies inside this one, which is larger.
    fn surrounds(&self, other: &Piece, period: [f64; 2], slack: f64) -> bool {
        let apart = other.centre_from(self, period);
        if !(self.whole && other.whole) {
            return false;
        }
        if self.radius > 0.0 && other.radius > 0.0 {
            return self.radius > other.radius + slack && length(apart) + other.radius <= self.radius + slack;
        }
        let (Some(a), Some(b)) = (&self.solid, &other.solid) else { return false };
        a.form.volume_um3() > b.form.volume_um3() * (1.0 + ROUNDING) && excess_um(b, a, apart) <= slack
    }

    /// Depth by which two pieces overlap in their nearest images, µm; negative if they are apart.
    fn overlap_um(&self, other: &Piece, period: [f64; 2]) -> f64 {
        let apart = other.centre_from(self, period);
        if let (Some(a), Some(b)) = (&self.solid, &other.solid)
            && [self, other].iter().any(|piece| piece.whole && piece.radius == 0.0)
        {
            let depth = |[x, y]: [f64; 2]| -proven_gap_um(a, b, [apart[0] + x, apart[1] + y, apart[2]]);
            return shifts(period).map(depth).fold(f64::NEG_INFINITY, f64::max);
        }
        let widths = [0, 1, 2].map(|axis| width(self.ranges[axis]) + width(other.ranges[axis]));
        let gaps = [0, 1, 2].map(|axis| apart[axis].abs() - 0.5 * widths[axis]);
        let inside = gaps.into_iter().fold(f64::NEG_INFINITY, f64::max).min(0.0);
        self.radius + other.radius - length(gaps.map(|gap| gap.max(0.0))) - inside
    }
}

/// Pieces by the cells they reach.
struct Cells<'a> {
    scene: &'a Scene,
    /// The smallest body found around another, with its volume.
    around: HashMap<usize, (usize, f64)>,
    /// Number of cells along x, y and z, and the lengths they divide.
    count: [i64; 3],
    length: [f64; 3],
    held: HashMap<[i64; 3], Vec<&'a Piece>>,
}

impl<'a> Cells<'a> {
    fn new(scene: &'a Scene, pieces: &[Piece]) -> Cells<'a> {
        let [lx, ly] = scene.period_um;
        let length = [lx, ly, scene.thickness_um()];
        let number = pieces.len().max(1) as f64;
        let flat = pieces.iter().all(|piece| piece.ranges[1] == ENDLESS);
        let side = match flat {
            true => (length[0] * length[2] / number).sqrt(),
            false => (length.iter().product::<f64>() / number).cbrt(),
        };
        let cells = |l: f64| ((l / side) as i64).clamp(1, pieces.len().max(1) as i64);
        let count = [cells(lx), if flat { 1 } else { cells(ly) }, cells(length[2])];
        Cells { scene, around: HashMap::new(), count, length, held: HashMap::new() }
    }

    /// Compares a piece with those of other bodies in its cells, and inserts it.
    fn enter(&mut self, piece: &'a Piece, slack: f64) -> Result<(), WaveError> {
        for cell in self.cells_of(piece) {
            let mut held = self.held.remove(&cell).unwrap_or_default();
            for other in held.iter().filter(|other| other.body != piece.body) {
                let overlap_um = other.overlap_um(piece, self.scene.period_um);
                if overlap_um > slack && !self.is_nested(other, piece, slack) {
                    return Err(WaveError::Overlap { first: other.body, second: piece.body, overlap_um });
                }
            }
            held.push(piece);
            self.held.insert(cell, held);
        }
        Ok(())
    }

    /// Whether one piece is around the other, which is noted.
    fn is_nested(&mut self, one: &Piece, other: &Piece, slack: f64) -> bool {
        if self.scene.is_around(one.body, other.body) {
            return true;
        }
        let surrounds = |a: &Piece, b: &Piece| a.surrounds(b, self.scene.period_um, slack);
        let (host, inner) = match (surrounds(one, other), surrounds(other, one)) {
            (true, _) => (one, other),
            (_, true) => (other, one),
            _ => return false,
        };
        let volume = host.solid.as_ref().map_or(f64::INFINITY, |solid| solid.form.volume_um3());
        let smallest = self.around.entry(inner.body).or_insert((host.body, volume));
        if volume < smallest.1 {
            *smallest = (host.body, volume);
        }
        true
    }

    fn cells_of(&self, piece: &Piece) -> Vec<[i64; 3]> {
        let [x, y, z] = [0, 1, 2].map(|axis| self.reach(axis, piece));
        let columns: Vec<[i64; 2]> = y.iter().flat_map(|&cy| x.iter().map(move |&cx| [cx, cy])).collect();
        z.iter().flat_map(|&cz| columns.iter().map(move |&[cx, cy]| [cx, cy, cz])).collect()
    }

    /// Cells along one axis that a piece reaches: periodic along x and y, from wall to wall along
    /// z.
    fn reach(&self, axis: usize, piece: &Piece) -> Vec<i64> {
        let count = self.count[axis];
        let [low, high] = piece.ranges[axis];
        if piece.ranges[axis] == ENDLESS {
            return (0..count).collect();
        }
        let place = |x: f64| (x / self.length[axis] * count as f64).floor() as i64;
        let (first, last) = (place(low - piece.radius), place(high + piece.radius));
        if axis == 2 {
            return (first.clamp(0, count - 1)..=last.clamp(0, count - 1)).collect();
        }
        (first..=last.min(first + count - 1)).map(|cell| cell.rem_euclid(count)).collect()
    }
}

/// Depth by which a body overlaps its own images: its parts may overlap each other, but not their
/// copies.
fn image_overlap_um(body: &Body, period: [f64; 2]) -> f64 {
    let shifts = || shifts(period).filter(|shift| *shift != [0.0; 2]).map(|[x, y]| [x, y, 0.0]);
    match &body.shape {
        BodyShape::Balls(balls) => {
            let pairs = balls.iter().flat_map(|a| balls.iter().map(move |b| (a, b)));
            let overlaps = pairs.flat_map(|(a, b)| {
                let reach = a.radius_um + b.radius_um;
                let from = sub(b.center_um, a.center_um);
                shifts().map(move |shift| reach - length(sub(shift, from)))
            });
            overlaps.fold(f64::NEG_INFINITY, f64::max)
        }
        BodyShape::Solid(solid) => {
            shifts().map(|shift| -proven_gap_um(solid, solid, shift)).fold(f64::NEG_INFINITY, f64::max)
        }
        BodyShape::CylinderY { radius_um, .. } => 2.0 * radius_um - period[0],
        BodyShape::BarY { x_um, .. } => width(*x_um) - period[0],
        BodyShape::Sheet { .. } | BodyShape::Open { .. } => f64::NEG_INFINITY,
    }
}

/// From a cell to itself and to its neighbours, µm.
fn shifts([lx, ly]: [f64; 2]) -> impl Iterator<Item = [f64; 2]> {
    (-1..=1).flat_map(move |i| (-1..=1).map(move |j| [f64::from(i) * lx, f64::from(j) * ly]))
}

fn middle([low, high]: [f64; 2]) -> f64 {
    0.5 * (low + high)
}

fn width([low, high]: [f64; 2]) -> f64 {
    high - low
}

/// Length of a vector, of any size.
fn length([x, y, z]: [f64; 3]) -> f64 {
    x.hypot(y).hypot(z)
}

/// Signed distance to the nearest periodic image.
fn nearest(delta: f64, period: f64) -> f64 {
    if period.is_finite() { delta - period * (delta / period).round() } else { delta }
}

#[cfg(test)]
#[path = "overlap_tests.rs"]
mod tests;
