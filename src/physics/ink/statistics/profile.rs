//! Volume fractions across the layer.

use crate::ink::grains::volume::in_slices;
use crate::ink::{Layered, Packing};

/// Columns per side for what is beyond a relief.
const COLUMNS: usize = 24;

/// Volume fractions in `slices` equal slices from z = 0: one profile per material of the grains
/// (see [`Packing::materials`]), and last the fraction beyond a relief's surface, if any.
///
/// Overlapping spheres of one grain are counted individually and scaled to the volume of their
/// union, so that the mean for every pigment is its achieved fraction.
pub fn profile(packing: &Packing, slices: usize) -> Vec<Vec<f64>> {
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
        let share = dry * packing.achieved_fraction(pigment);
        let factor = if sum > 0.0 { share * slices as f64 / sum } else { 0.0 };
        fractions.iter_mut().for_each(|slice| materials().for_each(|m| slice[m] *= factor));
        layers += shell.len();
    }
    if packing.relief().is_some() {
        let air = beyond_surface(packing, slices, height);
        for (slice, air) in fractions.iter_mut().zip(air) {
            let grains: f64 = slice.iter().sum();
            slice.push(air * (1.0 - grains).max(0.0));
        }
    }
    fractions
}

/// Fraction of each slice beyond the binder's surface, without regard to grains.
fn beyond_surface(packing: &Packing, slices: usize, height: f64) -> Vec<f64> {
    let period = packing.period_um();
    let column = |k: usize| {
        let at = |i: usize, axis: usize| period[axis] * (i as f64 + 0.5) / COLUMNS as f64;
        packing.filled_um(at(k % COLUMNS, 0), at(k / COLUMNS, 1))
    };
    let filled: Vec<[f64; 2]> = (0..COLUMNS * COLUMNS).map(column).collect();
    let share = |slice: usize| {
        let above = |z: f64| ((z - slice as f64 * height) / height).clamp(0.0, 1.0);
        filled.iter().map(|[from, to]| above(*from) + 1.0 - above(*to)).sum::<f64>() / filled.len() as f64
    };
    (0..slices).map(share).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ink::{PackingRequest, PigmentGrains, ReliefRequest, pack};

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
