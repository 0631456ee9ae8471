//! Check that bodies do not overlap: their contrasts would be counted twice.
//!
//! Bodies of every kind are inserted one by one into a grid of cells whose volume is a body's share
//! of the layer, and compared with those already in the same cells. Bodies that do not overlap
//! cannot crowd a cell, so the work is proportional to their number. Nothing here is shared with
//! the packing methods but the proof that two convex bodies are apart.

use super::{Ball, Body, BodyShape, Scene, WaveError};
use crate::ink;
use crate::ink::Solid;
use crate::ink::grains::contact::{excess_um, proven_gap_um};
use crate::numerics::Rotation;
use crate::numerics::vector::sub;
use std::collections::HashMap;

/// Tolerance for touching bodies due to the rounding of their coordinates, in periods along x.
const ROUNDING: f64 = 1e-9;

impl Scene {
    /// Rejects bodies that overlap each other or their own periodic images. Exempt are bodies
    /// around each other ([`Body::within`]), and the space beyond a relief, which is cut around the
    /// grains.
    ///
    /// # Errors
    /// [`WaveError::Overlap`] and [`WaveError::OverlapsImage`], for the first pair found.
    pub fn check_overlaps(&self) -> Result<(), WaveError> {
        let hosts = self.hosts()?;
        let stray = (0..hosts.len()).find_map(|second| {
            let first = hosts[second].filter(|_| self.bodies[second].within != hosts[second])?;
            Some((first, second))
        });
        let Some((first, second)) = stray else { return Ok(()) };
        let [lo, hi] = self.bodies[second].extent_um();
        Err(WaveError::Overlap { first, second, overlap_um: hi - lo })
    }

    /// The scene with every sphere or convex body that lies wholly inside another one as a body
    /// within it.
    ///
    /// # Errors
    /// As [`Scene::check_overlaps`], for pairs of which neither lies inside the other.
    pub fn nested(mut self) -> Result<Scene, WaveError> {
        let hosts = self.hosts()?;
        self.bodies.iter_mut().zip(hosts).for_each(|(body, host)| body.within = host);
        Ok(self)
    }

    /// The smallest body around every body, or the one given as around it.
    fn hosts(&self) -> Result<Vec<Option<usize>>, WaveError> {
        let slack = ROUNDING * self.period_um[0];
        let images = self.bodies.iter().map(|body| image_overlap_um(body, self.period_um)).enumerate();
        if let Some((body, overlap_um)) = images.into_iter().find(|&(_, overlap)| overlap > slack) {
            return Err(WaveError::OverlapsImage { body, overlap_um });
        }
        let pieces: Vec<Piece> = self.bodies.iter().enumerate().flat_map(pieces_of).collect();
        let mut cells = Cells::new(self, &pieces);
        pieces.iter().try_for_each(|piece| cells.enter(piece, slack))?;
        let around = |body: usize| cells.around.get(&body).map(|(host, _)| *host);
        Ok((0..self.bodies.len()).map(|body| self.bodies[body].within.or(around(body))).collect())
    }

    /// Whether one of two bodies is given as around the other, directly or not.
    fn is_around(&self, one: usize, other: usize) -> bool {
        let up = |body: usize| std::iter::successors(Some(body), |&b| self.bodies[b].within);
        up(one).any(|b| b == other) || up(other).any(|b| b == one)
    }
}

/// A convex part of a body.
#[derive(Clone, Copy)]
struct Piece<'a> {
    body: usize,
    /// Whether it is the whole body.
    whole: bool,
    form: PieceForm<'a>,
}

impl Piece<'_> {
    /// Whether another sphere or convex body lies inside this one, which is larger.
    fn surrounds(&self, other: &Piece, period: [f64; 2], slack: f64) -> bool {
        if let (PieceForm::Ball(a), PieceForm::Ball(b)) = (self.form, other.form) {
            let apart = a.radius_um + b.radius_um - ball_overlap_um(&a, &b, period);
            let larger = a.radius_um > b.radius_um + slack;
            return self.whole && other.whole && larger && apart + b.radius_um <= a.radius_um + slack;
        }
        let convex = |piece: &Piece| piece.form.convex().filter(|_| piece.whole);
        let (Some(a), Some(b)) = (convex(self), convex(other)) else { return false };
        let larger = a.form.volume_um3() > b.form.volume_um3() * (1.0 + ROUNDING);
        larger && excess_um(&b, &a, apart(&a, &b, period)) <= slack
    }
}

