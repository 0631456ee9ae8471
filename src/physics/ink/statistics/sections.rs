//! Plane sections of the grains and exact chords on lines in them: fraction, profile, two-point
//! probability.

use crate::ink::grains::volume::merge;
use crate::ink::{Grain, Packing, Solid, Sphere};
use rayon::prelude::*;

/// Statistics of the pigment on lines parallel to x and y in equally spaced planes z = const.
///
/// Chords are exact; only the lines are sampled.
#[derive(Clone, Debug, PartialEq)]
pub struct SectionStatistics {
    /// Heights of the planes, µm.
    pub z_um: Vec<f64>,
    /// Covered fraction of each plane, for each pigment.
    pub profile: Vec<Vec<f64>>,
    /// Separations of S2, µm, from 0.
    pub r_um: Vec<f64>,
    /// Probability that two points r apart along x both lie in pigment.
    pub s2_x: Vec<f64>,
    /// Probability that two points r apart along y both lie in pigment.
    pub s2_y: Vec<f64>,
    /// Chords per µm of line along x and along y: a quarter of the surface per volume, and −S2′(0).
    pub chords_per_um: [f64; 2],
    /// ⟨φ(z)²⟩, the limit of S2 in the plane for large r.
    pub mean_square_profile: f64,
    /// Distance of the lines, µm: as asked for, or more in a packing of very many grains.
    pub spacing_um: f64,
}

impl SectionStatistics {
    /// Profile φ(z) of all pigments together.
    pub fn total_profile(&self) -> Vec<f64> {
        let planes = 0..self.z_um.len();
        planes.map(|k| self.profile.iter().map(|p| p[k]).sum()).collect()
    }
}

/// Chords along one axis beyond which lines are taken further apart: their scatter is below a
/// thousandth then.
const MOST_CHORDS: f64 = 3e6;
/// Lines in all planes beyond which they are taken further apart.
const MOST_LINES: f64 = 1e6;

/// Distance of the lines, wider than wanted if a packing has very many grains, or tiny ones in a
/// wide cell.
fn spacing_um_of(packing: &Packing, planes: usize, spacing_um: f64) -> f64 {
    let per_um = planes as f64 / packing.thickness_um();
    // planes through a sphere, and lines through it in each of them
    let crossings = |s: &Sphere| 2.0 * s.radius_um * per_um * (2.0 * s.radius_um / spacing_um);
    let chords: f64 = packing.grains().iter().flat_map(|g| &g.spheres).map(crossings).sum();
    let [lx, ly] = packing.period_um();
    let lines = planes as f64 * lx.max(ly) / spacing_um;
    spacing_um * (chords / MOST_CHORDS).max(lines / MOST_LINES).max(1.0)
}

/// Sections at `planes` heights, lines `spacing_um` apart (or more, see
/// [`SectionStatistics::spacing_um`]), S2 at multiples of `step_um` up to `furthest_um`.
pub fn section_statistics(
    packing: &Packing,
    planes: usize,
    spacing_um: f64,
    step_um: f64,
    furthest_um: f64,
) -> SectionStatistics {
    let period = packing.period_um();
    let spacing_um = spacing_um_of(packing, planes, spacing_um);
    let half = 0.5 * period[0].min(period[1]);
    let steps = (furthest_um.min(half) / step_um + 1e-9).floor() as usize;
    let r_um: Vec<f64> = (0..=steps).map(|i| i as f64 * step_um).collect();
    let height = packing.thickness_um();
    let z_um: Vec<f64> = (0..planes).map(|k| (k as f64 + 0.5) * height / planes as f64).collect();
    let mut statistics = SectionStatistics {
        profile: vec![vec![0.0; planes]; packing.shares().len()],
        s2_x: vec![0.0; r_um.len()],
        s2_y: vec![0.0; r_um.len()],
        chords_per_um: [0.0; 2],
        mean_square_profile: 0.0,
        spacing_um,
        z_um,
        r_um,
    };
    let weight = 1.0 / planes as f64;
    let by_height = SpheresByHeight::new(packing);
    let section = |z: &f64| {
        let discs = by_height.discs(*z);
        let covered = |pigment: usize| Lines::new(&discs, Some(pigment), period, spacing_um, 0).covered();
        let lines = [0, 1].map(|axis| Lines::new(&discs, None, period, spacing_um, axis));
        PlaneSection {
            covered: (0..packing.shares().len()).map(covered).collect(),
            chords_per_um: lines.each_ref().map(Lines::chords_per_um),
            s2: lines.map(|lines| statistics.r_um.iter().map(|r| lines.both_ends(*r)).collect()),
        }
    };
    // in order, so that sums do not depend on the number of threads
    let sections: Vec<PlaneSection> = statistics.z_um.par_iter().map(section).collect();
    for (plane, PlaneSection { covered, chords_per_um, s2: [s2_x, s2_y] }) in sections.into_iter().enumerate()
    {
        statistics.profile.iter_mut().zip(covered).for_each(|(profile, covered)| profile[plane] = covered);
        statistics.chords_per_um.iter_mut().zip(chords_per_um).for_each(|(sum, n)| *sum += weight * n);
        statistics.s2_x.iter_mut().zip(s2_x).for_each(|(sum, s2)| *sum += weight * s2);
        statistics.s2_y.iter_mut().zip(s2_y).for_each(|(sum, s2)| *sum += weight * s2);
    }
    statistics.mean_square_profile = statistics.total_profile().iter().map(|p| p * p).sum::<f64>() * weight;
    statistics
}

