//! Light in a halftone print followed ray by ray: round dots on a square lattice over a Lambertian paper that spreads light
//! by exp(−r/ℓ)/(2πℓ²). No formula of the series is used.

use std::f64::consts::{PI, TAU};

/// Uniform numbers from 0 to 1 (SplitMix64).
pub struct Uniform(pub u64);

impl Uniform {
    fn draw(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// A kind of area: shares of the light that enter, that reach the eye from the paper, that leave and that come back to the
/// paper; the rest is absorbed.
#[derive(Clone, Copy, Debug)]
pub struct Area {
    pub entering: f64,
    /// Radiance factor per flux from the paper.
    pub leaving: f64,
    /// R̄_b.
    pub back: f64,
}

/// A print: dots of ink with this coverage, at most a half, else holes.
#[derive(Clone, Copy, Debug)]
pub struct Screen {
    pub coverage: f64,
    /// Distance of the dots over ℓ.
    pub pitch_by_spread: f64,
    pub ink: Area,
    pub bare: Area,
    pub albedo: f64,
}

impl Screen {
    /// What lies at a place, in pitches.
    fn area(&self, [x, y]: [f64; 2]) -> &Area {
        let x = x - x.round();
        let y = y - y.round();
        let has_dots = self.coverage <= 0.5;
        let share = if has_dots { self.coverage } else { 1.0 - self.coverage };
        let in_disc = x * x + y * y < share / PI;
        if in_disc == has_dots { &self.ink } else { &self.bare }
    }

    /// Radiance factor of the print by this number of rays.
    pub fn factor(&self, rays: usize, random: &mut Uniform) -> f64 {
        let mut sum = 0.0;
        for _ in 0..rays {
            let mut place = [random.draw(), random.draw()];
            let mut weight = self.area(place).entering;
            while weight > 1e-5 {
                // two exponential draws make r exp(−r/ℓ), the distance of this spread
                let length = -(random.draw().max(1e-300) * random.draw().max(1e-300)).ln();
                let length = length / self.pitch_by_spread;
                let azimuth = TAU * random.draw();
                place = [place[0] + length * azimuth.cos(), place[1] + length * azimuth.sin()];
                weight *= self.albedo;
                let above = self.area(place);
                sum += weight * above.leaving;
                weight *= above.back;
            }
        }
        sum / rays as f64
    }
}
