//! The BRDF of the ink on its paper for any pair of directions, for renderers.
//!
//! ```text
//! f(i, o) = f_layer,diffuse(i, o) + g T(i) T(o)/π          (P1 section 5)
//! ```
//!
//! The mirror reflection is left out, because it is a delta function. The layer's diffuse part is
//! the BRDF fitted to all orders, with its dependence on the azimuth Δφ between the planes (cos Δφ
//! and cos 2Δφ); light returned by the paper does not depend on it. T is tabulated finely enough
//! for interference fringes; its mean over the hemisphere is T̄, so that a renderer obtains the
//! albedo R + g T T̄.

use super::films::hemisphere;
use super::ink::{InkError, InkOnPaper};
use super::on_paper::{LayerOnPaper, PolarAngle};
use crate::numerics::estimate::Estimate;
use std::f64::consts::PI;

/// A direction on the incident side. Azimuth 0 is forward, where the mirror image lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Direction {
    /// Angle from the normal, degrees, up to 90.
    pub polar_deg: f64,
    /// Azimuth from the direction in which the light travels, degrees.
    pub azimuth_deg: f64,
}

/// What renderers ask of a print: its diffuse BRDF and its mirror part.
pub trait DirectionalPrint: Sync {
    /// Wavelengths, nm.
    fn wavelengths_nm(&self) -> &[f64];

    /// f(i, o) at the wavelength with this index, 1/sr, without mirror reflection.
    fn brdf(&self, wavelength: usize, light_deg: f64, view: Direction) -> f64;

    /// Specular part of R(θ).
    fn specular(&self, wavelength: usize, polar_deg: f64) -> f64;

    /// The directional–hemispherical albedo without mirror reflection.
    fn diffuse_albedo(&self, wavelength: usize, polar_deg: f64) -> f64;

    /// ∫ f cos θ_o dω at every wavelength, minus the albedo without mirror reflection.
    ///
    /// # Errors
    /// The print refuses the angle.
    fn disagreement(&self, polar_deg: f64) -> Result<Vec<Disagreement>, InkError>;

    /// Recommended angles of incidence of a table, degrees, increasing.
    fn nodes_deg(&self) -> Vec<f64> {
        NODES_DEG.to_vec()
    }
}

/// A difference between the albedo by two ways, with its standard error in two parts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disagreement {
    /// The difference.
    pub value: f64,
    /// Standard error by chance: jackknife over the realisations; `None` where it is unknown.
    pub chance: Option<f64>,
    /// What the two fits differ by beyond chance, root mean square over the hemisphere: polynomials
    /// of the cosines and splines of the wavelength do not hold all of f and of R.
    pub of_fits: f64,
}

impl Disagreement {
    /// A difference without a known error.
    pub fn unknown_error(value: f64) -> Self {
        Self { value, chance: None, of_fits: 0.0 }
    }

    /// Standard error of both parts.
    pub fn standard_error(&self) -> Option<f64> {
        self.chance.map(|chance| chance.hypot(self.of_fits))
    }
}

/// Step of the tables, degrees: linear interpolation is accurate to about 1e-5 in T for a film of a
/// few wavelengths.
const STEP_DEG: f64 = 0.25;
/// Recommended angles of incidence of a renderer's tables, degrees.
const NODES_DEG: [f64; 10] = [0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0, 85.0];

/// The ink on its paper, tabulated against the angle.
#[derive(Clone, Debug)]
pub struct DirectionalInk<'a> {
    ink: &'a InkOnPaper,
    /// \[wavelength\]\[angle\]: T, mirror part of R, albedo, T of the light returned by the paper;
    /// the last angle is grazing.
    tables: Vec<Vec<[f64; 4]>>,
    /// Angles with the weights of 2∫₀¹ f μ dμ.
    hemisphere: Vec<(PolarAngle, f64)>,
    /// \[wavelength\]: what the fits of f and of R differ by beyond chance.
    of_fits: Vec<f64>,
}

