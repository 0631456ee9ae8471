//! The wave solve against independent references, identities and theory. A tolerance is an identity (rounding
//! or the solver's residual), an order of convergence, or an accuracy that was asked for; each says which.

#[path = "../support/mod.rs"]
mod support;

mod accuracy;
mod convergence;
mod edges;
mod identities;
mod layers;
