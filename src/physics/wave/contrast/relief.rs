//! The space between a rough binder surface and the face beyond it, around the protruding grains.
//!
//! Integration over columns of a raster finer than the grid: in each, the medium of that side fills
//! what lies between the surface s(x, y) and the face except inside grains. Moments along z are
//! exact in every column, so the sampled function is continuous and the raster's aliasing decays
//! fast.

use super::folding::CellCoefficients;
use super::section::extents;
use crate::ink::Solid;
use crate::numerics::fourier::{PlaneFft, Real};
use crate::numerics::periodic::bilinear;
use crate::wave::grid::element::Element;
use crate::wave::scene::{Ball, HeightField};
use gauss_quad::GaussLegendre;

/// Geometry and grid of one cell for the integration over columns.
pub(crate) struct CellColumns<'a> {
    pub range_um: [f64; 2],
    pub element: &'a Element,
    pub orders: &'a [[i32; 2]],
    /// Largest |m| and |n| of the harmonics.
    pub widest: [usize; 2],
}

/// Balls and convex bodies that a surface leaves bare.
type Grains<'a> = (&'a [Ball], &'a [Solid]);

/// Raster points per point of the grid's widest harmonics; doubling it changes amplitudes of rough
/// ink by < 1e-5.
const FINER: usize = 4;

/// Adds the moments of the space between a surface and the face at z = `face_um` in one cell to
/// `planes` (harmonics of the grid's widest set).
pub(crate) fn add_open<T: Real>(
    (surface, face_um): (&HeightField, f64),
    grains: Grains,
    cell: &CellColumns,
    sum: &mut CellCoefficients<T>,
) {
    let count = cell.widest.map(|m| if m == 0 { 1 } else { FINER * (2 * m + 2) });
    let fft = PlaneFft::new(count[0], count[1]);
    let mut scratch = fft.scratch();
    let columns = column_moments((surface, face_um), grains, cell, count);
    let points = (count[0] * count[1]) as f64;
    for (plane, out) in sum.spectra.iter_mut().enumerate() {
        let values = columns.iter().skip(plane).step_by(cell.element.degree + 1);
        scratch.plane.iter_mut().zip(values.clone()).for_each(|(s, m)| *s = T::of(m / points).into());
        sum.means[plane] += values.sum::<f64>() / points;
        fft.forward(&mut scratch, std::slice::from_ref(&(0..count[0])));
        for (value, &[m, n]) in out.iter_mut().zip(cell.orders) {
            let row = m.rem_euclid(count[0] as i32) as usize;
            *value += scratch.spectrum[row * count[1] + n.rem_euclid(count[1] as i32) as usize];
        }
    }
}

/// Moments ∫ ψ_p dz over the open part of each column within the cell: columns × planes of the
/// cell.
fn column_moments(
    (surface, face_um): (&HeightField, f64),
    grains: Grains,
    cell: &CellColumns,
    count: [usize; 2],
) -> Vec<f64> {
    let [lo, hi] = cell.range_um;
    let planes = cell.element.degree + 1;
    let rule = GaussLegendre::new(planes).expect("at least two nodes");
    let chords = chords(grains, cell, surface.period_um, count);
    let mut rest = chords.as_slice();
    let mut all = vec![0.0; count[0] * count[1] * planes];
    for (column, moments) in all.chunks_exact_mut(planes).enumerate() {
        let here = rest.partition_point(|(k, _)| *k == column);
        let (blocked, after) = rest.split_at(here);
        rest = after;
        let [x, y] = place(column, count, surface.period_um);
        let z = bilinear(&surface.z_um, surface.count, surface.period_um, [x, y]);
        let (mut from, to) = (z.min(face_um).max(lo), z.max(face_um).min(hi));
        for [start, end] in blocked.iter().map(|(_, chord)| *chord).chain([[to, to]]) {
            add_stretch(moments, cell, &rule, [from, start.min(to)]);
            from = from.max(end);
        }
    }
    all
}

