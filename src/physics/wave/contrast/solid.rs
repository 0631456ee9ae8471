//! Horizontal cuts through convex bodies: closed curves of straight segments and arcs of ellipses.
//!
//! A cut is exact at every height. Heights are divided where the kind of the cut changes: at the
//! corners of a prism, and where the ends of a disc begin. Between them a whole ellipse is an
//! entire function of the height, a polygon is linear in it, and the arcs of a disc have square
//! roots at the ends, which z = lo + (hi − lo) sin²t removes.

use super::section::{Edge, EdgePoint, Sampling, gauss_of_degree, heights};
use crate::ink::grains::solid::{Form, Solid};
use crate::numerics::vector::{V3, cross, dot, norm, scale, unit};
use std::f64::consts::{PI, TAU};

/// Part of the edge of a cut, counterclockwise, µm.
enum Boundary {
    Line([[f64; 2]; 2]),
    /// center + cos φ axes\[0\] + sin φ axes\[1\] for φ in `angles`.
    Arc {
        center: [f64; 2],
        axes: [[f64; 2]; 2],
        angles: [f64; 2],
    },
}

/// Heights within which the cut keeps its kind.
struct Stretch {
    range: [f64; 2],
    /// Half of the lateral movement of the edge's points, µm.
    reach: f64,
    /// Whether square roots occur at the ends.
    roots: bool,
}

/// |cos| of the angle between a disc's axis and z below which the axis counts as horizontal: the
/// disc's surface moves by less than this share of its size.
const LYING: f64 = 1e-8;

impl Sampling {
    /// Calls `cut(z, weight, points)` for the edges of the cuts within a range of heights. `extra`
    /// is the degree that the integrand has in addition to the wave and ψ.
    pub fn cuts(&self, solid: &Solid, range: [f64; 2], extra: f64, cut: &mut impl FnMut(f64, f64, &Edge)) {
        let mut points = Vec::new();
        let [low, high] = solid.extent_um(2);
        for stretch in stretches(solid, [range[0].max(low), range[1].min(high)]) {
            let lo = stretch.range[0];
            let length = stretch.range[1] - stretch.range[0];
            let more =
                self.degree as f64 + extra + if stretch.roots { 4.0 + self.degree as f64 } else { 2.0 };
            let count = (0.5 * (self.demands.degree(stretch.reach) + more)).ceil() as usize + 1;
            for (z, weight) in heights(lo, length, count, stretch.roots) {
                points.clear();
                sides(solid, z).iter().for_each(|side| self.push_side(side, extra, &mut points));
                cut(z, weight, &points);
            }
        }
    }

    fn push_side(&self, side: &Boundary, extra: f64, points: &mut Vec<EdgePoint>) {
        match *side {
            Boundary::Line([from, to]) => {
                let step = [to[0] - from[0], to[1] - from[1]];
                let degree = self.demands.degree(0.5 * step[0].hypot(step[1])) + 1.0 + extra;
                for &(x, w) in gauss_of_degree(degree) {
                    let t = 0.5 * (x + 1.0);
                    let position = [from[0] + t * step[0], from[1] + t * step[1]];
                    points.push(EdgePoint { position, normal: [0.5 * w * step[1], -0.5 * w * step[0]] });
                }
            }
            Boundary::Arc { center, axes, angles: [start, end] } => {
                let mut push = |angle: f64, weight: f64| points.push(arc_point(center, axes, angle, weight));
                let longest = axes.iter().map(|a| a[0].hypot(a[1])).fold(0.0, f64::max);
                if end - start >= TAU {
                    // n points integrate waves of degree n − 1, and the normal adds one.
                    let count = (self.demands.degree(longest) + extra).ceil() as usize + 3;
                    let step = TAU / count as f64;
                    return (0..count).for_each(|i| push(step * i as f64, step));
                }
                let half = 0.5 * (end - start);
                let degree = self.demands.degree(longest * half) + 4.0 * half + 2.0 + extra;
                for &(x, w) in gauss_of_degree(degree) {
                    push(start + half * (1.0 + x), half * w);
                }
            }
        }
    }
}

/// The point of an ellipse at an angle, with a quadrature weight in radians.
fn arc_point(center: [f64; 2], axes: [[f64; 2]; 2], angle: f64, weight: f64) -> EdgePoint {
    let (s, c) = angle.sin_cos();
    let position = [0, 1].map(|i| center[i] + c * axes[0][i] + s * axes[1][i]);
    let tangent = [0, 1].map(|i| c * axes[1][i] - s * axes[0][i]);
    EdgePoint { position, normal: [weight * tangent[1], -weight * tangent[0]] }
}

