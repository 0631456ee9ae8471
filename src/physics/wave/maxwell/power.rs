//! Power diagrams of cuts through a union of balls: each ball's share of a cut and its edge.
//!
//! A point belongs to the ball of least power |x − c|² − R². At one height the shares are bounded
//! by the discs' free arcs and by segments of their radical lines, along which the balls' surfaces
//! meet.

use crate::ink::Sphere;
use crate::wave::contrast::section::{self, Edge, EdgePoint, Sampling, breakpoints, free_arcs};

/// Calls `edge(z, weight, points)` for heights within a range on the edge of ball `i`'s share.
pub(super) fn share_edges(
    balls: &[Sphere],
    i: usize,
    range: [f64; 2],
    sampling: &Sampling,
    edge: &mut impl FnMut(f64, f64, &Edge),
) {
    let mut points = Vec::new();
    for part in breakpoints(balls, i, range).windows(2) {
        let lo = part[0];
        let length = part[1] - part[0];
        for &(x, w) in section::gauss_rule(sampling.height_count(length, false) + 2) {
            // z = lo + length sin²t removes the square roots with which edges appear and vanish.
            let t = std::f64::consts::FRAC_PI_4 * (x + 1.0);
            let z = lo + length * t.sin().powi(2);
            let dz = length * (2.0 * t).sin();
            share_edge(balls, i, z, sampling, &mut points);
            edge(z, std::f64::consts::FRAC_PI_4 * w * dz, &points);
        }
    }
}

/// Centre and squared radius of a ball's disc at a height; the square may be negative, powers
/// remain defined.
fn disc(ball: &Sphere, z: f64) -> ([f64; 2], f64) {
    let [x, y, height] = ball.center_um;
    ([x, y], ball.radius_um.powi(2) - (z - height).powi(2))
}

fn share_edge(balls: &[Sphere], i: usize, z: f64, sampling: &Sampling, points: &mut Vec<EdgePoint>) {
    points.clear();
    for arc in free_arcs(balls, i, z) {
        sampling.push_arc(&balls[i], z, arc, points);
    }
    for j in (0..balls.len()).filter(|&j| j != i) {
        push_chord(balls, [i, j], z, sampling, points);
    }
}

/// Points along the segment of the radical line of discs `i` and `j` that bounds the share of disc
/// `i`.
fn push_chord(
    balls: &[Sphere],
    [i, j]: [usize; 2],
    z: f64,
    sampling: &Sampling,
    points: &mut Vec<EdgePoint>,
) {
    let (first, first_square) = disc(&balls[i], z);
    let (second, second_square) = disc(&balls[j], z);
    let delta = [0, 1].map(|k| second[k] - first[k]);
    let distance = delta[0].hypot(delta[1]);
    if distance < 1e-12 * balls[i].radius_um {
        return;
    }
    let normal = delta.map(|d| d / distance);
    let along = 0.5 * (distance + (first_square - second_square) / distance);
    let half = (first_square - along * along).max(0.0).sqrt();
    let tangent = [-normal[1], normal[0]];
    let foot = [0, 1].map(|k| first[k] + along * normal[k]);
    let mut stretch = [-half, half];
    for k in (0..balls.len()).filter(|&k| k != i && k != j) {
        let (third, square) = disc(&balls[k], z);
        let apart = [0, 1].map(|a| third[a] - first[a]);
        let dot = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
        // Power of the third ball minus that of this one along the line: start + slope t, which
        // must be positive.
        let start = dot(apart, apart) - 2.0 * dot(apart, normal.map(|n| along * n)) - square + first_square;
        clip(&mut stretch, start, -2.0 * dot(apart, tangent), balls[i].radius_um, k < j);
    }
    let [from, to] = stretch;
    if to <= from {
        return;
    }
    let half = 0.5 * (to - from);
    for &(x, w) in section::gauss_of_degree(sampling.demands.degree(half) + 3.0) {
        let t = from + half * (1.0 + x);
        let position = [0, 1].map(|k| foot[k] + t * tangent[k]);
        points.push(EdgePoint { position, normal: normal.map(|n| n * half * w) });
    }
}

/// Restricts an interval to start + slope t ≥ 0; of three balls with a common radical line the
/// first two share it.
fn clip(stretch: &mut [f64; 2], start: f64, slope: f64, radius: f64, third_first: bool) {
    if slope.abs() < 1e-12 * radius {
        let on_line = start.abs() < 1e-12 * radius * radius;
        if (on_line && third_first) || (!on_line && start < 0.0) {
            *stretch = [0.0, 0.0];
        }
    } else if slope > 0.0 {
        stretch[0] = stretch[0].max(-start / slope);
    } else {
        stretch[1] = stretch[1].min(-start / slope);
    }
}
