//! Axes of a sweep: turns lists, ranges and cases into labelled settings.

use super::file::{AxisTable, CaseTable};
use crate::input::fault::{Allowed, EMPTY_LIST, Faults};
use std::cmp::Ordering;
use toml::{Table, Value};

/// Maximum number of values of an axis.
const LONGEST_AXIS: usize = 10_000;

/// An axis with checked values.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// Name of the axis.
    pub name: String,
    /// Name shared by axes that advance together.
    pub zip: Option<String>,
    /// Unit of numeric values: "nm", "µm", "°"; otherwise empty.
    pub unit: String,
    /// Its settings, in order.
    pub settings: Vec<AxisSetting>,
}

/// One value of an axis.
#[derive(Clone, Debug, PartialEq)]
pub struct AxisSetting {
    /// Label of the setting, in names and on contact sheets.
    pub label: String,
    /// The value as text; conditions may use it too.
    pub value: String,
    /// Fields of the study and their values.
    pub set: Table,
}

impl Axis {
    /// Reads the `i`-th `[[axis]]`.
    pub fn read(i: usize, table: &AxisTable, faults: &mut Faults) -> Self {
        let place = |key: &str| format!("axis[{i}].{key}");
        let name = table.name.clone().or_else(|| {
            table.field.as_ref().map(|field| field.rsplit(['.', ']']).next().unwrap_or(field).to_owned())
        });
        let settings = match (&table.field, table.case.is_empty()) {
            (Some(field), true) => values(i, field, table, faults),
            (None, false) => table.case.iter().map(of_case).collect(),
            _ => {
                let allowed = "either a field with its values, or [[axis.case]] entries";
                let remedy = "write for example field = \"pigment[0].diameter_nm\" and values = [100, 300]";
                let found = if table.field.is_some() { "field and cases" } else { "none of them" };
                faults.add(place("field"), found, allowed, remedy);
                Vec::new()
            }
        };
        let name = name.unwrap_or_else(|| {
            let remedy = "write for example name = \"ink\"";
            faults.add(place("name"), "nothing", "a name for an axis of cases", remedy);
            String::new()
        });
        let unit = table.field.as_ref().map_or("", |field| unit(field, &settings)).to_owned();
        let axis = Self { name, zip: table.zip.clone(), unit, settings };
        axis.check_labels(&place("labels"), faults);
        axis
    }

    fn check_labels(&self, field: &str, faults: &mut Faults) {
        let labels: Vec<&str> = self.settings.iter().map(|setting| setting.label.as_str()).collect();
        for (k, label) in labels.iter().enumerate() {
            faults.name(field.to_owned(), label, labels[..k].iter().copied(), "value of the axis");
        }
    }

    /// Indices of the settings that a condition selects by label, by value or by a list of them.
    pub fn matching(&self, selected: &Value) -> Vec<usize> {
        let all = match selected {
            Value::Array(list) => list.iter().map(in_words).collect(),
            one => vec![in_words(one)],
        };
        let fits = |s: &AxisSetting| all.iter().any(|word| *word == s.label || *word == s.value);
        (0..self.settings.len()).filter(|&k| fits(&self.settings[k])).collect()
    }
}

/// Suffixes of field names and the units they stand for.
const UNITS: [(&str, &str); 3] = [("_nm", "nm"), ("_um", "µm"), ("_deg", "°")];

/// The unit of a field's values; empty if the values have labels, which may contain units.
fn unit(field: &str, settings: &[AxisSetting]) -> &'static str {
    let bare = settings.iter().all(|s| s.label == s.value);
    UNITS.iter().find(|(end, _)| bare && field.ends_with(end)).map_or("", |(_, unit)| unit)
}

/// The name without its unit suffix.
pub(super) fn plain(name: &str) -> &str {
    UNITS.iter().find_map(|(end, _)| name.strip_suffix(end)).unwrap_or(name)
}

/// The names of all axes.
pub(super) fn names(axes: &[Axis]) -> String {
    format!("the axes {}", axes.iter().map(|axis| axis.name.as_str()).collect::<Vec<_>>().join(", "))
}

