//! Point sources for convex bodies with exact surfaces, as [`super::sources`] has them for balls.
//!
//! N is n nᵀ on every face. Inside it is the mean of the faces' tensors, weighted by the inverse
//! square of the distance to each: smooth everywhere but on the edges, where no normal exists. A
//! horizontal face on a node of the grid needs no tensor: the fields are joined there exactly.

use super::sources::{FIELDS, Slab, Source, VALUES};
use crate::ink::grains::solid::{edges, outward};
use crate::ink::{Form, Solid};
use crate::numerics::vector::{Rotation, V3, dot, scale, sub};
use crate::wave::contrast::section::{EdgePoint, Sampling};

/// Components xx, xy, yy, xz, yz, zz of n nᵀ.
type Square = [f64; FIELDS - 1];

/// A face with its distance from a point and the tensor there.
enum Face {
    /// n · x = offset, about the body's centre.
    Plane { normal: V3, offset: f64 },
    /// A round wall about an axis through the centre.
    Wall { axis: V3, radius: f64 },
    /// An ellipsoid.
    Ellipsoid { rotation: Rotation, semi_axes: V3 },
}

/// Degree that N, which is not a polynomial, adds to the integrand.
const TENSOR_DEGREE: f64 = 6.0;

/// Sources of a convex body within a cell; `nodes` are the heights of the grid, µm.
pub(super) fn of_solid(
    solid: &Solid,
    nodes: &[f64],
    slab: &Slab,
    sampling: &Sampling,
    push: &mut impl FnMut(Source),
) {
    let faces = faces(solid, nodes);
    sampling.cuts(solid, slab.range_um, TENSOR_DEGREE, &mut |z, weight, edge| {
        let shares = slab.point(z, weight, z).map(|[share, ..]| share);
        fan((solid, &faces), edge, sampling, (z, shares), push);
    });
}

/// A cut as a fan of triangles from a point inside it to its edge.
fn fan(
    (solid, faces): (&Solid, &[Face]),
    edge: &[EdgePoint],
    sampling: &Sampling,
    (z, shares): (f64, [f64; 2]),
    push: &mut impl FnMut(Source),
) {
    let inside = [0, 1].map(|i| edge.iter().map(|p| p.position[i]).sum::<f64>() / edge.len() as f64);
    for point in edge {
        let to = [0, 1].map(|i| point.position[i] - inside[i]);
        let cone = to[0] * point.normal[0] + to[1] * point.normal[1];
        let degree = sampling.demands.degree(0.5 * to[0].hypot(to[1])) + TENSOR_DEGREE;
        for &(x, w) in sampling.rules.of((0.5 * degree).ceil() as usize + 1) {
            let s = 0.5 * (1.0 + x);
            let position = [0, 1].map(|i| inside[i] + s * to[i]);
            let tensor = tensor(faces, sub([position[0], position[1], z], solid.center_um));
            push(Source { position, values: values(&tensor, shares.map(|m| 0.5 * w * s * cone * m)) });
        }
    }
}

fn values(tensor: &Square, shares: [f64; 2]) -> [f64; VALUES] {
    let field = |f: usize| if f == 0 { 1.0 } else { tensor[f - 1] };
    std::array::from_fn(|i| field(i / 2) * shares[i % 2])
}

/// All faces but horizontal ones that lie on a node.
fn faces(solid: &Solid, nodes: &[f64]) -> Vec<Face> {
    let turn = |v: V3| solid.rotation.turn(v);
    let ends =
        |half: f64| [-1.0, 1.0].map(|side| Face::Plane { normal: turn([0.0, 0.0, side]), offset: half });
    let mut faces = match &solid.form {
        Form::Ellipsoid { semi_axes_um } => {
            vec![Face::Ellipsoid { rotation: solid.rotation.inverse(), semi_axes: *semi_axes_um }]
        }
        Form::Disc { radius_um, half_length_um } => {
            let wall = Face::Wall { axis: turn([0.0, 0.0, 1.0]), radius: *radius_um };
            ends(*half_length_um).into_iter().chain([wall]).collect()
        }
        Form::Prism { corners_um, half_length_um } => {
            let sides = edges(corners_um).map(|(a, b)| {
                let normal = outward(a, b);
                Face::Plane { normal: turn(normal), offset: normal[0] * a[0] + normal[1] * a[1] }
            });
            ends(*half_length_um).into_iter().chain(sides).collect()
        }
    };
    let slack = 1e-9 * solid.form.reach_um();
    faces.retain(|face| !is_on_node(face, solid.center_um[2], nodes, slack));
    faces
}

