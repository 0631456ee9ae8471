//! The layer on its paper at one wavelength: the formulas of [`crate::appearance::paper`] applied
//! to fitted values.

mod functions;
mod totals;

pub use functions::{
    AZIMUTHAL, BENDS, DIFFUSE, SYMMETRIC, anchor_weights, azimuthal, diffuse_functions, symmetric,
};
pub use totals::{Anchors, LayerTotals};

use super::films::FilmAt;
use super::wavelengths::Weights;
use crate::appearance::paper::{MirroredSky, PaperError, returned};
use gauss_quad::GaussLegendre;
use std::borrow::Cow;
use std::f64::consts::PI;

/// Nodes of the integrals of fitted curves, which are polynomials of degree 5.
const CURVE_NODES: usize = 6;

/// Everything known at the wavelengths of interest.
#[derive(Clone, Debug)]
pub struct AngleNodes {
    /// Vacuum wavelengths, nm.
    pub wavelengths_nm: Vec<f64>,
    /// The coherent film at each wavelength.
    pub films: Vec<FilmAt>,
    /// The paper's albedo at each wavelength.
    pub albedos: Vec<f64>,
    /// Values of the spectral functions at each wavelength.
    pub weights: Vec<Weights>,
    /// The film's hemispherical means, in the order of [`super::layer::EnsembleMean`].
    pub means: Vec<[f64; 4]>,
}

/// Differences from the film, measured at every wavelength solved.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Measured {
    /// Totals at 0° and 45°.
    pub anchors: Anchors,
    /// Totals at 0° and 45° in the light returned by the paper, which is unpolarised; equal to
    /// `anchors` unless the incident light is polarised.
    pub returned: Anchors,
    /// T of the unscattered order at 0°.
    pub straight_on: f64,
    /// T̄.
    pub transmittance: f64,
    /// Ā from the exit side.
    pub absorptance: f64,
}

/// Step of differences that stand for derivatives: rounding and curvature both cost some 1e-7.
const SLOPE_STEP: f64 = 1e-6;
/// Numbers that are measured.
pub(super) const MEASURED: usize = 4 * TOTALS + 3;
const TOTALS: usize = 3;

impl Measured {
    /// All numbers, totals first.
    pub(super) fn numbers(&self) -> [f64; MEASURED] {
        let [[a, b], [c, d]] = [self.anchors, self.returned].map(|totals| totals.map(LayerTotals::numbers));
        let rest = [self.straight_on, self.transmittance, self.absorptance];
        let mut all = [a, b, c, d, rest].into_iter().flatten();
        std::array::from_fn(|_| all.next().unwrap_or_default())
    }

    /// 1 for one of the numbers, 0 for the others.
    pub(super) fn unit(k: usize) -> Self {
        let one: [f64; MEASURED] = std::array::from_fn(|place| f64::from(u8::from(place == k)));
        let [a, b, c, d] =
            [0, 1, 2, 3].map(|part| LayerTotals::from_fn(|column| one[TOTALS * part + column]));
        let [.., straight_on, transmittance, absorptance] = one;
        Self { anchors: [a, b], returned: [c, d], straight_on, transmittance, absorptance }
    }
}

/// Fitted curves over the angle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AngleCurve {
    /// Coefficients of the curves between the anchors.
    pub bends: LayerTotals<[f64; BENDS]>,
    /// Coefficients in the light returned by the paper.
    pub returned: LayerTotals<[f64; BENDS]>,
    /// Coefficients of the layer's diffuse BRDF, 1/sr.
    pub diffuse: [f64; DIFFUSE],
    /// Coefficients of its dependence on the azimuth, 1/sr.
    pub azimuthal: [f64; AZIMUTHAL],
    /// Projected solid angle of an order, averaged over the ensemble, sr; the specular order
    /// contains this much diffuse light.
    pub order_area: f64,
}

/// A viewing or illumination angle, with the film's R and T.
#[derive(Clone, Debug, PartialEq)]
pub struct PolarAngle {
    /// Angle from the normal, degrees.
    pub polar_deg: f64,
    mu: f64,
    between: [f64; 2],
    bends: [f64; BENDS],
    /// Totals of the film at every node.
    film: Vec<FilmTotals>,
}

/// The film's totals at one angle.
#[derive(Clone, Copy, Debug, PartialEq)]
struct FilmTotals {
    reflectance: f64,
    transmittance: f64,
    /// T in the light returned by the paper.
    returned: f64,
}

impl PolarAngle {
    /// The part of a curve with these coefficients.
    pub fn bent(&self, coefficients: &[f64; BENDS]) -> f64 {
        self.bends.iter().zip(coefficients).map(|(b, c)| b * c).sum()
    }

