//! The level to which the binder sinks between placed grains.

use super::placed::{Packing, PackingAccount};
use crate::ink::grains::volume::merge;
use crate::ink::relief::{Relief, ReliefRequest, ReliefRule, RoughFace, mean};
use crate::numerics::Draws;

/// Columns per smallest radius.
const PER_RADIUS: f64 = 8.0;
const MOST: usize = 1024;
/// Keeps the draws of surfaces apart from those of grains.
const SURFACES: u64 = 0x5375_7266;

/// Pigment along vertical lines: intervals of height above the face opposite to the rough one.
struct HeightColumns {
    count: [usize; 2],
    period_um: [f64; 2],
    pigment: Vec<Vec<[f64; 2]>>,
}

impl HeightColumns {
    fn new(packing: &Packing, face: RoughFace) -> Self {
        let period_um = packing.period_um();
        let spheres = || packing.grains().iter().filter(|g| g.solid.is_none()).flat_map(|g| &g.spheres);
        let solids = || packing.grains().iter().filter_map(|g| g.solid.as_ref());
        let radii = spheres().map(|s| s.radius_um).chain(solids().map(|s| s.form.thin_um()));
        let thinnest = radii.fold(f64::MAX, f64::min);
        let count = period_um.map(|l| ((PER_RADIUS * l / thinnest).ceil() as usize).clamp(8, MOST));
        let mut columns = Self { count, period_um, pigment: vec![Vec::new(); count[0] * count[1]] };
        let thickness = packing.thickness_um();
        let height = |z: f64| if face == RoughFace::Incident { thickness - z } else { z };
        for s in spheres() {
            let [x, y, z] = s.center_um;
            columns.add([x, y].map(|c| [c - s.radius_um, c + s.radius_um]), |at| {
                let (dx, dy) = (at[0] - x, at[1] - y);
                let square = s.radius_um * s.radius_um - dx * dx - dy * dy;
                (square > 0.0).then(|| [height(z) - square.sqrt(), height(z) + square.sqrt()])
            });
        }
        for solid in solids() {
            columns.add([0, 1].map(|axis| solid.extent_um(axis)), |[x, y]| {
                let [a, b] = solid.chord([x, y, 0.0], [0.0, 0.0, 1.0])?.map(height);
                Some([a.min(b), a.max(b)])
            });
        }
        columns.pigment.iter_mut().for_each(merge);
        columns
    }

    /// Adds a grain of the given extents along x and y, with its interval of height at a position.
    fn add(&mut self, extents_um: [[f64; 2]; 2], interval: impl Fn([f64; 2]) -> Option<[f64; 2]>) {
        let count = self.count;
        let pitch = [0, 1].map(|axis| self.period_um[axis] / count[axis] as f64);
        let [columns, rows] = [0, 1].map(|axis| {
            let [low, high] = extents_um[axis].map(|end| end / pitch[axis]);
            low.ceil() as i64..=high.floor() as i64
        });
        for j in rows {
            for i in columns.clone() {
                let column = [i.rem_euclid(count[0] as i64), j.rem_euclid(count[1] as i64)];
                let place = column[1] as usize * count[0] + column[0] as usize;
                self.pigment[place].extend(interval([i as f64 * pitch[0], j as f64 * pitch[1]]));
            }
        }
    }

    /// Periodic Gaussian filter of a function on the columns.
    fn smoothed(&self, values: &[f64], sigma_um: f64) -> Vec<f64> {
        let ([nx, ny], [lx, ly]) = (self.count, self.period_um);
        let in_x = smoothed(values, [nx, 1], [ny, nx], sigma_um * nx as f64 / lx);
        smoothed(&in_x, [ny, nx], [nx, 1], sigma_um * ny as f64 / ly)
    }

