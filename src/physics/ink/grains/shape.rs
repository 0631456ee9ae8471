//! Grain shapes: convex bodies, and rigid clusters of spheres, most of them along an axis (P1
//! section 3, "Форма").

use super::agglomeration::PlacedGrain;
use super::solid::{self, Form, Solid};
use super::sphere::{Sphere, bead, centred, chain, inscribed};
use super::volume::{Volume, union_volume};
use crate::numerics::allowed::{Allowed, Whole};
#[cfg(feature = "schema")]
use crate::numerics::files::also_by_name;
#[cfg(feature = "serde")]
use crate::numerics::files::{no_keys, ratio};
use crate::numerics::vector::scale;
use std::f64::consts::PI;

/// Length of a grain in radii; 2 is a sphere.
const LENGTH_IN_RADII: Allowed = Allowed::above(2.0, 100.0, "");
/// Radius of a rice grain's ends in radii.
const TIP_IN_RADII: Allowed = Allowed::above(0.0, 1.0, "");
/// Length of a beaded ellipsoid over its width; 1 is a sphere.
const ASPECT_RATIO: Allowed = Allowed::above(1.0, 20.0, "");
/// Length of an axis or edge of a convex body.
const LENGTH: Allowed = Allowed::above(0.0, 1e6, "");
/// Corners of a prism's polygon.
const MOST_CORNERS: usize = 64;
/// Longest over shortest length of a convex body.
const SLIMMEST: f64 = 100.0;
/// Spheres on the axis of a grain.
const SPHERES: Whole = Whole::between(2, 200);

