//! Point sources for convex bodies with exact surfaces, as [`super::sources`] has them for balls.
//!
//! N is n nᵀ on every face. Inside it is the mean of the faces' tensors, weighted by the inverse
//! square of the distance to each: smooth everywhere but on the edges, where no normal exists. In a
//! layer the faces of the bodies inside count too. A horizontal face on a node of the grid needs no
//! tensor: the fields are joined there exactly. Bodies inside others may be single spheres and
//! convex bodies.

use super::sources::{FIELDS, NormalField, Slab, Source, VALUES, fan};
use crate::ink::Sphere;
use crate::ink::grains::solid::{edges, outward};
use crate::ink::{Form, Solid};
use crate::numerics::vector::{Rotation, V3, dot, scale, sub};
use crate::wave::contrast::section::{Edge, Sampling};
use crate::wave::{Body, BodyShape, Scene};

/// Components xx, xy, yy, xz, yz, zz of n nᵀ.
pub(super) type Square = [f64; FIELDS - 1];

/// The surface of a body: of the outer one, or of one inside the layer.
struct SolidSurface {
    center: V3,
    /// Every face; whether it needs no tensor.
    faces: Vec<(Face, bool)>,
    inner: bool,
}

/// A face with its distance from a point and the tensor there.
enum Face {
    /// n · x = offset, about the body's centre.
    Plane { normal: V3, offset: f64 },
    /// An ellipsoid, or a round wall of infinite length; M⁻¹ are the semi-axes, μ is the mean of
    /// M² where it is finite.
    Round { into: Rotation, semi_axes: V3, mean: f64 },
}

/// Degree that N, which is not a polynomial, adds to the integrand.
pub(super) const TENSOR_DEGREE: f64 = 6.0;

/// Sources, within a cell, of the first of these bodies less those inside it; `nodes` are the
/// heights of the grid, µm.
pub(super) fn of_bodies(bodies: &[Solid], nodes: &[f64], slab: &Slab, push: &mut impl FnMut(Source)) {
    points_in(bodies, nodes, slab, TENSOR_DEGREE, &mut |[x, y, _], shares, tensor| {
        push(Source { position: [x, y], values: values(&tensor, shares) });
    });
}

/// Points within a cell in the first of these bodies less those inside it, µm, with the integrals
/// of both Gauss planes' functions that they stand for, µm², and N there; `extra` is the degree of
/// what is integrated besides the wave and those functions.
pub(super) fn points_in(
    bodies: &[Solid],
    nodes: &[f64],
    slab: &Slab,
    extra: f64,
    visit: &mut impl FnMut(V3, [f64; 2], Square),
) {
    let surfaces: Vec<SolidSurface> =
        bodies.iter().enumerate().map(|(i, solid)| SolidSurface::of(solid, nodes, i > 0)).collect();
    for (i, solid) in bodies.iter().enumerate() {
        let sign = if i == 0 { 1.0 } else { -1.0 };
        slab.sampling.cuts(solid, slab.range_um, extra, &mut |z, weight, edge| {
            let shares = slab.point(z, weight, z).map(|[share, ..]| sign * share);
            for (place, area) in points_of_cut(edge, slab.sampling, extra) {
                let point = [place[0], place[1], z];
                visit(point, shares.map(|share| area * share), tensor(&surfaces, point));
            }
        });
    }
}

/// Points of a cut with their areas, µm and µm².
fn points_of_cut(edge: &Edge, sampling: &Sampling, extra: f64) -> Vec<([f64; 2], f64)> {
    let inside = [0, 1].map(|i| edge.iter().map(|p| p.position[i]).sum::<f64>() / edge.len() as f64);
    let mut points = fan(inside, edge, sampling, extra);
    points.iter_mut().for_each(|([x, y], _)| {
        *x += inside[0];
        *y += inside[1];
    });
    points
}

fn values(tensor: &Square, shares: [f64; 2]) -> [f64; VALUES] {
    let field = |f: usize| if f == 0 { 1.0 } else { tensor[f - 1] };
    std::array::from_fn(|i| field(i / 2) * shares[i % 2])
}

