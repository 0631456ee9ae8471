//! What packings reach of the profiles of their pigments.

use super::depth::DepthLaw;
use super::placed::Packing;
use super::request::PackingRequest;
use crate::ink::Grain;
use crate::ink::grains::volume::in_slices;

/// Number of equal parts of the depth that are told of.
const PARTS: usize = 3;

/// Shares of the thirds of a layer, as asked and as reached, for every pigment with a profile.
pub(super) fn notes(request: &PackingRequest, packing: &Packing) -> Vec<String> {
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
        let own: Vec<&Grain> = packing.grains().iter().filter(|grain| grain.pigment == k).collect();
        let between_walls = between_walls(&law, &own, height, request.walls);
        let listed = |values: &dyn Fn(usize) -> f64| {
            (0..PARTS).map(|part| format!("{:.3}", values(part))).collect::<Vec<_>>().join(", ")
        };
        notes.push(format!(
            "pigment {}: shares {} in the thirds of the depth, asked {}, of which grains that end at the faces hold {}",
            k + 1,
            listed(&|part| reached[part]),
            listed(&asked),
            listed(&|part| PARTS as f64 * pigment.volume_fraction * between_walls[part])
        ));
    }
    notes
}

/// What part of the volume of grains lies in every third of the depth in the mean, if their
/// centres follow the profile as far as the faces leave them room.
fn between_walls(law: &DepthLaw, grains: &[&Grain], height: f64, walls: bool) -> [f64; PARTS] {
    /// Grains and depths that are tried.
    const GRAINS: usize = 64;
    const DEPTHS: usize = 64;
    let thickness = height * PARTS as f64;
    let mut volumes = [0.0; PARTS];
    for grain in grains.iter().step_by(grains.len().div_ceil(GRAINS).max(1)) {
        let [low, high] = grain.extent_um(2);
        let from = if walls { 0.0 } else { 0.5 * (low - high) };
        let room = (thickness - (high - low) - 2.0 * from).max(0.0);
        let middle = 0.5 * (high - low);
        let within = [(from + middle) / thickness, (from + middle + room) / thickness];
        for i in 0..DEPTHS {
            let depth = law.quantile_within(within, (i as f64 + 0.5) / DEPTHS as f64);
            let moved = grain.lifted(depth * thickness - middle - low);
            let parts = in_slices(&moved.spheres, moved.solid.as_ref(), height, PARTS);
            volumes.iter_mut().zip(parts).for_each(|(sum, part)| *sum += part);
        }
    }
    let all = volumes.iter().sum::<f64>().max(f64::MIN_POSITIVE);
    volumes.map(|volume| volume / all)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ink::packing::request::MethodChoice;
    use crate::ink::{PigmentGrains, Sphere, pack};

    const HEIGHT_UM: f64 = 1.2;
    const RADIUS_UM: f64 = 0.06;
    const PARTS: usize = 6;

    /// Shares in equal parts of the depth of spheres whose centres have a linear density between
    /// the walls.
    fn between_walls(shares: [f64; 2], mean: f64) -> Vec<f64> {
        const STEPS: usize = 4000;
        let mut parts = vec![0.0; PARTS];
        let mut all = 0.0;
        for i in 0..STEPS {
            let room_um = HEIGHT_UM - 2.0 * RADIUS_UM;
            let z = RADIUS_UM + room_um * (i as f64 + 0.5) / STEPS as f64;
            let density = shares[0] + (shares[1] - shares[0]) * z / HEIGHT_UM;
            let sphere = Sphere { center_um: [0.0, 0.0, z], radius_um: RADIUS_UM };
            let within = in_slices(&[sphere], None, HEIGHT_UM / PARTS as f64, PARTS);
            parts.iter_mut().zip(&within).for_each(|(sum, part)| *sum += density * part);
            all += density * within.iter().sum::<f64>();
        }
        parts.into_iter().map(|part| mean * PARTS as f64 * part / all).collect()
    }

    /// Dilute and crowded packings have the shares of centres that are drawn from the profile and
    /// kept there, part by part and in their mean depth. *Planted*: depths redrawn after 64
    /// attempts of all grains (only the mean depth tells), and the profile upside down.
    #[test]
    fn packings_follow_their_profile() {
        for (shares, method) in [
            ([0.04, 0.12], MethodChoice::Auto),
            ([0.1, 0.3], MethodChoice::SequentialAddition),
            ([0.1, 0.3], MethodChoice::Auto),
            ([0.45, 0.2], MethodChoice::Auto),
        ] {
            let rows = vec![[0.0, shares[0]], [1.0, shares[1]]];
            let mean = 0.5 * (shares[0] + shares[1]);
            let grains = PigmentGrains { profile: rows, ..PigmentGrains::spheres(2e3 * RADIUS_UM, mean) };
            let request = PackingRequest {
                period_um: [4.0; 2],
                thickness_um: HEIGHT_UM,
                pigments: vec![grains],
                method,
                ..PackingRequest::default()
            };
            let packing = pack(&request, &mut ()).expect("a packing");
            let mut reached = [0.0; PARTS];
            let part_um = HEIGHT_UM / PARTS as f64;
            for grain in packing.grains() {
                let within = in_slices(&grain.spheres, None, part_um, PARTS);
                reached.iter_mut().zip(within).for_each(|(sum, part)| *sum += part / (16.0 * part_um));
            }
            let grains = packing.grains().len() as f64;
            let all_asked = between_walls(shares, mean);
            let mean_part = |parts: &[f64], power: i32| {
                let sum: f64 = parts.iter().sum();
                let places = parts.iter().enumerate().map(|(part, share)| (part as f64).powi(power) * share);
                places.sum::<f64>() / sum
            };
            let spread = mean_part(&all_asked, 2) - mean_part(&all_asked, 1).powi(2);
            let off = (mean_part(&reached, 1) - mean_part(&all_asked, 1)) / (spread / grains).sqrt();
            assert!(off.abs() < 4.0, "{shares:?}: the mean depth is off by {off} standard errors");
            for (part, (reached, asked)) in reached.iter().zip(all_asked).enumerate() {
                let of_all = asked / (mean * PARTS as f64);
                let error = asked * ((1.0 - of_all) / of_all / grains).sqrt();
                println!("{shares:?} {part}: {reached:.4}, asked {asked:.4} ± {error:.4}");
                // Significance of depths drawn one by one; grains of crowded cells that have no
                // place at their depth take up to 2 % of the share along.
                let off = (reached - asked).abs();
                assert!(off < 4.0 * error + 0.02 * asked, "{shares:?} {part}: {reached} {asked} {error}");
            }
            assert!(packing.account().notes.iter().any(|note| note.contains("thirds of the depth")));
        }
    }

    /// A profile that is even is none, to the last bit.
    #[test]
    fn an_even_profile_is_none() {
        for share in [0.1, 0.4] {
            let even = PigmentGrains::spheres(150.0, share);
            let rows = vec![[0.0, share], [0.3, share], [1.0, share]];
            let packed = |pigment: PigmentGrains| {
                let request = PackingRequest { pigments: vec![pigment], ..PackingRequest::default() };
                pack(&request, &mut ()).expect("a packing")
            };
            let with_rows = packed(PigmentGrains { profile: rows, ..even.clone() });
            let grains = packed(even).grains().to_vec();
            assert_eq!(format!("{:?}", with_rows.grains()), format!("{grains:?}"));
        }
    }
}
