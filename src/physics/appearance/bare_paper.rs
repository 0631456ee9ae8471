//! Bare paper as instruments measure it, and the albedo that lies behind its surface.
//!
//! In optical contact the paper's scatterers sit in a medium of index n. Bare, this medium has a
//! plane surface to air, which light crosses on its way in and out; what comes back inside is
//! reflected again (Saunderson 1942, here with Fresnel's formulas for unpolarised light):
//!
//! ```text
//! β = m + T_in T_out/n² · ρ/(1 − ρ R̄_b)     R̄_b = 1 − T̄/n²     T̄ = 2∫₀¹ T(μ) μ dμ
//! x = (β − m) n²/(T_in T_out)                 ρ = x/(1 + x R̄_b)
//! ```
//!
//! with m what the surface mirrors into the instrument. This is the series of
//! [`returned`] for a layer that is this surface alone. Behind an air gap
//! bare paper has no surface, and the factor is the albedo.

use super::paper::{Coupling, PRINT_DEG, PaperError, returned};
use gauss_quad::GaussLegendre;

/// Directions of light and view of an instrument.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum PaperGeometry {
    /// Lit at 45°, seen along the normal, or the reverse: equal by reciprocity.
    #[default]
    #[cfg_attr(feature = "serde", serde(rename = "45:0", alias = "0:45"))]
    LitAt45,
    /// Diffuse light, seen at 8°, mirrored light included.
    #[cfg_attr(feature = "serde", serde(rename = "d:8"))]
    Sphere,
    /// Diffuse light, seen at 8°, mirrored light excluded.
    #[cfg_attr(feature = "serde", serde(rename = "d:8 excluded"))]
    SphereExcluded,
    /// Diffuse light, seen along the normal through a port, so that nothing is mirrored.
    #[cfg_attr(feature = "serde", serde(rename = "d:0"))]
    DiffuseNormal,
    /// A uniform sky, seen along the normal, mirrored light included.
    #[cfg_attr(feature = "serde", serde(rename = "natural"))]
    NaturalLight,
}

/// Angle of view of instruments with a sphere, degrees.
pub const SPHERE_DEG: f64 = 8.0;

impl PaperGeometry {
    /// All of them.
    pub const ALL: [Self; 5] =
        [Self::LitAt45, Self::Sphere, Self::SphereExcluded, Self::DiffuseNormal, Self::NaturalLight];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::LitAt45 => "45:0",
            Self::Sphere => "d:8",
            Self::SphereExcluded => "d:8 excluded",
            Self::DiffuseNormal => "d:0",
            Self::NaturalLight => "natural",
        }
    }
}

/// The surface of bare paper: none for a gap, else plane, between air and the paper's medium.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BareSurface {
    index: f64,
    light: SurfaceLight,
    mean_transmittance: f64,
}

/// Nodes of the mean over the hemisphere; the transmittance has a root at grazing incidence, where
/// its weight vanishes.
const NODES: usize = 64;

/// The light that crosses a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum SurfaceLight {
    /// Half of it s, half of it p.
    Unpolarised,
    /// E perpendicular to the plane of incidence.
    S,
}

impl BareSurface {
    /// The surface that bare paper has with this contact between ink and paper.
    pub fn new(coupling: Coupling) -> Self {
        Self::of_light(coupling, SurfaceLight::Unpolarised)
    }

    /// This surface as s light meets it, and with it the scalar wave.
    pub fn of_s_light(coupling: Coupling) -> Self {
        Self::of_light(coupling, SurfaceLight::S)
    }

    fn of_light(coupling: Coupling, light: SurfaceLight) -> Self {
        let index = coupling.index_out();
        let rule = GaussLegendre::new(NODES).expect("a positive number of nodes");
        // with μ = s² the root at grazing incidence is smooth
        let mean = rule.integrate(0.0, 1.0, |s: f64| 4.0 * s.powi(3) * transmitted(index, s * s, light));
        Self { index, light, mean_transmittance: if index == 1.0 { 1.0 } else { mean } }
    }

    /// T of light from air at an angle from the normal, degrees.
    pub fn transmittance(&self, polar_deg: f64) -> f64 {
        transmitted(self.index, polar_deg.to_radians().cos(), self.light)
    }

    /// T̄ of diffuse light from air.
    pub fn mean_transmittance(&self) -> f64 {
        self.mean_transmittance
    }

    /// T̄/n², the share of diffuse light from the paper that leaves: 1 − R̄_b.
    pub fn escaping(&self) -> f64 {
        self.mean_transmittance / (self.index * self.index)
    }

    /// T_in of the light of an instrument, and T_out/n² towards its eye.
    pub fn passed(&self, geometry: PaperGeometry) -> [f64; 2] {
        let density = self.index * self.index;
        match geometry {
            PaperGeometry::LitAt45 => [self.transmittance(PRINT_DEG), self.transmittance(0.0) / density],
            PaperGeometry::Sphere | PaperGeometry::SphereExcluded => {
                [self.mean_transmittance, self.transmittance(SPHERE_DEG) / density]
            }
            PaperGeometry::DiffuseNormal | PaperGeometry::NaturalLight => {
                [self.mean_transmittance, self.transmittance(0.0) / density]
            }
        }
    }

