//! Averages over realisations with their standard errors.

use super::pairs::{PairStatistics, SampledCentres, mean_diameter_um, pair_statistics};
use super::sections::{SectionStatistics, section_statistics};
use super::single::{ReachedSizes, orientation_tensor};
use crate::ink::{Grain, Method, Packing, Relief, Solid, Sphere};
use crate::numerics::estimate::Estimate;
use rayon::prelude::*;

/// A function with standard errors.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct StatisticCurve {
    /// File stem, e.g. "pair_correlation".
    pub name: String,
    /// Quantity and unit along x.
    pub x_label: String,
    /// Quantity and unit along y.
    pub y_label: String,
    /// Abscissae.
    pub x: Vec<f64>,
    /// Ordinates, one for each abscissa.
    pub y: Vec<Estimate>,
}

/// All statistics of an ensemble.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Statistics {
    /// Number of packings.
    pub realisations: usize,
    /// All curves: g(r), nearest neighbours, S2, profiles.
    pub curves: Vec<StatisticCurve>,
    /// Name, unit and value of every scalar.
    pub scalars: Vec<(String, String, Estimate)>,
    /// What was sampled, in packings of very many grains.
    pub remarks: Vec<String>,
}

/// Statistics over realisations of one request; empty without realisations.
pub fn gather(packings: &[Packing]) -> Statistics {
    let mut all = Statistics {
        realisations: packings.len(),
        curves: Vec::new(),
        scalars: Vec::new(),
        remarks: Vec::new(),
    };
    let Some(first) = packings.first().filter(|p| !p.grains().is_empty()) else { return all };
    let d = mean_diameter_um(first);
    // Boxes of voxels have no centres that mean anything.
    let grains = if first.method() == Method::Voxels { &[] } else { packings };
    let pairs: Vec<_> = grains.par_iter().map(|p| pair_statistics(p, 0.02 * d, 5.0 * d)).collect();
    // Grains align with the walls, so the planes must be close together; in the plane, lines sample
    // at random.
    let planes = ((24.0 * first.thickness_um() / d).round() as usize).clamp(20, 400);
    let spacing = d / 6.0;
    let section = |p: &Packing| section_statistics(p, planes, spacing, d / 20.0, 3.0 * d);
    let sections: Vec<SectionStatistics> = packings.par_iter().map(section).collect();
    all.remarks.extend(sampled_lines(&sections, spacing));
    all.remarks.extend(sampled_pairs(&pairs));
    if !pairs.is_empty() {
        all.curves.extend([pair_correlation(&pairs), nearest(&pairs)]);
    }
    all.curves.extend(two_point(&sections));
    all.curves.extend(profiles(&sections));
    all.add_fractions(packings, grains);
    all.add_sizes(packings);
    all.add_structure(grains, &pairs, &sections);
    all.add_tensors(grains);
    all.add_walls(grains);
    all.add_relief(packings);
    all
}

/// Where lines are further apart than wanted.
fn sampled_lines(sections: &[SectionStatistics], wanted_um: f64) -> Option<String> {
    let widest = sections.iter().map(|s| s.spacing_um).fold(0.0, f64::max);
    (widest > wanted_um * (1.0 + 1e-9)).then(|| {
        format!(
            "φ(z) and S2 are from lines {widest:.3} µm apart in every plane instead of {wanted_um:.3} µm, to save time: the \
             packing has very many or very small grains"
        )
    })
}

/// Where not all neighbours were counted.
fn sampled_pairs(pairs: &[PairStatistics]) -> Option<String> {
    let sampled = pairs.iter().map(|p| p.sampled).find(|sampled| sampled.counted < sampled.all)?;
    let SampledCentres { counted, all } = sampled;
    Some(format!("g(r) and nearest neighbours are from the neighbours of {counted} of {all} grains"))
}

/// Mean and standard error of the i-th entry over realisations.
fn pointwise<T>(of: &[T], n: usize, entry: impl Fn(&T, usize) -> f64) -> Vec<Estimate> {
    (0..n).map(|i| Estimate::of_mean(&of.iter().map(|p| entry(p, i)).collect::<Vec<_>>())).collect()
}

/// Pair correlation g(r). Its error is the scatter of the realisations, at least the counting
/// error; shells in which an ideal gas would have fewer than ten pairs are omitted.
fn pair_correlation(pairs: &[PairStatistics]) -> StatisticCurve {
    let n = pairs.iter().map(|p| p.counts.len()).min().unwrap_or(0);
    let gs: Vec<Vec<f64>> = pairs.iter().map(PairStatistics::g).collect();
    let ideal: Vec<f64> = (0..n).map(|i| pairs.iter().map(|p| p.ideal[i]).sum()).collect();
    let counts: Vec<f64> = (0..n).map(|i| pairs.iter().map(|p| p.counts[i]).sum()).collect();
    let start = ideal.iter().position(|pairs| *pairs >= 10.0).unwrap_or(n);
    let all = pointwise(&gs, n, |g, i| g[i]);
    let y = (start..n).map(|i| all[i].at_least(counts[i].sqrt() / ideal[i])).collect();
    let edges = &pairs[0].edges_um;
    let x = (start..n).map(|i| 0.5 * (edges[i] + edges[i + 1])).collect();
    curve("pair_correlation", "distance of centres r, µm", "pair correlation g(r)", x, y)
}

