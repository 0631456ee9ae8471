//! The strategies, one file each.

pub mod bicgstab;
pub mod born;
mod coarse;
pub mod convergent_born;
pub mod direct;
pub mod guided;
pub mod idr;
pub mod krylov;
mod least_squares;
pub mod relaxation;

pub use bicgstab::Bicgstab;
pub use born::Born;
pub use convergent_born::ConvergentBorn;
pub use direct::Direct;
pub use guided::GuidedModes;
pub use idr::Idr;
pub use krylov::Gmres;
pub use relaxation::Relaxation;
