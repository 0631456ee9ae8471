//! Recipes: points of the box of what varies, and the studies they stand for.

mod axes;
mod target;

use super::file::{DesignFile, DesignTable, VaryTable};
use super::surface::most_coefficients;
use super::wish::NumberWish;
use crate::input::check::check;
use crate::input::fault::{Fault, Faults, StudyError, keys_in_words};
use crate::input::field::set;
use crate::input::limits;
use crate::input::load::{read_file, read_table, stem};
use crate::input::locate::steps;
use crate::input::measured::MeasuredCondition;
use crate::input::study::Study;
use crate::numerics::allowed::{Allowed, Whole};
use crate::store::identity::Key;
use std::path::{Path, PathBuf};
use target::{checked_ends, put_target};
use toml::{Table, Value};

/// Largest number of fields that may vary: surfaces need a multiple of its square in variants.
const MOST_FIELDS: usize = 5;
/// Range over whose ends' ratio a field is taken by its logarithm.
const LOGARITHMIC: f64 = 1.5;
/// Weight of a missed contrast ratio, ΔE₀₀ for each percent.
const OF_CONTRAST: f64 = 100.0;

/// One number that varies.
#[derive(Clone, Debug)]
pub struct Variable {
    /// For people.
    pub name: String,
    /// As written.
    pub written: VaryTable,
    /// Whether it enters after the solves, so that every value of it is composed exactly from the
    /// same solves; else it is interpolated between variants.
    pub composed: bool,
    /// Whether a thickness is written beside the smallest one, which sets the slabs of all.
    listed: bool,
    /// Whether steps along it are steps of its logarithm.
    logarithmic: bool,
}

impl Variable {
    /// A value as the study has it.
    fn as_written(&self, value: f64) -> Value {
        let first = self.written.from;
        if self.listed && value > first { vec![first, value].into() } else { Value::Float(value) }
    }

    /// The value at a place of the box, 0 to 1.
    pub fn value(&self, place: f64) -> f64 {
        let (from, to) = (self.written.from, self.written.to);
        if self.logarithmic { from * (to / from).powf(place) } else { from + (to - from) * place }
    }
}

/// A checked design.
#[derive(Clone, Debug)]
pub struct DesignTask {
    /// Title, for people.
    pub title: String,
    /// What varies.
    pub variables: Vec<Variable>,
    /// How recipes are sought.
    pub settings: DesignTable,
    /// L*, a*, b* of the target; none where numbers alone are wanted.
    pub lab: Option<[f64; 3]>,
    /// Least contrast ratio.
    pub contrast_ratio: Option<f64>,
    /// Weighted numbers that are wanted.
    pub numbers: Vec<NumberWish>,
    /// What was taken where files leave something open.
    pub remarks: Vec<String>,
    /// The light under which the target was measured, where the base names none.
    condition: Option<MeasuredCondition>,
    base: Table,
    folder: PathBuf,
}

impl DesignTask {
    /// Number of variants that the surfaces rest on: one where nothing is interpolated.
    pub fn variants(&self) -> usize {
        let interpolated = self.interpolated().count();
        if interpolated == 0 {
            return 1;
        }
        let needed = most_coefficients(interpolated);
        self.settings.variants.unwrap_or(needed + needed.div_ceil(2) + 3)
    }

    /// Hash of all that the design depends on.
    pub fn key(&self) -> String {
        let varied: Vec<&VaryTable> = self.variables.iter().map(|variable| &variable.written).collect();
        let wish = (&self.title, self.lab, self.contrast_ratio, &self.settings);
        // the study for the content of files that the base names
        let middle = self.study(&vec![0.5; self.variables.len()]).ok().map(|study| study.key());
        let middle = middle.as_ref().map(Key::as_str);
        let whole = (self.base.to_string(), varied, wish, middle);
        if self.numbers.is_empty() {
            return Key::of("design", &whole).to_string();
        }
        let wanted: Vec<_> = self.numbers.iter().map(|wish| (wish, &wish.wanted)).collect();
        Key::of("design", &(whole, wanted)).to_string()
    }

