//! Data of the picture of P1 Fig. 6; `inkwave::draw` renders it.
//!
//! Left strip: the ink under natural light, rows by viewing angle from 0° (top). Right square: the
//! diffuse BRDF times π, rows by viewing angle, columns by angle of illumination, 0° at the top
//! left. A Lambertian surface of albedo 1 is (255, 255, 255). Choices that P1 leaves open: the BRDF
//! is averaged over the azimuth between the two planes; the mirrored sky is optional in the strip;
//! the transfer curve is that of sRGB.

use super::colour::Colour;
use ndarray::Array2;

/// Colours of the strip \[viewing\] and the square \[viewing, illumination\] at common angles.
#[derive(Clone, Debug, PartialEq)]
pub struct InkPicture {
    /// Angles of strip and square, degrees, increasing.
    pub angles_deg: Vec<f64>,
    /// Colours under natural light by viewing angle.
    pub strip: Vec<Colour>,
    /// Diffuse reflection: rows by viewing angle, columns by angle of illumination.
    pub square: Array2<Colour>,
}

/// What a screen shows of a picture: gamma-encoded sRGB in steps of 1/255.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ScreenPicture {
    /// Angles of strip and square, degrees, increasing.
    pub angles_deg: Vec<f64>,
    /// Under natural light by viewing angle.
    pub strip: Vec<[u8; 3]>,
    /// Diffuse reflection: rows by viewing angle, columns by angle of illumination.
    pub square: Vec<Vec<[u8; 3]>>,
}

impl InkPicture {
    /// What a screen shows of it.
    pub fn on_screen(&self) -> ScreenPicture {
        let shown = |colour: &Colour| colour.srgb8;
        ScreenPicture {
            angles_deg: self.angles_deg.clone(),
            strip: self.strip.iter().map(shown).collect(),
            square: self.square.rows().into_iter().map(|row| row.iter().map(shown).collect()).collect(),
        }
    }

    /// The picture whose strip has these colours by place of the viewing angle, and whose square
    /// has these by places of viewing and illumination.
    ///
    /// # Errors
    /// The first colour that cannot be computed.
    pub fn new<E>(
        angles_deg: &[f64],
        strip: impl Fn(usize) -> Result<Colour, E>,
        square: impl Fn(usize, usize) -> Result<Colour, E>,
    ) -> Result<Self, E> {
        let n = angles_deg.len();
        let strip = (0..n).map(strip).collect::<Result<_, _>>()?;
        let all = (0..n * n).map(|k| square(k / n, k % n)).collect::<Result<Vec<_>, _>>()?;
        let square = Array2::from_shape_fn((n, n), |(o, i)| all[o * n + i]);
        Ok(Self { angles_deg: angles_deg.to_vec(), strip, square })
    }
}
