//! Maxwell's equations against independent references (validation/data/vector.json: multilayers in 60 digits, hp-FEM,
//! RCWA, vector multipoles), identities and the scalar solver. A tolerance is an identity (rounding or the solver's
//! residual), an order of convergence, or an accuracy that was asked for; each says which.

mod crystals;
mod identities;
mod orders;
mod references;
mod strategies;
mod unions;