fn curve(name: &str, x_label: &str, y_label: &str, x: Vec<f64>, y: Vec<Estimate>) -> StatisticCurve {
    StatisticCurve { name: name.into(), x_label: x_label.into(), y_label: y_label.into(), x, y }
}

/// Density of the distance to the nearest centre, in 40 classes from the smallest to the largest
/// distance.
fn nearest(pairs: &[PairStatistics]) -> StatisticCurve {
    const CLASSES: usize = 40;
    let all = || pairs.iter().flat_map(|p| &p.nearest_um).copied().filter(|r| r.is_finite());
    let low = all().fold(f64::MAX, f64::min);
    let high = all().fold(0.0, f64::max);
    let width = ((high - low) / CLASSES as f64).max(1e-9);
    let density = |p: &PairStatistics, i: usize| {
        let class = |r: &&f64| (((**r - low) / width) as usize).min(CLASSES - 1) == i && r.is_finite();
        p.nearest_um.iter().filter(class).count() as f64 / (p.nearest_um.len() as f64 * width)
    };
    let x = (0..CLASSES).map(|i| low + (i as f64 + 0.5) * width).collect();
    let y = pointwise(pairs, CLASSES, density);
    curve("nearest_neighbour", "distance to the nearest centre, µm", "density, 1/µm", x, y)
}

fn two_point(sections: &[SectionStatistics]) -> [StatisticCurve; 3] {
    // Cells of varied size have their own separations, with a common step.
    let r = sections.iter().map(|s| &s.r_um).min_by_key(|r| r.len()).map_or(&[][..], Vec::as_slice);
    let named = |name: &str, label: &str, entry: &dyn Fn(&SectionStatistics, usize) -> f64| {
        curve(name, "separation in the plane r, µm", label, r.to_vec(), pointwise(sections, r.len(), entry))
    };
    [
        named("two_point", "two-point probability S2(r)", &|s, i| 0.5 * (s.s2_x[i] + s.s2_y[i])),
        named("two_point_x", "S2 along x", &|s, i| s.s2_x[i]),
        named("two_point_y", "S2 along y", &|s, i| s.s2_y[i]),
    ]
}

fn profiles(sections: &[SectionStatistics]) -> Vec<StatisticCurve> {
    let z = &sections[0].z_um;
    let label = "depth z, µm";
    let total = pointwise(sections, z.len(), |s, i| s.profile.iter().map(|p| p[i]).sum());
    let mut curves = vec![curve("profile", label, "volume fraction φ(z)", z.clone(), total)];
    let pigments = sections[0].profile.len();
    for k in (0..pigments).filter(|_| pigments > 1) {
        let name = format!("profile_pigment_{k}");
        let y_label = format!("φ(z) of pigment {k}");
        let y = pointwise(sections, z.len(), |s, i| s.profile[k][i]);
        curves.push(curve(&name, label, &y_label, z.clone(), y));
    }
    curves
}

impl Statistics {
    /// Adds the mean of a scalar, if it has values.
    fn put(&mut self, name: impl Into<String>, unit: &str, values: impl IntoIterator<Item = f64>) {
        let values: Vec<f64> = values.into_iter().collect();
        if !values.is_empty() {
            self.scalars.push((name.into(), unit.into(), Estimate::of_mean(&values)));
        }
    }

    fn add_fractions(&mut self, packings: &[Packing], with_grains: &[Packing]) {
        for k in 0..packings[0].shares().len() {
            let achieved = packings.iter().map(|p| p.achieved_fraction(k));
            let grains = with_grains.iter().map(|p| p.shares()[k].grains as f64);
            self.put(
                format!("requested fraction of pigment {k}"),
                "1",
                [packings[0].shares()[k].requested_fraction],
            );
            self.put(format!("achieved fraction of pigment {k}"), "1", achieved);
            self.put(format!("grains of pigment {k}"), "1", grains);
        }
    }

    /// Percentiles d10, d50 and d90 of every pigment's grains.
    fn add_sizes(&mut self, packings: &[Packing]) {
        for k in 0..packings[0].shares().len() {
            let all: Vec<_> = packings.iter().filter_map(|p| ReachedSizes::of(p, k)).collect();
            for (i, name) in ["d10", "d50", "d90"].into_iter().enumerate() {
                let said = |by: &str| format!("{name} by {by} of pigment {k}");
                self.put(said("number"), "nm", all.iter().map(|r| r.by_number_nm[i]));
                self.put(said("volume"), "nm", all.iter().map(|r| r.by_volume_nm[i]));
            }
        }
    }

