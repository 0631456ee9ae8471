//! Agglomerates: grains glued into one rigid body before the packing starts.

mod fractal;

pub use fractal::Fractal;

use crate::ink::{PackError, Sphere};
use crate::numerics::Draws;
use crate::numerics::allowed::{Allowed, Each, Whole};
use crate::numerics::vector::{Rotation, V3, add, dot, norm, scale, sub};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Fraction of grains in agglomerates.
const DEGREE: Allowed = Allowed::between(0.0, 1.0, "");
/// Grains per agglomerate.
const GRAINS: Whole = Whole::between(2, 500);

/// Which grains stick together.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Agglomeration {
    /// Share of the pigment's grains (by number) that sit in agglomerates, 0 to 1.
    #[schemars(transform = DEGREE.mark(), example = 0.8)]
    pub degree: f64,
    /// How many grains stick together.
    #[schemars(example = 5)]
    pub grains: GrainCount,
    /// Makes them fractal clusters, such as carbon black's: without it grains fly in one by one,
    /// which gives dense ones.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(example = Fractal { dimension: 1.78, prefactor: 1.3 })]
    pub fractal: Option<Fractal>,
}

/// Number of grains in one agglomerate. A last, incomplete agglomerate keeps the grains that are
/// left.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "a whole number, { from = …, to = … } or { values = […], weights = […] }, in whole numbers from 2"
)]
pub enum GrainCount {
    /// `grains = 5`
    Constant(#[schemars(transform = GRAINS.mark())] usize),
    /// `grains = { from = 2, to = 6 }`: each number equally likely.
    Uniform(Range),
    /// `grains = { values = [2, 3, 8], weights = [5, 3, 1] }`
    List(CountList),
}

/// Whole numbers from `from` to `to`, both included.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "GrainRange")]
pub struct Range {
    /// Smallest number of grains, at least 2.
    #[schemars(transform = GRAINS.mark(), example = 2)]
    pub from: usize,
    /// Largest number of grains, at most 500.
    #[schemars(transform = GRAINS.mark(), example = 6)]
    pub to: usize,
}

/// Numbers of grains with the frequencies of agglomerates of each.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CountList {
    /// Numbers of grains, 2 to 500 each.
    #[schemars(transform = Each { entry: GRAINS, most: 500 }, example = (2, 3, 8))]
    pub values: Vec<usize>,
    /// Frequency of each number, at least 0; the weights are normalised.
    #[schemars(inner(range(min = 0)), example = (5, 3, 1))]
    pub weights: Vec<f64>,
}

impl Agglomeration {
    /// The first invalid number, if any: field, value found, allowed range.
    pub fn defect(&self) -> Option<(&'static str, String, &'static str)> {
        if !DEGREE.holds(self.degree) {
            return Some(("agglomeration.degree", self.degree.to_string(), "0 to 1"));
        }
        let allowed = "2 to 500 grains; weights of at least 0, one per value, with a sum above 0";
        let fits = |n: usize| GRAINS.holds(n);
        let sound = match &self.grains {
            GrainCount::Constant(n) => fits(*n),
            GrainCount::Uniform(r) => fits(r.from) && fits(r.to) && r.from <= r.to,
            GrainCount::List(list) => {
                let weights = &list.weights;
                weights.len() == list.values.len()
                    && list.values.iter().all(|n| fits(*n))
                    && weights.iter().all(|w| w.is_finite() && *w >= 0.0)
                    && weights.iter().sum::<f64>() > 0.0
            }
        };
        let wrong = (!sound).then(|| ("agglomeration.grains", format!("{:?}", self.grains), allowed));
        wrong.or_else(|| self.fractal?.defect())
    }

    /// Mean number of grains of a body, weighted by volume; single grains count.
    pub(crate) fn mean_body(&self) -> f64 {
        let together = match &self.grains {
            GrainCount::Constant(n) => *n as f64,
            GrainCount::Uniform(r) => weighted_mean((r.from..=r.to).map(|n| (n, 1.0))),
            GrainCount::List(list) => {
                weighted_mean(list.values.iter().copied().zip(list.weights.iter().copied()))
            }
        };
        1.0 + self.degree * (together - 1.0)
    }

    pub(crate) fn draw_count(&self, draws: &mut Draws) -> usize {
        match &self.grains {
            GrainCount::Constant(n) => *n,
            GrainCount::Uniform(r) => r.from + draws.below(r.to - r.from + 1),
            GrainCount::List(list) => {
                let mut left = draws.uniform() * list.weights.iter().sum::<f64>();
                let hit = list.weights.iter().position(|w| {
                    left -= w;
                    left < 0.0
                });
                list.values[hit.unwrap_or(list.values.len() - 1)]
            }
        }
    }
}

/// Mean of numbers n, each weighted by n and its own weight.
fn weighted_mean(numbers: impl Iterator<Item = (usize, f64)>) -> f64 {
    let add = |(sum, squares): (f64, f64), (n, weight): (usize, f64)| {
        (sum + weight * n as f64, squares + weight * (n * n) as f64)
    };
    let (sum, squares) = numbers.fold((0.0, 0.0), add);
    squares / sum
}

