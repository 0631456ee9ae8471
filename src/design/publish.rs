//! Files of a design: `design.json`, the best recipe as a study, and a page.

use super::recipe::{DesignTask, Variable, short};
use super::run::{DesignAnswer, DesignOutcome, Verified};
use super::wish::{NumberWish, decimals};
use crate::appearance::tristimulus::Colorimeter;
use crate::draw::page::{hex, made_by, rendered};
use crate::input::locate::steps;
use crate::report::publish::PublishResult;
use crate::store::folder::OutputFolder;
use minijinja::value::Serde;
use minijinja::{Value, context};

/// A field that varies, as people who make inks call it.
struct Heading {
    /// Such as "share of yellow, %".
    words: String,
    /// What its values are multiplied by: shares are shown in percent.
    scale: f64,
}

impl Heading {
    /// Of a variable; `pigments` are the names of the study's pigments.
    fn new(variable: &Variable, pigments: &[String]) -> Self {
        let path: Vec<&str> = steps(&variable.name).collect();
        let by_number = |place: &str| pigments.get(place.parse::<usize>().ok()?).cloned();
        let of = |place: &str| by_number(place).unwrap_or_else(|| place.to_owned());
        let (words, scale) = match path.as_slice() {
            _ if variable.written.ratio.is_some() => (variable.name.clone(), 1.0),
            ["pigment", which, "volume_fraction"] => (format!("share of {}, %", of(which)), 100.0),
            ["pigment", which, "diameter_nm"] => (format!("diameter of {}, nm", of(which)), 1.0),
            ["layer", "thickness_um"] => ("thickness, µm".to_owned(), 1.0),
            _ => (variable.name.clone(), 1.0),
        };
        Self { words, scale }
    }

    fn shown(&self, value: f64) -> String {
        short(self.scale * value)
    }
}

/// What the page's tables are made with.
struct RecipeTables<'a> {
    headings: Vec<Heading>,
    /// Whether any field has a price.
    priced: bool,
    wishes: &'a [NumberWish],
}

impl<'a> RecipeTables<'a> {
    fn new(task: &'a DesignTask) -> Self {
        let middle = task.study(&vec![0.5; task.variables.len()]);
        let pigments: Vec<String> =
            middle.map(|study| study.pigments.into_iter().map(|p| p.name).collect()).unwrap_or_default();
        let headings = task.variables.iter().map(|variable| Heading::new(variable, &pigments)).collect();
        let priced = task.variables.iter().any(|variable| variable.written.cost != 0.0);
        Self { headings, priced, wishes: &task.numbers }
    }

    /// A recipe as a row of the page's tables; `distance` is that from the target colour, if one is
    /// wanted.
    fn row(
        &self,
        hex: Option<&str>,
        distance: Option<String>,
        values: &[f64],
        numbers: Vec<String>,
    ) -> Value {
        let values: Vec<String> = self.headings.iter().zip(values).map(|(h, &x)| h.shown(x)).collect();
        context!(hex => hex.map(str::to_owned), distance, values, numbers)
    }

    fn verified(&self, run: &Verified) -> Value {
        let distance = run.delta_e_2000.map(|distance| distance.in_words(2));
        let predicted = distance.as_ref().map(|_| run.predicted.map_or(String::new(), |x| format!("{x:.2}")));
        let cost = self.priced.then(|| short(run.cost));
        let wanted = self.wishes.iter().zip(&run.numbers);
        let wanted = wanted.map(|(wish, number)| number.estimate.in_words(decimals(wish)));
        let numbers = predicted.into_iter().chain([run.contrast_ratio.in_words(3)]).chain(wanted);
        self.row(Some(&run.hex), distance, &run.values, numbers.chain(cost).collect())
    }

    fn answered(&self, answer: &DesignAnswer) -> Value {
        let distance = answer.delta_e_2000.map(|distance| format!("{distance:.2}"));
        let wanted = self.wishes.iter().zip(&answer.numbers);
        let wanted = wanted.map(|(wish, number)| format!("{number:.*}", decimals(wish)));
        let numbers = distance.into_iter().chain([format!("{:.3}", answer.contrast_ratio)]).chain(wanted);
        self.row(None, None, &answer.values, numbers.collect())
    }
}

/// L*, a*, b* under daylight as screens show it, `#rrggbb`.
fn patch([l, a, b]: [f64; 3]) -> Option<String> {
    let wavelengths_nm: Vec<f64> = (0..31).map(|i| 400.0 + 10.0 * f64::from(i)).collect();
    let meter = Colorimeter::new(&wavelengths_nm).ok()?;
    let y = (l + 16.0) / 116.0;
    let cubed = |f: f64| if f > 6.0 / 29.0 { f.powi(3) } else { (f - 4.0 / 29.0) * 108.0 / 841.0 };
    let [x_n, y_n, z_n] = meter.white_xyz;
    let xyz = [x_n * cubed(y + a / 500.0), y_n * cubed(y), z_n * cubed(y - b / 200.0)];
    Some(hex(meter.colour_of(xyz).srgb8))
}

