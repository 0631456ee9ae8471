//! Moments for uniaxial crystals, beside χ and χN: with the optic axis a, A = a aᵀ and u = aᵀ N a,
//! those of A, uN, NA, uNA, uA and u²A (see [`crate::wave::maxwell::crystal`]).
//!
//! They are integrated over points of the bodies. Every one of them is linear in what a grain
//! contributes, so that grains with different axes share one set of fields.

use super::MomentBuilder;
use crate::ink::Sphere;
use crate::numerics::vector::{V3, dot};
use crate::wave::contrast::nufft::Sources;
use crate::wave::contrast::section::{extents, gauss_rule};
use crate::wave::maxwell::crystal::{CRYSTAL_FIELDS, CrystalFields};
use crate::wave::maxwell::power::share_edges;
use crate::wave::maxwell::solid_sources::{self, Square, TENSOR_DEGREE, square};
use crate::wave::maxwell::sources::{
    FIELDS, NormalField, PROFILE_DEGREE, Slab, VALUES, chord, fan, of_block, profile_nodes,
};
use crate::wave::{Body, BodyShape};
use num_complex::Complex64;
use std::f64::consts::TAU;

/// Transforms take the fields in groups of as many as other materials have.
const GROUPS: usize = CRYSTAL_FIELDS / FIELDS;
/// Degree in x that u²A and uNA have more than N.
const MORE: f64 = 2.0;
/// Nodes along a column: products of four powers of z with a linear function.
const COLUMN_NODES: usize = 3;

/// Partial sums of the crystals' fields in one cell, first Gauss plane + i · second plane.
pub(super) struct CrystalSum<'a> {
    builder: &'a MomentBuilder<'a>,
    slab: Slab<'a>,
    sources: Vec<Sources<'a, f64>>,
    /// Means of fields that do not vary over the plane.
    uniform: [Complex64; CRYSTAL_FIELDS],
}

impl<'a> CrystalSum<'a> {
    pub fn new(builder: &'a MomentBuilder<'a>, slab: Slab<'a>) -> Self {
        let group = |_| Sources::new(&builder.transform, builder.grid.period_um, VALUES);
        let sources = (0..GROUPS).map(group).collect();
        CrystalSum { builder, slab, sources, uniform: [Complex64::default(); CRYSTAL_FIELDS] }
    }

    /// Adds a crystal that contains no other body.
    pub fn add_body(&mut self, body: &Body) {
        let axis = body.optic_axis;
        let slab = self.slab;
        match &body.shape {
            BodyShape::Balls(balls) => {
                for (i, ball) in balls.iter().enumerate() {
                    self.open(extents(ball));
                    points_in_ball(balls, i, &slab, &mut |place, shares, normal| {
                        self.add(place, shares, fields(&normal, axis));
                    });
                    self.close();
                }
            }
            BodyShape::Solid(solid) => {
                let nodes = &self.builder.grid.nodes_um;
                self.open([0, 1].map(|i| solid.extent_um(i)));
                let bodies = std::slice::from_ref(solid);
                let degree = TENSOR_DEGREE + MORE;
                solid_sources::points_in(bodies, nodes, &slab, degree, &mut |[x, y, _], shares, normal| {
                    self.add([x, y], shares, fields(&normal, axis));
                });
                self.close();
            }
            BodyShape::Sheet { z_um } => {
                let [first, second, ..] = of_block(*z_um, &slab, false);
                let share = Complex64::new(first, second);
                let own = fields(&square([0.0, 0.0, 1.0]), axis);
                self.uniform.iter_mut().zip(own).for_each(|(sum, field)| *sum += share * field);
            }
            _ => unreachable!("crystals of other shapes are refused first"),
        }
    }

    fn open(&mut self, extents: [[f64; 2]; 2]) {
        self.sources.iter_mut().for_each(|group| group.open(extents));
    }

    fn close(&mut self) {
        self.sources.iter_mut().for_each(Sources::close);
    }

    /// Spreads a point with its shares in both Gauss planes.
    fn add(&mut self, place: [f64; 2], shares: [f64; 2], fields: CrystalFields) {
        for (group, own) in self.sources.iter_mut().zip(fields.chunks_exact(FIELDS)) {
            let values: [f64; VALUES] = std::array::from_fn(|i| own[i / 2] * shares[i % 2]);
            group.spread(place, &values);
        }
    }

