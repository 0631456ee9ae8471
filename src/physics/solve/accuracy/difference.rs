//! Differences between two far fields.

use crate::wave::physical::largest;
use crate::wave::{FarField, Order};

/// Largest difference of any propagating amplitude in any polarisation, or of a neighbour of the
/// specular order.
///
/// The amplitudes of other evanescent orders exist within a fraction of a wavelength of the faces,
/// carry no power, and converge more slowly.
pub fn largest_difference(a: &FarField, b: &FarField) -> f64 {
    let counts =
        |o: &&Order| o.reflected_propagates || o.transmitted_propagates || (o.m.abs() <= 1 && o.n.abs() <= 1);
    let pairs = a.orders.iter().filter(counts);
    let pairs = pairs.filter_map(|a| Some((a, b.orders.iter().find(|b| (a.m, a.n) == (b.m, b.n))?)));
    let amplitudes = pairs.flat_map(|(a, b)| a.amplitudes().zip(b.amplitudes()));
    largest(amplitudes.flat_map(|(a, b)| [(a[0] - b[0]).norm(), (a[1] - b[1]).norm()]))
}

/// Maximum of [`largest_difference`] over all polarisations.
pub fn largest_of_all(a: &[FarField], b: &[FarField]) -> f64 {
    largest(a.iter().zip(b).map(|(a, b)| largest_difference(a, b)))
}
