//! The cell that bodies are placed in, and a grid of spheres over it, updated at single insertions
//! and moves (sequential addition, Monte Carlo).

use crate::numerics::Draws;
use crate::numerics::vector::V3;

/// The cell: side lengths, and the distance beyond which a periodic image is nearer (infinite
/// across walls).
#[derive(Clone, Copy, Debug)]
pub(crate) struct CellBox {
    pub size: V3,
    pub walls: bool,
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

    pub fn wrap(&self, mut p: V3) -> V3 {
        for (a, (x, size)) in p.iter_mut().zip(&self.size).enumerate() {
            if self.periodic(a) && !(*x >= 0.0 && *x < *size) {
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
        std::array::from_fn(|a| draws.between(0.0, self.size[a]))
    }
}

/// Spheres by grid cell; a sphere can touch only spheres of the neighbouring cells.
pub(crate) struct Buckets {
    count: [usize; 3],
    scale: V3,
    members: Vec<Vec<u32>>,
    /// Cell of every sphere.
    home: Vec<usize>,
    /// Neighbouring cells (including the cell itself), each once even if the grid is narrower than
    /// three cells.
    near: Vec<Vec<u32>>,
}

impl Buckets {
    /// A grid for `points` spheres whose cells are at least `reach` wide.
    pub fn new(cell: &CellBox, reach: f64, points: usize) -> Self {
        let count = grid_count(cell, reach, points);
        let scale = std::array::from_fn(|a| count[a] as f64 / cell.size[a]);
        let cells = count.iter().product();
        let near = (0..cells).map(|c| neighbours(c, count, cell)).collect();
        Self { count, scale, members: vec![Vec::new(); cells], home: vec![0; points], near }
    }

    pub fn cell_of(&self, p: V3) -> usize {
        grid_cell(p, self.scale, self.count)
    }

    pub fn insert(&mut self, sphere: usize, at: V3) {
        self.home[sphere] = self.cell_of(at);
        self.members[self.home[sphere]].push(sphere as u32);
    }

    /// Puts a sphere that has moved into its new cell.
    pub fn follow(&mut self, sphere: usize, at: V3) {
        let home = self.home[sphere];
        if home != self.cell_of(at) {
            self.members[home].retain(|s| *s != sphere as u32);
            self.insert(sphere, at);
        }
    }

    /// Spheres in the cells around `cell`.
    #[inline]
    pub fn around(&self, cell: usize) -> impl Iterator<Item = usize> + '_ {
        let lists = self.near[cell].iter().map(|c| &self.members[*c as usize]);
        lists.flat_map(|list| list.iter().map(|s| *s as usize))
    }
}

/// Grid cells per side, at least `reach` wide and at most a few per point: small grains in a wide
/// layer would otherwise fill the memory with empty cells.
pub(crate) fn grid_count(cell: &CellBox, reach: f64, points: usize) -> [usize; 3] {
    let most = (4 * points + 64) as f64;
    let volume: f64 = cell.size.iter().product();
    let wide = reach.max((volume / most).cbrt());
    std::array::from_fn(|a| (cell.size[a] / wide).floor().clamp(1.0, most) as usize)
}

/// Number of the grid cell that holds a place; `scale` is the number of cells per length.
#[inline]
pub(crate) fn grid_cell(p: V3, scale: V3, count: [usize; 3]) -> usize {
    let [x, y, z] = [0, 1, 2].map(|a| ((p[a] * scale[a]) as usize).min(count[a] - 1));
    (z * count[1] + y) * count[0] + x
}

/// Indices adjacent to `place` along an axis of `count` cells, including itself, ascending and
/// without repetition.
fn along(place: usize, count: usize, periodic: bool) -> Vec<usize> {
    let n = count as isize;
    let near = (-1..=1).map(|step| place as isize + step).filter(|i| periodic || (0..n).contains(i));
    let mut found: Vec<usize> = near.map(|i| i.rem_euclid(n) as usize).collect();
    found.sort_unstable();
    found.dedup();
    found
}

/// Cells adjacent to cell `c`, including itself, without repetition, in a fixed order.
pub(crate) fn neighbours(c: usize, count: [usize; 3], cell: &CellBox) -> Vec<u32> {
    let place = [c % count[0], c / count[0] % count[1], c / (count[0] * count[1])];
    let [xs, ys, zs] = [0, 1, 2].map(|a| along(place[a], count[a], cell.periodic(a)));
    let mut all = Vec::with_capacity(27);
    for z in &zs {
        for y in &ys {
            all.extend(xs.iter().map(|x| ((z * count[1] + y) * count[0] + x) as u32));
        }
    }
    all
}
