//! One grain: its shape as a rigid union of balls, its size, volume, orientation, and grains glued together.

pub mod agglomeration;
mod log_normal;
mod name_or_table;
pub mod orientation;
pub mod shape;
pub mod size;
mod size_strata;
pub mod sphere;
pub mod volume;
