//! Surfaces with the film beneath and the verified runs on top, and the search on them.
//!
//! Surfaces are polynomials over the interpolated axes. At every place of the composed axes there
//! are others, through spectra that are composed there of the solves of all runs.

use super::film::FilmResponse;
use super::interpolated::Interpolated;
use super::solved::Composable;
use super::{DesignError, Verified, study_at};
use crate::appearance::colour::ciede2000;
use crate::design::recipe::DesignTask;
use crate::design::surface::{Eye, Spectra3, Surfaces};
use crate::design::wish::NumberWish;
use crate::numerics::Sequence;
use crate::run::RunError;
use crate::run::watch::RunWatch;
use rayon::prelude::*;
use serde::Serialize;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

/// Points of the box that a search begins with, for each variable.
const TRIED: usize = 250;
/// Seed of their places.
const SEARCH_SEED: u64 = 2;
/// Share of the box beyond each side whose points are moved to the side.
const EDGE: f64 = 0.05;
/// Best ones that are followed downhill, and halvings of their steps.
const FOLLOWED: usize = 6;
const HALVINGS: usize = 7;
/// Their first step on an interpolated axis and on a composed one. Places on composed axes are
/// multiples of a power of a half, so that few of them are composed.
const STEP: f64 = 0.1;
const COMPOSED_STEP: f64 = 0.125;
/// Places of a composed axis that a search begins with, less one.
const COMPOSED_TRIED: f64 = 32.0;
/// Range over which the distance between a run and the surfaces is carried over.
const CARRIED: f64 = 0.3;
/// Recipes of nearly equal colour that are listed, and their least distance in the box.
const LISTED: usize = 6;
const LISTED_APART: f64 = 0.02;

/// What surfaces are made of.
#[derive(Clone, Copy)]
pub(super) struct Ground<'a> {
    pub task: &'a DesignTask,
    pub watch: &'a dyn RunWatch,
    pub interpolated: Interpolated,
}

/// A run that the surfaces rest on.
struct Support {
    places: Vec<f64>,
    spectra: Spectra3,
    solved: Option<Arc<Composable>>,
}

/// Surfaces with the film beneath, and what they answer.
pub(super) struct Map<'a> {
    ground: Ground<'a>,
    task: &'a DesignTask,
    eye: Eye,
    film: FilmResponse<'a>,
    runs: Vec<Support>,
    /// By the places of the composed axes.
    known: Mutex<HashMap<Vec<u64>, Arc<Surfaces>>>,
    /// Verified recipes: places, and run less surface in L*, a*, b*, and in the numbers.
    offsets: Vec<(Vec<f64>, [f64; 3], Vec<f64>)>,
    /// The wishes that a search aims at: ranges less what the surfaces and a run may be wrong by.
    aims: Vec<NumberWish>,
}

/// What a recipe looks like, and its numbers in the order of the wishes.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Looks {
    /// L*, a*, b* over the paper.
    pub lab: [f64; 3],
    /// Y over black divided by Y over white.
    pub contrast_ratio: f64,
    /// The numbers.
    pub numbers: Vec<f64>,
}

