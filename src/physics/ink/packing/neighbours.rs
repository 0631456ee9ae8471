//! Verlet neighbour lists of spheres, with a skin that keeps them valid over many small steps.

use super::bodies::Bodies;
use super::cell::{grid_cell, grid_count, neighbours};
use crate::numerics::vector::{V3, dot};

/// For each sphere, the spheres of other bodies within reach × (1 + inflation) + skin when the list
/// was built.
pub(crate) struct Neighbours {
    start: Vec<u32>,
    list: Vec<u32>,
    /// Positions when the list was built.
    origin: Vec<V3>,
    skin: f64,
    sorted: Sorted,
}

impl Neighbours {
    pub fn new(bodies: &Bodies, inflation: f64, skin: f64) -> Self {
        let sorted = Sorted::default();
        let mut made = Self { start: Vec::new(), list: Vec::new(), origin: Vec::new(), skin, sorted };
        made.remake(bodies, inflation);
        made
    }

    #[inline(always)]
    pub fn of(&self, sphere: usize) -> &[u32] {
        &self.list[self.start[sphere] as usize..self.start[sphere + 1] as usize]
    }

    /// Whether the sphere has moved by more than its part of the skin.
    #[inline(always)]
    pub fn outrun(&self, bodies: &Bodies, sphere: usize) -> bool {
        let d = bodies.cell.delta(self.origin[sphere], bodies.at[sphere]);
        dot(d, d) > 0.25 * self.skin * self.skin
    }

    /// Narrows the skin if lists stay valid for long, widens it otherwise (`steps` since the last
    /// build).
    pub fn adapt(&mut self, steps: u64, mean_radius: f64) {
        let factor = match steps {
            0..=4 => 1.3,
            5..=11 => 1.0,
            _ => 0.7,
        };
        self.skin = (factor * self.skin).clamp(0.2 * mean_radius, mean_radius);
    }

    pub fn remake(&mut self, bodies: &Bodies, inflation: f64) {
        let n = bodies.spheres();
        let widest = bodies.radius[..n].iter().copied().fold(0.0, f64::max);
        let reach = 2.0 * widest * (1.0 + inflation) + self.skin;
        self.sorted.sort(bodies, grid_count(&bodies.cell, reach, n));
        let sorted = &self.sorted;
        self.origin.clear();
        self.origin.extend_from_slice(&bodies.at[..n]);
        self.start.clear();
        self.list.clear();
        for s in 0..n {
            self.start.push(self.list.len() as u32);
            let (p, owner) = (bodies.at[s], bodies.owner[s]);
            let wide = bodies.radius[s] * (1.0 + inflation) + self.skin;
            for &c in &sorted.near[sorted.cell[s] as usize] {
                for k in sorted.start[c as usize]..sorted.start[c as usize + 1] {
                    let (q, r, t) = sorted.entry[k as usize];
                    let d = bodies.cell.delta(p, q);
                    let cut = wide + r * (1.0 + inflation);
                    if dot(d, d) < cut * cut && bodies.owner[t as usize] != owner {
                        self.list.push(t);
                    }
                }
            }
        }
        self.start.push(self.list.len() as u32);
    }
}

/// Spheres sorted by grid cell (counting sort): position, radius and number side by side.
#[derive(Default)]
struct Sorted {
    count: [usize; 3],
    near: Vec<Vec<u32>>,
    cell: Vec<u32>,
    start: Vec<u32>,
    next: Vec<u32>,
    entry: Vec<(V3, f64, u32)>,
}

impl Sorted {
    fn sort(&mut self, bodies: &Bodies, count: [usize; 3]) {
        let cells: usize = count.iter().product();
        if self.count != count {
            self.count = count;
            self.near = (0..cells).map(|c| neighbours(c, count, &bodies.cell)).collect();
        }
        let n = bodies.spheres();
        let scale: V3 = std::array::from_fn(|a| count[a] as f64 / bodies.cell.size[a]);
        self.cell.clear();
        self.cell.extend(bodies.at[..n].iter().map(|p| grid_cell(*p, scale, count) as u32));
        self.start.clear();
        self.start.resize(cells + 1, 0);
        self.cell.iter().for_each(|c| self.start[*c as usize + 1] += 1);
        for c in 1..self.start.len() {
            self.start[c] += self.start[c - 1];
        }
        self.next.clone_from(&self.start);
        self.entry.resize(n, ([0.0; 3], 0.0, 0));
        for s in 0..n {
            let slot = &mut self.next[self.cell[s] as usize];
            self.entry[*slot as usize] = (bodies.at[s], bodies.radius[s], s as u32);
            *slot += 1;
        }
    }
}

/// Overlap energy of each body.
pub(crate) fn strain(bodies: &Bodies) -> Vec<f64> {
    let list = Neighbours::new(bodies, 0.0, 0.0);
    let mut strain = vec![0.0; bodies.placed];
    for s in 0..bodies.spheres() {
        let p = bodies.at[s];
        let mut push = |depth: f64| strain[bodies.owner[s] as usize] += depth.max(0.0).powi(2);
        if bodies.cell.walls {
            let [low, high] = bodies.extent_z(s);
            push(-2.0 * (p[2] + low).min(bodies.cell.size[2] - p[2] - high));
        }
        for t in list.of(s).iter().map(|t| *t as usize) {
            push(bodies.contact(s, t, bodies.cell.delta(p, bodies.at[t]), 0.0).map_or(0.0, |c| -c.gap_um));
        }
    }
    strain
}
