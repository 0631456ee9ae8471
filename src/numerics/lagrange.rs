//! Polynomials through points.

/// Weights of the values at `points` in the polynomial through them, at `x`.
pub fn lagrange(points: &[f64], x: f64) -> Vec<f64> {
    (0..points.len()).map(|i| weight(points, i, x)).collect()
}

fn weight(points: &[f64], i: usize, x: f64) -> f64 {
    let others = points.iter().enumerate().filter(|&(j, _)| j != i);
    others.map(|(_, p)| (x - p) / (points[i] - p)).product()
}