impl AxisTable {
    /// Which keys of values there are.
    fn values_in_words(&self) -> String {
        let keys = [
            ("values", self.values.is_some()),
            ("from", self.from.is_some()),
            ("to", self.to.is_some()),
            ("step", self.step.is_some()),
            ("count", self.count.is_some()),
        ];
        let keys: Vec<&str> =
            keys.into_iter().filter(|(_, is_there)| *is_there).map(|(key, _)| key).collect();
        match keys.as_slice() {
            [] => "none of these keys".to_owned(),
            ["values"] => EMPTY_LIST.to_owned(),
            keys => keys.join(" and "),
        }
    }
}

fn of_case(case: &CaseTable) -> AxisSetting {
    AxisSetting { label: case.label.clone(), value: case.label.clone(), set: case.set.clone() }
}

fn values(i: usize, field: &str, table: &AxisTable, faults: &mut Faults) -> Vec<AxisSetting> {
    let before = faults.0.len();
    let list = match (&table.values, table.from, table.to) {
        (Some(values), None, None) if table.step.is_none() && table.count.is_none() => values.clone(),
        (None, Some(from), Some(to)) => range(i, table, from, to, faults),
        _ => Vec::new(),
    };
    if list.is_empty() && faults.0.len() == before {
        let found = table.values_in_words();
        let allowed = "either values = […], or from, to and one of step and count";
        let remedy = "write for example values = [100, 300]";
        faults.add(format!("axis[{i}].values"), found, allowed, remedy);
    }
    if let Some(labels) = table.labels.as_ref().filter(|labels| labels.len() != list.len()) {
        let found = format!("{} labels", labels.len());
        let allowed = format!("{} labels", list.len());
        faults.add(format!("axis[{i}].labels"), found, allowed, "one label for each value");
    }
    let setting = |(k, value): (usize, &Value)| AxisSetting {
        label: table.labels.as_ref().and_then(|l| l.get(k).cloned()).unwrap_or_else(|| in_words(value)),
        value: in_words(value),
        set: Table::from_iter([(field.to_owned(), value.clone())]),
    };
    list.iter().enumerate().map(setting).collect()
}

fn range(i: usize, table: &AxisTable, from: f64, to: f64, faults: &mut Faults) -> Vec<Value> {
    let before = faults.0.len();
    let count = match (table.step, table.count) {
        (Some(step), None) => {
            let allowed = Allowed::above(0.0, f64::MAX, "");
            faults.number(&format!("axis[{i}].step"), step, allowed, "a step from `from` towards `to`");
            ((to - from) / step + 1e-9).floor() + 1.0
        }
        (None, Some(1)) if from != to => {
            let found = format!("1 from {from} to {to}");
            let allowed = "2 or more, which begin and end there";
            faults.add(format!("axis[{i}].count"), found, allowed, "or write values = […]");
            return Vec::new();
        }
        (None, Some(count)) => count as f64,
        _ => return Vec::new(),
    };
    let key = if table.count.is_some() { "count" } else { "step" };
    if to.partial_cmp(&from).is_none_or(Ordering::is_lt) {
        let allowed = format!("a number from from = {from} on");
        faults.add(format!("axis[{i}].to"), to, allowed, "write the smaller number as from");
    } else if !(1.0..=LONGEST_AXIS as f64).contains(&count) && faults.0.len() == before {
        let found = format!("{} from {from} to {to}: {count} values", table.step.unwrap_or(count));
        let allowed = format!("1 to {LONGEST_AXIS} values");
        faults.add(format!("axis[{i}].{key}"), found, allowed, "a sweep has one study for each value");
    }
    if faults.0.len() > before {
        return Vec::new();
    }
    let step = table.step.unwrap_or(if count > 1.0 { (to - from) / (count - 1.0) } else { 0.0 });
    // Rounded to twelve digits: 0.15 + 3 × 0.05 must give 0.3.
    let rounded = |x: f64| format!("{x:.11e}").parse::<f64>().unwrap_or(x);
    let last = rounded(from + (count - 1.0) * step);
    if to - last > 1e-6 * step {
        let found = format!("{step} from {from}, which ends at {last} before {to}");
        let remedy = format!("write to = {last}, or count in place of step");
        faults.add(format!("axis[{i}].step"), found, "a step that reaches `to`", remedy);
        return Vec::new();
    }
    (0..count as usize).map(|k| Value::Float(rounded(from + k as f64 * step))).collect()
}

/// Formats a value the way people write it: 100 and 100.0 are equal.
pub fn in_words(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        Value::Float(x) => x.to_string(),
        other => other.to_string(),
    }
}