    /// What the surface mirrors into the instrument.
    fn mirrored(&self, geometry: PaperGeometry) -> f64 {
        match geometry {
            PaperGeometry::Sphere => 1.0 - self.transmittance(SPHERE_DEG),
            PaperGeometry::NaturalLight => 1.0 - self.transmittance(0.0),
            PaperGeometry::LitAt45 | PaperGeometry::SphereExcluded | PaperGeometry::DiffuseNormal => 0.0,
        }
    }

    /// The factor that an instrument reads on bare paper of this albedo, a perfect white being 1.
    ///
    /// # Errors
    /// An albedo outside 0–1.
    pub fn factor(&self, albedo: f64, geometry: PaperGeometry) -> Result<f64, PaperError> {
        let [inwards, outwards] = self.passed(geometry);
        let series = returned(albedo, self.mean_transmittance, 0.0, self.index)? * self.index * self.index;
        Ok(self.mirrored(geometry) + inwards * outwards * series)
    }

    /// The albedo behind the surface of paper that reads this factor. It is above 1 where no paper
    /// without fluorescence reads so much, and below 0 for less than the surface mirrors.
    pub fn albedo(&self, factor: f64, geometry: PaperGeometry) -> f64 {
        let [inwards, outwards] = self.passed(geometry);
        let inside = (factor - self.mirrored(geometry)) / (inwards * outwards);
        inside / (1.0 + inside * (1.0 - self.escaping()))
    }
}

/// T of light from air into a medium of this index, by the cosine of the angle in air.
fn transmitted(index: f64, cosine: f64, light: SurfaceLight) -> f64 {
    if index == 1.0 {
        return 1.0;
    }
    let inner = (1.0 - (1.0 - cosine * cosine) / (index * index)).sqrt();
    let s = (cosine - index * inner) / (cosine + index * inner);
    let p = (index * cosine - inner) / (index * cosine + inner);
    match light {
        SurfaceLight::Unpolarised => 1.0 - 0.5 * (s * s + p * p),
        SurfaceLight::S => 1.0 - s * s,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// T̄ of a face of 1.5 is 0.9082 (Saunderson's 0.0918 of diffuse light reflected), and inside
    /// 0.5963 of diffuse light comes back.
    #[test]
    fn means_are_those_of_tables() {
        let surface = BareSurface::new(Coupling::OpticalContact { index: 1.5 });
        assert!((surface.mean_transmittance() - 0.9082).abs() < 1e-4, "{}", surface.mean_transmittance());
        assert!((1.0 - surface.escaping() - 0.5963).abs() < 1e-4);
    }

    /// Scalar light behind a face of 1.5: a paper of 0.9444 that reads 0.876 at 45:0 bare reads
    /// 0.884 there, and a perfect white T(45°) T(0°)/T̄ of s light. *Planted*: p light for s.
    #[test]
    fn s_light_meets_another_surface() {
        let coupling = Coupling::OpticalContact { index: 1.5 };
        let albedo = BareSurface::new(coupling).albedo(0.876, PaperGeometry::LitAt45);
        let surface = BareSurface::of_s_light(coupling);
        let factor = surface.factor(albedo, PaperGeometry::LitAt45).unwrap();
        assert!((factor - 0.8841).abs() < 1e-4, "{factor}");
        // (1 − r²) of s light at 45°: r = (cos 45° − √(1.5² − 1/2))/(cos 45° + √(1.5² − 1/2))
        let inner = (1.5_f64 * 1.5 - 0.5).sqrt();
        let r = (0.5_f64.sqrt() - inner) / (0.5_f64.sqrt() + inner);
        assert!((surface.transmittance(45.0) - (1.0 - r * r)).abs() < 1e-14);
        let white = surface.factor(1.0, PaperGeometry::LitAt45).unwrap();
        assert!((white - surface.transmittance(45.0) * 0.96 / surface.mean_transmittance()).abs() < 1e-12);
    }

    /// The albedo of a factor reads that factor, in every geometry; behind a gap both are equal.
    /// *Planted*: R̄_b left out of the inverse.
    #[test]
    fn albedo_and_factor_are_inverse() {
        for geometry in PaperGeometry::ALL {
            let surface = BareSurface::new(Coupling::OpticalContact { index: 1.53 });
            let gap = BareSurface::new(Coupling::Gap);
            for albedo in [0.0, 0.3, 0.955, 1.0] {
                let factor = surface.factor(albedo, geometry).unwrap();
                // identity: rounding
                assert!((surface.albedo(factor, geometry) - albedo).abs() < 1e-14);
                assert_eq!(gap.factor(albedo, geometry).unwrap(), albedo);
                assert_eq!(gap.albedo(albedo, geometry), albedo);
            }
        }
    }
}
