//! From a packing to the scene that the wave sees.

use super::{Ball, Body, Scene, Shape};
use crate::ink::{Grain, Packing};

impl Scene {
    /// One stratum of binder (background 0) with one body per grain; pigment i is inclusion i.
    ///
    /// The packing has proven that no grains overlap, so the quadratic check of pairs is not repeated.
    pub fn from_packing(packing: &Packing) -> Scene {
        let bodies = packing.grains().iter().map(body).collect();
        Scene::layer(packing.period_um(), packing.thickness_um(), bodies)
    }
}

fn body(grain: &Grain) -> Body {
    let ball = |s: &crate::ink::Sphere| Ball { center_um: s.center_um, radius_um: s.radius_um };
    Body { shape: Shape::Balls(grain.spheres.iter().map(ball).collect()), inclusion: grain.pigment }
}
