//! The BRDF of the ink on its paper for any pair of directions, as a renderer asks for it.
//!
//! ```text
//! f(i, o) = f_layer,diffuse(i, o) + g T(i) T(o)/π          (P1 section 5)
//! ```
//!
//! The layer's own part is the smoothed diffuse BRDF of the orders: no mirror part, which is a delta and not a density.
//! It is solved at the rule's angles of incidence and linear in the angle between them; T comes from the program's own
//! interpolation, fringes included (a linear one made the colour 1 % too dark). The layer is taken as isotropic, so both
//! senses of the azimuth are averaged: f(i, o) depends on |φ_o − φ_i| alone.

use super::angles::PolarAngle;
use super::bdf::{Bdf, BdfError, Lobe};
use super::ink_on_paper::{InkError, InkOnPaper};
use super::paper::LayerOnPaper;
use std::f64::consts::PI;

/// A direction on the incident side: angle from the normal and azimuth from the plane of incidence (0: forward, where the
/// mirror image lies), degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Direction {
    /// From the normal, degrees, below 90.
    pub polar_deg: f64,
    /// From the direction the light travels to, degrees.
    pub azimuth_deg: f64,
}

/// The ink on its paper with the distributions of its layer.
#[derive(Clone, Debug)]
pub struct DirectionalInk<'a> {
    ink: &'a InkOnPaper,
    /// \[wavelength\]\[angle of incidence\], angles as in the ink's rule.
    layers: Vec<&'a [Bdf]>,
    /// Smoothing of the layer's diffuse part at each wavelength, direction cosines.
    bandwidths: Vec<f64>,
}

impl<'a> DirectionalInk<'a> {
    /// `layers[w]` starts with the distributions at the rule's angles, in their order; `bandwidths[w]` smooths them.
    ///
    /// # Errors
    /// Fewer distributions than the rule has angles, or not one list for every wavelength.
    pub fn new(ink: &'a InkOnPaper, layers: Vec<&'a [Bdf]>, bandwidths: Vec<f64>) -> Result<Self, InkError> {
        let expected = ink.wavelengths_nm().len();
        for (field, count) in [("layers", layers.len()), ("bandwidths", bandwidths.len())] {
            if count != expected {
                return Err(InkError::Count { field, count, expected });
            }
        }
        let angles = ink.rule().above.len();
        match layers.iter().find(|bdfs| bdfs.len() < angles) {
            Some(bdfs) => Err(InkError::Count { field: "angles", count: bdfs.len(), expected: angles }),
            None => Ok(Self { ink, layers, bandwidths }),
        }
    }

    /// The ink itself.
    pub fn ink(&self) -> &InkOnPaper {
        self.ink
    }

    /// The rule's angles of incidence, degrees, rising.
    pub fn nodes_deg(&self) -> Vec<f64> {
        self.ink.rule().above.iter().map(|node| node.polar_deg).collect()
    }

    /// T(θ) at a wavelength; beyond the rule's largest angle it falls to 0 at grazing as cos θ does.
    ///
    /// # Errors
    /// An angle below 0.
    pub fn transmittance(&self, wavelength: usize, polar_deg: f64) -> Result<f64, InkError> {
        self.with_grazing(polar_deg, |at| self.ink.layers()[wavelength].transmittance(at))
    }

    /// Specular part of R(θ); it rises to 1 at grazing beyond the rule's largest angle.
    ///
    /// # Errors
    /// An angle below 0.
    pub fn specular(&self, wavelength: usize, polar_deg: f64) -> Result<f64, InkError> {
        Ok(1.0 - self.with_grazing(polar_deg, |at| 1.0 - self.ink.layers()[wavelength].specular(at))?)
    }

    /// The directional–hemispherical albedo without its mirror part.
    ///
    /// # Errors
    /// An angle outside the rule's.
    pub fn diffuse_albedo(&self, wavelength: usize, polar_deg: f64) -> Result<f64, InkError> {
        let (at, layer) = (self.ink.rule().at(polar_deg)?, &self.ink.layers()[wavelength]);
        Ok(layer.albedo(&at) - layer.specular(&at))
    }

