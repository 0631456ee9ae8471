//! Statistics of packings (G9), each with a standard error over realisations.

mod ensemble;
mod orientation;
mod pairs;
mod profile;
mod reached;
mod sections;

pub use ensemble::{StatisticCurve, Statistics, gather};
pub use orientation::{OrientationTensor, orientation_tensor};
pub use pairs::{PairStatistics, pair_statistics, pair_statistics_to};
pub use profile::profile;
pub use reached::ReachedSizes;
pub use sections::{SectionStatistics, section_statistics};
