//! Statistics of single grains: the orientation tensor of elongated ones, achieved sizes as
//! particle sizers report them, and volume fractions across the layer.

use crate::ink::grains::volume::in_slices;
use crate::ink::{Layered, Method, Packing, Solid, Sphere};
use std::array::from_fn;
use std::f64::consts::PI;

/// Q = (3⟨u u⟩ − 1)/2 over the axes of grains of more than one sphere: zero if isotropic (standard
/// error of a diagonal component 0.447/√N), diag(−½, −½, 1) if all are along z, diag(¼, ¼, −½) if
/// all are in the plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrientationTensor {
    /// Q, symmetric and traceless, in the coordinates of the cell.
    pub q: [[f64; 3]; 3],
    /// Number of elongated grains averaged.
    pub grains: usize,
}

/// The tensor of one pigment, or of all for `None`; the result is `None` without elongated grains.
pub fn orientation_tensor(packing: &Packing, pigment: Option<usize>) -> Option<OrientationTensor> {
    let grains = packing.grains().iter().filter(|g| pigment.is_none_or(|k| k == g.pigment));
    let elongated = grains.filter(|g| g.solid.is_some() || g.spheres.len() > 1);
    let axes: Vec<[f64; 3]> = elongated.map(|g| g.axis).collect();
    let mean = |a: usize, b: usize| axes.iter().map(|u| u[a] * u[b]).sum::<f64>() / axes.len() as f64;
    let unit = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let q = from_fn(|a| from_fn(|b| 1.5 * mean(a, b) - 0.5 * unit[a][b]));
    (!axes.is_empty()).then_some(OrientationTensor { q, grains: axes.len() })
}

/// Fractions of the grains below d10, d50 and d90.
const SHARES: [f64; 3] = [0.1, 0.5, 0.9];

/// d10, d50 and d90 of the effective diameters of packed grains, nm.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ReachedSizes {
    /// Percentiles by number of grains.
    pub by_number_nm: [f64; 3],
    /// Percentiles by volume.
    pub by_volume_nm: [f64; 3],
}

impl ReachedSizes {
    /// Percentiles of one pigment's grains; `None` without grains, and of voxels.
    pub fn of(packing: &Packing, pigment: usize) -> Option<Self> {
        let counts = packing.method() != Method::Voxels;
        let grains = packing.grains().iter().filter(|grain| counts && grain.pigment == pigment);
        Self::of_volumes(grains.map(|grain| grain.volume_um3).collect())
    }

    fn of_volumes(mut um3: Vec<f64>) -> Option<Self> {
        um3.sort_by(f64::total_cmp);
        (!um3.is_empty()).then(|| Self {
            by_number_nm: SHARES.map(|share| percentile_nm(&um3, share, |_| 1.0)),
            by_volume_nm: SHARES.map(|share| percentile_nm(&um3, share, |volume| volume)),
        })
    }

    /// Display of both sets of percentiles.
    pub fn in_words(&self) -> String {
        let listed = |[d10, d50, d90]: [f64; 3]| format!("{d10:.0}, {d50:.0}, {d90:.0} nm");
        format!("{} by number; {} by volume", listed(self.by_number_nm), listed(self.by_volume_nm))
    }
}

/// Weighted quantile of the effective diameters, nm: each grain is placed at the middle of its own
/// weight, with linear interpolation between grains.
fn percentile_nm(um3: &[f64], share: f64, weight: fn(f64) -> f64) -> f64 {
    let diameter = |volume: f64| 1e3 * (6.0 * volume / PI).cbrt();
    let target = share * um3.iter().map(|v| weight(*v)).sum::<f64>();
    let mut below = 0.0;
    // the grain before: middle of its weight, and diameter
    let mut last: Option<(f64, f64)> = None;
    for &volume in um3 {
        let middle = below + 0.5 * weight(volume);
        let nm = diameter(volume);
        if middle >= target {
            let Some((last_middle, last_nm)) = last else { return nm };
            return last_nm + (nm - last_nm) * (target - last_middle) / (middle - last_middle);
        }
        below += weight(volume);
        last = Some((middle, nm));
    }
    last.map_or(0.0, |(_, nm)| nm)
}

/// Columns per side for what is beyond a relief.
const COLUMNS: usize = 24;

