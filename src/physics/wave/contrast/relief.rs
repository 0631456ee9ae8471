//! The space between a rough binder surface and the face beyond it, around the protruding grains.
//!
//! Integration over columns of a raster finer than the grid: in each, the medium of that side fills
//! what lies between the surface s(x, y) and the face except inside grains. Moments along z are
//! exact in every column, so the sampled function is continuous and the raster's aliasing decays
//! fast.

use super::folding::CellCoefficients;
use super::section::extents;
use crate::ink::Solid;
use crate::ink::Sphere;
use crate::numerics::fourier::{PlaneFft, Real};
use crate::numerics::interpolate::bilinear;
use crate::wave::{Element, HeightField};
use gauss_quad::GaussLegendre;

/// The space between a surface and a face of the layer in one cell of the grid, around the grains
/// that the surface leaves bare.
pub(crate) struct OpenSpace<'a> {
    pub surface: &'a HeightField,
    /// z of the face, µm.
    pub face_um: f64,
    pub balls: &'a [Sphere],
    pub solids: &'a [Solid],
    /// Heights of the cell's faces, µm.
    pub range_um: [f64; 2],
    pub element: &'a Element,
    /// Columns along x and y.
    pub count: [usize; 2],
}

/// Raster points per point of the grid's widest harmonics; doubling it changes amplitudes of rough
/// ink by < 1e-5.
const FINER: usize = 4;

/// Columns along x and y for harmonics of the given largest |m| and |n|.
pub(crate) fn raster(widest: [usize; 2]) -> [usize; 2] {
    widest.map(|m| if m == 0 { 1 } else { FINER * (2 * m + 2) })
}

impl OpenSpace<'_> {
    /// Adds the moments of the space to `sum`, harmonics of the grid's widest set, which are
    /// `orders`.
    pub fn add_to<T: Real>(&self, sum: &mut CellCoefficients<T>, orders: &[[i32; 2]]) {
        let count = self.count;
        let fft = PlaneFft::new(count[0], count[1]);
        let mut scratch = fft.scratch();
        let columns = self.column_moments();
        let points = (count[0] * count[1]) as f64;
        for (plane, out) in sum.spectra.iter_mut().enumerate() {
            let values = columns.iter().skip(plane).step_by(self.element.degree + 1);
            scratch.plane.iter_mut().zip(values.clone()).for_each(|(s, m)| *s = T::of(m / points).into());
            sum.means[plane] += values.sum::<f64>() / points;
            fft.forward(&mut scratch, std::slice::from_ref(&(0..count[0])));
            for (value, &[m, n]) in out.iter_mut().zip(orders) {
                let row = m.rem_euclid(count[0] as i32) as usize;
                *value += scratch.spectrum[row * count[1] + n.rem_euclid(count[1] as i32) as usize];
            }
        }
    }

    /// Moments ∫ ψ_p dz over the open part of each column within the cell: columns × planes of the
    /// cell.
    fn column_moments(&self) -> Vec<f64> {
        let [lo, hi] = self.range_um;
        let surface = self.surface;
        let count = self.count;
        let planes = self.element.degree + 1;
        let rule = GaussLegendre::new(planes).expect("at least two nodes");
        let chords = self.chords();
        let mut rest = chords.as_slice();
        let mut all = vec![0.0; count[0] * count[1] * planes];
        for (column, moments) in all.chunks_exact_mut(planes).enumerate() {
            let (blocked, after) = rest.split_at(rest.partition_point(|(k, _)| *k == column));
            rest = after;
            let [x, y] = self.place(column);
            let z = bilinear(&surface.z_um, surface.count, surface.period_um, [x, y]);
            let mut from = z.min(self.face_um).max(lo);
            let to = z.max(self.face_um).min(hi);
            for [start, end] in blocked.iter().map(|(_, chord)| *chord).chain([[to, to]]) {
                self.add_stretch(moments, &rule, [from, start.min(to)]);
                from = from.max(end);
            }
        }
        all
    }

    /// Position of a column, µm.
    fn place(&self, column: usize) -> [f64; 2] {
        let index = [column % self.count[0], column / self.count[0]];
        [0, 1].map(|i| index[i] as f64 / self.count[i] as f64 * self.surface.period_um[i])
    }

    /// Intervals of the columns inside grains that reach into the cell, by column and from the top.
    fn chords(&self) -> Vec<(usize, [f64; 2])> {
        let [lo, hi] = self.range_um;
        let mut chords = Vec::new();
        let near = |b: &&Sphere| b.center_um[2] - b.radius_um < hi && b.center_um[2] + b.radius_um > lo;
        for ball in self.balls.iter().filter(near) {
            for (column, _) in self.crossed(extents(ball)) {
                let chord = chord(ball, self.place(column), self.surface.period_um);
                chords.extend(chord.map(|chord| (column, chord)));
            }
        }
        for solid in self.solids {
            let [low, high] = solid.extent_um(2);
            if low < hi && high > lo {
                for (column, [x, y]) in self.crossed([0, 1].map(|axis| solid.extent_um(axis))) {
                    let chord = solid.chord([x, y, 0.0], [0.0, 0.0, 1.0]);
                    chords.extend(chord.map(|chord| (column, chord)));
                }
            }
        }
        chords.sort_by(|(a, c), (b, d)| a.cmp(b).then(c[0].total_cmp(&d[0])));
        chords
    }

    /// The columns that a grain of the given extents along x and y may intersect, each once, with
    /// their positions beside it, µm.
    fn crossed(&self, extents_um: [[f64; 2]; 2]) -> impl Iterator<Item = (usize, [f64; 2])> + use<> {
        let count = self.count;
        let step = [0, 1].map(|axis| self.surface.period_um[axis] / count[axis] as f64);
        let [columns, rows] = [0, 1].map(|axis| {
            let [first, last] = extents_um[axis].map(|end| end / step[axis]);
            let first = first.floor() as i64;
            first..=(last.ceil() as i64).min(first + count[axis] as i64 - 1)
        });
        let wrapped = move |k: i64, axis: usize| k.rem_euclid(count[axis] as i64) as usize;
        rows.flat_map(move |j| {
            let position = move |i: i64| [i as f64 * step[0], j as f64 * step[1]];
            columns.clone().map(move |i| (wrapped(j, 1) * count[0] + wrapped(i, 0), position(i)))
        })
    }

    fn add_stretch(&self, moments: &mut [f64], rule: &GaussLegendre, [from, to]: [f64; 2]) {
        if to <= from {
            return;
        }
        let [lo, hi] = self.range_um;
        for &(x, w) in rule.as_node_weight_pairs() {
            let z = from + 0.5 * (to - from) * (x + 1.0);
            let psi = self.element.shape_functions((z - lo) / (hi - lo));
            moments.iter_mut().zip(psi).for_each(|(m, p)| *m += 0.5 * (to - from) * w * p);
        }
    }
}

