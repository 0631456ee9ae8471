//! Pairs of grain centres: pair correlation g(r) and nearest neighbours.

use crate::ink::packing::cell::{CellBox, CellGrid};
use crate::ink::{Grain, Packing};
use crate::numerics::vector::{V3, norm};
use std::f64::consts::PI;

/// Pair counts of one packing in shells of equal width, with those of an ideal gas.
#[derive(Clone, Debug, PartialEq)]
pub struct PairStatistics {
    /// Shell edges, µm.
    pub edges_um: Vec<f64>,
    /// Number of pairs of centres in each shell, of which one is sampled.
    pub counts: Vec<f64>,
    /// Expected counts for the same number of uniformly distributed points (between the walls, if
    /// any).
    pub ideal: Vec<f64>,
    /// Distance from each sampled centre to its nearest neighbour, µm.
    pub nearest_um: Vec<f64>,
    /// Centres whose neighbours were counted, of all.
    pub sampled: SampledCentres,
}

/// How many of the centres had their neighbours counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SampledCentres {
    /// Those that had.
    pub counted: usize,
    /// All of them.
    pub all: usize,
}

impl PairStatistics {
    /// Pair correlation g in each shell, averaged over the shell's volume.
    pub fn g(&self) -> Vec<f64> {
        self.counts.iter().zip(&self.ideal).map(|(c, i)| if *i > 0.0 { c / i } else { 0.0 }).collect()
    }

    /// Mean distance from a centre to its nearest neighbour, µm.
    pub fn mean_nearest_um(&self) -> f64 {
        self.nearest_um.iter().sum::<f64>() / self.nearest_um.len().max(1) as f64
    }
}

/// Mean diameter of the spheres of equal volume, µm: the length unit of the shells.
pub fn mean_diameter_um(packing: &Packing) -> f64 {
    let n = packing.grains().len().max(1) as f64;
    packing.grains().iter().map(|g| (6.0 * g.volume_um3 / PI).cbrt()).sum::<f64>() / n
}

/// Pair statistics in shells of `width` up to `furthest`, both in mean diameters, at most half the
/// period.
pub fn pair_statistics_to(packing: &Packing, width: f64, furthest: f64) -> PairStatistics {
    let d = mean_diameter_um(packing);
    pair_statistics(packing, width * d, furthest * d)
}

/// Pair statistics in shells given in µm, comparable between realisations of different grains.
pub fn pair_statistics(packing: &Packing, width_um: f64, furthest_um: f64) -> PairStatistics {
    let cell = CellBox::new(packing.period_um(), packing.thickness_um(), packing.walls());
    let half = (0..3).filter(|a| cell.periodic(*a)).map(|a| 0.5 * cell.size[a]).fold(f64::MAX, f64::min);
    // The small addition keeps rounding from losing the last shell of 3.0 / 0.02.
    let shells = (half.min(furthest_um) / width_um + 1e-9).floor() as usize;
    let edges_um: Vec<f64> = (0..=shells).map(|i| i as f64 * width_um).collect();
    let centres: Vec<V3> = packing.grains().iter().map(|g| cell.wrap(g.centre_um())).collect();
    let n = centres.len() as f64;
    let expected = ideal_share(packing, &edges_um);
    let share = |w: &[f64]| w[1] - w[0];
    let step = centres.len().div_ceil(MOST_CENTRES).max(1);
    if step == 1 {
        let (counts, nearest_um) = count(&cell, &centres, &edges_um, width_um);
        let ideal = expected.windows(2).map(|w| 0.5 * n * (n - 1.0) * share(w)).collect();
        let sampled = SampledCentres { counted: centres.len(), all: centres.len() };
        return PairStatistics { edges_um, counts, ideal, nearest_um, sampled };
    }
    let (counts, nearest_um) = count_sampled(&cell, &centres, step, &edges_um);
    let sampled = SampledCentres { counted: nearest_um.len(), all: centres.len() };
    let ideal = expected.windows(2).map(|w| sampled.counted as f64 * (n - 1.0) * share(w)).collect();
    PairStatistics { edges_um, counts, ideal, nearest_um, sampled }
}

