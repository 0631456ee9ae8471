//! Exponentials of many complex numbers at a time, in loops that the compiler vectorises: a tenth
//! of the time of one after the other.

use multiversion::multiversion;
use num_complex::Complex64;

/// Added to a number below 2⁵¹ in size, it leaves its nearest integer in the last bits.
const ROUNDER: f64 = 6_755_399_441_055_744.0;
/// Logarithm of 2 and π/2 in parts, of which multiples by numbers below 2²⁰ are exact but for the
/// last (Cody and Waite 1980; the parts are those of FDLIBM).
const LN2: [f64; 2] = [6.931_471_803_691_238e-1, 1.908_214_929_270_587_7e-10];
const HALF_PI: [f64; 3] = [1.570_796_326_734_125_6, 6.077_100_506_303_966e-11, 2.022_266_248_795_950_6e-21];
/// Largest real and imaginary parts for these loops: their integers are exact up to here.
const MOST_REAL: f64 = 700.0;
const MOST_IMAGINARY: f64 = 1e6;

/// Coefficients of sin r = r + r³ Σ and cos r = 1 − r²/2 + r⁴ Σ for |r| ≤ π/4, in powers of r²
/// (FDLIBM): errors below 2⁻⁵⁷.
const SINE: [f64; 6] = [
    -1.666_666_666_666_663_2e-1,
    8.333_333_333_322_49e-3,
    -1.984_126_982_985_795e-4,
    2.755_731_370_707_006_8e-6,
    -2.505_076_025_340_686_3e-8,
    1.589_690_995_211_55e-10,
];
const COSINE: [f64; 6] = [
    4.166_666_666_666_66e-2,
    -1.388_888_888_887_411e-3,
    2.480_158_728_947_673e-5,
    -2.755_731_435_139_066_3e-7,
    2.087_572_321_298_175e-9,
    -1.135_964_755_778_819_5e-11,
];
/// Coefficients 1/k! of e^r for |r| ≤ ½ ln 2, from k = 13 down: the first left out is below 1e-17.
const EXPONENTIAL: [f64; 12] = [
    1.0 / 6_227_020_800.0,
    1.0 / 479_001_600.0,
    1.0 / 39_916_800.0,
    1.0 / 3_628_800.0,
    1.0 / 362_880.0,
    1.0 / 40_320.0,
    1.0 / 5_040.0,
    1.0 / 720.0,
    1.0 / 120.0,
    1.0 / 24.0,
    1.0 / 6.0,
    0.5,
];

/// Replaces every z by e^z, to four units in the last place of its modulus.
///
/// ```
/// use inkwave_numerics::exponential::exponentials;
/// use num_complex::Complex64;
///
/// let mut z = [Complex64::new(-0.5, std::f64::consts::PI)];
/// exponentials(&mut z);
/// assert!((z[0] + (-0.5f64).exp()).norm() < 1e-15);
/// ```
pub fn exponentials(values: &mut [Complex64]) {
    let is_usual = |z: &Complex64| (z.re.abs() < MOST_REAL) & (z.im.abs() < MOST_IMAGINARY);
    if values.iter().fold(true, |all, z| all & is_usual(z)) {
        return usual(values);
    }
    values.iter_mut().for_each(|z| *z = z.exp());
}

#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx2+fma", "x86_64+avx2+fma"))]
fn usual(values: &mut [Complex64]) {
    for z in values {
        let size = real_exponential(z.re);
        // z.im = n π/2 + r
        let shifted = z.im * std::f64::consts::FRAC_2_PI + ROUNDER;
        let quadrant = shifted.to_bits();
        let n = shifted - ROUNDER;
        let r = ((z.im - n * HALF_PI[0]) - n * HALF_PI[1]) - n * HALF_PI[2];
        let square = r * r;
        let sine = r + r * square * polynomial(square, SINE);
        let cosine = 1.0 - 0.5 * square + square * square * polynomial(square, COSINE);
        let is_odd = quadrant & 1 == 1;
        let (re, im) = if is_odd { (sine, cosine) } else { (cosine, sine) };
        // cos: signs + − − +; sin: + + − −
        let sign = |negative: u64, x: f64| f64::from_bits(x.to_bits() ^ (negative << 63));
        let half = (quadrant >> 1) & 1;
        *z = Complex64::new(size * sign(half ^ (quadrant & 1), re), size * sign(half, im));
    }
}

/// e^x for |x| < [`MOST_REAL`].
#[inline(always)]
fn real_exponential(x: f64) -> f64 {
    // x = n ln 2 + r
    let shifted = x * std::f64::consts::LOG2_E + ROUNDER;
    let n = shifted - ROUNDER;
    let r = (x - n * LN2[0]) - n * LN2[1];
    let power = EXPONENTIAL.iter().fold(0.0, |sum, &c| sum * r + c);
    let scale = f64::from_bits(shifted.to_bits().wrapping_add(1023) << 52); // 2ⁿ
    (1.0 + (r + r * r * power)) * scale
}

#[inline(always)]
fn polynomial(x: f64, coefficients: [f64; 6]) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, &c| sum * x + c)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

    /// Against the functions of the standard library, one number after the other. *Planted*: a
    /// sign of a quadrant, a series one term short, the last part of π/2 left out.
    #[test]
    fn exponentials_are_those_of_the_standard_library() {
        let real = (0..400).map(|k| 3.7 - 0.031 * f64::from(k * k) / 7.0);
        let real = real.chain([0.0, -1e-300, 1e-17, -690.0, 690.0]);
        let special = (-40..40).flat_map(|k| [0.0, 1e-9, -3e-13].map(|e| f64::from(k) * FRAC_PI_4 + e));
        let imaginary: Vec<f64> =
            special.chain((0..500).map(|k| 0.37 * f64::from(k) - 50.0)).chain([9.9e5, -777_777.7]).collect();
        let mut worst = 0f64;
        for re in real {
            let mut values: Vec<_> = imaginary.iter().map(|&im| Complex64::new(re, im)).collect();
            exponentials(&mut values);
            for (found, &im) in values.iter().zip(&imaginary) {
                let expected = Complex64::new(re, im).exp();
                worst = worst.max((found - expected).norm() / expected.norm());
            }
        }
        // four units in the last place
        assert!(worst < 9e-16, "{worst:e}");
        let mut near_zero = [Complex64::new(0.0, 17.0 * FRAC_PI_2)];
        exponentials(&mut near_zero);
        let cosine = (17.0 * FRAC_PI_2).cos();
        assert!((near_zero[0].re / cosine - 1.0).abs() < 1e-3, "{} {cosine}", near_zero[0].re);
    }

    /// Numbers beyond the range of the loops, and none.
    #[test]
    fn large_numbers_are_left_to_the_standard_library() {
        for z in [Complex64::new(-800.0, 1.0), Complex64::new(0.0, 1e9), Complex64::new(f64::NAN, 0.0)] {
            let mut values = [z, Complex64::ONE];
            exponentials(&mut values);
            let expected = z.exp();
            assert!(values[0] == expected || expected.is_nan() && values[0].is_nan());
            assert_eq!(values[1], Complex64::ONE.exp());
        }
        exponentials(&mut []);
    }
}
