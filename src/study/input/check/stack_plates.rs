//! Stacks that are lists of plates: which layers are solved as a whole, and what cannot be.

use super::composed::refuse_beside_slabs;
use super::light::check_list;
use crate::ink::{Joint, Orientation};
use crate::input::file::{ComposedTable, StackLayerTable};
use crate::input::forms::ThicknessWritten;
use crate::input::study::{Composed, LayerPlates, Study, StudyKind};
use crate::input::{Faults, LightRule, StudyFile, as_written, limits};
use crate::numerics::allowed::{brief, shown};

/// Thicknesses are told to a millionth of a nanometre.
const PER_ROUNDED_UM: f64 = 1e9;

/// How much more a solve of twice the thickness takes: *measured* 2.0 to 2.9.
const TWICE: f64 = 2.4;

/// Makes a stack of plates of the study of a stack.
pub(super) fn compose(
    written: &StudyFile,
    layers: &[StackLayerTable],
    table: &ComposedTable,
    study: &mut Study,
    faults: &mut Faults,
) {
    faults.number("stack.composed.slab_um", table.slab_um, limits::THICKNESS_UM, "2 is usual");
    let [x_um, y_um] = study.layer.period_um;
    let longest_nm = study.wavelengths_nm.last().copied().unwrap_or(0.0);
    let directions = table.in_a_stack(x_um.min(y_um), 1e-3 * longest_nm);
    for (zone, count) in directions.into_iter().enumerate() {
        let field = format!("stack.composed.directions[{zone}]");
        faults.whole(
            &field,
            count,
            limits::ZONE_DIRECTIONS,
            "[3, 6] are usual; [5, 9] show what more directions change",
        );
    }
    let is_listed = |layer: &StackLayerTable| matches!(layer.thickness_um, ThicknessWritten::Several(_));
    let varied = layers.iter().position(is_listed);
    // a sum of thicknesses is not 9.100000000000001 µm
    let sum_um = (study.layer.thickness_um * PER_ROUNDED_UM).round() / PER_ROUNDED_UM;
    let thicknesses_um = varied.map_or(vec![sum_um], |i| layers[i].thickness_um.all());
    if let Some(i) = varied {
        let field = format!("layer[{i}].thickness_um");
        let remedy = "list rising thicknesses, in µm";
        check_list(&field, &thicknesses_um, limits::THICKNESS_UM, remedy, faults);
    }
    let plates: Vec<LayerPlates> =
        (0..layers.len()).map(|i| plates_of(study, layers, table, i, faults)).collect();
    refuse(written, layers, study, faults);
    study.remarks.push(in_words(study, &plates, table.slab_um));
    let thickest = plates.iter().zip(&study.stack).map(|(plates, layer)| match plates {
        LayerPlates::Slabs(um) => *um,
        LayerPlates::Clear | LayerPlates::Whole => layer.thickness_um,
    });
    let composed = Composed {
        slab_um: thickest.fold(0.0, f64::max),
        directions,
        thicknesses_um,
        mixing: None,
        layers: plates,
        varied,
        joint_index: table.joint_index,
    };
    if let Some(index) = table.joint_index {
        check_joint(index, study, faults);
    }
    study.variation.light = LightRule::Listed;
    study.kind = StudyKind::Composed(composed);
    study.remarks.extend(study.layers_without_plates());
}

/// The index of the half-spaces between the layers. Clear layers are followed at the directions of
/// these half-spaces, all of which must exist in them.
fn check_joint(index: f64, study: &Study, faults: &mut Faults) {
    faults.number("stack.composed.joint_index", index, limits::JOINT_INDEX, "take that of the binders");
    for (i, layer) in study.stack.iter().enumerate().filter(|(_, layer)| layer.pigments == 0) {
        let own = study.wavelengths_nm.iter().map(|nm| layer.binder.index_at(1e-3 * nm).re);
        let least = own.fold(f64::INFINITY, f64::min);
        if least < index {
            let allowed = format!("{index} or more, as stack.composed.joint_index");
            let remedy =
                "lower stack.composed.joint_index to that of this layer, or leave the clear layer out";
            faults.add(format!("layer[{i}].binder.index"), least, allowed, remedy);
        }
    }
}

