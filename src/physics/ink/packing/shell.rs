//! Layers around the cores of grains.
//!
//! Every sphere of a grain shrinks by the thickness of the layers around it: the grain is then the
//! parallel body of its core, all points within that thickness of it, for any union of spheres.
//!
//! A layer moves every face of a convex core outwards by its thickness, and makes every semi-axis
//! of an ellipsoid longer by it: the whole is then a form of the same kind, to which sizes refer.
//! (The points within a given distance of an ellipsoid or of a body with edges are no such form.)

use crate::ink::Template;
use crate::ink::grains::solid::{Form, Solid, edges, outward};
use crate::ink::grains::volume::union_volume;
use crate::ink::{PackError, PigmentGrains, Sphere};
use crate::numerics::vector::{V3, dot};

/// Sizes over which shares are averaged: spheres, chains and convex bodies have a closed volume,
/// clusters do not.
const SIZES: [usize; 2] = [1000, 16];

/// The spheres inside layers of this thickness.
pub(super) fn inside(spheres: &[Sphere], depth_um: f64) -> Vec<Sphere> {
    spheres.iter().map(|s| Sphere { radius_um: s.radius_um - depth_um, ..*s }).collect()
}

/// Thickness of layers below which a core remains in a grain, µm.
pub(super) fn deepest_um(spheres: &[Sphere], form: Option<&Form>) -> f64 {
    form.map_or_else(|| spheres.iter().map(|s| s.radius_um).fold(f64::MAX, f64::min), Form::deepest_um)
}

impl PigmentGrains {
    /// Checks the thicknesses, and that a core remains in the smallest grain of the distribution.
    pub(super) fn check_layers(&self, k: usize) -> Result<(), PackError> {
        for (i, thickness) in self.shell_nm.iter().enumerate() {
            let field = format!("pigment[{k}].shell[{i}].thickness_nm");
            let sound = thickness.is_finite() && *thickness > 0.0;
            let remedy = "give the thickness of the layer in nm, or leave the layer out";
            PackError::unless(sound, field, thickness, "above 0", remedy)?;
        }
        if self.shell_nm.is_empty() {
            return Ok(());
        }
        let template = self.shape.template();
        self.check_core(k, &template, self.size.radius_um(self.size.smallest_nm(), &template))
    }

    /// Checks that a core remains in the grain of this thickest radius.
    pub(super) fn check_core(&self, k: usize, template: &Template, radius_um: f64) -> Result<(), PackError> {
        let deepest = deepest_um(&template.spheres, template.form.as_ref());
        let layers = self.shell_nm.iter().sum::<f64>();
        let most = 1e3 * radius_um * deepest;
        if layers < most {
            return Ok(());
        }
        let found = format!("layers of {layers} nm in all");
        let what = match template.form {
            None => "the smallest radius in the smallest grain",
            Some(_) => "at which a face or axis of the smallest grain's core vanishes",
        };
        let allowed = format!("less than {most:.3} nm, {what}");
        let remedy = "take thinner layers or larger grains; sizes are outer ones, which include the layers";
        Err(PackError::input(format!("pigment[{k}].shell"), found, allowed, remedy))
    }

    /// Shares of the grains' volume: the core, then the layers from the core outwards.
    pub fn layer_shares(&self) -> Vec<f64> {
        if self.shell_nm.is_empty() {
            return vec![1.0];
        }
        let template = self.shape.template();
        let most = SIZES[usize::from(template.spheres.len() > 1)];
        let count = if self.size.has_spread() { most } else { 1 };
        let mut volumes = vec![0.0; self.shell_nm.len() + 1];
        for i in 0..count {
            let nm = self.size.quantile_nm((i as f64 + 0.5) / count as f64);
            self.add_volumes(&template, self.size.radius_um(nm, &template), &mut volumes);
        }
        let total: f64 = volumes.iter().sum();
        volumes.iter().map(|v| v / total).collect()
    }

    /// Adds the volumes of the core and the layers of a grain of this thickest radius.
    fn add_volumes(&self, template: &Template, radius_um: f64, volumes: &mut [f64]) {
        let grain = template.grain(radius_um);
        let mut outer = grain.volume_um3;
        let mut depth = 0.0;
        for (i, thickness) in self.shell_nm.iter().enumerate().rev() {
            depth += 1e-3 * thickness;
            let inner = match &grain.solid {
                Some(solid) => solid.form.inset(depth).volume_um3(),
                None => union_volume(&inside(&grain.spheres, depth)).um3,
            };
            volumes[i + 1] += outer - inner;
            outer = inner;
        }
        volumes[0] += outer;
    }
}

impl Form {
    /// Total thickness of layers below which a core with all its faces remains, µm.
    pub fn deepest_um(&self) -> f64 {
        match self {
            Form::Prism { corners_um, half_length_um } => {
                let shifts = shifts(corners_um);
                let along = edges(corners_um).zip(edges(&shifts)).map(|((a, b), (s, t))| {
                    let edge = [b[0] - a[0], b[1] - a[1]];
                    let shorter = edge[0] * (s[0] - t[0]) + edge[1] * (s[1] - t[1]);
                    (edge[0] * edge[0] + edge[1] * edge[1]) / shorter
                });
                along.fold(*half_length_um, f64::min)
            }
            _ => self.thin_um(),
        }
    }

    /// The core inside layers of this thickness, which must be below [`Form::deepest_um`].
    pub fn inset(&self, depth_um: f64) -> Form {
        let inset_corners = |corners: &[[f64; 2]]| {
            let with_shifts = corners.iter().zip(shifts(corners));
            with_shifts.map(|(c, s)| [c[0] + depth_um * s[0], c[1] + depth_um * s[1]]).collect()
        };
        self.resized(|x| x - depth_um, inset_corners)
    }
}

