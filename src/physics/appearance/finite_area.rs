//! A finite illuminated square of the infinite layer: every order becomes a lobe of finite width
//! (P2 section 4.1).
//!
//! Only the square |x|, |y| ≤ l/2 of the periodic layer emits, everything outside is dark, and
//! Kirchhoff's formula carries the field on the face to the far hemisphere (P2 (4.1)–(4.8)). For
//! propagating orders with amplitudes α and lateral wavevectors (kx, ky), in the direction (ϑ, φ)
//! of a medium of index n, k = n k0:
//!
//! ```text
//! s(ϑ, φ) = Σ α sinc(l (kx − k sin ϑ cos φ)/2) sinc(l (ky − k sin ϑ sin φ)/2)
//! sinc t = sin t / t
//! G(ϑ, φ) = l²/(4π²) · k³ cos²ϑ / κ₀ · |s|²                                      (4.9)
//! ```
//!
//! P2 prints the flux k0|u|²; here it is divided by the flux κ₀ of an incident wave of amplitude 1
//! (κ₀ = k cos σ on its side), so that G is a fraction of the light incident on the square, per
//! steradian. With cos ϑ dω = dkx dky/k²,
//!
//! ```text
//! ∫ G dω = l²/(4π²) ∫ √(k² − kx² − ky²)/κ₀ · |s|² dkx dky,                       kx² + ky² < k²
//! ```
//!
//! which tends to R or T of the infinite layer (P2 section 4.2). For a side of whole periods the
//! deficit is the light at the edges, to first order in 1/l the mean of |Σ α exp(i(kx x + ky y))|²
//! over each of them:
//!
//! ```text
//! ∫ G dω → Σ κ/κ₀ |α|² − 1/(κ₀ l) · [⟨|u|²⟩ at x = l/2 + ⟨|u|²⟩ at y = l/2]
//! one order: … − 2 |α|²/(κ₀ l)
//! ```
//!
//! One correction to P2: (4.9) omits α₀₀ because the field on the lit face contains the incident
//! wave. The incident wave contributes 1, not α₀₀; [`crate::wave::Order::reflected`] is already α₀₀
//! − 1, and the remaining specular lobe is real. It is kept here, and
//! [`FiniteArea::without_specular`] omits it. Evanescent orders are omitted, as in P2.

use super::bdf::Lobe;
use crate::wave::{FarField, Media, Order, Side};
use num_complex::Complex64;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};
use thiserror::Error;

/// Longest side of the square in wavelengths; the cost of the hemispherical integral grows with its
/// square.
const MOST_WAVELENGTHS: f64 = 1000.0;
/// Minimum number of samples of the hemispherical integral along a radius of the disk.
const SAMPLES: f64 = 400.0;
/// Samples per lobe width 2π/l: |s|² has no structure finer than half of it.
const SAMPLES_A_LOBE: f64 = 4.0;

/// Why a finite area has no distribution.
#[derive(Debug, Error, Clone, PartialEq)]
pub enum FiniteAreaError {
    /// A side shorter than a period, or too many wavelengths long.
    #[error(
        "illuminated_um, the side of the lit square, is {value}; allowed is {least} … {most} µm (one period to a thousand \
         wavelengths): try ten periods, {} µm",
        10.0 * .least
    )]
    Side {
        /// The side found, µm.
        value: f64,
        /// The longer period, µm.
        least: f64,
        /// A thousand wavelengths, µm.
        most: f64,
    },
    /// A half-space in which light does not propagate to infinity.
    #[error(
        "the index of the half-space of the {side} light is {eta}; light reaches infinity only where it is real and above 0: \
         make that half-space transparent, or ask for the other side"
    )]
    Absorber {
        /// Reflected or transmitted light.
        side: &'static str,
        /// Index of its half-space.
        eta: Complex64,
    },
    /// Amplitudes of polarised light.
    #[error(
        "the far field holds polarised light; lobes of a finite area are those of the scalar wave: solve the scalar wave"
    )]
    Polarised,
    /// An amplitude that is not finite.
    #[error("order ({m}, {n}) of the far field is not finite; check the solve behind it")]
    NotFinite {
        /// Order along x.
        m: i32,
        /// Order along y.
        n: i32,
    },
    /// A direction outside the hemisphere.
    #[error(
        "direction is {polar_deg}° from the normal, azimuth {azimuth_deg}°; allowed are 0 … 90° and any finite azimuth"
    )]
    Direction {
        /// From the layer's normal, degrees.
        polar_deg: f64,
        /// From the x axis, degrees.
        azimuth_deg: f64,
    },
}

