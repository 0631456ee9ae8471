//! Carries a design out: variants for the surfaces, search, verifying runs.

mod map;

pub use map::DesignAnswer;

use super::recipe::{DesignTask, corner, short};
use super::surface::{Spectra3, spectra};
use crate::appearance::colour::{ColourError, ciede2000};
use crate::evaluate::ink::InkError;
use crate::evaluate::seen::see;
use crate::evaluate::summary::summarise;
use crate::numerics::estimate::Estimate;
use crate::run::watch::RunWatch;
use crate::run::{RunError, RunSettings};
use crate::store::folder::OutputFolder;
use crate::store::marker::Holds;
use crate::sweep::alone::run_study;
use map::{Map, even_point, spread, study_at};
use serde::Serialize;
use std::fmt::Display;
use thiserror::Error;

/// Variables for which all corners of the box are among the variants.
const CORNERS: usize = 3;
/// Seed of the places of the variants.
const DESIGN_SEED: u64 = 1;
/// Radius of the region about the best verified recipe that later searches keep to, if it is closer
/// to the target than this ΔE₀₀.
const REGION: f64 = 0.25;
const CLOSE: f64 = 4.0;
/// Standard errors within which a wish counts as met.
const WITHIN: f64 = 2.0;
/// Distance at which a recipe lies at an end of its range.
const SAME: f64 = 0.02;
/// Recipes nearer than this in every variable are the same.
const RUN: f64 = 0.004;

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
    /// A run gave no colour.
    #[error("{0}")]
    NoColour(String),
    /// Too many variants could not be packed.
    #[error("{0} are needed: lower the volume fractions in [[vary]]")]
    TooFew(String),
}

impl DesignError {
    fn no_colour(task: &DesignTask, places: &[f64], reason: impl Display) -> Self {
        Self::NoColour(format!("{}: no colour: {reason}", task.in_words(places)))
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
    /// ΔE₀₀ to the target, with its standard error.
    pub delta_e_2000: Estimate,
    /// ΔE₀₀ to the target that the surfaces answered; none for variants of the design.
    pub predicted: Option<f64>,
    /// ΔE₀₀ between the run and the surfaces' answer.
    pub surface_error: Option<f64>,
    /// Contrast ratio.
    pub contrast_ratio: Estimate,
    /// Cost by the weights of the variables.
    pub cost: f64,
    #[serde(skip)]
    places: Vec<f64>,
    #[serde(skip)]
    spectra: Spectra3,
}

/// The result of a design.
#[derive(Clone, Debug, Serialize)]
pub struct DesignOutcome {
    /// Whether a verified recipe is as near as wished.
    pub met: bool,
    /// L*, a*, b* wanted.
    pub target: [f64; 3],
    /// Verdict in words.
    pub verdict: String,
    /// Verified recipes, the best one first.
    pub verified: Vec<Verified>,
    /// Recipes of nearly the same colour by the surfaces.
    pub valley: Vec<DesignAnswer>,
    /// Smallest and largest value of every variable in the valley.
    pub valley_ranges: Vec<[f64; 2]>,
    /// Median leave-one-out error of the surfaces, ΔE₀₀.
    pub surface_error: f64,
    /// Variants that the surfaces rest on.
    pub variants: usize,
}

/// A design in progress.
pub struct DesignRun<'a> {
    /// What is designed.
    pub task: &'a DesignTask,
    /// Where solves are kept.
    pub folder: &'a OutputFolder,
    /// How runs are carried out.
    pub settings: RunSettings,
    /// Who is told of the work.
    pub watch: &'a dyn RunWatch,
}

