//! A stack without each of its layers, each of them alone, and their densities.

use super::rows::ThicknessRows;
use crate::evaluate::composed::numbers::LayerTask;
use crate::evaluate::manifest::left_out::{DensityRow, LeftOutColours, LeftOutNotes, LeftOutRow, StackPart};
use crate::evaluate::published::{ErrorParts, Withheld};
use crate::evaluate::quantities::{LeftOutNumbers, ThicknessNumbers};

impl LeftOutNotes {
    pub(super) fn new(
        task: &LayerTask,
        numbers: &[LeftOutNumbers<ErrorParts>],
        withheld: &mut Vec<Withheld>,
    ) -> Self {
        let mut all = Self::default();
        for (&um, numbers) in task.composed.thicknesses_um.iter().zip(numbers) {
            let mut judged = |part: StackPart, name: &str, numbers: &ThicknessNumbers<ErrorParts>| {
                let mut rows = ThicknessRows::default();
                rows.add(task, um, numbers);
                let reasons = std::mem::take(&mut rows.withheld).into_iter();
                withheld.extend(reasons.map(|reason| part.withheld(name, reason)));
                rows
            };
            let mut layers = Vec::new();
            for (k, layer) in task.study.stack.iter().enumerate() {
                let without = judged(StackPart::Without, &layer.name, &numbers.without[k]);
                let alone = judged(StackPart::Alone, &layer.name, &numbers.alone[k]);
                layers.push((layer.name.clone(), without, alone));
            }
            for (w, &wavelength_nm) in task.study.wavelengths_nm.iter().enumerate() {
                all.rows.extend(layers.iter().map(|(layer, without, alone)| LeftOutRow {
                    thickness_um: um,
                    wavelength_nm,
                    layer: layer.clone(),
                    lit_at_45_without: without.rows[w].layer.lit_at_45,
                    natural_light_without: without.rows[w].layer.natural_light,
                    lit_at_45_alone: alone.rows[w].layer.lit_at_45,
                    natural_light_alone: alone.rows[w].layer.natural_light,
                }));
                all.densities.push(DensityRow::new([um, wavelength_nm], numbers.densities[w]));
            }
            for (layer, without, alone) in layers {
                let without = without.colours.into_iter().next();
                let alone = alone.colours.into_iter().next();
                if without.is_some() || alone.is_some() {
                    all.colours.push(LeftOutColours { layer, without, alone });
                }
            }
        }
        all
    }
}
