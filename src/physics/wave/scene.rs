//! Scene of the wave problem: strata of constant index with bodies inside them, and the media's
//! indices.

use super::WaveError;
use crate::ink::{Solid, Sphere};
use crate::numerics::vector::{V3, norm, unit};
use num_complex::Complex64;

/// A body's shape, lengths in µm. Bodies along y serve the two-dimensional references.
#[derive(Clone, Debug, PartialEq)]
pub enum BodyShape {
    /// Union of the balls of one grain, µm; overlapping volume counts once. Centres may lie outside
    /// the cell and are wrapped periodically in x and y.
    Balls(Vec<Sphere>),
    /// A convex body with an exact surface.
    Solid(Solid),
    /// Infinite circular cylinder along y.
    CylinderY {
        /// Centre along x, µm.
        x_um: f64,
        /// Centre along z, µm.
        z_um: f64,
        /// Radius, µm.
        radius_um: f64,
    },
    /// Infinite rectangular bar along y.
    BarY {
        /// Range along x, µm.
        x_um: [f64; 2],
        /// Range along z, µm.
        z_um: [f64; 2],
    },
    /// Everything between a rough surface and a face of the layer except the given grains.
    Open {
        /// The surface.
        surface: HeightField,
        /// z of the face: 0 or the thickness of the layer, µm.
        face_um: f64,
        /// Balls of the grains that protrude from it.
        balls: Vec<Sphere>,
        /// Convex grains that protrude from it.
        solids: Vec<Solid>,
    },
    /// Homogeneous sheet between two heights (a stratum that the grid need not resolve).
    Sheet {
        /// Range along z, µm.
        z_um: [f64; 2],
    },
}

/// A periodic surface z(x, y) in µm on a grid of points (x fastest), bilinear between them.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightField {
    /// Heights, as z in µm, `count[0]` · `count[1]` of them.
    pub z_um: Vec<f64>,
    /// Points along x and y.
    pub count: [usize; 2],
    /// Periods along x and y, µm.
    pub period_um: [f64; 2],
}

/// Material of a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Material {
    /// The medium of this index in [`Media::inclusions`], such as a pigment.
    Inclusion(usize),
    /// A uniaxial crystal, whose optic axis is that of the body; Maxwell's equations only.
    Uniaxial(Uniaxial),
    /// The medium of the incident side (vacuum unless the study says otherwise), which fills the
    /// space above a relief.
    Incident,
    /// The medium of the exit side, which fills the space below a relief on that side.
    Exit,
}

/// Both indices of a uniaxial crystal, by their places in [`Media::inclusions`]: ε = ε_o (1 − a aᵀ)
/// + ε_e a aᵀ with the optic axis a.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Uniaxial {
    /// The ordinary ray's.
    pub ordinary: usize,
    /// The extraordinary ray's.
    pub extraordinary: usize,
}

/// One body of the scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// Shape and position, µm.
    pub shape: BodyShape,
    /// Material of the body.
    pub material: Material,
    /// The body directly around this one, whose material it displaces, as an index into
    /// [`Scene::bodies`]; `None` in the background.
    pub within: Option<usize>,
    /// Unit vector along the optic axis of a uniaxial crystal; of no effect in other materials.
    pub optic_axis: V3,
}

/// One stratum of constant background, counted from z = 0; `background` indexes
/// [`Media::backgrounds`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stratum {
    /// Thickness, µm.
    pub thickness_um: f64,
    /// Index into the backgrounds.
    pub background: usize,
}