impl DesignRun<'_> {
    /// The design.
    ///
    /// # Errors
    /// A stop, or runs without results.
    pub fn design(&self) -> Result<DesignOutcome, DesignError> {
        let mut data = self.variants()?;
        let variants = data.len();
        let mut map = Map::new(self.task, &data, variants)?;
        let surface_error = map.leave_one_out(&data)?;
        for round in 1..=self.task.settings.verifications {
            let found = &data[variants..];
            let best = found.iter().min_by(|a, b| self.order(a, b));
            let near = best.filter(|best| best.delta_e_2000.value < CLOSE);
            let near = near.map(|best| (best.places.clone(), REGION));
            let Some(answer) = map.search(near.as_ref()).into_iter().next() else { break };
            if found.iter().any(|known| same(&known.places, &answer.places)) {
                break;
            }
            self.watch.stage(&format!("verifying run {round}: {}", answer.recipe));
            let mut verified = self.run(&answer.places, true)?;
            verified.predicted = Some(answer.delta_e_2000);
            verified.surface_error = Some(ciede2000(verified.lab, map.at(&answer.places)?.0));
            let farthest = verified.delta_e_2000.value + error(&verified);
            let sure = self.meets(&verified) && farthest <= self.task.settings.delta_e;
            data.push(verified);
            map = Map::new(self.task, &data, variants)?;
            if sure {
                break;
            }
        }
        Ok(self.outcome(&map, data.split_off(variants), (surface_error, variants)))
    }

    /// Runs the variants of the design; those without room are left out.
    fn variants(&self) -> Result<Vec<Verified>, DesignError> {
        let (task, count) = (self.task, self.task.variables.len());
        let corners = if count <= CORNERS { 1 << count } else { 0 };
        let asked = task.variants();
        let places = (0..corners.min(asked))
            .map(|c| corner(c, count))
            .chain((0..asked.saturating_sub(corners)).map(|r| even_point(DESIGN_SEED, count, r)));
        let mut all = Vec::new();
        for (k, places) in places.enumerate() {
            self.watch.stage(&format!("variant {}/{asked}: {}", k + 1, task.in_words(&places)));
            match self.run(&places, false) {
                Err(DesignError::Run(error)) if error.has_no_room() => {}
                other => all.push(other?),
            }
        }
        let needed = super::surface::most_coefficients(count) + 2;
        if all.len() >= needed {
            return Ok(all);
        }
        let room = format!("{} of {asked} variants have room for their grains, {needed}", all.len());
        Err(DesignError::TooFew(room))
    }

    /// Runs a recipe.
    fn run(&self, places: &[f64], verifying: bool) -> Result<Verified, DesignError> {
        let task = self.task;
        let no_colour = |reason: String| DesignError::no_colour(task, places, reason);
        let mut study = study_at(task, places)?;
        study.judgement.target_lab = Some(task.lab);
        if let (true, Some(realisations)) = (verifying, task.settings.realisations) {
            study.realisations = realisations;
        }
        // a folder of its own: processes that help find this study alone in its queue
        let path = self.folder.path().join("runs").join(study.key().short());
        let folder = OutputFolder::open(&path, Holds::Study).map_err(RunError::from)?;
        let collected = run_study(&study, &folder, self.settings, self.watch)?.collected;
        if self.watch.stop() {
            return Err(RunError::Stopped.into());
        }
        let seen = see(&study, &collected).map_err(|error| no_colour(error.to_string()))?;
        let spectra = spectra(seen.ink.as_ref().map_err(|error| no_colour(error.to_string()))?)?;
        let manifest = summarise(&study, &collected, &seen);
        let none = || manifest.no_colour.clone().or(manifest.no_ink_maker.clone()).unwrap_or_default();
        let maker = manifest.ink_maker.as_ref().ok_or_else(|| no_colour(none()))?;
        let target = maker.target.as_ref().ok_or_else(|| no_colour(none()))?;
        Ok(Verified {
            recipe: task.in_words(places),
            values: task.values(places),
            lab: maker.print.colour.lab,
            hex: maker.print.hex.clone(),
            delta_e_2000: target.delta_e_2000,
            predicted: None,
            surface_error: None,
            contrast_ratio: maker.contrast_ratio,
            cost: task.cost(places),
            places: places.to_vec(),
            spectra,
        })
    }

    /// Whether a recipe is as near as wished and hides enough.
    fn meets(&self, run: &Verified) -> bool {
        run.delta_e_2000.value <= self.task.settings.delta_e && self.task.hides(run.contrast_ratio.value)
    }

    /// Order of two recipes, the best one first: by rank, those of one rank by distance.
    fn order(&self, a: &Verified, b: &Verified) -> std::cmp::Ordering {
        let distance = |run: &Verified| run.delta_e_2000.value;
        self.rank(a).total_cmp(&self.rank(b)).then(distance(a).total_cmp(&distance(b)))
    }

    /// Rank of a recipe: of those that meet the wish the cost, of the others the distance.
    fn rank(&self, run: &Verified) -> f64 {
        if self.meets(run) {
            // between 0 and 1 whatever the currency
            return 0.5 + run.cost.atan() / std::f64::consts::PI;
        }
        1.0 + self.task.miss(run.delta_e_2000.value, run.contrast_ratio.value)
    }

    fn outcome(
        &self,
        map: &Map,
        mut verified: Vec<Verified>,
        (surface_error, variants): (f64, usize),
    ) -> DesignOutcome {
        verified.sort_by(|a, b| self.order(a, b));
        let met = verified.first().is_some_and(|best| self.meets(best));
        let answers = map.search(None);
        let least = answers.first().map_or(0.0, |a| a.delta_e_2000);
        let limit = self.task.settings.delta_e.max(least + surface_error);
        let near = |a: &DesignAnswer| a.delta_e_2000 <= limit && self.task.hides(a.contrast_ratio);
        let valley: Vec<DesignAnswer> = answers.into_iter().filter(near).collect();
        let ends = |i: usize| {
            let all = || valley.iter().map(|a| a.values[i]);
            [all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max)]
        };
        let valley_ranges =
            if valley.is_empty() { Vec::new() } else { (0..self.task.variables.len()).map(ends).collect() };
        let (target, verdict, valley) = (self.task.lab, self.verdict(&verified, met), spread(&valley));
        DesignOutcome { met, target, verdict, verified, valley, valley_ranges, surface_error, variants }
    }

    fn verdict(&self, verified: &[Verified], met: bool) -> String {
        let (task, Some(best)) = (self.task, verified.first()) else { return "no recipe was run".into() };
        let wish = task.settings.delta_e;
        let distance = best.delta_e_2000.in_words(2);
        if met {
            return format!("{}: ΔE₀₀ {distance} to the target; wished: {wish}", best.recipe);
        }
        let ends: Vec<String> = (0..task.variables.len()).filter_map(|i| at_end(task, best, i)).collect();
        let ends = if ends.is_empty() { String::new() } else { format!(" It lies at {}.", ends.join(", ")) };
        if let Some(least) = task.contrast_ratio.filter(|least| best.contrast_ratio.value < *least) {
            let ratio = best.contrast_ratio.in_words(3);
            return format!(
                "No recipe in these ranges has the colour and hides enough: nearest is {} with ΔE₀₀ {distance} and a contrast \
                 ratio of {ratio}; wished: {wish} and {least}.{ends}",
                best.recipe
            );
        }
        if best.delta_e_2000.value - error(best) > wish {
            return format!(
                "Out of reach in these ranges: the nearest recipe, {}, is ΔE₀₀ {distance} away; wished: {wish}.{ends}",
                best.recipe
            );
        }
        format!(
            "Not proven: {} is ΔE₀₀ {distance} away; wished: {wish}. Its error is as large as what is missing: raise \
             design.realisations or design.verifications.{ends}",
            best.recipe
        )
    }
}

/// In words whether a recipe lies at an end of a range.
fn at_end(task: &DesignTask, best: &Verified, i: usize) -> Option<String> {
    let place = best.places[i];
    let which = if place < SAME { "smallest" } else { "largest" };
    let variable = &task.variables[i];
    let value = short(variable.value(place));
    (!(SAME..=1.0 - SAME).contains(&place)).then(|| format!("the {which} {} ({value})", variable.name))
}

/// What the distance of a run to the target may be wrong by.
fn error(run: &Verified) -> f64 {
    WITHIN * run.delta_e_2000.standard_error.unwrap_or(0.0)
}

fn same(one: &[f64], other: &[f64]) -> bool {
    one.iter().zip(other).all(|(a, b)| (a - b).abs() < RUN)
}
