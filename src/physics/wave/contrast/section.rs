//! Geometry of bodies: surfaces of balls as rings of points, and horizontal cuts of bodies along y.
//!
//! Transforms follow from surfaces alone (divergence theorem): for a function ψ(z) of height, ∫ ψ
//! e^{−ik·x} dV = (i/k²) ∮ k·n ψ e^{−ik·x} dS with the horizontal wavevector k; horizontal faces do
//! not contribute. On a ball, n dS is the edge's outward normal times its length times dz, ring by
//! ring, and a union of balls consists of the rings' arcs outside all other balls.

use crate::ink::Sphere;
use crate::wave::BodyShape;
use gauss_quad::GaussLegendre;
use std::f64::consts::{PI, TAU};
use std::sync::OnceLock;

/// A point of a surface's ring: position in µm and outward normal times arc length.
#[derive(Clone, Copy, Debug)]
pub struct EdgePoint {
    /// x and y, µm.
    pub position: [f64; 2],
    /// Horizontal outward normal times the arc's length, µm.
    pub normal: [f64; 2],
}

/// The edge of a cut.
pub type Edge = [EdgePoint];

/// Required resolution of e^{−ik·x} by rings and heights: wavenumbers, 1/µm, each with its relative
/// error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Demands(pub [(f64, f64); 2]);

impl Demands {
    /// Degree of the polynomial that approximates a wave over `reach` µm on either side.
    ///
    /// Its error is the Bessel function J_n(k reach), which beyond n = x decreases like Ai((n −
    /// x)(2/x)^{1/3}).
    pub(in crate::wave) fn degree(&self, reach: f64) -> f64 {
        let one = |&(k, error): &(f64, f64)| {
            let x = k * reach;
            x + (-1.5 * f64::ln(error)).powf(2.0 / 3.0) * (0.5 * x).cbrt()
        };
        self.0.iter().map(one).fold(0.0, f64::max)
    }
}

/// Number of nodes of the largest rule, which resolves some 600 wavelengths.
const MOST_NODES: usize = 2048;

/// Gauss–Legendre rules by their number of nodes, each computed on first use.
static RULES: [OnceLock<GaussLegendre>; MOST_NODES + 1] = [const { OnceLock::new() }; MOST_NODES + 1];

/// Nodes on (−1, 1) and weights.
pub fn gauss_rule(nodes: usize) -> &'static [(f64, f64)] {
    let nodes = nodes.clamp(2, MOST_NODES);
    RULES[nodes].get_or_init(|| GaussLegendre::new(nodes).expect("at least two nodes")).as_node_weight_pairs()
}

/// The rule that integrates polynomials of a degree, with a node to spare.
pub fn gauss_of_degree(degree: f64) -> &'static [(f64, f64)] {
    gauss_rule((0.5 * degree).ceil() as usize + 1)
}

/// Sampling of surfaces.
pub struct Sampling {
    /// Required resolution.
    pub demands: Demands,
    /// Degree of the polynomials ψ in z.
    pub degree: usize,
}

impl Sampling {
    /// Calls `ring(z, weight, points)` for rings on ball `i`, outside all others, within a range of
    /// heights.
    ///
    /// The range is divided where arcs appear and vanish. Whole rings are entire functions of z;
    /// for arcs z = lo + (hi − lo) sin²t removes the square roots at their ends.
    pub fn rings(&self, balls: &[Sphere], i: usize, range: [f64; 2], ring: &mut impl FnMut(f64, f64, &Edge)) {
        let mut points = Vec::new();
        for part in breakpoints(balls, i, range).windows(2) {
            let lo = part[0];
            let length = part[1] - part[0];
            let middle = free_arcs(balls, i, lo + 0.5 * length);
            if middle.is_empty() {
                continue;
            }
            let whole = matches!(middle[..], [[start, end]] if end - start >= TAU);
            for (z, weight) in heights(lo, length, self.height_count(length, whole), !whole) {
                points.clear();
                let arcs = if whole { middle.clone() } else { free_arcs(balls, i, z) };
                arcs.iter().for_each(|arc| self.push_arc(&balls[i], z, *arc, &mut points));
                ring(z, weight, &points);
            }
        }
    }

