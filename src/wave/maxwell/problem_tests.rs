//! Hypotheses on tiny grids.