/// More centres than this are sampled: some hundred neighbours of each give g to a thousandth.
const MOST_CENTRES: usize = 100_000;

fn count(cell: &CellBox, centres: &[V3], edges: &[f64], width: f64) -> (Vec<f64>, Vec<f64>) {
    let furthest = edges.last().copied().unwrap_or(0.0).max(width);
    let mut counts = vec![0.0; edges.len().saturating_sub(1)];
    let mut nearest = vec![f64::INFINITY; centres.len()];
    let mut grid = CellGrid::new(cell, furthest, centres.len());
    for (i, p) in centres.iter().enumerate() {
        for j in grid.around(grid.cell_of(*p)) {
            let r = norm(cell.delta(*p, centres[j]));
            nearest[i] = nearest[i].min(r);
            nearest[j] = nearest[j].min(r);
            if let Some(slot) = counts.get_mut((r / width) as usize) {
                *slot += 1.0;
            }
        }
        grid.insert(i, *p);
    }
    seek_further(cell, centres, furthest, &mut nearest);
    (counts, nearest)
}

/// Counts of the pairs of every `step`-th centre with all others, and the nearest of these.
fn count_sampled(cell: &CellBox, centres: &[V3], step: usize, edges: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let width = edges.get(1).copied().unwrap_or(1.0);
    let furthest = edges.last().copied().unwrap_or(0.0).max(width);
    let mut counts = vec![0.0; edges.len().saturating_sub(1)];
    let mut grid = CellGrid::new(cell, furthest, centres.len());
    centres.iter().enumerate().for_each(|(i, p)| grid.insert(i, *p));
    let mut nearest = vec![0.0; centres.len()];
    for i in (0..centres.len()).step_by(step) {
        nearest[i] = f64::INFINITY;
        for j in grid.around(grid.cell_of(centres[i])).filter(|j| *j != i) {
            let r = norm(cell.delta(centres[i], centres[j]));
            nearest[i] = nearest[i].min(r);
            if let Some(slot) = counts.get_mut((r / width) as usize) {
                *slot += 1.0;
            }
        }
    }
    seek_further(cell, centres, furthest, &mut nearest);
    (counts, nearest.into_iter().step_by(step).collect())
}

/// The nearest neighbours of the centres that have none within `known`, in ever wider cells.
fn seek_further(cell: &CellBox, centres: &[V3], known: f64, nearest: &mut [f64]) {
    let mut reach = known;
    let widest = norm(cell.size);
    while centres.len() > 1 && reach < widest {
        let alone: Vec<usize> = (0..centres.len()).filter(|i| nearest[*i] > reach).collect();
        if alone.is_empty() {
            return;
        }
        reach *= 2.0;
        let mut grid = CellGrid::new(cell, reach, centres.len());
        centres.iter().enumerate().for_each(|(i, p)| grid.insert(i, *p));
        for i in alone {
            let others = grid.around(grid.cell_of(centres[i])).filter(|j| *j != i);
            nearest[i] =
                others.map(|j| norm(cell.delta(centres[i], centres[j]))).fold(f64::INFINITY, f64::min);
        }
    }
}