    /// g T(i) T(o)/π: light that has been in the paper, 1/sr.
    ///
    /// # Errors
    /// An angle below 0.
    pub fn paper_brdf(&self, wavelength: usize, light_deg: f64, view_deg: f64) -> Result<f64, InkError> {
        let layer: &LayerOnPaper = &self.ink.layers()[wavelength];
        let passes = self.transmittance(wavelength, light_deg)? * self.transmittance(wavelength, view_deg)?;
        Ok(layer.return_factor() * passes / PI)
    }

    /// The layer's own diffuse BRDF at node `k` of the rule, 1/sr; 0 where the cell is too narrow to scatter.
    ///
    /// # Errors
    /// A direction without any order within the bandwidth.
    pub fn layer_brdf(&self, wavelength: usize, k: usize, view: Direction) -> Result<f64, BdfError> {
        let bdf = &self.layers[wavelength][k];
        if !bdf.scatters(Lobe::Reflected) {
            return Ok(0.0);
        }
        let sin = view.polar_deg.to_radians().sin();
        let at = |turn: f64| {
            let azimuth = (bdf.incidence().azimuth_deg + turn).to_radians();
            let direction = [sin * azimuth.cos(), sin * azimuth.sin()];
            Ok(bdf.at(Lobe::Reflected, direction, self.bandwidths[wavelength])?.bdf.value)
        };
        Ok((at(view.azimuth_deg)? + at(-view.azimuth_deg)?) / 2.0)
    }

    /// f(i, o) at a wavelength, 1/sr, mirror part left out.
    ///
    /// # Errors
    /// As [`DirectionalInk::layer_brdf`] and [`DirectionalInk::paper_brdf`].
    pub fn brdf(&self, wavelength: usize, light_deg: f64, view: Direction) -> Result<f64, InkError> {
        let mut own = 0.0;
        for (k, share) in neighbours(&self.nodes_deg(), light_deg) {
            if share > 0.0 {
                own += share * self.layer_brdf(wavelength, k, view)?;
            }
        }
        Ok(own + self.paper_brdf(wavelength, light_deg, view.polar_deg)?)
    }

    /// A quantity that vanishes at grazing, as cos θ does beyond the rule's largest angle.
    fn with_grazing(&self, polar_deg: f64, of: impl Fn(&PolarAngle) -> f64) -> Result<f64, InkError> {
        let rule = self.ink.rule();
        let largest = rule.above.last().map_or(0.0, |node| node.polar_deg);
        let cosine = |deg: f64| deg.to_radians().cos();
        let beyond = if polar_deg > largest { cosine(polar_deg).max(0.0) / cosine(largest) } else { 1.0 };
        Ok(of(&rule.at(polar_deg.min(largest))?) * beyond)
    }
}

/// The two nodes around an angle with their weights, linear between, the ends beyond.
fn neighbours(nodes_deg: &[f64], at_deg: f64) -> [(usize, f64); 2] {
    let last = nodes_deg.len() - 1;
    let after = nodes_deg.partition_point(|&deg| deg < at_deg).clamp(1.min(last), last);
    let before = after.saturating_sub(1);
    let span = nodes_deg[after] - nodes_deg[before];
    let t = if span > 0.0 { ((at_deg - nodes_deg[before]) / span).clamp(0.0, 1.0) } else { 0.0 };
    [(before, 1.0 - t), (after, t)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_are_linear_between_nodes_and_constant_beyond() {
        let nodes = [0.0, 20.0, 60.0];
        assert_eq!(neighbours(&nodes, 30.0), [(1, 0.75), (2, 0.25)]);
        assert_eq!(neighbours(&nodes, 0.0), [(0, 1.0), (1, 0.0)]);
        assert_eq!(neighbours(&nodes, 80.0), [(1, 0.0), (2, 1.0)]);
        assert_eq!(neighbours(&[0.0], 40.0), [(0, 1.0), (0, 0.0)]);
    }
}
