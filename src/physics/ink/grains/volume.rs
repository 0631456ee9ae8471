//! The volume of a union of spheres, exact for centres on a line and integrated with a standard
//! error otherwise; and volumes of grains between horizontal planes.

use crate::ink::{Solid, Sphere};
use crate::numerics::Draws;
use crate::numerics::vector::{V3, cross, dot, norm, scale, sub};
use std::f64::consts::PI;

/// A volume in µm³ with the standard error of its integration (zero for the closed form).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Volume {
    /// The volume, µm³.
    pub um3: f64,
    /// Its standard error, µm³.
    pub error_um3: f64,
}

/// The volume of the union of `spheres`.
///
/// Centres on one line: closed form (see [`axial`]). Disjoint or touching spheres: the sum of their
/// volumes. Otherwise, chords along z are integrated over the plane by a rank-1 lattice with eight
/// random shifts, whose scatter gives the standard error.
pub fn union_volume(spheres: &[Sphere]) -> Volume {
    if let Some(chain) = on_one_line(spheres) {
        return Volume { um3: axial(&chain), error_um3: 0.0 };
    }
    let overlap = |(i, a): (usize, &Sphere)| spheres[..i].iter().any(|b| a.gap_to(b) < 0.0);
    if !spheres.iter().enumerate().any(overlap) {
        return Volume { um3: spheres.iter().map(Sphere::volume_um3).sum(), error_um3: 0.0 };
    }
    integrated(spheres)
}

/// Positions along the common line and radii, if the centres lie on one line.
fn on_one_line(spheres: &[Sphere]) -> Option<Vec<(f64, f64)>> {
    let origin = spheres.first()?.center_um;
    let arm = |s: &Sphere| sub(s.center_um, origin);
    let farthest: V3 =
        spheres.iter().map(arm).max_by(|a, b| norm(*a).total_cmp(&norm(*b))).unwrap_or_default();
    let length = norm(farthest);
    if length == 0.0 {
        return Some(spheres.iter().map(|s| (0.0, s.radius_um)).collect());
    }
    let axis = scale(farthest, 1.0 / length);
    // Tolerance for the rounding of a rotated chain.
    let straight = spheres.iter().all(|s| norm(cross(arm(s), axis)) <= 1e-12 * length);
    straight.then(|| spheres.iter().map(|s| (dot(arm(s), axis), s.radius_um)).collect())
}

/// Union of spheres centred at x_i on a line: V = π ∫ max_i (R_i² − (x − x_i)²)₊ dx.
///
/// Adding x² turns every parabola into the straight line 2x x_i + R_i² − x_i², so the maximum is an
/// upper envelope of lines and each of its pieces integrates to a cubic.
pub fn axial(chain: &[(f64, f64)]) -> f64 {
    let mut cuts: Vec<f64> = chain.iter().flat_map(|&(x, r)| [x - r, x + r]).collect();
    for (i, &(xa, ra)) in chain.iter().enumerate() {
        for &(xb, rb) in &chain[..i] {
            if xa != xb {
                cuts.push(0.5 * ((xa + xb) + (rb * rb - ra * ra) / (xa - xb)));
            }
        }
    }
    cuts.sort_by(f64::total_cmp);
    PI * cuts.windows(2).map(|w| piece(chain, w[0], w[1])).sum::<f64>()
}

/// ∫ of the uppermost parabola between two breakpoints, where no other one crosses it.
fn piece(chain: &[(f64, f64)], low: f64, high: f64) -> f64 {
    let middle = 0.5 * (low + high);
    let height = |&(x, r): &(f64, f64)| r * r - (middle - x) * (middle - x);
    let Some(top) = chain.iter().max_by(|a, b| height(a).total_cmp(&height(b))) else { return 0.0 };
    if height(top) <= 0.0 {
        return 0.0;
    }
    let (x, r) = *top;
    let cubic = |t: f64| r * r * t - t * t * t / 3.0;
    cubic(high - x) - cubic(low - x)
}

const SHIFTS: usize = 8;
const POINTS: usize = 46_368; // a Fibonacci number: the lattice (1, F_{n-1})/F_n is optimal in the plane
const GENERATOR: usize = 28_657;

fn integrated(spheres: &[Sphere]) -> Volume {
    let bound = |sign: f64, axis: usize| {
        spheres.iter().map(move |s| sign * s.center_um[axis] + s.radius_um).fold(f64::MIN, f64::max)
    };
    let low = [-bound(-1.0, 0), -bound(-1.0, 1)];
    let size = [bound(1.0, 0) - low[0], bound(1.0, 1) - low[1]];
    let mut draws = Draws::new(0, 0);
    let mut chords = Vec::new();
    let means: [f64; SHIFTS] = std::array::from_fn(|_| {
        let shift = [draws.uniform(), draws.uniform()];
        let at = |[u, v]: [f64; 2]| [low[0] + u * size[0], low[1] + v * size[1]];
        lattice_mean(shift, |place| chord_length(spheres, at(place), &mut chords)) * size[0] * size[1]
    });
    let mean = means.iter().sum::<f64>() / SHIFTS as f64;
    let scatter = means.iter().map(|m| (m - mean).powi(2)).sum::<f64>();
    Volume { um3: mean, error_um3: (scatter / (SHIFTS * (SHIFTS - 1)) as f64).sqrt() }
}

/// Mean of a function over the unit square by the rank-1 lattice shifted by `shift`.
#[inline]
fn lattice_mean(shift: [f64; 2], mut f: impl FnMut([f64; 2]) -> f64) -> f64 {
    let value = |k: usize| {
        let u = (k as f64 / POINTS as f64 + shift[0]).fract();
        let v = ((k * GENERATOR % POINTS) as f64 / POINTS as f64 + shift[1]).fract();
        f([u, v])
    };
    (0..POINTS).map(value).sum::<f64>() / POINTS as f64
}