/// Volume fractions in `slices` equal slices from z = 0: one profile per material of the grains
/// (see [`Packing::materials`]), and last the fraction beyond a relief's surface, if any.
///
/// Overlapping spheres of one grain are counted individually and scaled to the volume of their
/// union, so that the mean for every pigment is its achieved fraction. A stack has as many equal
/// slices in each of its layers, one layer after the other.
pub fn profile(packing: &Packing, slices: usize) -> Vec<Vec<f64>> {
    if packing.layers_um().len() > 1 {
        return profile_of_stack(packing, slices);
    }
    let height = packing.thickness_um() / slices as f64;
    let mut fractions = vec![vec![0.0; packing.materials()]; slices];
    for grain in packing.grains() {
        let mut around: Option<usize> = None;
        for Layered { material, spheres, solid } in packing.nested(grain) {
            let volumes = in_slices(&spheres, solid.as_ref(), height, slices);
            for (slice, volume) in fractions.iter_mut().zip(volumes) {
                slice[material] += volume;
                around.iter().for_each(|&outer| slice[outer] -= volume);
            }
            around = Some(material);
        }
    }
    // Fractions of a layer with a relief refer to its dry height.
    let dry = packing.relief().map_or(1.0, |relief| relief.dry_height_um / packing.thickness_um());
    let mut layers = packing.shells_um().len();
    for (pigment, shell) in packing.shells_um().iter().enumerate() {
        let materials = || (layers..layers + shell.len()).chain([pigment]);
        let sum: f64 = fractions.iter().flat_map(|slice| materials().map(|m| slice[m])).sum();
        let target = dry * packing.achieved_fraction(pigment) * slices as f64;
        let factor = if sum > 0.0 { target / sum } else { 0.0 };
        fractions.iter_mut().for_each(|slice| materials().for_each(|m| slice[m] *= factor));
        layers += shell.len();
    }
    if packing.relief().is_some() {
        for (slice, air) in fractions.iter_mut().zip(beyond_surface(packing, slices, height, 0.0)) {
            let grains: f64 = slice.iter().sum();
            slice.push(air * (1.0 - grains).max(0.0));
        }
    }
    fractions
}

/// The profile of a stack, layer by layer.
fn profile_of_stack(packing: &Packing, slices: usize) -> Vec<Vec<f64>> {
    let [lx, ly] = packing.period_um();
    let mut volumes = Vec::new();
    let mut bottom_um = 0.0;
    let mut beyond = Vec::new();
    for &thickness_um in packing.layers_um() {
        let height = thickness_um / slices as f64;
        let within = volumes_within(packing, bottom_um, height, slices);
        let fraction = |volume: f64| volume / (lx * ly * height);
        volumes.extend(within.into_iter().map(|slice| slice.into_iter().map(fraction).collect::<Vec<_>>()));
        if packing.relief().is_some() {
            beyond.extend(beyond_surface(packing, slices, height, bottom_um));
        }
        bottom_um += thickness_um;
    }
    for (slice, air) in volumes.iter_mut().zip(beyond) {
        let grains: f64 = slice.iter().sum();
        slice.push(air * (1.0 - grains).max(0.0));
    }
    volumes
}

/// Volume of every material in equal slices from z = `bottom_um`, µm³: that of the spheres of a
/// grain is scaled to the volume of their union.
fn volumes_within(packing: &Packing, bottom_um: f64, height: f64, slices: usize) -> Vec<Vec<f64>> {
    let mut volumes = vec![vec![0.0; packing.materials()]; slices];
    for grain in packing.grains() {
        let parts: f64 = grain.spheres.iter().map(Sphere::volume_um3).sum();
        // the profile of a convex body is sampled on lines
        let sampled =
            |solid: &Solid| in_slices(&[], Some(&solid.lowered(solid.extent_um(2)[0])), f64::MAX, 1)[0];
        let scale = grain.volume_um3 / grain.solid.as_ref().map_or(parts, sampled);
        let mut around: Option<usize> = None;
        for Layered { material, mut spheres, solid } in packing.nested(grain) {
            spheres.iter_mut().for_each(|sphere| sphere.center_um[2] -= bottom_um);
            let solid = solid.map(|solid| solid.lowered(bottom_um));
            let within = in_slices(&spheres, solid.as_ref(), height, slices);
            for (slice, volume) in volumes.iter_mut().zip(within) {
                slice[material] += scale * volume;
                around.iter().for_each(|&outer| slice[outer] -= scale * volume);
            }
            around = Some(material);
        }
    }
    volumes
}