#[derive(Clone, Copy)]
enum PieceForm<'a> {
    Ball(Ball),
    Solid(&'a Solid),
    /// A cylinder along y: a disc in the plane of x and z.
    Disc {
        x: f64,
        z: f64,
        radius: f64,
    },
    Bar {
        x: [f64; 2],
        z: [f64; 2],
    },
    Sheet {
        z: [f64; 2],
    },
}

fn pieces_of((body, of): (usize, &Body)) -> Vec<Piece<'_>> {
    let whole = !matches!(&of.shape, BodyShape::Balls(balls) if balls.len() > 1);
    let piece = |form| Piece { body, whole, form };
    match &of.shape {
        BodyShape::Balls(balls) => balls.iter().map(|&ball| piece(PieceForm::Ball(ball))).collect(),
        BodyShape::Solid(solid) => vec![piece(PieceForm::Solid(solid))],
        BodyShape::CylinderY { x_um, z_um, radius_um } => {
            vec![piece(PieceForm::Disc { x: *x_um, z: *z_um, radius: *radius_um })]
        }
        BodyShape::BarY { x_um, z_um } => vec![piece(PieceForm::Bar { x: *x_um, z: *z_um })],
        BodyShape::Sheet { z_um } => vec![piece(PieceForm::Sheet { z: *z_um })],
        BodyShape::Open { .. } => Vec::new(),
    }
}

impl PieceForm<'_> {
    /// Smallest and largest x, y and z; the whole period along uniform axes.
    fn extent(&self, [lx, ly]: [f64; 2]) -> [[f64; 2]; 3] {
        match *self {
            PieceForm::Ball(Ball { center_um, radius_um }) => {
                center_um.map(|c| [c - radius_um, c + radius_um])
            }
            PieceForm::Solid(solid) => [0, 1, 2].map(|axis| solid.extent_um(axis)),
            PieceForm::Disc { x, z, radius } => {
                [[x - radius, x + radius], [0.0, ly], [z - radius, z + radius]]
            }
            PieceForm::Bar { x, z } => [x, [0.0, ly], z],
            PieceForm::Sheet { z } => [[0.0, lx], [0.0, ly], z],
        }
    }

    /// Centre and radius in the x–z plane of forms that are round there.
    fn disc(&self) -> Option<(f64, f64, f64)> {
        match *self {
            PieceForm::Ball(Ball { center_um: [x, _, z], radius_um }) => Some((x, z, radius_um)),
            PieceForm::Disc { x, z, radius } => Some((x, z, radius)),
            PieceForm::Solid(_) | PieceForm::Bar { .. } | PieceForm::Sheet { .. } => None,
        }
    }

    /// A sphere or convex body as the latter.
    fn convex(&self) -> Option<Solid> {
        match *self {
            PieceForm::Solid(solid) => Some(solid.clone()),
            PieceForm::Ball(Ball { center_um, radius_um }) => {
                Some(Solid::upright(ink::Form::Ellipsoid { semi_axes_um: [radius_um; 3] }, center_um))
            }
            _ => None,
        }
    }

    /// The form as a convex body; bodies along y are cut three periods long about the height `y`.
    fn solid(&self, [_, ly]: [f64; 2], y: f64) -> Option<Solid> {
        Some(match *self {
            PieceForm::Solid(_) | PieceForm::Ball(_) => return self.convex(),
            PieceForm::Disc { x, z, radius } => Solid {
                form: ink::Form::Disc { radius_um: radius, half_length_um: 1.5 * ly },
                center_um: [x, y, z],
                rotation: Rotation::from_z_to([0.0, 1.0, 0.0]),
            },
            PieceForm::Bar { x, z } => {
                Solid::upright(ink::Form::cuboid([width(x), 3.0 * ly, width(z)]), [middle(x), y, middle(z)])
            }
            PieceForm::Sheet { .. } => return None,
        })
    }

    /// Depth by which two forms overlap in their nearest images, µm; negative if they are apart.
    fn overlap_um(&self, other: &PieceForm, period: [f64; 2]) -> f64 {
        match (*self, *other) {
            (PieceForm::Solid(solid), any) | (any, PieceForm::Solid(solid)) => {
                match any.solid(period, solid.center_um[1]) {
                    Some(other) => solid_overlap_um(solid, &other, period, true),
                    None => common(any.extent(period)[2], solid.extent_um(2)),
                }
            }
            (PieceForm::Ball(a), PieceForm::Ball(b)) => ball_overlap_um(&a, &b, period),
            (PieceForm::Bar { x: x1, z: z1 }, PieceForm::Bar { x: x2, z: z2 }) => {
                let apart = nearest(middle(x1) - middle(x2), period[0]).abs();
                (0.5 * (width(x1) + width(x2)) - apart).min(common(z1, z2))
            }
            (PieceForm::Bar { x, z }, round) | (round, PieceForm::Bar { x, z }) if round.disc().is_some() => {
                let (cx, cz, radius) = round.disc().unwrap_or_default();
                let dx = nearest(cx - middle(x), period[0]).abs() - 0.5 * width(x);
                let dz = (cz - middle(z)).abs() - 0.5 * width(z);
                let inside = dx.max(dz).min(0.0);
                radius - dx.max(0.0).hypot(dz.max(0.0)) - inside
            }
            (a, b) => match (a.disc(), b.disc()) {
                (Some((x1, z1, r1)), Some((x2, z2, r2))) => {
                    r1 + r2 - nearest(x1 - x2, period[0]).hypot(z1 - z2)
                }
                _ => common(a.extent(period)[2], b.extent(period)[2]),
            },
        }
    }
}