/// Interval of the vertical line at (x, y) inside a ball or its nearest image.
fn chord(ball: &Sphere, [x, y]: [f64; 2], period: [f64; 2]) -> Option<[f64; 2]> {
    let nearest = |d: f64, l: f64| d - l * (d / l).round();
    let dx = nearest(x - ball.center_um[0], period[0]);
    let dy = nearest(y - ball.center_um[1], period[1]);
    let square = ball.radius_um.powi(2) - dx * dx - dy * dy;
    (square > 0.0).then(|| [ball.center_um[2] - square.sqrt(), ball.center_um[2] + square.sqrt()])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ridge along y. The shape functions add up to 1, so the moments of a column add up to the
    /// depth of its vacuum: cubic polynomials are exact with four nodes, rounding remains.
    #[test]
    fn columns_reach_down_to_the_surface_at_their_own_place() {
        let surface = HeightField { z_um: vec![0.1, 0.3], count: [2, 1], period_um: [0.6, 0.4] };
        let element = Element::new(3);
        let surface = &surface;
        let element = &element;
        let range_um = [0.0, 0.4];
        let balls = &[];
        let solids = &[];
        let count = [4, 2];
        let space = OpenSpace { surface, face_um: 0.0, balls, solids, range_um, element, count };
        let moments = space.column_moments();
        let depths: Vec<f64> = moments.chunks_exact(4).map(|column| column.iter().sum::<f64>()).collect();
        assert_eq!(depths.len(), 8);
        for (k, depth) in depths.iter().enumerate() {
            let expected = [0.1, 0.2, 0.3, 0.2][k % 4];
            assert!((depth - expected).abs() < 1e-12, "column {k}: {depth}");
        }
    }
}
