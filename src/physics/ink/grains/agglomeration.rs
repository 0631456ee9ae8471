//! Agglomerates: grains glued into one rigid body before the packing starts.

mod fractal;

pub use fractal::Fractal;

use super::contact::{contact, proven_gap_um};
use super::solid::Solid;
use super::sphere::{Sphere, centre_of_mass, reach_um};
#[cfg(feature = "schema")]
use crate::numerics::allowed::Each;
use crate::numerics::allowed::{Allowed, Whole};
use crate::numerics::vector::{Rotation, V3, add, dot, norm, scale, sub};
use crate::numerics::{Draws, are_weights, weighted};
use std::iter;

/// Fraction of grains in agglomerates.
const DEGREE: Allowed = Allowed::between(0.0, 1.0, "");
/// Grains per agglomerate.
const GRAINS: Whole = Whole::between(2, 500);

/// Which grains stick together.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Agglomeration {
    /// Share of the pigment's grains (by number) that sit in agglomerates, 0 to 1.
    #[cfg_attr(feature = "schema", schemars(transform = DEGREE.mark(), example = 0.8))]
    pub degree: f64,
    /// How many grains stick together.
    #[cfg_attr(feature = "schema", schemars(example = 5))]
    pub grains: GrainCount,
    /// Makes them fractal clusters, such as carbon black's (of spheres only): without it grains fly
    /// in one by one, which gives dense ones.
    #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "Option::is_none"))]
    #[cfg_attr(feature = "schema", schemars(example = Fractal { dimension: 1.78, prefactor: 1.3 }))]
    pub fractal: Option<Fractal>,
}

/// Number of grains in one agglomerate. A last, incomplete agglomerate keeps the grains that are
/// left.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(
        untagged,
        expecting = "a whole number, { from = …, to = … } or { values = […], weights = […] }, in whole numbers from 2"
    )
)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum GrainCount {
    /// `grains = 5`
    Constant(#[cfg_attr(feature = "schema", schemars(transform = GRAINS.mark()))] usize),
    /// `grains = { from = 2, to = 6 }`: each number equally likely.
    Uniform(Range),
    /// `grains = { values = [2, 3, 8], weights = [5, 3, 1] }`
    List(CountList),
}

impl GrainCount {
    /// The numbers as a file writes them.
    fn in_words(&self) -> String {
        match self {
            Self::Constant(n) => n.to_string(),
            Self::Uniform(Range { from, to }) => format!("from {from} to {to}"),
            Self::List(CountList { values, weights }) => {
                format!("values {values:?} with weights {weights:?}")
            }
        }
    }
}

/// Whole numbers from `from` to `to`, both included.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema), schemars(rename = "GrainRange"))]
pub struct Range {
    /// Smallest number of grains, at least 2.
    #[cfg_attr(feature = "schema", schemars(transform = GRAINS.mark(), example = 2))]
    pub from: usize,
    /// Largest number of grains, at most 500.
    #[cfg_attr(feature = "schema", schemars(transform = GRAINS.mark(), example = 6))]
    pub to: usize,
}

/// Numbers of grains with the frequencies of agglomerates of each.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct CountList {
    /// Numbers of grains, 2 to 500 each.
    #[cfg_attr(feature = "schema", schemars(transform = Each { entry: GRAINS, most: 500 }, example = (2, 3, 8)))]
    pub values: Vec<usize>,
    /// Frequency of each number, at least 0; the weights are normalised.
    #[cfg_attr(feature = "schema", schemars(inner(range(min = 0)), example = (5, 3, 1)))]
    pub weights: Vec<f64>,
}

impl Agglomeration {
    /// The first invalid number, if any: field, value found, allowed range.
    pub fn defect(&self) -> Option<(&'static str, String, &'static str)> {
        if !DEGREE.holds(self.degree) {
            return Some(("agglomeration.degree", self.degree.to_string(), "0 to 1"));
        }
        let allowed = "2 to 500 grains; weights of at least 0, one per value, with a sum above 0";
        let sound = match &self.grains {
            GrainCount::Constant(n) => GRAINS.holds(*n),
            GrainCount::Uniform(Range { from, to }) => GRAINS.holds(*from) && GRAINS.holds(*to) && from <= to,
            GrainCount::List(CountList { values, weights }) => {
                let fit = weights.len() == values.len() && values.iter().all(|n| GRAINS.holds(*n));
                fit && are_weights(weights)
            }
        };
        let wrong = (!sound).then(|| ("agglomeration.grains", self.grains.in_words(), allowed));
        wrong.or_else(|| self.fractal?.defect())
    }

    /// Mean number of grains of a body, weighted by volume; single grains count.
    pub(crate) fn mean_body(&self) -> f64 {
        let together = match &self.grains {
            GrainCount::Constant(n) => *n as f64,
            GrainCount::Uniform(r) => weighted_mean((r.from..=r.to).map(|n| (n, 1.0))),
            GrainCount::List(list) => weighted_mean(iter::zip(list.values.clone(), list.weights.clone())),
        };
        1.0 + self.degree * (together - 1.0)
    }