/// Length of the vertical line through (x, y) inside the union.
fn chord_length(spheres: &[Sphere], at: [f64; 2], chords: &mut Vec<[f64; 2]>) -> f64 {
    chords.clear();
    for s in spheres {
        let dx = at[0] - s.center_um[0];
        let dy = at[1] - s.center_um[1];
        let h2 = s.radius_um * s.radius_um - dx * dx - dy * dy;
        if h2 > 0.0 {
            chords.push([s.center_um[2] - h2.sqrt(), s.center_um[2] + h2.sqrt()]);
        }
    }
    merge(chords);
    chords.iter().map(|c| c[1] - c[0]).sum()
}

/// Sorts intervals and merges those that overlap or touch.
pub fn merge(intervals: &mut Vec<[f64; 2]>) {
    intervals.sort_by(|a, b| a[0].total_cmp(&b[0]));
    intervals.dedup_by(|next, kept| {
        let joined = next[0] <= kept[1];
        kept[1] = if joined { kept[1].max(next[1]) } else { kept[1] };
        joined
    });
}

/// Lines per side on which a convex body is sampled.
const LINES: usize = 24;

/// Volume of a grain, µm³, in `slices` of equal height from z = 0: of the convex body where there
/// is one, else of the spheres, each counted by itself.
pub fn in_slices(spheres: &[Sphere], solid: Option<&Solid>, height: f64, slices: usize) -> Vec<f64> {
    if let Some(solid) = solid {
        return of_solid(solid, height, slices);
    }
    let within = |k: usize| {
        let from = k as f64 * height;
        let to = (k + 1) as f64 * height;
        spheres.iter().map(|s| between(s, from, to)).sum()
    };
    (0..slices).map(within).collect()
}

/// Volume of a convex body in every slice, µm³, from its chords along z.
fn of_solid(solid: &Solid, height: f64, slices: usize) -> Vec<f64> {
    let extents = [0, 1].map(|axis| solid.extent_um(axis));
    let step = extents.map(|[low, high]| (high - low) / LINES as f64);
    let mut volumes = vec![0.0; slices];
    for line in 0..LINES * LINES {
        let at = |axis: usize, i: usize| extents[axis][0] + (i as f64 + 0.5) * step[axis];
        let from = [at(0, line % LINES), at(1, line / LINES), 0.0];
        let Some([low, high]) = solid.chord(from, [0.0, 0.0, 1.0]) else { continue };
        for (k, volume) in volumes.iter_mut().enumerate() {
            let bottom = k as f64 * height;
            let top = (k + 1) as f64 * height;
            *volume += step[0] * step[1] * (high.min(top) - low.max(bottom)).max(0.0);
        }
    }
    volumes
}

/// Volume of a sphere between two heights, µm³.
fn between(sphere: &Sphere, from: f64, to: f64) -> f64 {
    let z = sphere.center_um[2];
    let r = sphere.radius_um;
    let low = (from - z).clamp(-r, r);
    let high = (to - z).clamp(-r, r);
    PI * (r * r * (high - low) - (high.powi(3) - low.powi(3)) / 3.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chain(k: usize, spacing: f64) -> Vec<Sphere> {
        (0..k).map(|i| Sphere { center_um: [0.0, 0.0, i as f64 * spacing], radius_um: 1.0 }).collect()
    }

    #[test]
    fn equal_chains_follow_the_lens_formula() {
        for (k, d) in [(1, 1.0), (3, 2.0), (5, 1.0), (9, 0.5), (3, 3.0)] {
            let lens = if d < 2.0 { PI * d - PI * d * d * d / 12.0 } else { 4.0 * PI / 3.0 };
            let expected = 4.0 * PI / 3.0 + (k - 1) as f64 * lens;
            let got = union_volume(&chain(k, d));
            // Identity: cubics of numbers below ten.
            assert!((got.um3 - expected).abs() < 1e-12 * expected, "{k} {d}: {} {expected}", got.um3);
            assert_eq!(got.error_um3, 0.0);
        }
    }

    #[test]
    fn a_sphere_inside_another_adds_nothing() {
        let inner = Sphere { center_um: [0.0, 0.0, 0.2], radius_um: 0.5 };
        let both = union_volume(&[chain(1, 1.0)[0], inner]);
        assert!((both.um3 - 4.0 * PI / 3.0).abs() < 1e-12);
    }

    #[test]
    fn a_bent_cluster_is_integrated_within_its_error_bar() {
        // A right angle of three unit spheres at spacing 1.6: the end spheres are 2.26 apart, so no
        // point is in all three and inclusion–exclusion with two lenses is exact.
        let at = |x: f64, y: f64| Sphere { center_um: [x, y, 0.0], radius_um: 1.0 };
        let got = union_volume(&[at(0.0, 0.0), at(1.6, 0.0), at(0.0, 1.6)]);
        let lens = 4.0 * PI / 3.0 - (PI * 1.6 - PI * 1.6f64.powi(3) / 12.0);
        let expected = 4.0 * PI - 2.0 * lens;
        // Significance: five standard errors; the error itself must be small enough to be useful.
        assert!((got.um3 - expected).abs() < 5.0 * got.error_um3, "{} {expected}", got.um3);
        assert!(got.error_um3 > 0.0 && got.error_um3 < 1e-4 * expected, "{}", got.error_um3);
    }
}
