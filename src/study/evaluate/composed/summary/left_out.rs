//! A stack without each of its layers, each of them alone, and their densities.

use super::rows::ThicknessRows;
use crate::evaluate::composed::numbers::LayerTask;
use crate::evaluate::manifest::composed::{DensityRow, LeftOutColours, LeftOutNotes, LeftOutRow};
use crate::evaluate::published::{ErrorParts, Withheld};
use crate::evaluate::quantities::{DensityNumbers, LeftOutNumbers, ThicknessNumbers};

/// Sums of densities below this are too small to divide by.
const FAINT_DENSITY: f64 = 0.05;

impl LeftOutNotes {
    pub(super) fn new(
        task: &LayerTask,
        numbers: &[LeftOutNumbers<ErrorParts>],
        withheld: &mut Vec<Withheld>,
    ) -> Self {
        let mut all = Self::default();
        for (&um, numbers) in task.composed.thicknesses_um.iter().zip(numbers) {
            for (w, &wavelength_nm) in task.study.wavelengths_nm.iter().enumerate() {
                for (k, layer) in task.study.stack.iter().enumerate() {
                    let without = numbers.without[k].spectra[w];
                    let alone = numbers.alone[k].spectra[w];
                    all.rows.push(LeftOutRow {
                        thickness_um: um,
                        wavelength_nm,
                        layer: layer.name.clone(),
                        lit_at_45_without: without.lit_at_45,
                        natural_light_without: without.natural_light,
                        lit_at_45_alone: alone.lit_at_45,
                        natural_light_alone: alone.natural_light,
                    });
                }
                all.densities.push(density_row([um, wavelength_nm], numbers.densities[w]));
            }
            for (k, layer) in task.study.stack.iter().enumerate() {
                let mut colours = |numbers: &ThicknessNumbers<ErrorParts>, words: &str| {
                    let mut layers = ThicknessRows::default();
                    layers.add(task, um, numbers);
                    withheld.extend(layers.withheld.into_iter().map(|reason| Withheld {
                        number: format!("{} {words} {}", reason.number, layer.name),
                        ..reason
                    }));
                    layers.colours.pop()
                };
                let without = colours(&numbers.without[k], "without");
                let alone = colours(&numbers.alone[k], "of only");
                if without.is_some() || alone.is_some() {
                    all.colours.push(LeftOutColours { layer: layer.name.clone(), without, alone });
                }
            }
        }
        all
    }
}

fn density_row([thickness_um, wavelength_nm]: [f64; 2], numbers: DensityNumbers<ErrorParts>) -> DensityRow {
    let DensityNumbers { stack, layers, ratio } = numbers;
    DensityRow {
        thickness_um,
        wavelength_nm,
        density_of_stack: stack,
        density_of_layers: layers,
        density_ratio: (layers.value > FAINT_DENSITY).then_some(ratio),
    }
}
