//! Carries a design out: variants for the surfaces, search, verifying runs.

mod film;
mod interpolated;
mod map;
mod recipe_run;
mod solved;
mod verdict;

pub use interpolated::Interpolated;
pub use map::DesignAnswer;

use super::recipe::{DesignTask, corner};
use super::surface::{Spectra3, most_coefficients};
use super::wish::{NumberWish, ReachedNumber};
use crate::appearance::colour::ciede2000;
use crate::appearance::viewing::ColourError;
use crate::evaluate::ink::InkError;
use crate::input::study::Study;
use crate::numerics::estimate::Estimate;
use crate::run::watch::RunWatch;
use crate::run::{RunError, RunSettings};
use crate::store::folder::OutputFolder;
use map::{Ground, Map, distance, even_point, spread};
use serde::Serialize;
use solved::Composable;
use std::fmt::{self, Display};
use std::sync::Arc;
use thiserror::Error;

/// Results of a design, as they are named in its folder.
pub const RESULTS: [&str; 2] = ["design.json", "report.html"];
/// Variables for which all corners of the box are among the variants.
const CORNERS: usize = 3;
/// Seed of the places of the variants.
const DESIGN_SEED: u64 = 1;
/// Radius of the region about the best verified recipe that later searches keep to, if it is closer
/// to the target than this ΔE₀₀.
const REGION: f64 = 0.25;
const CLOSE: f64 = 4.0;
/// Recipes nearer than this share of the range in every variable are the same.
const SAME: f64 = 0.004;
/// Distance in the box that later searches keep from a recipe whose run gave no colour.
const AVOIDED: f64 = 0.1;

/// Why there is no design.
#[derive(Debug, Error)]
pub enum DesignError {
    /// A packing, a grid, a solve, or a stop.
    #[error(transparent)]
    Run(#[from] RunError),
    /// Wavelengths that carry no colour.
    #[error(transparent)]
    Colour(#[from] ColourError),
    /// A layer without a spectrum on its paper.
    #[error(transparent)]
    Ink(#[from] InkError),
    /// A recipe that no study can be made of, or surfaces without a solution.
    #[error("{0}")]
    NoColour(String),
    /// Too many variants are without a colour.
    #[error(
        "{left} of {planned} variants gave no colour, and the response surfaces need {needed} with a colour. The first is \
         {first}. Narrow the ranges in [[vary]] to recipes that have a colour, plan more of them (design.variants), \
         or, where too few packings are the reason, raise run.realisations of the base"
    )]
    TooFew {
        /// Variants without a colour so far.
        left: usize,
        /// Variants planned.
        planned: usize,
        /// Variants that the surfaces need.
        needed: usize,
        /// The first one without a colour.
        first: LeftOut,
    },
}

impl DesignError {
    fn no_colour(task: &DesignTask, places: &[f64], reason: impl Display) -> Self {
        Self::NoColour(format!("{}: no colour: {reason}", task.in_words(places)))
    }
}

/// A recipe that was run without a colour as the result, and is left out of the design.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LeftOut {
    /// The recipe in words.
    pub recipe: String,
    /// Why it has no colour.
    pub reason: String,
    /// Whether it was to verify an answer of the surfaces.
    pub verifying: bool,
    #[serde(skip)]
    places: Vec<f64>,
}

impl fmt::Display for LeftOut {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{} ({})", self.recipe, self.reason)
    }
}

/// A recipe that was run.
#[derive(Clone, Debug, Serialize)]
pub struct Verified {
    /// The recipe in words.
    pub recipe: String,
    /// Value of every variable.
    pub values: Vec<f64>,
    /// L*, a*, b*.
    pub lab: [f64; 3],
    /// `#rrggbb`.
    pub hex: String,
    /// ΔE₀₀ to the target, with its standard error; none where no colour is wanted.
    pub delta_e_2000: Option<Estimate>,
    /// ΔE₀₀ to the target that the surfaces answered; none for variants of the design.
    pub predicted: Option<f64>,
    /// ΔE₀₀ between the run and the surfaces' answer.
    pub surface_error: Option<f64>,
    /// Contrast ratio.
    pub contrast_ratio: Estimate,
    /// Numbers that are wanted, in the order of the wishes.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub numbers: Vec<ReachedNumber>,
    /// Packings behind these numbers.
    pub realisations: usize,
    /// Cost by the weights of the variables.
    pub cost: f64,
    #[serde(skip)]
    places: Vec<f64>,
    #[serde(skip)]
    spectra: Spectra3,
    /// What else is composed of its solves; none where nothing is.
    #[serde(skip)]
    solved: Option<Arc<Composable>>,
}

/// How the verdict on recipes begins whose errors are too large to decide.
const NOT_PROVEN: &str = "Not proven";

