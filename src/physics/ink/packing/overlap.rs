//! Independent check of zero overlap: every pair of spheres that could touch; of convex bodies, the
//! spheres around them, then a direction that separates them.
//!
//! Shares nothing with the packing methods: no grid, no neighbour list, no wrapped copy of
//! positions of theirs; a separating direction is judged by the widths of the forms alone. Spheres
//! are sorted into cells by classes of size, so that the time is nearly proportional to their
//! number, whatever their sizes.

mod sorted_spheres;

use super::request::are_lengths;
use crate::ink::grains::contact::proven_gap_um;
use crate::ink::{Grain, PackError, Solid, Sphere};
use crate::numerics::vector::norm;
use sorted_spheres::{GridEntry, SortedSpheres};
use std::ops::ControlFlow;

/// Overlap by the rounding of coordinates where faces touch, in lengths of the cell.
const ROUNDING: f64 = 1e-14;

/// The smallest gap between spheres of different grains and to the walls, if it is below the
/// largest radius.
///
/// Fails with [`PackError::Overlap`] on the worst overlap, and with [`PackError::BadInput`] on
/// non-finite numbers or grains wider than the period.
pub fn smallest_gap(size: [f64; 3], walls: bool, grains: &[Grain]) -> Result<Option<f64>, PackError> {
    check_numbers(size, walls, grains)?;
    let mut worst = SmallestGap { gap_um: f64::INFINITY, first: 0, second: None };
    let spheres = SortedSpheres::new(size, walls, grains);
    let entries = &spheres.entries;
    let largest = entries.iter().map(|e| e.sphere.radius_um).fold(0.0, f64::max);
    let cell = [size[0], size[1], if walls { f64::INFINITY } else { size[2] }];
    for (i, a) in entries.iter().enumerate() {
        if walls {
            let Sphere { center_um: [.., z], radius_um } = a.sphere;
            let solid = grains[a.grain].solid.as_ref();
            let [low, high] = solid.map_or([z - radius_um, z + radius_um], |solid| solid.extent_um(2));
            let to_wall = low.min(size[2] - high);
            if to_wall < worst.gap_um {
                worst = SmallestGap { gap_um: to_wall, first: a.grain, second: None };
            }
        }
        let _: ControlFlow<()> = spheres.near(i, worst.gap_um.min(largest), |j| {
            let first = &entries[i.min(j)];
            let second = &entries[i.max(j)];
            if first.grain != second.grain {
                // the later one along x seen from the earlier one, and the other way round
                let ahead = second.x - first.x;
                for (from, to, apart) in [(first, second, ahead), (second, first, size[0] - ahead)] {
                    if apart <= from.sphere.radius_um + 2.0 * largest {
                        let gap_um = gap(from, to, cell, grains, worst.gap_um);
                        if gap_um < worst.gap_um {
                            worst = SmallestGap { gap_um, first: from.grain, second: Some(to.grain) };
                        }
                    }
                }
            }
            ControlFlow::Continue(())
        });
    }
    let SmallestGap { gap_um, first, second } = worst;
    if gap_um < -ROUNDING * size[0].max(size[1]).max(size[2]) {
        let second = second.map_or("a wall".to_string(), |grain| format!("grain {grain}"));
        return Err(PackError::Overlap { first: format!("grain {first}"), second, overlap_um: -gap_um });
    }
    Ok((gap_um <= largest).then_some(gap_um.max(0.0)))
}

/// The smallest gap so far.
struct SmallestGap {
    gap_um: f64,
    /// One of the grains that it is between.
    first: usize,
    /// The other one; `None` for a wall.
    second: Option<usize>,
}

/// A sphere of a grain, by number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SphereOfGrain {
    /// Number of the grain.
    pub grain: usize,
    /// Number of the sphere in the grain.
    pub sphere: usize,
}

/// Two spheres of different grains that overlap, or a sphere and a wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SphereOverlap {
    /// One of the spheres.
    pub first: SphereOfGrain,
    /// The other one; `None` for a wall.
    pub second: Option<SphereOfGrain>,
    /// Depth of the overlap, µm.
    pub depth_um: f64,
}

/// Calls `visit` with every overlap of grains made of spheres that exceeds rounding, in a cell with
/// periods and thickness `size` and walls at its faces, until it breaks.
///
/// # Errors
/// [`PackError::BadInput`] on numbers that are not finite, and grains wider than the period.
pub fn each_overlap(
    size: [f64; 3],
    grains: &[Grain],
    mut visit: impl FnMut(SphereOverlap) -> ControlFlow<()>,
) -> Result<(), PackError> {
    check_numbers(size, true, grains)?;
    let spheres = SortedSpheres::new(size, true, grains);
    let slack = ROUNDING * size[0].max(size[1]).max(size[2]);
    let named = |entry: &GridEntry| SphereOfGrain { grain: entry.grain, sphere: entry.number };
    for (i, a) in spheres.entries.iter().enumerate() {
        let z = a.sphere.center_um[2];
        let radius = a.sphere.radius_um;
        let depth_um = (radius - z).max(z + radius - size[2]);
        if depth_um > slack && visit(SphereOverlap { first: named(a), second: None, depth_um }).is_break() {
            return Ok(());
        }
        let ended = spheres.near(i, 0.0, |j| {
            let b = &spheres.entries[j];
            let depth_um = -gap(a, b, [size[0], size[1], f64::INFINITY], grains, f64::INFINITY);
            if a.grain == b.grain || depth_um <= slack {
                return ControlFlow::Continue(());
            }
            visit(SphereOverlap { first: named(a), second: Some(named(b)), depth_um })
        });
        if ended.is_break() {
            return Ok(());
        }
    }
    Ok(())
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
fn gap(a: &GridEntry, b: &GridEntry, cell: [f64; 3], grains: &[Grain], known: f64) -> f64 {
    let near: [f64; 3] = std::array::from_fn(|axis| {
        let delta = b.sphere.center_um[axis] - a.sphere.center_um[axis];
        if cell[axis].is_finite() { delta - cell[axis] * (delta / cell[axis]).round() } else { delta }
    });
    let reach = a.sphere.radius_um + b.sphere.radius_um;
    let around = norm(near) - reach;
    if [a, b].iter().all(|e| grains[e.grain].solid.is_none()) || around >= known {
        return around;
    }
    let one = a.solid(grains);
    let two = b.solid(grains);
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
        let about_centre = |solid: &Solid| solid.extent_um(axis).map(|x| x - solid.center_um[axis]);
        let [one_low, one_high] = about_centre(one);
        let [two_low, two_high] = about_centre(two);
        (apart[axis] + two_low - one_high).max(one_low - apart[axis] - two_high)
    };
    along(0).max(along(1)).max(along(2))
}

fn check_numbers(lengths: [f64; 3], walls: bool, grains: &[Grain]) -> Result<(), PackError> {
    let sound = are_lengths(lengths);
    let found = format!("{lengths:?} µm");
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

#[cfg(test)]
#[path = "overlap_tests.rs"]
mod tests;
