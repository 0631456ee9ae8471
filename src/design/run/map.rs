//! Surfaces with the film beneath and the verified runs on top, and the search on them.

use super::{DesignError, Verified};
use crate::appearance::colour::ciede2000;
use crate::design::recipe::DesignTask;
use crate::design::surface::{Eye, Spectra3, Surfaces, spectra};
use crate::evaluate::seen::film_alone;
use crate::input::study::Study;
use crate::numerics::Sequence;
use rayon::prelude::*;
use serde::Serialize;

/// Points of the box that a search begins with, for each variable.
const TRIED: usize = 250;
/// Seed of their places.
const SEARCH_SEED: u64 = 2;
/// Share of the box beyond each side whose points are moved to the side.
const EDGE: f64 = 0.05;
/// Best ones that are followed downhill, and halvings of their steps.
const FOLLOWED: usize = 6;
const HALVINGS: usize = 7;
/// Range over which the distance between a run and the surfaces is carried over.
const CARRIED: f64 = 0.3;
/// Recipes of nearly equal colour that are listed, and their least distance in the box.
const LISTED: usize = 6;
const LISTED_APART: f64 = 0.02;

/// Surfaces with the film beneath, and what they answer.
pub(super) struct Map<'a> {
    task: &'a DesignTask,
    eye: Eye,
    surfaces: Surfaces,
    /// Verified recipes: places, and run less surface in L*, a*, b*.
    offsets: Vec<(Vec<f64>, [f64; 3])>,
}

/// A recipe that the surfaces answer.
#[derive(Clone, Debug, Serialize)]
pub struct DesignAnswer {
    /// The recipe in words.
    pub recipe: String,
    /// Value of every variable.
    pub values: Vec<f64>,
    /// ΔE₀₀ to the target by the surfaces.
    pub delta_e_2000: f64,
    /// Contrast ratio by the surfaces.
    pub contrast_ratio: f64,
    #[serde(skip)]
    pub(super) places: Vec<f64>,
}

pub(super) fn study_at(task: &DesignTask, places: &[f64]) -> Result<Study, DesignError> {
    task.study(places).map_err(|faults| DesignError::no_colour(task, places, &faults[0]))
}

/// Spectra of the coherent film of a recipe.
fn film(task: &DesignTask, places: &[f64]) -> Result<Spectra3, DesignError> {
    Ok(spectra(&film_alone(&study_at(task, places)?)?)?)
}

/// Point `r` of a sequence that fills the unit box of `count` dimensions and its sides evenly.
pub(super) fn even_point(seed: u64, count: usize, r: usize) -> Vec<f64> {
    let point = match count {
        1 => Sequence::<1>::new(seed).point(r).to_vec(),
        2 => Sequence::<2>::new(seed).point(r).to_vec(),
        3 => Sequence::<3>::new(seed).point(r).to_vec(),
        4 => Sequence::<4>::new(seed).point(r).to_vec(),
        _ => Sequence::<5>::new(seed).point(r)[..count.min(5)].to_vec(),
    };
    point.into_iter().map(|x| ((1.0 + 2.0 * EDGE) * x - EDGE).clamp(0.0, 1.0)).collect()
}

/// Distance between two points of the box.
pub(super) fn distance(one: &[f64], other: &[f64]) -> f64 {
    one.iter().zip(other).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}

/// Some recipes far from each other, the best one first.
pub(super) fn spread(all: &[DesignAnswer]) -> Vec<DesignAnswer> {
    let mut chosen: Vec<DesignAnswer> = all.iter().take(1).cloned().collect();
    while chosen.len() < LISTED {
        let from_chosen = |a: &DesignAnswer| {
            chosen.iter().map(|c| distance(&a.places, &c.places)).fold(f64::INFINITY, f64::min)
        };
        let apart = all.iter().map(|a| (from_chosen(a), a));
        let farthest = apart.max_by(|a, b| a.0.total_cmp(&b.0)).filter(|(apart, _)| *apart >= LISTED_APART);
        let Some((_, next)) = farthest else { break };
        chosen.push(next.clone());
    }
    chosen
}

impl<'a> Map<'a> {
    /// The surfaces through all runs; those from number `variants` on verified an answer.
    pub fn new(task: &'a DesignTask, data: &[Verified], variants: usize) -> Result<Self, DesignError> {
        let mut differences = Vec::new();
        for run in data {
            let film = film(task, &run.places)?;
            differences.push(run.spectra.iter().zip(&film).map(|(a, b)| a - b).collect());
        }
        let places: Vec<Vec<f64>> = data.iter().map(|run| run.places.clone()).collect();
        let none =
            || DesignError::NoColour(format!("{}: no colour: the surfaces have no solution", task.title));
        let surfaces = Surfaces::new(&places, &differences).ok_or_else(none)?;
        let eye = Eye::new(&study_at(task, &data[0].places)?)?;
        let mut map = Map { task, eye, surfaces, offsets: Vec::new() };
        for run in &data[variants..] {
            let lab = map.surface(&run.places)?.0;
            let offset = std::array::from_fn(|i| run.lab[i] - lab[i]);
            map.offsets.push((run.places.clone(), offset));
        }
        Ok(map)
    }

