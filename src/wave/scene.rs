//! What the wave sees: strata of constant index with bodies inside them, and the media's indices.

use super::WaveError;
use num_complex::Complex64;

/// A ball in µm; `center_um` may lie outside the cell, it is wrapped periodically in x and y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball {
    pub center_um: [f64; 3],
    pub radius_um: f64,
}

/// A body's shape, lengths in µm. Bodies along y serve the two-dimensional references.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// Union of balls of one grain; where they overlap the volume counts once.
    Balls(Vec<Ball>),
    /// Infinite circular cylinder along y.
    CylinderY { x_um: f64, z_um: f64, radius_um: f64 },
    /// Infinite rectangular bar along y.
    BarY { x_um: [f64; 2], z_um: [f64; 2] },
    /// Everything above a rough surface except the given balls: vacuum over a relief.
    Above { surface: HeightField, balls: Vec<Ball> },
    /// Whole sheet between two heights (a stratum that the grid need not resolve).
    Sheet { z_um: [f64; 2] },
}

/// A periodic surface z(x, y) in µm on a grid of points (x fastest), bilinear between them.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightField {
    pub z_um: Vec<f64>,
    pub count: [usize; 2],
    pub period_um: [f64; 2],
}

/// What a body consists of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Material {
    /// The medium of this index in [`Media::inclusions`], such as a pigment.
    Inclusion(usize),
    /// The medium of the incident side (vacuum unless the study says otherwise), which fills what a relief leaves open.
    Incident,
}

/// One body of the scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// Where it is, µm.
    pub shape: Shape,
    /// What it consists of.
    pub material: Material,
}

/// One stratum of constant background, counted from z = 0; `background` indexes [`Media::backgrounds`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stratum {
    pub thickness_um: f64,
    pub background: usize,
}

/// The geometry of one periodic cell, 0 ≤ z ≤ H, independent of wavelength and angle.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    pub period_um: [f64; 2],
    pub strata: Vec<Stratum>,
    pub bodies: Vec<Body>,
}

/// Complex refractive indices at one wavelength, Im η ≥ 0 absorbs (time factor e^{−iωt}).
#[derive(Clone, Debug, PartialEq)]
pub struct Media {
    /// Half-space z < 0, the incident side.
    pub incident: Complex64,
    /// Half-space z > H, the exit side.
    pub exit: Complex64,
    pub backgrounds: Vec<Complex64>,
    pub inclusions: Vec<Complex64>,
}

impl Scene {
    /// A single stratum holding `bodies`.
    pub fn layer(period_um: [f64; 2], thickness_um: f64, bodies: Vec<Body>) -> Scene {
        Scene { period_um, strata: vec![Stratum { thickness_um, background: 0 }], bodies }
    }

    /// H, the sum of the strata.
    pub fn thickness_um(&self) -> f64 {
        self.strata.iter().map(|s| s.thickness_um).sum()
    }

    /// True when nothing depends on y, so that only orders n = 0 exist.
    pub fn uniform_in_y(&self) -> bool {
        !self.bodies.iter().any(|b| matches!(b.shape, Shape::Balls(_) | Shape::Above { .. }))
    }

    /// True when nothing depends on x either: a stack of homogeneous films.
    pub fn uniform_in_plane(&self) -> bool {
        self.bodies.iter().all(|b| matches!(b.shape, Shape::Sheet { .. }))
    }

    /// Refuses lengths that are not finite and positive, bodies that leave the layer, and unknown media.
    pub fn check(&self, media: &Media) -> Result<(), WaveError> {
        for (axis, &period) in ["x", "y"].iter().zip(&self.period_um) {
            positive(&format!("period in {axis} (µm)"), period)?;
        }
        for (i, stratum) in self.strata.iter().enumerate() {
            positive(&format!("thickness of stratum {i} (µm)"), stratum.thickness_um)?;
            check_thickness(i, stratum.thickness_um)?;
        }
        let height = self.thickness_um();
        self.bodies.iter().enumerate().try_for_each(|(i, body)| body.check(i, height))?;
        media.check(self)
    }
}

