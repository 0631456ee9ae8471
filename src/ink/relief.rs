//! Micro-relief: the binder's surface below the tops of the grains (P1 section 3, "микрорельеф").
//!
//! Grains are packed between the paper (z = H) and the top (z = 0). The dry ink, pigment and binder together, has
//! the volume A (H − depth), of which the pigment takes the requested share exactly as in a flat layer. Since
//! grains stand out of it, the binder sinks: its level is found from the conservation of its volume.

use super::error::PackError;
use super::grains::volume::merge;
use super::packing::placed::Packing;
use serde::{Deserialize, Serialize};

/// What is asked of the binder's surface.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ReliefRequest {
    /// By how much the levelled dry ink is thinner than the layer of grains, H: the volume fractions refer to
    /// the dry volume, area × (H − depth).
    pub depth_um: f64,
    /// The surface's shape.
    #[serde(default)]
    pub rule: ReliefRule,
}

/// The shape of the surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum ReliefRule {
    /// One level everywhere.
    #[default]
    Flat,
    /// Level + `follow` × (T − ⟨T⟩), T the height of the topmost pigment over each point smoothed by a Gaussian
    /// of standard deviation `smoothing_um`: surface tension levels what is shorter. Never above the layer.
    Following {
        /// How far the surface follows the grains: 0 (flat) to 1.
        follow: f64,
        /// Standard deviation of the smoothing, µm, at least 0.
        smoothing_um: f64,
    },
}

impl ReliefRequest {
    pub(crate) fn check(&self, thickness_um: f64, walls: bool) -> Result<(), PackError> {
        if !walls {
            let advice = "set walls = true, or leave the relief out";
            return Err(PackError::input(
                "relief",
                "with walls = false",
                "relief between walls only",
                advice,
            ));
        }
        if !(self.depth_um >= 0.0 && self.depth_um < thickness_um) {
            let allowed = format!("0 up to the thickness, {thickness_um} µm");
            return Err(PackError::input("relief.depth_um", self.depth_um, allowed, "lower the depth"));
        }
        let ReliefRule::Following { follow, smoothing_um } = self.rule else { return Ok(()) };
        if !(0.0..=1.0).contains(&follow) {
            return Err(PackError::input("relief.rule.follow", follow, "0 (flat) to 1", "lower it"));
        }
        if !(smoothing_um.is_finite() && smoothing_um >= 0.0) {
            let field = "relief.rule.smoothing_um";
            return Err(PackError::input(
                field,
                smoothing_um,
                "finite, at least 0",
                "about one grain radius",
            ));
        }
        Ok(())
    }
}

/// Height of pigment and binder levelled out.
pub(crate) fn dry_height_um(request: &ReliefRequest, thickness_um: f64) -> f64 {
    thickness_um - request.depth_um
}

/// The binder's surface as heights above the paper on a periodic grid, with its balance of volumes.
#[derive(Clone, Debug, PartialEq)]
pub struct Relief {
    heights_um: Vec<f64>,
    /// Highest of binder and grains at the same points.
    surface_um: Vec<f64>,
    count: [usize; 2],
    period_um: [f64; 2],
    rule: ReliefRule,
    protruding_share: f64,
    fraction_below: f64,
    dry_height_um: f64,
    balance_error: f64,
}

impl Relief {
    /// Height of the binder above the paper at (x, y): bilinear between the points of the grid.
    pub fn height_um(&self, x_um: f64, y_um: f64) -> f64 {
        let [nx, ny] = self.count;
        let split = |x: f64, period: f64, n: usize| {
            let t = (x / period).rem_euclid(1.0) * n as f64;
            let i = (t as usize).min(n - 1);
            (i, (i + 1) % n, t - i as f64)
        };
        let (i0, i1, u) = split(x_um, self.period_um[0], nx);
        let (j0, j1, v) = split(y_um, self.period_um[1], ny);
        let h = |i: usize, j: usize| self.heights_um[j * nx + i];
        (1.0 - v) * ((1.0 - u) * h(i0, j0) + u * h(i1, j0)) + v * ((1.0 - u) * h(i0, j1) + u * h(i1, j1))
    }

    /// Points of the height grid along x and y.
    pub fn count(&self) -> [usize; 2] {
        self.count
    }

    /// The rule that was asked for.
    pub fn rule(&self) -> ReliefRule {
        self.rule
    }

    /// Mean height of the binder above the paper, µm.
    pub fn mean_height_um(&self) -> f64 {
        mean(&self.heights_um)
    }

    /// Root mean square deviation of the binder's height from its mean, µm.
    pub fn rms_height_um(&self) -> f64 {
        rms(&self.heights_um)
    }

    /// Root mean square height of what vacuum touches: the higher of binder and grains.
    pub fn rms_surface_um(&self) -> f64 {
        rms(&self.surface_um)
    }

    /// Share of the pigment's volume above the binder's surface.
    pub fn protruding_share(&self) -> f64 {
        self.protruding_share
    }

    /// Pigment below the surface over volume below the surface (the request refers to the dry volume instead).
    pub fn fraction_below(&self) -> f64 {
        self.fraction_below
    }

    /// Height of pigment and binder levelled out, the reference of the volume fractions.
    pub fn dry_height_um(&self) -> f64 {
        self.dry_height_um
    }

    /// Relative error of the pigment's volume on the grid of columns: how well the balance is known.
    pub fn balance_error(&self) -> f64 {
        self.balance_error
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn rms(values: &[f64]) -> f64 {
    let centre = mean(values);
    (values.iter().map(|v| (v - centre).powi(2)).sum::<f64>() / values.len() as f64).sqrt()
}

/// Columns per thinnest radius, and the largest grid.
const PER_RADIUS: f64 = 8.0;
const MOST: usize = 1024;

/// Pigment along vertical lines: intervals of height above the paper.
struct Columns {
    count: [usize; 2],
    pigment: Vec<Vec<[f64; 2]>>,
}

impl Columns {
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
    let columns = Columns::new(packing);
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
fn deviation(tops: &[f64], columns: &Columns, period: [f64; 2], rule: ReliefRule) -> Vec<f64> {
    let ReliefRule::Following { follow, smoothing_um } = rule else { return vec![0.0; tops.len()] };
    let [nx, ny] = columns.count;
    let in_x = smoothed(tops, nx, ny, 1, nx, smoothing_um * nx as f64 / period[0]);
    let smooth = smoothed(&in_x, ny, nx, nx, 1, smoothing_um * ny as f64 / period[1]);
    let centre = mean(&smooth);
    smooth.iter().map(|t| follow * (t - centre)).collect()
}

/// Periodic Gaussian filter along one axis of `n` points with stride `along`, for `lines` lines `across` apart.
fn smoothed(values: &[f64], n: usize, lines: usize, along: usize, across: usize, sigma: f64) -> Vec<f64> {
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
