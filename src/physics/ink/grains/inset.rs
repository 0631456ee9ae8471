//! The core of a convex body under a layer.
//!
//! The layer moves every face of a core outwards by its thickness, and makes every semi-axis of an
//! ellipsoid longer by it: the whole is then a form of the same kind, to which sizes refer. (The
//! points within a given distance of an ellipsoid or of a body with edges are no such form.)

use super::solid::{Form, edges, outward};
use crate::numerics::vector::{V3, dot};

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
        let moved = |(c, s): (&[f64; 2], [f64; 2])| [c[0] + depth_um * s[0], c[1] + depth_um * s[1]];
        self.resized(|x| x - depth_um, |corners| corners.iter().zip(shifts(corners)).map(moved).collect())
    }
}

/// How far the corners of a polygon move when its edges move inwards by one.
fn shifts(corners: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let normals: Vec<V3> = edges(corners).map(|(a, b)| outward(a, b)).collect();
    let before = normals.iter().cycle().skip(normals.len() - 1);
    let pairs = before.zip(&normals);
    pairs.map(|(p, q)| [0, 1].map(|axis| -(p[axis] + q[axis]) / (1.0 + dot(*p, *q)))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ink::Solid;
    use crate::numerics::vector::{norm, sub};

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
