//! Horizontal cuts through bodies: at a height z, where is the body's edge, and how large is its area?
//!
//! A cut's Fourier transform follows from its edge alone (divergence theorem):
//! ∫ e^{−ik·x} dA = (i/k²) ∮ k·n e^{−ik·x} ds, so discs and unions of discs are treated alike.

use crate::wave::scene::{Ball, Shape};
use gauss_quad::GaussLegendre;
use std::f64::consts::{PI, TAU};

/// A point of a cut's edge: position in µm and outward normal times arc length.
#[derive(Clone, Copy, Debug)]
pub struct EdgePoint {
    pub position: [f64; 2],
    pub normal: [f64; 2],
}

/// A cut through a body at one height.
pub enum Cut<'a> {
    /// Area in µm² and edge.
    Edge { area: f64, points: &'a [EdgePoint] },
    /// A strip x₀ … x₁ that is uniform in y.
    Strip([f64; 2]),
    /// The whole plane.
    Everything,
}

/// Quadrature heights (z, weight) for the part of `shape` within `range`, accurate for wavenumbers up to `kmax`.
///
/// The range is divided where the cut's shape changes; within a part, z = lo + (hi − lo) sin²t removes the
/// square roots with which edges appear and vanish.
pub fn heights(shape: &Shape, range: [f64; 2], kmax: f64, degree: usize, out: &mut Vec<(f64, f64)>) {
    out.clear();
    let breaks = breakpoints(shape, range);
    for pair in breaks.windows(2) {
        let (lo, length) = (pair[0], pair[1] - pair[0]);
        let smooth = matches!(shape, Shape::Balls(balls) if balls.len() == 1);
        let rule =
            GaussLegendre::new(height_count(length, kmax, smooth) + degree).expect("at least two nodes");
        for &(x, w) in rule.as_node_weight_pairs() {
            let t = 0.5 * (x + 1.0);
            let (s, ds) =
                if smooth { (t, 1.0) } else { ((PI / 2.0 * t).sin().powi(2), PI / 2.0 * (PI * t).sin()) };
            out.push((lo + length * s, 0.5 * w * length * ds));
        }
    }
}

/// Gauss points that integrate a cut's transform to about 1e-10. One ball's transform is an entire function of
/// z, with wavenumbers up to `kmax` times the height, times the shape functions.
fn height_count(length: f64, kmax: f64, smooth: bool) -> usize {
    let phase = kmax * length;
    if smooth { 3 + (0.5 * phase) as usize } else { 8 + phase as usize }
}

fn breakpoints(shape: &Shape, [lo, hi]: [f64; 2]) -> Vec<f64> {
    let mut breaks = vec![lo, hi];
    match shape {
        Shape::Balls(balls) => {
            breaks.extend(
                balls.iter().flat_map(|b| [b.center_um[2] - b.radius_um, b.center_um[2] + b.radius_um]),
            );
            let pairs =
                balls.iter().enumerate().flat_map(|(i, a)| balls[i + 1..].iter().map(move |b| (a, b)));
            breaks.extend(pairs.filter_map(|(a, b)| meeting_heights(a, b)).flatten());
        }
        Shape::CylinderY { z_um, radius_um, .. } => breaks.extend([z_um - radius_um, z_um + radius_um]),
        Shape::BarY { z_um, .. } | Shape::Sheet { z_um } => breaks.extend(z_um),
        Shape::Above { .. } => {}
    }
    let (first, last) = body_range(shape);
    breaks.retain(|&z| z >= lo.max(first) && z <= hi.min(last));
    breaks.sort_by(f64::total_cmp);
    breaks.dedup_by(|a, b| (*a - *b).abs() < 1e-12 * (hi - lo));
    breaks
}

fn body_range(shape: &Shape) -> (f64, f64) {
    let body = crate::wave::Body::new(shape.clone(), 0);
    let [lo, hi] = body.extent_um();
    (lo, hi)
}

/// Lowest and highest point of the circle in which two balls' surfaces meet.
fn meeting_heights(a: &Ball, b: &Ball) -> Option<[f64; 2]> {
    let delta: [f64; 3] = std::array::from_fn(|i| b.center_um[i] - a.center_um[i]);
    let distance = delta.iter().map(|d| d * d).sum::<f64>().sqrt();
    let along = (distance.powi(2) + a.radius_um.powi(2) - b.radius_um.powi(2)) / (2.0 * distance);
    let circle = (a.radius_um.powi(2) - along * along).sqrt();
    let tilt = delta[2] / distance;
    let reach = circle * (1.0 - tilt * tilt).max(0.0).sqrt();
    let center = a.center_um[2] + along * tilt;
    // NaN: concentric balls, or surfaces that do not meet.
    reach.is_finite().then_some([center - reach, center + reach])
}

