//! Grain shapes, packings and their statistics (no grid, no wave, no picture).
//!
//! A [`PackingRequest`] is turned into rigid bodies of [`grains`], which [`pack`] places
//! ([`packing`]). The result must pass an all-pairs check that shares no code with the placement
//! before it becomes a [`Packing`]; a [`Relief`] may then lower the binder. [`statistics`] only
//! reads packings.

mod error;
pub mod grains;
pub mod packing;
pub(crate) mod relief;
pub mod statistics;

pub use error::{PackError, PackProgress, PackWatch, Reached};
pub use grains::agglomeration::{Agglomeration, CountList, Fractal, GrainCount, Range};
pub use grains::orientation::{AxisField, Orientation};
pub use grains::shape::{Shape, Template};
pub use grains::size::{By, Measure, SizeDistribution};
pub use grains::solid::{Form, Solid};
pub use grains::sphere::Sphere;
pub use packing::grain::{Grain, Layered, VoxelCut};
pub use packing::pack::pack;
pub use packing::placed::{Method, Packing, PackingAccount, Share};
pub use packing::request::{
    EquilibrationSettings, Joint, MethodChoice, PackingRequest, PigmentGrains, RelaxationSettings,
    SequentialSettings, ShareRule, StackedRequest,
};
pub use relief::{Relief, ReliefRequest, ReliefRule, RoughFace};
