//! The cell that bodies are placed in, periodic along x and y and between walls or periodic along
//! z; and grids over it.

use crate::numerics::Draws;
use crate::numerics::vector::V3;

/// The cell.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CellBox {
    /// Side lengths, µm.
    pub size: V3,
    pub walls: bool,
    /// Distance beyond which a periodic image is nearer; infinite across walls.
    half: V3,
}

impl CellBox {
    pub fn new(period: [f64; 2], thickness: f64, walls: bool) -> Self {
        let size = [period[0], period[1], thickness];
        let half = [0.5 * size[0], 0.5 * size[1], if walls { f64::INFINITY } else { 0.5 * size[2] }];
        Self { size, walls, half }
    }

    pub fn periodic(&self, axis: usize) -> bool {
        axis < 2 || !self.walls
    }

    /// The image of a place in the cell.
    pub fn wrap(&self, mut p: V3) -> V3 {
        for (axis, (x, size)) in p.iter_mut().zip(&self.size).enumerate() {
            if self.periodic(axis) && !(*x >= 0.0 && *x < *size) {
                *x -= size * (*x / size).floor();
                // A tiny negative number rounds up to the period.
                if *x >= *size {
                    *x = 0.0;
                }
            }
        }
        p
    }

    /// Vector from wrapped a to the nearest image of wrapped b.
    #[inline(always)]
    pub fn delta(&self, a: V3, b: V3) -> V3 {
        let mut d = [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
        for ((d, half), size) in d.iter_mut().zip(&self.half).zip(&self.size) {
            if *d > *half {
                *d -= size;
            } else if *d < -half {
                *d += size;
            }
        }
        d
    }

    /// A uniform place.
    pub fn draw_place(&self, draws: &mut Draws) -> V3 {
        std::array::from_fn(|axis| draws.between(0.0, self.size[axis]))
    }
}

/// Points sorted into the cells of a grid, updated as they come and move one at a time; a sphere
/// can touch only spheres whose centres lie in the neighbouring cells.
pub(crate) struct CellGrid {
    count: [usize; 3],
    cells_per_um: V3,
    /// Points of every grid cell.
    members: Vec<Vec<u32>>,
    /// Grid cell of every point.
    home: Vec<usize>,
    /// Neighbouring cells (including the cell itself), each once even if the grid is narrower than
    /// three cells.
    near: Vec<Vec<u32>>,
}

impl CellGrid {
    /// A grid for `points` points whose cells are at least `reach` wide.
    pub fn new(cell: &CellBox, reach: f64, points: usize) -> Self {
        let count = grid_count(cell, reach, points);
        let cells: usize = count.iter().product();
        Self {
            count,
            cells_per_um: std::array::from_fn(|axis| count[axis] as f64 / cell.size[axis]),
            members: vec![Vec::new(); cells],
            home: vec![0; points],
            near: (0..cells).map(|c| neighbours(c, count, cell)).collect(),
        }
    }

    pub fn cell_of(&self, place: V3) -> usize {
        grid_cell(place, self.cells_per_um, self.count)
    }

    pub fn insert(&mut self, point: usize, place: V3) {
        self.home[point] = self.cell_of(place);
        self.members[self.home[point]].push(point as u32);
    }

    /// Puts a point that has moved into its new cell.
    pub fn follow(&mut self, point: usize, place: V3) {
        let home = self.home[point];
        if home != self.cell_of(place) {
            self.members[home].retain(|member| *member != point as u32);
            self.insert(point, place);
        }
    }

    /// Points in the cells around `cell`.
    #[inline]
    pub fn around(&self, cell: usize) -> impl Iterator<Item = usize> + '_ {
        let lists = self.near[cell].iter().map(|c| &self.members[*c as usize]);
        lists.flat_map(|list| list.iter().map(|point| *point as usize))
    }
}

/// Grid cells per side, at least `reach` wide and at most a few per point: small grains in a wide
/// layer would otherwise fill the memory with empty cells.
pub(crate) fn grid_count(cell: &CellBox, reach: f64, points: usize) -> [usize; 3] {
    let most = (4 * points + 64) as f64;
    let volume: f64 = cell.size.iter().product();
    let edge = reach.max((volume / most).cbrt());
    std::array::from_fn(|axis| (cell.size[axis] / edge).floor().clamp(1.0, most) as usize)
}

/// Number of the grid cell that holds a place.
#[inline]
pub(crate) fn grid_cell(place: V3, cells_per_um: V3, count: [usize; 3]) -> usize {
    let along = |axis: usize| ((place[axis] * cells_per_um[axis]) as usize).min(count[axis] - 1);
    (along(2) * count[1] + along(1)) * count[0] + along(0)
}

/// Indices adjacent to `index` along an axis of `count` cells, including itself, ascending and
/// without repetition.
fn adjacent(index: usize, count: usize, periodic: bool) -> Vec<usize> {
    let n = count as isize;
    let near = (-1..=1).map(|step| index as isize + step).filter(|i| periodic || (0..n).contains(i));
    let mut indices: Vec<usize> = near.map(|i| i.rem_euclid(n) as usize).collect();
    indices.sort_unstable();
    indices.dedup();
    indices
}

/// Cells adjacent to cell `c`, including itself, without repetition, in a fixed order.
pub(crate) fn neighbours(c: usize, count: [usize; 3], cell: &CellBox) -> Vec<u32> {
    let xs = adjacent(c % count[0], count[0], cell.periodic(0));
    let ys = adjacent(c / count[0] % count[1], count[1], cell.periodic(1));
    let zs = adjacent(c / (count[0] * count[1]), count[2], cell.periodic(2));
    let mut all = Vec::with_capacity(27);
    for z in &zs {
        for y in &ys {
            all.extend(xs.iter().map(|x| ((z * count[1] + y) * count[0] + x) as u32));
        }
    }
    all
}
