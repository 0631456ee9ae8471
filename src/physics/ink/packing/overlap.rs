//! Independent check of zero overlap: every pair of spheres that could touch; of convex bodies, the
//! spheres around them, then a direction that separates them.
//!
//! Shares nothing with the packing methods: no grid, no neighbour list, no wrapped copy of
//! positions of theirs; a separating direction is judged by the widths of the forms alone. Spheres
//! are sorted into cells by classes of size, so that the time is nearly proportional to their
//! number, whatever their sizes.

use super::request::are_lengths;
use crate::ink::grains::contact::proven_gap_um;
use crate::ink::{Grain, PackError, Solid, Sphere};
use crate::numerics::vector::norm;
use std::ops::ControlFlow;

/// Overlap by the rounding of coordinates where faces touch, in lengths of the cell.
const ROUNDING: f64 = 1e-14;

struct GridEntry {
    /// Position along x and y within the period.
    x: f64,
    y: f64,
    grain: usize,
    /// Number of the sphere in its grain.
    number: usize,
    sphere: Sphere,
}

/// The spheres of one class of sizes, sorted into cells.
struct SizeClass {
    largest_um: f64,
    /// Numbers of cells along x, y, z.
    count: [usize; 3],
    /// First member of every cell, and the end of the last one.
    start: Vec<u32>,
    /// Entries of all cells, in the order of the cells.
    members: Vec<u32>,
}

/// All spheres of a packing by x, with their places in the cells of their class.
struct SortedSpheres {
    size: [f64; 3],
    walls: bool,
    /// Spheres by increasing x.
    entries: Vec<GridEntry>,
    /// Class of every entry.
    class: Vec<usize>,
    /// By increasing size.
    classes: Vec<SizeClass>,
}

impl SortedSpheres {
    fn new(size: [f64; 3], walls: bool, grains: &[Grain]) -> Self {
        let entries = sorted(size, grains);
        let radii = || entries.iter().map(|e| e.sphere.radius_um);
        let smallest = radii().fold(f64::MAX, f64::min);
        let octave = |radius: f64| ((radius / smallest).log2() as usize).min(MOST_CLASSES - 1);
        let class: Vec<usize> = radii().map(octave).collect();
        let mut spheres = Self { size, walls, entries, class, classes: Vec::new() };
        for k in 0..spheres.class.iter().max().map_or(0, |last| last + 1) {
            let members: Vec<u32> =
                (0..spheres.entries.len() as u32).filter(|&i| spheres.class[i as usize] == k).collect();
            let made = spheres.sorted_into_cells(members);
            spheres.classes.push(made);
        }
        spheres
    }

    fn sorted_into_cells(&self, members: Vec<u32>) -> SizeClass {
        let radius = |i: &u32| self.entries[*i as usize].sphere.radius_um;
        let largest_um = members.iter().map(radius).fold(0.0, f64::max);
        // no finer than a few cells per sphere: few of them need few cells
        let most = 4 * members.len() + 8;
        let edge = (2.0 * largest_um).max(finest_edge(self.size, most as f64));
        let count = self.size.map(|length| ((length / edge) as usize).max(1));
        let mut class = SizeClass { largest_um, count, start: Vec::new(), members: Vec::new() };
        let cells: Vec<usize> =
            members.iter().map(|i| class.cell(self.place_of(*i as usize), self.size)).collect();
        class.start = vec![0; count.iter().product::<usize>() + 1];
        cells.iter().for_each(|cell| class.start[cell + 1] += 1);
        for cell in 1..class.start.len() {
            class.start[cell] += class.start[cell - 1];
        }
        let mut next = class.start.clone();
        class.members = vec![0; members.len()];
        for (i, cell) in members.iter().zip(cells) {
            class.members[next[cell] as usize] = *i;
            next[cell] += 1;
        }
        class
    }

    /// The centre of an entry within the cell; between walls, z as it is.
    fn place_of(&self, i: usize) -> [f64; 3] {
        let GridEntry { x, y, sphere, .. } = &self.entries[i];
        let z = sphere.center_um[2];
        [*x, *y, if self.walls { z } else { z.rem_euclid(self.size[2]) }]
    }

