//! The record of one packing: what was requested, what was achieved and how.

use super::store::Record;
use crate::ink::statistics::{ReachedSizes, profile};
use crate::ink::{Method, Packing, PackingAccount, Share};
use serde::{Deserialize, Serialize};

/// Number of slices in the profile.
const SLICES: usize = 40;

/// Record of one realisation's packing. The grains themselves can be reproduced from the request,
/// bit for bit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PackingRecord {
    /// Number of the realisation, from 0.
    pub realisation: usize,
    /// Period of the cell, µm.
    pub period_um: [f64; 2],
    /// Thickness of the layer, µm.
    pub thickness_um: f64,
    /// Volume fractions in equal slices across the layer (across each layer of a stack in turn),
    /// from the incident side: each pigment, then the volume beyond a relief.
    pub profile: Vec<Vec<f64>>,
    /// Packing method.
    pub method: Method,
    /// Attempts of sequential addition, or relaxation steps.
    pub steps: u64,
    /// Smallest gap between two surfaces, µm; `None` if no grains are close.
    pub smallest_gap_um: Option<f64>,
    /// Notes for the reader.
    pub notes: Vec<String>,
    /// One entry per pigment, in the study's order.
    pub shares: Vec<ShareRecord>,
}

impl Record for PackingRecord {
    const KIND: &'static str = "packing";
}

/// Volume fraction and sizes of one pigment.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ShareRecord {
    /// Requested volume fraction.
    pub requested_fraction: f64,
    /// Volume fraction of the placed grains.
    pub achieved_fraction: f64,
    /// Number of grains.
    pub grains: usize,
    /// Factor on the drawn sizes (1 unless sizes are scaled to meet the fraction).
    pub size_factor: f64,
    /// Percentiles of the grain sizes; `None` without grains.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sizes: Option<ReachedSizes>,
}

impl PackingRecord {
    /// The record of a packing.
    pub fn new(realisation: usize, packing: &Packing) -> Self {
        let PackingAccount { method, steps, smallest_gap_um, notes, .. } = packing.account().clone();
        let share = |(k, share): (usize, &Share)| ShareRecord {
            requested_fraction: share.requested_fraction,
            achieved_fraction: share.achieved_fraction,
            grains: share.grains,
            size_factor: share.size_factor,
            sizes: ReachedSizes::of(packing, k),
        };
        let shares = packing.shares().iter().enumerate().map(share).collect();
        let period_um = packing.period_um();
        let thickness_um = packing.thickness_um();
        let profile = profile(packing, SLICES);
        Self { realisation, period_um, thickness_um, profile, method, steps, smallest_gap_um, notes, shares }
    }
}