/// The geometry of one periodic cell, 0 ≤ z ≤ H, independent of wavelength and angle.
///
/// ```
/// use inkwave_physics::ink::Sphere;
/// use inkwave_physics::wave::{Body, Media, Scene, BodyShape};
///
/// let ball = Sphere { center_um: [0.1, 0.2, 0.15], radius_um: 0.1 };
/// let scene = Scene::layer([0.5, 0.5], 0.3, vec![Body::new(BodyShape::Balls(vec![ball]), 0)]);
/// let media = Media {
///     incident: 1.0.into(),
///     exit: 1.0.into(),
///     backgrounds: vec![1.558.into()], // the binder
///     inclusions: vec![1.4.into()],    // the ball
/// };
/// scene.check(&media)?;
/// assert_eq!(scene.thickness_um(), 0.3);
///
/// // A body that leaves the layer is rejected, with its position and a remedy.
/// let high = Sphere { center_um: [0.1, 0.2, 0.05], radius_um: 0.1 };
/// let scene = Scene::layer([0.5, 0.5], 0.3, vec![Body::new(BodyShape::Balls(vec![high]), 0)]);
/// let refusal = scene.check(&media).unwrap_err().to_string();
/// assert!(refusal.contains("move it or make the layer thicker"));
/// # Ok::<(), inkwave_physics::wave::WaveError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// Lateral periods (Lx, Ly), µm.
    pub period_um: [f64; 2],
    /// Strata, starting at z = 0.
    pub strata: Vec<Stratum>,
    /// Bodies in them: none overlaps another except those around it ([`Body::within`]).
    pub bodies: Vec<Body>,
    /// Whether bodies may extend beyond the layer, whose faces cut them.
    pub cut: bool,
}

/// Complex refractive indices at one wavelength, Im η ≥ 0 absorbs (time factor e^{−iωt}).
#[derive(Clone, Debug, PartialEq)]
pub struct Media {
    /// Half-space z < 0, the incident side.
    pub incident: Complex64,
    /// Half-space z > H, the exit side.
    pub exit: Complex64,
    /// Media of the strata.
    pub backgrounds: Vec<Complex64>,
    /// Media of the bodies.
    pub inclusions: Vec<Complex64>,
}

impl Scene {
    /// A single stratum that contains `bodies`.
    pub fn layer(period_um: [f64; 2], thickness_um: f64, bodies: Vec<Body>) -> Scene {
        Scene { period_um, strata: vec![Stratum { thickness_um, background: 0 }], bodies, cut: false }
    }

    /// Thickness H, the sum over the strata, µm.
    pub fn thickness_um(&self) -> f64 {
        self.strata.iter().map(|s| s.thickness_um).sum()
    }

    /// Whether the scene is uniform along y, so that only orders n = 0 exist.
    pub fn uniform_in_y(&self) -> bool {
        use BodyShape::{Balls, Open, Solid};
        !self.bodies.iter().any(|b| matches!(b.shape, Balls(_) | Solid(_) | Open { .. }))
    }

    /// Whether the scene is uniform along x and y: a stack of homogeneous films.
    pub fn uniform_in_plane(&self) -> bool {
        self.bodies.iter().all(|b| matches!(b.shape, BodyShape::Sheet { .. }))
    }

    /// Indices of the strata that contain part of a body: elsewhere the wave is that of a film,
    /// exact on every grid.
    pub fn patterned_strata(&self) -> Vec<usize> {
        let mut bottom = 0.0;
        let slack = 1e-9 * self.thickness_um();
        let is_reached = |stratum: &Stratum| {
            let low = bottom;
            let high = low + stratum.thickness_um;
            bottom = high;
            self.bodies.iter().map(Body::extent_um).any(|[lo, hi]| lo < high - slack && hi > low + slack)
        };
        let reached: Vec<bool> = self.strata.iter().map(is_reached).collect();
        (0..reached.len()).filter(|&i| reached[i]).collect()
    }

    /// Rejects lengths that are not finite and positive, bodies that extend beyond the layer, and
    /// unknown media.
    pub fn check(&self, media: &Media) -> Result<(), WaveError> {
        for (axis, &period) in ["x", "y"].iter().zip(&self.period_um) {
            positive(&format!("period in {axis} (µm)"), period)?;
        }
        for (i, stratum) in self.strata.iter().enumerate() {
            positive(&format!("thickness of stratum {i} (µm)"), stratum.thickness_um)?;
            if stratum.thickness_um < THINNEST_UM {
                return Err(WaveError::Unsound(format!(
                    "thickness of stratum {i} is {:e} µm; below {THINNEST_UM:e} µm, thinner than any atom, rounding \
                     would drown it: leave the stratum out",
                    stratum.thickness_um
                )));
            }
        }
        let height = self.thickness_um();
        let period = self.period_um[0].min(self.period_um[1]);
        self.bodies.iter().enumerate().try_for_each(|(i, body)| {
            body.check(i, period)?;
            if self.cut { Ok(()) } else { body.check_height(i, height) }
        })?;
        media.check(self)
    }
}