impl SolidSurface {
    fn of(solid: &Solid, nodes: &[f64], inner: bool) -> SolidSurface {
        let turn = |v: V3| solid.rotation.turn(v);
        let ends =
            |half: f64| [-1.0, 1.0].map(|side| Face::Plane { normal: turn([0.0, 0.0, side]), offset: half });
        let round = |semi_axes: V3, mean| Face::Round { into: solid.rotation.inverse(), semi_axes, mean };
        let faces: Vec<Face> = match &solid.form {
            Form::Ellipsoid { semi_axes_um: [a, b, c] } => {
                vec![round([*a, *b, *c], (a * b * c).powf(-2.0 / 3.0))]
            }
            Form::Disc { radius_um: r, half_length_um } => {
                let wall = round([*r, *r, f64::INFINITY], r.powi(-2));
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
        let center = solid.center_um;
        let slack = 1e-9 * solid.form.reach_um();
        let joined = |face: &Face| is_on_node(face, center[2], nodes, slack);
        let faces = faces.into_iter().map(|face| (joined(&face), face)).map(|(on, face)| (face, on));
        SolidSurface { center, faces: faces.collect(), inner }
    }
}

fn is_on_node(face: &Face, center: f64, nodes: &[f64], slack: f64) -> bool {
    let Face::Plane { normal: [_, _, up], offset } = face else { return false };
    up.abs() > 1.0 - 1e-12 && nodes.iter().any(|z| (center + up * offset - z).abs() < slack)
}

/// N at a point. Outside a body, the distance from a face is that from the edges of the face.
fn tensor(surfaces: &[SolidSurface], point: V3) -> Square {
    let mut total = 0.0;
    let mut sum = [0.0; FIELDS - 1];
    for surface in surfaces {
        let x = sub(point, surface.center);
        let beyond = |(face, _): &(Face, bool)| face.gap(x).min(0.0).powi(2);
        let beyond = if surface.inner { surface.faces.iter().map(beyond).sum() } else { 0.0 };
        for (face, _) in surface.faces.iter().filter(|(_, on_node)| !on_node) {
            let gap = face.gap(x);
            let square = if surface.inner { gap.max(0.0).powi(2) + beyond } else { gap * gap };
            let weight = 1.0 / square.max(1e-24);
            total += weight;
            sum.iter_mut().zip(face.tensor(x, surface.inner)).for_each(|(s, n)| *s += weight * n);
        }
    }
    if total == 0.0 { sum } else { sum.map(|s| s / total) }
}

impl Face {
    /// Distance from a point, µm: positive inside, of round faces to first order.
    fn gap(&self, x: V3) -> f64 {
        match self {
            Face::Plane { normal, offset } => offset - dot(*normal, x),
            Face::Round { .. } => {
                let [_, inside, length] = self.gradient(x).1;
                inside / (2.0 * length.sqrt())
            }
        }
    }

    /// n nᵀ on the surface and smooth beside it.
    ///
    /// With x = M⁻¹ y in the body's frame and g = M y, round faces have g gᵀ/(g² + μ (1 − y²)): x
    /// xᵀ/R² in a sphere. That of an inner body, which is needed on both of its sides, has (1 −
    /// y²)² instead, with which it is at most n nᵀ.
    fn tensor(&self, x: V3, inner: bool) -> Square {
        match self {
            Face::Plane { normal, .. } => square(*normal),
            Face::Round { mean, .. } => {
                let (gradient, [squared, inside, length]) = self.gradient(x);
                let length = if inner { squared + mean * inside * inside } else { length };
                square(scale(gradient, 1.0 / length.sqrt()))
            }
        }
    }

    /// Of a round face: g, and g², 1 − y² and g² + μ (1 − y²)₊.
    fn gradient(&self, x: V3) -> (V3, [f64; 3]) {
        let Face::Round { into, semi_axes, mean } = self else { return ([0.0; 3], [0.0, 0.0, 1.0]) };
        let turned = into.turn(x);
        let y: V3 = std::array::from_fn(|i| turned[i] / semi_axes[i]);
        let gradient: V3 = std::array::from_fn(|i| y[i] / semi_axes[i]);
        let squared = dot(gradient, gradient);
        let inside = 1.0 - dot(y, y);
        (into.inverse().turn(gradient), [squared, inside, squared + mean * inside.max(0.0)])
    }
}

/// The tensor v vᵀ.
pub(super) fn square([x, y, z]: V3) -> Square {
    [x * x, x * y, y * y, x * z, y * z, z * z]
}

/// Largest distance between centres that counts as none, in radii of the inner sphere.
const ROUNDING: f64 = 1e-9;

/// What lies directly inside a body.
pub(super) enum Core {
    /// One sphere about the centre of the sphere around it, with N between them.
    Concentric(Sphere, NormalField),
    /// The convex bodies, beginning with the outer one.
    Bodies(Vec<Solid>),
}

/// Whether every body inside another one and every body around one is convex.
pub(super) fn are_convex(scene: &Scene) -> bool {
    let mut inner = scene.bodies.iter().filter_map(|body| Some((body, body.within?)));
    inner.all(|(body, host)| convex(body).is_some() && convex(&scene.bodies[host]).is_some())
}

/// What lies directly inside every body; `None` where nothing does.
pub(super) fn cores(scene: &Scene) -> Vec<Option<Core>> {
    let mut inner: Vec<Vec<&Body>> = vec![Vec::new(); scene.bodies.len()];
    scene.bodies.iter().for_each(|body| body.within.iter().for_each(|&host| inner[host].push(body)));
    scene.bodies.iter().zip(inner).map(|(host, inner)| core_of(host, &inner, scene.period_um)).collect()
}

fn core_of(host: &Body, inner: &[&Body], period_um: [f64; 2]) -> Option<Core> {
    let mut bodies: Vec<Solid> = [host].into_iter().chain(inner.iter().copied()).filter_map(convex).collect();
    let (outer, cores) = bodies.split_first_mut()?;
    // Distances are those within one cell: of every core the image inside its host.
    for core in cores {
        for (axis, period) in period_um.into_iter().enumerate() {
            let apart = core.center_um[axis] - outer.center_um[axis];
            core.center_um[axis] -= period * (apart / period).round();
        }
    }
    (!inner.is_empty()).then(|| concentric(host, inner, period_um).unwrap_or(Core::Bodies(bodies)))
}

fn concentric(host: &Body, inner: &[&Body], period_um: [f64; 2]) -> Option<Core> {
    let outer = sphere(host)?;
    let &[core] = inner else { return None };
    let core = sphere(core)?;
    let apart = |axis: usize| {
        let d = core.center_um[axis] - outer.center_um[axis];
        period_um.get(axis).map_or(d, |period| d - period * (d / period).round())
    };
    let same = (0..3).all(|axis| apart(axis).abs() <= ROUNDING * core.radius_um);
    same.then(|| Core::Concentric(core, NormalField::of_layer(core.radius_um, outer.radius_um)))
}

fn sphere(body: &Body) -> Option<Sphere> {
    match &body.shape {
        BodyShape::Balls(balls) if balls.len() == 1 => Some(balls[0]),
        _ => None,
    }
}

fn convex(body: &Body) -> Option<Solid> {
    match &body.shape {
        BodyShape::Solid(solid) => Some(solid.clone()),
        _ => sphere(body).map(|ball| ball.solid()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::vector::{add, cross, norm, unit};

    /// On every face of a body and of its core N is the projector on the normal, which the
    /// triangles of the surface have.
    #[test]
    fn the_tensor_projects_on_the_normal_at_both_surfaces() {
        let corners_um = vec![[-0.1, -0.1], [0.2, -0.1], [-0.1, 0.2]];
        for form in [
            Form::Ellipsoid { semi_axes_um: [0.3, 0.2, 0.1] },
            Form::Disc { radius_um: 0.2, half_length_um: 0.1 },
            Form::Prism { corners_um, half_length_um: 0.2 },
        ] {
            let rotation = Rotation::by([0.4, -0.2, 0.9]);
            let solid = Solid { form, center_um: [0.1, -0.2, 0.3], rotation };
            let core = solid.inset(0.03);
            let layered = [SolidSurface::of(&solid, &[], false), SolidSurface::of(&core, &[], true)];
            for (body, surfaces) in [(&solid, &layered[..1]), (&solid, &layered[..]), (&core, &layered[..])] {
                for [a, b, c] in body.triangles(200) {
                    let middle = scale(add(a, add(b, c)), 1.0 / 3.0);
                    let normal = unit(cross(sub(b, a), sub(c, a)));
                    let found = tensor(surfaces, middle);
                    let off =
                        found.iter().zip(square(normal)).map(|(f, n)| (f - n).abs()).fold(0.0, f64::max);
                    // A facet's middle lies below the surface by its sagitta, 1e-4 of the size.
                    let edge = norm(sub(a, b)).min(norm(sub(a, c))).min(norm(sub(b, c)));
                    assert!(off < 0.05 || edge < 0.01, "{:?}: {found:?} {normal:?}", body.form);
                }
            }
        }
    }
}