/// The result of a design.
#[derive(Clone, Debug, Serialize)]
pub struct DesignOutcome {
    /// Whether a verified recipe meets all wishes.
    pub met: bool,
    /// L*, a*, b* of the target; none where numbers alone are wanted.
    pub target: Option<[f64; 3]>,
    /// Weighted numbers that are wanted.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub wishes: Vec<NumberWish>,
    /// Verdict in words.
    pub verdict: String,
    /// Verified recipes, the best one first.
    pub verified: Vec<Verified>,
    /// Recipes of nearly the same colour by the surfaces, or, where no colour is wanted, that meet
    /// the wishes by the surfaces.
    pub valley: Vec<DesignAnswer>,
    /// Smallest and largest value of every variable in the valley.
    pub valley_ranges: Vec<[f64; 2]>,
    /// Variables of which every value was composed from the same solves.
    pub composed: Vec<String>,
    /// Variables that were interpolated between variants.
    pub interpolated: Vec<String>,
    /// What was interpolated of the variants' spectra; none where nothing was.
    pub interpolated_as: Option<Interpolated>,
    /// Median leave-one-out error of the surfaces, ΔE₀₀; 0 where nothing was interpolated.
    pub surface_error: f64,
    /// What each wanted number may be wrong by, in the order of the wishes: the median of the
    /// surfaces' leave-one-out errors with that of the runs' standard errors.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub number_errors: Vec<f64>,
    /// Variants that the surfaces rest on.
    pub variants: usize,
    /// Recipes that were run and have no colour, with the reason.
    pub left_out: Vec<LeftOut>,
}

impl DesignOutcome {
    /// Whether the errors of the verified recipes are small enough to say that one of them meets
    /// the wishes, or that none does.
    pub fn is_decided(&self) -> bool {
        self.met || !self.verdict.starts_with(NOT_PROVEN)
    }
}

/// What the surfaces rest on.
struct Variants {
    run: Vec<Verified>,
    left_out: Vec<LeftOut>,
}

/// A design in progress.
pub struct DesignRun<'a> {
    /// What is designed.
    pub task: &'a DesignTask,
    /// Where solves are kept.
    pub folder: &'a OutputFolder,
    /// How runs are carried out.
    pub settings: RunSettings,
    /// Receives the progress of the work, and may stop it.
    pub watch: &'a dyn RunWatch,
}