/// The shape of a grain. A file gives either the bare name (`shape = "cylinder"`) or a table
/// (`shape = { kind = "cylinder", length_in_radii = 8.0, spheres = 7 }`).
///
/// Clusters of spheres have lengths in radii R of their thickest sphere. `ellipsoid`, `box`, `disc`
/// and `prism` are exact convex bodies: their lengths are proportions, which the size scales (in
/// case files they are µm).
#[derive(Clone, Debug, PartialEq, Default)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)
)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema), schemars(transform = also_by_name))]
pub enum Shape {
    /// One sphere.
    #[default]
    #[cfg_attr(feature = "serde", serde(deserialize_with = "no_keys"))]
    Sphere,
    /// Equal spheres at equal spacing; `length_in_radii` includes the round ends. P1 section 5:
    /// length 6 R.
    Cylinder {
        /// Tip-to-tip length over R, above 2.
        #[cfg_attr(feature = "serde", serde(default = "ratio::<6, 1>"))]
        #[cfg_attr(feature = "schema", schemars(transform = LENGTH_IN_RADII.mark()))]
        length_in_radii: f64,
        /// Number of spheres on the axis, 2 to 200.
        #[cfg_attr(feature = "serde", serde(default = "count::<5>"))]
        #[cfg_attr(feature = "schema", schemars(transform = SPHERES.mark()))]
        spheres: usize,
    },
    /// P1 Fig. 1: radii decrease parabolically from R in the middle to `tip_in_radii` R at the
    /// ends.
    RiceGrain {
        /// Tip-to-tip length over R, above 2.
        #[cfg_attr(feature = "serde", serde(default = "ratio::<6, 1>"))]
        #[cfg_attr(feature = "schema", schemars(transform = LENGTH_IN_RADII.mark()))]
        length_in_radii: f64,
        /// Radius of the end spheres over R, above 0 up to 1.
        #[cfg_attr(feature = "serde", serde(default = "ratio::<1, 2>"))]
        #[cfg_attr(feature = "schema", schemars(transform = TIP_IN_RADII.mark()))]
        tip_in_radii: f64,
        /// Number of spheres on the axis, 2 to 200.
        #[cfg_attr(feature = "serde", serde(default = "count::<7>"))]
        #[cfg_attr(feature = "schema", schemars(transform = SPHERES.mark()))]
        spheres: usize,
    },
    /// Ellipsoid with three axes; bare: the third twice as long as the others.
    Ellipsoid {
        /// Lengths of the axes, tip to tip, along x, y and z: z is the grain's axis.
        #[cfg_attr(feature = "serde", serde(default = "lengths::<2>"))]
        #[cfg_attr(feature = "schema", schemars(inner(range(min = 0))))]
        axes: [f64; 3],
    },
    /// Box with three edges; bare: a cube.
    Box {
        /// Lengths of the edges along x, y and z: z is the grain's axis.
        #[cfg_attr(feature = "serde", serde(default = "lengths::<1>"))]
        #[cfg_attr(feature = "schema", schemars(inner(range(min = 0))))]
        edges: [f64; 3],
    },
    /// Circular disc, platelet or rod with flat ends; bare: five times as wide as thick.
    Disc {
        /// Diameter of the ends.
        #[cfg_attr(feature = "serde", serde(default = "ratio::<1, 1>"))]
        #[cfg_attr(feature = "schema", schemars(transform = LENGTH.mark()))]
        diameter: f64,
        /// Distance between the ends along z, the grain's axis.
        #[cfg_attr(feature = "serde", serde(default = "ratio::<1, 5>"))]
        #[cfg_attr(feature = "schema", schemars(transform = LENGTH.mark()))]
        thickness: f64,
    },
    /// Prism over a convex polygon; bare: hexagonal, as long as its edges.
    Prism {
        /// Corners of the polygon in order, x and y; its centre of mass becomes the grain's axis.
        #[cfg_attr(feature = "serde", serde(default = "hexagon"))]
        #[cfg_attr(feature = "schema", schemars(length(min = 3, max = 64)))]
        corners: Vec<[f64; 2]>,
        /// Distance between the ends along z, the grain's axis.
        #[cfg_attr(feature = "serde", serde(default = "ratio::<1, 1>"))]
        #[cfg_attr(feature = "schema", schemars(transform = LENGTH.mark()))]
        length: f64,
    },
    /// Spheres inscribed in a prolate ellipsoid of semi-axes R and `aspect_ratio` R, tips included;
    /// unlike `ellipsoid` it can make fractals.
    BeadedEllipsoid {
        /// Length over width, above 1.
        #[cfg_attr(feature = "serde", serde(default = "ratio::<2, 1>"))]
        #[cfg_attr(feature = "schema", schemars(transform = ASPECT_RATIO.mark()))]
        aspect_ratio: f64,
        /// Number of spheres on the axis, 2 to 200.
        #[cfg_attr(feature = "serde", serde(default = "count::<9>"))]
        #[cfg_attr(feature = "schema", schemars(transform = SPHERES.mark()))]
        spheres: usize,
    },
    /// Any rigid cluster: rows of x, y, z, radius in a common unit; the size then scales it.
    Cluster {
        /// x, y, z, radius of each sphere, 1 to 1000 of them.
        #[cfg_attr(feature = "schema", schemars(length(min = 1, max = 1000), example = ((0.0, 0.0, 0.0, 1.0), (1.5, 0.0, 0.0, 1.0))))]
        spheres: Vec<[f64; 4]>,
    },
}

#[cfg(feature = "serde")]
fn count<const N: usize>() -> usize {
    N
}
/// Two lengths of 1, and a third.
#[cfg(feature = "serde")]
fn lengths<const N: u32>() -> [f64; 3] {
    [1.0, 1.0, N.into()]
}
#[cfg(feature = "serde")]
fn hexagon() -> Vec<[f64; 2]> {
    let h = 0.75f64.sqrt();
    vec![[1.0, 0.0], [0.5, h], [-0.5, h], [-1.0, 0.0], [-0.5, -h], [0.5, -h]]
}