/// How one layer becomes plates. A whole layer takes one portion and two halves, slabs take three
/// of their thickness and three of half of it: from twice a slab on, slabs are cheaper.
fn plates_of(
    study: &Study,
    layers: &[StackLayerTable],
    table: &ComposedTable,
    i: usize,
    faults: &mut Faults,
) -> LayerPlates {
    let layer = &study.stack[i];
    let asked_um = layers[i].slab_um;
    let field = format!("layer[{i}].slab_um");
    if layer.pigments == 0 {
        if let Some(asked_um) = asked_um {
            let remedy = "remove it: a layer without grains is known exactly at any thickness";
            faults.add(field, asked_um, "slabs of layers with grains", remedy);
        }
        return LayerPlates::Clear;
    }
    let um = layer.thickness_um;
    let is_listed = matches!(layers[i].thickness_um, ThicknessWritten::Several(_));
    let slab_um = asked_um.unwrap_or(table.slab_um);
    if asked_um.is_some() {
        faults.number(&field, slab_um, limits::THICKNESS_UM, "2 is usual");
    }
    // thicknesses that are none are reported where they stand
    if !limits::THICKNESS_UM.holds(um) || !limits::THICKNESS_UM.holds(slab_um) {
        return LayerPlates::Whole;
    }
    if is_listed && slab_um > 0.5 * um * (1.0 + limits::ROUNDED) {
        let half_um = brief(0.5 * um);
        let allowed = format!("at most {half_um} µm, half of the thinnest of the thicknesses of layer[{i}]");
        let remedy =
            format!("take thinner slabs, there or as slab_um of layer[{i}], or give it one thickness");
        let field = if asked_um.is_some() { field } else { "stack.composed.slab_um".to_owned() };
        faults.add(field, slab_um, allowed, remedy);
        return LayerPlates::Whole;
    }
    let is_whole = if asked_um.is_some() { um <= slab_um * (1.0 + 1e-9) } else { um < 2.0 * slab_um };
    let is_whole = is_whole && !is_listed;
    if is_whole && um > 0.0 && !limits::STACK_UM.holds(um) {
        let found = format!("a layer of {um} µm solved whole");
        let allowed = format!("{} where a layer is solved whole", limits::STACK_UM);
        faults.add(&field, found, allowed, "take slabs of at most half of its thickness; 2 is usual");
    }
    let own_um = if is_whole { um } else { um / (um / slab_um).round().max(2.0) };
    // that of agglomerates is a matter of chance
    let widest_um = study.packing.layers.get(i).map_or(0.0, |layer| layer.request.widest_body_um());
    if widest_um.is_finite() && own_um > 0.0 && widest_um > 0.5 * own_um {
        let least_um = format!("{:.3} µm or more, twice the largest grain", 2.0 * widest_um);
        if is_whole {
            let allowed = format!("{least_um}: layers of a composed stack are compared with their halves");
            let remedy = "take smaller grains or a thicker layer, or remove [stack.composed]: a thin stack is solved whole";
            faults.add(format!("layer[{i}].thickness_um"), um, allowed, remedy);
        } else {
            let allowed = format!("slabs of {least_um}: they are compared with some half as thick");
            let remedy =
                "take thicker slabs for this layer; of one thickness below that of a slab it is solved whole";
            faults.add(field, format!("slabs of {own_um:.3} µm"), allowed, remedy);
        }
    }
    if is_whole { LayerPlates::Whole } else { LayerPlates::Slabs(own_um) }
}

