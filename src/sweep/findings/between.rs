//! Variants between the solved settings of an axis that need no solves of their own, because the
//! axis does not reach into the solved layers: paper, light, or the thickness of a layer of solved
//! slabs. The explorer shows them instead of an interpolation.

use super::continuous::{lines, numbers};
use super::kept::KeptPages;
use super::outcome::Outcome;
use crate::evaluate::evaluated::Evaluated;
use crate::input::check::check;
use crate::input::load::read_table;
use crate::run::Stores;
use crate::store::folder::OutputFolder;
use crate::sweep::definition::folder::VARIANTS;
use crate::sweep::definition::load::Sweep;
use crate::work::alone::stored;
use crate::work::variant::Variant;
use std::path::PathBuf;
use toml::{Table, Value};

/// Steps from one setting to the next, the finest first; their halves have no rounding.
const STEPS: [usize; 3] = [8, 4, 2];
/// Largest number of variants between others: they are evaluated one after the other, in some .03 s
/// each, and add 1 kB each to the page.
const MOST: usize = 400;
/// Largest number of them where layers are composed, which take a second each.
const MOST_COMPOSED: usize = 28;

/// What is known between the settings of a sweep's axes.
#[derive(Clone, Debug, Default)]
pub(super) struct VariantsBetween {
    /// Steps from one setting of each axis to the next; 1 where all settings are solved.
    pub steps: Vec<usize>,
    /// The variants between others.
    pub variants: Vec<BetweenVariant>,
}

/// A variant between others.
#[derive(Clone, Debug)]
pub(super) struct BetweenVariant {
    /// Place on every axis, a fraction between two settings.
    pub place: Vec<f64>,
    /// The solved variant next to it.
    pub nearest: usize,
    /// Its numbers.
    pub outcome: Outcome,
}

impl VariantsBetween {
    /// Only the solved settings of `axes` axes.
    fn nothing(axes: usize) -> Self {
        Self { steps: vec![1; axes], variants: Vec::new() }
    }

    /// Evaluates the variants between those of a finished sweep from its store.
    pub fn new(sweep: &Sweep, folder: &OutputFolder, stores: &Stores) -> Self {
        let texts = sweep.texts.iter().map(|text| text.parse()).collect::<Result<Vec<Table>, _>>();
        let nothing = Self::nothing(sweep.outline.axes.len());
        let Ok(texts) = texts else { return nothing };
        let reading = SolvedVariants { sweep, texts, variants: folder.path().join(VARIANTS), stores };
        let steps = reading.steps();
        if steps.iter().all(|&n| n == 1) {
            return nothing;
        }
        let variants: Option<Vec<_>> =
            reading.places(&steps).into_iter().map(|place| reading.variant(place)).collect();
        variants.map_or(nothing, |variants| Self { steps, variants })
    }
}

/// The solved variants of a sweep.
struct SolvedVariants<'a> {
    sweep: &'a Sweep,
    /// Their studies as files.
    texts: Vec<Table>,
    /// The folder that holds theirs, to which names of tables are relative.
    variants: PathBuf,
    stores: &'a Stores,
}

