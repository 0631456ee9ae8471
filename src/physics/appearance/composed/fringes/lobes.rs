//! R and T of light, and their arithmetic.

/// Shares of the light that are reflected and transmitted.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Lobes {
    /// R, or its change.
    pub reflected: f64,
    /// T, or its change.
    pub transmitted: f64,
}

impl Lobes {
    /// This and a multiple of another.
    pub fn plus(self, by: f64, other: Self) -> Self {
        Self {
            reflected: self.reflected + by * other.reflected,
            transmitted: self.transmitted + by * other.transmitted,
        }
    }

    /// The difference from another.
    pub(super) fn less(self, other: Self) -> Self {
        self.plus(-1.0, other)
    }

    /// With shares of what is lost.
    pub(super) fn with_loss(self, shares: Self) -> Self {
        self.plus(1.0 - self.reflected - self.transmitted, shares)
    }

    /// Changed, and kept within the light that there is.
    pub fn changed(self, by: Self) -> Self {
        let sum = self.plus(1.0, by);
        let whole = (sum.reflected + sum.transmitted).clamp(0.0, 1.0);
        let reflected = sum.reflected.max(0.0).min(whole);
        Self { reflected, transmitted: whole - reflected }
    }
}