impl Body {
    /// A body of the medium `inclusion` of [`Media::inclusions`].
    pub fn new(shape: Shape, inclusion: usize) -> Body {
        Body { shape, material: Material::Inclusion(inclusion) }
    }

    /// Lowest and highest z of the body.
    pub fn extent_um(&self) -> [f64; 2] {
        match &self.shape {
            Shape::Balls(balls) => balls.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[lo, hi], b| {
                [lo.min(b.center_um[2] - b.radius_um), hi.max(b.center_um[2] + b.radius_um)]
            }),
            Shape::CylinderY { z_um, radius_um, .. } => [z_um - radius_um, z_um + radius_um],
            Shape::Above { surface, .. } => [0.0, surface.deepest_um()],
            Shape::BarY { z_um, .. } | Shape::Sheet { z_um } => *z_um,
        }
    }

    fn check(&self, index: usize, height: f64) -> Result<(), WaveError> {
        let [lo, hi] = self.extent_um();
        let size = hi - lo;
        self.check_lateral(index)?;
        positive(&format!("height of body {index} (µm)"), size)?;
        // A grain that touches a wall may stand out of it by the rounding of its coordinates.
        let slack = 1e-9 * height;
        if lo < -slack || hi > height + slack {
            return Err(WaveError::OutsideLayer {
                body: index,
                low_um: lo,
                high_um: hi,
                thickness_um: height,
            });
        }
        Ok(())
    }
}

impl Body {
    /// Refuses lateral positions that are no numbers; they would only show as NaN in every amplitude.
    fn check_lateral(&self, index: usize) -> Result<(), WaveError> {
        let lateral: Vec<f64> = match &self.shape {
            Shape::Balls(balls) | Shape::Above { balls, .. } => {
                balls.iter().flat_map(|b| b.center_um[..2].to_vec()).collect()
            }
            Shape::CylinderY { x_um, .. } => vec![*x_um],
            Shape::BarY { x_um, .. } => x_um.to_vec(),
            Shape::Sheet { .. } => Vec::new(),
        };
        lateral.into_iter().find(|x| !x.is_finite()).map_or(Ok(()), |value| {
            let field = format!("lateral position of body {index} (µm)");
            Err(WaveError::NotFinite { field, value })
        })
    }
}

impl Media {
    /// Refractive index of a body's material; [`Scene::check`] has seen to it that the material is known.
    pub fn index_of(&self, material: Material) -> Complex64 {
        match material {
            Material::Inclusion(index) => self.inclusions[index],
            Material::Incident => self.incident,
        }
    }

    fn check(&self, scene: &Scene) -> Result<(), WaveError> {
        let missing = |what, need: usize, have: usize| {
            (need >= have).then_some(WaveError::UnknownMedium { what, index: need, known: have })
        };
        let background =
            scene.strata.iter().find_map(|s| missing("background", s.background, self.backgrounds.len()));
        let inclusion = scene.bodies.iter().find_map(|b| match b.material {
            Material::Inclusion(index) => missing("inclusion", index, self.inclusions.len()),
            Material::Incident => None,
        });
        if let Some(error) = background.or(inclusion) {
            return Err(error);
        }
        let named = |name: &'static str| move |(i, &eta): (usize, &Complex64)| (format!("{name} {i}"), eta);
        let all = [
            ("half-space of the incident side".to_string(), self.incident),
            ("half-space of the exit side".to_string(), self.exit),
        ];
        let inner = self.backgrounds.iter().enumerate().map(named("background"));
        let inner = inner.chain(self.inclusions.iter().enumerate().map(named("inclusion")));
        all.into_iter().chain(inner).try_for_each(|(name, eta)| check_index(&name, eta))
    }
}

fn check_index(name: &str, eta: Complex64) -> Result<(), WaveError> {
    if eta.is_finite() && eta.im >= 0.0 && eta.re >= 0.0 && eta.norm() > 0.0 {
        return Ok(());
    }
    Err(WaveError::Index { medium: name.to_string(), real: eta.re, imaginary: eta.im })
}

