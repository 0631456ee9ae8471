//! Convex bodies with exact surfaces: ellipsoids, discs and rods with flat ends, prisms and boxes.

use crate::numerics::vector::{Rotation, V3, add, cross, dot, norm, scale, sub, unit};
use std::f64::consts::PI;

/// A convex form about its centre, in its own frame; lengths in µm.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Form {
    /// Ellipsoid with these semi-axes along x, y and z.
    Ellipsoid {
        /// Semi-axes, µm.
        semi_axes_um: V3,
    },
    /// Circular disc or rod with flat ends; its axis is z.
    Disc {
        /// Radius, µm.
        radius_um: f64,
        /// Half of the distance between the ends, µm.
        half_length_um: f64,
    },
    /// Prism over a convex polygon in the plane of x and y; its axis is z. A box has four corners.
    Prism {
        /// Corners of the polygon, counterclockwise, µm.
        corners_um: Vec<[f64; 2]>,
        /// Half of the distance between the ends, µm.
        half_length_um: f64,
    },
}

/// A form in its place.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Solid {
    /// Shape and size.
    pub form: Form,
    /// Centre (x, y, z), µm.
    pub center_um: V3,
    /// Rotation from the form's frame.
    pub rotation: Rotation,
}

impl Form {
    /// A box with these edges along x, y and z, µm.
    pub fn cuboid(edges_um: V3) -> Form {
        let [a, b, c] = scale(edges_um, 0.5);
        Form::Prism { corners_um: vec![[-a, -b], [a, -b], [a, b], [-a, b]], half_length_um: c }
    }

    /// Volume, µm³.
    pub fn volume_um3(&self) -> f64 {
        match self {
            Form::Ellipsoid { semi_axes_um: [a, b, c] } => 4.0 / 3.0 * PI * a * b * c,
            Form::Disc { radius_um, half_length_um } => 2.0 * PI * radius_um * radius_um * half_length_um,
            Form::Prism { corners_um, half_length_um } => 2.0 * area(corners_um) * half_length_um,
        }
    }

    /// The form with all lengths multiplied by `factor`.
    pub fn scaled(&self, factor: f64) -> Form {
        self.resized(|x| x * factor, |corners| corners.iter().map(|c| c.map(|x| x * factor)).collect())
    }

    /// A form of the same kind with other semi-axes, radius and length, and other corners.
    pub(in crate::ink) fn resized(
        &self,
        length: impl Fn(f64) -> f64,
        corners: impl Fn(&[[f64; 2]]) -> Vec<[f64; 2]>,
    ) -> Form {
        match self {
            Form::Ellipsoid { semi_axes_um } => Form::Ellipsoid { semi_axes_um: semi_axes_um.map(length) },
            Form::Disc { radius_um, half_length_um } => {
                Form::Disc { radius_um: length(*radius_um), half_length_um: length(*half_length_um) }
            }
            Form::Prism { corners_um, half_length_um } => {
                Form::Prism { corners_um: corners(corners_um), half_length_um: length(*half_length_um) }
            }
        }
    }

    /// The point farthest along `direction`, in the form's frame.
    pub fn farthest(&self, direction: V3) -> V3 {
        let [x, y, z] = direction;
        match self {
            Form::Ellipsoid { semi_axes_um: axes } => {
                let stretched: V3 = std::array::from_fn(|i| axes[i] * direction[i]);
                let toward = unit(stretched);
                std::array::from_fn(|i| axes[i] * toward[i])
            }
            Form::Disc { radius_um, half_length_um } => {
                let across = x.hypot(y);
                let [x, y] = if across > 0.0 { [x / across, y / across] } else { [0.0; 2] };
                [radius_um * x, radius_um * y, half_length_um.copysign(z)]
            }
            Form::Prism { corners_um, half_length_um } => {
                let along = corners_um.iter().map(|c| (c[0] * x + c[1] * y, *c));
                let (_, [x, y]) = along.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or_default();
                [x, y, half_length_um.copysign(z)]
            }
        }
    }

