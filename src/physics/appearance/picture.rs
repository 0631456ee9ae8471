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
