//! Repeats a conclusion for every value of an axis.

use crate::input::fault::{Fault, Faults};
use crate::sweep::definition::axes::Axis;
use crate::sweep::definition::file::{ConclusionTable, Where};
use toml::Value;

/// All conclusions, each with the index of the table that defines it.
pub(super) fn expanded(
    tables: &[ConclusionTable],
    axes: &[Axis],
    faults: &mut Faults,
) -> Vec<(usize, ConclusionTable)> {
    let mut all = Vec::new();
    for (i, table) in tables.iter().enumerate() {
        let Some(name) = &table.each else {
            all.push((i, table.clone()));
            continue;
        };
        match axes.iter().find(|axis| axis.name == *name) {
            Some(axis) => all.extend(axis.settings.iter().map(|s| (i, of_label(table, name, &s.label)))),
            None => faults.push(unknown(i, name, axes)),
        }
    }
    all
}

fn unknown(i: usize, name: &str, axes: &[Axis]) -> Fault {
    let names: Vec<&str> = axes.iter().map(|axis| axis.name.as_str()).collect();
    let allowed = format!("one of the axes {}", names.join(", "));
    Fault::new(format!("conclusion[{i}].each"), format!("{name:?}"), allowed, "name one of the axes")
}

/// The conclusion for one label; conditions that name the axis are left unchanged.
fn of_label(table: &ConclusionTable, axis: &str, label: &str) -> ConclusionTable {
    let mut one = table.clone();
    one.id = format!("{label}: {}", table.id);
    let lists = [&mut one.plus, &mut one.minus, &mut one.among];
    for condition in lists.into_iter().flatten().chain(&mut one.absorbed_by) {
        add(condition, axis, label);
    }
    one
}

fn add(condition: &mut Where, axis: &str, label: &str) {
    condition.entry(axis.to_owned()).or_insert_with(|| Value::String(label.to_owned()));
}
