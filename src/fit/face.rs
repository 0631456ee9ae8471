//! The face of a measured sample in place of the smooth one that the wave equation has.
//!
//! A matt or dusty face adds light. Saunderson's constants stand for a whole face: the smooth one is
//! taken off by his formula with the constants of its index, and the sample's is put on. Light is
//! taken to be diffuse inside, as in all such corrections.

use super::file::FitGeometry;
use crate::appearance::kubelka_munk::DiffuseFaces;
use num_complex::Complex64;

/// Angle of the light at 45:0 within Fresnel's formulas.
const LIT_DEG: f64 = 45.0;

/// Cuts of the mean over diffuse light: to 1e-6.
const CUTS: usize = 500;

/// A sample's face.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum SampleFace {
    /// That of the base.
    #[default]
    Smooth,
    /// A smooth one that adds light.
    Matt {
        /// Added to the reflectance factor.
        light: f64,
    },
    /// Another face.
    Saunderson {
        /// The smooth face at every wavelength.
        smooth: Vec<DiffuseFaces>,
        /// The sample's.
        own: DiffuseFaces,
    },
}

impl SampleFace {
    /// A face with Saunderson's \[k₁, k₂\] on a binder with an index at every wavelength.
    pub fn saunderson([k1, k2]: [f64; 2], geometry: FitGeometry, binder: &[Complex64]) -> Self {
        let polar_deg = if geometry == FitGeometry::LitAt45 { LIT_DEG } else { 0.0 };
        let smooth = |eta: &Complex64| DiffuseFaces {
            external: fresnel(eta.re, polar_deg),
            ..DiffuseFaces::plane(of_diffuse_light(eta.re), eta.re)
        };
        Self::Saunderson {
            smooth: binder.iter().map(smooth).collect(),
            own: DiffuseFaces { external: k1, internal: k2 },
        }
    }

    /// What an instrument reads, from the reading of the smooth sample at a wavelength by its
    /// place.
    pub fn seen(&self, wave: usize, reading: f64, geometry: FitGeometry) -> f64 {
        match self {
            Self::Smooth => reading,
            Self::Matt { light } => reading + light,
            Self::Saunderson { smooth, own } => {
                let smooth = &smooth[wave];
                let mirrored = |face: &DiffuseFaces| {
                    if geometry.includes_mirrored() { 0.0 } else { face.external }
                };
                // faces hold what they mirror; a reading without it lacks it
                let bare = smooth.taken_off(reading + mirrored(smooth), 0.0);
                bare.map_or(f64::NAN, |[bare, _]| own.put_on(bare, 0.0)[0] - mirrored(own))
            }
        }
    }

    /// Derivative of [`SampleFace::seen`] with respect to the reading.
    pub fn slope(&self, wave: usize, reading: f64, geometry: FitGeometry) -> f64 {
        let step = 1e-6;
        let [more, less] = [step, -step].map(|by| self.seen(wave, reading + by, geometry));
        (more - less) / (2.0 * step)
    }
}

/// Fresnel's reflectance of unpolarised light from air.
fn fresnel(index: f64, polar_deg: f64) -> f64 {
    let (sine, cosine) = polar_deg.to_radians().sin_cos();
    let inside = (1.0 - (sine / index).powi(2)).sqrt();
    let s = (cosine - index * inside) / (cosine + index * inside);
    let p = (index * cosine - inside) / (index * cosine + inside);
    0.5 * (s * s + p * p)
}

/// Its mean over diffuse light: ∫ F d(sin²θ), by the midpoint rule in the cosine.
fn of_diffuse_light(index: f64) -> f64 {
    let cosine = |k: usize| (k as f64 + 0.5) / CUTS as f64;
    let part = |cosine: f64| 2.0 * cosine * fresnel(index, cosine.acos().to_degrees());
    (0..CUTS).map(|k| part(cosine(k))).sum::<f64>() / CUTS as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Walsh's 0.0918 of diffuse light at n = 1.5, and with it k₂ = 0.596.
    #[test]
    fn a_smooth_face_has_the_constants_of_its_index() {
        assert!((of_diffuse_light(1.5) - 0.0918).abs() < 1e-4, "{}", of_diffuse_light(1.5));
        let internal = DiffuseFaces::plane(of_diffuse_light(1.5), 1.5).internal;
        assert!((internal - 0.596).abs() < 1e-3, "{internal}");
        assert!((fresnel(1.5, 0.0) - 0.04).abs() < 1e-12);
    }

    /// Saunderson's own formula, R = k₁ + (1 − k₁)(1 − k₂) r/(1 − k₂ r), of a body of r = 0.3 behind a
    /// smooth face. *Planted*: k₁ left in where specular light is excluded; the smooth face left on.
    #[test]
    fn a_face_takes_the_place_of_the_smooth_one() {
        let saunderson = |k1: f64, k2: f64, r: f64| (1.0 - k1) * (1.0 - k2) * r / (1.0 - k2 * r);
        let binder = [Complex64::new(1.5, 0.0); 2];
        let k2 = 1.0 - (1.0 - of_diffuse_light(1.5)) / 2.25;
        for (geometry, mirror, kept) in [
            (FitGeometry::Sphere, 0.04, 1.0),
            (FitGeometry::SphereExcluded, 0.04, 0.0),
            (FitGeometry::LitAt45, fresnel(1.5, 45.0), 0.0),
        ] {
            let reading = kept * mirror + saunderson(mirror, k2, 0.3);
            let face = SampleFace::saunderson([0.03, 0.5], geometry, &binder);
            let expected = kept * 0.03 + saunderson(0.03, 0.5, 0.3);
            let seen = face.seen(1, reading, geometry);
            assert!((seen - expected).abs() < 1e-12, "{geometry:?}: {seen} for {expected}");
        }
        let matt = SampleFace::Matt { light: 0.012 };
        assert!((matt.seen(0, 0.2, FitGeometry::LitAt45) - 0.212).abs() < 1e-15);
        assert!((matt.slope(0, 0.2, FitGeometry::LitAt45) - 1.0).abs() < 1e-9);
    }
}