    fn add_structure(
        &mut self,
        packings: &[Packing],
        pairs: &[PairStatistics],
        sections: &[SectionStatistics],
    ) {
        let slopes = sections.iter().map(|s| -0.5 * (s.chords_per_um[0] + s.chords_per_um[1]));
        self.put("mean nearest-neighbour distance", "µm", pairs.iter().map(PairStatistics::mean_nearest_um));
        self.put("smallest gap", "µm", packings.iter().filter_map(|p| p.account().smallest_gap_um));
        self.put("S2(0) from chords", "1", sections.iter().map(|s| 0.5 * (s.s2_x[0] + s.s2_y[0])));
        self.put("slope of S2 at 0 (= −s/4)", "1/µm", slopes);
        self.put("mean of φ(z)², the limit of S2", "1", sections.iter().map(|s| s.mean_square_profile));
    }

    fn add_tensors(&mut self, packings: &[Packing]) {
        for k in 0..packings.first().map_or(0, |p| p.shares().len()) {
            let tensors: Vec<_> = packings.iter().filter_map(|p| orientation_tensor(p, Some(k))).collect();
            let axes = [("xx", 0, 0), ("yy", 1, 1), ("zz", 2, 2), ("xy", 0, 1), ("xz", 0, 2), ("yz", 1, 2)];
            for (name, a, b) in axes {
                let name = format!("orientation tensor Q_{name} of pigment {k}");
                self.put(name, "1", tensors.iter().map(|t| t.q[a][b]));
            }
        }
    }

    fn add_walls(&mut self, packings: &[Packing]) {
        if packings.first().is_some_and(Packing::walls) {
            self.put("grains touching the wall z = 0", "1/µm²", packings.iter().map(|p| touching(p, true)));
            self.put("grains touching the wall z = H", "1/µm²", packings.iter().map(|p| touching(p, false)));
        }
    }

    fn add_relief(&mut self, packings: &[Packing]) {
        let all: Vec<&Relief> = packings.iter().filter_map(Packing::relief).collect();
        self.put("mean height of the binder", "µm", all.iter().map(|r| r.mean_height_um()));
        self.put("rms of the binder's height", "µm", all.iter().map(|r| r.rms_height_um()));
        self.put("share of the pigment above the binder", "1", all.iter().map(|r| r.protruding_share));
        self.put("rms of the free surface (grains and binder)", "µm", all.iter().map(|r| r.rms_surface_um()));
        self.put("pigment fraction below the binder's surface", "1", all.iter().map(|r| r.fraction_below));
    }
}

/// Grains per µm² with a sphere closer than a hundredth of its radius to the wall z = 0 (`top`) or
/// z = H.
fn touching(packing: &Packing, top: bool) -> f64 {
    let depth = |low: f64, high: f64| if top { low } else { packing.thickness_um() - high };
    let near = |s: &Sphere| depth(s.center_um[2], s.center_um[2]) < 1.01 * s.radius_um;
    let edge = |solid: &Solid| {
        let [low, high] = solid.extent_um(2);
        depth(low, high) < 0.01 * solid.form.thin_um()
    };
    let touch = |g: &&Grain| g.solid.as_ref().map_or_else(|| g.spheres.iter().any(near), edge);
    let touches = packing.grains().iter().filter(touch).count();
    touches as f64 / (packing.period_um()[0] * packing.period_um()[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Cells of varied size: the curves reach as far as the smallest cell lets them, whichever
    /// comes first.
    #[test]
    fn curves_of_varied_cells_end_with_the_smallest() {
        let packing = |period: f64| {
            let sphere = Sphere { center_um: [0.3, 0.3, 0.5], radius_um: 0.2 };
            Packing::from_grains([period; 2], 1.0, true, vec![Grain::new(vec![sphere], 0)]).unwrap()
        };
        let curve = |periods: [f64; 2]| gather(&periods.map(packing)).curves[2].x.clone();
        let smaller_last = curve([1.6, 1.2]);
        let smaller_first = curve([1.2, 1.6]);
        assert_eq!(smaller_last, smaller_first);
        assert!((smaller_last.last().unwrap() - 0.6).abs() < 0.02, "{smaller_last:?}");
    }

    /// Both cells have g = 1.25 of 25 pairs in all where 20 are expected: √25/20.
    #[test]
    fn errors_of_g_are_at_least_those_of_counting() {
        let pairs = || PairStatistics {
            edges_um: vec![0.0, 1.0],
            counts: vec![12.5],
            ideal: vec![10.0],
            nearest_um: Vec::new(),
            sampled: SampledCentres::default(),
        };
        let expected = Estimate { value: 1.25, standard_error: Some(0.25) };
        assert_eq!(pair_correlation(&[pairs(), pairs()]).y, [expected]);
    }
}
