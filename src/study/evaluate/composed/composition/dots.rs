//! The dots of a composition: kinds of area with their layers and shares.

use super::{CompositionLayer, UM_PER_CM};
use crate::appearance::halftone::{demichel, mean_spread_share, spread_share};
use crate::appearance::paper_series::AreaMix;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Most layers with a coverage of their own: every overprint of them is composed.
const MOST_INKS: usize = 6;

/// Dots of a composition: of the whole stack, or of the layers that have a coverage of their own.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CompositionDots {
    /// Share of the area that the whole stack covers, 0 to 1, one number; the rest is bare paper.
    /// Left out where layers have a `coverage` of their own: one of both must be given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub coverage: Option<f64>,
    /// Ruling of the screen, dots per cm, 1 to 1000; 60 is usual (150 lpi).
    pub ruling_per_cm: f64,
    /// Length over which the paper spreads light, µm, 0 to 10000; coated papers have 20 to 60.
    pub spread_um: f64,
}

/// What a print in dots consists of.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct KindsOfArea {
    /// Numbers of the layers on every kind of area, in the order of the light. None of bare paper.
    /// The first kind has the fewest, the last one all.
    pub kinds: Vec<Vec<usize>>,
    /// Their shares, and how far the paper spreads light between them.
    pub mix: AreaMix,
    /// Number of coverages.
    pub inks: usize,
}

impl KindsOfArea {
    /// Share of the area that bears any layer.
    pub(super) fn inked(&self) -> f64 {
        let borne = self.kinds.iter().zip(&self.mix.shares).filter(|(layers, _)| !layers.is_empty());
        borne.map(|(_, share)| share).sum()
    }
}

impl CompositionDots {
    /// The kinds of area of a print of these layers.
    ///
    /// # Errors
    /// Coverages, rulings and lengths that there are not; coverages of the whole and of layers.
    pub(super) fn areas(&self, layers: &[CompositionLayer]) -> Result<KindsOfArea, String> {
        let judge = |field: &str, value: f64, from: f64, to: f64| {
            let share = if to == 1.0 { ": write a share, such as 0.6 for 60 %" } else { "" };
            let words = format!("{field}: found {value}; allowed {from} to {to}{share}");
            (from..=to).contains(&value).then_some(()).ok_or(words)
        };
        judge("dots.ruling_per_cm", self.ruling_per_cm, 1.0, 1000.0)?;
        judge("dots.spread_um", self.spread_um, 0.0, 10_000.0)?;
        let ruling_per_um = self.ruling_per_cm / UM_PER_CM;
        let mut inks = Vec::new();
        for (number, layer) in layers.iter().enumerate() {
            let Some(coverage) = layer.coverage else { continue };
            judge(&format!("layers[{number}].coverage"), coverage, 0.0, 1.0)?;
            inks.push((number, coverage));
        }
        if let Some(coverage) = self.coverage {
            judge("dots.coverage", coverage, 0.0, 1.0)?;
            if let Some((number, _)) = inks.first() {
                return Err(format!(
                    "dots.coverage: found one beside layers[{number}].coverage; allowed is that of the stack or those of its layers: \
                     remove one of them"
                ));
            }
            let spread = spread_share(coverage, ruling_per_um, self.spread_um);
            return Ok(KindsOfArea {
                kinds: vec![Vec::new(), (0..layers.len()).collect()],
                mix: AreaMix { shares: vec![1.0 - coverage, coverage], spread },
                inks: 1,
            });
        }
        if inks.is_empty() || inks.len() > MOST_INKS {
            return Err(format!(
                "dots.coverage: found {} coverages; allowed is that of the stack, or layers[…].coverage of 1 to {MOST_INKS} layers",
                inks.len()
            ));
        }
        let coverages: Vec<f64> = inks.iter().map(|(_, coverage)| *coverage).collect();
        let kind = |set: usize| -> Vec<usize> {
            let bears = |layer: &usize| {
                let ink = inks.iter().position(|(number, _)| number == layer);
                ink.is_none_or(|ink| set >> ink & 1 == 1)
            };
            (0..layers.len()).filter(bears).collect()
        };
        let shares = demichel(&coverages);
        Ok(KindsOfArea {
            kinds: (0..shares.len()).map(kind).collect(),
            mix: AreaMix { shares, spread: mean_spread_share(&coverages, ruling_per_um, self.spread_um) },
            inks: inks.len(),
        })
    }
}
