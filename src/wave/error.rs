//! What can be wrong with a wave problem, each with the value found and the remedy.

use thiserror::Error;

/// Refusals of the wave stage.
#[derive(Debug, Error, Clone, PartialEq)]
pub enum WaveError {
    #[error("{field} is {value}; it must be finite and above 0")]
    NotPositive { field: String, value: f64 },
    #[error(
        "thickness of stratum {stratum} is {thickness_um:e} µm; below {least_um:e} µm, thinner than any atom, rounding \
         would drown it: leave the stratum out"
    )]
    TooThin { stratum: usize, thickness_um: f64, least_um: f64 },
    #[error(
        "{field} is {value:e}; at most {most_um:e} µm (a million periods) leaves enough digits of its place in the period: \
         give it within the period"
    )]
    FarOut { field: String, value: f64, most_um: f64 },
    #[error("{field} is {value}; it must be a finite number")]
    NotFinite { field: String, value: f64 },
    #[error(
        "body {body} reaches from z = {low_um} to {high_um} µm; it must lie within 0 … {thickness_um} µm: \
         move it or make the layer thicker"
    )]
    OutsideLayer { body: usize, low_um: f64, high_um: f64, thickness_um: f64 },
    #[error("{what} {index} is used, but only {known} are given; add its index")]
    UnknownMedium { what: &'static str, index: usize, known: usize },
    #[error(
        "refractive index of {medium} is {real} + {imaginary}i; both parts must be finite and ≥ 0 \
         (Im η ≥ 0 absorbs: change the sign if it was given for e^(+iωt))"
    )]
    Index { medium: String, real: f64, imaginary: f64 },
    #[error("{field} is {value}; allowed is {allowed}: {remedy}")]
    Range { field: &'static str, value: f64, allowed: &'static str, remedy: &'static str },
    #[error(
        "cell {cell} of the grid is {height_um:.4} µm high: phase k·h = {phase:.2} rad per cell, at most {limit} \
         is accurate; use at least {needed} cells in z"
    )]
    CellTooHigh { cell: usize, height_um: f64, phase: f64, limit: f64, needed: usize },
    #[error(
        "grid of {nx} × {ny} points is too coarse: order ({m}, {n}) propagates; use at least {need} points"
    )]
    GridTooCoarse { nx: usize, ny: usize, m: i32, n: i32, need: usize },
    #[error(
        "bodies {first} and {second} overlap by {overlap_um:.3e} µm; grains must not overlap: move them apart"
    )]
    Overlap { first: usize, second: usize, overlap_um: f64 },
    #[error(
        "body {body} overlaps its own periodic image by {overlap_um:.3e} µm; grains must not overlap: \
         make the period larger or the grain smaller"
    )]
    OverlapsImage { body: usize, overlap_um: f64 },
}
