//! Independent check of zero overlap: every pair of spheres that could touch, found by sorting
//! along x; of convex bodies, the spheres around them, then a direction that separates them.
//!
//! Shares nothing with the packing methods: no grid, no neighbour list, no wrapped copy of
//! positions; a separating direction is judged by the widths of the forms alone.

use super::request::are_lengths;
use crate::ink::grains::contact::proven_gap_um;
use crate::ink::{Grain, PackError, Solid, Sphere};
use crate::numerics::vector::norm;

/// Overlap by the rounding of coordinates where faces touch, in lengths of the cell.
const ROUNDING: f64 = 1e-14;

struct GridEntry {
    /// Position along x and y within the period.
    x: f64,
    y: f64,
    grain: usize,
    sphere: Sphere,
}

/// The smallest gap between spheres of different grains and to the walls, if it is below the
/// largest radius.
///
/// Fails with [`PackError::Overlap`] on the worst overlap, and with [`PackError::BadInput`] on
/// non-finite numbers or grains wider than the period.
pub fn smallest_gap(size: [f64; 3], walls: bool, grains: &[Grain]) -> Result<Option<f64>, PackError> {
    check_numbers(size, walls, grains)?;
    // The smallest gap, and the grains that it is between; none is a wall.
    let mut worst = (f64::INFINITY, 0, None);
    let entries = sorted(size, grains);
    let largest = entries.iter().map(|e| e.sphere.radius_um).fold(0.0, f64::max);
    for (i, a) in entries.iter().enumerate() {
        if walls {
            let ends = [-1.0, 1.0].map(|side| a.sphere.center_um[2] + side * a.sphere.radius_um);
            let [low, high] = grains[a.grain].solid.as_ref().map_or(ends, |solid| solid.extent_um(2));
            let to_wall = low.min(size[2] - high);
            if to_wall < worst.0 {
                worst = (to_wall, a.grain, None);
            }
        }
        let window = a.sphere.radius_um + 2.0 * largest;
        for step in 1..entries.len() {
            let wrapped = i + step >= entries.len();
            let b = &entries[(i + step) % entries.len()];
            if b.x + if wrapped { size[0] } else { 0.0 } - a.x > window {
                break;
            }
            // Too far apart in y or z to be closer than the closest pair found.
            let reach = a.sphere.radius_um + b.sphere.radius_um + worst.0;
            let dy = (a.y - b.y).abs();
            let dz = (a.sphere.center_um[2] - b.sphere.center_um[2]).abs();
            let far = dy.min(size[1] - dy) > reach || (walls && dz > reach);
            if !far && a.grain != b.grain {
                let cell = [size[0], size[1], if walls { f64::INFINITY } else { size[2] }];
                let gap = gap([a, b], cell, grains, worst.0);
                if gap < worst.0 {
                    worst = (gap, a.grain, Some(b.grain));
                }
            }
        }
    }
    let (gap, first, second) = worst;
    if gap < -ROUNDING * size[0].max(size[1]).max(size[2]) {
        let second = second.map_or("a wall".to_string(), |grain| format!("grain {grain}"));
        return Err(PackError::Overlap { first: format!("grain {first}"), second, overlap_um: -gap });
    }
    Ok((gap <= largest).then_some(gap.max(0.0)))
}

impl GridEntry {
    /// The convex body that the sphere is around, or the sphere as one.
    fn solid(&self, grains: &[Grain]) -> Solid {
        let round = || Sphere { center_um: [0.0; 3], ..self.sphere }.solid();
        grains[self.grain].solid.clone().unwrap_or_else(round)
    }
}

/// Gap between two entries in their nearest images; a lower bound if it is larger than `known`
/// already.
fn gap([a, b]: [&GridEntry; 2], cell: [f64; 3], grains: &[Grain], known: f64) -> f64 {
    let near: [f64; 3] = std::array::from_fn(|axis| {
        let delta = b.sphere.center_um[axis] - a.sphere.center_um[axis];
        if cell[axis].is_finite() { delta - cell[axis] * (delta / cell[axis]).round() } else { delta }
    });
    let reach = a.sphere.radius_um + b.sphere.radius_um;
    let around = norm(near) - reach;
    if [a, b].iter().all(|e| grains[e.grain].solid.is_none()) || around >= known {
        return around;
    }
    let (one, two) = (a.solid(grains), b.solid(grains));
    // Long bodies may meet in another image than that with the nearest centre.
    let shifted = |axis: usize, k: i32| near[axis] + if k == 0 { 0.0 } else { f64::from(k) * cell[axis] };
    let [xs, ys, zs] = cell.map(|length| if 2.0 * reach > length { -1..=1 } else { 0..=0 });
    let in_plane = xs.flat_map(|i| ys.clone().map(move |j| [i, j]));
    let all = in_plane.flat_map(|[i, j]| zs.clone().map(move |k| [i, j, k]));
    let gaps = all.map(|[i, j, k]| [shifted(0, i), shifted(1, j), shifted(2, k)]).map(|apart| {
        let bound = boxes_gap(&one, &two, apart);
        if bound >= known { bound } else { proven_gap_um(&one, &two, apart) }
    });
    gaps.fold(f64::INFINITY, f64::min)
}

/// Gap between the upright boxes around two bodies, along the axis where it is widest.
fn boxes_gap(one: &Solid, two: &Solid, apart: [f64; 3]) -> f64 {
    let along = |axis: usize| {
        let [a, b] = [one, two].map(|solid| solid.extent_um(axis).map(|x| x - solid.center_um[axis]));
        (apart[axis] + b[0] - a[1]).max(a[0] - apart[axis] - b[1])
    };
    along(0).max(along(1)).max(along(2))
}

fn sorted(size: [f64; 3], grains: &[Grain]) -> Vec<GridEntry> {
    let spheres = grains.iter().enumerate().flat_map(|(grain, g)| g.spheres.iter().map(move |s| (grain, *s)));
    let entry = |(grain, sphere): (usize, Sphere)| {
        let [x, y] = [0, 1].map(|i| sphere.center_um[i].rem_euclid(size[i]));
        GridEntry { x, y, grain, sphere }
    };
    let mut entries: Vec<GridEntry> = spheres.map(entry).collect();
    entries.sort_by(|a, b| a.x.total_cmp(&b.x));
    entries
}

fn check_numbers(lengths: [f64; 3], walls: bool, grains: &[Grain]) -> Result<(), PackError> {
    let (sound, found) = (are_lengths(lengths), format!("{lengths:?} µm"));
    PackError::unless(sound, "period and thickness", found, "finite and above 0", "check the cell")?;
    for (k, grain) in grains.iter().enumerate() {
        let sound = |s: &Sphere| s.center_um.iter().all(|c| c.is_finite()) && s.radius_um > 0.0;
        if grain.spheres.is_empty() || !grain.spheres.iter().all(sound) {
            let found = format!("{:?}", grain.spheres);
            let allowed = "finite centres and radii above 0";
            return Err(PackError::input(format!("grain {k}"), found, allowed, "check the coordinates"));
        }
        for (axis, length) in lengths.iter().enumerate().take(if walls { 2 } else { 3 }) {
            let [low, high] = grain.extent_um(axis);
            if high - low > *length * (1.0 + ROUNDING) {
                let field = format!("extent of grain {k}");
                let allowed = format!("at most the period, {length} µm");
                return Err(PackError::input(field, high - low, allowed, "widen the cell"));
            }
        }
    }
    Ok(())
}