/// What one plane adds to the statistics.
struct PlaneSection {
    /// Covered fraction by pigment.
    covered: Vec<f64>,
    chords_per_um: [f64; 2],
    /// S2 along x and along y by separation.
    s2: [Vec<f64>; 2],
}

/// A sphere cut by a plane, or the sphere around a convex body.
#[derive(Clone, Copy, Debug)]
struct Disc<'a> {
    centre: [f64; 2],
    radius: f64,
    pigment: usize,
    /// The convex body, and the plane's height where the body is.
    solid: Option<(&'a Solid, f64)>,
}

/// The spheres of a packing in the order of their heights, so that a plane looks at those near it
/// alone.
struct SpheresByHeight<'a> {
    /// Height of the centre, within the layer where the packing repeats across it, and the sphere.
    sorted: Vec<(f64, &'a Sphere, &'a Grain)>,
    largest_um: f64,
    /// Thickness of a layer that repeats across it.
    repeats_um: Option<f64>,
}

impl<'a> SpheresByHeight<'a> {
    fn new(packing: &'a Packing) -> Self {
        let ends = packing.walls() || packing.is_cut();
        let repeats_um = (!ends).then_some(packing.thickness_um());
        let spheres = packing.grains().iter().flat_map(|grain| grain.spheres.iter().map(move |s| (s, grain)));
        let placed = |(s, grain): (&'a Sphere, &'a Grain)| {
            let z = s.center_um[2];
            (repeats_um.map_or(z, |height| z.rem_euclid(height)), s, grain)
        };
        let mut sorted: Vec<_> = spheres.map(placed).collect();
        let largest_um = sorted.iter().map(|(_, s, _)| s.radius_um).fold(0.0, f64::max);
        sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
        Self { sorted, largest_um, repeats_um }
    }

    /// The spheres cut by a plane, each in its image nearest to the plane.
    fn discs(&self, z: f64) -> Vec<Disc<'a>> {
        // rounding must not lose a sphere
        let reach = self.largest_um * (1.0 + 1e-9);
        let images: &[f64] = if self.repeats_um.is_some() { &[-1.0, 0.0, 1.0] } else { &[0.0] };
        let height = self.repeats_um.unwrap_or(0.0);
        let within = |image: &f64| {
            let middle = z + image * height;
            let first = self.sorted.partition_point(|s| s.0 < middle - reach);
            let last = self.sorted.partition_point(|s| s.0 <= middle + reach);
            first..last
        };
        // a sphere is near the plane in one image, unless it is as wide as the layer
        if height > 0.0 && 2.0 * reach >= height {
            return (0..self.sorted.len()).filter_map(|i| self.disc(z, i)).collect();
        }
        images.iter().flat_map(within).filter_map(|i| self.disc(z, i)).collect()
    }

    fn disc(&self, z: f64, i: usize) -> Option<Disc<'a>> {
        let (_, s, grain) = self.sorted[i];
        let off = z - s.center_um[2];
        let off = self.repeats_um.map_or(off, |height| off - height * (off / height).round());
        let square = s.radius_um * s.radius_um - off * off;
        let centre = [s.center_um[0], s.center_um[1]];
        let solid = grain.solid.as_ref().map(|solid| (solid, s.center_um[2] + off));
        (square > 0.0).then(|| Disc { centre, radius: square.sqrt(), pigment: grain.pigment, solid })
    }
}

