//! Form factors F(q) = ∫ e^{−iq·r} dV of convex bodies about their centre, as in the manual of sasmodels and in Pedersen,
//! Adv. Colloid Interface Sci. 70 (1997) 171.

use num_complex::Complex64;
use std::f64::consts::{PI, TAU};

/// Sphere of radius r, Rayleigh: 3V (sin x − x cos x)/x³ with x = q r.
pub fn sphere(q: [f64; 3], r: f64) -> f64 {
    ellipsoid(q, [r; 3])
}

/// Ellipsoid along the axes of q: a sphere in the coordinates divided by the semi-axes.
pub fn ellipsoid(q: [f64; 3], semi_axes: [f64; 3]) -> f64 {
    let volume = 4.0 / 3.0 * PI * semi_axes.iter().product::<f64>();
    let x = (0..3).map(|i| (q[i] * semi_axes[i]).powi(2)).sum::<f64>().sqrt();
    if x < 1e-3 { volume * (1.0 - x * x / 10.0) } else { 3.0 * volume * (x.sin() - x * x.cos()) / x.powi(3) }
}

/// Box along the axes of q: V Π sin(q a/2)/(q a/2).
pub fn cuboid(q: [f64; 3], edges: [f64; 3]) -> f64 {
    (0..3).map(|i| edges[i] * sinc(0.5 * q[i] * edges[i])).product()
}

/// Disc of radius r and thickness h about z: V · 2 J₁(q⊥ r)/(q⊥ r) · sinc(q_z h/2).
pub fn disc(q: [f64; 3], r: f64, h: f64) -> f64 {
    let x = q[0].hypot(q[1]) * r;
    let round = if x < 1e-6 { 1.0 } else { 2.0 * bessel_j1(x) / x };
    PI * r * r * h * round * sinc(0.5 * q[2] * h)
}

/// Prism over a polygon about z: the transform of the polygon by its edges, S(q⊥) = Σ (q × e)·i/q² sinc(q·e/2) e^{−iq·c}
/// with edges e about their centres c, times h sinc(q_z h/2).
pub fn prism(q: [f64; 3], corners: &[[f64; 2]], h: f64) -> Complex64 {
    let square = q[0] * q[0] + q[1] * q[1];
    let next = corners.iter().cycle().skip(1);
    let edge = |(a, b): (&[f64; 2], &[f64; 2])| {
        let e = [b[0] - a[0], b[1] - a[1]];
        let c = [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])];
        let along = 0.5 * (q[0] * e[0] + q[1] * e[1]);
        let phase = Complex64::cis(-(q[0] * c[0] + q[1] * c[1]));
        Complex64::I * (q[0] * e[1] - q[1] * e[0]) / square * sinc(along) * phase
    };
    let twice = corners.iter().zip(next.clone()).map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum::<f64>();
    let flat: Complex64 =
        if square < 1e-12 { (0.5 * twice).into() } else { corners.iter().zip(next).map(edge).sum() };
    h * sinc(0.5 * q[2] * h) * flat
}

fn sinc(x: f64) -> f64 {
    if x.abs() < 1e-8 { 1.0 } else { x.sin() / x }
}

/// J₁(x) = (1/π) ∫₀^π cos(t − x sin t) dt: the trapezoidal rule over a period converges geometrically.
fn bessel_j1(x: f64) -> f64 {
    let count = 128;
    let term = |i: usize| {
        let t = TAU * (i as f64 + 0.5) / f64::from(count);
        (t - x * t.sin()).cos()
    };
    (0..count as usize).map(term).sum::<f64>() / f64::from(count)
}