    /// Evaluates the films at an angle.
    ///
    /// # Errors
    /// The angle is outside 0° ≤ θ < 90°.
    pub fn new(polar_deg: f64, nodes: &AngleNodes) -> Result<Self, PaperError> {
        if !(0.0..90.0).contains(&polar_deg) {
            return Err(PaperError::AngleOutOfRange { value: polar_deg });
        }
        let mu = polar_deg.to_radians().cos();
        let (between, bends) = anchor_weights(mu);
        let film = nodes.films.iter().map(|film| film_totals(film, polar_deg)).collect();
        Ok(Self { polar_deg, mu, between, bends, film })
    }
}

fn film_totals(film: &FilmAt, polar_deg: f64) -> FilmTotals {
    let [reflectance, transmittance] = film.reflectance_transmittance(polar_deg);
    let returned = match film.returned() {
        Cow::Borrowed(_) => transmittance,
        Cow::Owned(back) => back.reflectance_transmittance(polar_deg)[1],
    };
    FilmTotals { reflectance, transmittance, returned }
}

/// The layer on paper at one wavelength.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LayerOnPaper {
    node: usize,
    measured: Measured,
    curve: AngleCurve,
    /// The film's T̄ and Ā from the exit side.
    film_means: [f64; 2],
    albedo: f64,
    index_out: f64,
}

impl LayerOnPaper {
    /// The layer over paper of \[albedo, index\].
    ///
    /// # Errors
    /// An albedo outside 0–1, a lossless mirror over a lossless paper, or numbers that are not
    /// finite.
    pub fn new(
        node: usize,
        film_means: [f64; 2],
        measured: Measured,
        curve: AngleCurve,
        [albedo, index_out]: [f64; 2],
    ) -> Result<Self, PaperError> {
        let layer = Self { node, measured, curve, film_means, albedo, index_out };
        returned(albedo, layer.mean_transmittance(), layer.mean_absorptance_exit(), index_out)?;
        Ok(layer)
    }

    /// T̄, the mean transmittance over the hemisphere on the incident side.
    pub fn mean_transmittance(&self) -> f64 {
        self.film_means[0] + self.measured.transmittance
    }

    /// Ā from the exit side, the mean absorptance over the hemisphere there.
    pub fn mean_absorptance_exit(&self) -> f64 {
        self.film_means[1] + self.measured.absorptance
    }

    /// R̄ from the exit side, 1 − T̄/n² − Ā.
    pub fn mean_reflectance_exit(&self) -> f64 {
        1.0 - self.mean_transmittance() / self.index_out.powi(2) - self.mean_absorptance_exit()
    }

    /// Index of its wavelength among the nodes; those of the spectra come first.
    pub(super) fn node(&self) -> usize {
        self.node
    }

    /// Unscattered share of T at the normal: T of that order without the diffuse light that every
    /// order carries (π times its share of the hemisphere, as if the diffuse light were isotropic).
    pub(super) fn straight_on(&self, normal: &PolarAngle) -> f64 {
        let straight = normal.film[self.node].transmittance + self.measured.straight_on;
        straight / self.transmittance(normal) - self.curve.order_area / PI
    }

    /// Index of the half-space on the exit side: that of the paper in optical contact.
    pub fn index_out(&self) -> f64 {
        self.index_out
    }

    /// g = ρ/(1 − ρ R̄_b), over n² in optical contact.
    pub fn return_factor(&self) -> f64 {
        let back =
            returned(self.albedo, self.mean_transmittance(), self.mean_absorptance_exit(), self.index_out);
        // checked in `new`; noise alone cannot make it a result
        back.unwrap_or(f64::NAN)
    }

    /// The layer over another backing of the given albedo.
    pub fn over(&self, albedo: f64) -> Self {
        Self { albedo, ..*self }
    }

    /// R(θ) of the layer without paper.
    pub fn reflectance(&self, at: &PolarAngle) -> f64 {
        at.film[self.node].reflectance + self.differences(at).reflectance
    }

    /// T(θ) of the layer without paper, limited to 0–1 because curves through few angles and
    /// wavelengths overshoot. R and the means are not limited: they enter sums, and a jackknife
    /// over limited values would underestimate errors.
    pub fn transmittance(&self, at: &PolarAngle) -> f64 {
        (at.film[self.node].transmittance + self.differences(at).transmittance).clamp(0.0, 1.0)
    }

