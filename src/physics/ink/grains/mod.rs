//! Grains: shape as a rigid union of balls or a convex body, size, volume, orientation, and
//! agglomerates.

pub mod agglomeration;
pub mod contact;
pub mod orientation;
pub mod shape;
pub mod size;
pub mod solid;
pub mod sphere;
pub mod volume;
