//! Why a packing was not delivered.

/// Every way a packing can fail; the fields carry what a reader needs to act.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PackError {
    #[error("{field} = {found}: allowed is {allowed}; {advice}")]
    BadInput { field: String, found: String, allowed: String, advice: String },

    #[error(
        "volume fraction {requested:.4} not reached after {steps} steps: {placed} of {wanted} grains fit without overlap \
         (fraction {reached:.4}), largest overlap left {largest_overlap_um:.2e} µm ({relative_overlap:.1e} of the \
         radii's sum); {advice}"
    )]
    NotReached {
        requested: f64,
        /// Fraction of the grains that did find room after the worst ones were taken out.
        reached: f64,
        placed: usize,
        wanted: usize,
        steps: u64,
        largest_overlap_um: f64,
        /// Largest overlap over the sum of the two radii.
        relative_overlap: f64,
        advice: String,
    },

    #[error(
        "{first} and {second} overlap by {overlap_um:.3e} µm; a packing holds only grains that do not overlap"
    )]
    Overlap { first: String, second: String, overlap_um: f64 },

    #[error("stopped on request during {stage} after {steps} steps; nothing is delivered")]
    Stopped { stage: &'static str, steps: u64 },
}

impl PackError {
    pub(crate) fn input(
        field: impl Into<String>,
        found: impl ToString,
        allowed: impl Into<String>,
        advice: impl Into<String>,
    ) -> Self {
        let (field, allowed, advice) = (field.into(), allowed.into(), advice.into());
        Self::BadInput { field, found: found.to_string(), allowed, advice }
    }
}
