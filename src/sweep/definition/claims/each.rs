//! Repeats a conclusion for every value of an axis.

use crate::input::fault::Faults;
use crate::sweep::definition::axes::{Axis, names};
use crate::sweep::definition::file::{ConclusionTable, SweepFile};

/// All conclusions, each with the index of the table that defines it.
pub fn expanded(file: &SweepFile, axes: &[Axis], faults: &mut Faults) -> Vec<(usize, ConclusionTable)> {
    let mut all = Vec::new();
    for (i, table) in file.conclusion.iter().enumerate() {
        let Some(name) = &table.each else {
            all.push((i, table.clone()));
            continue;
        };
        match axes.iter().find(|axis| axis.name == *name) {
            Some(axis) => all.extend(axis.settings.iter().map(|s| (i, of_label(table, name, &s.label)))),
            None => {
                let (field, allowed) = (format!("conclusion[{i}].each"), format!("one of {}", names(axes)));
                faults.add(field, format!("{name:?}"), allowed, "name one of the axes");
            }
        }
    }
    all
}

/// The conclusion for one label; conditions that name the axis are left unchanged.
fn of_label(table: &ConclusionTable, axis: &str, label: &str) -> ConclusionTable {
    let mut one = table.clone();
    one.id = format!("{label}: {}", table.id);
    let lists = [&mut one.plus, &mut one.minus, &mut one.among];
    for condition in lists.into_iter().flatten().chain(&mut one.absorbed_by) {
        condition.entry(axis.to_owned()).or_insert_with(|| label.into());
    }
    one
}
