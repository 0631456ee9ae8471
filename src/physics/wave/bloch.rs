//! Bloch vector in the first Brillouin zone, so that harmonics are centred on zero.
//!
//! Harmonics are q + G with the reduced vector q, |q| ≤ π/L along each axis, and the incident wave
//! is one of them. All incident waves that share q are solved on the same harmonics, and those of q
//! and −q are opposite, which makes reciprocity exact between all orders, on odd and on even grids
//! (whose Nyquist harmonic is omitted); at oblique incidence no points are wasted on one side. On
//! the zone boundary itself, q and −q are the same direction with different harmonics: there
//! reciprocity is exact for the specular order, and as accurate as the grid for others.
//!
//! P2 (the remark after (3.13)) illuminates its cell along the Fourier directions, whose lateral
//! wavevectors are multiples of 2π/L. Here every direction is solved through its Bloch vector, and
//! none needs to be moved; [`Incidence::snapped`] does so for comparison with programs limited to
//! such directions.

use super::{Incidence, Layout, Media, Side, WaveError};
use std::f64::consts::TAU;

/// Distance from the zone boundary, in units of 2π/L, within which a vector counts as on it and is
/// left unchanged: rounding must not decide between both ends of the zone.
const TIE: f64 = 1e-9;

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
fn nearest_order(x: f64) -> i32 {
    (x.signum() * (x.abs() - 0.5 - TIE).ceil()) as i32
}

/// Longest lateral wavevector of a snapped direction, in units of k: 89.9° from the normal. Solves
/// reject light closer to grazing.
const REACH: f64 = 1.0 - 1e-6;
/// Range of periods for snapping, in wavelengths: the vector's integers remain exact.
const PERIODS: std::ops::RangeInclusive<f64> = 1e-6..=1e6;

/// A direction moved onto the lattice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Snapped {
    /// The light with its new direction.
    pub incidence: Incidence,
    /// Integers (m, n) of the lateral wavevector 2π (m/Lx, n/Ly).
    pub vector: [i32; 2],
}

impl Incidence {
    /// Lateral wavevector (kx, ky) of the incident wave, 1/µm.
    fn lateral_wavevector(&self, media: &Media) -> Result<[f64; 2], WaveError> {
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

    /// The light whose lateral wavevector is the lattice vector 2π (m/Lx, n/Ly) nearest to this
    /// one's, among those that propagate in the half-space of incidence (P2, after (3.13)). Of
    /// equally near ones the closest to the normal is taken; the azimuth of light along the normal
    /// is kept. `period_um` are the periods \[Lx, Ly\], µm.
    ///
    /// ```
    /// use inkwave_physics::wave::{Incidence, Media, Side};
    ///
    /// let air = 1.0.into();
    /// let backgrounds = vec![1.5.into()];
    /// let media = Media { incident: air, exit: air, backgrounds, inclusions: vec![] };
    /// let from = Side::Incident;
    /// let light = Incidence { wavelength_um: 0.5, polar_deg: 20.0, azimuth_deg: 30.0, from };
    /// // Directions of the lattice lie 0.25 apart.
    /// let snapped = light.snapped([2.0, 2.0], &media)?;
    /// assert_eq!(snapped.vector, [1, 1]);
    /// let polar_deg = (0.125f64).sqrt().asin().to_degrees();
    /// assert!((snapped.incidence.polar_deg - polar_deg).abs() < 1e-12);
    /// assert!((snapped.incidence.azimuth_deg - 45.0).abs() < 1e-12);
    /// # Ok::<(), inkwave_physics::wave::WaveError>(())
    /// ```
    ///
    /// # Errors
    /// Lights that [`Incidence::check`] rejects; light incident through an absorber; periods
    /// outside 1e-6 to 1e6 wavelengths.
    pub fn snapped(&self, period_um: [f64; 2], media: &Media) -> Result<Snapped, WaveError> {
        self.check()?;
        if let Some(&value) = period_um.iter().find(|l| !PERIODS.contains(&(**l / self.wavelength_um))) {
            let field = "period (µm)";
            let allowed = "1e-6 to 1e6 wavelengths for a direction to be snapped";
            return Err(WaveError::range(field, value, allowed, "give it in µm, or do not snap"));
        }
        let whole = self.lateral_wavevector(media)?;
        let eta = if self.from == Side::Incident { media.incident } else { media.exit };
        let k = TAU / self.wavelength_um * eta.re;
        let step = period_um.map(|l| TAU / l);
        let vector = nearest_within(whole, step, REACH * k);
        Ok(Snapped { incidence: self.along(lateral(vector, step), k), vector })
    }

    /// The light with another lateral wavevector, 1/µm; the azimuth stays within the same multiple
    /// of 360°.
    fn along(&self, [x, y]: [f64; 2], k: f64) -> Incidence {
        if [x, y] == [0.0; 2] {
            return Incidence { polar_deg: 0.0, ..*self };
        }
        let azimuth = y.atan2(x).to_degrees();
        let turns = ((self.azimuth_deg - azimuth) / 360.0).round();
        let polar_deg = (x.hypot(y) / k).asin().to_degrees();
        Incidence { polar_deg, azimuth_deg: azimuth + 360.0 * turns, ..*self }
    }
}

fn lateral(vector: [i32; 2], step: [f64; 2]) -> [f64; 2] {
    [0, 1].map(|i| step[i] * f64::from(vector[i]))
}

/// The lattice vector nearest to `whole` among those no longer than `reach`.
fn nearest_within(whole: [f64; 2], step: [f64; 2], reach: f64) -> [i32; 2] {
    // Rounding both integers towards zero stays within reach, so the nearest vector is less than a
    // diagonal away: at most √2 rows along the axis of the wider step. In each row it is the
    // nearest one inside the circle.
    let wide = usize::from(step[1] > step[0]);
    let in_row = |row: i32| nearest_in_row(wide, row, whole, step, reach);
    let length = |v: [i32; 2]| lateral(v, step)[0].hypot(lateral(v, step)[1]);
    let distance = |v: [i32; 2]| (lateral(v, step)[0] - whole[0]).hypot(lateral(v, step)[1] - whole[1]);
    let middle = nearest_order(whole[wide] / step[wide]);
    let mut found: Vec<[i32; 2]> = (-2..=2).map(|i| middle.saturating_add(i)).filter_map(in_row).collect();
    // Rounding must not decide between equally near ones.
    found.sort_by(|&a, &b| length(a).total_cmp(&length(b)));
    let slack = TIE * step[wide];
    found.into_iter().reduce(|a, b| if distance(b) < distance(a) - slack { b } else { a }).unwrap_or_default()
}

/// The vector nearest to `whole` among those with `row` along the axis `wide` that are no longer
/// than `reach`, if any.
fn nearest_in_row(wide: usize, row: i32, whole: [f64; 2], step: [f64; 2], reach: f64) -> Option<[i32; 2]> {
    let other = 1 - wide;
    let height = step[wide] * f64::from(row);
    let chord = (reach * reach - height * height).sqrt();
    let most = (chord / step[other]) as i32;
    let mut vector = [row; 2];
    vector[other] = nearest_order(whole[other] / step[other]).clamp(-most, most);
    (!chord.is_nan()).then_some(vector)
}

#[cfg(test)]
#[path = "bloch_tests.rs"]
mod tests;

#[cfg(test)]
#[path = "snapping_tests.rs"]
mod snapping_tests;