/// What a stack of plates cannot hold.
fn refuse(written: &StudyFile, layers: &[StackLayerTable], study: &Study, faults: &mut Faults) {
    for (i, layer) in layers.iter().enumerate() {
        let mut refuse = |found: Option<String>, key: &str, allowed: &str, remedy: &str| {
            if let Some(found) = found {
                let allowed = format!("{allowed} where the stack is composed");
                faults.add(format!("layer[{i}].{key}"), found, allowed, remedy);
            }
        };
        let remedy = "remove it, or remove [stack.composed]: a thin stack is solved whole";
        let open = layer.joint.as_ref().filter(|joint| **joint == Joint::Open);
        let std_um = Some(layer.thickness_um.std()).filter(|std_um| *std_um > 0.0);
        refuse(open.map(as_written), "joint", "\"wall\"", remedy);
        refuse(layer.relief.as_ref().map(as_written), "relief", "a plane surface", remedy);
        refuse(layer.microstructure.as_ref().map(as_written), "microstructure", "packed grains", remedy);
        refuse(std_um.map(shown), "thickness_um.std", "one thickness or a list", remedy);
        for (k, pigment) in layer.pigments.iter().enumerate() {
            let is_aligned = pigment.index.is_birefringent() && pigment.orientation != Orientation::Random;
            let aligned = Some(&pigment.orientation).filter(|_| is_aligned);
            let remedy = "remove orientation, or give the pigment one index";
            let allowed = "\"random\" for birefringent grains";
            refuse(aligned.map(as_written), &format!("pigment[{k}].orientation"), allowed, remedy);
            let remedy = "remove it: slabs are packed without a gradient; layers of rising shares make one";
            let profile = pigment.profile.as_ref().map(as_written);
            refuse(profile, &format!("pigment[{k}].profile"), "even layers", remedy);
        }
    }
    refuse_metals(study, faults);
    refuse_beside_slabs(written, "the stack", "stack.composed", faults);
    for (i, area) in written.areas.iter().enumerate() {
        let Some(folder) = &area.results else { continue };
        let allowed = "areas of this study's layers where the stack is composed";
        let remedy = "run this study and print it from one that is solved as a whole";
        faults.add(format!("area[{i}].results"), format!("{folder:?}"), allowed, remedy);
    }
    if study.pigments.is_empty() {
        let remedy = "remove [stack.composed]: a clear stack is solved exactly at any thickness";
        faults.add("layer.pigment", "none", "grains in a layer where the stack is composed", remedy);
    } else if study.realisations < 2 {
        let remedy = "12 to 24 are usual: one realisation has no error bar";
        faults.add("run.realisations", study.realisations, "2 or more", remedy);
    }
}

/// Layers with grains are solved between half-spaces of the mixture's index, which must hold the
/// directions of air.
fn refuse_metals(study: &Study, faults: &mut Faults) {
    for i in (0..study.stack.len()).filter(|&i| study.stack[i].pigments > 0) {
        let layer = study.of_layer(i);
        let indices = study.wavelengths_nm.iter().map(|nm| layer.embedding_index(1e-3 * nm));
        let thinnest = indices.fold(f64::INFINITY, f64::min);
        if thinnest < 1.0 {
            let found = format!("a mixture of index {thinnest:.2}");
            let allowed = "1 or more where the stack is composed";
            let remedy = "lower the volume fraction of the metal, or remove [stack.composed]";
            faults.add(format!("layer[{i}].pigment"), found, allowed, remedy);
        }
    }
}

/// What becomes of every layer, and what the other way would cost.
fn in_words(study: &Study, plates: &[LayerPlates], slab_um: f64) -> String {
    let per_um = |um: f64| um.powf(TWICE.log2());
    let whole = |um: f64| per_um(um) + 2.0 * per_um(0.5 * um);
    let slabs = |um: f64| 3.0 * (per_um(um) + per_um(0.5 * um));
    let words = study.stack.iter().zip(plates).map(|(layer, plates)| {
        let (name, um) = (&layer.name, layer.thickness_um);
        match plates {
            LayerPlates::Clear => format!("{name}: clear, known exactly"),
            LayerPlates::Whole => {
                let slab_um = slab_um.min(0.5 * um);
                let times = slabs(slab_um) / whole(um);
                format!("{name}: solved whole (slabs of {slab_um:.2} µm would cost about {times:.1} times as much)")
            }
            LayerPlates::Slabs(own_um) => {
                let times = whole(um) / slabs(*own_um);
                format!("{name}: slabs of {own_um:.2} µm (whole it would cost about {times:.1} times as much)")
            }
        }
    });
    format!("stack.composed: {}", words.collect::<Vec<_>>().join("; "))
}
