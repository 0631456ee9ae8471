//! Kubelka–Munk coefficients of a layer, as used in ink mixing, from its diffuse reflectance and
//! transmittance.
//!
//! Two diffuse fluxes in a layer of thickness X obey (Kubelka 1948), with a = 1 + K/S and b = √(a²
//! − 1):
//!
//! ```text
//! R = 1/(a + b coth bSX)      T = b/(a sinh bSX + b cosh bSX)
//! over a backing ρ:  R + T² ρ/(1 − ρ R)
//! ```
//!
//! They assume a layer with the same reflectance from both sides. Reflection at its faces is not
//! scattering: [`DiffuseFaces`] removes it first (Saunderson 1942), for light that is diffuse
//! inside.

/// The two plane faces of a layer between air and air, for diffuse light.
///
/// One face reflects r of diffuse light from outside and r′ = 1 − (1 − r)/n² of diffuse light from
/// inside (the transmittances in both directions differ by n²). Illuminated from both sides by
/// equal fluxes the bare layer reflects ρ = R₀ + T₀, by opposite ones R₀ − T₀; its faces modify
/// each as J. L. Saunderson gives for one face (J. Opt. Soc. Am. 32, 727–736, 1942):
///
/// ```text
/// R ± T = r + (1 − r)(1 − r′) ρ/(1 − r′ ρ)      ρ = (R ± T − r)/((1 − r)(1 − r′) + r′ (R ± T − r))
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DiffuseFaces {
    /// Reflectance r of a face for diffuse light from outside, 0–1.
    pub external: f64,
    /// Reflectance r′ of a face for diffuse light from inside, 0–1.
    pub internal: f64,
}

impl DiffuseFaces {
    /// Plane faces of a layer of real index n with the reflectance `external` for diffuse light
    /// from outside.
    pub fn plane(external: f64, index: f64) -> Self {
        Self { external, internal: 1.0 - (1.0 - external) / (index * index) }
    }

    /// \[R, T\] of the layer without its faces. `None` if no layer in diffuse light has this R and
    /// T with such faces.
    pub fn taken_off(&self, reflectance: f64, transmittance: f64) -> Option<[f64; 2]> {
        let bare = |sum: f64| {
            let inside = sum - self.external;
            let divisor = (1.0 - self.external) * (1.0 - self.internal) + self.internal * inside;
            (divisor > 0.0).then(|| inside / divisor)
        };
        let same = bare(reflectance + transmittance)?;
        let opposite = bare(reflectance - transmittance)?;
        Some([0.5 * (same + opposite), 0.5 * (same - opposite)])
    }

    /// \[R, T\] of the layer with its faces, from those of the bare layer.
    pub fn put_on(&self, reflectance: f64, transmittance: f64) -> [f64; 2] {
        let through = (1.0 - self.external) * (1.0 - self.internal);
        let whole = |bare: f64| self.external + through * bare / (1.0 - self.internal * bare);
        let same = whole(reflectance + transmittance);
        let opposite = whole(reflectance - transmittance);
        [0.5 * (same + opposite), 0.5 * (same - opposite)]
    }
}

/// Absorption and scattering per unit thickness.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KubelkaMunk {
    /// K, 1/µm.
    pub absorption_per_um: f64,
    /// S, 1/µm.
    pub scattering_per_um: f64,
}

/// a² − 1 below this counts as no absorption: it is of the size of rounding.
const NO_ABSORPTION: f64 = 1e-12;

impl KubelkaMunk {
    /// Coefficients from the diffuse reflectance and transmittance of the layer alone. If noise
    /// makes R + T exceed 1, the absorption is 0. `None` unless 0 ≤ R < 1, 0 < T ≤ 1 and the
    /// thickness is positive.
    pub fn from_layer(reflectance: f64, transmittance: f64, thickness_um: f64) -> Option<Self> {
        Self::with(reflectance, transmittance, thickness_um, |a| a.max(1.0))
    }

    /// Analytic continuation of [`KubelkaMunk::from_layer`] to R + T above 1, where K is negative.
    /// It shows the full effect of noise on K and S, whereas `from_layer` clips K at 0.
    pub fn continued(reflectance: f64, transmittance: f64, thickness_um: f64) -> Option<Self> {
        Self::with(reflectance, transmittance, thickness_um, |a| a)
    }

