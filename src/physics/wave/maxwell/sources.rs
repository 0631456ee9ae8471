//! Point sources whose Fourier sums are the moments of a grain's indicator χ and of χN, N the
//! normal-field tensor.
//!
//! In a ball N = x xᵀ/R² about its centre: smooth inside, n nᵀ on the surface. In a layer between
//! concentric spheres of radii r and R it is x xᵀ (r² + R² − x²)/(r² R²), n nᵀ on both, and the
//! core is a ball of its own: N is continuous throughout. In a union of balls N is that of the ball
//! of least power |x − c|² − R² (the jump on inner radical planes is harmless at ink contrast). A
//! vertical column of a ball has closed moments in z, so a ball needs a quadrature only in its
//! plan; r = R sin θ removes the square root at the rim.

use super::power::share_edges;
use crate::ink::Sphere;
use crate::wave::contrast::section::{Edge, Sampling, gauss_of_degree, gauss_rule};
use std::f64::consts::{FRAC_PI_2, TAU};

/// Number of fields: χ, and the components xx, xy, yy, xz, yz, zz of χN.
pub const FIELDS: usize = 7;
/// Number of fields on both Gauss planes of a cell, planes running fastest.
pub const VALUES: usize = 2 * FIELDS;

/// Height range of a cell, with the sampling of what lies in it.
#[derive(Clone, Copy)]
pub struct Slab<'a> {
    /// Heights of its faces, µm.
    pub range_um: [f64; 2],
    /// Sampling of surfaces and volumes.
    pub sampling: &'a Sampling,
}

/// A source: lateral position in µm and its contribution to every field's moments, in µm².
#[derive(Clone, Copy, Debug)]
pub struct Source {
    /// Lateral position, µm.
    pub position: [f64; 2],
    /// Contribution to every field's moments, µm².
    pub values: [f64; VALUES],
}

/// Moments 2∫ψ_q ζᵏ dζ/h for both Gauss planes q and k = 0 … 4.
type HeightMoments = [[f64; 5]; 2];

/// N = x xᵀ (constant − slope x²) about a ball's centre.
#[derive(Clone, Copy, Debug)]
pub struct NormalField {
    constant: f64,
    slope: f64,
}

impl NormalField {
    /// N of a homogeneous ball.
    pub fn of_ball(radius_um: f64) -> NormalField {
        NormalField { constant: 1.0 / (radius_um * radius_um), slope: 0.0 }
    }

    /// Components xx, xy, yy, xz, yz, zz of N at a place relative to the centre.
    pub fn at(&self, [x, y, z]: [f64; 3]) -> [f64; FIELDS - 1] {
        let factor = self.constant - self.slope * (x * x + y * y + z * z);
        [x * x, x * y, y * y, x * z, y * z, z * z].map(|square| factor * square)
    }

    /// N between two concentric spheres.
    pub fn of_layer(inner_um: f64, outer_um: f64) -> NormalField {
        let inner = inner_um * inner_um;
        let outer = outer_um * outer_um;
        NormalField { constant: (inner + outer) / (inner * outer), slope: 1.0 / (inner * outer) }
    }
}

impl Slab<'_> {
    fn height(&self) -> f64 {
        self.range_um[1] - self.range_um[0]
    }

    fn middle(&self) -> f64 {
        0.5 * (self.range_um[0] + self.range_um[1])
    }

    /// Moments over an interval ζ₀ … ζ₁ of a column, heights relative to `origin`.
    fn stretch(&self, [from, to]: [f64; 2], origin: f64) -> HeightMoments {
        let h = self.height();
        let middle = self.middle() - origin;
        let power: [f64; 6] = std::array::from_fn(|k| {
            let n = k as i32 + 1;
            (to.powi(n) - from.powi(n)) / f64::from(n)
        });
        let moment = |sign: f64, k: usize| {
            (power[k] + sign * 2.0 * 3f64.sqrt() / h * (power[k + 1] - middle * power[k])) / h
        };
        [-1.0, 1.0].map(|sign| [0, 1, 2, 3, 4].map(|k| moment(sign, k)))
    }

    /// Moments of one height z with a quadrature weight in µm: ψ_q is ½ ∓ √3 (t − ½).
    pub(super) fn point(&self, z: f64, weight: f64, origin: f64) -> HeightMoments {
        let zeta = z - origin;
        let slope = 3f64.sqrt() * (z - self.middle()) / self.height();
        [0.5 - slope, 0.5 + slope]
            .map(|psi| [0, 1, 2, 3, 4].map(|k| 2.0 * weight * psi * zeta.powi(k) / self.height()))
    }
}