fn stretches(solid: &Solid, [lo, hi]: [f64; 2]) -> Vec<Stretch> {
    let center = solid.center_um[2];
    let mut heights = match &solid.form {
        Form::Ellipsoid { .. } => Vec::new(),
        Form::Disc { radius_um, half_length_um } => {
            let [sine, cosine] = tilt(solid);
            let ends = [-1.0, 1.0].map(|e| e * half_length_um * cosine);
            ends.iter().flat_map(|end| [-1.0, 1.0].map(|s| center + end + s * radius_um * sine)).collect()
        }
        Form::Prism { corners_um, half_length_um } => {
            let corners = Solid::corners(corners_um, *half_length_um, solid.rotation);
            corners.iter().map(|c| center + c[2]).collect::<Vec<f64>>()
        }
    };
    heights.retain(|&z| z > lo && z < hi);
    heights.extend([lo, hi]);
    heights.sort_by(f64::total_cmp);
    heights.dedup_by(|a, b| (*a - *b).abs() < 1e-12 * solid.form.reach_um());
    heights.windows(2).filter(|_| hi > lo).map(|pair| stretch(solid, [pair[0], pair[1]])).collect()
}

fn stretch(solid: &Solid, range: [f64; 2]) -> Stretch {
    let length = range[1] - range[0];
    let middle = 0.5 * (range[0] + range[1]) - solid.center_um[2];
    match &solid.form {
        Form::Ellipsoid { .. } => {
            let ellipse = Ellipse::of(solid);
            let rate = ellipse.drift[0].hypot(ellipse.drift[1]) + ellipse.widest() / ellipse.half;
            Stretch { range, reach: 0.5 * length * rate, roots: false }
        }
        Form::Disc { radius_um, half_length_um } => {
            let [sine, cosine] = tilt(solid);
            // Whole ellipses between the ends of a long rod move sideways only.
            let whole = middle.abs() + radius_um * sine <= half_length_um * cosine * (1.0 + 1e-12);
            let drift = if whole { sine / cosine } else { 0.0 };
            let most = (half_length_um * sine).hypot(*radius_um);
            let reach = if whole { 0.5 * length * drift } else { 0.5 * PI * most };
            Stretch { range, reach, roots: !whole }
        }
        Form::Prism { corners_um, half_length_um } => {
            let corners = Solid::corners(corners_um, *half_length_um, solid.rotation);
            let rate = |[a, b]: [V3; 2]| (b[0] - a[0]).hypot(b[1] - a[1]) / (b[2] - a[2]).abs();
            let fastest = crossing(&corners, middle).map(rate).fold(0.0, f64::max);
            Stretch { range, reach: 0.5 * length * fastest, roots: false }
        }
    }
}

/// sin and cos of the angle between the axis of a disc and ±z.
fn tilt(solid: &Solid) -> [f64; 2] {
    let axis = solid.rotation.turn([0.0, 0.0, 1.0]);
    let sine = axis[0].hypot(axis[1]);
    let cosine = axis[2].abs();
    if cosine < LYING { [1.0, 0.0] } else { [if sine < LYING { 0.0 } else { sine }, cosine] }
}

/// Edges of a prism that cross the height ζ above its centre.
fn crossing(corners: &[V3], zeta: f64) -> impl Iterator<Item = [V3; 2]> + '_ {
    let n = corners.len() / 2;
    let edges = (0..n).flat_map(move |i| {
        let next = (i + 1) % n;
        [[i, next], [i + n, next + n], [i, i + n]].map(|e| e.map(|k| corners[k]))
    });
    edges.filter(move |[a, b]| (a[2] < zeta) != (b[2] < zeta))
}

/// The edge of the cut at height z.
fn sides(solid: &Solid, z: f64) -> Vec<Boundary> {
    let zeta = z - solid.center_um[2];
    match &solid.form {
        Form::Ellipsoid { .. } => vec![Ellipse::of(solid).at(solid, zeta)],
        Form::Disc { radius_um, half_length_um } => disc(solid, zeta, *radius_um, *half_length_um),
        Form::Prism { corners_um, half_length_um } => {
            let corners = Solid::corners(corners_um, *half_length_um, solid.rotation);
            let [x, y, _] = solid.center_um;
            let meet = |[a, b]: [V3; 2]| {
                let t = (zeta - a[2]) / (b[2] - a[2]);
                [x + a[0] + t * (b[0] - a[0]), y + a[1] + t * (b[1] - a[1])]
            };
            polygon(crossing(&corners, zeta).map(meet).collect())
        }
    }
}

/// The sides of a convex polygon through the given points.
fn polygon(mut corners: Vec<[f64; 2]>) -> Vec<Boundary> {
    let n = corners.len();
    let middle = [0, 1].map(|i| corners.iter().map(|c| c[i]).sum::<f64>() / n.max(1) as f64);
    let angle = |c: &[f64; 2]| (c[1] - middle[1]).atan2(c[0] - middle[0]);
    corners.sort_by(|a, b| angle(a).total_cmp(&angle(b)));
    (0..n).map(|i| Boundary::Line([corners[i], corners[(i + 1) % n]])).collect()
}

