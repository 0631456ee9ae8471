//! What is kept of one packing: what was asked, what was reached and how.

use super::store::Record;
use crate::ink::statistics::{ReachedSizes, profile};
use crate::ink::{Method, Packing, PackingAccount, Share};
use serde::{Deserialize, Serialize};

/// Slices of the profile.
const SLICES: usize = 40;

/// One realisation's packing. The grains themselves follow from the request, bit for bit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PackingRecord {
    /// Number of the realisation, from 0.
    pub realisation: usize,
    /// Period of the cell, µm.
    pub period_um: [f64; 2],
    /// Thickness of the layer, µm.
    pub thickness_um: f64,
    /// Volume fractions in equal slices across the layer, from the incident side: each pigment, and what lies above a relief.
    pub profile: Vec<Vec<f64>>,
    /// How the grains came to their places.
    pub method: Method,
    /// Attempts of sequential addition or steps of relaxation.
    pub steps: u64,
    /// Smallest distance between two surfaces, µm, where any are near.
    pub smallest_gap_um: Option<f64>,
    /// Notes of the packing for the reader.
    pub notes: Vec<String>,
    /// One entry for each pigment, in the study's order.
    pub shares: Vec<ShareRecord>,
}

impl Record for PackingRecord {
    const KIND: &'static str = "packing";
}

/// One pigment's share of the layer's volume.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ShareRecord {
    /// Volume fraction asked for.
    pub requested_fraction: f64,
    /// Volume fraction of whole grains.
    pub achieved_fraction: f64,
    /// Number of grains.
    pub grains: usize,
    /// Factor on the drawn sizes (1 unless the share is met by scaling).
    pub size_factor: f64,
    /// Percentiles of its grains' sizes; none without grains.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sizes: Option<ReachedSizes>,
}

impl PackingRecord {
    /// The record of a packing.
    pub fn new(realisation: usize, packing: &Packing) -> Self {
        let PackingAccount { method, steps, smallest_gap_um, notes, .. } = packing.account().clone();
        let share = |(k, share): (usize, &Share)| ShareRecord {
            sizes: ReachedSizes::of(packing, k),
            ..ShareRecord::from(share)
        };
        let shares = packing.shares().iter().enumerate().map(share).collect();
        let (period_um, thickness_um) = (packing.period_um(), packing.thickness_um());
        let profile = profile(packing, SLICES);
        Self { realisation, period_um, thickness_um, profile, method, steps, smallest_gap_um, notes, shares }
    }
}

impl From<&Share> for ShareRecord {
    fn from(share: &Share) -> Self {
        let Share { requested_fraction, achieved_fraction, grains, size_factor, .. } = *share;
        Self { requested_fraction, achieved_fraction, grains, size_factor, sizes: None }
    }
}
