//! The level that the binder sinks to between grains in their places.

use super::placed::Packing;
use crate::ink::grains::volume::merge;
use crate::ink::relief::{Relief, ReliefRequest, ReliefRule, dry_height_um, mean};

/// Columns per thinnest radius, and the largest grid.
const PER_RADIUS: f64 = 8.0;
const MOST: usize = 1024;

/// Pigment along vertical lines: intervals of height above the paper.
struct HeightColumns {
    count: [usize; 2],
    pigment: Vec<Vec<[f64; 2]>>,
}

impl HeightColumns {
    fn new(packing: &Packing) -> Self {
        let period = packing.period_um();
        let spheres = || packing.grains().iter().flat_map(|g| &g.spheres);
        let thinnest = spheres().map(|s| s.radius_um).fold(f64::MAX, f64::min);
        let count = period.map(|l| ((PER_RADIUS * l / thinnest).ceil() as usize).clamp(8, MOST));
        let pitch = [period[0] / count[0] as f64, period[1] / count[1] as f64];
        let mut pigment = vec![Vec::new(); count[0] * count[1]];
        for s in spheres() {
            let [x, y, z] = s.center_um;
            let range = |c: f64, h: f64| {
                ((c - s.radius_um) / h).ceil() as i64..=((c + s.radius_um) / h).floor() as i64
            };
            for j in range(y, pitch[1]) {
                for i in range(x, pitch[0]) {
                    let (dx, dy) = (i as f64 * pitch[0] - x, j as f64 * pitch[1] - y);
                    let square = s.radius_um * s.radius_um - dx * dx - dy * dy;
                    if square > 0.0 {
                        let (height, half) = (packing.thickness_um() - z, square.sqrt());
                        let column = [i.rem_euclid(count[0] as i64), j.rem_euclid(count[1] as i64)];
                        let place = column[1] as usize * count[0] + column[0] as usize;
                        pigment[place].push([height - half, height + half]);
                    }
                }
            }
        }
        pigment.iter_mut().for_each(merge);
        Self { count, pigment }
    }

    fn tops(&self) -> Vec<f64> {
        self.pigment.iter().map(|c| c.last().map_or(0.0, |top| top[1])).collect()
    }

    /// Mean over columns of the length of pigment below each column's surface.
    fn pigment_below(&self, surface: impl Fn(usize) -> f64) -> f64 {
        let below = |(k, column): (usize, &Vec<[f64; 2]>)| {
            let top = surface(k);
            column.iter().map(|c| (c[1].min(top) - c[0]).max(0.0)).sum::<f64>()
        };
        self.pigment.iter().enumerate().map(below).sum::<f64>() / self.pigment.len() as f64
    }
}

/// The binder's surface over a packing.
pub(crate) fn settle(packing: &Packing, request: &ReliefRequest) -> Relief {
    let columns = HeightColumns::new(packing);
    let thickness = packing.thickness_um();
    let area = packing.period_um()[0] * packing.period_um()[1];
    let tops = columns.tops();
    let shape = deviation(&tops, &columns, packing.period_um(), request.rule);
    let pigment = packing.grains().iter().map(|g| g.volume_um3).sum::<f64>() / area;
    let binder = dry_height_um(request, thickness) - pigment;
    let surface = |level: f64, k: usize| (level + shape[k]).clamp(0.0, thickness);
    let filled = |level: f64| {
        let volume = (0..shape.len()).map(|k| surface(level, k)).sum::<f64>() / shape.len() as f64;
        volume - columns.pigment_below(|k| surface(level, k))
    };
    let level = bisect(filled, binder, -thickness, 2.0 * thickness);
    let heights_um: Vec<f64> = (0..shape.len()).map(|k| surface(level, k)).collect();
    let below = columns.pigment_below(|k| heights_um[k]);
    let all = columns.pigment_below(|_| thickness);
    let surface_um = heights_um.iter().zip(&tops).map(|(h, t)| h.max(*t)).collect();
    Relief {
        fraction_below: below / mean(&heights_um),
        protruding_share: 1.0 - below / all,
        balance_error: (all / pigment - 1.0).abs(),
        dry_height_um: dry_height_um(request, thickness),
        heights_um,
        surface_um,
        count: columns.count,
        period_um: packing.period_um(),
        rule: request.rule,
    }
}