impl DesignRun<'_> {
    /// The design. Results of another design in the folder are removed before the first run.
    ///
    /// # Errors
    /// A stop, a folder that cannot be written, or too few variants with a colour.
    pub fn design(&self) -> Result<DesignOutcome, DesignError> {
        self.folder.begin_input(&self.task.key(), &RESULTS).map_err(RunError::from)?;
        let Variants { run: mut data, mut left_out } = self.variants()?;
        let variants = data.len();
        let ground = self.ground(&data)?;
        let mut map = Map::new(ground, &data, variants)?;
        let surface_error = map.leave_one_out(&data)?;
        let number_errors = map.number_errors(&data);
        for round in 1..=self.task.settings.verifications {
            let verified_before = &data[variants..];
            let best = verified_before.iter().min_by(|a, b| self.order(a, b));
            let near = best.filter(|best| self.distance(best) < CLOSE);
            let near = near.map(|best| (best.places.clone(), REGION));
            let avoided = |answer: &DesignAnswer| {
                left_out.iter().any(|left| left.verifying && distance(&left.places, &answer.places) < AVOIDED)
            };
            let answer = map.search(near.as_ref()).into_iter().find(|answer| !avoided(answer));
            self.heed()?;
            let Some(answer) = answer else { break };
            if verified_before.iter().any(|known| same(&known.places, &answer.places)) {
                break;
            }
            self.watch.stage(&format!("verifying run {round}: {}", answer.recipe));
            let mut verified = match self.run(&answer.places, Some(round))? {
                Ok(verified) => verified,
                Err(reason) => {
                    left_out.push(self.left_out(&answer.places, reason, true));
                    continue;
                }
            };
            verified.predicted = answer.delta_e_2000;
            verified.surface_error = Some(ciede2000(verified.lab, map.at(&answer.places)?.lab));
            let predicted = answer.numbers.iter().copied();
            verified.numbers.iter_mut().zip(predicted).for_each(|(own, by)| own.predicted = Some(by));
            let sure = self.is_sure(&verified);
            data.push(verified);
            map = Map::new(ground, &data, variants)?;
            if sure {
                break;
            }
        }
        let verified = data.split_off(variants);
        let outcome = self.outcome(&map, verified, Variants { run: data, left_out }, surface_error);
        self.heed()?;
        Ok(DesignOutcome { number_errors, ..outcome })
    }

    /// Ends the design where it is to stop.
    fn heed(&self) -> Result<(), DesignError> {
        if self.watch.stop() { Err(RunError::Stopped.into()) } else { Ok(()) }
    }

    /// What is interpolated of these variants: of layers that are composed of slabs, which tell no
    /// film of theirs, the spectra or their logarithms, whichever leaves out less.
    fn ground(&self, data: &[Verified]) -> Result<Ground<'_>, DesignError> {
        let of = |interpolated| Ground { task: self.task, watch: self.watch, interpolated };
        let places = vec![0.5; self.task.variables.len()];
        if study_at(self.task, &places)?.composed().is_none() {
            return Ok(of(Interpolated::BeyondFilm));
        }
        let left_out = |ground: Ground| Map::new(ground, data, data.len())?.leave_one_out(data);
        let themselves = left_out(of(Interpolated::Spectra))?;
        let logarithms = left_out(of(Interpolated::Logarithms))?;
        let is_better = logarithms < themselves;
        Ok(of(if is_better { Interpolated::Logarithms } else { Interpolated::Spectra }))
    }

    /// Runs the variants of the design; those without a colour are left out.
    fn variants(&self) -> Result<Variants, DesignError> {
        let task = self.task;
        let count = task.interpolated().count();
        let planned = task.variants();
        let needed = if count == 0 { 1 } else { most_coefficients(count) + 2 };
        let corners = if count <= CORNERS { (1 << count).min(planned) } else { 0 };
        let places = (0..corners)
            .map(|c| corner(c, count))
            .chain((0..planned - corners).map(|r| even_point(DESIGN_SEED, count, r)))
            .map(|interpolated| task.between(&interpolated));
        let mut variants = Variants { run: Vec::new(), left_out: Vec::new() };
        for (k, places) in places.enumerate() {
            self.watch.stage(&format!("variant {}/{planned}: {}", k + 1, task.in_words(&places)));
            match self.run(&places, None)? {
                Ok(run) => variants.run.push(run),
                Err(reason) => variants.left_out.push(self.left_out(&places, reason, false)),
            }
            let left = variants.left_out.len();
            if let Some(first) = variants.left_out.first().filter(|_| planned < needed + left) {
                return Err(DesignError::TooFew { left, planned, needed, first: first.clone() });
            }
        }
        Ok(variants)
    }

    fn left_out(&self, places: &[f64], reason: String, verifying: bool) -> LeftOut {
        LeftOut { recipe: self.task.in_words(places), reason, verifying, places: places.to_vec() }
    }

    fn outcome(
        &self,
        map: &Map,
        mut verified: Vec<Verified>,
        data: Variants,
        surface_error: f64,
    ) -> DesignOutcome {
        verified.sort_by(|a, b| self.order(a, b));
        let met = verified.first().is_some_and(|best| self.meets(best));
        let answers = map.search(None);
        let least = answers.first().and_then(|a| a.delta_e_2000).unwrap_or(0.0);
        // where nothing is interpolated, runs alone are in error
        let of_run = || data.run.first().and_then(|run| run.delta_e_2000?.standard_error);
        let is_interpolated = self.task.interpolated().next().is_some();
        let leeway = if is_interpolated { surface_error } else { of_run().unwrap_or(0.0) };
        let limit = self.task.settings.delta_e.max(least + leeway);
        let near = |a: &DesignAnswer| {
            a.delta_e_2000.is_none_or(|distance| distance <= limit)
                && self.task.hides(a.contrast_ratio)
                && self.task.numbers.iter().zip(&a.numbers).all(|(wish, &value)| wish.holds(value))
        };
        let valley: Vec<DesignAnswer> = answers.into_iter().filter(near).collect();
        let ends = |i: usize| {
            let all = || valley.iter().map(|a| a.values[i]);
            [all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max)]
        };
        let valley_ranges =
            if valley.is_empty() { Vec::new() } else { (0..self.task.variables.len()).map(ends).collect() };
        DesignOutcome {
            met,
            target: self.task.lab,
            wishes: self.task.numbers.clone(),
            verdict: self.verdict(&verified, met),
            verified,
            valley: spread(&valley),
            valley_ranges,
            composed: self.task.names(self.task.composed()),
            interpolated: self.task.names(self.task.interpolated()),
            interpolated_as: self.task.interpolated().next().map(|_| map.interpolated()),
            surface_error,
            number_errors: Vec::new(),
            variants: data.run.len(),
            left_out: data.left_out,
        }
    }
}

/// The study of a recipe.
fn study_at(task: &DesignTask, places: &[f64]) -> Result<Study, DesignError> {
    task.study(places).map_err(|faults| DesignError::no_colour(task, places, &faults[0]))
}

fn same(one: &[f64], other: &[f64]) -> bool {
    one.iter().zip(other).all(|(a, b)| (a - b).abs() < SAME)
}

#[cfg(test)]
#[path = "run/run_tests.rs"]
mod tests;