    /// Number of Gauss points over a height: the degree integrated is 2n − 1.
    pub fn height_count(&self, length: f64, whole: bool) -> usize {
        // Along sin²t the phase changes at up to π/2 times the mean rate.
        let reach = if whole { 0.5 * length } else { 0.25 * PI * length };
        let extra = if whole { self.degree } else { 2 * self.degree + 4 };
        (0.5 * (self.demands.degree(reach) + extra as f64)).ceil() as usize + 1
    }

    /// Adds points along an arc: the trapezoidal rule on a whole circle, Gauss–Legendre on a part;
    /// both converge geometrically once they resolve e^{−ik·x}.
    pub fn push_arc(&self, ball: &Sphere, z: f64, [start, end]: [f64; 2], points: &mut Vec<EdgePoint>) {
        let radius = (ball.radius_um.powi(2) - (z - ball.center_um[2]).powi(2)).max(0.0).sqrt();
        let mut push = |[c, s]: [f64; 2], weight: f64| {
            let position = [ball.center_um[0] + radius * c, ball.center_um[1] + radius * s];
            points.push(EdgePoint { position, normal: [c * radius * weight, s * radius * weight] });
        };
        if end - start >= TAU {
            // n points integrate waves of degree n − 1, and the normal adds one.
            let count = self.demands.degree(radius).ceil() as usize + 3;
            let step = TAU / count as f64;
            let (turn_s, turn_c) = step.sin_cos();
            let mut direction = [1.0, 0.0];
            for _ in 0..count {
                push(direction, step);
                let [c, s] = direction;
                direction = [c * turn_c - s * turn_s, s * turn_c + c * turn_s];
            }
            return;
        }
        let half = 0.5 * (end - start);
        for &(x, w) in gauss_of_degree(self.demands.degree(radius * half) + 4.0 * half + 2.0) {
            let (s, c) = (start + half * (1.0 + x)).sin_cos();
            push([c, s], half * w);
        }
    }

    /// Heights and weights for the part of a body along y within `range`.
    pub fn strip_heights(&self, shape: &BodyShape, [lo, hi]: [f64; 2]) -> impl Iterator<Item = (f64, f64)> {
        let round = matches!(shape, BodyShape::CylinderY { .. });
        let count = if round { self.height_count(hi - lo, false) } else { self.degree };
        heights(lo, hi - lo, count, round)
    }
}

/// Gauss points and weights of a length above `lo`. With `roots`, the substitution s = sin²(πt/2)
/// removes square roots at both of its ends.
pub(super) fn heights(lo: f64, length: f64, count: usize, roots: bool) -> impl Iterator<Item = (f64, f64)> {
    let share = move |t: f64| match roots {
        true => ((PI / 2.0 * t).sin().powi(2), PI / 2.0 * (PI * t).sin()),
        false => (t, 1.0),
    };
    gauss_rule(count).iter().map(move |&(x, w)| {
        let (s, ds) = share(0.5 * (x + 1.0));
        (lo + length * s, 0.5 * w * length * ds)
    })
}

/// Lateral extents of a ball, µm.
pub(in crate::wave) fn extents(ball: &Sphere) -> [[f64; 2]; 2] {
    [0, 1].map(|i| [ball.center_um[i] - ball.radius_um, ball.center_um[i] + ball.radius_um])
}

/// The strip x₀ … x₁ that a body along y covers at height `z`, if it is not covered entirely.
pub fn strip(shape: &BodyShape, z: f64) -> Option<[f64; 2]> {
    match shape {
        BodyShape::CylinderY { x_um, z_um, radius_um } => {
            let half = (radius_um.powi(2) - (z - z_um).powi(2)).max(0.0).sqrt();
            Some([x_um - half, x_um + half])
        }
        BodyShape::BarY { x_um, .. } => Some(*x_um),
        _ => None,
    }
}