/// T, mirror part of R, albedo, T of the light returned by the paper; `bend` is added to the T
/// whose mean is T̄.
fn row(layer: &LayerOnPaper, angle: &PolarAngle, bend: f64) -> [f64; 4] {
    let through = layer.transmittance(angle);
    let back = layer.transmittance_returned(angle);
    // for polarised light T̄ is not the mean of this T
    let through = if through == back { through + bend } else { through };
    let returned = layer.return_factor() * through * layer.mean_transmittance();
    [through, layer.mirrored(angle), layer.reflectance(angle) + returned, back + bend]
}

impl<'a> DirectionalInk<'a> {
    /// Tabulates the ink.
    ///
    /// # Errors
    /// The ink refuses an angle.
    pub fn new(ink: &'a InkOnPaper) -> Result<Self, InkError> {
        let steps = (90.0 / STEP_DEG) as usize;
        let hemisphere = hemisphere().into_iter().map(|(deg, weight)| Ok((ink.at(deg)?, weight)));
        let hemisphere = hemisphere.collect::<Result<Vec<_>, InkError>>()?;
        let mut tables = vec![Vec::with_capacity(steps + 1); ink.wavelengths_nm().len()];
        let lacking: Vec<_> = ink.layers().iter().map(|layer| layer.lacking_bends(&hemisphere)).collect();
        for k in 0..steps {
            let angle = ink.at(k as f64 * STEP_DEG)?;
            for ((table, layer), lacking) in tables.iter_mut().zip(ink.layers()).zip(&lacking) {
                table.push(row(layer, &angle, angle.bent(lacking)));
            }
        }
        tables.iter_mut().for_each(|table| table.push([0.0, 1.0, 1.0, 0.0]));
        let mut directional = Self { ink, tables, hemisphere, of_fits: Vec::new() };
        directional.of_fits = directional.beyond_chance();
        Ok(directional)
    }

    /// Root of the mean over the hemisphere of d² less its variance by chance, for the difference d
    /// between the fits of f and of R; 0 where chance explains it.
    fn beyond_chance(&self) -> Vec<f64> {
        let mut squares = vec![0.0; self.ink.wavelengths_nm().len()];
        for (angle, weight) in &self.hemisphere {
            for (square, difference) in squares.iter_mut().zip(self.difference(angle)) {
                let chance = difference.standard_error.unwrap_or(0.0);
                *square += weight * (difference.value.powi(2) - chance.powi(2));
            }
        }
        squares.into_iter().map(|square| square.max(0.0).sqrt()).collect()
    }

    /// Difference between the fits of f and of R, with its jackknife error.
    fn difference(&self, angle: &PolarAngle) -> Vec<Estimate> {
        let difference = |layer: &LayerOnPaper| {
            layer.own_albedo(angle, &self.hemisphere) - (layer.reflectance(angle) - layer.mirrored(angle))
        };
        self.ink.spectrum(difference).estimates()
    }

    /// T(θ) at the wavelength with this index.
    pub fn transmittance(&self, wavelength: usize, polar_deg: f64) -> f64 {
        self.tabulated(wavelength, polar_deg)[0]
    }

    fn tabulated(&self, wavelength: usize, polar_deg: f64) -> [f64; 4] {
        interpolated(&self.tables[wavelength], polar_deg / STEP_DEG)
    }
}

/// The rows of a table, of two or more, at a place between them.
pub(super) fn interpolated<const N: usize>(table: &[[f64; N]], place: f64) -> [f64; N] {
    let place = place.clamp(0.0, (table.len() - 1) as f64);
    let before = (place as usize).min(table.len() - 2);
    let t = place - before as f64;
    std::array::from_fn(|i| (1.0 - t) * table[before][i] + t * table[before + 1][i])
}

