//! Independent check of zero overlap: every pair of spheres that could touch, found by sorting
//! along x; of convex bodies, the spheres around them, then a direction that separates them.
//!
//! Shares nothing with the packing methods: no grid, no neighbour list, no wrapped copy of
//! positions; a separating direction is judged by the widths of the forms alone.

use super::grain::Grain;
use crate::ink::error::PackError;
use crate::ink::grains::contact::proven_gap_um;
use crate::ink::grains::solid::{Form, Solid};
use crate::ink::grains::sphere::Sphere;

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
pub fn smallest_gap(
    period: [f64; 2],
    thickness: f64,
    walls: bool,
    grains: &[Grain],
) -> Result<Option<f64>, PackError> {
    check_numbers(period, thickness, walls, grains)?;
    let mut worst = Worst { gap: f64::INFINITY, pair: (String::new(), String::new()) };
    let entries = sorted(period, grains);
    let largest = entries.iter().map(|e| e.sphere.radius_um).fold(0.0, f64::max);
    for (i, a) in entries.iter().enumerate() {
        if walls {
            let [low, high] = grains[a.grain].solid.as_ref().map_or(a.ends(), |solid| solid.extent_um(2));
            let to_wall = low.min(thickness - high);
            worst.hear(to_wall, || (format!("grain {}", a.grain), "a wall".into()));
        }
        let window = a.sphere.radius_um + 2.0 * largest;
        for step in 1..entries.len() {
            let wrapped = i + step >= entries.len();
            let b = &entries[(i + step) % entries.len()];
            if b.x + if wrapped { period[0] } else { 0.0 } - a.x > window {
                break;
            }
            // Too far apart in y or z to be closer than the closest pair found.
            let reach = a.sphere.radius_um + b.sphere.radius_um + worst.gap;
            let dy = (a.y - b.y).abs();
            let dz = (a.sphere.center_um[2] - b.sphere.center_um[2]).abs();
            let far = dy.min(period[1] - dy) > reach || (walls && dz > reach);
            if !far && a.grain != b.grain {
                let apart = image(&a.sphere, &b.sphere, period, thickness, walls);
                let gap = gap(a, b, apart, grains, worst.gap);
                worst.hear(gap, || (format!("grain {}", a.grain), format!("grain {}", b.grain)));
            }
        }
    }
    worst.verdict(largest)
}

struct Worst {
    gap: f64,
    pair: (String, String),
}

impl Worst {
    fn hear(&mut self, gap: f64, names: impl FnOnce() -> (String, String)) {
        if gap < self.gap {
            self.gap = gap;
            self.pair = names();
        }
    }

    fn verdict(self, largest: f64) -> Result<Option<f64>, PackError> {
        let (first, second) = self.pair;
        match self.gap {
            gap if gap < 0.0 => Err(PackError::Overlap { first, second, overlap_um: -gap }),
            gap => Ok((gap <= largest).then_some(gap)),
        }
    }
}

impl GridEntry {
    /// Lowest and highest z of the sphere.
    fn ends(&self) -> [f64; 2] {
        [-1.0, 1.0].map(|side| self.sphere.center_um[2] + side * self.sphere.radius_um)
    }

    /// The convex body that the sphere is around, or the sphere as one.
    fn solid(&self, grains: &[Grain]) -> Solid {
        let round = Form::Ellipsoid { semi_axes_um: [self.sphere.radius_um; 3] };
        grains[self.grain].solid.clone().unwrap_or_else(|| Solid::upright(round, [0.0; 3]))
    }
}

/// Gap between two entries with their centres `apart`; that of the spheres around convex bodies if
/// it is larger than `known` already.
fn gap(a: &GridEntry, b: &GridEntry, apart: [f64; 3], grains: &[Grain], known: f64) -> f64 {
    let [dx, dy, dz] = apart;
    let around = (dx * dx + dy * dy + dz * dz).sqrt() - a.sphere.radius_um - b.sphere.radius_um;
    let spheres = [a, b].iter().all(|e| grains[e.grain].solid.is_none());
    if spheres || around >= known {
        return around;
    }
    proven_gap_um(&a.solid(grains), &b.solid(grains), apart)
}

/// Vector from a to the nearest periodic image of b.
fn image(a: &Sphere, b: &Sphere, period: [f64; 2], thickness: f64, walls: bool) -> [f64; 3] {
    let nearest = |d: f64, l: f64| d - l * (d / l).round();
    let dx = nearest(b.center_um[0] - a.center_um[0], period[0]);
    let dy = nearest(b.center_um[1] - a.center_um[1], period[1]);
    let dz = b.center_um[2] - a.center_um[2];
    [dx, dy, if walls { dz } else { nearest(dz, thickness) }]
}

fn sorted(period: [f64; 2], grains: &[Grain]) -> Vec<GridEntry> {
    let spheres = grains.iter().enumerate().flat_map(|(grain, g)| g.spheres.iter().map(move |s| (grain, *s)));
    let entry = |(grain, sphere): (usize, Sphere)| {
        let [x, y] = [0, 1].map(|i| sphere.center_um[i].rem_euclid(period[i]));
        GridEntry { x, y, grain, sphere }
    };
    let mut entries: Vec<GridEntry> = spheres.map(entry).collect();
    entries.sort_by(|a, b| a.x.total_cmp(&b.x));
    entries
}

fn check_numbers(period: [f64; 2], thickness: f64, walls: bool, grains: &[Grain]) -> Result<(), PackError> {
    let lengths = [period[0], period[1], thickness];
    if lengths.iter().any(|l| !(l.is_finite() && *l > 0.0)) {
        let found = format!("{lengths:?} µm");
        return Err(PackError::input("period and thickness", found, "finite and above 0", "check the cell"));
    }
    for (k, grain) in grains.iter().enumerate() {
        let sound = |s: &Sphere| s.center_um.iter().all(|c| c.is_finite()) && s.radius_um > 0.0;
        if grain.spheres.is_empty() || !grain.spheres.iter().all(sound) {
            let found = format!("{:?}", grain.spheres);
            let allowed = "finite centres and radii above 0";
            return Err(PackError::input(format!("grain {k}"), found, allowed, "check the coordinates"));
        }
        let periodic = if walls { 2 } else { 3 };
        for (axis, length) in lengths.iter().enumerate().take(periodic) {
            let end = |sign: f64| grain.spheres.iter().map(move |s| sign * s.center_um[axis] + s.radius_um);
            let extent = end(1.0).fold(f64::MIN, f64::max) + end(-1.0).fold(f64::MIN, f64::max);
            if extent > *length {
                let allowed = format!("at most the period, {length} µm");
                return Err(PackError::input(
                    format!("extent of grain {k}"),
                    extent,
                    allowed,
                    "widen the cell",
                ));
            }
        }
    }
    Ok(())
}