/// Heights within `range` between which the number of arcs of ball `i` is constant.
pub(in crate::wave) fn breakpoints(balls: &[Sphere], i: usize, [lo, hi]: [f64; 2]) -> Vec<f64> {
    let ball = &balls[i];
    let lo = lo.max(ball.center_um[2] - ball.radius_um);
    let hi = hi.min(ball.center_um[2] + ball.radius_um);
    let others = balls.iter().enumerate().filter(|&(j, _)| j != i);
    let mut breaks: Vec<f64> = others.filter_map(|(_, b)| meeting_heights(ball, b)).flatten().collect();
    breaks.retain(|&z| z > lo && z < hi);
    breaks.extend([lo, hi]);
    breaks.sort_by(f64::total_cmp);
    breaks.dedup_by(|a, b| (*a - *b).abs() < 1e-12 * ball.radius_um);
    if hi > lo { breaks } else { Vec::new() }
}

/// Lowest and highest point of the circle in which the surfaces of two balls intersect.
fn meeting_heights(a: &Sphere, b: &Sphere) -> Option<[f64; 2]> {
    let delta: [f64; 3] = std::array::from_fn(|i| b.center_um[i] - a.center_um[i]);
    let distance = delta.iter().map(|d| d * d).sum::<f64>().sqrt();
    let along = (distance.powi(2) + a.radius_um.powi(2) - b.radius_um.powi(2)) / (2.0 * distance);
    let circle = (a.radius_um.powi(2) - along * along).sqrt();
    let tilt = delta[2] / distance;
    let reach = circle * (1.0 - tilt * tilt).max(0.0).sqrt();
    let center = a.center_um[2] + along * tilt;
    // NaN: concentric balls, or surfaces that do not intersect.
    reach.is_finite().then_some([center - reach, center + reach])
}

#[derive(Clone, Copy)]
struct SectionDisc {
    center: [f64; 2],
    radius: f64,
}

fn disc_of(ball: &Sphere, z: f64) -> Option<SectionDisc> {
    let square = ball.radius_um.powi(2) - (z - ball.center_um[2]).powi(2);
    (square > 0.0)
        .then(|| SectionDisc { center: [ball.center_um[0], ball.center_um[1]], radius: square.sqrt() })
}

/// Intervals [start, end] of ball `i`'s edge at height `z` that lie outside all other balls.
pub(in crate::wave) fn free_arcs(balls: &[Sphere], i: usize, z: f64) -> Vec<[f64; 2]> {
    let Some(disc) = disc_of(&balls[i], z) else { return Vec::new() };
    let others = balls.iter().enumerate().filter(|&(j, _)| j != i);
    let mut covered = Vec::new();
    for (j, other) in others.filter_map(|(j, b)| Some((j, disc_of(b, z)?))) {
        match covered_angles(&disc, &other, j < i) {
            Covered::All => return Vec::new(),
            Covered::Part(angles) => covered.push(angles),
            Covered::None => {}
        }
    }
    uncovered(covered)
}

/// Part of a disc's edge covered by another disc; angles may exceed ±π.
enum Covered {
    None,
    Part([f64; 2]),
    All,
}

fn covered_angles(a: &SectionDisc, b: &SectionDisc, b_first: bool) -> Covered {
    let delta = [b.center[0] - a.center[0], b.center[1] - a.center[1]];
    let distance = delta[0].hypot(delta[1]);
    // Of two equal discs the second counts as covered.
    if distance <= b.radius - a.radius && (distance > 0.0 || b.radius > a.radius || b_first) {
        return Covered::All;
    }
    if distance < a.radius + b.radius && distance > (a.radius - b.radius).abs() {
        let cosine =
            (distance * distance + a.radius * a.radius - b.radius * b.radius) / (2.0 * distance * a.radius);
        let middle = delta[1].atan2(delta[0]);
        let half = cosine.clamp(-1.0, 1.0).acos();
        return Covered::Part([middle - half, middle + half]);
    }
    Covered::None
}

/// The parts of the circle outside the `covered` intervals.
fn uncovered(covered: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    if covered.is_empty() {
        return vec![[0.0, TAU]];
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
    let mut arcs = Vec::new();
    for [a, b] in shifted {
        if a > free {
            arcs.push([start + free, start + a.min(TAU)]);
        }
        free = free.max(b);
    }
    if free < TAU {
        arcs.push([start + free, start + TAU]);
    }
    arcs
}