    /// Calls `visit` with every entry whose surface may be closer to that of entry `i` than
    /// `margin_um`, and others near it. Over all i, every pair comes once.
    fn near(
        &self,
        i: usize,
        margin_um: f64,
        mut visit: impl FnMut(usize) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let place = self.place_of(i);
        let radius = self.entries[i].sphere.radius_um;
        for (k, class) in self.classes.iter().enumerate().skip(self.class[i]) {
            let reach = radius + class.largest_um + margin_um;
            if class.members.is_empty() || reach < 0.0 {
                continue;
            }
            let along = |axis: usize| {
                let count = class.count[axis];
                let length = self.size[axis];
                cells_within(place[axis], reach, length / count as f64, count, axis < 2 || !self.walls)
            };
            let xs = along(0);
            let ys = along(1);
            let zs = along(2);
            for cell_z in zs {
                for cell_y in ys.clone() {
                    for cell_x in xs.clone() {
                        let cell = class.number([cell_x, cell_y, cell_z]);
                        let members = class.start[cell] as usize..class.start[cell + 1] as usize;
                        for &j in &class.members[members] {
                            if k > self.class[i] || j as usize > i {
                                visit(j as usize)?;
                            }
                        }
                    }
                }
            }
        }
        ControlFlow::Continue(())
    }
}

/// Edge of cells of which at most `most` fit into a box, however flat or long it is.
fn finest_edge(size: [f64; 3], most: f64) -> f64 {
    let mut sides = size;
    sides.sort_by(|a, b| b.total_cmp(a));
    let [longest, middle, shortest] = sides;
    let along = longest / most;
    let in_plane = (longest * middle / most).sqrt();
    along.max(in_plane).max((longest * middle * shortest / most).cbrt())
}

/// More classes than the sizes of any file have.
const MOST_CLASSES: usize = 64;

impl SizeClass {
    /// Number of the cell at a place along x, y, z.
    fn number(&self, cell: [i64; 3]) -> usize {
        let along = |axis: usize| cell[axis].rem_euclid(self.count[axis] as i64) as usize;
        (along(2) * self.count[1] + along(1)) * self.count[0] + along(0)
    }

    /// Number of the cell that holds a centre; what lies beyond a wall counts to the last cell.
    fn cell(&self, place: [f64; 3], size: [f64; 3]) -> usize {
        let along = |axis: usize| {
            let cell = (place[axis] / size[axis] * self.count[axis] as f64) as i64;
            cell.clamp(0, self.count[axis] as i64 - 1)
        };
        self.number([along(0), along(1), along(2)])
    }
}

/// Cells along an axis that hold places within `reach` of one, each once; numbers beyond the ends
/// are of periodic images.
fn cells_within(
    place: f64,
    reach: f64,
    width: f64,
    count: usize,
    periodic: bool,
) -> std::ops::RangeInclusive<i64> {
    // one part in 10⁹ more: a place may be rounded across the edge of its cell
    let more = 1e-9 * width;
    let first = ((place - reach) / width - more).floor() as i64;
    let last = ((place + reach) / width + more).floor() as i64;
    let end = count as i64 - 1;
    match periodic {
        true if last.saturating_sub(first) >= end => 0..=end,
        true => first..=last,
        false => first.clamp(0, end)..=last.clamp(0, end),
    }
}

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
            let ends = [-1.0, 1.0].map(|side| a.sphere.center_um[2] + side * a.sphere.radius_um);
            let [low, high] = grains[a.grain].solid.as_ref().map_or(ends, |solid| solid.extent_um(2));
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