    /// Band-limited fields at the points of both planes.
    pub fn finish(mut self) -> [Vec<CrystalFields>; 2] {
        let builder = self.builder;
        let mut narrow = builder.fft.scratch();
        let mut wide = builder.transform.scratch();
        let mut planes = [(); 2].map(|()| vec![[0.0; CRYSTAL_FIELDS]; builder.grid.points()]);
        for f in 0..CRYSTAL_FIELDS {
            let mut spectrum = vec![Complex64::default(); builder.harmonics.len()];
            // Order (0, 0) comes first.
            spectrum[0] = self.uniform[f];
            if let Some(sources) = self.sources[f / FIELDS].grids.get_mut(f % FIELDS) {
                builder.add_sources(sources, &mut wide, &mut spectrum);
            }
            builder.harmonics.spread(&spectrum, &mut narrow.spectrum);
            builder.fft.inverse(&mut narrow, &builder.harmonics.rows);
            for (i, value) in narrow.plane.iter().enumerate() {
                planes[0][i][f] = value.re;
                planes[1][i][f] = value.im;
            }
        }
        planes
    }
}

/// The fields of a crystal with its axis a where the normal tensor is N.
pub(in crate::wave::maxwell) fn fields(normal: &Square, axis: V3) -> CrystalFields {
    let &[xx, xy, yy, xz, yz, zz] = normal;
    let along = [dot([xx, xy, xz], axis), dot([xy, yy, yz], axis), dot([xz, yz, zz], axis)];
    let u = dot(axis, along);
    let axes = square(axis);
    let mut all = [0.0; CRYSTAL_FIELDS];
    for i in 0..6 {
        all[i] = axes[i];
        all[6 + i] = u * normal[i];
        all[30 + i] = u * axes[i];
        all[36 + i] = u * u * axes[i];
    }
    for i in 0..9 {
        all[12 + i] = along[i / 3] * axis[i % 3];
        all[21 + i] = u * all[12 + i];
    }
    all
}

/// Points of ball `i` of one grain within a cell: lateral place, integrals of both Gauss planes'
/// functions that it stands for, and N = x xᵀ/R² there.
fn points_in_ball(
    balls: &[Sphere],
    i: usize,
    slab: &Slab,
    visit: &mut impl FnMut([f64; 2], [f64; 2], Square),
) {
    let ball = &balls[i];
    let [cx, cy, cz] = ball.center_um;
    let normal = NormalField::of_ball(ball.radius_um);
    let mut point = |[x, y]: [f64; 2], z: f64, shares: [f64; 2]| {
        visit([cx + x, cy + y], shares, normal.at([x, y, z - cz]));
    };
    if balls.len() > 1 {
        share_edges(balls, i, slab.range_um, slab.sampling, &mut |z, weight, edge| {
            let shares = slab.point(z, weight, cz).map(|[share, ..]| share);
            for (place, area) in fan([cx, cy], edge, slab.sampling, 3.0 + MORE) {
                point(place, z, shares.map(|share| area * share));
            }
        });
        return;
    }
    for (theta, weight) in profile_nodes(cz, ball.radius_um, slab, PROFILE_DEGREE + 2.0 * MORE) {
        let (sine, cosine) = theta.sin_cos();
        let r = ball.radius_um * sine;
        let Some([low, high]) = chord(ball.radius_um * cosine, cz, slab) else { continue };
        let count = 4 * ((slab.sampling.demands.degree(r) + 3.0 + MORE) / 4.0).ceil() as usize;
        let area = weight * ball.radius_um * cosine * r * TAU / count as f64;
        for &(t, w) in gauss_rule(COLUMN_NODES) {
            let z = cz + 0.5 * (low + high + (high - low) * t);
            let shares = slab.point(z, 0.5 * (high - low) * w, cz).map(|[share, ..]| area * share);
            for k in 0..count {
                let (s, c) = (TAU * k as f64 / count as f64).sin_cos();
                point([r * c, r * s], z, shares);
            }
        }
    }
}
