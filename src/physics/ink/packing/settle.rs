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
            let r = s.radius_um;
            columns.add([x - r, x + r], [y - r, y + r], |column_x, column_y| {
                let dx = column_x - x;
                let dy = column_y - y;
                let square = r * r - dx * dx - dy * dy;
                (square > 0.0).then(|| [height(z) - square.sqrt(), height(z) + square.sqrt()])
            });
        }
        for solid in solids() {
            columns.add(solid.extent_um(0), solid.extent_um(1), |x, y| {
                let [a, b] = solid.chord([x, y, 0.0], [0.0, 0.0, 1.0])?.map(height);
                Some([a.min(b), a.max(b)])
            });
        }
        columns.pigment.iter_mut().for_each(merge);
        columns
    }

    /// Adds a grain of the given extents along x and y, with its interval of height at a position.
    fn add(&mut self, x_um: [f64; 2], y_um: [f64; 2], interval: impl Fn(f64, f64) -> Option<[f64; 2]>) {
        let [nx, ny] = self.count;
        let pitch_x = self.period_um[0] / nx as f64;
        let pitch_y = self.period_um[1] / ny as f64;
        for j in within(y_um, pitch_y) {
            for i in within(x_um, pitch_x) {
                let column = i.rem_euclid(nx as i64) as usize;
                let row = j.rem_euclid(ny as i64) as usize;
                self.pigment[row * nx + column].extend(interval(i as f64 * pitch_x, j as f64 * pitch_y));
            }
        }
    }

    /// Periodic Gaussian filter of a function on the columns.
    fn smoothed(&self, values: &[f64], sigma_um: f64) -> Vec<f64> {
        let [nx, ny] = self.count;
        let [lx, ly] = self.period_um;
        let along_x = AxisLines { points: nx, stride: 1, lines: ny, line_stride: nx };
        let along_y = AxisLines { points: ny, stride: nx, lines: nx, line_stride: 1 };
        let smooth_in_x = along_x.smoothed(values, sigma_um * nx as f64 / lx);
        along_y.smoothed(&smooth_in_x, sigma_um * ny as f64 / ly)
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
        let below = |k: usize| {
            let top = surface(k);
            self.pigment[k].iter().map(|c| (c[1].min(top) - c[0]).max(0.0)).sum::<f64>()
        };
        (0..self.pigment.len()).map(below).sum::<f64>() / self.pigment.len() as f64
    }
}

/// Numbers of the columns within an interval.
fn within(interval_um: [f64; 2], pitch_um: f64) -> std::ops::RangeInclusive<i64> {
    let [low, high] = interval_um;
    (low / pitch_um).ceil() as i64..=(high / pitch_um).floor() as i64
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

/// The lines of a grid along one of its axes.
struct AxisLines {
    /// Points of a line, and how far apart they are stored.
    points: usize,
    stride: usize,
    /// Lines, and how far apart their first points are stored.
    lines: usize,
    line_stride: usize,
}

impl AxisLines {
    /// Periodic Gaussian filter along the lines; `sigma` in points.
    fn smoothed(&self, values: &[f64], sigma: f64) -> Vec<f64> {
        let n = self.points;
        let reach = ((4.0 * sigma).ceil() as usize).min(n / 2);
        let weight = |k: usize| if k == 0 { 1.0 } else { (-0.5 * (k as f64 / sigma).powi(2)).exp() };
        let weights: Vec<f64> = (0..=reach).map(weight).collect();
        let total = weights[0] + 2.0 * weights[1..].iter().sum::<f64>();
        let mut out = vec![0.0; values.len()];
        for line in 0..self.lines {
            let index = |i: usize| line * self.line_stride + (i % n) * self.stride;
            for i in 0..n {
                let both = |k: usize| weights[k] * (values[index(i + k)] + values[index(i + n - k)]);
                let sum = weights[0] * values[index(i)] + (1..=reach).map(both).sum::<f64>();
                out[index(i)] = sum / total;
            }
        }
        out
    }
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
        let above = RoughFace::Incident;
        let below = RoughFace::Exit;
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
        let rms = 0.04;
        let length = 0.2;
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
            let level = relief.mean_height_um();
            let [nx, ny] = relief.count;
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
        let expected = (-1.0_f64).exp();
        let found = products / squares;
        assert!((found - expected).abs() < 0.08, "{found} against {expected}");
        assert!((means - 0.7).abs() < 0.01, "{means}: the dry volume");
    }
}