/// Thinnest stratum, µm: rounding of its mean operator is about 1e-16/(k h), here 1e-11.
pub const THINNEST_UM: f64 = 1e-6;

fn check_thickness(stratum: usize, thickness_um: f64) -> Result<(), WaveError> {
    if thickness_um >= THINNEST_UM {
        return Ok(());
    }
    Err(WaveError::TooThin { stratum, thickness_um, least_um: THINNEST_UM })
}

fn positive(field: &str, value: f64) -> Result<(), WaveError> {
    if value.is_finite() && value > 0.0 {
        return Ok(());
    }
    Err(WaveError::NotPositive { field: field.to_string(), value })
}

impl Scene {
    /// Refuses bodies that overlap: their contrasts would be counted twice. All pairs, with periodic images.
    pub fn check_overlaps(&self) -> Result<(), WaveError> {
        for (j, b) in self.bodies.iter().enumerate() {
            for (i, a) in self.bodies[..=j].iter().enumerate() {
                let overlap_um = self.overlap_um(a, b, i == j);
                // Touching grains may overlap by the rounding of their coordinates.
                if overlap_um > 1e-9 * self.period_um[0] {
                    let between = WaveError::Overlap { first: i, second: j, overlap_um };
                    return Err(if i == j {
                        WaveError::OverlapsImage { body: i, overlap_um }
                    } else {
                        between
                    });
                }
            }
        }
        Ok(())
    }

    /// Depth by which two bodies of the same kind reach into each other, at most; ≤ 0 when they are apart.
    fn overlap_um(&self, a: &Body, b: &Body, same: bool) -> f64 {
        let [lx, ly] = self.period_um;
        let height = |a: [f64; 2], b: [f64; 2]| a[1].min(b[1]) - a[0].max(b[0]);
        match (&a.shape, &b.shape) {
            (Shape::Balls(a), Shape::Balls(b)) => {
                let pairs = a.iter().flat_map(|a| b.iter().map(move |b| (a, b)));
                pairs.map(|(a, b)| self.ball_overlap(a, b, same)).fold(f64::NEG_INFINITY, f64::max)
            }
            (
                Shape::CylinderY { x_um: x1, z_um: z1, radius_um: r1 },
                Shape::CylinderY { x_um: x2, z_um: z2, radius_um: r2 },
            ) => {
                let reach = if same { lx } else { nearest(x1 - x2, lx).hypot(z1 - z2) };
                r1 + r2 - reach
            }
            (Shape::BarY { x_um: x1, z_um: z1 }, Shape::BarY { x_um: x2, z_um: z2 }) if !same => {
                let apart = nearest(0.5 * (x1[0] + x1[1] - x2[0] - x2[1]), lx).abs();
                (0.5 * (x1[1] - x1[0] + x2[1] - x2[0]) - apart).min(height(*z1, *z2))
            }
            (Shape::Sheet { z_um: z1 }, Shape::Sheet { z_um: z2 }) if !same => height(*z1, *z2),
            _ => -lx.min(ly),
        }
    }

    fn ball_overlap(&self, a: &Ball, b: &Ball, same_body: bool) -> f64 {
        let [lx, ly] = self.period_um;
        let delta: [f64; 3] = std::array::from_fn(|i| a.center_um[i] - b.center_um[i]);
        let reach = a.radius_um + b.radius_um;
        if same_body {
            // Parts of one grain may overlap each other, but not their own periodic images.
            let images =
                [[lx, 0.0], [0.0, ly], [lx, ly], [-lx, ly]].into_iter().flat_map(|[x, y]| [[x, y], [-x, -y]]);
            let distance = |[x, y]: [f64; 2]| (delta[0] + x).hypot(delta[1] + y).hypot(delta[2]);
            return images.map(|i| reach - distance(i)).fold(f64::NEG_INFINITY, f64::max);
        }
        reach - nearest(delta[0], lx).hypot(nearest(delta[1], ly)).hypot(delta[2])
    }
}

/// Signed distance to the nearest periodic image.
fn nearest(delta: f64, period: f64) -> f64 {
    delta - period * (delta / period).round()
}