    /// Gaussian heights of standard deviation `rms_um` with the autocorrelation exp(−r²/ℓ²) and no
    /// mean: independent ones, filtered with the standard deviation ℓ/2.
    fn random(&self, packing: &Packing, rms_um: f64, correlation_um: f64) -> Vec<f64> {
        let PackingAccount { seed, stream, .. } = *packing.account();
        let mut draws = Draws::new(seed.wrapping_add(SURFACES), stream);
        let count = self.count[0] * self.count[1];
        let independent: Vec<f64> = (0..count).map(|_| draws.normal()).collect();
        let mut point = vec![0.0; count];
        point[0] = 1.0;
        // What the filter leaves of the variance 1, less that of the mean.
        let left = self.smoothed(&point, 0.5 * correlation_um).iter().map(|w| w * w).sum::<f64>()
            - 1.0 / count as f64;
        let heights = self.smoothed(&independent, 0.5 * correlation_um);
        let centre = mean(&heights);
        heights.iter().map(|h| rms_um / left.sqrt() * (h - centre)).collect()
    }

    /// Mean over columns of the pigment's length below the surface.
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
    let columns = HeightColumns::new(packing, request.face);
    let thickness = packing.thickness_um();
    let area = packing.period_um()[0] * packing.period_um()[1];
    let tops: Vec<f64> = columns.pigment.iter().map(|c| c.last().map_or(0.0, |top| top[1])).collect();
    let shape = match request.rule {
        ReliefRule::Flat => vec![0.0; tops.len()],
        ReliefRule::Following { follow, smoothing_um } => {
            let smooth = columns.smoothed(&tops, smoothing_um);
            let centre = mean(&smooth);
            smooth.iter().map(|t| follow * (t - centre)).collect()
        }
        ReliefRule::Random { rms_um, correlation_um } => columns.random(packing, rms_um, correlation_um),
    };
    let pigment = packing.grains().iter().map(|g| g.volume_um3).sum::<f64>() / area;
    let binder = request.dry_um(thickness) - pigment;
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
        dry_height_um: request.dry_um(thickness),
        heights_um,
        surface_um,
        count: columns.count,
        period_um: columns.period_um,
        rule: request.rule,
        face: request.face,
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

/// Periodic Gaussian filter along one axis of `n` points with stride `along`, for `lines` lines
/// `apart` from each other.
fn smoothed(values: &[f64], [n, along]: [usize; 2], [lines, apart]: [usize; 2], sigma: f64) -> Vec<f64> {
    let reach = ((4.0 * sigma).ceil() as usize).min(n / 2);
    let weight = |k: usize| if k == 0 { 1.0 } else { (-0.5 * (k as f64 / sigma).powi(2)).exp() };
    let weights: Vec<f64> = (0..=reach).map(weight).collect();
    let total = weights[0] + 2.0 * weights[1..].iter().sum::<f64>();
    let mut out = vec![0.0; values.len()];
    for line in 0..lines {
        let at = |i: usize| values[line * apart + (i % n) * along];
        for i in 0..n {
            let both = |k: usize| weights[k] * (at(i + k) + at(i + n - k));
            out[line * apart + i * along] = (weights[0] * at(i) + (1..=reach).map(both).sum::<f64>()) / total;
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ink::pack;
    use crate::ink::{Grain, MethodChoice, PackingRequest, PigmentGrains, Shape};

    fn packed(rule: ReliefRule) -> Packing {
        packed_of(PigmentGrains::spheres(250.0, 0.4), rule, RoughFace::Incident)
    }

    fn packed_of(grains: PigmentGrains, rule: ReliefRule, face: RoughFace) -> Packing {
        let request = PackingRequest {
            period_um: [2.0, 2.4],
            thickness_um: 1.0,
            pigments: vec![grains],
            method: MethodChoice::Relaxation,
            relief: Some(ReliefRequest { depth_um: 0.2, rule, face }),
            ..Default::default()
        };
        pack(&request, &mut ()).unwrap()
    }

    #[test]
    fn pigment_and_binder_fill_the_dry_volume() {
        let following = ReliefRule::Following { follow: 0.6, smoothing_um: 0.1 };
        let boxes = PigmentGrains::of(Shape::Box { edges: [1.0, 1.5, 0.8] }, 250.0, 0.35);
        let spheres = || PigmentGrains::spheres(250.0, 0.4);
        let [above, below] = [RoughFace::Incident, RoughFace::Exit];
        for (grains, rule, face) in
            [(spheres(), ReliefRule::Flat, above), (spheres(), following, below), (boxes, following, above)]
        {
            let packing = packed_of(grains, rule, face);
            let relief = packing.relief().unwrap();
            let pigment = packing.achieved_fraction(0) * 0.8;
            let binder = relief.mean_height_um() * (1.0 - relief.fraction_below);
            // Order: columns an eighth of a radius apart know the pigment's volume to some 1e-3.
            assert!(relief.balance_error < 2e-3, "{}", relief.balance_error);
            assert!((pigment + binder - 0.8).abs() < 1e-9, "{}", pigment + binder);
            assert!(relief.protruding_share > 0.02 && relief.mean_height_um() < 0.8);
        }
    }

    #[test]
    fn a_flat_surface_is_level_and_a_following_one_rises_over_grains() {
        let flat = packed(ReliefRule::Flat);
        assert!(flat.relief().unwrap().rms_height_um() < 1e-12);
        assert_eq!(flat.filled_um(0.3, 0.7), flat.filled_um(-5.1, 9.2));
        let rule = ReliefRule::Following { follow: 1.0, smoothing_um: 0.05 };
        let discs = PigmentGrains::of(Shape::Disc { diameter: 2.0, thickness: 1.0 }, 250.0, 0.3);
        rises_over_grains(&packed(rule));
        rises_over_grains(&packed_of(discs.clone(), rule, RoughFace::Incident));
        rises_over_grains(&packed_of(discs, rule, RoughFace::Exit));
    }

    fn rises_over_grains(packing: &Packing) {
        let relief = packing.relief().unwrap();
        let depth = |z: f64| if relief.face == RoughFace::Exit { -z } else { z };
        let centres = packing.grains().iter().map(Grain::centre_um);
        let [x, y, _] = centres.min_by(|a, b| depth(a[2]).total_cmp(&depth(b[2]))).unwrap();
        let above = relief.height_um(x, y) - relief.mean_height_um();
        assert!(above > relief.rms_height_um(), "{above}");
    }

    /// Heights and products of heights ℓ apart, over 24 surfaces. *Planted*: a filter of ℓ in place
    /// of ℓ/2, or heights that keep their mean.
    #[test]
    fn a_random_surface_has_its_height_and_correlation_length() {
        let (rms, length) = (0.04, 0.2);
        let [mut squares, mut products, mut means] = [0.0; 3];
        for stream in 0..24 {
            let rule = ReliefRule::Random { rms_um: rms, correlation_um: length };
            let request = PackingRequest {
                period_um: [2.0, 2.0],
                thickness_um: 1.0,
                pigments: vec![PigmentGrains::spheres(300.0, 0.01)],
                relief: Some(ReliefRequest { depth_um: 0.3, rule, face: RoughFace::Incident }),
                stream,
                ..Default::default()
            };
            let packing = pack(&request, &mut ()).unwrap();
            let relief = packing.relief().unwrap();
            let (level, [nx, ny]) = (relief.mean_height_um(), relief.count);
            let apart = (length * nx as f64 / 2.0).round() as usize;
            let at = |i: usize, j: usize| relief.heights_um[j * nx + i % nx] - level;
            let pairs = (0..ny).flat_map(|j| (0..nx).map(move |i| (i, j)));
            let count = (nx * ny * 24) as f64;
            means += level / 24.0;
            for (i, j) in pairs {
                squares += at(i, j) * at(i, j) / count;
                products += at(i, j) * at(i + apart, j) / count;
            }
        }
        // 24 surfaces of (2 µm)²/(π ℓ²/2) = 64 independent spots: √(2/1500) = 4 % of the variance,
        // three times; heights are cut off at 7 standard deviations
        assert!((squares / rms.powi(2) - 1.0).abs() < 0.12, "{}", squares.sqrt());
        let [expected, found] = [(-1.0_f64).exp(), products / squares];
        assert!((found - expected).abs() < 0.08, "{found} against {expected}");
        assert!((means - 0.7).abs() < 0.01, "{means}: the dry volume");
    }
}