    /// Largest distance of a point from the centre, µm.
    pub fn reach_um(&self) -> f64 {
        match self {
            Form::Ellipsoid { semi_axes_um } => semi_axes_um.iter().copied().fold(0.0, f64::max),
            Form::Disc { radius_um, half_length_um } => radius_um.hypot(*half_length_um),
            Form::Prism { corners_um, half_length_um } => {
                corners_um.iter().map(|c| c[0].hypot(c[1])).fold(0.0, f64::max).hypot(*half_length_um)
            }
        }
    }

    /// Half of the least distance between two parallel planes that hold the body, µm.
    pub fn thin_um(&self) -> f64 {
        match self {
            Form::Ellipsoid { semi_axes_um } => semi_axes_um.iter().copied().fold(f64::MAX, f64::min),
            Form::Disc { radius_um, half_length_um } => radius_um.min(*half_length_um),
            Form::Prism { corners_um, half_length_um } => {
                let widths = edges(corners_um).map(|(a, b)| {
                    let n = outward(a, b);
                    0.5 * dot(sub(self.farthest(n), self.farthest(scale(n, -1.0))), n)
                });
                widths.fold(*half_length_um, f64::min)
            }
        }
    }

    /// The part of the line p + t d inside, in the form's frame: t at both ends.
    fn chord(&self, p: V3, d: V3) -> Option<[f64; 2]> {
        let ends = |half: f64| [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]].map(|n| (n, half));
        let [a, b] = match self {
            Form::Ellipsoid { semi_axes_um: axes } => {
                // in units of the semi-axes, where the ellipsoid is a sphere of radius 1
                let p: V3 = std::array::from_fn(|i| p[i] / axes[i]);
                let d: V3 = std::array::from_fn(|i| d[i] / axes[i]);
                roots(dot(d, d), dot(p, d), dot(p, p) - 1.0)?
            }
            Form::Disc { radius_um, half_length_um } => {
                let planar = |a: V3, b: V3| a[0] * b[0] + a[1] * b[1];
                let round = roots(planar(d, d), planar(p, d), planar(p, p) - radius_um * radius_um)?;
                clipped(round, p, d, ends(*half_length_um))
            }
            Form::Prism { corners_um, half_length_um } => {
                let sides = edges(corners_um).map(|(a, b)| {
                    let n = outward(a, b);
                    (n, n[0] * a[0] + n[1] * a[1])
                });
                clipped([f64::NEG_INFINITY, f64::INFINITY], p, d, sides.chain(ends(*half_length_um)))
            }
        };
        (a < b).then_some([a, b])
    }

    /// The face nearest to a point: the signed distance from it (from an ellipsoid along its
    /// shortest axis), and a vector outwards from it.
    pub(super) fn nearest_face(&self, p: V3) -> (f64, V3) {
        let [x, y, z] = p;
        let end = |half: f64| (z.abs() - half, [0.0, 0.0, z.signum()]);
        match self {
            Form::Ellipsoid { semi_axes_um: axes @ [a, b, c] } => {
                let depth = ((x / a).hypot(y / b).hypot(z / c) - 1.0) * a.min(*b).min(*c);
                (depth, std::array::from_fn(|i| p[i] / (axes[i] * axes[i])))
            }
            Form::Disc { radius_um, half_length_um } => {
                let side = x.hypot(y) - radius_um;
                let (end_depth, end_normal) = end(*half_length_um);
                if side > end_depth { (side, [x, y, 0.0]) } else { (end_depth, end_normal) }
            }
            Form::Prism { corners_um, half_length_um } => {
                let sides = edges(corners_um).map(|(a, b)| {
                    let n = outward(a, b);
                    (n[0] * (x - a[0]) + n[1] * (y - a[1]), n)
                });
                let faces = sides.chain([end(*half_length_um)]);
                let none = (f64::NEG_INFINITY, [0.0, 0.0, 1.0]);
                faces.fold(none, |far, face| if face.0 < far.0 { far } else { face })
            }
        }
    }

    /// Longest axis, diameter or edge, µm.
    pub fn longest_um(&self) -> f64 {
        match self {
            Form::Ellipsoid { .. } => 2.0 * self.reach_um(),
            Form::Disc { radius_um, half_length_um } => 2.0 * radius_um.max(*half_length_um),
            Form::Prism { corners_um, half_length_um } => {
                let sides = edges(corners_um).map(|(a, b)| (a[0] - b[0]).hypot(a[1] - b[1]));
                sides.fold(2.0 * half_length_um, f64::max)
            }
        }
    }
}

