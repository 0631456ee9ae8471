//! Errors of wave problems, each with the value found and the remedy.

use crate::numerics::allowed::brief;
use thiserror::Error;

/// Invalid scenes, media, lights or grids.
#[derive(Debug, Error, Clone, PartialEq)]
pub enum WaveError {
    /// A length, coordinate, medium or index that cannot be; the sentence says what was found and
    /// what is allowed.
    #[error("{0}")]
    Unsound(String),
    /// A body that extends beyond the layer.
    #[error(
        "body {body} reaches from z = {} to {} µm; it must lie within 0 … {} µm: move it or make the layer thicker",
        brief(*low_um), brief(*high_um), brief(*thickness_um)
    )]
    OutsideLayer {
        /// Index of the body in the scene.
        body: usize,
        /// Smallest z of the body, µm.
        low_um: f64,
        /// Largest z of the body, µm.
        high_um: f64,
        /// Thickness of the layer, µm.
        thickness_um: f64,
    },
    /// A case that the solver of Maxwell's equations does not support.
    #[error("{what} is not supported by the vector wave: {reason}; {remedy}")]
    NotInVectorMode {
        /// What was found.
        what: &'static str,
        /// Why it is not supported.
        reason: &'static str,
        /// What to do instead.
        remedy: &'static str,
    },
    /// The computation was cancelled.
    #[error("stopped before the geometry was on its grid")]
    Stopped,
    /// A grid too coarse along z for the wave.
    #[error(
        "cell {cell} of the grid along z is {height_um:.4} µm high, and the phase of the wave turns by {phase:.2} rad over it; at \
         most {limit} is accurate: use at least {needed} cells in z (each has one to four planes, as its scheme says)"
    )]
    CellTooHigh {
        /// Number of the cell.
        cell: usize,
        /// Its height, µm.
        height_um: f64,
        /// Phase k h across it, rad.
        phase: f64,
        /// Largest phase allowed, rad.
        limit: f64,
        /// Number of cells needed.
        needed: usize,
    },
    /// A grid too coarse in the plane for an order that propagates.
    #[error(
        "grid of {nx} × {ny} points is too coarse: order ({m}, {n}) propagates; use at least {need} points"
    )]
    GridTooCoarse {
        /// Points along x.
        nx: usize,
        /// Points along y.
        ny: usize,
        /// The order along x.
        m: i32,
        /// The order along y.
        n: i32,
        /// Number of points needed.
        need: usize,
    },
    /// Two bodies that overlap.
    #[error(
        "bodies {first} and {second} overlap by {overlap_um:.3e} µm; grains must not overlap: move them apart"
    )]
    Overlap {
        /// Index of one body in the scene.
        first: usize,
        /// Index of the other body.
        second: usize,
        /// Depth of the overlap, µm.
        overlap_um: f64,
    },
    /// A body that overlaps its own image in the next period.
    #[error(
        "body {body} overlaps its own periodic image by {overlap_um:.3e} µm; grains must not overlap: \
         make the period larger or the grain smaller"
    )]
    OverlapsImage {
        /// Index of the body in the scene.
        body: usize,
        /// Depth of the overlap, µm.
        overlap_um: f64,
    },
}

impl WaveError {
    /// A number outside its range, with what is allowed and what to try.
    pub(super) fn range(field: &str, value: f64, allowed: &str, remedy: &str) -> WaveError {
        WaveError::Unsound(format!("{field} is {value}; allowed is {allowed}: {remedy}"))
    }
}
