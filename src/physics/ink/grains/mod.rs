//! Grains: shape as a rigid union of balls or a convex body, size, volume, orientation, and
//! agglomerates.

pub(crate) mod agglomeration;
pub mod contact;
pub(crate) mod orientation;
pub(crate) mod shape;
pub(crate) mod size;
pub(crate) mod solid;
pub(crate) mod sphere;
pub mod volume;
