//! Colour of a spectrum: XYZ, CIE Lab, sRGB, and colour differences with their uncertainty.

pub use super::lab::ciede2000;
use super::lab::lab_from_xyz;
use super::tristimulus::Colorimeter;
use super::viewing::ColourError;
use crate::numerics::estimate::{Estimate, jackknife_covariance};

/// Tolerance of the gamut test: rounding of the division by white.
const GAMUT_SLACK: f64 = 1e-9;

/// A colour under D65 for the CIE 1931 2° observer.
///
/// `lab` is relative to the perfect white on the same grid. `linear_rgb` is divided per channel by
/// the value of white and not clipped; `srgb` and `srgb8` are clipped to 0–1 before the transfer
/// curve (IEC 61966-2-1), and `out_of_gamut` states whether clipping changed the colour.
/// `lab_covariance` is `None` for a single realisation.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Colour {
    /// X, Y, Z; a perfect white has Y = 100.
    pub xyz: [f64; 3],
    /// X, Y, Z of the perfect white on the same wavelengths.
    pub white_xyz: [f64; 3],
    /// CIE 1976 L*, a*, b*.
    pub lab: [f64; 3],
    /// Linear red, green, blue; 1 for white.
    pub linear_rgb: [f64; 3],
    /// Gamma-encoded sRGB after clipping, 0 to 1.
    pub srgb: [f64; 3],
    /// Gamma-encoded sRGB in steps of 1/255.
    pub srgb8: [u8; 3],
    /// Whether clipping changed the colour.
    pub out_of_gamut: bool,
    /// Covariance of L*, a*, b*.
    pub lab_covariance: Option<[[f64; 3]; 3]>,
}

impl Colorimeter {
    /// Colour of a spectrum of reflectance factors (perfect white = 1), uncertainty unknown.
    ///
    /// ```
    /// use inkwave_physics::appearance::tristimulus::Colorimeter;
    /// let wavelengths_nm: Vec<f64> = (0..31).map(|i| 400.0 + 10.0 * i as f64).collect();
    /// let white = Colorimeter::new(&wavelengths_nm)?.colour(&[1.0; 31])?;
    /// assert_eq!(white.srgb8, [255, 255, 255]);
    /// # Ok::<(), inkwave_physics::appearance::viewing::ColourError>(())
    /// ```
    ///
    /// # Errors
    /// Wrong length, or a value that is not finite.
    pub fn colour(&self, values: &[f64]) -> Result<Colour, ColourError> {
        Ok(self.colour_of(self.xyz(values)?))
    }

    /// Colour of tristimulus values scaled so that white has Y = 100 on this grid, uncertainty
    /// unknown.
    pub fn colour_of(&self, xyz: [f64; 3]) -> Colour {
        let white_xyz = self.white_xyz;
        let linear_rgb = self.linear_rgb(xyz);
        let srgb = linear_rgb.map(|c| srgb_curve(c.clamp(0.0, 1.0)));
        let lab = lab_from_xyz(xyz, white_xyz);
        let srgb8 = srgb.map(|c| (255.0 * c).round() as u8);
        let out_of_gamut = linear_rgb.iter().any(|c| !(-GAMUT_SLACK..=1.0 + GAMUT_SLACK).contains(c));
        Colour { xyz, white_xyz, lab, linear_rgb, srgb, srgb8, out_of_gamut, lab_covariance: None }
    }

    /// Colour of the ensemble's spectrum with the jackknife covariance of Lab. `replicates` are the
    /// n spectra that leave out one realisation each; with fewer than two, the covariance is
    /// unknown.
    ///
    /// # Errors
    /// See [`Colorimeter::colour`].
    pub fn colour_with_error(&self, values: &[f64], replicates: &[Vec<f64>]) -> Result<Colour, ColourError> {
        let labs = replicates.iter().map(|r| Ok(self.colour(r)?.lab)).collect::<Result<Vec<_>, _>>()?;
        Ok(Colour { lab_covariance: jackknife_covariance(&labs), ..self.colour(values)? })
    }
}

impl Colour {
    /// Chroma C* = √(a*² + b*²), standard error to first order.
    pub fn chroma(&self) -> Estimate {
        let [_, a, b] = self.lab;
        let standard_error = self.lab_covariance.map(|c| quadratic_form(&c, self.chroma_gradient()).sqrt());
        Estimate { value: a.hypot(b), standard_error }
    }

    /// Hue angle, degrees in 0–360, standard error to first order. A neutral colour has no hue: the
    /// result is 0 with an unknown error.
    pub fn hue_deg(&self) -> Estimate {
        let [_, a, b] = self.lab;
        if a * a + b * b < NEUTRAL {
            return Estimate::unknown_error(0.0);
        }
        let standard_error = self.lab_covariance.map(|c| quadratic_form(&c, self.hue_gradient()).sqrt());
        Estimate { value: b.atan2(a).to_degrees().rem_euclid(360.0), standard_error }
    }

    /// Derivatives of the hue angle with respect to L*, a*, b*, degrees; zero for a neutral colour.
    pub fn hue_gradient(&self) -> [f64; 3] {
        let [_, a, b] = self.lab;
        let square = a * a + b * b;
        if square < NEUTRAL { [0.0; 3] } else { [0.0, -b / square, a / square].map(f64::to_degrees) }
    }

    /// Derivatives of C* with respect to L*, a*, b*.
    pub fn chroma_gradient(&self) -> [f64; 3] {
        gradient(|[_, a, b]| a.hypot(b), self.lab)
    }

    /// Standard errors of L*, a*, b*.
    pub fn lab_standard_error(&self) -> Option<[f64; 3]> {
        self.lab_covariance.map(|c| std::array::from_fn(|i| c[i][i].max(0.0).sqrt()))
    }

