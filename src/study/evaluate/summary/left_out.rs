//! A stack that is solved as a whole, without each of its layers and each of them alone: the same
//! evaluation of studies of these layers, with their own packings.
//!
//! Errors of what combines several of these studies: realisations of the same number have cells,
//! directions and wavelengths from one draw, and their common scatter is known; all other parts
//! are taken as independent, and add up as squares.

use super::{LIT_AT_45, NATURAL_LIGHT, summarise};
use crate::appearance::colour::Colour;
use crate::evaluate::manifest::composed::ComposedColours;
use crate::evaluate::manifest::left_out::{DensityRow, LeftOutColours, LeftOutNotes, LeftOutRow, StackPart};
use crate::evaluate::manifest::{ColourNote, FailureNote, Manifest, SpectrumReplicates};
use crate::evaluate::prints::bare_factors;
use crate::evaluate::published::{ErrorParts, Withheld};
use crate::evaluate::quantities::{DensityNumbers, Lab};
use crate::evaluate::seen::see;
use crate::input::study::{Study, Substack};
use crate::numerics::estimate::{Estimate, Linked, jackknife_deviations};
use crate::run::Collected;
use std::f64::consts::LN_10;

/// Failed packings and solves of the parts of a stack.
pub(super) fn failures(study: &Study, collected: &Collected) -> Vec<FailureNote> {
    let mut all = Vec::new();
    for (Substack { name, .. }, solved) in study.substacks().iter().zip(&collected.substacks) {
        let own = solved.iter().flat_map(super::failures);
        all.extend(own.map(|f| FailureNote::Slab(format!("{name}, {}: {}", f.place(), f.reason()))));
    }
    all
}

/// The parts of a stack that are solved, and what of them cannot be.
pub(super) fn left_out(whole: &Manifest, collected: &Collected) -> (LeftOutNotes, Vec<Withheld>) {
    let study = whole.study;
    let substacks = study.substacks();
    let mut evaluated: Vec<Option<Manifest>> = Vec::new();
    for (part, solved) in substacks.iter().zip(&collected.substacks) {
        let seen = solved.as_ref().and_then(|solved| Some((solved, see(&part.study, solved).ok()?)));
        evaluated.push(seen.map(|(solved, seen)| summarise(&part.study, solved, &seen)));
    }
    let mut notes = LeftOutNotes::default();
    let mut withheld = Vec::new();
    if evaluated.iter().all(Option::is_none) {
        return (notes, withheld);
    }
    let part = |place: usize| evaluated[place].as_ref();
    let thickness_um = study.layer.thickness_um;
    let bare = bare_factors(study);
    for (&wavelength_nm, &bare) in study.wavelengths_nm.iter().zip(&bare) {
        for (k, layer) in study.stack.iter().enumerate() {
            let without = SeenPart::at(part(study.place_without(k)), wavelength_nm);
            let alone = SeenPart::at(part(study.place_alone(k)), wavelength_nm);
            notes.rows.push(LeftOutRow {
                thickness_um,
                wavelength_nm,
                layer: layer.name.clone(),
                lit_at_45_without: without.lit_at_45.as_ref().map(parts_of),
                natural_light_without: without.natural_light.as_ref().map(parts_of),
                lit_at_45_alone: alone.lit_at_45.as_ref().map(parts_of),
                natural_light_alone: alone.natural_light.as_ref().map(parts_of),
            });
        }
        let factor = |manifest: Option<&Manifest>| SeenPart::at(manifest, wavelength_nm).lit_at_45;
        let layers = (0..study.stack.len()).map(|k| factor(part(study.place_alone(k))));
        let densities = densities(factor(Some(whole)), layers.collect(), bare);
        notes
            .densities
            .extend(densities.map(|numbers| DensityRow::new([thickness_um, wavelength_nm], numbers)));
    }
    for (k, layer) in study.stack.iter().enumerate() {
        let mut colours = |place: usize, which: StackPart| {
            let manifest = part(place)?;
            withheld
                .extend(manifest.withheld.iter().map(|reason| which.withheld(&layer.name, reason.clone())));
            colours_of(manifest, thickness_um)
        };
        let without = colours(study.place_without(k), StackPart::Without);
        let alone = colours(study.place_alone(k), StackPart::Alone);
        if without.is_some() || alone.is_some() {
            notes.colours.push(LeftOutColours { layer: layer.name.clone(), without, alone });
        }
    }
    (notes, withheld)
}