impl Body {
    /// A body made of the medium `inclusion` of [`Media::inclusions`].
    pub fn new(shape: BodyShape, inclusion: usize) -> Body {
        Body::of(shape, Material::Inclusion(inclusion))
    }

    /// A body in no other one, made of a material whose optic axis, if it has one, is z.
    pub fn of(shape: BodyShape, material: Material) -> Body {
        Body { shape, material, within: None, optic_axis: [0.0, 0.0, 1.0] }
    }

    /// A body made of a uniaxial crystal with its optic axis along a vector of any length above 0.
    pub fn crystal(shape: BodyShape, indices: Uniaxial, optic_axis: V3) -> Body {
        Body { optic_axis: unit(optic_axis), ..Body::of(shape, Material::Uniaxial(indices)) }
    }

    /// Lowest and highest z of the body.
    pub fn extent_um(&self) -> [f64; 2] {
        match &self.shape {
            BodyShape::Balls(balls) => {
                balls.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[lo, hi], b| {
                    [lo.min(b.center_um[2] - b.radius_um), hi.max(b.center_um[2] + b.radius_um)]
                })
            }
            BodyShape::Solid(solid) => solid.extent_um(2),
            BodyShape::CylinderY { z_um, radius_um, .. } => [z_um - radius_um, z_um + radius_um],
            BodyShape::Open { surface, face_um, .. } => {
                let ends = surface.z_um.iter().map(|z| z - face_um);
                let farthest = ends.max_by(|a, b| a.abs().total_cmp(&b.abs())).unwrap_or(0.0);
                [face_um + farthest.min(0.0), face_um + farthest.max(0.0)]
            }
            BodyShape::BarY { z_um, .. } | BodyShape::Sheet { z_um } => *z_um,
        }
    }

    fn check(&self, index: usize, period: f64) -> Result<(), WaveError> {
        let [lo, hi] = self.extent_um();
        self.check_lateral(index, period)?;
        let length = norm(self.optic_axis);
        if !(length - 1.0).abs().le(&1e-9) {
            return Err(WaveError::Unsound(format!(
                "optic axis of body {index} is {:?}; it must be a unit vector",
                self.optic_axis
            )));
        }
        positive(&format!("height of body {index} (µm)"), hi - lo)
    }

    fn check_height(&self, index: usize, height: f64) -> Result<(), WaveError> {
        let [low_um, high_um] = self.extent_um();
        // A grain touching a wall may protrude by the rounding of its coordinates.
        let slack = 1e-9 * height;
        if low_um < -slack || high_um > height + slack {
            return Err(WaveError::OutsideLayer { body: index, low_um, high_um, thickness_um: height });
        }
        Ok(())
    }

    /// Rejects lateral positions that are not finite, which would otherwise show only as NaN in
    /// every amplitude, and those so far out that wrapping them into the period leaves too few
    /// digits.
    fn check_lateral(&self, index: usize, period: f64) -> Result<(), WaveError> {
        let lateral: Vec<f64> = match &self.shape {
            BodyShape::Balls(balls) => balls.iter().flat_map(|b| b.center_um[..2].to_vec()).collect(),
            BodyShape::Open { balls, solids, .. } => {
                let centres = balls.iter().map(|b| b.center_um).chain(solids.iter().map(|s| s.center_um));
                centres.flat_map(|centre| centre[..2].to_vec()).collect()
            }
            BodyShape::Solid(solid) => solid.center_um[..2].to_vec(),
            BodyShape::CylinderY { x_um, .. } => vec![*x_um],
            BodyShape::BarY { x_um, .. } => x_um.to_vec(),
            BodyShape::Sheet { .. } => Vec::new(),
        };
        let most_um = FARTHEST * period;
        let wrong = lateral.into_iter().find(|x| x.is_nan() || x.abs() > most_um);
        let Some(value) = wrong else { return Ok(()) };
        let field = format!("lateral position of body {index} (µm)");
        Err(WaveError::Unsound(match value.is_finite() {
            false => format!("{field} is {value}; it must be a finite number"),
            true => format!(
                "{field} is {value:e}; at most {most_um:e} µm (a million periods) leaves enough digits of its \
                 position in the period: give it within the period"
            ),
        }))
    }
}

