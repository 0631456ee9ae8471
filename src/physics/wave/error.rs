//! What can be wrong with a wave problem, each with the value found and the remedy.

use thiserror::Error;

/// Refusals of the wave stage.
#[derive(Debug, Error, Clone, PartialEq)]
pub enum WaveError {
    /// A length that must be positive.
    #[error("{field} is {value}; it must be finite and above 0")]
    NotPositive {
        /// Which length.
        field: String,
        /// The value found.
        value: f64,
    },
    /// A stratum that rounding would drown.
    #[error(
        "thickness of stratum {stratum} is {thickness_um:e} µm; below {least_um:e} µm, thinner than any atom, rounding \
         would drown it: leave the stratum out"
    )]
    TooThin {
        /// Its number from the incident side.
        stratum: usize,
        /// Its thickness, µm.
        thickness_um: f64,
        /// Least thickness, µm.
        least_um: f64,
    },
    /// A coordinate beyond what its rounding allows.
    #[error(
        "{field} is {value:e}; at most {most_um:e} µm (a million periods) leaves enough digits of its place in the period: \
         give it within the period"
    )]
    FarOut {
        /// Which coordinate.
        field: String,
        /// The value found, µm.
        value: f64,
        /// Most allowed, µm.
        most_um: f64,
    },
    /// A number that is not finite.
    #[error("{field} is {value}; it must be a finite number")]
    NotFinite {
        /// Which number.
        field: String,
        /// The value found.
        value: f64,
    },
    /// A body that leaves the layer.
    #[error(
        "body {body} reaches from z = {low_um} to {high_um} µm; it must lie within 0 … {thickness_um} µm: \
         move it or make the layer thicker"
    )]
    OutsideLayer {
        /// Its place in the scene.
        body: usize,
        /// Its smallest z, µm.
        low_um: f64,
        /// Its largest z, µm.
        high_um: f64,
        /// Thickness of the layer, µm.
        thickness_um: f64,
    },
    /// A medium without an index.
    #[error("{what} {index} is used, but only {known} are given; add its index")]
    UnknownMedium {
        /// Background or inclusion.
        what: &'static str,
        /// The index used.
        index: usize,
        /// How many are given.
        known: usize,
    },
    /// A refractive index that no passive medium has.
    #[error(
        "refractive index of {medium} is {real} + {imaginary}i; both parts must be finite and ≥ 0 \
         (Im η ≥ 0 absorbs: change the sign if it was given for e^(+iωt))"
    )]
    Index {
        /// Which medium.
        medium: String,
        /// Real part found.
        real: f64,
        /// Imaginary part found.
        imaginary: f64,
    },
    /// Something that Maxwell's equations are not solved for here.
    #[error("{what} is refused by the vector wave: {reason}; {remedy}")]
    NotInVectorMode {
        /// What was found.
        what: &'static str,
        /// Why it is refused.
        reason: &'static str,
        /// What to do instead.
        remedy: &'static str,
    },
    /// A number outside its range.
    #[error("{field} is {value}; allowed is {allowed}: {remedy}")]
    Range {
        /// Which number.
        field: &'static str,
        /// The value found.
        value: f64,
        /// What is allowed.
        allowed: &'static str,
        /// What to try.
        remedy: &'static str,
    },
    /// Someone asked to stop.
    #[error("stopped before the geometry was on its grid")]
    Stopped,
    /// A grid too coarse along z for the wave.
    #[error(
        "cell {cell} of the grid is {height_um:.4} µm high: phase k·h = {phase:.2} rad per cell, at most {limit} \
         is accurate; use at least {needed} cells in z"
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
        /// Cells that would do.
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
        /// Points that would do.
        need: usize,
    },
    /// Two bodies that overlap.
    #[error(
        "bodies {first} and {second} overlap by {overlap_um:.3e} µm; grains must not overlap: move them apart"
    )]
    Overlap {
        /// Place of one in the scene.
        first: usize,
        /// Place of the other.
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
        /// Its place in the scene.
        body: usize,
        /// Depth of the overlap, µm.
        overlap_um: f64,
    },
}