    pub(crate) fn draw_count(&self, draws: &mut Draws) -> usize {
        match &self.grains {
            GrainCount::Constant(n) => *n,
            GrainCount::Uniform(r) => r.from + draws.below(r.to - r.from + 1),
            GrainCount::List(list) => weighted(&list.values, &list.weights, draws.uniform()),
        }
    }
}

/// Mean of numbers n, each weighted by n and its own weight.
fn weighted_mean(numbers: impl Iterator<Item = (usize, f64)>) -> f64 {
    let sums = numbers.fold([0.0; 2], |[sum, squares], (n, weight)| {
        [sum + weight * n as f64, squares + weight * (n * n) as f64]
    });
    sums[1] / sums[0]
}

/// One grain of an agglomerate, in the agglomerate's frame.
#[derive(Clone, Debug)]
pub(crate) struct PlacedGrain {
    /// Its spheres, or the one around a convex body.
    pub spheres: Vec<Sphere>,
    /// The convex body, if it is one; about its sphere's centre.
    pub solid: Option<Solid>,
    pub axis: V3,
    pub volume_um3: f64,
}

impl PlacedGrain {
    fn surfaces(&self) -> impl Iterator<Item = GrainSurface<'_>> {
        self.spheres.iter().map(|sphere| GrainSurface { sphere, solid: self.solid.as_ref() })
    }

    fn turned(&self, turn: Rotation) -> Self {
        let spheres = self.spheres.iter().map(|s| Sphere { center_um: turn.turn(s.center_um), ..*s });
        let solid = self.solid.clone().map(|s| Solid { rotation: s.rotation.then(turn), ..s });
        Self { spheres: spheres.collect(), solid, axis: turn.turn(self.axis), ..*self }
    }

    fn moved(mut self, by: V3) -> Self {
        self.spheres.iter_mut().for_each(|s| s.center_um = add(s.center_um, by));
        self
    }

    /// A distance that this convex body and another surely have, µm; none between spheres.
    fn proven_gap_um(&self, other: &Self) -> Option<f64> {
        let one = self.solid.as_ref()?;
        let two = other.solid.as_ref()?;
        Some(proven_gap_um(one, two, sub(other.spheres[0].center_um, self.spheres[0].center_um)))
    }
}

/// Surfaces of glued grains stay this fraction of the smaller radius apart, so that rounding after
/// a rotation cannot make them overlap.
const GLUE_GAP: f64 = 1e-6;

/// Convex bodies stay this fraction of the thinner one's radius apart: the proof of their
/// separation finds its direction by iteration.
const CONVEX_GAP: f64 = 1e-5;

impl Agglomeration {
    /// Glues grains into one agglomerate about its centre of mass.
    pub(crate) fn join(&self, grains: &[PlacedGrain], draws: &mut Draws) -> Vec<PlacedGrain> {
        about_centre(match self.fractal {
            Some(law) => law.aggregate(grains, draws),
            None => glue(grains, draws),
        })
    }
}

/// Ballistic aggregation: each grain, randomly rotated, flies in from a random direction along a
/// line through the bounding sphere of the aggregate until it touches.
fn glue(grains: &[PlacedGrain], draws: &mut Draws) -> Vec<PlacedGrain> {
    let mut placed: Vec<PlacedGrain> = Vec::with_capacity(grains.len());
    for grain in grains {
        let first = grain.turned(draws.rotation());
        placed.push(if placed.is_empty() { first } else { landed(&placed, first, draws) });
    }
    placed
}

/// Flights tried for one grain. Most hit: each is directed at a sphere of the aggregate, and only
/// grains with gaps at their centre, or convex bodies whose distance is not proven, need a second.
const MOST_FLIGHTS: usize = 10_000;

/// The incoming grain in first contact; where no flight hits, the spheres around the grain and the
/// aggregate touch instead.
fn landed(placed: &[PlacedGrain], grain: PlacedGrain, draws: &mut Draws) -> PlacedGrain {
    let there = all_spheres(placed);
    let incoming = &grain.spheres;
    let centre = centre_of(&there);
    for _ in 0..MOST_FLIGHTS {
        let target = there[draws.below(there.len())];
        let from = draws.direction();
        // The flight is directed at the centre of a sphere of the aggregate.
        let aim = sub(target.center_um, centre_of(incoming));
        let far = 2.0 * reach_um(&there, centre) + 2.0 * reach_um(incoming, centre_of(incoming));
        let start = add(aim, scale(from, far));
        if let Some(path) = first_contact(placed, &grain, start, from) {
            let landed = grain.clone().moved(sub(start, scale(from, path)));
            if placed.iter().all(|p| p.proven_gap_um(&landed).is_none_or(|gap| gap > 0.0)) {
                return landed;
            }
        }
    }
    let from = draws.direction();
    let grain_centre = centre_of(incoming);
    let apart = (reach_um(&there, centre) + reach_um(incoming, grain_centre)) * (1.0 + CONVEX_GAP);
    grain.moved(sub(add(centre, scale(from, apart)), grain_centre))
}

