//! What packings reach of the profiles of their pigments.

use super::depth::DepthLaw;
use super::placed::Packing;
use super::request::PackingRequest;
use crate::ink::grains::volume::in_slices;

/// Shares of the thirds of a layer, as asked and as reached, for every pigment with a profile.
pub(super) fn notes(request: &PackingRequest, packing: &Packing) -> Vec<String> {
    const PARTS: usize = 3;
    let mut notes = Vec::new();
    for (k, pigment) in request.pigments.iter().enumerate() {
        let Some(law) = DepthLaw::of(&pigment.profile) else { continue };
        let [lx, ly] = packing.period_um();
        let height = packing.thickness_um() / PARTS as f64;
        let mut reached = [0.0; PARTS];
        for grain in packing.grains().iter().filter(|grain| grain.pigment == k) {
            let within = in_slices(&grain.spheres, grain.solid.as_ref(), height, PARTS);
            let scale = grain.volume_um3 / within.iter().sum::<f64>() / (lx * ly * height);
            reached.iter_mut().zip(within).for_each(|(sum, part)| *sum += scale * part);
        }
        let asked = |part: usize| {
            let at = |i: usize| law.share_above(i as f64 / PARTS as f64);
            PARTS as f64 * pigment.volume_fraction * (at(part + 1) - at(part))
        };
        let listed = |values: &dyn Fn(usize) -> f64| {
            (0..PARTS).map(|part| format!("{:.3}", values(part))).collect::<Vec<_>>().join(", ")
        };
        notes.push(format!(
            "pigment {}: shares {} in the thirds of the depth, asked {}",
            k + 1,
            listed(&|part| reached[part]),
            listed(&asked)
        ));
    }
    notes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ink::{PigmentGrains, pack};

    /// Dilute and crowded packings follow the profile. *Planted*: the profile upside down.
    #[test]
    fn packings_follow_their_profile() {
        for shares in [[0.04, 0.12], [0.2, 0.4]] {
            let rows = vec![[0.0, shares[0]], [1.0, shares[1]]];
            let mean = 0.5 * (shares[0] + shares[1]);
            let grains = PigmentGrains { profile: rows, ..PigmentGrains::spheres(120.0, mean) };
            let request = PackingRequest {
                period_um: [2.5; 2],
                thickness_um: 1.2,
                pigments: vec![grains],
                ..PackingRequest::default()
            };
            let packing = pack(&request, &mut ()).expect("a packing");
            // middles of the halves: a quarter and three quarters of the depth
            let of_half = |half: usize| {
                let grains = packing.grains().iter();
                let volumes = grains.map(|g| in_slices(&g.spheres, None, 0.6, 2)[half]);
                volumes.sum::<f64>() / (2.5 * 2.5 * 0.6)
            };
            let want = |depth: f64| shares[0] + (shares[1] - shares[0]) * depth;
            // 300 grains and more: 6 % of either half
            for (half, depth) in [(0, 0.25), (1, 0.75)] {
                let off = of_half(half) / want(depth) - 1.0;
                assert!(off.abs() < 0.15, "{shares:?} {half}: {}", of_half(half));
            }
            assert!(packing.account().notes.iter().any(|note| note.contains("thirds of the depth")));
        }
    }
}
