//! The strategies.

pub mod bicgstab;
pub mod born;
mod coarse;
pub mod direct;
pub mod guided;
pub mod idr;
pub mod krylov;
pub mod relaxation;

pub use bicgstab::Bicgstab;
pub use born::{Born, ConvergentBorn};
pub use direct::Direct;
pub use guided::GuidedModes;
pub use idr::Idr;
pub use krylov::Gmres;
pub use relaxation::Relaxation;