/// Probability that two independent uniform points are closer than each edge.
///
/// Between walls w apart (for centres: H less twice the smallest thickest radius) their distance
/// across the layer has density 2(w − u)/w², and ∫₀^min(r,w) 2(w − u)/w² · π(r² − u²)/A du is a
/// polynomial.
fn ideal_share(packing: &Packing, edges: &[f64]) -> Vec<f64> {
    let area = packing.period_um()[0] * packing.period_um()[1];
    if !packing.walls() {
        let volume = area * packing.thickness_um();
        return edges.iter().map(|r| 4.0 / 3.0 * PI * r.powi(3) / volume).collect();
    }
    let widest = |g: &Grain| g.spheres.iter().map(|s| s.radius_um).fold(0.0, f64::max);
    let thickest = |g: &Grain| g.solid.as_ref().map_or_else(|| widest(g), |s| s.form.thin_um());
    let margin = packing.grains().iter().map(thickest).fold(f64::MAX, f64::min);
    let w = packing.thickness_um() - 2.0 * margin;
    if w <= 1e-9 * packing.thickness_um() {
        return edges.iter().map(|r| PI * r * r / area).collect();
    }
    let share = |r: &f64| {
        let m = r.min(w);
        let integral = w * (r * r * m - m.powi(3) / 3.0) - (0.5 * r * r * m * m - 0.25 * m.powi(4));
        2.0 * PI / (area * w * w) * integral
    };
    edges.iter().map(share).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ink::Sphere;
    use crate::numerics::Draws;

    /// Uniform random points in a wide cell.
    fn gas(points: usize, width: f64) -> Packing {
        let mut draws = Draws::new(7, 0);
        let mut point = |_| {
            let center_um =
                [draws.between(0.0, width), draws.between(0.0, width), draws.between(1e-6, 0.999_999)];
            Grain::new(vec![Sphere { center_um, radius_um: 1e-7 }], 0)
        };
        Packing::from_grains([width; 2], 1.0, true, (0..points).map(&mut point).collect()).unwrap()
    }

    /// Of many centres a part is sampled, with the g of all. *Planted*: pairs of sampled centres
    /// counted as if each came once.
    #[test]
    fn many_centres_are_sampled() {
        let packing = gas(2 * MOST_CENTRES + 1, 300.0);
        let pairs = pair_statistics(&packing, 0.5, 5.0);
        assert_eq!(
            pairs.sampled,
            SampledCentres { counted: MOST_CENTRES * 2 / 3 + 1, all: 2 * MOST_CENTRES + 1 }
        );
        assert_eq!(pairs.nearest_um.len(), pairs.sampled.counted);
        for (counted, ideal) in pairs.counts.iter().zip(&pairs.ideal) {
            // Significance: four standard deviations in 10 shells; pairs of two sampled centres,
            // a third of them, count twice, which widens the scatter
            assert!((counted - ideal).abs() < 6.0 * ideal.sqrt(), "{counted} {ideal}");
        }
    }

    /// Neighbours beyond the shells: those of all pairs.
    #[test]
    fn far_neighbours_are_those_of_all_pairs() {
        let packing = gas(300, 40.0);
        let cell = CellBox::new(packing.period_um(), packing.thickness_um(), true);
        let centres: Vec<V3> = packing.grains().iter().map(|g| cell.wrap(g.centre_um())).collect();
        let found = pair_statistics(&packing, 0.01, 0.1).nearest_um;
        for (i, found) in found.iter().enumerate() {
            let others = (0..centres.len()).filter(|j| *j != i);
            let least = others.map(|j| norm(cell.delta(centres[i], centres[j]))).fold(f64::MAX, f64::min);
            assert_eq!(*found, least, "{i}");
        }
    }

    /// Uniform random points between walls have g = 1: a test of the normalisation.
    #[test]
    fn an_ideal_gas_between_walls_has_no_correlation() {
        let mut draws = Draws::new(2, 0);
        let radius_um = 1e-5;
        let n = 4000;
        let mut point = |_| {
            let center_um = [draws.between(0.0, 2.0), draws.between(0.0, 2.0), draws.between(2e-5, 0.29998)];
            Grain::new(vec![Sphere { center_um, radius_um }], 0)
        };
        let packing = Packing::from_grains([2.0, 2.0], 0.3, true, (0..n).map(&mut point).collect()).unwrap();
        let pairs = pair_statistics_to(&packing, 2500.0, 45_000.0);
        assert_eq!(pairs.counts.len(), 18);
        for (counted, ideal) in pairs.counts.iter().zip(&pairs.ideal) {
            // Significance: 18 shells, four standard deviations of a count that is Poisson.
            assert!((counted - ideal).abs() < 4.0 * ideal.sqrt(), "{counted} {ideal}");
        }
    }
}