/// The ranges of the valley in words, one for each variable.
pub fn ranges(task: &DesignTask, outcome: &DesignOutcome) -> Vec<String> {
    let named = task.variables.iter().zip(&outcome.valley_ranges);
    named.map(|(v, [low, high])| format!("{} {} … {}", v.name, short(*low), short(*high))).collect()
}

/// What was run for the surfaces, and what they may be wrong by.
fn surfaces_in_words(outcome: &DesignOutcome) -> String {
    if outcome.interpolated.is_empty() {
        return "One run answers for all recipes: nothing is interpolated, and what it may be wrong by is its own error.".to_owned();
    }
    format!(
        "The response surfaces are fitted to {} variants. Each variant left out in turn, they predict its colour with a median error of ΔE₀₀ {:.2}.",
        outcome.variants, outcome.surface_error
    )
}

/// Which variables were composed exactly and which were interpolated; `None` where all were
/// interpolated.
pub fn axes_in_words(outcome: &DesignOutcome) -> Option<String> {
    if outcome.composed.is_empty() {
        return None;
    }
    let composed = format!("composed exactly from the same solves: {}", outcome.composed.join(", "));
    let interpolated = outcome.interpolated_as.map(|what| {
        format!(
            "; interpolated between variants, by {}: {}",
            what.in_words(),
            outcome.interpolated.join(", ")
        )
    });
    Some(format!("{composed}{}", interpolated.unwrap_or_else(|| "; nothing is interpolated".to_owned())))
}

/// Writes all files.
///
/// # Errors
/// A file cannot be written.
pub fn publish(task: &DesignTask, outcome: &DesignOutcome, folder: &OutputFolder) -> PublishResult {
    let names: Vec<&str> = task.variables.iter().map(|v| v.name.as_str()).collect();
    let json = serde_json::json!({
        "title": task.title,
        "variables": names,
        "design": outcome,
        "version": env!("CARGO_PKG_VERSION"),
    });
    folder.write("design.json", &serde_json::to_vec_pretty(&json)?)?;
    let in_lab = |[l, a, b]: [f64; 3]| format!("L* {l:.2}, a* {a:.2}, b* {b:.2}");
    let of_numbers = |wish: &NumberWish| format!("{} {}", wish.name, wish.in_words());
    let errors = outcome.wishes.iter().zip(&outcome.number_errors);
    let errors: Vec<String> =
        errors.map(|(wish, error)| format!("{} {error:.*}", wish.name, decimals(wish) + 1)).collect();
    let tables = RecipeTables::new(task);
    let page = context! {
        title => &task.title,
        met => outcome.met,
        verdict => &outcome.verdict,
        target => outcome.target.map(in_lab),
        patch => outcome.target.and_then(patch),
        wishes => outcome.wishes.iter().map(of_numbers).collect::<Vec<_>>(),
        wanted => outcome.wishes.iter().map(|wish| wish.name.clone()).collect::<Vec<_>>(),
        errors,
        priced => tables.priced,
        variables => tables.headings.iter().map(|heading| heading.words.clone()).collect::<Vec<_>>(),
        verified => outcome.verified.iter().map(|run| tables.verified(run)).collect::<Vec<_>>(),
        valley => outcome.valley.iter().map(|answer| tables.answered(answer)).collect::<Vec<_>>(),
        ranges => ranges(task, outcome),
        left_out => Serde(&outcome.left_out),
        note => surfaces_in_words(outcome),
        axes => axes_in_words(outcome),
        program => made_by(),
    };
    folder.write("report.html", rendered(include_str!("design.html"), page)?.as_bytes())?;
    Ok(folder.complete()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// White, a mid grey and a yellow, whose sRGB is tabulated elsewhere (D65, IEC 61966-2-1): Lab (97.14, −21.55, 94.48) is
    /// `#ffff00`. *Planted*: a and b exchanged.
    #[test]
    fn the_target_has_the_colour_of_its_lab() {
        assert_eq!(patch([100.0, 0.0, 0.0]).as_deref(), Some("#ffffff"));
        assert_eq!(patch([53.59, 0.0, 0.0]).as_deref(), Some("#808080"));
        let yellow = patch([97.14, -21.55, 94.48]).unwrap();
        let channels: Vec<i64> =
            [1, 3, 5].map(|i| i64::from_str_radix(&yellow[i..i + 2], 16).unwrap()).to_vec();
        // The white of 10 nm steps is not quite D65's: a step of a channel or two.
        assert!(
            channels.iter().zip([255, 255, 0]).all(|(found, known)| (found - known).abs() <= 2),
            "{yellow}"
        );
    }
}
