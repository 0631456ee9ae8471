//! Points that fill a box evenly for any number of points: a Kronecker sequence.
//!
//! Coordinate d of point r is the fractional part of s_d + (r + 1) g^{−d}, with g the positive root
//! of g^{D+1} = g + 1 (the golden ratio for D = 1; M. Roberts 2018, "The unreasonable effectiveness
//! of quasirandom sequences"). The shifts s_d are drawn from the seed (Cranley and Patterson 1976):
//! every single point is uniform, so a mean over points is unbiased, and the sequence may be
//! extended without changing earlier points.

use super::Draws;

/// Stream of the seed for the shifts; packings use the streams 0, 1, 2, …
const STREAM: u64 = u64::MAX;

/// A shifted Kronecker sequence in `D` dimensions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sequence<const D: usize> {
    shift: [f64; D],
    step: [f64; D],
}

impl<const D: usize> Sequence<D> {
    /// The sequence of a seed.
    pub fn new(seed: u64) -> Self {
        let mut draws = Draws::new(seed, STREAM);
        let root = root(D);
        Self {
            shift: std::array::from_fn(|_| draws.uniform()),
            step: std::array::from_fn(|d| 1.0 / power(root, d + 1)),
        }
    }

    /// Point `r`, each coordinate in 0 ≤ x < 1.
    pub fn point(&self, r: usize) -> [f64; D] {
        std::array::from_fn(|d| (self.shift[d] + (r + 1) as f64 * self.step[d]).fract())
    }
}

/// xⁿ by repeated squaring. The last digit of `powi` may depend on the build, and with it a seed's
/// directions, which identify stored solves.
fn power(x: f64, n: usize) -> f64 {
    let (mut power, mut square, mut left) = (1.0, x, n);
    loop {
        if left % 2 == 1 {
            power *= square;
        }
        left /= 2;
        if left == 0 {
            return power;
        }
        square *= square;
    }
}

/// The positive root of g^{D+1} = g + 1, by the contraction g → (1 + g)^{1/(D+1)}.
fn root(dimensions: usize) -> f64 {
    let power = 1.0 / (dimensions as f64 + 1.0);
    (0..64).fold(1.5, |g: f64, _| (1.0 + g).powf(power))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_root_is_the_golden_ratio_in_one_dimension() {
        approx::assert_relative_eq!(root(1), (1.0 + 5f64.sqrt()) / 2.0, max_relative = 1e-15);
        let g = root(6);
        approx::assert_relative_eq!(power(g, 7), g + 1.0, max_relative = 1e-14);
    }

    /// 64 points leave no gap wider than three times the even spacing, in any coordinate and for
    /// any seed: independent draws leave gaps of 5/64 and more (ln 64 ≈ 4.2 times the spacing on
    /// average).
    #[test]
    fn points_are_even_in_every_coordinate() {
        for seed in 0..20 {
            let sequence = Sequence::<6>::new(seed);
            for d in 0..6 {
                let mut x: Vec<f64> = (0..64).map(|r| sequence.point(r)[d]).collect();
                x.sort_by(f64::total_cmp);
                let around = 1.0 + x[0] - x[63];
                let widest = x.windows(2).map(|w| w[1] - w[0]).fold(around, f64::max);
                assert!(widest < 3.0 / 64.0, "seed {seed}, coordinate {d}: {widest}");
            }
        }
    }

    #[test]
    fn seeds_differ_and_repeat() {
        let of = |seed| Sequence::<2>::new(seed).point(3);
        assert_eq!(of(5), of(5));
        assert_ne!(of(5), of(6));
    }
}