    /// ΔE₀₀ (CIEDE2000, k_L = k_C = k_H = 1) to an independent colour.
    ///
    /// The error is of first order: √(gᵀ(C₁ + C₂)g), with g the gradient along the line between the
    /// two colours. Where ΔE is not well above its error, noise alone raises ΔE: compare with
    /// [`Colour::delta_e_noise`].
    pub fn delta_e_2000(&self, other: &Self) -> Estimate {
        self.delta_e_2000_among(other, &INDEPENDENT)
    }

    /// ΔE₀₀ between correlated colours, such as those of the same realisations: `common[i][j]` is
    /// the covariance of Lab component i of `self` and j of `other`.
    pub fn delta_e_2000_among(&self, other: &Self, common: &[[f64; 3]; 3]) -> Estimate {
        let [here, there] = self.delta_e_2000_gradients(other);
        let shared: f64 = (0..9).map(|k| here[k / 3] * common[k / 3][k % 3] * there[k % 3]).sum();
        let variance = |a, b| quadratic_form(&a, here) + quadratic_form(&b, there) + 2.0 * shared;
        let covariances = self.lab_covariance.zip(other.lab_covariance);
        let first_order = covariances.map(|(a, b)| variance(a, b).max(0.0).sqrt());
        // equal colours define no direction: the noise over all directions bounds the error
        let equal = distance(self.lab, other.lab) < 2.0 * STEP;
        let in_common = 2.0 * (common[0][0] + common[1][1] + common[2][2]);
        let noise = || Some((self.delta_e_noise(other)?.powi(2) - in_common).max(0.0).sqrt());
        let standard_error = if equal { noise() } else { first_order };
        Estimate { value: ciede2000(self.lab, other.lab), standard_error }
    }

    /// Root mean square of ΔE*ab expected from the two uncertainties alone: √tr(C₁ + C₂).
    pub fn delta_e_noise(&self, other: &Self) -> Option<f64> {
        let trace = |c: [[f64; 3]; 3]| c[0][0] + c[1][1] + c[2][2];
        Some((trace(self.lab_covariance?) + trace(other.lab_covariance?)).sqrt())
    }

    /// Root mean square of ΔE₀₀ expected from the uncertainty of this colour alone: √tr(M C), with
    /// M the local metric of ΔE₀₀.
    pub fn delta_e_2000_noise(&self) -> Option<f64> {
        let covariance = self.lab_covariance?;
        let trace: f64 = (0..9).map(|k| metric(self.lab, k / 3, k % 3) * covariance[k / 3][k % 3]).sum();
        Some(trace.max(0.0).sqrt())
    }

    /// Derivatives of ΔE₀₀ with respect to Lab of `self` and of `other`.
    pub fn delta_e_2000_gradients(&self, other: &Self) -> [[f64; 3]; 2] {
        let here = self.lab;
        let there = other.lab;
        [gradient(|lab| ciede2000(lab, there), here), gradient(|lab| ciede2000(here, lab), there)]
    }
}

/// C*² below which a colour counts as neutral.
const NEUTRAL: f64 = 1e-18;

/// Covariance of statistically independent colours.
const INDEPENDENT: [[f64; 3]; 3] = [[0.0; 3]; 3];

/// IEC 61966-2-1 transfer curve for 0 ≤ c ≤ 1.
pub fn srgb_curve(c: f64) -> f64 {
    if c <= 0.0031308 { 12.92 * c } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 }
}

fn distance(p: [f64; 3], q: [f64; 3]) -> f64 {
    p.iter().zip(q).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}

fn quadratic_form(c: &[[f64; 3]; 3], g: [f64; 3]) -> f64 {
    let row = |i: usize| (0..3).map(|j| c[i][j] * g[j]).sum::<f64>();
    (0..3).map(|i| g[i] * row(i)).sum::<f64>().max(0.0)
}

/// Step of the finite differences in the metric of ΔE₀₀, Lab units.
const METRIC_STEP: f64 = 1e-2;

/// Component (i, j) of the local metric of ΔE₀₀ at `lab`, by polarisation of the quadratic form.
fn metric(lab: [f64; 3], i: usize, j: usize) -> f64 {
    let unit = |i: usize| std::array::from_fn::<f64, 3, _>(|k| if k == i { 1.0 } else { 0.0 });
    if i == j {
        return quadratic_metric(lab, unit(i));
    }
    let pair = std::array::from_fn(|k| unit(i)[k] + unit(j)[k]);
    (quadratic_metric(lab, pair) - quadratic_metric(lab, unit(i)) - quadratic_metric(lab, unit(j))) / 2.0
}

/// Quadratic form of the metric at `lab`: (ΔE₀₀/h)² of a displacement h·`by`.
fn quadratic_metric(lab: [f64; 3], by: [f64; 3]) -> f64 {
    let moved: [f64; 3] = std::array::from_fn(|i| lab[i] + METRIC_STEP * by[i]);
    (ciede2000(lab, moved) / METRIC_STEP).powi(2)
}

/// Step of the numerical gradients, Lab units.
const STEP: f64 = 1e-3;

/// Gradient by central differences.
fn gradient(f: impl Fn([f64; 3]) -> f64, at: [f64; 3]) -> [f64; 3] {
    let shifted = |i: usize, by: f64| {
        let mut p = at;
        p[i] += by;
        f(p)
    };
    std::array::from_fn(|i| (shifted(i, STEP) - shifted(i, -STEP)) / (2.0 * STEP))
}

#[cfg(test)]
#[path = "colour_tests.rs"]
mod tests;
