//! One number for each total of a layer.

/// One value for each total of the layer.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LayerTotals<T = f64> {
    /// For R.
    pub reflectance: T,
    /// For T.
    pub transmittance: T,
    /// For the specular part of R.
    pub specular: T,
}

impl<T> LayerTotals<T> {
    /// Values in the order of the fits' columns.
    pub fn from_fn(of: impl FnMut(usize) -> T) -> Self {
        let [reflectance, transmittance, specular] = std::array::from_fn(of);
        Self { reflectance, transmittance, specular }
    }
}

impl LayerTotals {
    /// The values in the order of the fits' columns.
    pub(super) fn numbers(self) -> [f64; 3] {
        [self.reflectance, self.transmittance, self.specular]
    }

    /// Adds `step` times other values.
    pub(super) fn plus(self, step: f64, by: &Self) -> Self {
        Self {
            reflectance: self.reflectance + step * by.reflectance,
            transmittance: self.transmittance + step * by.transmittance,
            specular: self.specular + step * by.specular,
        }
    }
}

/// Differences of the totals from the film at \[0°, 45°\].
pub type Anchors = [LayerTotals; 2];