    /// T(θ) of the layer without paper for the light returned by the paper, which is unpolarised;
    /// equal to T(θ) unless the incident light is polarised.
    pub fn transmittance_returned(&self, at: &PolarAngle) -> f64 {
        let beyond_film = curve(&self.measured.returned, &self.curve.returned, (at.between, at.bends));
        (at.film[self.node].returned + beyond_film.transmittance).clamp(0.0, 1.0)
    }

    /// Specular part of R(θ): that of the cells' specular order.
    pub fn specular(&self, at: &PolarAngle) -> f64 {
        at.film[self.node].reflectance + self.differences(at).specular
    }

    /// Mirror reflection of a print of any size. The specular order of a cell contains diffuse
    /// light like every order, f times its projected solid angle, which is subtracted.
    pub fn mirrored(&self, at: &PolarAngle) -> f64 {
        self.specular(at) - self.curve.order_area * self.directional_brdf(at.mu, at.mu, 1.0)
    }

    /// The layer's diffuse f(i, o), 1/sr, azimuthal mean. Symmetric in i and o unless the incident
    /// light is polarised.
    pub fn diffuse_brdf(&self, illumination: &PolarAngle, viewing: &PolarAngle) -> f64 {
        self.diffuse_brdf_at(illumination.mu, viewing.mu)
    }

    /// The layer's diffuse f(i, o) for cosines of the polar angles, 1/sr.
    pub fn diffuse_brdf_at(&self, illumination: f64, viewing: f64) -> f64 {
        let functions = diffuse_functions(illumination, viewing);
        functions.iter().zip(&self.curve.diffuse).map(|(f, c)| f * c).sum()
    }

    /// Dependence of [`LayerOnPaper::diffuse_brdf_at`] on the azimuth between the planes of
    /// illumination and viewing, with a mean of 0. `cosine` is that of the azimuth, 1 forward.
    pub fn azimuthal_brdf(&self, illumination: f64, viewing: f64, cosine: f64) -> f64 {
        let sines = ((1.0 - illumination * illumination) * (1.0 - viewing * viewing)).max(0.0).sqrt();
        let functions = azimuthal(illumination, viewing, sines * cosine);
        functions.iter().zip(&self.curve.azimuthal).map(|(f, c)| f * c).sum()
    }

    /// The layer's diffuse f(i, o) with its dependence on the azimuth, reduced where f would become
    /// negative: the azimuthal mean, and with it the albedo, is unchanged. `cosine` is that of the
    /// azimuth, 1 forward.
    pub fn directional_brdf(&self, illumination: f64, viewing: f64, cosine: f64) -> f64 {
        let mean = self.diffuse_brdf_at(illumination, viewing);
        let [forward, backward] = [1.0, -1.0].map(|c| self.azimuthal_brdf(illumination, viewing, c));
        // A cos Δφ + B cos 2Δφ is never below −|A| − |B|
        let swing = 0.5 * ((forward - backward).abs() + (forward + backward).abs());
        let share = if swing > mean.max(0.0) { mean.max(0.0) / swing } else { 1.0 };
        mean + share * self.azimuthal_brdf(illumination, viewing, cosine)
    }

    /// Diffuse f(i, o), 1/sr, azimuthal mean: the layer's part plus that of the paper. Symmetric in
    /// i and o unless the incident light is polarised; the observer sees both polarisations.
    pub fn brdf(&self, illumination: &PolarAngle, viewing: &PolarAngle) -> f64 {
        let through = self.transmittance(illumination) * self.transmittance_returned(viewing);
        self.diffuse_brdf(illumination, viewing) + self.return_factor() * through / PI
    }

    /// ∫ f cos θ_o dω of the layer's diffuse f, over angles with the weights of 2∫₀¹ f μ dμ. It
    /// equals R minus the mirror reflection as far as the fits of f and of R agree.
    pub fn own_albedo(&self, illumination: &PolarAngle, hemisphere: &[(PolarAngle, f64)]) -> f64 {
        let own = |(at, weight): &(PolarAngle, f64)| PI * weight * self.diffuse_brdf(illumination, at);
        hemisphere.iter().map(own).sum()
    }

    /// Smallest coefficients to add to T(θ) of the returned light so that its mean over these
    /// angles is T̄: T̄ is measured solve by solve, whereas the curve between the anchors is a fit.
    pub fn lacking_bends(&self, hemisphere: &[(PolarAngle, f64)]) -> [f64; BENDS] {
        let mut lack = self.mean_transmittance();
        let (mut means, mut squares) = ([0.0; BENDS], [[0.0; BENDS]; BENDS]);
        for (at, weight) in hemisphere {
            lack -= weight * self.transmittance_returned(at);
            for (b, own) in at.bends.iter().enumerate() {
                means[b] += weight * own;
                at.bends.iter().enumerate().for_each(|(c, other)| squares[b][c] += weight * own * other);
            }
        }
        // Cramer's rule: M x = m, then scaled to the missing mean
        let [[a, b], [_, d]] = squares;
        let x = [d * means[0] - b * means[1], a * means[1] - b * means[0]];
        let scale = lack / (x[0] * means[0] + x[1] * means[1]);
        x.map(|x| scale * x)
    }