    fn with(r: f64, t: f64, thickness_um: f64, limited: fn(f64) -> f64) -> Option<Self> {
        if !((0.0..1.0).contains(&r) && t > 0.0 && t <= 1.0 && thickness_um > 0.0) {
            return None;
        }
        if r == 0.0 {
            return Some(Self { absorption_per_um: -t.ln() / thickness_um, scattering_per_um: 0.0 });
        }
        let a = limited((1.0 + r * r - t * t) / (2.0 * r));
        let b2 = a * a - 1.0;
        let depth = match b2 {
            b2 if b2.abs() < NO_ABSORPTION => r / t,
            b2 if b2 > 0.0 => ((1.0 - r * (a - b2.sqrt())) / t).ln() / b2.sqrt(),
            // ln(1 − R a + i R β) over i β with b = i β; the modulus is T
            b2 => (r * (-b2).sqrt()).atan2(1.0 - r * a) / (-b2).sqrt(),
        };
        let scattering_per_um = depth / thickness_um;
        Some(Self { absorption_per_um: scattering_per_um * (a - 1.0), scattering_per_um })
    }

    /// Coefficients from the reflectances of one layer over two known backings, as measured on a
    /// draw-down card. `None` if no layer gives such a pair: R over the lighter backing must be
    /// larger, and both must lie inside 0–1.
    pub fn from_backings(darker: [f64; 2], lighter: [f64; 2], thickness_um: f64) -> Option<Self> {
        let [rho0, r0] = darker;
        let [rho1, r1] = lighter;
        // (r_i − R)(1 − ρ_i R) = T² ρ_i: dividing each by its ρ and subtracting leaves one equation
        // for R
        let square = |r: f64| {
            let t2 = |rho: f64, measured: f64| (measured - r) * (1.0 - rho * r) / rho;
            if rho0 > 0.0 { t2(rho0, r0) - t2(rho1, r1) } else { r - r0 }
        };
        let r = if rho0 > 0.0 { root(square, 0.0, r0.min(r1))? } else { r0 };
        let t2 = (r1 - r) * (1.0 - rho1 * r) / rho1;
        if t2 > 0.0 { Self::from_layer(r, t2.sqrt(), thickness_um) } else { None }
    }

    /// \[R, T\] of a layer of the given thickness, µm.
    pub fn layer(&self, thickness_um: f64) -> [f64; 2] {
        let k = self.absorption_per_um * thickness_um;
        let s = self.scattering_per_um * thickness_um;
        if s == 0.0 {
            return [0.0, (-k).exp()];
        }
        let a = 1.0 + k / s;
        let b = (a * a - 1.0).sqrt();
        if b * b < NO_ABSORPTION {
            return [s / (1.0 + s), 1.0 / (1.0 + s)];
        }
        // divided by e^{bS} so that thick layers do not overflow
        let sinh = (1.0 - (-2.0 * b * s).exp()) / 2.0;
        let cosh = (1.0 + (-2.0 * b * s).exp()) / 2.0;
        let denominator = a * sinh + b * cosh;
        [sinh / denominator, b * (-b * s).exp() / denominator]
    }

    /// Reflectance over a backing of albedo ρ.
    pub fn over(&self, backing: f64, thickness_um: f64) -> f64 {
        let [r, t] = self.layer(thickness_um);
        r + t * t * backing / (1.0 - backing * r)
    }

    /// R∞ = a − b, the reflectance of an opaque layer; 1 without absorption.
    pub fn infinite(&self) -> f64 {
        if self.scattering_per_um == 0.0 {
            return 0.0;
        }
        let a = 1.0 + self.absorption_per_um / self.scattering_per_um;
        a - (a * a - 1.0).sqrt()
    }
}

/// If the value at the start is this much smaller than at the end, it is zero within rounding.
const ROUNDING: f64 = 1e-13;

/// Root of a function that changes sign in an interval, to rounding; the start if it already is a
/// root.
fn root(f: impl Fn(f64) -> f64, mut lo: f64, mut hi: f64) -> Option<f64> {
    if f(lo).abs() <= ROUNDING * f(hi).abs() {
        return Some(lo);
    }
    if f(lo).is_nan() || f(hi).is_nan() || f(lo) * f(hi) > 0.0 {
        return None;
    }
    for _ in 0..200 {
        let middle = (lo + hi) / 2.0;
        if f(lo) * f(middle) <= 0.0 { hi = middle } else { lo = middle }
    }
    Some((lo + hi) / 2.0)
}

