//! The picture of P1 Fig. 6 in numbers; `inkwave::draw` paints it.
//!
//! Left strip: the ink under natural light, rows are the viewing angle from 0° (top). Right square: the diffuse BRDF
//! times π, rows viewing, columns illumination angle, 0° at the top left. A Lambertian of albedo 1 is (255, 255, 255).
//! P1 leaves open, and this project chooses: the BRDF is averaged over the azimuth between the two planes; the strip
//! contains the mirrored sky or not, as asked; the transfer curve is that of sRGB.

use super::colour::Colour;
use ndarray::Array2;

/// Colours of the strip \[viewing\] and the square \[viewing, illumination\] at the same angles.
#[derive(Clone, Debug, PartialEq)]
pub struct InkPicture {
    /// Angles of strip and square, degrees, rising.
    pub angles_deg: Vec<f64>,
    /// Under natural light, against the viewing angle.
    pub strip: Vec<Colour>,
    /// Diffuse reflection: rows by viewing angle, columns by angle of illumination.
    pub square: Array2<Colour>,
}
