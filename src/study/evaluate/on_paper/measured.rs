//! What is measured of a layer at every wavelength solved: differences of its totals from those of
//! the coherent film.

/// Number of totals with a curve over the angle: R, T, and the specular part of R.
pub const CURVES: usize = 3;
// their places
pub(super) const REFLECTANCE: usize = 0;
pub(super) const TRANSMITTANCE: usize = 1;
pub(super) const SPECULAR: usize = 2;
/// Differences of these totals from the film at \[0°, 45°\].
pub type Anchors = [[f64; CURVES]; 2];

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

/// Numbers that are measured.
pub(in crate::evaluate) const MEASURED: usize = 4 * CURVES + 3;

impl Measured {
    /// All numbers, totals first.
    pub(super) fn all(&mut self) -> impl Iterator<Item = &mut f64> {
        let Self { anchors, returned, straight_on, transmittance, absorptance } = self;
        anchors.iter_mut().chain(returned).flatten().chain([straight_on, transmittance, absorptance])
    }

    /// As a list, totals first.
    pub(in crate::evaluate) fn numbers(mut self) -> [f64; MEASURED] {
        let mut all = self.all();
        std::array::from_fn(|_| all.next().map_or(0.0, |number| *number))
    }

    /// With `step` times other values added.
    pub(super) fn moved(mut self, by: &Self, step: f64) -> Self {
        self.all().zip(by.numbers()).for_each(|(number, by)| *number += step * by);
        self
    }
}