/// Light that leaves an illuminated square of the layer on one side (P2 (4.9)).
///
/// ```
/// use inkwave_physics::appearance::bdf::Lobe;
/// use inkwave_physics::appearance::finite_area::FiniteArea;
/// use inkwave_physics::solve::{Gmres, Goal, Silent, Solver};
/// use inkwave_physics::wave::{Incidence, Mean, Media, Problem, Resolution, Scene, Scheme, Side};
///
/// // A film sends back one lobe, of (l/λ)² R per steradian at the normal.
/// let scene = Scene::layer([1.0, 1.0], 0.3, vec![]);
/// let media = Media {
///     incident: 1.0.into(),
///     exit: 1.0.into(),
///     backgrounds: vec![1.6.into()],
///     inclusions: vec![],
/// };
/// let light = Incidence {
///     wavelength_um: 0.5,
///     polar_deg: 0.0,
///     azimuth_deg: 0.0,
///     from: Side::Incident,
/// };
/// let grid = Resolution { nx: 1, ny: 1, cells: 6, scheme: Scheme::Cubic };
/// let problem = Problem::from_scene(&scene, &media, &light, grid, Mean::default())?;
/// let solution = Gmres::default().solve(&problem, Goal::default(), &mut Silent)?;
/// let far = problem.far_field(&solution.field);
/// let lit = FiniteArea::new(&far, &media, Lobe::Reflected, 10.0)?;
/// assert!((lit.at(0.0, 0.0)? / (400.0 * far.reflectance) - 1.0).abs() < 1e-12);
/// assert!((lit.total() / far.reflectance - 1.0).abs() < 0.02); // what the edges lose: 2/(k l)
/// assert_eq!(lit.without_specular().total(), 0.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct FiniteArea {
    side_um: f64,
    /// k in the half-space that the light leaves into, 1/µm.
    k: f64,
    /// κ₀, 1/µm.
    incident_kappa: f64,
    /// Propagating orders by n: all orders of a row share ky.
    rows: BTreeMap<i32, LobeRow>,
}

/// The orders (·, n).
#[derive(Clone, Debug, PartialEq)]
struct LobeRow {
    /// 1/µm.
    ky: f64,
    waves: Vec<PlaneWave>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct PlaneWave {
    m: i32,
    /// 1/µm.
    kx: f64,
    amplitude: Complex64,
}

impl FiniteArea {
    /// Lobes of one side of a far field, emitted by a square of side `side_um` (µm), centred at x =
    /// y = 0 with its sides along the periods. `media` must be those of the far field's solve.
    ///
    /// # Errors
    /// Sides that [`FiniteArea::check_side`] rejects; an absorbing half-space; polarised light;
    /// amplitudes that are not finite.
    pub fn new(far: &FarField, media: &Media, lobe: Lobe, side_um: f64) -> Result<Self, FiniteAreaError> {
        Self::check_side(side_um, far.period_um, far.incidence.wavelength_um)?;
        let (from, to) = match far.incidence.from {
            Side::Incident => (media.incident, media.exit),
            Side::Exit => (media.exit, media.incident),
        };
        let (eta, side) = [(from, "reflected"), (to, "transmitted")][lobe as usize];
        if eta.im != 0.0 || eta.re <= 0.0 {
            return Err(FiniteAreaError::Absorber { side, eta });
        }
        let k0 = TAU / far.incidence.wavelength_um;
        let k = k0 * eta.re;
        let rows = rows(&far.orders, lobe, k0)?;
        let incident_kappa = k0 * from.re * far.incidence.polar_deg.to_radians().cos();
        Ok(FiniteArea { side_um, k, incident_kappa, rows })
    }

    /// Rejects a side shorter than a period or longer than a thousand wavelengths (all in µm): P2
    /// (4.1) assumes many periods.
    ///
    /// # Errors
    /// A side outside that range, or not a number.
    pub fn check_side(side_um: f64, period_um: [f64; 2], wavelength_um: f64) -> Result<(), FiniteAreaError> {
        let least = period_um[0].max(period_um[1]);
        let most = MOST_WAVELENGTHS * wavelength_um;
        if (least..=most).contains(&side_um) {
            return Ok(());
        }
        Err(FiniteAreaError::Side { value: side_um, least, most })
    }

    /// The lobes without the order (0, 0): diffuse light alone, as in P2 (4.9).
    pub fn without_specular(&self) -> FiniteArea {
        let mut diffuse = self.clone();
        if let Some(row) = diffuse.rows.get_mut(&0) {
            row.waves.retain(|w| w.m != 0);
        }
        diffuse
    }