/// Cuts of an ellipsoid: ellipses of one shape, whose centre lies on a line.
struct Ellipse {
    /// Half of the ellipsoid's height, µm.
    half: f64,
    /// Lateral movement of the centre per height.
    drift: [f64; 2],
    /// Conjugate half-diameters of the cut through the centre, µm.
    axes: [[f64; 2]; 2],
}

impl Ellipse {
    fn of(solid: &Solid) -> Ellipse {
        let Form::Ellipsoid { semi_axes_um } = &solid.form else { unreachable!("called for ellipsoids") };
        // x = A y with |y| ≤ 1; z is w · y with w the last row of A.
        let image = |y: V3| solid.rotation.turn(std::array::from_fn(|i| semi_axes_um[i] * y[i]));
        let back = solid.rotation.inverse().turn([0.0, 0.0, 1.0]);
        let w: V3 = std::array::from_fn(|i| semi_axes_um[i] * back[i]);
        let half = norm(w);
        let up = unit(w);
        let across = if up[0].abs() < 0.9 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
        let first = unit(std::array::from_fn(|i| across[i] - dot(across, up) * up[i]));
        let [top, first, second] = [up, first, cross(up, first)].map(image);
        let flip = (first[0] * second[1] - first[1] * second[0]).signum();
        let [x, y, _] = scale(top, 1.0 / half);
        let axes = [[first[0], first[1]], [flip * second[0], flip * second[1]]];
        Ellipse { half, drift: [x, y], axes }
    }

    fn widest(&self) -> f64 {
        self.axes.iter().map(|a| a[0] * a[0] + a[1] * a[1]).sum::<f64>().sqrt()
    }

    fn at(&self, solid: &Solid, zeta: f64) -> Boundary {
        let share = (1.0 - (zeta / self.half).powi(2)).max(0.0).sqrt();
        let center = [0, 1].map(|i| solid.center_um[i] + self.drift[i] * zeta);
        Boundary::Arc { center, axes: self.axes.map(|a| a.map(|x| share * x)), angles: [0.0, TAU] }
    }
}

/// The cut of a disc: an ellipse between the two lines in which its ends are cut.
///
/// With the axis in the plane of ê and z at an angle θ from z, the round surface is p = t sin θ + r
/// cos φ cos θ, q = r sin φ, ζ = t cos θ − r cos φ sin θ, |t| ≤ L/2.
fn disc(solid: &Solid, zeta: f64, r: f64, half: f64) -> Vec<Boundary> {
    let axis = solid.rotation.turn([0.0, 0.0, 1.0]);
    let axis = if axis[2] < 0.0 { scale(axis, -1.0) } else { axis };
    let [sine, cosine] = tilt(solid);
    let along = if sine > 0.0 { unit([axis[0], axis[1], 0.0]) } else { [1.0, 0.0, 0.0] };
    let place = |p: f64, q: f64| {
        [solid.center_um[0] + p * along[0] - q * along[1], solid.center_um[1] + p * along[1] + q * along[0]]
    };
    // cos φ on the lines in which the lower and the upper end are cut.
    let bound = |end: f64| (end * cosine - zeta) / (r * sine);
    let [low, high] = if sine > 0.0 { [bound(-half), bound(half)] } else { [-2.0, 2.0] };
    if low >= 1.0 || high <= -1.0 {
        return Vec::new();
    }
    let angle = |cosine: f64| cosine.clamp(-1.0, 1.0).acos();
    let first = angle(high);
    let last = angle(low);
    // Where the ends are cut, and the width of the cut there.
    let edge = |end: f64, angle: f64| (end * sine + r * angle.cos() * cosine, r * angle.sin());
    let (p_high, q_high) = edge(half, first);
    let (p_low, q_low) = edge(-half, last);
    let mut sides = Vec::new();
    if high < 1.0 {
        sides.push(Boundary::Line([place(p_high, -q_high), place(p_high, q_high)]));
    }
    if low > -1.0 {
        sides.push(Boundary::Line([place(p_low, q_low), place(p_low, -q_low)]));
    }
    if cosine == 0.0 {
        sides.push(Boundary::Line([place(p_high, q_high), place(p_low, q_low)]));
        sides.push(Boundary::Line([place(p_low, -q_low), place(p_high, -q_high)]));
        return sides;
    }
    let center = place(zeta * sine / cosine, 0.0);
    let axes = [[along[0], along[1]].map(|x| x * r / cosine), [-along[1] * r, along[0] * r]];
    let whole = sides.is_empty();
    let arcs = if whole { vec![[0.0, TAU]] } else { vec![[first, last], [TAU - last, TAU - first]] };
    sides.extend(arcs.into_iter().map(|angles| Boundary::Arc { center, axes, angles }));
    sides
}

#[cfg(test)]
#[path = "solid_tests.rs"]
mod tests;