fn sorted(size: [f64; 3], grains: &[Grain]) -> Vec<GridEntry> {
    let mut entries: Vec<GridEntry> = Vec::new();
    for (grain, Grain { spheres, .. }) in grains.iter().enumerate() {
        for (number, sphere) in spheres.iter().enumerate() {
            let x = sphere.center_um[0].rem_euclid(size[0]);
            let y = sphere.center_um[1].rem_euclid(size[1]);
            entries.push(GridEntry { x, y, grain, number, sphere: *sphere });
        }
    }
    entries.sort_by(|a, b| a.x.total_cmp(&b.x));
    entries
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
mod tests {
    use super::*;
    use crate::ink::Form;
    use crate::numerics::Draws;
    use crate::numerics::vector::Rotation;

    /// All pairs in all their images near the cell: gaps of spheres in closed form.
    fn all_pairs(size: [f64; 3], walls: bool, grains: &[Grain]) -> f64 {
        let images = if walls { 0..=0 } else { -1..=1 };
        let mut least = f64::INFINITY;
        for (i, a) in grains.iter().enumerate() {
            for (b, [x, y]) in grains[..i]
                .iter()
                .flat_map(|b| (-1..=1).flat_map(move |x| (-1..=1).map(move |y| (b, [x, y]))))
            {
                for z in images.clone() {
                    let shift = [f64::from(x), f64::from(y), f64::from(z)];
                    for (s, t) in a.spheres.iter().flat_map(|s| b.spheres.iter().map(move |t| (s, t))) {
                        let apart = [0, 1, 2].map(|k| s.center_um[k] - t.center_um[k] + shift[k] * size[k]);
                        least = least.min(norm(apart) - s.radius_um - t.radius_um);
                    }
                }
            }
            for s in a.spheres.iter().filter(|_| walls) {
                least = least.min((s.center_um[2] - s.radius_um).min(size[2] - s.center_um[2] - s.radius_um));
            }
        }
        least
    }

    /// The smallest gap, or the deepest overlap, against all pairs, in cells of every shape with
    /// sizes over three decades. *Planted*: cells of a class searched one too few, or without the
    /// images across the period.
    #[test]
    fn the_smallest_gap_is_that_of_all_pairs() {
        let mut draws = Draws::new(5, 0);
        for trial in 0..200 {
            let size = [draws.between(0.5, 3.0), draws.between(0.5, 3.0), [0.4, 1.0, 3.0][trial % 3]];
            let walls = trial % 2 == 0;
            let spread = [0.0, 2.0, 6.0][trial / 2 % 3];
            let count = 2 + draws.below(60);
            let mut grain = |_| {
                let radius_um = 0.1 * draws.between(-spread, 0.0).exp();
                let margin = if walls { 0.1 } else { 0.0 };
                let z = draws.between(margin, size[2] - margin);
                let center_um = [draws.between(-size[0], 2.0 * size[0]), draws.between(0.0, size[1]), z];
                // the images near the cell are all that the other way counts
                let center_um = [center_um[0].rem_euclid(size[0]), center_um[1], center_um[2]];
                Grain::new(vec![Sphere { center_um, radius_um }], 0)
            };
            let grains: Vec<Grain> = (0..count).map(&mut grain).collect();
            let (expected, largest) = (
                all_pairs(size, walls, &grains),
                grains.iter().map(|g| g.spheres[0].radius_um).fold(0.0, f64::max),
            );
            let found = match smallest_gap(size, walls, &grains) {
                Ok(gap) => gap.unwrap_or(f64::INFINITY),
                Err(PackError::Overlap { overlap_um, .. }) => -overlap_um,
                Err(other) => panic!("{other}"),
            };
            let expected = if expected > largest { f64::INFINITY } else { expected };
            // identity: the same distances, rounded
            assert!(found == expected || (found - expected).abs() < 1e-12, "{trial}: {found} {expected}");
            if walls {
                let mut deepest = 0.0;
                let mut overlaps = 0;
                let visited = each_overlap(size, &grains, |overlap| {
                    (deepest, overlaps) = (overlap.depth_um.max(deepest), overlaps + 1);
                    ControlFlow::Continue(())
                });
                visited.expect("sound numbers");
                assert!((deepest - (-expected).max(0.0)).abs() < 1e-12, "{trial}: {deepest} {expected}");
                assert_eq!(overlaps > 0, expected < -1e-13, "{trial}");
            }
        }
    }

    /// Long bodies, whose nearest surfaces are not where their centres are nearest.
    #[test]
    fn bodies_are_found_across_the_period() {
        let rod = |x: f64, y: f64| {
            let form = Form::cuboid([0.9, 0.02, 0.02]);
            let turned = Solid { center_um: [x, y, 0.5], form, rotation: Rotation::IDENTITY };
            Grain::convex(turned, 0)
        };
        let gap = smallest_gap([1.0, 1.0, 1.0], true, &[rod(0.05, 0.5), rod(0.95, 0.53)]);
        assert!((gap.expect("apart").expect("close") - 0.01).abs() < 1e-9);
    }
}
