//! Optic axes of birefringent grains.

use super::request::PackingRequest;
use crate::ink::Grain;
use crate::numerics::Draws;
use crate::numerics::vector::unit;

/// Seeds of the grains' own streams differ by this, apart from all others: 2⁶⁴ over π.
const NEXT_SEED: u64 = 0x517C_C1B7_2722_0A95;

/// Gives every birefringent grain without an optic axis one. Each is drawn from the grain's own
/// stream, so that no place depends on it.
pub(super) fn give_axes(request: &PackingRequest, grains: &mut [Grain]) {
    for (number, grain) in grains.iter_mut().enumerate() {
        let Some(pigment) = request.pigments.get(grain.pigment) else { continue };
        let Some(written) = pigment.optic_axis.filter(|_| grain.optic_axis.is_none()) else { continue };
        let seed = request.seed.wrapping_add(NEXT_SEED.wrapping_mul(number as u64 + 1));
        let mut draws = Draws::new(seed, request.stream);
        let axis = match &grain.solid {
            Some(solid) => solid.rotation.turn(written),
            None if grain.spheres.len() > 1 => draws.rotation_with_axis(grain.axis).turn(written),
            None => match pigment.orientation.field() {
                Some(field) => field.draw_axis(&mut draws),
                None => draws.direction(),
            },
        };
        grain.optic_axis = Some(unit(axis));
    }
}

#[cfg(test)]
mod tests {
    use crate::ink::{Grain, Orientation, Packing, PackingRequest, PigmentGrains, Shape, pack};
    use crate::numerics::vector::{V3, dot};

    fn request(shape: Shape, orientation: Orientation, optic_axis: Option<V3>) -> PackingRequest {
        let grains = PigmentGrains { orientation, optic_axis, ..PigmentGrains::of(shape, 150.0, 0.2) };
        PackingRequest { period_um: [2.0; 2], pigments: vec![grains], ..PackingRequest::default() }
    }

    fn packed(shape: &Shape, orientation: Orientation, optic_axis: Option<V3>) -> Packing {
        pack(&request(shape.clone(), orientation, optic_axis), &mut ()).expect("20 % pack")
    }

    /// Axes move no grain, and those of spheres are isotropic. *Planted*: axes drawn from the
    /// stream of the places; one axis for all.
    #[test]
    fn axes_of_spheres_are_isotropic_and_move_no_grain() {
        let sphere = Shape::Sphere;
        let with = packed(&sphere, Orientation::Random, Some([0.0, 0.0, 1.0]));
        let without = packed(&sphere, Orientation::Random, None);
        let bare = |packing: &Packing| -> Vec<Grain> {
            packing.grains().iter().map(|g| Grain { optic_axis: None, ..g.clone() }).collect()
        };
        assert_eq!(bare(&with), without.grains());
        let axes: Vec<V3> = with.grains().iter().filter_map(|grain| grain.optic_axis).collect();
        assert_eq!(axes.len(), with.grains().len());
        for i in 0..3 {
            let mean = axes.iter().map(|axis| axis[i] * axis[i]).sum::<f64>() / axes.len() as f64;
            // Significance: cos² has a deviation of 0.3; four standard errors.
            assert!((mean - 1.0 / 3.0).abs() < 4.0 * 0.3 / (axes.len() as f64).sqrt(), "{i}: {mean}");
        }
        assert_eq!((with.extraordinary(0), without.extraordinary(0)), (Some(1), None));
    }

    #[test]
    fn axes_follow_bodies_and_the_alignment_of_spheres() {
        let up = Orientation::Perpendicular { strength: None };
        let discs = Shape::Disc { diameter: 1.0, thickness: 0.5 };
        for grain in packed(&discs, Orientation::Random, Some([0.0, 0.0, 2.0])).grains() {
            let axis = grain.optic_axis.expect("an axis");
            assert!((dot(axis, grain.axis) - 1.0).abs() < 1e-12);
        }
        for grain in packed(&Shape::Sphere, up, Some([0.0, 0.0, 1.0])).grains() {
            assert!(grain.optic_axis.expect("an axis")[2].abs() > 1.0 - 1e-12);
        }
        // across the axis of a union of spheres, at any turn about it
        for grain in packed(&Shape::CYLINDER, up, Some([1.0, 0.0, 0.0])).grains() {
            assert!(dot(grain.optic_axis.expect("an axis"), grain.axis).abs() < 1e-12);
        }
    }

    /// A grain across the faces of a periodic slab has one axis in all of its parts.
    #[test]
    fn the_parts_of_a_cut_grain_share_its_axis() {
        let whole = request(Shape::Sphere, Orientation::Random, Some([0.0, 0.0, 1.0]));
        let slab = |cut: [f64; 2]| PackingRequest { walls: false, cut_um: Some(cut), ..whole.clone() };
        let low = pack(&slab([0.0, 0.5]), &mut ()).expect("a slab");
        let high = pack(&slab([0.5, 1.0]), &mut ()).expect("a slab");
        let mut shared = 0;
        for grain in low.grains() {
            let here = grain.spheres[0].center_um;
            let same = |other: &&Grain| {
                let there = other.spheres[0].center_um;
                (0..2).all(|i| (here[i] - there[i]).abs() < 1e-12)
            };
            for other in high.grains().iter().filter(same) {
                assert_eq!(grain.optic_axis, other.optic_axis);
                shared += 1;
            }
        }
        assert!(shared > 0, "no grain was cut");
    }
}