/// All fields of a ball's column at (x, y) relative to its centre.
fn ball_values([x, y]: [f64; 2], normal: NormalField, heights: &HeightMoments, weight: f64) -> [f64; VALUES] {
    let NormalField { slope, constant } = normal;
    let at_middle = constant - slope * (x * x + y * y);
    let mut values = [0.0; VALUES];
    for (q, [m0, m1, m2, m3, m4]) in heights.iter().enumerate() {
        let field = |factor: f64, m: &f64, beyond: &f64| factor * at_middle * m - factor * slope * beyond;
        let [xx, xy, yy] = [x * x, x * y, y * y].map(|factor| field(factor, m0, m2));
        let fields = [*m0, xx, xy, yy, field(x, m1, m3), field(y, m1, m3), field(1.0, m2, m4)];
        fields.iter().enumerate().for_each(|(f, v)| values[2 * f + q] = weight * v);
    }
    values
}

/// Sources of ball `i` of one grain within a cell: its own volume, or its part of the union.
pub fn of_ball(balls: &[Sphere], i: usize, slab: &Slab, push: &mut impl FnMut(Source)) {
    match balls {
        [ball] => of_single(ball, NormalField::of_ball(ball.radius_um), slab, push),
        _ => of_share(balls, i, slab, push),
    }
}

/// Sources of a ball within a cell, with N of its own or of the layer that ends at its surface.
pub fn of_single(ball: &Sphere, normal: NormalField, slab: &Slab, push: &mut impl FnMut(Source)) {
    let [cx, cy, cz] = ball.center_um;
    for (theta, weight) in profile_nodes(cz, ball.radius_um, slab, PROFILE_DEGREE) {
        let (sine, cosine) = theta.sin_cos();
        let r = ball.radius_um * sine;
        let Some(chord) = chord(ball.radius_um * cosine, cz, slab) else { continue };
        let heights = slab.stretch(chord, cz);
        // The trapezoidal rule with a multiple of four points, so that quarter turns change
        // nothing; N increases the degree by two.
        let count = 4 * ((slab.sampling.demands.degree(r) + 3.0) / 4.0).ceil() as usize;
        let area = weight * ball.radius_um * cosine * r * TAU / count as f64;
        for k in 0..count {
            let (s, c) = (TAU * k as f64 / count as f64).sin_cos();
            let values = ball_values([r * c, r * s], normal, &heights, area);
            push(Source { position: [cx + r * c, cy + r * s], values });
        }
    }
}

/// The part of a column ±`half` about the centre that lies in the cell, relative to the centre.
pub(super) fn chord(half: f64, center: f64, slab: &Slab) -> Option<[f64; 2]> {
    let range = [(slab.range_um[0] - center).max(-half), (slab.range_um[1] - center).min(half)];
    (range[1] > range[0]).then_some(range)
}

/// Degree added by the profile's powers of sin θ and cos θ, per radian of half-range.
pub(super) const PROFILE_DEGREE: f64 = 8.0;

/// Nodes θ and weights for columns at R sin θ, 0 ≤ θ ≤ π/2, divided where columns begin to
/// intersect a face of the cell; powers of sin θ and cos θ add `extra` per radian to the degree.
pub(super) fn profile_nodes(center: f64, radius: f64, slab: &Slab, extra: f64) -> Vec<(f64, f64)> {
    let mut breaks = vec![0.0, FRAC_PI_2];
    let faces = slab.range_um.map(|z| (z - center).abs() / radius);
    breaks.extend(faces.into_iter().filter(|&c| c < 1.0).map(f64::acos));
    breaks.sort_by(f64::total_cmp);
    let mut nodes = Vec::new();
    for pair in breaks.windows(2) {
        let middle = 0.5 * (pair[0] + pair[1]);
        let half = 0.5 * (pair[1] - pair[0]);
        if half < 1e-12 || chord(radius * middle.cos(), center, slab).is_none() {
            continue;
        }
        // Sines and cosines of θ up to the fifth power multiply the wave: twice their degree over
        // the half-range.
        let reach = 0.5 * radius * (pair[1].sin() - pair[0].sin());
        let degree = slab.sampling.demands.degree(reach) + extra * half;
        let rule = gauss_rule((0.5 * degree).ceil() as usize + 2);
        nodes.extend(rule.iter().map(|&(x, w)| (middle + half * x, half * w)));
    }
    nodes
}