#[cfg(test)]
#[path = "kubelka_munk_faces_tests.rs"]
mod faces_tests;

#[cfg(test)]
mod tests {
    use super::*;

    const CASES: [[f64; 2]; 5] = [[0.5, 0.0], [0.0, 0.5], [0.3, 0.8], [1e-3, 2.0], [4.0, 3.0]];

    #[test]
    fn coefficients_come_back_from_the_layer_they_make() {
        for [absorption_per_um, scattering_per_um] in CASES {
            let ink = KubelkaMunk { absorption_per_um, scattering_per_um };
            let [r, t] = ink.layer(0.8);
            let back = KubelkaMunk::from_layer(r, t, 0.8).unwrap();
            assert!((back.absorption_per_um - absorption_per_um).abs() < 1e-8, "{ink:?} {back:?}");
            assert!((back.scattering_per_um - scattering_per_um).abs() < 1e-8, "{ink:?} {back:?}");
            assert!(r + t <= 1.0 + 1e-15);
        }
    }

    /// Two layers of half the thickness, coupled by multiple reflections, are equivalent to one
    /// layer.
    #[test]
    fn half_layers_add_up() {
        for [absorption_per_um, scattering_per_um] in CASES {
            let ink = KubelkaMunk { absorption_per_um, scattering_per_um };
            let [r, t] = ink.layer(1.0);
            let [half_r, half_t] = ink.layer(0.5);
            let back = 1.0 - half_r * half_r;
            assert!((half_r + half_t * half_t * half_r / back - r).abs() < 1e-13);
            assert!((half_t * half_t / back - t).abs() < 1e-13);
        }
    }

    /// Across R + T = 1 the continuation has neither step nor kink.
    #[test]
    fn noise_around_no_absorption_is_continued() {
        let continued = |t: f64| KubelkaMunk::continued(0.3, t, 1.0).unwrap();
        for get in [|k: KubelkaMunk| k.absorption_per_um, |k: KubelkaMunk| k.scattering_per_um] {
            let below = get(continued(0.699));
            let none = get(continued(0.7));
            let above = get(continued(0.701));
            // order: second differences of a step of 1e-3; K and S have derivatives of order one
            assert!((below - 2.0 * none + above).abs() < 2e-5 && (below - above).abs() > 1e-4);
        }
        assert!(continued(0.701).absorption_per_um < 0.0);
        assert_eq!(continued(0.6), KubelkaMunk::from_layer(0.3, 0.6, 1.0).unwrap());
    }

    #[test]
    fn a_third_backing_follows_from_two() {
        for ink in CASES.map(|[k, s]| KubelkaMunk { absorption_per_um: k, scattering_per_um: s }) {
            for (dark, light) in [(0.0, 0.8), (0.05, 0.9)] {
                let pair = [dark, light].map(|rho| [rho, ink.over(rho, 1.0)]);
                let back = KubelkaMunk::from_backings(pair[0], pair[1], 1.0).unwrap();
                assert!((back.over(0.4, 1.0) - ink.over(0.4, 1.0)).abs() < 1e-9, "{ink:?} {back:?}");
            }
        }
    }

    #[test]
    fn a_thick_layer_hides_everything_and_impossible_layers_are_refused() {
        let ink = KubelkaMunk { absorption_per_um: 0.5, scattering_per_um: 3.0 };
        assert!((ink.over(0.9, 500.0) - ink.infinite()).abs() < 1e-12);
        assert_eq!(KubelkaMunk::from_layer(0.4, 0.0, 1.0), None);
        assert_eq!(KubelkaMunk::from_layer(f64::NAN, 0.5, 1.0), None);
        assert_eq!(KubelkaMunk::from_backings([0.0, 0.5], [0.8, 0.4], 1.0), None);
        // noise: R + T slightly above 1 is a layer without absorption
        assert_eq!(KubelkaMunk::from_layer(0.4, 0.6001, 1.0).unwrap().absorption_per_um, 0.0);
    }
}