impl Disc<'_> {
    /// Start and end of the chord on the line along `axis` that misses the centre by `miss`.
    fn chord(&self, axis: usize, miss: f64) -> Option<[f64; 2]> {
        let along = self.centre[axis];
        let Some((solid, z)) = self.solid else {
            let half = (self.radius * self.radius - miss * miss).max(0.0).sqrt();
            return Some([along - half, along + half]);
        };
        let mut from = [along, self.centre[1 - axis] + miss, z];
        let mut direction = [0.0; 3];
        if axis == 1 {
            from.swap(0, 1);
        }
        direction[axis] = 1.0;
        solid.chord(from, direction).map(|ends| ends.map(|t| along + t))
    }
}

/// Merged chords on parallel lines in one plane.
struct Lines {
    length: f64,
    chords: Vec<Vec<[f64; 2]>>,
}

impl Lines {
    /// Lines along `axis` (0: x, 1: y), at the midpoints of equal strips.
    fn new(discs: &[Disc], pigment: Option<usize>, period: [f64; 2], spacing: f64, axis: usize) -> Self {
        let length = period[axis];
        let across = period[1 - axis];
        let n = (across / spacing).ceil().max(1.0) as usize;
        let pitch = across / n as f64;
        let mut chords = vec![Vec::new(); n];
        for disc in discs.iter().filter(|d| pigment.is_none_or(|p| p == d.pigment)) {
            let off = disc.centre[1 - axis];
            let first = ((off - disc.radius) / pitch - 0.5).ceil() as i64;
            let last = ((off + disc.radius) / pitch - 0.5).floor() as i64;
            for line in first..=last {
                let miss = (line as f64 + 0.5) * pitch - off;
                let Some([from, to]) = disc.chord(axis, miss) else { continue };
                let start = from.rem_euclid(length);
                push(&mut chords[line.rem_euclid(n as i64) as usize], start, start + to - from, length);
            }
        }
        chords.iter_mut().for_each(merge);
        Self { length, chords }
    }

    fn covered(&self) -> f64 {
        let sum: f64 = self.chords.iter().flatten().map(|c| c[1] - c[0]).sum();
        sum / (self.length * self.chords.len() as f64)
    }

    /// A chord that crosses the edge of the cell is stored in two pieces but is one chord.
    fn chords_per_um(&self) -> f64 {
        let count = |line: &Vec<[f64; 2]>| {
            let cut = line.first().zip(line.last()).is_some_and(|(a, b)| a[0] <= 0.0 && b[1] >= self.length);
            line.len() - usize::from(cut)
        };
        self.chords.iter().map(count).sum::<usize>() as f64 / (self.length * self.chords.len() as f64)
    }

    /// Fraction of the points x for which x and x + r are both covered.
    fn both_ends(&self, r: f64) -> f64 {
        let shifts = [r, r - self.length];
        let both = |line: &Vec<[f64; 2]>| shifts.iter().map(|shift| overlap(line, *shift)).sum::<f64>();
        let sum: f64 = self.chords.iter().map(both).sum();
        sum / (self.length * self.chords.len() as f64)
    }
}

fn push(line: &mut Vec<[f64; 2]>, start: f64, end: f64, length: f64) {
    if end > length {
        line.push([start, length]);
        line.push([0.0, end - length]);
    } else {
        line.push([start, end]);
    }
}

