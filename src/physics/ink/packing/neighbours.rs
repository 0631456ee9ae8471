//! Spheres in the cell, and Verlet lists of their neighbours, with a skin that keeps the lists
//! valid over many small steps.

use super::cell::{CellBox, grid_cell, grid_count, neighbours};
use crate::numerics::vector::{V3, dot};

/// Spheres in the cell, each of them of one body; those of the placed bodies come first.
pub(crate) struct CellSpheres {
    pub cell: CellBox,
    /// Body of every sphere.
    pub owner: Vec<u32>,
    pub radius: Vec<f64>,
    /// Centres, wrapped into the cell.
    pub centre: Vec<V3>,
}

/// Skin of new lists in mean radii: wide enough for a few steps of the largest allowed length (the
/// time of 10 × 10 × 1 µm cases is constant between 0.7 and 1.0).
const SKIN_RADII: f64 = 0.9;

/// For each sphere, the spheres of other bodies within reach × (1 + inflation) + skin when the list
/// was built.
pub(crate) struct NeighbourLists {
    start: Vec<u32>,
    list: Vec<u32>,
    /// Centres when the lists were built.
    origin: Vec<V3>,
    skin: f64,
    mean_radius: f64,
    sorted: SortedCentres,
}

impl NeighbourLists {
    /// Empty lists for small steps of spheres of this mean radius.
    pub fn new(mean_radius: f64) -> Self {
        Self::with_skin(SKIN_RADII * mean_radius, mean_radius)
    }

    /// Lists of the first `count` spheres as they stand, without a skin.
    pub fn of_contacts(spheres: &CellSpheres, count: usize) -> Self {
        let mut lists = Self::with_skin(0.0, 0.0);
        lists.build(spheres, count, 0.0);
        lists
    }

    fn with_skin(skin: f64, mean_radius: f64) -> Self {
        let sorted = SortedCentres::default();
        Self { start: Vec::new(), list: Vec::new(), origin: Vec::new(), skin, mean_radius, sorted }
    }

    #[inline(always)]
    pub fn of_sphere(&self, sphere: usize) -> &[u32] {
        &self.list[self.start[sphere] as usize..self.start[sphere + 1] as usize]
    }

    /// Whether the sphere has moved by more than its part of the skin.
    #[inline(always)]
    pub fn is_outrun(&self, spheres: &CellSpheres, sphere: usize) -> bool {
        let d = spheres.cell.delta(self.origin[sphere], spheres.centre[sphere]);
        dot(d, d) > 0.25 * self.skin * self.skin
    }

    /// Narrows the skin if lists stay valid for long, widens it otherwise (`steps` since the last
    /// build).
    pub fn adapt_skin(&mut self, steps: u64) {
        let factor = match steps {
            0..=4 => 1.3,
            5..=11 => 1.0,
            _ => 0.7,
        };
        self.skin = (factor * self.skin).clamp(0.2 * self.mean_radius, self.mean_radius);
    }

    /// Builds the lists of the first `count` spheres, with radii larger by the part `inflation`.
    pub fn build(&mut self, spheres: &CellSpheres, count: usize, inflation: f64) {
        let widest = spheres.radius[..count].iter().copied().fold(0.0, f64::max);
        let cell_width = 2.0 * widest * (1.0 + inflation) + self.skin;
        self.sorted.sort(spheres, count, grid_count(&spheres.cell, cell_width, count));
        self.origin.clear();
        self.origin.extend_from_slice(&spheres.centre[..count]);
        self.start.clear();
        self.list.clear();
        let sorted = &self.sorted;
        for s in 0..count {
            self.start.push(self.list.len() as u32);
            let centre = spheres.centre[s];
            let reach = spheres.radius[s] * (1.0 + inflation) + self.skin;
            for &cell in &sorted.near[sorted.cell[s] as usize] {
                for other in sorted.in_cell(cell) {
                    let d = spheres.cell.delta(centre, other.centre);
                    let cutoff = reach + other.radius * (1.0 + inflation);
                    if dot(d, d) < cutoff * cutoff && spheres.owner[other.number as usize] != spheres.owner[s]
                    {
                        self.list.push(other.number);
                    }
                }
            }
        }
        self.start.push(self.list.len() as u32);
    }
}

/// A sphere, its data side by side in memory.
#[derive(Clone, Copy, Default)]
struct SortedCentre {
    centre: V3,
    radius: f64,
    number: u32,
}

/// Spheres sorted by grid cell (counting sort).
#[derive(Default)]
struct SortedCentres {
    count: [usize; 3],
    /// Neighbouring cells of every cell, including itself.
    near: Vec<Vec<u32>>,
    /// Cell of every sphere.
    cell: Vec<u32>,
    /// First entry of every cell, and the end of the last one.
    start: Vec<u32>,
    next: Vec<u32>,
    entries: Vec<SortedCentre>,
}

impl SortedCentres {
    #[inline(always)]
    fn in_cell(&self, cell: u32) -> &[SortedCentre] {
        &self.entries[self.start[cell as usize] as usize..self.start[cell as usize + 1] as usize]
    }

    fn sort(&mut self, spheres: &CellSpheres, spheres_in_place: usize, count: [usize; 3]) {
        let cells: usize = count.iter().product();
        if self.count != count {
            self.count = count;
            self.near = (0..cells).map(|c| neighbours(c, count, &spheres.cell)).collect();
        }
        let cells_per_um: V3 = std::array::from_fn(|axis| count[axis] as f64 / spheres.cell.size[axis]);
        let centres = &spheres.centre[..spheres_in_place];
        self.cell.clear();
        self.cell.extend(centres.iter().map(|p| grid_cell(*p, cells_per_um, count) as u32));
        self.start.clear();
        self.start.resize(cells + 1, 0);
        self.cell.iter().for_each(|c| self.start[*c as usize + 1] += 1);
        for c in 1..self.start.len() {
            self.start[c] += self.start[c - 1];
        }
        self.next.clone_from(&self.start);
        self.entries.resize(spheres_in_place, SortedCentre::default());
        for (s, centre) in centres.iter().enumerate() {
            let place = &mut self.next[self.cell[s] as usize];
            let entry = SortedCentre { centre: *centre, radius: spheres.radius[s], number: s as u32 };
            self.entries[*place as usize] = entry;
            *place += 1;
        }
    }
}