/// Pieces by the cells they reach.
struct Cells<'a> {
    scene: &'a Scene,
    period: [f64; 2],
    /// The smallest body found around another, with its volume.
    around: HashMap<usize, (usize, f64)>,
    /// Number of cells along x, y and z, and the lengths they divide.
    count: [i64; 3],
    length: [f64; 3],
    held: HashMap<[i64; 3], Vec<&'a Piece<'a>>>,
}

impl<'a> Cells<'a> {
    fn new(scene: &'a Scene, pieces: &[Piece]) -> Cells<'a> {
        let [lx, ly] = scene.period_um;
        let length = [lx, ly, scene.thickness_um()];
        let number = pieces.len().max(1) as f64;
        let flat = !pieces.iter().any(|p| matches!(p.form, PieceForm::Ball(_) | PieceForm::Solid(_)));
        let side = if flat {
            (length[0] * length[2] / number).sqrt()
        } else {
            (length.iter().product::<f64>() / number).cbrt()
        };
        let cells = |l: f64| ((l / side) as i64).clamp(1, pieces.len().max(1) as i64);
        let count = [cells(lx), if flat { 1 } else { cells(ly) }, cells(length[2])];
        let (around, held) = (HashMap::new(), HashMap::new());
        Cells { scene, period: scene.period_um, around, count, length, held }
    }

    /// Compares a piece with those of other bodies in its cells, and inserts it.
    fn enter(&mut self, piece: &'a Piece<'a>, slack: f64) -> Result<(), WaveError> {
        for cell in self.cells_of(piece) {
            let mut held = self.held.remove(&cell).unwrap_or_default();
            for other in held.iter().filter(|other| other.body != piece.body) {
                let overlap_um = other.form.overlap_um(&piece.form, self.period);
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
        let surrounds = |a: &Piece, b: &Piece| a.surrounds(b, self.period, slack);
        let (host, inner) = match (surrounds(one, other), surrounds(other, one)) {
            (true, _) => (one, other),
            (_, true) => (other, one),
            _ => return false,
        };
        let Some(solid) = host.form.convex() else { return false };
        let volume = solid.form.volume_um3();
        let smallest = self.around.entry(inner.body).or_insert((host.body, volume));
        if volume < smallest.1 {
            *smallest = (host.body, volume);
        }
        true
    }

    fn cells_of(&self, piece: &Piece) -> Vec<[i64; 3]> {
        let extent = piece.form.extent(self.period);
        let [x, y, z] = [0, 1, 2].map(|axis| self.reach(axis, extent[axis]));
        let of_plane = |&cz: &i64| {
            let rows = y.iter().flat_map(|&cy| x.iter().map(move |&cx| [cx, cy]));
            rows.map(move |[cx, cy]| [cx, cy, cz]).collect::<Vec<_>>()
        };
        z.iter().flat_map(of_plane).collect()
    }

    /// Cells along one axis that an interval intersects: periodic along x and y, from wall to wall
    /// along z.
    fn reach(&self, axis: usize, [low, high]: [f64; 2]) -> Vec<i64> {
        let count = self.count[axis];
        let place = |x: f64| (x / self.length[axis] * count as f64).floor() as i64;
        let (first, last) = (place(low), place(high));
        if axis == 2 {
            return (first.clamp(0, count - 1)..=last.clamp(0, count - 1)).collect();
        }
        (first..=last.min(first + count - 1)).map(|cell| cell.rem_euclid(count)).collect()
    }
}

fn ball_overlap_um(a: &Ball, b: &Ball, [lx, ly]: [f64; 2]) -> f64 {
    let [x, y, z]: [f64; 3] = std::array::from_fn(|i| a.center_um[i] - b.center_um[i]);
    a.radius_um + b.radius_um - nearest(x, lx).hypot(nearest(y, ly)).hypot(z)
}

/// Centre of the nearest image of the second body relative to the first one's, µm.
fn apart(a: &Solid, b: &Solid, [lx, ly]: [f64; 2]) -> [f64; 3] {
    let [x, y, z] = sub(b.center_um, a.center_um);
    [nearest(x, lx), nearest(y, ly), z]
}

/// Depth by which two convex bodies overlap in any of their images, without that in place if not
/// wanted; negative if they are apart.
fn solid_overlap_um(a: &Solid, b: &Solid, [lx, ly]: [f64; 2], in_place: bool) -> f64 {
    let near = apart(a, b, [lx, ly]);
    let shifts = (-1..=1).flat_map(|i| (-1..=1).map(move |j| [f64::from(i) * lx, f64::from(j) * ly]));
    let wanted = shifts.filter(|shift| in_place || *shift != [0.0; 2]);
    let depth = |[x, y]: [f64; 2]| -proven_gap_um(a, b, [near[0] + x, near[1] + y, near[2]]);
    wanted.map(depth).fold(f64::NEG_INFINITY, f64::max)
}

/// Depth by which a body overlaps its own images: its parts may overlap each other, but not their
/// copies.
fn image_overlap_um(body: &Body, [lx, ly]: [f64; 2]) -> f64 {
    match &body.shape {
        BodyShape::Balls(balls) => {
            let shifts = [[lx, 0.0], [0.0, ly], [lx, ly], [-lx, ly]];
            let shifts = shifts.into_iter().flat_map(|[x, y]| [[x, y], [-x, -y]]);
            let overlap = |a: &Ball, b: &Ball, [x, y]: [f64; 2]| {
                let [dx, dy, dz]: [f64; 3] = std::array::from_fn(|i| a.center_um[i] - b.center_um[i]);
                a.radius_um + b.radius_um - (dx + x).hypot(dy + y).hypot(dz)
            };
            let pairs = balls.iter().flat_map(|a| balls.iter().map(move |b| (a, b)));
            let deepest = pairs.flat_map(|(a, b)| shifts.clone().map(move |shift| overlap(a, b, shift)));
            deepest.fold(f64::NEG_INFINITY, f64::max)
        }
        BodyShape::Solid(solid) => solid_overlap_um(solid, solid, [lx, ly], false),
        BodyShape::CylinderY { radius_um, .. } => 2.0 * radius_um - lx,
        BodyShape::BarY { x_um, .. } => width(*x_um) - lx,
        BodyShape::Sheet { .. } | BodyShape::Open { .. } => f64::NEG_INFINITY,
    }
}

fn middle([low, high]: [f64; 2]) -> f64 {
    0.5 * (low + high)
}

fn width([low, high]: [f64; 2]) -> f64 {
    high - low
}

/// Length of the intersection of two intervals.
fn common(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[1].min(b[1]) - a[0].max(b[0])
}

/// Signed distance to the nearest periodic image.
fn nearest(delta: f64, period: f64) -> f64 {
    delta - period * (delta / period).round()
}

#[cfg(test)]
#[path = "overlap_tests.rs"]
mod tests;