/// A recipe that the surfaces answer.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DesignAnswer {
    /// The recipe in words.
    pub recipe: String,
    /// Value of every variable.
    pub values: Vec<f64>,
    /// ΔE₀₀ to the target by the surfaces, where a colour is wanted.
    pub delta_e_2000: Option<f64>,
    /// Contrast ratio by the surfaces.
    pub contrast_ratio: f64,
    /// Numbers that are wanted, by the surfaces, in the order of the wishes.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub numbers: Vec<f64>,
    #[serde(skip)]
    pub(super) places: Vec<f64>,
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
    pub fn new(ground: Ground<'a>, data: &[Verified], variants: usize) -> Result<Self, DesignError> {
        let task = ground.task;
        let film = FilmResponse::new(task, &data[0].places)?;
        let support = |run: &Verified| Support {
            places: run.places.clone(),
            spectra: run.spectra.clone(),
            solved: run.solved.clone(),
        };
        let runs = data.iter().map(support).collect();
        let eye = Eye::new(&study_at(task, &data[0].places)?)?;
        let (known, offsets, aims) = (Mutex::default(), Vec::new(), task.numbers.clone());
        let mut map = Map { ground, task, eye, film, runs, known, offsets, aims };
        map.surfaces(&data[0].places)?;
        let errors = map.number_errors(data);
        map.aims = task.numbers.iter().zip(&errors).map(|(wish, error)| wish.narrowed(2.0 * error)).collect();
        for run in &data[variants..] {
            let Looks { lab, numbers, .. } = map.surface(&run.places)?;
            let offset = std::array::from_fn(|i| run.lab[i] - lab[i]);
            let of_numbers =
                run.numbers.iter().zip(&numbers).map(|(run, here)| run.estimate.value - here).collect();
            map.offsets.push((run.places.clone(), offset, of_numbers));
        }
        Ok(map)
    }

    /// What the surfaces interpolate.
    pub fn interpolated(&self) -> Interpolated {
        self.ground.interpolated
    }

    /// The surfaces at a recipe's places of the composed axes.
    fn surfaces(&self, places: &[f64]) -> Result<Arc<Surfaces>, DesignError> {
        let composed = self.task.composed_places(places);
        let name: Vec<u64> = composed.iter().map(|place| place.to_bits()).collect();
        if let Some(known) = self.known.lock().unwrap_or_else(PoisonError::into_inner).get(&name) {
            return Ok(known.clone());
        }
        let mut values = Vec::new();
        for run in &self.runs {
            if self.ground.watch.stop() {
                return Err(RunError::Stopped.into());
            }
            let there = self.task.moved(&run.places, &composed);
            let [spectra, film] = self.spectra_of(run, &there)?;
            values.push(self.ground.interpolated.of(&spectra, &film));
        }
        let places: Vec<Vec<f64>> =
            self.runs.iter().map(|run| self.task.interpolated_places(&run.places)).collect();
        let none = || {
            DesignError::NoColour(format!("{}: no colour: the surfaces have no solution", self.task.title))
        };
        let surfaces = Arc::new(Surfaces::new(&places, &values).ok_or_else(none)?);
        self.known.lock().unwrap_or_else(PoisonError::into_inner).insert(name, surfaces.clone());
        Ok(surfaces)
    }

    /// Spectra of a run at other places of the composed axes, its own or composed of its solves, and
    /// those of the film beneath.
    fn spectra_of(&self, run: &Support, places: &[f64]) -> Result<[Spectra3; 2], DesignError> {
        let solved = run.solved.as_ref().filter(|_| run.places != places);
        let Some(solved) = solved else {
            return Ok([run.spectra.clone(), self.film_at(places)?]);
        };
        let there = solved.at(self.task, places)?;
        // films have no sums of their own there
        let film = if self.task.numbers.is_empty() { there.film.clone() } else { self.film_at(places)? };
        Ok([there.layer.clone(), film])
    }

    /// The film beneath the surfaces; none where there is nothing beneath them.
    fn film_at(&self, places: &[f64]) -> Result<Spectra3, DesignError> {
        match self.ground.interpolated {
            Interpolated::BeyondFilm => self.film.at(places),
            Interpolated::Spectra | Interpolated::Logarithms => Ok(Vec::new()),
        }
    }

    /// What such an answer looks like.
    fn looks(&self, spectra: &[f64]) -> Result<Looks, DesignError> {
        let (lab, contrast_ratio) = self.eye.sees(spectra)?;
        Ok(Looks { lab, contrast_ratio, numbers: self.film.numbers(spectra) })
    }

    /// A recipe by the surfaces alone.
    pub(super) fn surface(&self, places: &[f64]) -> Result<Looks, DesignError> {
        let interpolated = self.surfaces(places)?.at(&self.task.interpolated_places(places));
        self.looks(&self.ground.interpolated.back(interpolated, &self.film_at(places)?))
    }

    /// A recipe by the surfaces and what runs have shown nearby.
    pub fn at(&self, places: &[f64]) -> Result<Looks, DesignError> {
        let mut looks = self.surface(places)?;
        let distances = self.offsets.iter().map(|(own, ..)| distance(own, places));
        let near: Vec<f64> = distances.map(|d| (-0.5 * (d / CARRIED).powi(2)).exp()).collect();
        let sum: f64 = near.iter().map(|near| near.powi(4)).sum();
        let most = near.iter().copied().fold(0.0, f64::max);
        for ((_, offset, of_numbers), near) in self.offsets.iter().zip(&near) {
            let share = most * near.powi(4) / sum.max(1e-300);
            (0..3).for_each(|i| looks.lab[i] += share * offset[i]);
            looks.numbers.iter_mut().zip(of_numbers).for_each(|(number, by)| *number += share * by);
        }
        Ok(looks)
    }

    fn answer(&self, places: Vec<f64>) -> Option<DesignAnswer> {
        let Looks { lab, contrast_ratio, numbers } = self.at(&places).ok()?;
        if numbers.iter().any(|number| !number.is_finite()) {
            return None;
        }
        let delta_e_2000 = self.task.lab.map(|target| ciede2000(lab, target));
        let recipe = self.task.in_words(&places);
        let values = self.task.values(&places);
        Some(DesignAnswer { recipe, values, delta_e_2000, contrast_ratio, numbers, places })
    }

    /// What is to be small: the distance, what is missing in contrast, and how far numbers are from
    /// what is aimed at.
    fn miss(&self, answer: &DesignAnswer) -> f64 {
        let lack = self.aims.iter().zip(&answer.numbers).map(|(aim, &value)| aim.lack(value)).sum::<f64>();
        self.task.miss(answer.delta_e_2000, answer.contrast_ratio) + lack
    }

    /// Order of two answers, the best one first; of those that miss nothing the cheapest, and of
    /// these the one that is deepest within what is wanted.
    fn order(&self, a: &DesignAnswer, b: &DesignAnswer) -> std::cmp::Ordering {
        let cost = |answer: &DesignAnswer| self.task.cost(&answer.places);
        let depth = |answer: &DesignAnswer| {
            let all = self.task.numbers.iter().zip(&answer.numbers);
            all.map(|(wish, &value)| wish.depth(value)).fold(f64::INFINITY, f64::min)
        };
        let missed = self.miss(a).total_cmp(&self.miss(b));
        missed.then_with(|| cost(a).total_cmp(&cost(b))).then_with(|| depth(b).total_cmp(&depth(a)))
    }

    /// Recipes of the box, or of a region of it, the nearest to the target first.
    pub fn search(&self, region: Option<&(Vec<f64>, f64)>) -> Vec<DesignAnswer> {
        let count = self.task.variables.len();
        let bounds: Vec<[f64; 2]> = (0..count)
            .map(|i| region.map_or([0.0, 1.0], |(at, r)| [(at[i] - r).max(0.0), (at[i] + r).min(1.0)]))
            .collect();
        let place = |r: usize| -> Vec<f64> {
            let point = even_point(SEARCH_SEED, count, r);
            let mut places: Vec<f64> = bounds.iter().zip(point).map(|([a, b], x)| a + (b - a) * x).collect();
            for i in self.task.composed() {
                places[i] = ((places[i] * COMPOSED_TRIED).round() / COMPOSED_TRIED).clamp(0.0, 1.0);
            }
            places
        };
        let tried = (0..TRIED * count).into_par_iter();
        let mut all: Vec<DesignAnswer> = tried.filter_map(|r| self.answer(place(r))).collect();
        all.sort_by(|a, b| self.order(a, b));
        let best: Vec<DesignAnswer> = all.iter().take(FOLLOWED).cloned().collect();
        all.extend(best.into_par_iter().map(|start| self.downhill(start, &bounds)).collect::<Vec<_>>());
        all.sort_by(|a, b| self.order(a, b));
        all
    }

    /// Follows a recipe downhill along the variables.
    fn downhill(&self, mut here: DesignAnswer, bounds: &[[f64; 2]]) -> DesignAnswer {
        let step = |i: usize| if self.task.variables[i].composed { COMPOSED_STEP } else { STEP };
        let mut share = 1.0;
        for _ in 0..HALVINGS {
            loop {
                let moves = (0..bounds.len()).flat_map(|i| [(i, share * step(i)), (i, -share * step(i))]);
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
            share *= 0.5;
        }
        here
    }

    /// What the surfaces without a run predict for it, at its own places of the composed axes or at
    /// others.
    fn without(&self, i: usize, places: &[f64]) -> Result<[Spectra3; 2], DesignError> {
        let [own, _] = self.spectra_of(&self.runs[i], places)?;
        let without = self.ground.interpolated.wrong_by(&own, &self.surfaces(places)?.left_out[i]);
        Ok([without, own])
    }

    /// Median ΔE₀₀ between variants and the surfaces without them, at both ends of the composed axes
    /// and in their middle.
    pub fn leave_one_out(&self, data: &[Verified]) -> Result<f64, DesignError> {
        let composed = self.task.composed().count();
        let looked_at = if composed == 0 { &[0.5][..] } else { &[0.0, 0.5, 1.0] };
        let mut all = Vec::new();
        for &place in looked_at {
            for (i, run) in data.iter().enumerate() {
                let there = self.task.moved(&run.places, &vec![place; composed]);
                let [without, own] = self.without(i, &there)?;
                all.push(ciede2000(self.eye.sees(&without)?.0, self.eye.sees(&own)?.0));
            }
        }
        Ok(median(all))
    }

    /// What each wanted number of a run and of the surfaces may be wrong by: the median between
    /// variants and the surfaces without them, and the median standard error of the runs.
    pub fn number_errors(&self, data: &[Verified]) -> Vec<f64> {
        let missed = |(i, run): (usize, &Verified)| -> Vec<f64> {
            let without = self.without(i, &run.places).map(|[without, _]| self.film.numbers(&without));
            let without = without.unwrap_or_default();
            without.iter().zip(&run.numbers).map(|(here, run)| (here - run.estimate.value).abs()).collect()
        };
        let all: Vec<Vec<f64>> = data.iter().enumerate().map(missed).collect();
        let of = |k: usize| {
            let surfaces: Vec<f64> =
                all.iter().filter_map(|run| run.get(k).copied()).filter(|x| x.is_finite()).collect();
            let runs = data.iter().filter_map(|run| run.numbers.get(k)?.estimate.standard_error);
            median(surfaces).hypot(median(runs.collect()))
        };
        (0..self.task.numbers.len()).map(of).collect()
    }
}

/// The middle one, the upper of two; 0 of none.
fn median(mut all: Vec<f64>) -> f64 {
    all.sort_by(f64::total_cmp);
    all.get(all.len() / 2).copied().unwrap_or(0.0)
}

#[cfg(test)]
#[path = "map_tests.rs"]
pub(super) mod tests;
