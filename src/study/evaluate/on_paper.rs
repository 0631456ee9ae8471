//! The layer on its paper at one wavelength: the formulas of [`crate::appearance::paper`] applied
//! to fitted values.
//!
//! These are differences from the coherent film: [`Measured`] totals and means, and
//! [`AngleCurve`]s between the angles of these totals, for directions of light and view
//! ([`PolarAngle`]).

mod angle;
pub(super) mod curves;
mod measured;

pub use angle::{AngleNodes, PolarAngle};
pub use curves::{
    AZIMUTHAL, AngleCurve, BENDS, DIFFUSE, SYMMETRIC, anchor_weights, azimuthal, diffuse_functions, symmetric,
};
pub(super) use measured::MEASURED;
pub use measured::{Anchors, CURVES, Measured};

use super::samples::{SolvedDirection, mean};
use crate::appearance::paper::{MirroredSky, PaperError, emerging, returned};
use crate::appearance::paper_series::AreaOptics;
use curves::{curve, weighted};
use gauss_quad::GaussLegendre;
use measured::{REFLECTANCE, SPECULAR, TRANSMITTANCE};
use std::f64::consts::PI;

/// Nodes of the integrals of fitted curves, which are polynomials of degree 5.
const CURVE_NODES: usize = 6;
/// Step of differences that stand for derivatives: rounding and curvature both cost some 1e-7.
const SLOPE_STEP: f64 = 1e-6;

/// Light that a brightened paper emits below the layer, over the light that comes in at this
/// wavelength: its value, and what errors of R and of T change of it.
pub type EmittedShare = [f64; 3];

/// What a brightened paper emits; nothing of other paper.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Emitted {
    /// Under a uniform sky.
    pub natural: EmittedShare,
    /// Lit at 45°, and taken for all other directions of light.
    pub lit_at_45: EmittedShare,
    /// Power of the lamp that both are over, where it has lines and excites the paper.
    pub lamp_power: Option<f64>,
}