impl Solid {
    /// A form in its own frame, about a centre in µm.
    pub fn upright(form: Form, center_um: V3) -> Solid {
        Solid { form, center_um, rotation: Rotation::IDENTITY }
    }

    /// The body about another centre, µm.
    pub fn placed(&self, center_um: V3) -> Solid {
        Solid { center_um, ..self.clone() }
    }

    /// Lowest and highest coordinate along axis 0, 1 or 2, µm.
    pub fn extent_um(&self, axis: usize) -> [f64; 2] {
        let mut direction = [0.0; 3];
        direction[axis] = 1.0;
        let half = dot(self.arm(direction), direction);
        let back = dot(self.arm(scale(direction, -1.0)), direction);
        [self.center_um[axis] + back, self.center_um[axis] + half]
    }

    /// The body moved along z towards smaller z, µm.
    pub fn lowered(&self, by_um: f64) -> Self {
        let [x, y, z] = self.center_um;
        Self { center_um: [x, y, z - by_um], ..self.clone() }
    }

    /// The point farthest along `direction`, relative to the centre, µm.
    pub fn arm(&self, direction: V3) -> V3 {
        self.rotation.turn(self.form.farthest(self.rotation.inverse().turn(direction)))
    }

    /// The part of the line from + t along inside the body: t at both ends.
    pub fn chord(&self, from: V3, along: V3) -> Option<[f64; 2]> {
        let back = self.rotation.inverse();
        self.form.chord(back.turn(sub(from, self.center_um)), back.turn(along))
    }

    /// Outward normal of the surface nearest to a point on it.
    pub fn normal(&self, point: V3) -> V3 {
        let in_frame = self.rotation.inverse().turn(sub(point, self.center_um));
        let (_, outwards) = self.form.nearest_face(in_frame);
        unit(self.rotation.turn(outwards))
    }

    /// Corners of a prism relative to its centre: the lower end, then the upper one.
    pub fn corners(corners_um: &[[f64; 2]], half_length_um: f64, rotation: Rotation) -> Vec<V3> {
        let end = |z: f64| corners_um.iter().map(move |c| rotation.turn([c[0], c[1], z]));
        end(-half_length_um).chain(end(half_length_um)).collect()
    }

    /// Triangles of the surface, corners in µm; round surfaces in `steps` parts per half turn.
    pub fn triangles(&self, steps: usize) -> Vec<[V3; 3]> {
        let place = |p: V3| add(self.center_um, self.rotation.turn(p));
        let mut triangles = Vec::new();
        for pair in self.rings(steps).windows(2) {
            for (i, next) in (0..pair[0].len()).zip((1..pair[0].len()).chain([0])) {
                let a = place(pair[0][i]);
                let b = place(pair[0][next]);
                let c = place(pair[1][i]);
                let d = place(pair[1][next]);
                triangles.extend([[a, b, d], [a, d, c]]);
            }
        }
        triangles.retain(|t| norm(cross(sub(t[1], t[0]), sub(t[2], t[0]))) > 0.0);
        triangles
    }

    /// Closed rings of points in the form's frame, from the lower to the upper end.
    fn rings(&self, steps: usize) -> Vec<Vec<V3>> {
        let turns = |n: usize| (0..n).map(|i| (PI * i as f64 / steps as f64).sin_cos());
        let (around, h) = match &self.form {
            Form::Ellipsoid { semi_axes_um: [a, b, c] } => {
                let rings = turns(steps + 1).map(|(sine, cosine)| {
                    turns(2 * steps).map(|(s, co)| [a * sine * co, b * sine * s, -c * cosine]).collect()
                });
                return rings.collect();
            }
            Form::Disc { radius_um: r, half_length_um } => {
                (turns(2 * steps).map(|(s, c)| [r * c, r * s]).collect(), *half_length_um)
            }
            Form::Prism { corners_um, half_length_um } => (corners_um.clone(), *half_length_um),
        };
        let rings = [(0.0, -h), (1.0, -h), (1.0, h), (0.0, h)];
        rings.map(|(share, z)| around.iter().map(|p| [share * p[0], share * p[1], z]).collect()).to_vec()
    }
}