    /// The study of a recipe, at places from 0 to 1.
    ///
    /// # Errors
    /// Faults of its values.
    pub fn study(&self, places: &[f64]) -> Result<Study, Vec<Fault>> {
        let mut table = self.base.clone();
        // ratios divide what other fields may have set
        let mut all: Vec<(&Variable, f64)> = self.variables.iter().zip(self.values(places)).collect();
        all.sort_by_key(|(variable, _)| variable.written.ratio.is_some());
        for (variable, value) in all {
            let put = match &variable.written.ratio {
                Some(pair) => mix(&mut table, pair, value),
                None => set(&mut table, &variable.name, &variable.as_written(value)),
            };
            let remedy = "name a field of the study, as in a sweep";
            put.map_err(|e| vec![Fault::new(&variable.name, e, "a field of the base", remedy)])?;
        }
        let name = self.in_words(places);
        table.insert("title".into(), Value::String(name.clone()));
        let mut study = check(&read_table(table)?, &self.folder, &name)?;
        study.judgement.condition = study.judgement.condition.or(self.condition);
        study.without_layers = false; // a recipe is the whole print
        let is_listed = self.variables.iter().any(|variable| variable.listed);
        if is_listed {
            // the recipe's own thickness, with the slabs of the first one
            study.request_um(study.requested_um().pop().into_iter().collect());
        }
        Ok(study)
    }

    /// Value of every variable of a recipe.
    pub fn values(&self, places: &[f64]) -> Vec<f64> {
        self.variables.iter().zip(places).map(|(variable, &place)| variable.value(place)).collect()
    }

    /// The recipe in words.
    pub fn in_words(&self, places: &[f64]) -> String {
        let named = self.variables.iter().zip(self.values(places));
        named.map(|(v, value)| format!("{} {}", v.name, short(value))).collect::<Vec<_>>().join(", ")
    }

    /// Cost of a recipe.
    pub fn cost(&self, places: &[f64]) -> f64 {
        self.variables.iter().zip(self.values(places)).map(|(v, value)| v.written.cost * value).sum()
    }

    /// Whether a contrast ratio hides enough.
    pub fn hides(&self, ratio: f64) -> bool {
        self.contrast_ratio.is_none_or(|least| ratio >= least)
    }

    /// What is to be small: the distance to the target, and what is missing in contrast.
    pub fn miss(&self, delta_e: Option<f64>, ratio: f64) -> f64 {
        let missing = self.contrast_ratio.map_or(0.0, |least| (least - ratio).max(0.0));
        delta_e.unwrap_or(0.0) + OF_CONTRAST * missing
    }

    /// How far numbers, in the order of the wishes, are from their ranges, in steps that count as
    /// much as a ΔE₀₀ of 1.
    pub fn lack(&self, numbers: &[f64]) -> f64 {
        self.numbers.iter().zip(numbers).map(|(wish, &value)| wish.lack(value)).sum()
    }
}

/// Corner number `c` of the box.
pub fn corner(c: usize, variables: usize) -> Vec<f64> {
    (0..variables).map(|i| ((c >> i) & 1) as f64).collect()
}

/// Four significant digits.
pub fn short(value: f64) -> String {
    let digits = (3 - value.abs().max(1e-12).log10().floor() as i32).clamp(0, 6) as usize;
    format!("{value:.digits$}")
}

/// Divides the sum of two pigments' volume fractions.
fn mix(table: &mut Table, [one, other]: &[String; 2], share: f64) -> Result<(), String> {
    let sum = fraction(table, one)? + fraction(table, other)?;
    set(table, &format!("pigment.{one}.volume_fraction"), &Value::Float(sum * share))?;
    set(table, &format!("pigment.{other}.volume_fraction"), &Value::Float(sum * (1.0 - share)))
}

/// The volume fraction of a pigment.
fn fraction(table: &Table, name: &String) -> Result<f64, String> {
    let pigments = table.get("pigment").and_then(Value::as_array).into_iter().flatten();
    let mut named = pigments.filter(|p| p.get("name").and_then(Value::as_str) == Some(name));
    let value = named.next().and_then(|p| p.get("volume_fraction"));
    let value = value.and_then(|v| v.as_float().or(v.as_integer().map(|i| i as f64)));
    value.ok_or_else(|| format!("no pigment {name:?} with a volume fraction"))
}