/// The layer on paper at one wavelength.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LayerOnPaper {
    /// Index of its wavelength among the nodes; those of the spectra come first.
    pub(super) node: usize,
    measured: Measured,
    curve: AngleCurve,
    /// The film's T̄ and Ā from the exit side.
    film_means: [f64; 2],
    pub(super) paper_albedo: f64,
    /// Index of the half-space on the exit side: that of the paper in optical contact.
    pub(super) index_out: f64,
    /// What the paper emits besides.
    pub(super) emitted: Emitted,
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
        let emitted = Emitted::default();
        let layer = Self { node, measured, curve, film_means, paper_albedo: albedo, index_out, emitted };
        returned(albedo, layer.mean_transmittance(), layer.mean_absorptance_exit(), index_out)?;
        Ok(layer)
    }

    /// This layer as another of the nodes.
    pub(super) fn at_node(&self, node: usize) -> Self {
        Self { node, ..*self }
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

    /// Unscattered share of T at the normal: T of that order without the diffuse light that every
    /// order carries (π times its share of the hemisphere, as if the diffuse light were isotropic).
    pub(super) fn straight_on(&self, normal: &PolarAngle) -> f64 {
        let straight = normal.film[self.node][TRANSMITTANCE] + self.measured.straight_on;
        straight / self.transmittance(normal) - self.curve.order_area / PI
    }

    /// g = ρ/(1 − ρ R̄_b), over n² in optical contact.
    pub fn return_factor(&self) -> f64 {
        // checked in `new`; noise alone cannot make it a result
        returned(self.paper_albedo, self.mean_transmittance(), self.mean_absorptance_exit(), self.index_out)
            .unwrap_or(f64::NAN)
    }

    /// 1/(1 − ρ R̄_b), over n² in optical contact: the series of light that the paper emits.
    pub(super) fn emerging_factor(&self) -> f64 {
        emerging(self.paper_albedo, self.mean_transmittance(), self.mean_absorptance_exit(), self.index_out)
            .unwrap_or(f64::NAN)
    }

    /// The layer over another backing of the given albedo, which does not fluoresce.
    pub fn over(&self, albedo: f64) -> Self {
        Self { paper_albedo: albedo, emitted: Emitted::default(), ..*self }
    }

    /// The layer on the same paper without what that emits.
    pub(super) fn dark(&self) -> Self {
        Self { emitted: Emitted::default(), ..*self }
    }

    /// The layer as light from this angle and light between it and the paper meet it, seen at
    /// another.
    pub(super) fn optics(&self, illumination: &PolarAngle, viewing: &PolarAngle) -> AreaOptics {
        let density = self.index_out * self.index_out;
        AreaOptics {
            own: PI * self.diffuse_brdf_at(illumination.mu, viewing.mu),
            entering: self.transmittance(illumination),
            leaving: self.transmittance_returned(viewing) / density,
            lost: self.mean_transmittance() / density + self.mean_absorptance_exit(),
        }
    }

    /// R(θ) of the layer without paper.
    pub fn reflectance(&self, angle: &PolarAngle) -> f64 {
        self.total(angle, REFLECTANCE)
    }

    /// T(θ) of the layer without paper, limited to 0–1 because curves through few angles and
    /// wavelengths overshoot. R and the means are not limited: they enter sums, and a jackknife
    /// over limited values would underestimate errors.
    pub fn transmittance(&self, angle: &PolarAngle) -> f64 {
        self.total(angle, TRANSMITTANCE).clamp(0.0, 1.0)
    }

    /// T(θ) of the layer without paper for the light returned by the paper, which is unpolarised;
    /// equal to T(θ) unless the incident light is polarised.
    pub fn transmittance_returned(&self, angle: &PolarAngle) -> f64 {
        (angle.film_returned[self.node] + self.returned(angle.between, angle.bends, TRANSMITTANCE))
            .clamp(0.0, 1.0)
    }

    /// Specular part of R(θ): that of the cells' specular order.
    pub fn specular(&self, angle: &PolarAngle) -> f64 {
        self.total(angle, SPECULAR)
    }

    /// Mirror reflection of a print of any size. The specular order of a cell contains diffuse
    /// light like every order, f times its projected solid angle, which is subtracted.
    pub fn mirrored(&self, angle: &PolarAngle) -> f64 {
        self.specular(angle) - self.curve.order_area * self.directional_brdf(angle.mu, angle.mu, 1.0)
    }

    /// The layer's diffuse f(i, o) for cosines of the polar angles, 1/sr, azimuthal mean. Symmetric
    /// in i and o unless the incident light is polarised.
    pub fn diffuse_brdf_at(&self, illumination: f64, viewing: f64) -> f64 {
        weighted(&diffuse_functions(illumination, viewing), &self.curve.diffuse)
    }

    /// Dependence of [`LayerOnPaper::diffuse_brdf_at`] on the azimuth between the planes of
    /// illumination and viewing, with a mean of 0. `cosine` is that of the azimuth, 1 forward.
    pub fn azimuthal_brdf(&self, illumination: f64, viewing: f64, cosine: f64) -> f64 {
        let sines = ((1.0 - illumination * illumination) * (1.0 - viewing * viewing)).max(0.0).sqrt();
        weighted(&azimuthal(illumination, viewing, sines * cosine), &self.curve.azimuthal)
    }

    /// The layer's diffuse f(i, o) with its dependence on the azimuth, reduced where f would become
    /// negative: the azimuthal mean, and with it the albedo, is unchanged. `cosine` is that of the
    /// azimuth, 1 forward.
    pub fn directional_brdf(&self, illumination: f64, viewing: f64, cosine: f64) -> f64 {
        let mean = self.diffuse_brdf_at(illumination, viewing);
        let forward = self.azimuthal_brdf(illumination, viewing, 1.0);
        let backward = self.azimuthal_brdf(illumination, viewing, -1.0);
        // A cos Δφ + B cos 2Δφ is never below −|A| − |B|
        let swing = 0.5 * ((forward - backward).abs() + (forward + backward).abs());
        let share = if swing > mean.max(0.0) { mean.max(0.0) / swing } else { 1.0 };
        mean + share * self.azimuthal_brdf(illumination, viewing, cosine)
    }

    /// Diffuse f(i, o), 1/sr, azimuthal mean: the layer's part plus that of the paper. Symmetric in
    /// i and o unless the incident light is polarised; the observer sees both polarisations.
    pub fn brdf(&self, illumination: &PolarAngle, viewing: &PolarAngle) -> f64 {
        let through = self.transmittance(illumination) * self.transmittance_returned(viewing);
        let reflected =
            self.diffuse_brdf_at(illumination.mu, viewing.mu) + self.return_factor() * through / PI;
        let [emitted, ..] = self.emitted.lit_at_45;
        if emitted == 0.0 {
            return reflected;
        }
        reflected + emitted * self.emerging_factor() * self.transmittance_returned(viewing) / PI
    }

    /// ∫ f cos θ_o dω of the layer's diffuse f, over angles with the weights of 2∫₀¹ f μ dμ. It
    /// equals R minus the mirror reflection as far as the fits of f and of R agree.
    pub fn own_albedo(&self, light: &PolarAngle, hemisphere: &[(PolarAngle, f64)]) -> f64 {
        hemisphere.iter().map(|(angle, weight)| PI * weight * self.diffuse_brdf_at(light.mu, angle.mu)).sum()
    }

    /// Smallest coefficients to add to T(θ) of the returned light so that its mean over these
    /// angles is T̄: T̄ is measured solve by solve, whereas the curve between the anchors is a fit.
    pub fn lacking_bends(&self, hemisphere: &[(PolarAngle, f64)]) -> [f64; BENDS] {
        let mut lack = self.mean_transmittance();
        let mut means = [0.0; BENDS];
        let mut squares = [[0.0; BENDS]; BENDS];
        for (angle, weight) in hemisphere {
            lack -= weight * self.transmittance_returned(angle);
            for (b, bend) in angle.bends.iter().enumerate() {
                means[b] += weight * bend;
                angle.bends.iter().enumerate().for_each(|(c, other)| squares[b][c] += weight * bend * other);
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
        let mirrored = if sky == MirroredSky::Excluded { self.mirrored(viewing) } else { 0.0 };
        let reflected = self.albedo(viewing) - mirrored;
        let [emitted, ..] = self.emitted.natural;
        if emitted == 0.0 {
            return reflected;
        }
        reflected + emitted * self.emerging_factor() * self.transmittance(viewing)
    }

    /// The layer with `step` times other measured values added.
    pub(super) fn moved(&self, by: &Measured, step: f64) -> Self {
        Self { measured: self.measured.moved(by, step), ..*self }
    }

    /// Derivatives of a quantity with respect to all measured numbers.
    pub(super) fn slopes(&self, quantity: impl Fn(&Self) -> f64) -> [f64; MEASURED] {
        let here = quantity(self);
        std::array::from_fn(|k| {
            let mut layer = *self;
            layer.measured.all().skip(k).take(1).for_each(|number| *number += SLOPE_STEP);
            (quantity(&layer) - here) / SLOPE_STEP
        })
    }

    /// Difference between the equally weighted mean over these angles and the mean of the fitted
    /// curves.
    pub(super) fn quadrature_error(&self, solves: &[SolvedDirection], exit: bool) -> Measured {
        let rule = GaussLegendre::new(CURVE_NODES).expect("a positive number of nodes");
        let error = |total: usize| {
            let back = |mu: f64| {
                let (between, bends) = anchor_weights(mu);
                self.returned(between, bends, total)
            };
            let sampled = mean(solves, |s| back(s.polar_deg.to_radians().cos()));
            sampled - rule.integrate(0.0, 1.0, |mu| 2.0 * mu * back(mu))
        };
        let reflected = error(REFLECTANCE);
        let transmittance = error(TRANSMITTANCE);
        // without solves from the exit side, A there equals that from the incident side, 1 − R − T
        let absorptance = if exit { 0.0 } else { -reflected - transmittance };
        Measured { transmittance, absorptance, ..Measured::default() }
    }

    /// Coefficients of the curves of R and of T in the light returned by the paper: of the values
    /// at both anchors, then of the other functions ([`anchor_weights`]).
    pub(super) fn returned_coefficients(&self) -> [[f64; 2 + BENDS]; 2] {
        let Self { measured: Measured { returned: anchors, .. }, curve, .. } = self;
        [REFLECTANCE, TRANSMITTANCE].map(|total| {
            let of = |k: usize| if k < 2 { anchors[k][total] } else { curve.returned[total][k - 2] };
            std::array::from_fn(of)
        })
    }

    /// A total of the layer without paper.
    #[inline]
    fn total(&self, angle: &PolarAngle, total: usize) -> f64 {
        let bends = &self.curve.bends[total];
        angle.film[self.node][total] + curve(&self.measured.anchors, bends, angle.between, angle.bends, total)
    }

    /// Fitted difference of a total from the film in the light returned by the paper.
    #[inline]
    fn returned(&self, between: [f64; 2], bends: [f64; BENDS], total: usize) -> f64 {
        curve(&self.measured.returned, &self.curve.returned[total], between, bends, total)
    }
}

#[cfg(test)]
#[path = "on_paper_tests.rs"]
mod tests;