    /// Directional–hemispherical albedo R(i) + g T(i) T̄, mirror reflection included.
    pub fn albedo(&self, illumination: &PolarAngle) -> f64 {
        let returned = self.return_factor() * self.transmittance(illumination) * self.mean_transmittance();
        self.reflectance(illumination) + returned
    }

    /// Radiance at `viewing` under a uniform sky of radiance 1 (white paper: 1), by reciprocity.
    /// For polarised light: as seen through a polariser under an unpolarised sky, relative to white
    /// paper seen through the same.
    pub fn natural_light(&self, viewing: &PolarAngle, sky: MirroredSky) -> f64 {
        let mirrored = match sky {
            MirroredSky::Included => 0.0,
            MirroredSky::Excluded => self.specular(viewing),
        };
        self.albedo(viewing) - mirrored
    }

    /// The layer with `step` times other measured values added.
    pub(super) fn moved(&self, by: &Measured, step: f64) -> Self {
        let mut layer = *self;
        let moved = |own: Anchors, by: &Anchors| [own[0].plus(step, &by[0]), own[1].plus(step, &by[1])];
        layer.measured.anchors = moved(self.measured.anchors, &by.anchors);
        layer.measured.returned = moved(self.measured.returned, &by.returned);
        layer.measured.straight_on += step * by.straight_on;
        layer.measured.transmittance += step * by.transmittance;
        layer.measured.absorptance += step * by.absorptance;
        layer
    }

    /// Derivatives of a quantity with respect to all measured numbers.
    pub(super) fn slopes(&self, quantity: impl Fn(&Self) -> f64) -> [f64; MEASURED] {
        let own = quantity(self);
        std::array::from_fn(|k| (quantity(&self.moved(&Measured::unit(k), SLOPE_STEP)) - own) / SLOPE_STEP)
    }

    /// Difference between the equally weighted mean over these angles and the mean of the fitted
    /// curves.
    pub(super) fn quadrature_error(
        &self,
        polar_deg: impl Iterator<Item = f64> + Clone,
        exit: bool,
    ) -> Measured {
        let back = |mu: f64| curve(&self.measured.returned, &self.curve.returned, anchor_weights(mu));
        let rule = GaussLegendre::new(CURVE_NODES).expect("a positive number of nodes");
        let count = polar_deg.clone().count().max(1) as f64;
        let error = |of: fn(LayerTotals) -> f64| {
            let sampled = polar_deg.clone().map(|deg| of(back(deg.to_radians().cos()))).sum::<f64>() / count;
            sampled - rule.integrate(0.0, 1.0, |mu| 2.0 * mu * of(back(mu)))
        };
        let (reflected, transmittance) = (error(|t| t.reflectance), error(|t| t.transmittance));
        // without solves from the exit side, A there equals that from the incident side, 1 − R − T
        let absorptance = if exit { 0.0 } else { -reflected - transmittance };
        Measured { transmittance, absorptance, ..Measured::default() }
    }

    #[inline]
    fn differences(&self, at: &PolarAngle) -> LayerTotals {
        curve(&self.measured.anchors, &self.curve.bends, (at.between, at.bends))
    }
}

/// Fitted differences from the film: weights of the anchors, and curve functions.
#[inline]
fn curve(
    anchors: &Anchors,
    coefficients: &LayerTotals<[f64; BENDS]>,
    (between, bends): ([f64; 2], [f64; BENDS]),
) -> LayerTotals {
    let at = |anchored: [f64; 2], own: &[f64; BENDS]| {
        let anchored: f64 = between.iter().zip(anchored).map(|(w, a)| w * a).sum();
        anchored + bends.iter().zip(own).map(|(b, c)| b * c).sum::<f64>()
    };
    LayerTotals {
        reflectance: at(anchors.map(|a| a.reflectance), &coefficients.reflectance),
        transmittance: at(anchors.map(|a| a.transmittance), &coefficients.transmittance),
        specular: at(anchors.map(|a| a.specular), &coefficients.specular),
    }
}

#[cfg(test)]
#[path = "on_paper_tests.rs"]
mod tests;