/// Reads and checks the file of a design.
///
/// # Errors
/// The file or its base cannot be read, or values are not allowed, also at the ends of the ranges.
pub fn load(path: &Path) -> Result<DesignTask, StudyError> {
    let (text, file): (String, DesignFile) = read_file(path)?;
    let beside = path.parent().unwrap_or(Path::new(""));
    let (mut base, folder) = file.base.read(beside)?;
    let mut faults = Faults::default();
    let is_apart = target::is_composed(&base) && file.target.file.is_some();
    let mut measuring = if is_apart { target::uncomposed(&base) } else { base.clone() };
    put_target(&mut measuring, &file.target, beside, &mut faults);
    if is_apart {
        base.remove("compare");
    } else {
        base = measuring.clone();
    }
    faults.title(file.title.as_deref());
    let variables = variables(&file.vary, &mut faults);
    check_twice(&base, &file.vary, &mut faults);
    check_settings(&file, &mut faults);
    let title = file.title.clone().unwrap_or_else(|| stem(path));
    let settings = file.design.clone();
    let contrast_ratio = file.target.contrast_ratio;
    let mut task = DesignTask {
        title,
        variables,
        settings,
        lab: None,
        contrast_ratio,
        numbers: Vec::new(),
        remarks: Vec::new(),
        condition: None,
        base,
        folder,
    };
    if faults.0.is_empty() {
        match checked_ends(&task, &file.target, &measuring) {
            Ok(target) => {
                task.lab = target.lab;
                task.numbers = target.numbers;
                task.remarks = target.remarks;
                task.condition = target.condition;
                task.tell_axes_apart();
                check_variants(&mut task, &mut faults);
            }
            Err(of_study) => faults.0.extend(of_study.into_iter().map(|fault| place_of(fault, &file))),
        }
    }
    if faults.0.is_empty() {
        return Ok(task);
    }
    Err(StudyError::Values { path: path.to_owned(), text, faults: faults.0 })
}

fn variables(tables: &[VaryTable], faults: &mut Faults) -> Vec<Variable> {
    if tables.is_empty() || tables.len() > MOST_FIELDS {
        let allowed = format!("1 to {MOST_FIELDS} [[vary]] with field (or ratio), from and to");
        faults.add("vary", tables.len(), allowed, "vary what moves the colour most");
    }
    let mut all = Vec::new();
    for (i, table) in tables.iter().enumerate() {
        let name = match (&table.field, &table.ratio) {
            (Some(field), None) => field.clone(),
            (None, Some([one, other])) if one != other => format!("{one} : ({one} + {other})"),
            (None, Some(_)) => {
                let field = format!("vary[{i}].ratio");
                faults.add(field, "one pigment twice", "two pigments' names", "name another one");
                continue;
            }
            _ => {
                let found = keys_in_words(table, &["field", "ratio"]);
                let remedy = "write for example field = \"layer.thickness_um\"";
                faults.add(format!("vary[{i}]"), found, "either field or ratio", remedy);
                continue;
            }
        };
        if let Some(field) = table.field.as_ref().filter(|field| !is_of_the_solid(field)) {
            let allowed = "a field of the layer, its pigments or the paper, which move the colour of the solid that a design aims at";
            let remedy = "a run of the recipe has its tints: [[area]] coverage = [0.1, 0.2, …]";
            faults.add(format!("vary[{i}].field"), format!("{field:?}"), allowed, remedy);
            continue;
        }
        let (from, to) = (table.from, table.to);
        if !(from.is_finite() && to.is_finite() && from < to) {
            let found = format!("{from} to {to}");
            let remedy =
                if from > to { "exchange from and to" } else { "write for example from = 0.1, to = 0.4" };
            faults.add(format!("vary[{i}].from"), found, "two finite numbers, from below to", remedy);
        }
        if table.ratio.is_some() && !(from > 0.0 && to < 1.0) {
            let allowed = "above 0 and below 1: both pigments stay";
            faults.add(format!("vary[{i}]"), format!("{from} to {to}"), allowed, "try 0.1 to 0.9");
        }
        let logarithmic = from > 0.0 && to / from > LOGARITHMIC && table.ratio.is_none();
        let (composed, listed) = (false, false);
        all.push(Variable { name, written: table.clone(), composed, listed, logarithmic });
    }
    all
}