/// How far the corners of a polygon move when its edges move inwards by one.
fn shifts(corners: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let normals: Vec<V3> = edges(corners).map(|(a, b)| outward(a, b)).collect();
    let before = normals.iter().cycle().skip(normals.len() - 1);
    let shift = |p: &V3, q: &V3| [0, 1].map(|axis| -(p[axis] + q[axis]) / (1.0 + dot(*p, *q)));
    before.zip(&normals).map(|(p, q)| shift(p, q)).collect()
}

impl Solid {
    /// The core inside layers of this thickness, see [`Form::inset`].
    pub fn inset(&self, depth_um: f64) -> Solid {
        Solid { form: self.form.inset(depth_um), ..self.clone() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ink::{Measure, Shape, SizeDistribution};
    use crate::numerics::vector::{norm, sub};

    #[test]
    fn shares_are_those_of_the_spheres() {
        let coated = PigmentGrains { shell_nm: vec![20.0, 30.0], ..PigmentGrains::spheres(300.0, 0.2) };
        let [core, first, second] = coated.layer_shares()[..] else { panic!("three shares") };
        // identity: volumes of spheres of 100, 120 and 150 nm
        assert!((core - (2.0f64 / 3.0).powi(3)).abs() < 1e-12, "{core}");
        assert!((first - (0.8f64.powi(3) - (2.0f64 / 3.0).powi(3))).abs() < 1e-12, "{first}");
        assert!((core + first + second - 1.0).abs() < 1e-12);
    }

    #[test]
    fn shares_of_many_sizes_weigh_every_grain_with_its_volume() {
        let list = |values_nm: Vec<f64>| SizeDistribution::List {
            values_nm,
            weights: Vec::new(),
            of: Measure::EffectiveDiameter,
        };
        let coated = PigmentGrains {
            size: list(vec![200.0, 400.0]),
            shell_nm: vec![50.0],
            ..PigmentGrains::spheres(300.0, 0.2)
        };
        let core = (100.0f64.powi(3) + 300.0f64.powi(3)) / (200.0f64.powi(3) + 400.0f64.powi(3));
        assert!((coated.layer_shares()[0] - core).abs() < 1e-12);
    }

    #[test]
    fn a_layer_thicker_than_the_thinnest_sphere_is_refused() {
        let grains = |shape, shell_nm| PigmentGrains { shell_nm, ..PigmentGrains::of(shape, 200.0, 0.2) };
        assert!(grains(Shape::Sphere, vec![40.0, 59.9]).check_layers(0).is_ok());
        let error = grains(Shape::Sphere, vec![40.0, 60.0]).check_layers(2).unwrap_err().to_string();
        assert!(error.contains("pigment[2].shell") && error.contains("100"), "{error}");
        assert!(grains(Shape::RICE_GRAIN, vec![60.0]).check_layers(0).is_err(), "its ends are thinner");
        assert!(grains(Shape::Sphere, vec![-1.0]).check_layers(0).is_err());
        // A plate of 200 nm by volume, five times as wide as thick, is 59.8 nm thick.
        let plate = Shape::Disc { diameter: 1.0, thickness: 0.2 };
        assert!(grains(plate.clone(), vec![29.0]).check_layers(0).is_ok());
        let error = grains(plate, vec![30.0]).check_layers(0).unwrap_err().to_string();
        assert!(error.contains("less than 29.8") && error.contains("face"), "{error}");
    }

    /// Between a body's surface and the core lies the thickness, everywhere on flat faces and round
    /// walls; a core remains up to the deepest layer and has no edge beyond it.
    #[test]
    fn every_face_of_the_core_lies_one_thickness_inside() {
        for form in [
            Form::cuboid([0.3, 0.2, 0.25]),
            Form::Disc { radius_um: 0.3, half_length_um: 0.1 },
            Form::Prism {
                corners_um: vec![[-0.14, -0.1], [0.16, -0.1], [0.16, 0.02], [-0.02, 0.2]],
                half_length_um: 0.2,
            },
            Form::Ellipsoid { semi_axes_um: [0.2; 3] },
        ] {
            let core = Solid::upright(form.inset(0.04), [0.0; 3]);
            let outer = Solid::upright(form.clone(), [0.0; 3]);
            for triangle in core.triangles(40) {
                let middle: V3 = std::array::from_fn(|i| triangle.iter().map(|p| p[i]).sum::<f64>() / 3.0);
                let normal = core.normal(middle);
                let Some([_, to_core]) = core.chord(middle, normal) else { continue };
                let [_, to_outer] = outer.chord(middle, normal).expect("inside");
                assert!((to_outer - to_core - 0.04).abs() < 1e-9, "{form:?}: {to_outer} {to_core}");
            }
            let last = form.inset(form.deepest_um() * (1.0 - 1e-9));
            assert!(last.volume_um3() >= 0.0 && last.deepest_um() < 1e-9, "{last:?}");
            let back = form.inset(0.04).inset(-0.04);
            assert!((back.volume_um3() / form.volume_um3() - 1.0).abs() < 1e-12);
        }
        // A trapezoid whose short side vanishes before the others meet.
        let corners_um = vec![[0.0, 0.0], [1.0, 0.0], [0.55, 0.5], [0.45, 0.5]];
        let form = Form::Prism { corners_um, half_length_um: 1.0 };
        let Form::Prism { corners_um, .. } = form.inset(form.deepest_um()) else { panic!("a prism") };
        let [.., c, d] = corners_um[..] else { panic!("four corners") };
        assert!(norm(sub([c[0], c[1], 0.0], [d[0], d[1], 0.0])) < 1e-12 && c[1] > 0.1, "{c:?} {d:?}");
    }
}
