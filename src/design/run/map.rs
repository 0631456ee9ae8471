//! Surfaces with the film beneath and the verified runs on top, and the search on them.

use super::{DesignError, Verified};
use crate::appearance::colour::ciede2000;
use crate::design::recipe::DesignTask;
use crate::design::surface::{Eye, Spectra3, Surfaces, spectra};
use crate::design::wish::NumberWish;
use crate::evaluate::numbers::{AskedNumber, film_spectra};
use crate::evaluate::seen::film_alone;
use crate::input::file::SeenLight;
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
    film: FilmResponse<'a>,
    surfaces: Surfaces,
    /// Verified recipes: places, and run less surface in L*, a*, b*, and in the numbers.
    offsets: Vec<(Vec<f64>, [f64; 3], Vec<f64>)>,
    /// The wishes that a search aims at: ranges less what the surfaces and a run may be wrong by.
    aims: Vec<NumberWish>,
}

/// What the coherent film of a recipe answers: the spectra behind its colours, and the sums behind
/// the numbers that are wanted.
struct FilmResponse<'a> {
    task: &'a DesignTask,
    asked: Vec<AskedNumber<'a>>,
    /// Wavelengths of the spectra that numbers take, nm.
    wavelengths_nm: Vec<f64>,
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

pub(super) fn study_at(task: &DesignTask, places: &[f64]) -> Result<Study, DesignError> {
    task.study(places).map_err(|faults| DesignError::no_colour(task, places, &faults[0]))
}

impl<'a> FilmResponse<'a> {
    /// Of recipes with the wavelengths of this one.
    fn new(task: &'a DesignTask, places: &[f64]) -> Result<Self, DesignError> {
        let wanted: Vec<_> = task.numbers.iter().map(|wish| &wish.wanted).collect();
        let wavelengths_nm =
            if wanted.is_empty() { Vec::new() } else { study_at(task, places)?.number_wavelengths_nm() };
        let asked =
            wanted.into_iter().filter_map(|wanted| AskedNumber::new(wanted, &wavelengths_nm)).collect();
        Ok(Self { task, asked, wavelengths_nm })
    }

    /// Spectra of a recipe's film, and the sums of its numbers.
    fn at(&self, places: &[f64]) -> Result<Spectra3, DesignError> {
        let study = study_at(self.task, places)?;
        let mut all = spectra(&film_alone(&study)?)?;
        for asked in &self.asked {
            let lights: Vec<SeenLight> = asked.wanted.spectra().collect();
            let spectra = film_spectra(&study, &lights, &self.wavelengths_nm)?;
            all.extend(asked.sums_of(&spectra.iter().map(Vec::as_slice).collect::<Vec<_>>()));
        }
        Ok(all)
    }

    /// The numbers of such an answer, whose sums come last.
    fn numbers(&self, spectra: &[f64]) -> Vec<f64> {
        let counts: Vec<usize> = self.asked.iter().map(AskedNumber::count).collect();
        let mut sums = &spectra[spectra.len() - counts.iter().sum::<usize>()..];
        let mut numbers = Vec::new();
        for (asked, count) in self.asked.iter().zip(counts) {
            let (own, rest) = sums.split_at(count);
            numbers.push(asked.number(own));
            sums = rest;
        }
        numbers
    }
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
        let film_of = FilmResponse::new(task, &data[0].places)?;
        for run in data {
            let film = film_of.at(&run.places)?;
            differences.push(run.spectra.iter().zip(&film).map(|(a, b)| a - b).collect());
        }
        let places: Vec<Vec<f64>> = data.iter().map(|run| run.places.clone()).collect();
        let none =
            || DesignError::NoColour(format!("{}: no colour: the surfaces have no solution", task.title));
        let surfaces = Surfaces::new(&places, &differences).ok_or_else(none)?;
        let eye = Eye::new(&study_at(task, &data[0].places)?)?;
        let (film, aims) = (film_of, task.numbers.clone());
        let mut map = Map { task, eye, film, surfaces, offsets: Vec::new(), aims };
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

    /// What such an answer looks like.
    fn looks(&self, spectra: &[f64]) -> Result<Looks, DesignError> {
        let (lab, contrast_ratio) = self.eye.sees(spectra)?;
        Ok(Looks { lab, contrast_ratio, numbers: self.film.numbers(spectra) })
    }

    /// A recipe by the surfaces alone.
    pub(super) fn surface(&self, places: &[f64]) -> Result<Looks, DesignError> {
        let parts = self.film.at(places)?.into_iter().zip(self.surfaces.at(places));
        let sum: Vec<f64> = parts.map(|(a, b)| a + b).collect();
        self.looks(&sum)
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
            bounds.iter().zip(point).map(|([a, b], x)| a + (b - a) * x).collect()
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

    /// What the surfaces without a variant predict for it.
    fn without(&self, i: usize, run: &Verified) -> Vec<f64> {
        run.spectra.iter().zip(&self.surfaces.left_out[i]).map(|(own, e)| own + e).collect()
    }

    /// Median ΔE₀₀ between variants and the surfaces without them.
    pub fn leave_one_out(&self, data: &[Verified]) -> Result<f64, DesignError> {
        let mut all = Vec::new();
        for (i, run) in data.iter().enumerate() {
            let without = self.without(i, run);
            all.push(ciede2000(self.eye.sees(&without)?.0, self.eye.sees(&run.spectra)?.0));
        }
        Ok(median(all))
    }

    /// What each wanted number of a run and of the surfaces may be wrong by: the median between
    /// variants and the surfaces without them, and the median standard error of the runs.
    pub fn number_errors(&self, data: &[Verified]) -> Vec<f64> {
        let missed = |(i, run): (usize, &Verified)| -> Vec<f64> {
            let without = self.film.numbers(&self.without(i, run));
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
