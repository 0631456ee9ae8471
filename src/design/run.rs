//! Carries a design out: variants for the surfaces, search, verifying runs.

mod map;

pub use map::DesignAnswer;

use super::recipe::{DesignTask, corner, short};
use super::surface::{Spectra3, spectra};
use super::wish::{NumberWish, ReachedNumber, decimals};
use crate::appearance::colour::ciede2000;
use crate::appearance::viewing::ColourError;
use crate::evaluate::evaluated::{Evaluated, FinishedSolves};
use crate::evaluate::ink::InkError;
use crate::evaluate::manifest::Manifest;
use crate::evaluate::numbers::sums_of_run;
use crate::evaluate::seen::Seen;
use crate::input::study::Study;
use crate::numerics::estimate::Estimate;
use crate::run::watch::RunWatch;
use crate::run::{RunError, RunSettings};
use crate::store::folder::OutputFolder;
use crate::store::marker::Holds;
use crate::work::alone::run_study;
use map::{Map, distance, even_point, spread, study_at};
use serde::Serialize;
use std::fmt::{self, Display};
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
/// Standard errors within which a wish counts as met.
const WITHIN: f64 = 2.0;
/// Distance from an end of a range, as a share of it, within which a recipe lies at this end.
const AT_END: f64 = 0.02;
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
}

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
    /// Median leave-one-out error of the surfaces, ΔE₀₀.
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
        let mut map = Map::new(self.task, &data, variants)?;
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
            map = Map::new(self.task, &data, variants)?;
            if sure {
                break;
            }
        }
        let verified = data.split_off(variants);
        let outcome = self.outcome(&map, verified, Variants { run: data, left_out }, surface_error);
        Ok(DesignOutcome { number_errors, ..outcome })
    }

    /// Runs the variants of the design; those without a colour are left out.
    fn variants(&self) -> Result<Variants, DesignError> {
        let task = self.task;
        let count = task.variables.len();
        let planned = task.variants();
        let needed = super::surface::most_coefficients(count) + 2;
        let corners = if count <= CORNERS { (1 << count).min(planned) } else { 0 };
        let places = (0..corners)
            .map(|c| corner(c, count))
            .chain((0..planned - corners).map(|r| even_point(DESIGN_SEED, count, r)));
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

    /// Runs a recipe, of a verifying run with its number from 1; the inner error says why it has no
    /// colour.
    ///
    /// # Errors
    /// What ends every other run as well: a stop, an unwritable folder, too little memory.
    fn run(&self, places: &[f64], round: Option<usize>) -> Result<Result<Verified, String>, DesignError> {
        let task = self.task;
        let study = match self.study(places, round) {
            Ok(study) => study,
            Err(fault) => return Ok(Err(fault.to_string())),
        };
        // a folder of its own: processes that help find this study alone in its queue
        let path = self.folder.path().join("runs").join(study.key().short());
        let folder = OutputFolder::open(&path, Holds::Study).map_err(RunError::from)?;
        let collected = match run_study(&study, &folder, self.settings, self.watch) {
            Ok(ran) => ran.collected,
            Err(error) if error.is_of_the_study() => return Ok(Err(error.to_string())),
            Err(error) => return Err(error.into()),
        };
        if self.watch.stop() {
            return Err(RunError::Stopped.into());
        }
        let solved = FinishedSolves::Whole(Box::new(collected));
        let evaluated = match Evaluated::new(&study, &solved) {
            Ok(evaluated) => evaluated,
            Err(error) => return Ok(Err(error.to_string())),
        };
        let mut spectra = match evaluated.seen().map(|seen| &seen.ink) {
            Some(Ok(ink)) => spectra(ink)?,
            Some(Err(reason)) => return Ok(Err(reason.to_string())),
            None => return Ok(Err("a composed layer has no spectra over other backings".to_owned())),
        };
        match evaluated.seen().map(|seen| self.number_sums(&study, seen)).transpose() {
            Ok(sums) => spectra.extend(sums.into_iter().flatten()),
            Err(reason) => return Ok(Err(reason)),
        }
        let manifest = evaluated.manifest;
        if let Some(what) = manifest.unphysical() {
            return Ok(Err(format!("{what}: curves through few wavelengths and cells overshoot")));
        }
        let main = manifest.main_numbers();
        let maker = manifest.ink_maker.as_ref();
        let target = maker.and_then(|maker| maker.target.as_ref());
        let Some(maker) = maker.filter(|_| target.is_some() || task.lab.is_none()) else {
            let reason = manifest.no_ink_maker.or(manifest.no_colour);
            return Ok(Err(reason.unwrap_or_else(|| "the run gives no colour at 45:0".into())));
        };
        let numbers = match self.reached(&manifest) {
            Ok(numbers) => numbers,
            Err(reason) => return Ok(Err(reason)),
        };
        Ok(Ok(Verified {
            recipe: task.in_words(places),
            values: task.values(places),
            lab: maker.print.colour.lab,
            hex: maker.print.hex.clone(),
            delta_e_2000: target.map(|target| target.delta_e_2000),
            predicted: None,
            surface_error: None,
            contrast_ratio: maker.contrast_ratio,
            numbers,
            realisations: main.realisations,
            cost: task.cost(places),
            places: places.to_vec(),
            spectra,
        }))
    }

    /// The sums behind the numbers that are wanted.
    fn number_sums(&self, study: &Study, seen: &Seen) -> Result<Vec<f64>, String> {
        let each = self.task.numbers.iter().map(|wish| sums_of_run(&wish.wanted, study, seen));
        Ok(each.collect::<Result<Vec<_>, String>>()?.concat())
    }

    /// The numbers of a run that are wanted, or why one of them is withheld.
    fn reached(&self, manifest: &Manifest) -> Result<Vec<ReachedNumber>, String> {
        let find = |wish: &NumberWish| {
            let note = manifest.numbers.iter().find(|note| note.name == wish.name);
            let reached = note.and_then(|note| note.estimate());
            let name = wish.name.clone();
            reached.map(|estimate| ReachedNumber { name, estimate, predicted: None }).ok_or_else(|| {
                let withheld = manifest.withheld.iter().find(|withheld| withheld.number == wish.name);
                withheld.map_or_else(|| format!("it has no {}", wish.name), |why| why.in_words())
            })
        };
        self.task.numbers.iter().map(find).collect()
    }

    /// The study of a recipe. A verifying run has the requested number of packings, and others than
    /// the variants and every earlier one: searches fit their answer to the chance of the runs
    /// before.
    fn study(&self, places: &[f64], round: Option<usize>) -> Result<Study, DesignError> {
        let mut study = study_at(self.task, places)?;
        study.judgement.target_lab = self.task.lab;
        if let Some(round) = round {
            study.packing.seed = study.packing.seed.wrapping_add(round as u64);
            study.realisations = self.task.settings.realisations.unwrap_or(study.realisations);
        }
        Ok(study)
    }

    /// Whether a run needs no further one: it meets the wish, and does so at the far end of its bar
    /// as well.
    fn is_sure(&self, run: &Verified) -> bool {
        let of_colour = |distance: Estimate| distance.value + error(distance) <= self.task.settings.delta_e;
        let of_number = |wish: &NumberWish, at: Estimate| {
            [-error(at), error(at)].iter().all(|by| wish.holds(at.value + by))
        };
        self.meets(run)
            && run.delta_e_2000.is_none_or(of_colour)
            && self.wanted(run).all(|(wish, number)| of_number(wish, number.estimate))
    }

    /// Whether a recipe is within the requested ΔE₀₀, hides enough and has the numbers wanted.
    fn meets(&self, run: &Verified) -> bool {
        run.delta_e_2000.is_none_or(|distance| distance.value <= self.task.settings.delta_e)
            && self.task.hides(run.contrast_ratio.value)
            && self.wanted(run).all(|(wish, number)| wish.holds(number.estimate.value))
    }

    /// The numbers that are wanted, and what a run has of them.
    fn wanted<'b>(
        &'b self,
        run: &'b Verified,
    ) -> impl Iterator<Item = (&'b NumberWish, &'b ReachedNumber)> + 'b {
        self.task.numbers.iter().zip(&run.numbers)
    }

    /// How far a run is from the wishes but for its contrast, as a ΔE₀₀.
    fn distance(&self, run: &Verified) -> f64 {
        let of_colour = run.delta_e_2000.map_or(0.0, |distance| distance.value);
        let numbers: Vec<f64> = run.numbers.iter().map(|number| number.estimate.value).collect();
        of_colour + self.task.lack(&numbers)
    }

    /// Order of two recipes, the best one first: by rank, those of one rank by distance.
    fn order(&self, a: &Verified, b: &Verified) -> std::cmp::Ordering {
        self.rank(a).total_cmp(&self.rank(b)).then(self.distance(a).total_cmp(&self.distance(b)))
    }

    /// Rank of a recipe: of those that meet the wish the cost, of the others the distance.
    fn rank(&self, run: &Verified) -> f64 {
        if self.meets(run) {
            // between 0 and 1 whatever the currency
            return 0.5 + run.cost.atan() / std::f64::consts::PI;
        }
        1.0 + self.task.miss(Some(self.distance(run)), run.contrast_ratio.value)
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
        let limit = self.task.settings.delta_e.max(least + surface_error);
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
            surface_error,
            number_errors: Vec::new(),
            variants: data.run.len(),
            left_out: data.left_out,
        }
    }

    fn verdict(&self, verified: &[Verified], met: bool) -> String {
        let task = self.task;
        let Some(best) = verified.first() else {
            return "Not proven: no verifying run gave a colour".into();
        };
        let wish = task.settings.delta_e;
        let ends: Vec<String> = (0..task.variables.len()).filter_map(|i| at_end(task, best, i)).collect();
        let ends = if ends.is_empty() { String::new() } else { format!(" It lies at {}.", ends.join(", ")) };
        let (Some(of_colour), true) = (best.delta_e_2000, task.numbers.is_empty()) else {
            return self.verdict_of_all(best, met, &ends);
        };
        let distance = of_colour.in_words(2);
        if met {
            return format!("{}: ΔE₀₀ {distance} to the target (requested: {wish})", best.recipe);
        }
        if let Some(least) = task.contrast_ratio.filter(|least| best.contrast_ratio.value < *least) {
            let ratio = best.contrast_ratio.in_words(3);
            return format!(
                "No recipe in these ranges has the colour and hides enough: the nearest is {} with ΔE₀₀ {distance} and a contrast \
                 ratio of {ratio} (requested: {wish} and {least}).{ends}",
                best.recipe
            );
        }
        if of_colour.value - error(of_colour) > wish {
            return format!(
                "Out of reach in these ranges: the nearest recipe, {}, is ΔE₀₀ {distance} away (requested: {wish}).{ends}",
                best.recipe
            );
        }
        format!(
            "Not proven: {} is ΔE₀₀ {distance} away (requested: {wish}), and its error is too large to decide: raise \
             design.realisations or design.verifications.{ends}",
            best.recipe
        )
    }

    /// The verdict where numbers are wanted: all that a recipe has of what was requested.
    fn verdict_of_all(&self, best: &Verified, met: bool, ends: &str) -> String {
        let task = self.task;
        let wish = task.settings.delta_e;
        let colour = best
            .delta_e_2000
            .map(|distance| format!("ΔE₀₀ {} to the target (requested: {wish})", distance.in_words(2)));
        let contrast = task.contrast_ratio.map(|least| {
            format!("a contrast ratio of {} (requested: {least})", best.contrast_ratio.in_words(3))
        });
        let numbers = self.wanted(best).map(|(wish, number)| {
            let reached = number.estimate.in_words(decimals(wish));
            format!("{} {reached} (requested: {})", wish.name, wish.in_words())
        });
        let all = colour.into_iter().chain(contrast).chain(numbers).collect::<Vec<_>>().join(", ");
        if met {
            return format!("{}: {all}", best.recipe);
        }
        let missed = |wish: &NumberWish, at: Estimate| wish.distance(at.value) > error(at);
        let is_missed = !task.hides(best.contrast_ratio.value)
            || best.delta_e_2000.is_some_and(|distance| distance.value - error(distance) > wish)
            || self.wanted(best).any(|(wish, number)| missed(wish, number.estimate));
        if is_missed {
            return format!(
                "Out of reach in these ranges: the nearest recipe, {}, has {all}.{ends}",
                best.recipe
            );
        }
        format!(
            "Not proven: {} has {all}, and its error is too large to decide: raise design.realisations or design.verifications.{ends}",
            best.recipe
        )
    }
}

/// In words whether a recipe lies at an end of a range.
fn at_end(task: &DesignTask, best: &Verified, i: usize) -> Option<String> {
    let place = best.places[i];
    let which = if place < AT_END { "smallest" } else { "largest" };
    let variable = &task.variables[i];
    let value = short(variable.value(place));
    (!(AT_END..=1.0 - AT_END).contains(&place)).then(|| format!("the {which} {} ({value})", variable.name))
}

/// What a number of a run may be wrong by.
fn error(of: Estimate) -> f64 {
    WITHIN * of.standard_error.unwrap_or(0.0)
}

fn same(one: &[f64], other: &[f64]) -> bool {
    one.iter().zip(other).all(|(a, b)| (a - b).abs() < SAME)
}

#[cfg(test)]
#[path = "run/run_tests.rs"]
mod tests;
