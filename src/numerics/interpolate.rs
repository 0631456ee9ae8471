//! Interpolation: polynomials through points, and values on a periodic grid of a rectangle.

/// Weights of the values at `points` in the polynomial through them, at `x`.
#[inline]
pub fn lagrange(points: &[f64], x: f64) -> Vec<f64> {
    let weight = |(i, own): (usize, &f64)| {
        points.iter().enumerate().filter(|&(j, _)| j != i).map(|(_, p)| (x - p) / (own - p)).product()
    };
    points.iter().enumerate().map(weight).collect()
}

/// The value at a place, interpolated bilinearly between `count` points (x fastest) of a rectangle
/// with the given periods.
#[inline]
pub fn bilinear(values: &[f64], count: [usize; 2], period: [f64; 2], place: [f64; 2]) -> f64 {
    let [(i0, i1, u), (j0, j1, v)] = [0, 1].map(|k| neighbours(place[k] / period[k], count[k]));
    let at = |i: usize, j: usize| values[j * count[0] + i];
    (1.0 - v) * ((1.0 - u) * at(i0, j0) + u * at(i1, j0)) + v * ((1.0 - u) * at(i0, j1) + u * at(i1, j1))
}

/// Indices of the points before and after a place (in periods), and the fractional distance between
/// them.
#[inline]
fn neighbours(place: f64, n: usize) -> (usize, usize, f64) {
    let t = place.rem_euclid(1.0) * n as f64;
    let i = (t as usize).min(n - 1);
    (i, (i + 1) % n, t - i as f64)
}
