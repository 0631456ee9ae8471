//! What is there: materials, grain shapes, packings and their statistics (no grid, no wave).
//!
//! A [`PackingRequest`] is drawn into rigid bodies (`plan`), which [`pack`] places by random sequential addition
//! (`sequential`) or relaxation of overlaps (`relaxation`) and, if asked, equilibrates (`monte_carlo`). The result
//! passes an all-pairs check that shares no code with them (`overlap`) before it becomes a [`Packing`]; a
//! [`Relief`] may then lower the binder. [`statistics`] and [`output`] only read packings.

pub mod agglomeration;
mod bodies;
mod buckets;
pub mod draws;
pub mod error;
mod fewer;
mod monte_carlo;
mod name_or_table;
mod neighbours;
pub mod orientation;
pub mod output;
mod overlap;
mod pack;
mod pack_study;
pub mod packing;
mod plan;
mod relaxation;
pub mod relief;
pub mod request;
mod sequential;
pub mod shape;
pub mod size;
pub mod spectra;
pub mod statistics;
pub mod vector;
pub mod volume;
pub mod watch;

pub use agglomeration::Agglomeration;
pub use draws::Draws;
pub use error::PackError;
pub use orientation::Orientation;
pub use pack::pack;
pub use pack_study::{LayerTable, PackStudy, PigmentTable};
pub use packing::{Account, Grain, Method, Packing, Share, Sphere};
pub use relief::{Relief, ReliefRequest, ReliefRule};
pub use request::{
    EquilibrationSettings, MethodChoice, PackingRequest, PigmentGrains, RelaxationSettings,
    SequentialSettings, ShareRule,
};
pub use shape::Shape;
pub use size::{Measure, SizeDistribution};
pub use vector::Rotation;
pub use watch::{PackProgress, PackWatch};
