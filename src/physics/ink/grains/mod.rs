//! Grains: shape as a rigid union of balls or a convex body, size, volume, orientation, and
//! agglomerates.

pub mod agglomeration;
mod beads;
pub mod contact;
mod inset;
mod log_normal;
pub mod orientation;
pub mod shape;
pub mod size;
mod size_strata;
pub mod slices;
pub mod solid;
pub mod sphere;
pub mod volume;
