//! Statistics of packings, each with a standard error over realisations.

mod ensemble;
mod pairs;
mod sections;
mod single;

pub use ensemble::{StatisticCurve, Statistics, gather};
pub use pairs::{PairStatistics, SampledCentres, pair_statistics, pair_statistics_to};
pub use sections::{SectionStatistics, section_statistics};
pub use single::{OrientationTensor, ReachedSizes, orientation_tensor, profile};