/// Position of a column, µm.
fn place(column: usize, count: [usize; 2], period_um: [f64; 2]) -> [f64; 2] {
    let index = [column % count[0], column / count[0]];
    [0, 1].map(|i| index[i] as f64 / count[i] as f64 * period_um[i])
}

/// Intervals of the columns inside grains that reach into the cell, by column and from the top.
fn chords(
    (balls, solids): Grains,
    cell: &CellColumns,
    period_um: [f64; 2],
    count: [usize; 2],
) -> Vec<(usize, [f64; 2])> {
    let [lo, hi] = cell.range_um;
    let mut chords = Vec::new();
    let near = |b: &&Ball| b.center_um[2] - b.radius_um < hi && b.center_um[2] + b.radius_um > lo;
    for ball in balls.iter().filter(near) {
        for (column, _) in crossed(extents(ball), period_um, count) {
            let [x, y] = place(column, count, period_um);
            chords.extend(chord(ball, x, y, period_um).map(|chord| (column, chord)));
        }
    }
    for solid in solids {
        let [low, high] = solid.extent_um(2);
        if low < hi && high > lo {
            let extents = [0, 1].map(|axis| solid.extent_um(axis));
            for (column, [x, y]) in crossed(extents, period_um, count) {
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
fn crossed(
    extents_um: [[f64; 2]; 2],
    period_um: [f64; 2],
    count: [usize; 2],
) -> impl Iterator<Item = (usize, [f64; 2])> {
    let step = [0, 1].map(|axis| period_um[axis] / count[axis] as f64);
    let [columns, rows] = [0, 1].map(|axis| {
        let [first, last] = extents_um[axis].map(|end| end / step[axis]);
        let first = first.floor() as i64;
        first..=(last.ceil() as i64).min(first + count[axis] as i64 - 1)
    });
    let wrapped = move |k: i64, axis: usize| k.rem_euclid(count[axis] as i64) as usize;
    rows.flat_map(move |j| {
        let at = move |i: i64| [i as f64 * step[0], j as f64 * step[1]];
        columns.clone().map(move |i| (wrapped(j, 1) * count[0] + wrapped(i, 0), at(i)))
    })
}

/// Interval of the vertical line at (x, y) inside a ball or its nearest image.
fn chord(ball: &Ball, x: f64, y: f64, period: [f64; 2]) -> Option<[f64; 2]> {
    let nearest = |d: f64, l: f64| d - l * (d / l).round();
    let dx = nearest(x - ball.center_um[0], period[0]);
    let dy = nearest(y - ball.center_um[1], period[1]);
    let square = ball.radius_um.powi(2) - dx * dx - dy * dy;
    (square > 0.0).then(|| [ball.center_um[2] - square.sqrt(), ball.center_um[2] + square.sqrt()])
}

fn add_stretch(moments: &mut [f64], cell: &CellColumns, rule: &GaussLegendre, [from, to]: [f64; 2]) {
    if to <= from {
        return;
    }
    let [lo, hi] = cell.range_um;
    for &(x, w) in rule.as_node_weight_pairs() {
        let z = from + 0.5 * (to - from) * (x + 1.0);
        let psi = cell.element.shape_functions((z - lo) / (hi - lo));
        moments.iter_mut().zip(psi).for_each(|(m, p)| *m += 0.5 * (to - from) * w * p);
    }
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
        let cell = CellColumns { range_um: [0.0, 0.4], element: &element, orders: &[], widest: [0, 0] };
        let moments = column_moments((&surface, 0.0), (&[], &[]), &cell, [4, 2]);
        let depths: Vec<f64> = moments.chunks_exact(4).map(|column| column.iter().sum::<f64>()).collect();
        assert_eq!(depths.len(), 8);
        for (k, depth) in depths.iter().enumerate() {
            let expected = [0.1, 0.2, 0.3, 0.2][k % 4];
            assert!((depth - expected).abs() < 1e-12, "column {k}: {depth}");
        }
    }
}