/// Both solutions t of a t² + 2 b t + c = 0; the whole line if it is parallel to a round wall and
/// inside.
fn roots(a: f64, b: f64, c: f64) -> Option<[f64; 2]> {
    if a < 1e-300 {
        return (c < 0.0).then_some([f64::NEG_INFINITY, f64::INFINITY]);
    }
    let square = b * b - a * c;
    (square > 0.0).then(|| [-1.0, 1.0].map(|side| (-b + side * square.sqrt()) / a))
}

/// The part of an interval of the line p + t d within half-spaces n · x ≤ offset.
fn clipped(interval: [f64; 2], p: V3, d: V3, within: impl IntoIterator<Item = (V3, f64)>) -> [f64; 2] {
    let [mut a, mut b] = interval;
    for (n, offset) in within {
        let rate = dot(n, d);
        let room = offset - dot(n, p);
        match rate {
            rate if rate > 0.0 => b = b.min(room / rate),
            rate if rate < 0.0 => a = a.max(room / rate),
            _ if room < 0.0 => b = f64::NEG_INFINITY,
            _ => {}
        }
    }
    [a, b]
}

/// Edges of a closed polygon, from corner to corner.
pub fn edges(corners: &[[f64; 2]]) -> impl Iterator<Item = ([f64; 2], [f64; 2])> {
    corners.iter().copied().zip(corners.iter().copied().cycle().skip(1))
}

/// Horizontal unit normal of an edge, outward if the corners run counterclockwise.
pub fn outward(a: [f64; 2], b: [f64; 2]) -> V3 {
    unit([b[1] - a[1], a[0] - b[0], 0.0])
}

/// Signed area of a polygon, positive if its corners run counterclockwise.
pub fn area(corners: &[[f64; 2]]) -> f64 {
    0.5 * edges(corners).map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum::<f64>()
}

/// Moves the centre of mass of a polygon to the origin; corners run counterclockwise afterwards.
pub fn centred(corners: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let total = area(corners);
    let mut centre = [0.0; 2];
    for (a, b) in edges(corners) {
        let part = (a[0] * b[1] - a[1] * b[0]) / (6.0 * total);
        (0..2).for_each(|i| centre[i] += part * (a[i] + b[i]));
    }
    let mut moved: Vec<[f64; 2]> = corners.iter().map(|c| [c[0] - centre[0], c[1] - centre[1]]).collect();
    if total < 0.0 {
        moved.reverse();
    }
    moved
}

/// Whether the corners, in either sense of rotation, bound a convex polygon of some area.
pub fn is_convex(corners: &[[f64; 2]]) -> bool {
    let n = corners.len();
    let turn = |i: usize| {
        let a = corners[i % n];
        let b = corners[(i + 1) % n];
        let c = corners[(i + 2) % n];
        (b[0] - a[0]) * (c[1] - b[1]) - (b[1] - a[1]) * (c[0] - b[0])
    };
    let angle = |i: usize| {
        let a = corners[i % n];
        let b = corners[(i + 1) % n];
        let c = corners[(i + 2) % n];
        let along = (b[0] - a[0]) * (c[0] - b[0]) + (b[1] - a[1]) * (c[1] - b[1]);
        turn(i).atan2(along).abs()
    };
    let finite = n >= 3 && corners.iter().flatten().all(|x| x.is_finite());
    // A polygon that winds around twice turns by 4π.
    finite
        && ((0..n).all(|i| turn(i) > 0.0) || (0..n).all(|i| turn(i) < 0.0))
        && (0..n).map(angle).sum::<f64>() < 3.0 * PI
}

#[cfg(test)]
#[path = "solid_tests.rs"]
mod tests;
