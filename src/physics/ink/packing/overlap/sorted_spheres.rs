//! The spheres of a packing, sorted into cells by classes of size, to find those near each other.

use crate::ink::{Grain, Sphere};
use std::ops::ControlFlow;

/// More classes than the sizes of any file have.
const MOST_CLASSES: usize = 64;

/// A sphere of a packing, with its place along x and y within the period.
pub(super) struct GridEntry {
    /// Position along x and y within the period.
    pub x: f64,
    pub y: f64,
    pub grain: usize,
    /// Number of the sphere in its grain.
    pub number: usize,
    pub sphere: Sphere,
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
pub(super) struct SortedSpheres {
    size: [f64; 3],
    walls: bool,
    /// Spheres by increasing x.
    pub entries: Vec<GridEntry>,
    /// Class of every entry.
    class: Vec<usize>,
    /// By increasing size.
    classes: Vec<SizeClass>,
}

impl SortedSpheres {
    /// Sorts all spheres of a cell with these periods and thickness.
    pub fn new(size: [f64; 3], walls: bool, grains: &[Grain]) -> Self {
        let entries = sorted(size, grains);
        let radii = || entries.iter().map(|e| e.sphere.radius_um);
        let smallest = radii().fold(f64::MAX, f64::min);
        let octave = |radius: f64| ((radius / smallest).log2() as usize).min(MOST_CLASSES - 1);
        let class: Vec<usize> = radii().map(octave).collect();
        let mut spheres = Self { size, walls, entries, class, classes: Vec::new() };
        for k in 0..spheres.class.iter().max().map_or(0, |last| last + 1) {
            let members: Vec<u32> =
                (0..spheres.entries.len() as u32).filter(|&i| spheres.class[i as usize] == k).collect();
            let class = spheres.sorted_into_cells(members);
            spheres.classes.push(class);
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
    pub fn near(
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

/// Edge of cells of which at most `most` fit into a box, however flat or long it is.
fn finest_edge(size: [f64; 3], most: f64) -> f64 {
    let mut sides = size;
    sides.sort_by(|a, b| b.total_cmp(a));
    let [longest, middle, shortest] = sides;
    let along = longest / most;
    let in_plane = (longest * middle / most).sqrt();
    along.max(in_plane).max((longest * middle * shortest / most).cbrt())
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
    let slack = 1e-9 * width;
    let first = ((place - reach) / width - slack).floor() as i64;
    let last = ((place + reach) / width + slack).floor() as i64;
    let end = count as i64 - 1;
    match periodic {
        true if last.saturating_sub(first) >= end => 0..=end,
        true => first..=last,
        false => first.clamp(0, end)..=last.clamp(0, end),
    }
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