impl DirectionalPrint for DirectionalInk<'_> {
    fn wavelengths_nm(&self) -> &[f64] {
        self.ink.wavelengths_nm()
    }

    fn brdf(&self, wavelength: usize, light_deg: f64, view: Direction) -> f64 {
        let cosine = |deg: f64| deg.to_radians().cos();
        let layer = &self.ink.layers()[wavelength];
        let lit = cosine(light_deg);
        let seen = cosine(view.polar_deg);
        let diffuse = layer.directional_brdf(lit, seen, cosine(view.azimuth_deg));
        let back = self.tabulated(wavelength, view.polar_deg)[3];
        // g T(i) T(o)/π: light returned by the paper, 1/sr
        diffuse + layer.return_factor() * (self.transmittance(wavelength, light_deg) * back) / PI
    }

    fn specular(&self, wavelength: usize, polar_deg: f64) -> f64 {
        self.tabulated(wavelength, polar_deg)[1]
    }

    fn diffuse_albedo(&self, wavelength: usize, polar_deg: f64) -> f64 {
        let [_, specular, albedo, _] = self.tabulated(wavelength, polar_deg);
        albedo - specular
    }

    /// Light returned by the paper is the same in both: this is the difference between the fits of
    /// f and of R.
    fn disagreement(&self, polar_deg: f64) -> Result<Vec<Disagreement>, InkError> {
        let differences = self.difference(&self.ink.at(polar_deg)?).into_iter().zip(&self.of_fits);
        let with_error = |(d, &of_fits): (Estimate, &f64)| Disagreement {
            value: d.value,
            chance: d.standard_error,
            of_fits,
        };
        Ok(differences.map(with_error).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::appearance::paper::Coupling;
    use crate::evaluate::ink::tests::{molecular_ink, yellow_made_up};

    #[test]
    fn tables_follow_the_ink() {
        let ink = molecular_ink("yellow", 0.3, Coupling::Gap);
        let directional = DirectionalInk::new(&ink).unwrap();
        for deg in [0.0, 13.1, 44.9, 70.3] {
            let angle = ink.at(deg).unwrap();
            let layer = &ink.layers()[7];
            // linear between steps of a quarter of a degree
            assert!((directional.transmittance(7, deg) - layer.transmittance(&angle)).abs() < 5e-5);
            assert!((directional.specular(7, deg) - layer.mirrored(&angle)).abs() < 5e-5);
            let view = Direction { polar_deg: deg, azimuth_deg: 30.0 };
            assert!(
                (directional.brdf(7, 0.0, view) - layer.brdf(&ink.at(0.0).unwrap(), &angle)).abs() < 5e-5
            );
        }
        assert_eq!((directional.transmittance(0, 90.0), directional.specular(0, 90.0)), (0.0, 1.0));
    }

    /// R of the made-up layer has a band in the wavelength and its f none: the difference is the
    /// same in every packing, and no chance. *Planted*: with the jackknife error alone it is
    /// hundreds of errors off.
    #[test]
    fn what_the_fits_cannot_hold_is_in_the_error() {
        let made = yellow_made_up(1e-4);
        let (ink, _) = made.ink(8, 3);
        let directional = DirectionalInk::new(&ink).unwrap();
        let mut squares = 0.0;
        let mut by_chance = 0.0;
        let mut count = 0.0;
        for deg in [5.0, 20.0, 35.0, 50.0, 65.0] {
            for apart in directional.disagreement(deg).unwrap() {
                squares += (apart.value / apart.standard_error().unwrap()).powi(2);
                by_chance += (apart.value / apart.chance.unwrap().max(1e-12)).powi(2);
                count += 1.0;
            }
        }
        let root_mean = |sum: f64| (sum / count).sqrt();
        let z = root_mean(squares);
        let alone = root_mean(by_chance);
        // the root mean square over the hemisphere is that over these angles to a factor of two
        assert!((0.5..2.0).contains(&z) && alone > 5.0, "rms z {z}, by chance alone {alone}");
    }
}
