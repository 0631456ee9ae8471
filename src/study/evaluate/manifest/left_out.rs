//! What is published of a stack without each of its layers and of each of them alone, whichever
//! evaluator made it.

use super::composed::ComposedColours;
use crate::evaluate::published::{ErrorParts, Withheld};
use crate::evaluate::quantities::DensityNumbers;
use crate::input::study::Study;
use serde::Serialize;

/// Sums of densities below this are too small to divide by.
const FAINT_DENSITY: f64 = 0.05;

/// A stack on its paper without one of its layers, and that layer alone, at one wavelength. `null`
/// is a number that cannot be, or that is not solved yet.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LeftOutRow {
    /// Thickness of the varied layer, or of the stack, µm.
    pub thickness_um: f64,
    /// Vacuum wavelength, nm.
    pub wavelength_nm: f64,
    /// Name of the layer.
    pub layer: String,
    /// Without it, lit at 45° and seen along the normal: π × BRDF.
    pub lit_at_45_without: Option<ErrorParts>,
    /// Without it, under a uniform sky.
    pub natural_light_without: Option<ErrorParts>,
    /// It alone, lit at 45° and seen along the normal.
    pub lit_at_45_alone: Option<ErrorParts>,
    /// It alone, under a uniform sky.
    pub natural_light_alone: Option<ErrorParts>,
}

/// Colours of a stack without one of its layers, and of that layer alone.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LeftOutColours {
    /// Name of the layer.
    pub layer: String,
    /// The stack without it.
    pub without: Option<ComposedColours>,
    /// It alone; its contrast ratio is what it hides by itself.
    pub alone: Option<ComposedColours>,
}

/// Densities of a stack at 45:0 and one wavelength, against the bare paper. `null` is a number that
/// cannot be, or that is not solved yet.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DensityRow {
    /// Thickness of the varied layer, or of the stack, µm.
    pub thickness_um: f64,
    /// Vacuum wavelength, nm.
    pub wavelength_nm: f64,
    /// −log₁₀ of the radiance factor over that of the bare paper.
    pub density_of_stack: Option<ErrorParts>,
    /// The sum of those of the layers, each alone.
    pub density_of_layers: Option<ErrorParts>,
    /// The first over the second; `None` where the second is too small for a quotient.
    pub density_ratio: Option<ErrorParts>,
}

impl DensityRow {
    /// The densities at one place, thickness in µm and wavelength in nm, as far as they are
    /// numbers.
    pub(in crate::evaluate) fn new(
        [thickness_um, wavelength_nm]: [f64; 2],
        numbers: DensityNumbers<ErrorParts>,
    ) -> Self {
        let known = |number: ErrorParts| Some(number).filter(|number| number.value.is_finite());
        let DensityNumbers { stack, layers, ratio } = numbers;
        Self {
            thickness_um,
            wavelength_nm,
            density_of_stack: known(stack),
            density_of_layers: known(layers),
            density_ratio: known(ratio).filter(|_| layers.value > FAINT_DENSITY),
        }
    }
}

/// A stack without each of its layers, and each alone; nothing of one layer, and of a stack that is
/// solved as a whole without [`Study::without_layers`].
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct LeftOutNotes {
    /// At every thickness and wavelength.
    #[serde(rename = "left_out", skip_serializing_if = "Vec::is_empty")]
    pub rows: Vec<LeftOutRow>,
    /// Their colours.
    #[serde(rename = "left_out_colours", skip_serializing_if = "Vec::is_empty")]
    pub colours: Vec<LeftOutColours>,
    /// Densities of the stack.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub densities: Vec<DensityRow>,
}

/// Which layers of a stack a number is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::evaluate) enum StackPart {
    /// All but one.
    Without,
    /// One.
    Alone,
}

impl StackPart {
    /// What was withheld of a part of a stack, with the name of its layer.
    pub fn withheld(self, layer: &str, reason: Withheld) -> Withheld {
        Withheld { number: format!("{}{}", reason.number, self.ending(layer)), ..reason }
    }

    fn ending(self, layer: &str) -> String {
        match self {
            Self::Without => format!(" without {layer}"),
            Self::Alone => format!(" of only {layer}"),
        }
    }
}

impl Withheld {
    /// Whether the number is of some layers of a study's stack, not of all.
    pub fn is_of_a_part(&self, study: &Study) -> bool {
        let ends = |part: StackPart, layer: &str| self.number.ends_with(&part.ending(layer));
        study
            .stack
            .iter()
            .any(|layer| ends(StackPart::Without, &layer.name) || ends(StackPart::Alone, &layer.name))
    }
}