fn all_spheres(grains: &[PlacedGrain]) -> Vec<Sphere> {
    grains.iter().flat_map(|g| g.spheres.iter().copied()).collect()
}

fn centre_of(spheres: &[Sphere]) -> V3 {
    let sum = spheres.iter().fold([0.0; 3], |c, s| add(c, s.center_um));
    scale(sum, 1.0 / spheres.len() as f64)
}

fn about_centre(grains: Vec<PlacedGrain>) -> Vec<PlacedGrain> {
    let back = scale(centre_of_mass(&all_spheres(&grains)), -1.0);
    grains.into_iter().map(|g| g.moved(back)).collect()
}

/// A sphere of a grain, and the convex body that it is around.
#[derive(Clone, Copy)]
struct GrainSurface<'a> {
    sphere: &'a Sphere,
    solid: Option<&'a Solid>,
}

/// Length of a grain's flight along −from until it is the gap of the glue short of touching one of
/// those there.
fn first_contact(there: &[PlacedGrain], incoming: &PlacedGrain, start: V3, from: V3) -> Option<f64> {
    let surfaces = there.iter().flat_map(PlacedGrain::surfaces);
    let pairs = surfaces.flat_map(|a| incoming.surfaces().map(move |b| (a, b)));
    pairs.filter_map(|(there, flying)| path_of(there, flying, start, from)).reduce(f64::min)
}

/// Length of a surface's flight, which starts at `start` from its place.
fn path_of(there: GrainSurface, flying: GrainSurface, start: V3, from: V3) -> Option<f64> {
    let a = there.sphere;
    let b = flying.sphere;
    let reach = a.radius_um + b.radius_um + GLUE_GAP * a.radius_um.min(b.radius_um);
    let offset = sub(add(b.center_um, start), a.center_um);
    let along = dot(offset, from);
    let miss2 = dot(offset, offset) - along * along;
    let path = (miss2 < reach * reach).then(|| along - (reach * reach - miss2).sqrt())?;
    let Some((body, other)) = there.solid.zip(flying.solid) else { return Some(path) };
    Some(path + path_of_solids(body, other, sub(offset, scale(from, path)), from)?)
}

/// Newton's steps to a contact: two between faces, some ten between round surfaces.
const STEPS: usize = 100;

/// Length of the flight of a convex body. The distance of two is a convex function of the path, so
/// that steps along its tangent never lead beyond the contact; they end if it grows again.
fn path_of_solids(a: &Solid, b: &Solid, offset: V3, from: V3) -> Option<f64> {
    let gap = CONVEX_GAP * a.form.thin_um().min(b.form.thin_um());
    let mut path = 0.0;
    for _ in 0..STEPS {
        let apart = sub(offset, scale(from, path));
        let nearest = contact(a, b, apart, norm(offset))?;
        let left = nearest.gap_um - gap;
        let rate = dot(nearest.normal, from);
        if left < 0.01 * gap {
            return Some(path);
        }
        if rate <= 0.0 {
            return None;
        }
        path += left / rate;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ink::Shape;

    #[test]
    fn glued_grains_touch_but_do_not_overlap() {
        let mut draws = Draws::new(5, 0);
        for shape in [Shape::Sphere, Shape::CYLINDER] {
            let grain = shape.template().grain(1.0);
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

    /// *Planted*: a flight that ends at the spheres around the bodies, or a thousandth of their
    /// thickness short of the contact.
    #[test]
    fn glued_bodies_touch_but_do_not_overlap() {
        let mut draws = Draws::new(6, 0);
        let corners = vec![[0.0, 0.0], [2.0, 0.0], [2.5, 1.0], [1.0, 1.8]];
        for shape in [
            Shape::Ellipsoid { axes: [1.0, 1.5, 2.5] },
            Shape::Ellipsoid { axes: [1.0, 1.0, 1.0] },
            Shape::Box { edges: [1.0, 1.5, 0.6] },
            Shape::Disc { diameter: 3.0, thickness: 1.0 },
            Shape::Disc { diameter: 50.0, thickness: 1.0 },
            Shape::Prism { corners, length: 1.0 },
        ] {
            let grain = shape.template().grain(1.0);
            let thin = grain.solid.as_ref().expect("a convex body").form.thin_um();
            for _ in 0..4 {
                let glued = glue(&vec![grain.clone(); 8], &mut draws);
                for (i, a) in glued.iter().enumerate().skip(1) {
                    let gaps = glued[..i].iter().map(|b| a.proven_gap_um(b).expect("two bodies"));
                    let closest = gaps.fold(f64::MAX, f64::min);
                    // Residual of the flight, and of the direction by which the gap is proven.
                    let touching = 0.0..1.1 * CONVEX_GAP * thin;
                    assert!(touching.contains(&closest), "{}: {}", shape.name(), closest / thin);
                }
            }
        }
    }
}
