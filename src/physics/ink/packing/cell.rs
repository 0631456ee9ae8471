//! The cell that bodies are placed in.

use crate::numerics::Draws;
use crate::numerics::vector::V3;

/// The cell: side lengths, and the distance beyond which a periodic image is nearer (infinite
/// across walls).
#[derive(Clone, Copy, Debug)]
pub(crate) struct CellBox {
    pub size: V3,
    pub walls: bool,
    half: V3,
}

impl CellBox {
    pub fn new(period: [f64; 2], thickness: f64, walls: bool) -> Self {
        let size = [period[0], period[1], thickness];
        let half = [0.5 * size[0], 0.5 * size[1], if walls { f64::INFINITY } else { 0.5 * size[2] }];
        Self { size, walls, half }
    }

    pub fn periodic(&self, axis: usize) -> bool {
        axis < 2 || !self.walls
    }

    pub fn wrap(&self, mut p: V3) -> V3 {
        for (a, (x, size)) in p.iter_mut().zip(&self.size).enumerate() {
            if self.periodic(a) && !(*x >= 0.0 && *x < *size) {
                *x -= size * (*x / size).floor();
                // A tiny negative number rounds up to the period.
                if *x >= *size {
                    *x = 0.0;
                }
            }
        }
        p
    }

    /// Vector from wrapped a to the nearest image of wrapped b.
    #[inline(always)]
    pub fn delta(&self, a: V3, b: V3) -> V3 {
        let mut d = [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
        for ((d, half), size) in d.iter_mut().zip(&self.half).zip(&self.size) {
            if *d > *half {
                *d -= size;
            } else if *d < -half {
                *d += size;
            }
        }
        d
    }

    /// A uniform place.
    pub fn draw_place(&self, draws: &mut Draws) -> V3 {
        std::array::from_fn(|a| draws.between(0.0, self.size[a]))
    }
}
