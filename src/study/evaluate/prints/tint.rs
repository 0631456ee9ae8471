//! What a print covers: its areas, and the inks on them.

use crate::appearance::halftone::{physical_coverage, spread_share};
use crate::input::measured::MeasuredCondition;
use crate::input::study::{Dots, MixedAreas, MixedPrint};
use serde::Serialize;

/// Micrometres of a centimetre.
const UM_PER_CM: f64 = 1e4;

/// One print.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct PrintedTint {
    /// Light of the instrument, where the paper fluoresces.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub condition: Option<MeasuredCondition>,
    /// Coverage as it was asked for; 0 is bare paper, 1 the solid.
    pub nominal: f64,
    /// Coverage with the physical gain.
    pub coverage: f64,
    /// Share of the light that the paper spreads over all areas alike.
    pub spread: f64,
    /// Nominal coverages of the inks, or of the areas with layers of other runs; empty where this
    /// study's layer is printed alone.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub inks: Vec<InkCoverage>,
    /// Shares of this study's layer, of the layers of other runs, and of bare paper.
    #[serde(skip)]
    pub shares: Vec<f64>,
}

impl PrintedTint {
    /// Share of the area that bears this study's layer.
    pub fn share_of_layer(&self) -> f64 {
        self.shares.first().copied().unwrap_or(self.coverage)
    }
}

/// The nominal coverage of an ink.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct InkCoverage {
    /// Its name in the study.
    pub name: String,
    /// Its coverage, 0 to 1.
    pub coverage: f64,
}

impl PrintedTint {
    /// The tints of one ink between bare paper and its solid, each once, from light to dark.
    pub(super) fn ramp(dots: &Dots) -> Vec<Self> {
        let mut nominal: Vec<f64> = dots.nominal.iter().copied().filter(|c| *c > 0.0 && *c < 1.0).collect();
        nominal.sort_by(f64::total_cmp);
        nominal.dedup();
        let ruling_per_um = dots.ruling_per_cm / UM_PER_CM;
        let tint = |nominal: f64| {
            let coverage = physical_coverage(nominal, dots.physical_gain);
            let spread = spread_share(coverage, ruling_per_um, dots.spread_um);
            Self { nominal, coverage, spread, ..Self::default() }
        };
        nominal.into_iter().map(tint).collect()
    }

    /// The prints of several kinds of area.
    pub(super) fn all_of(dots: &Dots, mixed: &MixedAreas) -> Vec<Self> {
        let print = |(&nominal, print): (&f64, &MixedPrint)| {
            let inks = mixed.names.iter().zip(&print.nominal);
            let coverage: f64 = print.shares.iter().sum();
            let bare = (1.0 - coverage).max(0.0);
            Self {
                condition: None,
                nominal,
                coverage,
                spread: print.spread,
                inks: inks.map(|(name, &coverage)| InkCoverage { name: name.clone(), coverage }).collect(),
                shares: print.shares.iter().copied().chain([bare]).collect(),
            }
        };
        dots.nominal.iter().zip(&mixed.prints).map(print).collect()
    }
}

/// The density of an overprint of solids over the sum of those of its inks.
pub(super) fn additivity(prints: &[PrintedTint], k: usize, density: impl Fn(usize) -> f64) -> f64 {
    let inks = &prints[k].inks;
    let count = inks.iter().filter(|ink| ink.coverage == 1.0).count();
    if count < 2 || inks.iter().any(|ink| ink.coverage != 0.0 && ink.coverage != 1.0) {
        return f64::NAN;
    }
    let mut sum = 0.0;
    for (number, _) in inks.iter().enumerate().filter(|(_, ink)| ink.coverage == 1.0) {
        let is_alone = |print: &PrintedTint| {
            let mut own = print.inks.iter().enumerate();
            !print.inks.is_empty() && own.all(|(i, ink)| ink.coverage == f64::from(i == number))
        };
        match prints.iter().position(is_alone) {
            Some(solid) => sum += density(solid),
            None => return f64::NAN,
        }
    }
    density(k) / sum
}