/// Reports a field that varies twice, under whatever names: set to a value that no field has, both
/// give one study.
fn check_twice(base: &Table, vary: &[VaryTable], faults: &mut Faults) {
    const UNUSED: f64 = 0.387_420_489;
    let with = |table: &VaryTable| {
        let mut study = base.clone();
        set(&mut study, table.field.as_ref()?, &Value::Float(UNUSED)).ok().map(|()| study)
    };
    for (i, table) in vary.iter().enumerate() {
        let here = with(table);
        let is_alike = |other: &&VaryTable| here.is_some() && with(other) == here;
        if let Some(other) = vary[..i].iter().find(is_alike) {
            let names = [table, other].map(|table| table.field.clone().unwrap_or_default());
            let found = format!("{:?} beside {:?}", names[0], names[1]);
            let allowed = "every field once";
            faults.add(format!("vary[{i}].field"), found, allowed, "remove one of the two");
        }
    }
}

/// Whether a field belongs to what a solid is printed with: neither to its dots nor to how it is
/// solved and shown.
fn is_of_the_solid(field: &str) -> bool {
    let table = steps(field).next().unwrap_or_default();
    ["layer", "stack", "pigment", "packing", "paper"].contains(&table)
}

fn check_settings(file: &DesignFile, faults: &mut Faults) {
    let DesignTable { delta_e, verifications, realisations, .. } = file.design;
    let usual = "0.5 is hard to see";
    faults.number("design.delta_e", delta_e, Allowed::between(0.05, 20.0, ""), usual);
    faults.whole("design.verifications", verifications, Whole::between(1, 50), "4 is usual");
    let remedy = "leave it out: that of the base";
    faults.whole("design.realisations", realisations.unwrap_or(1), limits::REALISATIONS, remedy);
}

/// Checks the number of variants, once it is known which variables are interpolated between them.
fn check_variants(task: &mut DesignTask, faults: &mut Faults) {
    let Some(count) = task.settings.variants else { return };
    let interpolated = task.interpolated().count();
    if interpolated == 0 && count > 1 {
        task.remarks.push(format!(
            "design.variants = {count}: one run is enough, because all that varies is composed from its solves"
        ));
        return;
    }
    let needed = if interpolated == 0 { 1 } else { most_coefficients(interpolated) + 2 };
    let remedy = "leave it out: the default is 1.5 times the number of coefficients of the surfaces";
    faults.whole("design.variants", count, Whole::between(needed, 1000), remedy);
}

/// A fault of a study as one of the design's file.
fn place_of(fault: Fault, file: &DesignFile) -> Fault {
    let target =
        ["compare", "colour.target_lab", "target"].iter().any(|start| fault.field.starts_with(start));
    let place = match file.vary.iter().position(|table| {
        let field = table.field.as_deref().unwrap_or("volume_fraction");
        steps(field).last().is_some_and(|end| fault.field.ends_with(end))
    }) {
        // of the design's own checks
        _ if ["target.", "base."].iter().any(|start| fault.field.starts_with(start)) => fault.field.clone(),
        _ if target => "target".to_owned(),
        Some(i) => format!("vary[{i}]"),
        None => format!("base.{}", fault.field),
    };
    let renamed = |text: &str| text.replace("compare.", "target.").replace("colour.target_lab", "target.lab");
    let found = renamed(&fault.found);
    let allowed = renamed(&fault.allowed);
    let remedy = renamed(&fault.remedy);
    let found = if place.starts_with("vary") { format!("{found} for {}", fault.field) } else { found };
    Fault { field: place, found, allowed, remedy }
}
