//! Why a packing was not delivered.

/// Every way a packing can fail; the fields carry what a reader needs to act.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PackError {
    /// A number of the request that cannot be packed; found before any grain is placed.
    #[error("{field} = {found}: allowed is {allowed}; {remedy}")]
    BadInput {
        /// Path of the field in the request.
        field: String,
        /// The value found.
        found: String,
        /// What is allowed.
        allowed: String,
        /// What to try.
        remedy: String,
    },

    /// Random sequential addition found no free place for a grain.
    #[error(
        "volume fraction {requested:.4} not reached after {attempts} attempts: sequential addition is blocked \
         with {placed} of {wanted} grains in place (fraction {reached:.4}; spheres saturate at 0.384): use method = \
         \"relaxation\", raise sequential.attempts_per_grain or lower the volume fraction"
    )]
    Blocked {
        /// Volume fraction of all grains of the request.
        requested: f64,
        /// Volume fraction of the grains in place.
        reached: f64,
        /// Grains in place.
        placed: usize,
        /// Grains of the request.
        wanted: usize,
        /// Attempts made, those for the grains in place included.
        attempts: u64,
    },

    /// Relaxation of overlaps came to rest, or to its limit of steps, with overlaps left.
    #[error(
        "volume fraction {requested:.4} not reached after {steps} steps: {}, largest overlap left \
         {largest_overlap_um:.2e} µm ({relative_overlap:.1e} of the radii's sum); lower the volume fraction to what was \
         reached, take smaller grains or a thicker layer (walls cost density), or allow more relaxation.max_steps",
        reached_part(reached, *wanted)
    )]
    NotReached {
        /// Volume fraction of all grains of the request.
        requested: f64,
        /// What did find room after the worst grains were taken out; `None` when that search gave up as well.
        reached: Option<Reached>,
        /// Grains of the request.
        wanted: usize,
        /// Steps of relaxation.
        steps: u64,
        /// Largest overlap left, µm.
        largest_overlap_um: f64,
        /// Largest overlap over the sum of the two radii.
        relative_overlap: f64,
    },

    /// Two grains, or a grain and a wall, overlap in a packing that claims to have no overlap.
    #[error(
        "{first} and {second} overlap by {overlap_um:.3e} µm; a packing holds only grains that do not overlap"
    )]
    Overlap {
        /// One of the two, such as "grain 3".
        first: String,
        /// The other, or "a wall".
        second: String,
        /// Depth of the overlap, µm.
        overlap_um: f64,
    },

    /// The watch asked to stop.
    #[error("stopped on request during {stage} after {steps} steps; nothing is delivered")]
    Stopped {
        /// What was being done.
        stage: &'static str,
        /// Steps, attempts or sweeps until then.
        steps: u64,
    },
}

/// The densest arrangement without overlap that a stuck relaxation leads to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reached {
    /// Its volume fraction.
    pub fraction: f64,
    /// Its grains.
    pub grains: usize,
}

fn reached_part(reached: &Option<Reached>, wanted: usize) -> String {
    match reached {
        Some(Reached { fraction, grains }) => {
            format!("{grains} of {wanted} grains fit without overlap (fraction {fraction:.4})")
        }
        None => format!("how many of the {wanted} grains would fit was not found either"),
    }
}

impl PackError {
    pub(crate) fn input(
        field: impl Into<String>,
        found: impl ToString,
        allowed: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        let (field, allowed, remedy) = (field.into(), allowed.into(), remedy.into());
        Self::BadInput { field, found: found.to_string(), allowed, remedy }
    }
}
