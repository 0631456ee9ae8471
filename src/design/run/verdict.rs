//! What a run is worth: whether it meets the wishes, its place among others, and the verdict in
//! words.

use super::{DesignRun, NOT_PROVEN, Verified};
use crate::design::recipe::{DesignTask, short};
use crate::design::wish::{NumberWish, ReachedNumber, decimals};
use crate::numerics::estimate::Estimate;

/// Standard errors within which a wish counts as met.
const WITHIN: f64 = 2.0;
/// Distance from an end of a range, as a share of it, within which a recipe lies at this end.
const AT_END: f64 = 0.02;

impl DesignRun<'_> {
    /// Whether a run needs no further one: it meets the wish, and does so at the far end of its bar
    /// as well.
    pub(super) fn is_sure(&self, run: &Verified) -> bool {
        let of_colour = |distance: Estimate| distance.value + error(distance) <= self.task.settings.delta_e;
        let of_number = |wish: &NumberWish, at: Estimate| {
            [-error(at), error(at)].iter().all(|by| wish.holds(at.value + by))
        };
        self.meets(run)
            && run.delta_e_2000.is_none_or(of_colour)
            && self.wanted(run).all(|(wish, number)| of_number(wish, number.estimate))
    }

    /// Whether a recipe is within the requested ΔE₀₀, hides enough and has the numbers wanted.
    pub(super) fn meets(&self, run: &Verified) -> bool {
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
    pub(super) fn distance(&self, run: &Verified) -> f64 {
        let of_colour = run.delta_e_2000.map_or(0.0, |distance| distance.value);
        let numbers: Vec<f64> = run.numbers.iter().map(|number| number.estimate.value).collect();
        of_colour + self.task.lack(&numbers)
    }

    /// Order of two recipes, the best one first: by rank, those of one rank by distance.
    pub(super) fn order(&self, a: &Verified, b: &Verified) -> std::cmp::Ordering {
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

    /// The verdict on the best of these runs.
    pub(super) fn verdict(&self, verified: &[Verified], met: bool) -> String {
        let task = self.task;
        let Some(best) = verified.first() else {
            return format!("{NOT_PROVEN}: no verifying run gave a colour");
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
            "{NOT_PROVEN}: {} is ΔE₀₀ {distance} away (requested: {wish}), and its error is too large to decide: raise \
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
            "{NOT_PROVEN}: {} has {all}, and its error is too large to decide: raise design.realisations or design.verifications.{ends}",
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