/// Spheres in the body frame (centre of mass at the origin, symmetry axis along z), thickest radius
/// 1; or a convex body whose longest axis or edge is 2.
#[derive(Clone, Debug, PartialEq)]
pub struct Template {
    /// Positions and radii in units of the thickest radius (not in µm, as the fields' names say);
    /// of a convex body the sphere around it.
    pub spheres: Vec<Sphere>,
    /// Volume of the grain, in units of the thickest radius cubed.
    pub volume: Volume,
    /// Tip-to-tip length along the axis; of a convex body the longest axis or edge.
    pub length: f64,
    /// The convex body, if the shape is one.
    pub form: Option<Form>,
}

impl Shape {
    /// The cylinder of P1 section 5: length 6 R, five spheres.
    pub const CYLINDER: Self = Self::Cylinder { length_in_radii: 6.0, spheres: 5 };
    /// The rice grain of P1 Fig. 1: length 6 R, seven spheres.
    pub const RICE_GRAIN: Self = Self::RiceGrain { length_in_radii: 6.0, tip_in_radii: 0.5, spheres: 7 };

    /// Display name, such as "rice grain".
    pub fn name(&self) -> &'static str {
        match self {
            Self::Sphere => "sphere",
            Self::Cylinder { .. } => "cylinder",
            Self::RiceGrain { .. } => "rice grain",
            Self::Ellipsoid { .. } => "ellipsoid",
            Self::Box { .. } => "box",
            Self::Disc { .. } => "disc",
            Self::Prism { .. } => "prism",
            Self::BeadedEllipsoid { .. } => "beaded ellipsoid",
            Self::Cluster { .. } => "cluster",
        }
    }

    /// The first invalid number, if any: field, value found, allowed range.
    pub fn defect(&self) -> Option<(&'static str, String, &'static str)> {
        let bad = |field, value: f64, allowed| Some((field, value.to_string(), allowed));
        match *self {
            Self::Cylinder { length_in_radii: l, .. } | Self::RiceGrain { length_in_radii: l, .. }
                if !LENGTH_IN_RADII.holds(l) =>
            {
                bad("shape.length_in_radii", l, "above 2 (a sphere) up to 100")
            }
            Self::RiceGrain { tip_in_radii: t, .. } if !TIP_IN_RADII.holds(t) => {
                bad("shape.tip_in_radii", t, "above 0 up to 1")
            }
            Self::BeadedEllipsoid { aspect_ratio: a, .. } if !ASPECT_RATIO.holds(a) => {
                bad("shape.aspect_ratio", a, "above 1 (a sphere) up to 20")
            }
            Self::Cylinder { spheres: n, .. }
            | Self::RiceGrain { spheres: n, .. }
            | Self::BeadedEllipsoid { spheres: n, .. } => {
                (!SPHERES.holds(n)).then(|| ("shape.spheres", n.to_string(), "2 to 200 spheres"))
            }
            Self::Sphere => None,
            Self::Cluster { ref spheres } => cluster_defect(spheres),
            Self::Ellipsoid { ref axes } => lengths_defect("shape.axes", axes),
            Self::Box { ref edges } => lengths_defect("shape.edges", edges),
            Self::Disc { diameter, thickness } => {
                lengths_defect("shape.diameter and shape.thickness", &[diameter, thickness])
            }
            Self::Prism { ref corners, length } => prism_defect(corners, length),
        }
    }

    /// The exact convex body that the shape describes, if any, in the units of its lengths.
    pub fn form(&self) -> Option<Form> {
        Some(match self {
            Self::Ellipsoid { axes } => Form::Ellipsoid { semi_axes_um: scale(*axes, 0.5) },
            Self::Box { edges } => Form::cuboid(*edges),
            Self::Disc { diameter, thickness } => {
                Form::Disc { radius_um: 0.5 * diameter, half_length_um: 0.5 * thickness }
            }
            Self::Prism { corners, length } => {
                Form::Prism { corners_um: solid::centred(corners), half_length_um: 0.5 * length }
            }
            _ => return None,
        })
    }

    /// The grain of unit size with its volume. The numbers must be valid (see [`Shape::defect`]).
    pub fn template(&self) -> Template {
        if let Some(form) = self.form() {
            let form = form.scaled(2.0 / form.longest_um());
            let around = Sphere { center_um: [0.0; 3], radius_um: form.reach_um() };
            let volume = Volume { um3: form.volume_um3(), error_um3: 0.0 };
            return Template { spheres: vec![around], volume, length: 2.0, form: Some(form) };
        }
        let spheres = match self {
            Self::Sphere => vec![bead(0.0, 1.0)],
            Self::Cylinder { length_in_radii: l, spheres } => chain(*spheres, 0.5 * l - 1.0, |_| 1.0),
            Self::RiceGrain { length_in_radii: l, tip_in_radii: tip, spheres } => {
                chain(*spheres, 0.5 * l - tip, |t| 1.0 - (1.0 - tip) * t * t)
            }
            Self::BeadedEllipsoid { aspect_ratio: a, spheres } => inscribed(*a, *spheres),
            Self::Cluster { spheres } => centred(spheres),
            Self::Ellipsoid { .. } | Self::Box { .. } | Self::Disc { .. } | Self::Prism { .. } => Vec::new(),
        };
        let tip = |sign: f64| spheres.iter().map(move |s| sign * s.center_um[2] + s.radius_um);
        let length = tip(1.0).fold(f64::MIN, f64::max) + tip(-1.0).fold(f64::MIN, f64::max);
        Template { volume: union_volume(&spheres), length, spheres, form: None }
    }
}

