//! What is kept of one packing: what was asked, what was reached and how.

use super::store::Record;
use crate::ink::{Account, Method, Packing, Share};
use serde::{Deserialize, Serialize};

/// One realisation's packing. The grains themselves follow from the request, bit for bit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PackingRecord {
    pub realisation: usize,
    pub method: Method,
    /// Attempts of sequential addition or steps of relaxation.
    pub steps: u64,
    /// Smallest distance between two surfaces, µm, where any are near.
    pub smallest_gap_um: Option<f64>,
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
    pub requested_fraction: f64,
    pub achieved_fraction: f64,
    pub grains: usize,
    /// Factor on the drawn sizes (1 unless the share is met by scaling).
    pub size_factor: f64,
}

impl PackingRecord {
    pub fn new(realisation: usize, packing: &Packing) -> Self {
        let Account { method, steps, smallest_gap_um, notes, .. } = packing.account().clone();
        let shares = packing.shares().iter().map(ShareRecord::from).collect();
        Self { realisation, method, steps, smallest_gap_um, notes, shares }
    }
}

impl From<&Share> for ShareRecord {
    fn from(share: &Share) -> Self {
        let Share { requested_fraction, achieved_fraction, grains, size_factor, .. } = *share;
        Self { requested_fraction, achieved_fraction, grains, size_factor }
    }
}
