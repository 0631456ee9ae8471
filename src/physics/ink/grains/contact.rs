//! Contact of two convex bodies, and the proof that they are apart.
//!
//! The contact (distance, or depth of penetration, and normal) comes from parry's search with
//! support mappings. The proof does not trust it: two bodies are apart if some direction separates
//! their shadows, and a direction is judged by the closed widths of the forms alone.

use super::solid::{Form, Solid, edges, outward};
use crate::numerics::vector::{V3, add, dot, scale, sub, unit};
use parry3d_f64::math::{Pose, Vector};
use parry3d_f64::query::details::contact_support_map_support_map;
use parry3d_f64::shape::SupportMap;

/// Nearest or deepest points of two bodies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Distance between the surfaces, µm; negative if the bodies overlap.
    pub gap_um: f64,
    /// Unit vector from the first body to the second.
    pub normal: V3,
    /// The points, each relative to its body's centre, µm.
    pub arms: [V3; 2],
}

/// A body in a unit of length, about its centre.
struct Scaled<'a> {
    solid: &'a Solid,
    unit_um: f64,
}

impl SupportMap for Scaled<'_> {
    fn local_support_point(&self, direction: Vector) -> Vector {
        Vector::from_array(scale(self.solid.arm(direction.to_array()), 1.0 / self.unit_um))
    }
}

/// The contact of two bodies whose centres are `apart` (second less first), µm, if their distance
/// is at most `within_um`.
pub fn contact(first: &Solid, second: &Solid, apart: V3, within_um: f64) -> Option<Contact> {
    // parry's tolerances are absolute, for bodies of the size of one.
    let unit_um = first.form.reach_um().max(second.form.reach_um());
    let a = Scaled { solid: first, unit_um };
    let b = Scaled { solid: second, unit_um };
    let place = Pose::from_translation(Vector::from_array(scale(apart, 1.0 / unit_um)));
    let nearest = contact_support_map_support_map(&place, &a, &b, within_um / unit_um)?;
    let normal = nearest.normal1.to_array();
    let sound = nearest.dist.is_finite() && normal.iter().all(|x| x.is_finite());
    let arms = [scale(nearest.point1.to_array(), unit_um), scale(nearest.point2.to_array(), unit_um)];
    sound.then_some(Contact { gap_um: nearest.dist * unit_um, normal, arms })
}

/// A distance that two bodies surely have, µm: that of their shadows along the best direction
/// tried. Negative if none separates them; then the bodies overlap by at most as much.
pub fn proven_gap_um(first: &Solid, second: &Solid, apart: V3) -> f64 {
    let between = |n: V3| dot(n, apart) - half_width(first, n) - half_width(second, scale(n, -1.0));
    let far = first.form.reach_um() + second.form.reach_um() + dot(apart, apart).sqrt();
    let nearest = contact(first, second, apart, far).map(|c| c.normal);
    let flat = [first, second].into_iter().flat_map(normals).flat_map(|n| [n, scale(n, -1.0)]);
    flat.chain(nearest).chain([unit(apart)]).map(|n| between(unit(n))).fold(f64::NEG_INFINITY, f64::max)
}

/// Largest coordinate of a body along the unit vector n, relative to its centre, µm.
fn half_width(solid: &Solid, n: V3) -> f64 {
    let axis = |v: V3| dot(solid.rotation.turn(v), n);
    let x = axis([1.0, 0.0, 0.0]);
    let y = axis([0.0, 1.0, 0.0]);
    let z = axis([0.0, 0.0, 1.0]);
    match &solid.form {
        Form::Ellipsoid { semi_axes_um: [a, b, c] } => (a * x).hypot(b * y).hypot(c * z),
        Form::Disc { radius_um, half_length_um } => radius_um * x.hypot(y) + half_length_um * z.abs(),
        Form::Prism { corners_um, half_length_um } => {
            let corners = corners_um.iter().map(|c| c[0] * x + c[1] * y);
            corners.fold(f64::NEG_INFINITY, f64::max) + half_length_um * z.abs()
        }
    }
}

/// Normals of a body's flat faces.
fn normals(solid: &Solid) -> Vec<V3> {
    let corners = if let Form::Prism { corners_um, .. } = &solid.form { &corners_um[..] } else { &[] };
    let in_frame = edges(corners).map(|(a, b)| outward(a, b)).chain([[0.0, 0.0, 1.0]]);
    in_frame.map(|n| solid.rotation.turn(n)).collect()
}

/// Steps from a point of the inner body's surface to the one farthest out of the other.
const ASCENTS: usize = 50;