/// One grain of an agglomerate, in the agglomerate's frame.
#[derive(Clone, Debug)]
pub(crate) struct PlacedGrain {
    pub spheres: Vec<Sphere>,
    pub axis: V3,
}

/// Surfaces of glued grains stay this fraction of the smaller radius apart, so that rounding after
/// a rotation cannot make them overlap.
const GLUE_GAP: f64 = 1e-6;

/// Ballistic aggregation: each grain, randomly rotated, flies in from a random direction along a
/// line through the bounding sphere of the aggregate until it touches.
pub(crate) fn glue(grains: &[Vec<Sphere>], draws: &mut Draws) -> Vec<PlacedGrain> {
    let mut placed: Vec<PlacedGrain> = Vec::with_capacity(grains.len());
    for grain in grains {
        let PlacedGrain { spheres, axis } = placed_first(grain, draws);
        let shift = if placed.is_empty() { [0.0; 3] } else { landing(&placed, &spheres, draws) };
        let spheres = spheres.iter().map(|s| Sphere { center_um: add(s.center_um, shift), ..*s }).collect();
        placed.push(PlacedGrain { spheres, axis });
    }
    placed
}

/// A grain alone, randomly rotated.
pub(super) fn placed_first(grain: &[Sphere], draws: &mut Draws) -> PlacedGrain {
    let axis = draws.direction();
    let turn = draws.rotation_with_axis(axis);
    PlacedGrain { spheres: turned(grain, turn), axis: turn.turn([0.0, 0.0, 1.0]) }
}

fn turned(grain: &[Sphere], turn: Rotation) -> Vec<Sphere> {
    grain.iter().map(|s| Sphere { center_um: turn.turn(s.center_um), ..*s }).collect()
}

/// Displacement that brings the incoming grain into first contact.
fn landing(placed: &[PlacedGrain], incoming: &[Sphere], draws: &mut Draws) -> V3 {
    let there: Vec<Sphere> = placed.iter().flat_map(|p| p.spheres.iter().copied()).collect();
    let centre = centre_of(&there);
    loop {
        let target = there[draws.below(there.len())];
        let from = draws.direction();
        // The flight is directed at the centre of a sphere of the aggregate.
        let aim = sub(target.center_um, centre_of(incoming));
        let start =
            add(aim, scale(from, 2.0 * span(&there, centre) + 2.0 * span(incoming, centre_of(incoming))));
        if let Some(path) = first_contact(&there, incoming, start, from) {
            return sub(start, scale(from, path));
        }
    }
}

fn centre_of(spheres: &[Sphere]) -> V3 {
    let sum = spheres.iter().fold([0.0; 3], |c, s| add(c, s.center_um));
    scale(sum, 1.0 / spheres.len() as f64)
}

fn span(spheres: &[Sphere], centre: V3) -> f64 {
    spheres.iter().map(|s| norm(sub(s.center_um, centre)) + s.radius_um).fold(0.0, f64::max)
}

/// Length of the flight along −from until a pair of spheres is `GLUE_GAP` short of touching.
pub(super) fn first_contact(there: &[Sphere], incoming: &[Sphere], start: V3, from: V3) -> Option<f64> {
    let mut shortest: Option<f64> = None;
    for a in there {
        for b in incoming {
            let reach = a.radius_um + b.radius_um + GLUE_GAP * a.radius_um.min(b.radius_um);
            let offset = sub(add(b.center_um, start), a.center_um);
            let along = dot(offset, from);
            let miss2 = dot(offset, offset) - along * along;
            if miss2 < reach * reach {
                let path = along - (reach * reach - miss2).sqrt();
                shortest = Some(shortest.map_or(path, |s: f64| s.min(path)));
            }
        }
    }
    shortest
}

/// The error for agglomerates that are too large in every draw.
pub(crate) fn too_large(pigment: usize, grains: usize, extent_um: f64, limit_um: f64) -> PackError {
    PackError::input(
        format!("pigment[{pigment}].agglomeration.grains"),
        format!("{grains} grains, {extent_um:.3} µm across in the best of many draws"),
        format!("agglomerates at most {limit_um:.3} µm across"),
        "take fewer or smaller grains per agglomerate, or a larger cell",
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ink::Shape;

    #[test]
    fn glued_grains_touch_but_do_not_overlap() {
        let mut draws = Draws::new(5, 0);
        for shape in [Shape::Sphere, Shape::CYLINDER] {
            let grain = shape.template().spheres;
            let glued = glue(&vec![grain; 8], &mut draws);
            for (i, a) in glued.iter().enumerate().skip(1) {
                let gaps = glued[..i]
                    .iter()
                    .flat_map(|b| a.spheres.iter().flat_map(|s| b.spheres.iter().map(move |t| s.gap_to(t))));
                let closest = gaps.fold(f64::MAX, f64::min);
                // Identity: the glue gap of unit radii, with the rounding of a root of numbers
                // below 100.
                assert!((closest - GLUE_GAP).abs() < 1e-9, "{closest}");
            }
        }
    }
}