    /// G: fraction of the light on the square scattered into the direction, sr⁻¹, with the phases
    /// and tails of all lobes.
    ///
    /// `polar_deg` is measured from the layer's normal on the side into which the light leaves, in
    /// the medium there; `azimuth_deg`, measured from the x axis, is that of the propagation
    /// direction, so both specular lobes are at the azimuth of the incidence.
    ///
    /// # Errors
    /// A polar angle outside 0 … 90°, an azimuth that is not finite.
    pub fn at(&self, polar_deg: f64, azimuth_deg: f64) -> Result<f64, FiniteAreaError> {
        if !((0.0..=90.0).contains(&polar_deg) && azimuth_deg.is_finite()) {
            return Err(FiniteAreaError::Direction { polar_deg, azimuth_deg });
        }
        let (sin, cos) = polar_deg.to_radians().sin_cos();
        let (y, x) = azimuth_deg.to_radians().sin_cos();
        // s = Σ_n sinc(l (ky_n − ky)/2) Σ_m α_mn sinc(l (kx_m − kx)/2)
        let rows = self.rows.values();
        let s: Complex64 =
            rows.map(|row| self.sinc(row.ky - self.k * sin * y) * self.along_x(row, self.k * sin * x)).sum();
        // G = l²/(4π²) · k³ cos²ϑ / κ₀ · |s|²
        Ok(self.aperture() * self.k.powi(3) * cos * cos / self.incident_kappa * s.norm_sqr())
    }

    /// ∫ G dω over the hemisphere: tends to R or T of the infinite layer as 1/l.
    ///
    /// By the midpoint rule in (kx, ky), accurate to about 1e-6 of the power in the lobes, and to
    /// 1e-3 for a lobe within 10° of grazing.
    pub fn total(&self) -> f64 {
        let samples = SAMPLES.max((SAMPLES_A_LOBE * self.k * self.side_um / TAU).ceil());
        let step = self.k / samples;
        // Midpoints: no sample lies on the rim of the disk.
        let places: Vec<f64> = (0..2 * samples as usize).map(|i| (i as f64 + 0.5 - samples) * step).collect();
        let table = |row: &LobeRow| places.iter().map(|ky| self.sinc(row.ky - ky)).collect();
        let tables: Vec<Vec<f64>> = self.rows.values().map(table).collect();
        let lines: Vec<f64> = places.par_iter().map(|&kx| self.line(kx, &places, &tables)).collect();
        // ∫ G dω = l²/(4π²) ∫ √(k² − kx² − ky²)/κ₀ · |s|² dkx dky
        self.aperture() * step * step / self.incident_kappa * lines.iter().sum::<f64>()
    }

    /// Angle between the centre of a lobe at normal direction and its first zero, degrees: sin ϑ =
    /// λ/(n l).
    pub fn first_zero_deg(&self) -> f64 {
        (TAU / (self.k * self.side_um)).min(1.0).asin().to_degrees()
    }

    /// Σ √(k² − kx² − ky²) |s|² over the samples `places` of ky; `tables` holds sinc(l (ky_n −
    /// ky)/2) of every row n.
    fn line(&self, kx: f64, places: &[f64], tables: &[Vec<f64>]) -> f64 {
        let mut s = vec![Complex64::default(); places.len()];
        for (row, table) in self.rows.values().zip(tables) {
            let along_x = self.along_x(row, kx);
            s.iter_mut().zip(table).for_each(|(s, sinc)| *s += along_x * sinc);
        }
        let kappa = |ky: f64| (self.k * self.k - kx * kx - ky * ky).max(0.0).sqrt();
        places.iter().zip(&s).map(|(&ky, s)| kappa(ky) * s.norm_sqr()).sum()
    }

    /// Σ_m α_mn sinc(l (kx_m − kx)/2) of a row.
    fn along_x(&self, row: &LobeRow, kx: f64) -> Complex64 {
        row.waves.iter().map(|w| w.amplitude * self.sinc(w.kx - kx)).sum()
    }

    /// sinc(l q/2) of a wavenumber difference q, 1/µm.
    fn sinc(&self, q: f64) -> f64 {
        let t = 0.5 * self.side_um * q;
        if t.abs() < 1e-8 { 1.0 } else { t.sin() / t }
    }

    /// Prefactor l²/(4π²), µm².
    fn aperture(&self) -> f64 {
        (0.5 * self.side_um / PI).powi(2)
    }
}

/// Propagating orders of one side, by n.
fn rows(orders: &[Order], lobe: Lobe, k0: f64) -> Result<BTreeMap<i32, LobeRow>, FiniteAreaError> {
    let mut rows = BTreeMap::new();
    for o in orders {
        let propagates = [o.reflected_propagates, o.transmitted_propagates][lobe as usize];
        let amplitude = [o.reflected, o.transmitted][lobe as usize];
        if o.further.as_flattened().iter().any(|a| a.norm_sqr() > 0.0) {
            return Err(FiniteAreaError::Polarised);
        }
        if !amplitude.is_finite() {
            return Err(FiniteAreaError::NotFinite { m: o.m, n: o.n });
        }
        let [kx, ky] = o.direction.map(|cosine| k0 * cosine);
        if propagates {
            let row = rows.entry(o.n).or_insert_with(|| LobeRow { ky, waves: Vec::new() });
            row.waves.push(PlaneWave { m: o.m, kx, amplitude });
        }
    }
    Ok(rows)
}

#[cfg(test)]
#[path = "finite_area_tests.rs"]
mod tests;
