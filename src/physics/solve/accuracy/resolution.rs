//! Resolutions related to a given one: companions for error estimates, and refinements.

use crate::wave::contrast::nufft::is_smooth;
use crate::wave::{Resolution, WaveError};

/// Lower limit on the own error as a fraction of the difference, however coarse the companion.
const LEAST_SHARE: f64 = 0.3;

/// Own error as a fraction of the difference to a companion, from the ratios of refinement in the
/// plane and across z; 1.5 for a finer companion.
pub(crate) fn error_share([plane, across]: [f64; 2], [in_plane, in_z]: [i32; 2]) -> f64 {
    if plane < 1.0 || across < 1.0 {
        return 1.5;
    }
    (1.0 / (plane.powi(in_plane) * across.powi(in_z) - 1.0)).max(LEAST_SHARE)
}

/// The coarsest sufficient resolution if a grid was rejected as too coarse.
pub fn raised(r: Resolution, refusal: &WaveError) -> Option<Resolution> {
    match *refusal {
        WaveError::CellTooHigh { needed, .. } => Some(Resolution { cells: needed.max(r.cells + 1), ..r }),
        WaveError::GridTooCoarse { need, .. } => {
            let raise = |n: usize| if n == 1 { 1 } else { n.max(smooth_size(need)) };
            Some(Resolution { nx: raise(r.nx), ny: raise(r.ny), ..r })
        }
        _ => None,
    }
}

/// Smallest product of 2, 3 and 5 that is at least `n`.
pub fn smooth_size(n: usize) -> usize {
    (n.max(2)..).find(|&n| is_smooth(n)).expect("smooth numbers are unbounded")
}

/// Points scaled by `factor`, rounded away from the present number to sizes with a fast transform.
pub(crate) fn scaled_plane(r: Resolution, factor: f64, uniform: [bool; 2]) -> Resolution {
    let scale = |n: usize, uniform: bool| if uniform { n } else { scaled_points(n, factor) };
    Resolution { nx: scale(r.nx, uniform[0]), ny: scale(r.ny, uniform[1]), ..r }
}

/// Points along one axis scaled by `factor`; see [`scaled_plane`].
pub(crate) fn scaled_points(n: usize, factor: f64) -> usize {
    match n {
        1 if factor > 1.0 => 3,
        n if factor > 1.0 => smooth_size((n as f64 * factor).ceil() as usize),
        n => (2..n).rev().find(|&k| (k as f64) <= n as f64 * factor && is_smooth(k)).unwrap_or(n),
    }
}

/// Cells scaled by `factor`, rounded away from the present number.
pub(crate) fn scaled_cells(r: Resolution, factor: f64) -> Resolution {
    let cells = r.cells as f64 * factor;
    let cells = if factor > 1.0 { cells.ceil() } else { cells.floor() };
    Resolution { cells: (cells as usize).max(1), ..r }
}

/// Refines each direction whose error exceeds half of the accuracy, as far as the fast convergence
/// of coarse grids suggests.
pub(crate) fn refine(r: Resolution, parts: [f64; 2], accuracy: f64) -> Resolution {
    let factor = |part: f64| (part / (0.4 * accuracy)).powf(1.0 / 6.0).clamp(1.1, 1.7);
    let mut next = r;
    if parts[0] > 0.45 * accuracy {
        let grow = |n: usize| if n == 1 { 1 } else { scaled_points(n, factor(parts[0])) };
        (next.nx, next.ny) = (grow(r.nx), grow(r.ny));
    }
    if parts[1] > 0.45 * accuracy {
        next.cells = ((r.cells as f64 * factor(parts[1])).round() as usize).max(r.cells + 1);
    }
    if next != r {
        return next;
    }
    // Neither exceeds its half, but their sum with the safety factor does: the direction with the
    // larger error is refined.
    match parts[0] > parts[1] {
        true => refine(r, [accuracy, 0.0], accuracy),
        false => refine(r, [0.0, accuracy], accuracy),
    }
}