/// Fraction of each slice from z = `bottom_um` beyond the binder's surface, whatever the grains.
fn beyond_surface(packing: &Packing, slices: usize, height: f64, bottom_um: f64) -> Vec<f64> {
    let [lx, ly] = packing.period_um();
    let place = |i: usize, period: f64| period * (i as f64 + 0.5) / COLUMNS as f64;
    let column = |k: usize| packing.filled_um(place(k % COLUMNS, lx), place(k / COLUMNS, ly));
    let filled: Vec<[f64; 2]> = (0..COLUMNS * COLUMNS).map(column).collect();
    let share = |slice: usize| {
        let above = |z: f64| ((z - bottom_um - slice as f64 * height) / height).clamp(0.0, 1.0);
        filled.iter().map(|[from, to]| above(*from) + 1.0 - above(*to)).sum::<f64>() / filled.len() as f64
    };
    (0..slices).map(share).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ink::{By, Measure, PackingRequest, PigmentGrains, ReliefRequest, SizeDistribution, pack};
    use crate::numerics::Draws;

    /// Grains drawn by volume have the requested percentiles by volume, and those of Hatch and
    /// Choate by number. *Planted*: numbers for volumes.
    #[test]
    fn packed_sizes_have_the_percentiles_asked_for() {
        let d10_nm = 154.8;
        let d50_nm = 200.0;
        let d90_nm = 258.4;
        let of = Measure::EffectiveDiameter;
        let law = SizeDistribution::Percentiles { d10_nm, d50_nm, d90_nm, by: By::Volume, of };
        let sizes = law.strata_nm(4000, &mut Draws::new(3, 0));
        let volumes = sizes.iter().map(|nm| PI / 6.0 * (1e-3 * nm).powi(3)).collect();
        let reached = ReachedSizes::of_volumes(volumes).unwrap();
        for (got, want) in reached.by_volume_nm.iter().zip([d10_nm, d50_nm, d90_nm]) {
            // truncation at three deviations, and steps of 4000 grains
            assert!((got / want - 1.0).abs() < 5e-3, "{reached:?}");
        }
        // σ = 0.2: the median by number is e^{−0.12} of that by volume
        assert!((reached.by_number_nm[1] / 177.4 - 1.0).abs() < 0.01, "{reached:?}");
        assert!(reached.in_words().ends_with("by volume") && ReachedSizes::of_volumes(Vec::new()).is_none());
    }

    #[test]
    fn the_profile_has_the_achieved_fraction_and_thins_at_the_walls() {
        let request = PackingRequest {
            period_um: [1.5, 1.5],
            thickness_um: 1.0,
            pigments: vec![PigmentGrains::spheres(200.0, 0.2)],
            ..Default::default()
        };
        let packing = pack(&request, &mut ()).unwrap();
        let profile = profile(&packing, 20);
        let mean: f64 = profile.iter().map(|slice| slice[0]).sum::<f64>() / 20.0;
        assert!((mean - packing.achieved_fraction(0)).abs() < 1e-12);
        // Centres stay 100 nm away from the walls: only caps reach the outermost 50 nm.
        assert!(profile[0][0] < 0.5 * profile[5][0] && profile[19][0] < 0.5 * profile[14][0]);
    }

    /// Above a level surface, grains and air fill every slice, and grains protrude.
    #[test]
    fn air_is_what_protruding_grains_leave() {
        let request = PackingRequest {
            period_um: [1.0, 1.0],
            thickness_um: 0.5,
            pigments: vec![PigmentGrains::spheres(200.0, 0.2)],
            relief: Some(ReliefRequest { depth_um: 0.15, ..Default::default() }),
            ..Default::default()
        };
        let packing = pack(&request, &mut ()).unwrap();
        let all = profile(&packing, 20);
        let mean = all.iter().map(|slice| slice[0]).sum::<f64>() / 20.0;
        // of the dry 350 nm, in a layer of 500
        assert!((mean - 0.7 * packing.achieved_fraction(0)).abs() < 1e-12, "{mean}");
        // Slices of 25 nm; the binder is at most as high as all of the dry ink, 350 nm.
        let above = (packing.filled_um(0.0, 0.0)[0] / 0.025) as usize;
        assert!(above >= 5, "{above}");
        let slices = &all[..above];
        assert!(slices.iter().any(|slice| slice[0] > 0.01), "{slices:?}");
        for slice in slices {
            assert!((slice[0] + slice[1] - 1.0).abs() < 1e-12, "{slice:?}");
        }
    }
}