/// Cuts `shape` at height `z`; edge points go to `buffer`.
pub fn cut<'a>(shape: &Shape, z: f64, kmax: f64, buffer: &'a mut Vec<EdgePoint>) -> Cut<'a> {
    match shape {
        Shape::Balls(balls) => cut_balls(balls, z, kmax, buffer),
        Shape::CylinderY { x_um, z_um, radius_um } => {
            let half = (radius_um.powi(2) - (z - z_um).powi(2)).max(0.0).sqrt();
            Cut::Strip([x_um - half, x_um + half])
        }
        Shape::BarY { x_um, .. } => Cut::Strip(*x_um),
        // What lies above a rough surface is summed in columns, not in cuts.
        Shape::Sheet { .. } | Shape::Above { .. } => Cut::Everything,
    }
}

#[derive(Clone, Copy)]
struct Disc {
    center: [f64; 2],
    radius: f64,
}

fn cut_balls<'a>(balls: &[Ball], z: f64, kmax: f64, buffer: &'a mut Vec<EdgePoint>) -> Cut<'a> {
    buffer.clear();
    let origin = [balls[0].center_um[0], balls[0].center_um[1]];
    let discs: Vec<Disc> = balls.iter().filter_map(|b| disc_of(b, z)).collect();
    for i in 0..discs.len() {
        let covered = covered_angles(&discs, i);
        for_free_arcs(covered, |start, end| push_arc(&discs[i], start, end, kmax, buffer));
    }
    let moment = |p: &EdgePoint| (0..2).map(|i| (p.position[i] - origin[i]) * p.normal[i]).sum::<f64>();
    Cut::Edge { area: 0.5 * buffer.iter().map(moment).sum::<f64>(), points: buffer }
}

fn disc_of(ball: &Ball, z: f64) -> Option<Disc> {
    let square = ball.radius_um.powi(2) - (z - ball.center_um[2]).powi(2);
    (square > 0.0).then(|| Disc { center: [ball.center_um[0], ball.center_um[1]], radius: square.sqrt() })
}

/// Angular intervals [start, end] of disc `i`'s edge that lie inside other discs; may exceed ±π.
fn covered_angles(discs: &[Disc], i: usize) -> Vec<[f64; 2]> {
    let a = discs[i];
    let mut covered = Vec::new();
    for (j, b) in discs.iter().enumerate().filter(|&(j, _)| j != i) {
        let delta = [b.center[0] - a.center[0], b.center[1] - a.center[1]];
        let distance = delta[0].hypot(delta[1]);
        let swallowed = distance <= b.radius - a.radius && (distance > 0.0 || b.radius > a.radius || j < i);
        if swallowed {
            return vec![[0.0, TAU]];
        }
        if distance < a.radius + b.radius && distance > (a.radius - b.radius).abs() {
            let cosine = (distance * distance + a.radius * a.radius - b.radius * b.radius)
                / (2.0 * distance * a.radius);
            let (middle, half) = (delta[1].atan2(delta[0]), cosine.clamp(-1.0, 1.0).acos());
            covered.push([middle - half, middle + half]);
        }
    }
    covered
}

/// Calls `arc` with every stretch of the circle outside the `covered` intervals.
fn for_free_arcs(covered: Vec<[f64; 2]>, mut arc: impl FnMut(f64, f64)) {
    if covered.is_empty() {
        return arc(0.0, TAU);
    }
    let start = covered[0][1];
    let shift = |[a, b]: [f64; 2]| {
        let a0 = (a - start).rem_euclid(TAU);
        [a0, a0 + (b - a)]
    };
    let mut shifted: Vec<[f64; 2]> = covered.into_iter().map(shift).collect();
    shifted.sort_by(|a, b| a[0].total_cmp(&b[0]));
    // An interval that wraps past 2π covers the beginning as well.
    let mut free = shifted.iter().map(|s| s[1] - TAU).fold(0.0, f64::max);
    for [a, b] in shifted {
        if a > free {
            arc(start + free, start + a.min(TAU));
        }
        free = free.max(b);
    }
    if free < TAU {
        arc(start + free, start + TAU);
    }
}

/// Points along an arc: the trapezoidal rule on a whole circle, Gauss–Legendre on a part; both converge
/// geometrically once they resolve e^{−ik·x}.
fn push_arc(disc: &Disc, start: f64, end: f64, kmax: f64, buffer: &mut Vec<EdgePoint>) {
    let phase = kmax * disc.radius;
    let mut push = |angle: f64, weight: f64| {
        let (s, c) = angle.sin_cos();
        let position = [disc.center[0] + disc.radius * c, disc.center[1] + disc.radius * s];
        buffer.push(EdgePoint { position, normal: [c * disc.radius * weight, s * disc.radius * weight] });
    };
    if end - start >= TAU {
        let count = (1.3 * phase) as usize + 16;
        (0..count).for_each(|q| push(TAU * q as f64 / count as f64, TAU / count as f64));
        return;
    }
    let half = 0.5 * (end - start);
    let rule = GaussLegendre::new((0.7 * phase * half) as usize + 10).expect("at least two nodes");
    rule.as_node_weight_pairs().iter().for_each(|&(x, w)| push(start + half * (1.0 + x), half * w));
}