fn is_on_node(face: &Face, center: f64, nodes: &[f64], slack: f64) -> bool {
    let Face::Plane { normal: [_, _, up], offset } = face else { return false };
    up.abs() > 1.0 - 1e-12 && nodes.iter().any(|z| (center + up * offset - z).abs() < slack)
}

/// N at a point x relative to the body's centre.
fn tensor(faces: &[Face], x: V3) -> Square {
    let mut total = 0.0;
    let mut sum = [0.0; FIELDS - 1];
    for face in faces {
        let (distance, own) = face.at(x);
        let weight = 1.0 / distance.powi(2).max(1e-24);
        total += weight;
        sum.iter_mut().zip(own).for_each(|(s, n)| *s += weight * n);
    }
    if faces.is_empty() { sum } else { sum.map(|s| s / total) }
}

impl Face {
    /// Distance from a point inside, µm, and the tensor there.
    fn at(&self, x: V3) -> (f64, Square) {
        match self {
            Face::Plane { normal, offset } => (offset - dot(*normal, x), square(*normal)),
            Face::Wall { axis, radius } => {
                let across = sub(x, scale(*axis, dot(*axis, x)));
                let gap = (radius * radius - dot(across, across)) / (2.0 * radius);
                (gap, square(scale(across, 1.0 / radius)))
            }
            Face::Ellipsoid { rotation, semi_axes } => (1.0, ellipsoid(*rotation, *semi_axes, x)),
        }
    }
}

/// (M y)(M y)ᵀ / (|M y|² + μ (1 − |y|²)) with x = M⁻¹ y in the body's frame: n nᵀ on the surface
/// |y| = 1, x xᵀ/R² for a sphere, and smooth within; μ is the geometric mean of M².
fn ellipsoid(into: Rotation, semi_axes: V3, x: V3) -> Square {
    let own = into.turn(x);
    let y: V3 = std::array::from_fn(|i| own[i] / semi_axes[i]);
    let gradient: V3 = std::array::from_fn(|i| y[i] / semi_axes[i]);
    let mean = (semi_axes[0] * semi_axes[1] * semi_axes[2]).powf(-2.0 / 3.0);
    let norm = dot(gradient, gradient) + mean * (1.0 - dot(y, y)).max(0.0);
    square(scale(into.inverse().turn(gradient), 1.0 / norm.sqrt()))
}

fn square([x, y, z]: V3) -> Square {
    [x * x, x * y, y * y, x * z, y * z, z * z]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::vector::{add, cross, norm, unit};

    /// On every face N is the projector on the normal, which the triangles of the surface have.
    #[test]
    fn the_tensor_projects_on_the_normal_at_the_surface() {
        let corners_um = vec![[-0.1, -0.1], [0.2, -0.1], [-0.1, 0.2]];
        for form in [
            Form::Ellipsoid { semi_axes_um: [0.3, 0.2, 0.1] },
            Form::Disc { radius_um: 0.2, half_length_um: 0.1 },
            Form::Prism { corners_um, half_length_um: 0.2 },
        ] {
            let rotation = Rotation::by([0.4, -0.2, 0.9]);
            let solid = Solid { form, center_um: [0.0; 3], rotation };
            let faces = faces(&solid, &[]);
            for [a, b, c] in solid.triangles(200) {
                let middle = scale(add(a, add(b, c)), 1.0 / 3.0);
                let normal = unit(cross(sub(b, a), sub(c, a)));
                let found = tensor(&faces, middle);
                let off = found.iter().zip(square(normal)).map(|(f, n)| (f - n).abs()).fold(0.0, f64::max);
                // A facet's middle lies below the surface by up to its sagitta, 1e-4 of the size.
                let edge = norm(sub(a, b)).min(norm(sub(a, c))).min(norm(sub(b, c)));
                assert!(off < 0.05 || edge < 0.01, "{:?}: {found:?} {normal:?}", solid.form);
            }
        }
    }
}