/// Length of the overlap of a set of sorted intervals with itself, shifted.
fn overlap(line: &[[f64; 2]], shift: f64) -> f64 {
    // intervals that end before the first of the others begins share nothing
    let Some(low) = line.first().map(|first| first[0].max(first[0] + shift)) else { return 0.0 };
    let mut i = line.partition_point(|interval| interval[1] <= low);
    let mut j = line.partition_point(|interval| interval[1] + shift <= low);
    let mut sum = 0.0;
    while i < line.len() && j < line.len() {
        let a = line[i];
        let b = [line[j][0] + shift, line[j][1] + shift];
        sum += (a[1].min(b[1]) - a[0].max(b[0])).max(0.0);
        if a[1] < b[1] { i += 1 } else { j += 1 }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Planes look at the spheres near them alone, also across the ends of a layer that repeats:
    /// the same as all spheres one by one. *Planted*: no images.
    #[test]
    fn planes_miss_no_sphere() {
        let mut draws = crate::numerics::Draws::new(3, 0);
        let period = 6.0;
        let height = 1.0;
        for walls in [true, false] {
            let mut sphere = |i: usize| {
                let radius_um = if i.is_multiple_of(7) { 0.2 } else { 0.05 };
                let z = draws.between(0.0, height);
                let z = if walls { z.clamp(radius_um, height - radius_um) } else { z };
                let place = [0.45 + 0.5 * (i % 11) as f64, 0.45 + 0.5 * (i / 11) as f64, z];
                Grain::new(vec![Sphere { center_um: place, radius_um }], 0)
            };
            let grains: Vec<Grain> = (0..121).map(&mut sphere).collect();
            let packing = Packing::from_grains([period; 2], height, walls, grains).unwrap();
            let by_height = SpheresByHeight::new(&packing);
            for k in 0..200 {
                let z = (k as f64 + 0.5) * height / 200.0;
                let mut found: Vec<f64> = by_height.discs(z).iter().map(|disc| disc.radius).collect();
                let radius = |s: &Sphere| {
                    let off = z - s.center_um[2];
                    let off = if walls { off } else { off - height * (off / height).round() };
                    let square = s.radius_um.powi(2) - off * off;
                    (square > 0.0).then(|| square.sqrt())
                };
                let all = packing.grains().iter().flat_map(|g| &g.spheres).filter_map(radius);
                let mut all: Vec<f64> = all.collect();
                found.sort_by(f64::total_cmp);
                all.sort_by(f64::total_cmp);
                assert_eq!(found.len(), all.len(), "walls {walls}, z = {z}");
                assert!(found.iter().zip(&all).all(|(a, b)| (a - b).abs() < 1e-12));
            }
        }
    }

    /// A tiny sphere in a wide cell has as few lines as bearable, and the sections of many grains
    /// remain those of all: the volume by lines three times as far apart.
    #[test]
    fn many_grains_have_fewer_lines_and_the_same_volume() {
        let of = |radius_um: f64, count: usize, period: f64| {
            let pitch = period / count as f64;
            let sphere = |i: usize| {
                let place = [pitch * (i % count) as f64 + 0.013, pitch * (i / count) as f64 + 0.021, 0.5];
                Grain::new(vec![Sphere { center_um: place, radius_um }], 0)
            };
            let grains = (0..count * count).map(sphere).collect();
            Packing::from_grains([period; 2], 1.0, true, grains).unwrap()
        };
        let alone = section_statistics(&of(1e-4, 1, 2.0), 400, 3e-5, 1e-5, 6e-4);
        assert!(alone.spacing_um * MOST_LINES >= 400.0 * 2.0 * (1.0 - 1e-9), "{}", alone.spacing_um);
        let many = of(0.1, 300, 90.0);
        let found = section_statistics(&many, 120, 1.0 / 120.0, 0.01, 0.6);
        assert!(found.spacing_um > 3.0 / 120.0, "{}", found.spacing_um);
        let fraction = found.total_profile().iter().sum::<f64>() / 120.0;
        // Order: midpoint sums over 24 planes through every sphere and lines at many phases
        assert!((fraction / many.achieved_fraction(0) - 1.0).abs() < 3e-3, "{fraction}");
    }

    #[test]
    fn one_sphere_has_the_analytic_section_and_its_own_s2() {
        let sphere = Sphere { center_um: [0.95, 0.4, 0.5], radius_um: 0.3 };
        let grains = vec![Grain::new(vec![sphere], 0)];
        let packing = Packing::from_grains([1.0, 1.0], 1.0, true, grains).unwrap();
        let found = section_statistics(&packing, 200, 0.005, 0.1, 0.3);
        let volume = sphere.volume_um3();
        // Order: midpoint sums of a disc over 120 lines and 120 planes are exact to a few 1e-4.
        let fraction = found.total_profile().iter().sum::<f64>() / 200.0;
        assert!((fraction - volume).abs() < 5e-4 * volume);
        // The volume common to two spheres r apart: v_int = V (1 − r/2R)² (1 + r/4R); L = 1 and A =
        // 1.
        for (r, s2) in found.r_um.iter().zip(&found.s2_x) {
            let t = r / 0.6;
            let common = volume * (1.0 - t).powi(2) * (1.0 + 0.5 * t);
            assert!((s2 - common).abs() < 5e-4 * volume, "{r}: {s2} {common}");
        }
        // Mean number of chords per unit length = projected area.
        let area = std::f64::consts::PI * 0.09;
        assert!((found.chords_per_um[0] - area).abs() < 5e-3 * area);
    }
}