impl Media {
    /// Refractive index of a body's material, of a crystal that of the mean over all directions of
    /// its axis, ε̄ = (2ε_o + ε_e)/3; [`Scene::check`] guarantees that the material is known.
    pub fn index_of(&self, material: Material) -> Complex64 {
        mean_of_rays(self.rays_of(material))
    }

    /// Ordinary and extraordinary index of a body's material, which are equal in all but crystals.
    pub fn rays_of(&self, material: Material) -> [Complex64; 2] {
        match material {
            Material::Inclusion(index) => [self.inclusions[index]; 2],
            Material::Uniaxial(Uniaxial { ordinary, extraordinary }) => {
                [self.inclusions[ordinary], self.inclusions[extraordinary]]
            }
            Material::Incident => [self.incident; 2],
            Material::Exit => [self.exit; 2],
        }
    }

    /// Largest |η_i² − η_b²| of any material in any background.
    pub fn largest_contrast(&self) -> f64 {
        let contrast = |b: Complex64| self.inclusions.iter().map(move |i| (i * i - b * b).norm());
        self.backgrounds.iter().copied().flat_map(contrast).fold(0.0, f64::max)
    }

    fn check(&self, scene: &Scene) -> Result<(), WaveError> {
        let backgrounds = scene.strata.iter().map(|s| ("background", s.background, self.backgrounds.len()));
        let inclusions = scene.bodies.iter().flat_map(|b| match b.material {
            Material::Inclusion(index) => vec![index],
            Material::Uniaxial(Uniaxial { ordinary, extraordinary }) => vec![ordinary, extraordinary],
            Material::Incident | Material::Exit => Vec::new(),
        });
        let inclusions = inclusions.map(|index| ("inclusion", index, self.inclusions.len()));
        let hosts = scene.bodies.iter().filter_map(|b| Some(("body", b.within?, scene.bodies.len())));
        let mut used = backgrounds.chain(inclusions).chain(hosts);
        if let Some((what, index, known)) = used.find(|&(_, index, known)| index >= known) {
            let sentence = format!("{what} {index} is used, but only {known} are given; add its index");
            return Err(WaveError::Unsound(sentence));
        }
        let named = |name: &'static str| move |(i, &eta): (usize, &Complex64)| (format!("{name} {i}"), eta);
        let all = [("incident", self.incident), ("exit", self.exit)]
            .map(|(side, eta)| (format!("half-space of the {side} side"), eta));
        let inner = self.backgrounds.iter().enumerate().map(named("background"));
        let inner = inner.chain(self.inclusions.iter().enumerate().map(named("inclusion")));
        all.into_iter().chain(inner).try_for_each(|(name, eta)| check_index(&name, eta))
    }
}

/// Index of the mean permittivity of a crystal over all directions of its axis, ε̄ = (2ε_o +
/// ε_e)/3, from its ordinary and extraordinary index; exactly these where they are equal.
pub fn mean_of_rays([ordinary, extraordinary]: [Complex64; 2]) -> Complex64 {
    if ordinary == extraordinary {
        return ordinary;
    }
    ((2.0 * ordinary * ordinary + extraordinary * extraordinary) / 3.0).sqrt()
}

fn check_index(name: &str, eta: Complex64) -> Result<(), WaveError> {
    if eta.is_finite() && eta.im >= 0.0 && eta.re >= 0.0 && eta.norm() > 0.0 {
        return Ok(());
    }
    Err(WaveError::Unsound(format!(
        "refractive index of {name} is {} + {}i; both parts must be finite and ≥ 0 \
         (Im η ≥ 0 absorbs: change the sign if it was given for e^(+iωt))",
        eta.re, eta.im
    )))
}

/// Largest distance of a body from the origin in periods: ten digits of its position in the period
/// remain.
const FARTHEST: f64 = 1e6;

/// Thinnest stratum, µm: the rounding error of its mean operator is about 1e-16/(k h), here 1e-11.
pub const THINNEST_UM: f64 = 1e-6;

fn positive(field: &str, value: f64) -> Result<(), WaveError> {
    if value.is_finite() && value > 0.0 {
        return Ok(());
    }
    Err(WaveError::Unsound(format!("{field} is {value}; it must be finite and above 0")))
}