/// How far a body, whose centre is `apart` from the other's, reaches out of that other one, µm (of
/// an ellipsoid along its shortest axis); negative if it lies inside.
///
/// Each step goes to the point farthest along the normal, which increases a convex function; it
/// starts from corners all around, and of flat faces from the point farthest along each.
pub fn excess_um(inner: &Solid, outer: &Solid, apart: V3) -> f64 {
    let inner = inner.placed(apart);
    let outer = outer.placed([0.0; 3]);
    let farthest = |n: V3| add(apart, inner.arm(n));
    let flat = normals(&outer).into_iter().flat_map(|n| [farthest(n), farthest(scale(n, -1.0))]);
    let ascended = |start: V3| {
        let path = std::iter::successors(Some(start), |&p| Some(farthest(outer.normal(p))));
        path.take(ASCENTS).map(|p| depth_um(&outer, p)).fold(f64::NEG_INFINITY, f64::max)
    };
    flat.chain(inner.triangles(4).into_iter().flatten()).map(ascended).fold(f64::NEG_INFINITY, f64::max)
}

/// Signed distance of a point from the farthest face of a body about the origin.
fn depth_um(solid: &Solid, point: V3) -> f64 {
    solid.form.nearest_face(solid.rotation.inverse().turn(point)).0
}

/// Whether a point lies in a body, by the inequalities that define its form.
pub fn contains(solid: &Solid, point: V3) -> bool {
    depth_um(solid, sub(point, solid.center_um)) < 0.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::Draws;
    use crate::numerics::vector::{Rotation, norm};

    fn drawn(draws: &mut Draws) -> Solid {
        let [a, b, c] = std::array::from_fn(|_| draws.between(0.1, 1.0));
        let form = match draws.between(0.0, 4.0) as usize {
            0 => Form::Ellipsoid { semi_axes_um: [a, b, c] },
            1 => Form::Disc { radius_um: a, half_length_um: 0.3 * b },
            2 => Form::cuboid([a, b, c]),
            _ => Form::Prism { corners_um: vec![[a, 0.0], [-a, b], [-a, -b]], half_length_um: c },
        };
        let rotation = Rotation::from_z_to(draws.direction()).then(Rotation::by(draws.direction()));
        Solid { form, center_um: [0.0; 3], rotation }
    }

    /// Surface points of one body, dense enough, decide whether it meets the other.
    #[test]
    fn contact_and_proof_agree_with_dense_points_of_the_surfaces() {
        let mut draws = Draws::new(7, 0);
        let mut apart = 0;
        let mut meeting = 0;
        for _ in 0..400 {
            let first = drawn(&mut draws);
            let mut second = drawn(&mut draws);
            let delta = scale(draws.direction(), draws.between(0.3, 2.0));
            second.center_um = delta;
            let steps = 40;
            let corner_in = |one: &Solid, other: &Solid| {
                one.triangles(steps).into_iter().flatten().any(|p| contains(other, p))
            };
            let overlap = corner_in(&first, &second) || corner_in(&second, &first);
            let gap = proven_gap_um(&first, &second, delta);
            assert!(gap <= 0.0 || !overlap, "{first:?} {second:?}: {gap}");
            let found = contact(&first, &second, delta, 10.0).expect("a contact within any distance");
            // The best direction bounds the distance from below, and the search attains it.
            assert!((found.gap_um - gap).abs() < 1e-5 || gap < 0.0, "{first:?} {second:?}: {found:?} {gap}");
            assert_eq!(found.gap_um > 1e-5, gap > 1e-5, "{first:?} {second:?}: {found:?} {gap}");
            let points = [found.arms[0], add(delta, found.arms[1])];
            assert!((norm(sub(points[1], points[0])) - found.gap_um.abs()).abs() < 1e-4, "{found:?}");
            apart += usize::from(gap > 0.0);
            meeting += usize::from(overlap);
        }
        assert!(apart > 80 && meeting > 80, "both answers occur: {apart} {meeting}");
    }

    /// The farthest of dense points of the surface is no farther out than the ascents say.
    #[test]
    fn a_body_reaches_out_of_another_as_far_as_its_farthest_point() {
        let mut draws = Draws::new(8, 0);
        let mut inside = 0;
        for _ in 0..400 {
            let outer = drawn(&mut draws);
            let mut inner = drawn(&mut draws);
            inner.form = inner.form.scaled(0.3);
            let apart = scale(draws.direction(), draws.between(0.0, 0.3));
            let points = inner.triangles(40).into_iter().flatten().map(|p| depth_um(&outer, add(apart, p)));
            let most = points.fold(f64::MIN, f64::max);
            let found = excess_um(&inner, &outer, apart);
            assert!(found > most - 1e-12 && found < most + 2e-3, "{inner:?} {outer:?}: {most} {found}");
            inside += usize::from(found < 0.0);
        }
        assert!((40..360).contains(&inside), "both answers occur: {inside}");
    }
}
