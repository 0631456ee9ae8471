//! Planes, spectra and the compact set of harmonics on awkward sizes.

use super::*;
use num_complex::Complex64;
use std::f64::consts::TAU;

const SIZES: [usize; 5] = [1, 2, 7, 11, 16];

fn garbage(count: usize) -> Vec<Complex64> {
    (0..count).map(|i| Complex64::new((i as f64 * 1.7).sin() * 1e3, (i as f64 * 0.9).cos())).collect()
}

fn all_sizes() -> impl Iterator<Item = (usize, usize)> {
    SIZES.into_iter().flat_map(|nx| SIZES.map(|ny| (nx, ny)))
}

#[test]
fn gather_undoes_scatter_and_ignores_what_was_there_before() {
    for (nx, ny) in all_sizes() {
        let harmonics = Harmonics::new(nx, ny);
        let compact = garbage(harmonics.len());
        let mut spectrum = garbage(nx * ny);
        harmonics.spread(&compact, &mut spectrum);
        let mut back = garbage(harmonics.len() + 1)[1..].to_vec();
        harmonics.gather(&spectrum, &mut back);
        assert_eq!(compact, back, "{nx} × {ny}");
        let kept = spectrum.iter().filter(|z| **z != Complex64::default()).count();
        assert_eq!(kept, harmonics.len(), "{nx} × {ny}: everything else must be zero");
    }
}

#[test]
fn the_set_is_symmetric_starts_with_the_origin_and_lists_nothing_twice() {
    for (nx, ny) in all_sizes() {
        let harmonics = Harmonics::new(nx, ny);
        assert_eq!(harmonics.orders[0], [0, 0]);
        assert_eq!(harmonics.len(), (nx - 1 + nx % 2) * (ny - 1 + ny % 2), "{nx} × {ny}");
        for (i, &[m, n]) in harmonics.orders.iter().enumerate() {
            assert_eq!(harmonics.find(m, n), Some(i));
            assert!(harmonics.find(-m, -n).is_some(), "({m}, {n}) on {nx} × {ny}");
        }
    }
}

#[test]
fn inverse_transform_is_the_sum_of_plane_waves() {
    for (nx, ny) in all_sizes() {
        let fft = PlaneFft::new(nx, ny);
        let harmonics = Harmonics::new(nx, ny);
        let mut scratch = fft.scratch();
        (scratch.plane, scratch.spectrum) = (garbage(nx * ny), garbage(nx * ny));
        let compact = garbage(harmonics.len());
        harmonics.spread(&compact, &mut scratch.spectrum);
        fft.inverse(&mut scratch, &harmonics.rows);
        for (i, value) in scratch.plane.iter().enumerate() {
            let x = (i % nx) as f64 / nx as f64;
            let y = (i / nx) as f64 / ny as f64;
            let wave = |([m, n], c): (&[i32; 2], &Complex64)| {
                c * Complex64::cis(TAU * (f64::from(*m) * x + f64::from(*n) * y))
            };
            let expected: Complex64 = harmonics.orders.iter().zip(&compact).map(wave).sum();
            // Identity: up to 225 terms of size 1e3, some 1e-16 of rounding each.
            assert!((value - expected).norm() < 1e-9, "{nx} × {ny}, point {i}");
        }
    }
}

#[test]
fn forward_after_inverse_multiplies_by_the_number_of_points() {
    for (nx, ny) in all_sizes() {
        let fft = PlaneFft::new(nx, ny);
        let harmonics = Harmonics::new(nx, ny);
        let mut scratch = fft.scratch();
        let compact = garbage(harmonics.len());
        harmonics.spread(&compact, &mut scratch.spectrum);
        fft.inverse(&mut scratch, &harmonics.rows);
        scratch.spectrum.copy_from_slice(&garbage(nx * ny));
        fft.forward(&mut scratch, &harmonics.rows);
        let mut back = compact.clone();
        harmonics.gather(&scratch.spectrum, &mut back);
        for (a, b) in compact.iter().zip(&back) {
            assert!((a * (nx * ny) as f64 - b).norm() < 1e-8, "{nx} × {ny}");
        }
    }
}