    /// L*, a*, b* and the contrast ratio by the surfaces alone.
    fn surface(&self, places: &[f64]) -> Result<([f64; 3], f64), DesignError> {
        let parts = film(self.task, places)?.into_iter().zip(self.surfaces.at(places));
        let sum: Vec<f64> = parts.map(|(a, b)| a + b).collect();
        Ok(self.eye.sees(&sum)?)
    }

    /// L*, a*, b* and the contrast ratio by the surfaces and what runs have shown nearby.
    pub fn at(&self, places: &[f64]) -> Result<([f64; 3], f64), DesignError> {
        let (mut lab, contrast) = self.surface(places)?;
        let distances = self.offsets.iter().map(|(own, _)| distance(own, places));
        let near: Vec<f64> = distances.map(|d| (-0.5 * (d / CARRIED).powi(2)).exp()).collect();
        let sum: f64 = near.iter().map(|near| near.powi(4)).sum();
        let most = near.iter().copied().fold(0.0, f64::max);
        for ((_, offset), near) in self.offsets.iter().zip(&near) {
            (0..3).for_each(|i| lab[i] += most * near.powi(4) / sum.max(1e-300) * offset[i]);
        }
        Ok((lab, contrast))
    }

    fn answer(&self, places: Vec<f64>) -> Option<DesignAnswer> {
        let (lab, contrast_ratio) = self.at(&places).ok()?;
        let delta_e_2000 = ciede2000(lab, self.task.lab);
        let recipe = self.task.in_words(&places);
        let values = self.task.values(&places);
        Some(DesignAnswer { recipe, values, delta_e_2000, contrast_ratio, places })
    }

    /// What is to be small: the distance, and what is missing in contrast.
    fn miss(&self, answer: &DesignAnswer) -> f64 {
        self.task.miss(answer.delta_e_2000, answer.contrast_ratio)
    }

    /// Recipes of the box, or of a region of it, the nearest to the target first.
    pub fn search(&self, region: Option<&(Vec<f64>, f64)>) -> Vec<DesignAnswer> {
        let count = self.task.variables.len();
        let bounds: Vec<[f64; 2]> = (0..count)
            .map(|i| region.map_or([0.0, 1.0], |(at, r)| [(at[i] - r).max(0.0), (at[i] + r).min(1.0)]))
            .collect();
        let place = |r: usize| -> Vec<f64> {
            let point = even_point(SEARCH_SEED, count, r);
            bounds.iter().zip(point).map(|([a, b], x)| a + (b - a) * x).collect()
        };
        let tried = (0..TRIED * count).into_par_iter();
        let mut all: Vec<DesignAnswer> = tried.filter_map(|r| self.answer(place(r))).collect();
        all.sort_by(|a, b| self.miss(a).total_cmp(&self.miss(b)));
        let best: Vec<DesignAnswer> = all.iter().take(FOLLOWED).cloned().collect();
        all.extend(best.into_par_iter().map(|start| self.downhill(start, &bounds)).collect::<Vec<_>>());
        all.sort_by(|a, b| self.miss(a).total_cmp(&self.miss(b)));
        all
    }

    /// Follows a recipe downhill along the variables.
    fn downhill(&self, mut here: DesignAnswer, bounds: &[[f64; 2]]) -> DesignAnswer {
        let mut step = 0.1;
        for _ in 0..HALVINGS {
            loop {
                let moves = (0..bounds.len()).flat_map(|i| [(i, step), (i, -step)]);
                let best = moves
                    .filter_map(|(i, by)| {
                        let mut places = here.places.clone();
                        places[i] = (places[i] + by).clamp(bounds[i][0], bounds[i][1]);
                        self.answer(places)
                    })
                    .min_by(|a, b| self.miss(a).total_cmp(&self.miss(b)));
                match best {
                    Some(best) if self.miss(&best) < self.miss(&here) - 1e-4 => here = best,
                    _ => break,
                }
            }
            step *= 0.5;
        }
        here
    }

    /// Median ΔE₀₀ between variants and the surfaces without them.
    pub fn leave_one_out(&self, data: &[Verified]) -> Result<f64, DesignError> {
        let mut all = Vec::new();
        for (i, run) in data.iter().enumerate() {
            let left = &self.surfaces.left_out[i];
            let without: Vec<f64> = run.spectra.iter().zip(left).map(|(own, e)| own + e).collect();
            all.push(ciede2000(self.eye.sees(&without)?.0, self.eye.sees(&run.spectra)?.0));
        }
        all.sort_by(f64::total_cmp);
        Ok(all[all.len() / 2])
    }
}

#[cfg(test)]
#[path = "map_tests.rs"]
pub(super) mod tests;
