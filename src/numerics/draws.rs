//! Random draws that are identical on every machine: ChaCha8 words converted to numbers by rules of
//! this project; and points that fill a box evenly for any number of points.

use super::vector::{Rotation, V3};
use rand::SeedableRng;
use rand::rand_core::Rng;
use rand::rngs::ChaCha8Rng;
use std::f64::consts::{PI, TAU};

/// A reproducible random source: the seed identifies the study, the stream the realisation.
pub struct Draws(ChaCha8Rng);

impl Draws {
    /// The 64-bit seed fills the first eight bytes of the ChaCha key (little-endian), zeros the
    /// rest.
    pub fn new(seed: u64, stream: u64) -> Self {
        let mut key = [0u8; 32];
        key[..8].copy_from_slice(&seed.to_le_bytes());
        let mut words = ChaCha8Rng::from_seed(key);
        words.set_stream(stream);
        Self(words)
    }

    /// Uniform in [0, 1): the upper 53 bits of a 64-bit word times 2⁻⁵³.
    #[inline]
    pub fn uniform(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 * (-53f64).exp2()
    }

    /// Uniform in [low, high).
    #[inline]
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.uniform()
    }

    /// Uniform in 0..n.
    pub fn below(&mut self, n: usize) -> usize {
        ((self.uniform() * n as f64) as usize).min(n.saturating_sub(1))
    }

    /// Standard normal (Box–Muller, the cosine branch).
    pub fn normal(&mut self) -> f64 {
        (-2.0 * (1.0 - self.uniform()).ln()).sqrt() * (TAU * self.uniform()).cos()
    }

    /// Uniform on the unit sphere.
    pub fn direction(&mut self) -> V3 {
        let z = self.between(-1.0, 1.0);
        let (s, c) = self.between(-PI, PI).sin_cos();
        let planar = (1.0 - z * z).max(0.0).sqrt();
        [planar * c, planar * s, z]
    }

    /// A uniform rotation about the z axis followed by the rotation of z onto `axis`.
    pub fn rotation_with_axis(&mut self, axis: V3) -> Rotation {
        Rotation::by([0.0, 0.0, self.between(-PI, PI)]).then(Rotation::from_z_to(axis))
    }

    /// A uniform rotation.
    pub fn rotation(&mut self) -> Rotation {
        let axis = self.direction();
        self.rotation_with_axis(axis)
    }

    /// Shuffles the items, each order equally likely (Fisher–Yates).
    pub fn shuffle<T>(&mut self, items: &mut [T]) {
        for i in (1..items.len()).rev() {
            items.swap(i, self.below(i + 1));
        }
    }
}

/// Weighted quantile of the values, in the order of the list.
pub fn weighted<T: Copy>(values: &[T], weights: &[f64], share: f64) -> T {
    if weights.is_empty() {
        return values[((share * values.len() as f64) as usize).min(values.len() - 1)];
    }
    let mut left = share * weights.iter().sum::<f64>();
    for (value, weight) in values.iter().zip(weights) {
        left -= weight;
        if left < 0.0 {
            return *value;
        }
    }
    values[weights.iter().rposition(|w| *w > 0.0).unwrap_or(0)]
}

/// Whether numbers can be weights: finite, none below 0, their sum above it.
pub fn are_weights(weights: &[f64]) -> bool {
    weights.iter().all(|w| w.is_finite() && *w >= 0.0) && weights.iter().sum::<f64>() > 0.0
}

/// Stream of the seed for the shifts; packings use the streams 0, 1, 2, …
const STREAM: u64 = u64::MAX;

/// A shifted Kronecker sequence in `D` dimensions: its points fill a box evenly for any number of
/// points.
///
/// Coordinate d of point r is the fractional part of s_d + (r + 1) g^{−d}, with g the positive root
/// of g^{D+1} = g + 1 (the golden ratio for D = 1; M. Roberts 2018, "The unreasonable effectiveness
/// of quasirandom sequences"). The shifts s_d are drawn from the seed (Cranley and Patterson 1976):
/// every single point is uniform, so a mean over points is unbiased, and the sequence may be
/// extended without changing earlier points.
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
    let mut power = 1.0;
    let mut square = x;
    let mut left = n;
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
    fn the_first_draws_are_pinned() {
        let first = |seed, stream| {
            let mut draws = Draws::new(seed, stream);
            [draws.uniform(), draws.uniform(), draws.uniform()]
        };
        // Exact: any change here changes every published packing.
        assert_eq!(first(1, 0), [0.381489413238261, 0.2949273257816749, 0.7982542473815959]);
        assert_eq!(first(1, 7), [0.29874720210219474, 0.19632633696866708, 0.5288116588181441]);
    }

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