/// What of a stack or of a part of it is seen on the paper at one wavelength.
#[derive(Default)]
struct SeenPart {
    lit_at_45: Option<Linked>,
    natural_light: Option<Linked>,
}

impl SeenPart {
    fn at(manifest: Option<&Manifest>, wavelength_nm: f64) -> Self {
        let Some(manifest) = manifest else { return Self::default() };
        let rows = manifest.spectra.whole().iter();
        let own = rows.clone().find(|row| row.polar_deg == 0.0 && row.wavelength_nm == wavelength_nm);
        let Some(row) = own else { return Self::default() };
        let linked = |estimate: Option<Estimate>, replicates: fn(&SpectrumReplicates) -> &Vec<f64>| {
            let replicates: Vec<[f64; 1]> = replicates(&row.replicates).iter().map(|&x| [x]).collect();
            let by_chance = jackknife_deviations(&replicates).into_iter().map(|[by]| by);
            let cells = row.deviations.iter().map(|(cell, _)| *cell);
            Some(Linked {
                estimate: known(estimate?, manifest.study)?,
                deviations: cells.zip(by_chance).collect(),
            })
        };
        Self {
            lit_at_45: linked(row.lit_at_45, |replicates| &replicates.lit_at_45),
            natural_light: linked(row.natural_light, |replicates| &replicates.natural_light),
        }
    }
}

/// A number whose error is known: films without grains have none.
fn known(estimate: Estimate, study: &Study) -> Option<Estimate> {
    let is_certain = study.pigments.is_empty() && study.variation.thickness_std_um == 0.0;
    let standard_error = estimate.standard_error.or(is_certain.then_some(0.0))?;
    Some(Estimate { standard_error: Some(standard_error), ..estimate })
}

/// A number with its error by chance, and all the rest of it as that of the grid.
fn parts_of(number: &Linked) -> ErrorParts {
    let standard_error = number.estimate.standard_error.unwrap_or(f64::NAN);
    with_parts(Estimate { standard_error: Some(standard_error), ..number.estimate }, number.chance_variance())
}

/// The error of a number in two parts.
fn with_parts(estimate: Estimate, chance_variance: f64) -> ErrorParts {
    let variance = estimate.standard_error.unwrap_or(0.0).powi(2);
    let chance = chance_variance.min(variance);
    let parts = ErrorParts { value: estimate.value, chance: chance.sqrt(), ..ErrorParts::default() };
    ErrorParts { grid: (variance - chance).sqrt(), ..parts }.summed()
}

/// Densities of a stack and of its layers alone, from their radiance factors and that of the bare
/// paper; `None` where one of them is not known.
fn densities(
    stack: Option<Linked>,
    layers: Vec<Option<Linked>>,
    bare: f64,
) -> Option<DensityNumbers<ErrorParts>> {
    let stack = density(&stack?, bare);
    let layers: Vec<Linked> =
        layers.into_iter().map(|layer| Some(density(&layer?, bare))).collect::<Option<_>>()?;
    let sum = Linked::sum(layers.iter().map(|layer| (1.0, layer)));
    let value = stack.estimate.value / sum.estimate.value;
    // of the quotient, to first order
    let change = Linked::sum([(1.0 / sum.estimate.value, &stack), (-value / sum.estimate.value, &sum)]);
    let ratio = Linked { estimate: Estimate { value, ..change.estimate }, ..change };
    Some(DensityNumbers { stack: parts_of(&stack), layers: parts_of(&sum), ratio: parts_of(&ratio) })
}

/// The density of what has this radiance factor, against the bare paper.
fn density(factor: &Linked, bare: f64) -> Linked {
    let Estimate { value, standard_error } = factor.estimate;
    let slope = -1.0 / (LN_10 * value);
    Linked {
        estimate: Estimate {
            value: -(value / bare).log10(),
            standard_error: standard_error.map(|error| error * slope.abs()),
        },
        deviations: factor.deviations.iter().map(|(&cell, by)| (cell, slope * by)).collect(),
    }
}