impl Template {
    /// Diameter of the sphere of equal union volume, in units of the thickest radius.
    pub fn effective_diameter(&self) -> f64 {
        (6.0 * self.volume.um3 / PI).cbrt()
    }

    /// The grain of this thickest radius, in its own frame.
    pub(crate) fn grain(&self, radius_um: f64) -> PlacedGrain {
        let sphere = |s: &Sphere| Sphere {
            center_um: scale(s.center_um, radius_um),
            radius_um: s.radius_um * radius_um,
        };
        PlacedGrain {
            spheres: self.spheres.iter().map(sphere).collect(),
            solid: self.form.as_ref().map(|form| Solid::upright(form.scaled(radius_um), [0.0; 3])),
            axis: [0.0, 0.0, 1.0],
            volume_um3: self.volume.um3 * radius_um.powi(3),
        }
    }
}

fn lengths_defect(field: &'static str, lengths: &[f64]) -> Option<(&'static str, String, &'static str)> {
    let (least, most) = lengths.iter().fold((f64::MAX, 0.0), |(a, b): (f64, f64), &l| (a.min(l), b.max(l)));
    let sound = lengths.iter().all(|l| LENGTH.holds(*l)) && most <= SLIMMEST * least;
    let allowed = "numbers above 0, none more than 100 times another";
    (!sound).then(|| (field, format!("{lengths:?}"), allowed))
}

fn prism_defect(corners: &[[f64; 2]], length: f64) -> Option<(&'static str, String, &'static str)> {
    let wide = || 4.0 * solid::area(corners).abs().sqrt();
    if corners.len() > MOST_CORNERS || !solid::is_convex(corners) {
        let allowed = "3 to 64 corners of a convex polygon, in order";
        return Some(("shape.corners", format!("{corners:?}"), allowed));
    }
    lengths_defect("shape.length beside shape.corners", &[length, wide()])
}

fn cluster_defect(spheres: &[[f64; 4]]) -> Option<(&'static str, String, &'static str)> {
    let sound = |s: &[f64; 4]| s.iter().all(|v| v.is_finite()) && s[3] > 0.0;
    if spheres.is_empty() || spheres.len() > 1000 {
        let allowed = "1 to 1000 rows of x, y, z, radius";
        return Some(("shape.spheres", format!("{} rows", spheres.len()), allowed));
    }
    let bad = spheres.iter().find(|s| !sound(s))?;
    Some(("shape.spheres", format!("{bad:?}"), "finite x, y, z and a radius above 0"))
}

#[cfg(test)]
#[path = "shape_tests.rs"]
mod tests;
