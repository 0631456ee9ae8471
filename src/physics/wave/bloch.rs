//! Bloch vector in the first Brillouin zone, so that harmonics are centred on zero.
//!
//! Harmonics are q + G with the reduced vector q, |q| ≤ π/L along each axis, and the incident wave
//! is one of them. All incident waves that share q are solved on the same harmonics, and those of q
//! and −q are opposite, which makes reciprocity exact between all orders, on odd and on even grids
//! (whose Nyquist harmonic is omitted); at oblique incidence no points are wasted on one side. On
//! the zone boundary itself, q and −q are the same direction with different harmonics: there
//! reciprocity is exact for the specular order, and as accurate as the grid for others.

use super::{Incidence, Layout, Media, Side, WaveError};
use std::f64::consts::TAU;

/// Distance from the zone boundary, in units of 2π/L, within which a vector counts as on it and is
/// left unchanged: rounding must not decide between both ends of the zone.
pub(super) const TIE: f64 = 1e-9;

/// Bloch vector, and the harmonic of the incident wave.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlochVector {
    /// Reduced vector q in 1/µm; only axes with a lattice are reduced.
    pub reduced: [f64; 2],
    /// Harmonic (m, n) of the incident wave: its lateral wavevector is q + 2π (m/Lx, n/Ly).
    pub incident: [i32; 2],
    step: [f64; 2],
}

impl BlochVector {
    /// Reduces the lateral wavevector of the incident wave.
    ///
    /// Along a uniform axis there is no lattice: the component is kept unchanged. Errors: light
    /// incident through an absorber.
    pub fn new(layout: &Layout, media: &Media, incidence: &Incidence) -> Result<BlochVector, WaveError> {
        let whole = incidence.lateral_wavevector(media)?;
        let step = layout.grid.period_um.map(|l| TAU / l);
        let order = |i: usize| if layout.uniform[i] { 0 } else { nearest_order(whole[i] / step[i]) };
        let incident = [order(0), order(1)];
        let reduced = [0, 1].map(|i| whole[i] - step[i] * f64::from(incident[i]));
        Ok(BlochVector { reduced, incident, step })
    }

    /// Lateral wavevector of a harmonic, 1/µm.
    pub fn lateral(&self, harmonic: [i32; 2]) -> [f64; 2] {
        [0, 1].map(|i| self.reduced[i] + self.step[i] * f64::from(harmonic[i]))
    }

    /// Rejects a grid on which a propagating order of a half-space has no harmonic.
    pub fn check_orders(&self, layout: &Layout, media: &Media, k0: f64) -> Result<(), WaveError> {
        let resolution = layout.grid.resolution;
        let sizes = [resolution.nx, resolution.ny];
        let k = k0 * media.incident.re.max(media.exit.re);
        // A uniform axis scatters no light into its orders.
        for axis in (0..2).filter(|&i| !layout.uniform[i]) {
            let outermost = |sign: f64| ((k - sign * self.reduced[axis]) / self.step[axis]).floor() as i32;
            let order = outermost(1.0).max(outermost(-1.0));
            if order > (sizes[axis] as i32 - 1) / 2 {
                let signed = if outermost(1.0) == order { order } else { -order };
                let mut label = [0, 0];
                label[axis] = signed.saturating_sub(self.incident[axis]);
                let need = 2 * order as usize + 1;
                let [m, n] = label;
                return Err(WaveError::GridTooCoarse { nx: sizes[0], ny: sizes[1], m, n, need });
            }
        }
        Ok(())
    }
}

/// The integer nearest to `x`; of two equally near ones that closer to zero, so that opposite waves
/// have opposite harmonics.
pub(super) fn nearest_order(x: f64) -> i32 {
    (x.signum() * (x.abs() - 0.5 - TIE).ceil()) as i32
}

impl Incidence {
    /// Lateral wavevector (kx, ky) of the incident wave, 1/µm.
    pub(super) fn lateral_wavevector(&self, media: &Media) -> Result<[f64; 2], WaveError> {
        let eta = if self.from == Side::Incident { media.incident } else { media.exit };
        if eta.im != 0.0 {
            let field = "imaginary part of the index of the half-space that the light comes from";
            let remedy =
                "light cannot arrive from infinity through an absorber: make that half-space transparent";
            return Err(WaveError::range(field, eta.im, "0", remedy));
        }
        let k = TAU / self.wavelength_um * eta.re * self.polar_deg.to_radians().sin();
        let (sin, cos) = self.azimuth_deg.to_radians().sin_cos();
        Ok([k * cos, k * sin])
    }
}

#[cfg(test)]
#[path = "bloch_tests.rs"]
mod tests;