impl SolvedVariants<'_> {
    /// Steps of every axis that needs no other solves, as fine as the number of variants allows.
    fn steps(&self) -> Vec<usize> {
        let axes = self.sweep.outline.axes.len();
        let is_composed = self.sweep.variants.iter().any(|variant| variant.study.composed().is_some());
        let most = if is_composed { MOST_COMPOSED } else { MOST };
        let mut free: Vec<usize> = (0..axes).filter(|&a| self.needs_no_solves(a)).collect();
        while !free.is_empty() {
            for n in STEPS {
                let steps: Vec<usize> = (0..axes).map(|a| if free.contains(&a) { n } else { 1 }).collect();
                if self.places(&steps).len() <= most {
                    return steps;
                }
            }
            free.pop();
        }
        vec![1; axes]
    }

    /// Whether the variants of an axis have common solves, and others between them would have them
    /// too.
    fn needs_no_solves(&self, a: usize) -> bool {
        let axis = &self.sweep.outline.axes[a];
        let (Some(values), Some(lines)) = (numbers(axis), lines(&self.sweep.outline, a)) else {
            return false;
        };
        if values.len() < 2 {
            return false;
        }
        lines.iter().all(|line| {
            let mut place: Vec<f64> =
                self.sweep.outline.variants[line[0]].place.iter().map(|&k| k as f64).collect();
            place[a] += 1.0 / STEPS[0] as f64;
            self.study(&place).is_some_and(|variant| self.is_stored(&variant))
        })
    }

    /// Whether every solve of a variant is stored.
    fn is_stored(&self, Variant { study, .. }: &Variant) -> bool {
        let finished = stored(study, self.stores).map_or(0, |solved| solved.finished());
        finished > 0 && finished == study.solves()
    }

    /// All places between variants.
    fn places(&self, steps: &[usize]) -> Vec<Vec<f64>> {
        let mut places = vec![Vec::new()];
        for (axis, &n) in self.sweep.outline.axes.iter().zip(steps) {
            let last = n * (axis.labels.len() - 1);
            let longer = |place: &Vec<f64>| {
                let place = place.clone();
                (0..=last).map(move |k| [&place[..], &[k as f64 / n as f64]].concat())
            };
            places = places.iter().flat_map(longer).collect();
        }
        places.retain(|place| place.iter().any(|x| x.fract() != 0.0) && self.text(place).is_some());
        places
    }

    /// The solved variant at a place of whole numbers.
    fn solved(&self, place: &[f64]) -> Option<usize> {
        let is_here = |solved: &[usize]| solved.iter().zip(place).all(|(&k, &x)| k as f64 == x);
        self.sweep.outline.variants.iter().position(|variant| is_here(&variant.place))
    }

    /// The study at a place: its numbers lie between those of its neighbours along every axis.
    fn text(&self, place: &[f64]) -> Option<Table> {
        let Some(a) = place.iter().position(|x| x.fract() != 0.0) else {
            return self.solved(place).map(|variant| self.texts[variant].clone());
        };
        let beside = |x: f64| {
            let mut place = place.to_vec();
            place[a] = x;
            self.text(&place)
        };
        let mut below = beside(place[a].floor())?;
        let mut above = beside(place[a].ceil())?;
        for text in [&mut below, &mut above] {
            text.remove("title");
        }
        mixed_tables(&below, &above, place[a].fract())
    }

    /// The checked study at a place; `None` where it is not allowed.
    fn study(&self, place: &[f64]) -> Option<Variant> {
        let nearest = &self.sweep.variants[self.nearest(place)?];
        let name = format!("{} at {place:?}", nearest.name);
        let file = read_table(self.text(place)?).ok()?;
        let study = check(&file, &self.variants.join(&nearest.name), &name).ok()?;
        Some(Variant { name, study: study.in_slabs_of(&nearest.study) })
    }

    fn nearest(&self, place: &[f64]) -> Option<usize> {
        self.solved(&place.iter().map(|x| x.round()).collect::<Vec<f64>>())
    }

    /// The variant at a place; `None` where it has solves of its own.
    fn variant(&self, place: Vec<f64>) -> Option<BetweenVariant> {
        let nearest = self.nearest(&place)?;
        let variant = self.study(&place)?;
        let kept = KeptPages::new(self.stores);
        let nothing = Outcome::of_study(&variant, Vec::new());
        if let Some(outcome) = kept.evaluated(&variant, &nothing) {
            return Some(BetweenVariant { place, nearest, outcome });
        }
        let solved = stored(&variant.study, self.stores)?;
        let evaluated = Evaluated::new(&variant.study, &solved).ok()?;
        let outcome = nothing.with(&evaluated.manifest);
        if !outcome.is_complete() || outcome.reason.is_some() {
            return None;
        }
        // a record that cannot be written is made again
        let _ = kept.keep_evaluated(&variant, &outcome);
        Some(BetweenVariant { place, nearest, outcome })
    }
}

/// The table whose numbers lie at `t` = 0…1 between those of two others; `None` if anything but
/// numbers differs.
fn mixed_tables(one: &Table, other: &Table, t: f64) -> Option<Table> {
    let same_keys = one.len() == other.len();
    let entry = |(key, value): (&String, &Value)| Some((key.clone(), mixed(value, other.get(key)?, t)?));
    one.iter().map(entry).collect::<Option<Table>>().filter(|_| same_keys)
}

fn mixed(one: &Value, other: &Value, t: f64) -> Option<Value> {
    if one == other {
        return Some(one.clone());
    }
    match (one, other) {
        (Value::Table(one), Value::Table(other)) => mixed_tables(one, other, t).map(Value::Table),
        (Value::Array(one), Value::Array(other)) if one.len() == other.len() => {
            let entries = one.iter().zip(other).map(|(one, other)| mixed(one, other, t));
            entries.collect::<Option<_>>().map(Value::Array)
        }
        _ => {
            let (one, other) = (number(one)?, number(other)?);
            Some(Value::Float(one + t * (other - one)))
        }
    }
}

fn number(value: &Value) -> Option<f64> {
    value.as_float().or_else(|| value.as_integer().map(|n| n as f64))
}

#[cfg(test)]
mod tests {
    use super::mixed_tables;
    use toml::Table;

    /// *Planted*: words of the first study are taken where they differ.
    #[test]
    fn numbers_lie_between_and_everything_else_is_the_same() {
        let table = |text: &str| text.parse::<Table>().expect("a table");
        let one =
            table("paper.albedo = 0.5\nlayer.thickness_um = 1\n[[pigment]]\nname = 'red'\nn = [1, 2.0]");
        let other =
            table("paper.albedo = 0.9\nlayer.thickness_um = 2\n[[pigment]]\nname = 'red'\nn = [1, 4.0]");
        let between =
            table("paper.albedo = 0.6\nlayer.thickness_um = 1.25\n[[pigment]]\nname = 'red'\nn = [1, 2.5]");
        assert_eq!(mixed_tables(&one, &other, 0.25), Some(between));
        let words = |word: &str| table(&format!("name = '{word}'\nx = 1"));
        assert_eq!(mixed_tables(&words("red"), &words("blue"), 0.5), None);
        assert_eq!(mixed_tables(&one, &words("red"), 0.5), None);
        assert_eq!(mixed_tables(&table("n = [1.0]"), &table("n = [1.0, 2.0]"), 0.5), None);
    }
}