/// Root of an increasing function to the last bit.
fn bisect(f: impl Fn(f64) -> f64, target: f64, mut low: f64, mut high: f64) -> f64 {
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if f(middle) < target { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// What the rule adds to the level at each column.
fn deviation(tops: &[f64], columns: &HeightColumns, period: [f64; 2], rule: ReliefRule) -> Vec<f64> {
    let ReliefRule::Following { follow, smoothing_um } = rule else { return vec![0.0; tops.len()] };
    let [nx, ny] = columns.count;
    let in_x = smoothed(tops, [nx, 1], [ny, nx], smoothing_um * nx as f64 / period[0]);
    let smooth = smoothed(&in_x, [ny, nx], [nx, 1], smoothing_um * ny as f64 / period[1]);
    let centre = mean(&smooth);
    smooth.iter().map(|t| follow * (t - centre)).collect()
}

/// Periodic Gaussian filter along one axis of `n` points with stride `along`, for `lines` lines `across` apart.
fn smoothed(values: &[f64], [n, along]: [usize; 2], [lines, across]: [usize; 2], sigma: f64) -> Vec<f64> {
    let reach = ((4.0 * sigma).ceil() as usize).min(n / 2);
    let weight = |k: usize| if k == 0 { 1.0 } else { (-0.5 * (k as f64 / sigma).powi(2)).exp() };
    let weights: Vec<f64> = (0..=reach).map(weight).collect();
    let total = weights[0] + 2.0 * weights[1..].iter().sum::<f64>();
    let mut out = vec![0.0; values.len()];
    for line in 0..lines {
        let at = |i: usize| values[line * across + (i % n) * along];
        for i in 0..n {
            let both = |k: usize| weights[k] * (at(i + k) + at(i + n - k));
            out[line * across + i * along] =
                (weights[0] * at(i) + (1..=reach).map(both).sum::<f64>()) / total;
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ink::pack;
    use crate::ink::{MethodChoice, PackingRequest, PigmentGrains};

    fn packed(rule: ReliefRule) -> Packing {
        let request = PackingRequest {
            period_um: [2.0, 2.4],
            thickness_um: 1.0,
            pigments: vec![PigmentGrains::spheres(250.0, 0.4)],
            method: MethodChoice::Relaxation,
            relief: Some(ReliefRequest { depth_um: 0.2, rule }),
            ..Default::default()
        };
        pack(&request, &mut ()).unwrap()
    }

    #[test]
    fn pigment_and_binder_fill_the_dry_volume() {
        let following = ReliefRule::Following { follow: 0.6, smoothing_um: 0.1 };
        for rule in [ReliefRule::Flat, following] {
            let packing = packed(rule);
            let relief = packing.relief().unwrap();
            let pigment = packing.achieved_fraction(0) * 0.8;
            let binder = relief.mean_height_um() * (1.0 - relief.fraction_below());
            // Order: columns an eighth of a radius apart know the pigment's volume to some 1e-3.
            assert!(relief.balance_error() < 2e-3, "{}", relief.balance_error());
            assert!((pigment + binder - 0.8).abs() < 1e-9, "{}", pigment + binder);
            assert!(relief.protruding_share() > 0.02 && relief.mean_height_um() < 0.8);
        }
    }

    #[test]
    fn a_flat_surface_is_level_and_a_following_one_rises_over_grains() {
        let flat = packed(ReliefRule::Flat);
        assert!(flat.relief().unwrap().rms_height_um() < 1e-12);
        assert_eq!(flat.surface_height_um(0.3, 0.7), flat.surface_height_um(-5.1, 9.2));
        let packing = packed(ReliefRule::Following { follow: 1.0, smoothing_um: 0.05 });
        let highest =
            packing.grains().iter().min_by(|a, b| a.centre_um()[2].total_cmp(&b.centre_um()[2])).unwrap();
        let [x, y, _] = highest.centre_um();
        let above = packing.surface_height_um(x, y) - packing.relief().unwrap().mean_height_um();
        assert!(above > packing.relief().unwrap().rms_height_um(), "{above}");
    }
}
