//! The wave solve against identities, theory and layered references; the scattering references are claims 7, 8 and 15
//! in validation/claims. A tolerance is an identity (rounding or the solver's residual), an order of convergence, or an
//! accuracy that was asked for; each says which.

use inkwave_validation::support;

mod edges;
mod identities;
mod layers;