/// The colours of a part of a stack; `None` where it has none.
fn colours_of(part: &Manifest, thickness_um: f64) -> Option<ComposedColours> {
    let study = part.study;
    let note = |conditions: &str| part.colours.whole().iter().find(|note| note.conditions == conditions);
    let of_note = |note: &ColourNote| {
        lab_parts(&note.colour, note.deviations.iter().map(|(_, by)| *by).collect(), study)
    };
    let natural_light = note(NATURAL_LIGHT);
    let lit_at_45 = note(LIT_AT_45);
    let maker = part.ink_maker.as_ref();
    let contrast_ratio = maker.and_then(|maker| {
        let chance = maker.contrast_deviations.iter().map(|(_, by)| by * by).sum();
        Some(with_parts(known(maker.contrast_ratio, study)?, chance))
    });
    if natural_light.is_none() && lit_at_45.is_none() && maker.is_none() {
        return None;
    }
    Some(ComposedColours {
        thickness_um,
        hex: natural_light.map(|note| {
            let [r, g, b] = note.colour.srgb8;
            format!("#{r:02x}{g:02x}{b:02x}")
        }),
        colour: natural_light.map(|note| note.colour),
        natural_light: natural_light.and_then(of_note),
        lit_at_45: lit_at_45.and_then(of_note),
        over_black: maker.and_then(|maker| {
            lab_parts(&maker.over_black.colour, maker.over_black.deviations.clone(), study)
        }),
        contrast_ratio,
    })
}

/// L*, a*, b* with their errors; the contribution of each realisation is known.
fn lab_parts(colour: &Colour, deviations: Vec<[f64; 3]>, study: &Study) -> Option<Lab<ErrorParts>> {
    let errors = colour.lab_standard_error();
    let part = |i: usize| {
        let estimate = Estimate { value: colour.lab[i], standard_error: errors.map(|errors| errors[i]) };
        let chance = deviations.iter().map(|by| by[i] * by[i]).sum();
        Some(with_parts(known(estimate, study)?, chance))
    };
    Some([part(0)?, part(1)?, part(2)?])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A factor whose realisations scatter by these, with a further error of the grid.
    fn factor(value: f64, scatter: [f64; 3], grid: f64) -> Linked {
        let chance = scatter.iter().map(|by| by * by).sum::<f64>();
        let estimate = Estimate { value, standard_error: Some((chance + grid * grid).sqrt()) };
        Linked { estimate, deviations: scatter.into_iter().enumerate().collect() }
    }

    /// A tenth of the paper's light is a density of 1. Layers that scatter alike in the same
    /// realisations add their errors, others the squares; the quotient of densities that move
    /// together has no error by chance. *Planted*: the wrong sign; squares added in every case.
    #[test]
    fn densities_add_with_what_their_realisations_share() {
        let own = factor(0.09, [0.001, -0.002, 0.002], 0.004);
        let other = factor(0.09, [0.002, 0.002, 0.001], 0.004);
        let of = |stack: &Linked, layers: [&Linked; 2]| {
            densities(Some(stack.clone()), layers.map(|layer| Some(layer.clone())).to_vec(), 0.9).unwrap()
        };
        let alike = of(&own, [&own, &own]);
        let slope = 1.0 / (LN_10 * 0.09);
        // rounding of some ten operations
        let close = |found: f64, wanted: f64| assert!((found - wanted).abs() < 1e-12, "{found} {wanted}");
        close(alike.stack.value, 1.0);
        close(alike.layers.value, 2.0);
        close(alike.ratio.value, 0.5);
        close(alike.stack.chance, 0.003 * slope);
        close(alike.stack.grid, 0.004 * slope);
        close(alike.layers.chance, 2.0 * 0.003 * slope);
        close(alike.layers.grid, 0.004 * slope * 2.0_f64.sqrt());
        close(alike.ratio.chance, 0.0);
        assert!(alike.ratio.standard_error > 0.0);
        // the scatter of both is orthogonal
        close(of(&own, [&own, &other]).layers.chance, 0.003 * slope * 2.0_f64.sqrt());
        assert_eq!(densities(Some(own.clone()), vec![Some(own), None], 0.9), None);
    }
}