/// Cuts at heights; a ball's part of a cut is a fan of cones from its centre to the part's edge.
fn of_share(balls: &[Sphere], i: usize, slab: &Slab, push: &mut impl FnMut(Source)) {
    let [x, y, z_center] = balls[i].center_um;
    // The cone's Jacobian and N increase the degree by three.
    share_edges(balls, i, slab.range_um, slab.sampling, &mut |z, weight, edge| {
        let heights = slab.point(z, weight, z_center);
        let points = fan([x, y], edge, slab.sampling, 3.0).into_iter();
        points.for_each(|(place, area)| push(ball_source(&balls[i], place, &heights, area)));
    });
}

/// A source of a ball at a place relative to its centre.
fn ball_source(ball: &Sphere, [x, y]: [f64; 2], heights: &HeightMoments, weight: f64) -> Source {
    let values = ball_values([x, y], NormalField::of_ball(ball.radius_um), heights, weight);
    Source { position: [ball.center_um[0] + x, ball.center_um[1] + y], values }
}

/// A cut as a fan of triangles from a point inside it to its edge: places relative to that point,
/// µm, and areas, µm². What is integrated is of the degree `extra` besides the wave.
pub(super) fn fan(inside: [f64; 2], edge: &Edge, sampling: &Sampling, extra: f64) -> Vec<([f64; 2], f64)> {
    let mut points = Vec::new();
    for point in edge {
        let to = [0, 1].map(|i| point.position[i] - inside[i]);
        let cone = to[0] * point.normal[0] + to[1] * point.normal[1];
        let rule = gauss_of_degree(sampling.demands.degree(0.5 * to[0].hypot(to[1])) + extra).iter();
        let halves = rule.map(|&(x, w)| (0.5 * (1.0 + x), 0.5 * w));
        points.extend(halves.map(|(s, half)| (to.map(|t| s * t), half * s * cone)));
    }
    points
}

/// Lines of a cylinder along y: x relative to its axis with a weight in µm, and all fields.
pub fn of_cylinder(z_um: f64, radius_um: f64, slab: &Slab) -> Vec<(f64, [f64; VALUES])> {
    let mut lines = Vec::new();
    for (theta, weight) in profile_nodes(z_um, radius_um, slab, PROFILE_DEGREE) {
        let (sine, cosine) = theta.sin_cos();
        let Some(chord) = chord(radius_um * cosine, z_um, slab) else { continue };
        let heights = slab.stretch(chord, z_um);
        let normal = NormalField::of_ball(radius_um);
        for x in [-radius_um * sine, radius_um * sine] {
            lines.push((x, ball_values([x, 0.0], normal, &heights, weight * radius_um * cosine)));
        }
    }
    lines
}

/// Indicator χ over a height range, with N = x̂x̂ᵀ for bars and ẑẑᵀ for sheets: a bar's horizontal
/// faces should lie on cell faces.
pub fn of_block([lo, hi]: [f64; 2], slab: &Slab, upright: bool) -> [f64; VALUES] {
    let range = [lo.max(slab.range_um[0]), hi.min(slab.range_um[1])];
    let mut values = [0.0; VALUES];
    if range[1] <= range[0] {
        return values;
    }
    let heights = slab.stretch(range, 0.0);
    let normal = if upright { 1 } else { FIELDS - 1 };
    for (q, [m0, ..]) in heights.iter().enumerate() {
        values[q] = *m0;
        values[2 * normal + q] = *m0;
    }
    values
}
