//! Stacks of layers: every layer is checked as if it were alone, then what only a stack can have
//! wrong, and one study is made of them.

use super::{Examined, examine_layer, grains, stack_plates};
use crate::ink::{Joint, PackingRequest, RoughFace, StackedRequest};
use crate::input::file::{LayerTable, StackLayerTable, StackTable};
use crate::input::forms::{Pair, ThicknessWritten};
use crate::input::study::{Pigment, StackLayer, Study};
use crate::input::{CellRule, Fault, Faults, StudyFile, limits};
use crate::numerics::allowed::brief;
use std::path::Path;

/// Most layers of a stack.
const MOST_LAYERS: usize = 32;
/// Relative difference of periods of given grains that is rounding.
const ROUNDING: f64 = 1e-6;
/// Difference of indices that is rounding.
const SAME_INDEX: f64 = 1e-9;

/// Examines a study with `[[layer]]`.
pub(super) fn examine(
    written: &StudyFile,
    layers: &[StackLayerTable],
    folder: &Path,
    name: &str,
) -> Examined {
    let mut packing_faults = Faults::default();
    check_layers(written, layers, &mut packing_faults);
    let mut parts = parts(written, layers, folder, name);
    let mut wave_faults = Faults::default();
    for part in &mut parts {
        collect(&mut packing_faults, &mut part.packing_faults);
        collect(&mut wave_faults, &mut part.wave_faults);
    }
    let Some((first, others)) = parts.split_first() else { return nothing(written, folder, name) };
    let common = written.stack.clone().unwrap_or_default();
    let composed = common.composed.as_ref();
    // one that is composed is a list of one plate
    if others.is_empty() && composed.is_none() {
        let study = first.study.clone();
        if common.without_layers {
            wave_faults.0.push(no_substacks("a stack of one layer", "2 layers or more"));
        }
        return Examined { study, packing_faults, wave_faults };
    }
    check_periods(&parts, &mut packing_faults);
    if composed.is_none() {
        check_thickness(&parts, &mut packing_faults);
        check_slabs(layers, &mut packing_faults);
    }
    check_binders(layers, &parts, &mut wave_faults);
    let mut study = together(layers, &parts);
    if let Some(table) = composed {
        stack_plates::compose(written, layers, table, &mut study, &mut packing_faults);
    }
    if common.without_layers {
        wave_faults.0.extend(substack_fault(&study));
        study.without_layers = study.composed().is_none();
    }
    Examined { study, packing_faults, wave_faults }
}

/// Why `stack.without_layers` is refused.
fn no_substacks(found: &str, allowed: &str) -> Fault {
    let remedy = "remove stack.without_layers, or leave it false";
    Fault::new("stack.without_layers", format!("true in {found}"), allowed, remedy)
}

/// What of a stack keeps it from being told without its layers.
fn substack_fault(study: &Study) -> Option<Fault> {
    if study.composed().is_some() {
        let allowed = "a stack that is solved as a whole: a composed one tells this without it";
        return Some(no_substacks("a composed stack", allowed));
    }
    if let Some(reason) = study.no_ink() {
        let allowed = format!("a stack on its paper, with directions and wavelengths of a colour: {reason}");
        return Some(no_substacks("a stack without paper", &allowed));
    }
    let varies = !study.pigments.is_empty() || study.variation.thickness_std_um > 0.0;
    let allowed = "2 realisations or more: one has no error bar; 12 to 24 are usual";
    (varies && study.realisations < 2).then(|| no_substacks("a study of 1 realisation", allowed))
}

/// The study as far as it goes where there is no layer at all.
fn nothing(written: &StudyFile, folder: &Path, name: &str) -> Examined {
    let mut file = written.clone();
    file.layer.thickness_um = ThicknessWritten::Even(1.0);
    let mut examined = examine_layer(&file, folder, name);
    let remedy = "write [[layer]] with its thickness_um and binder for every layer";
    examined.packing_faults.add("layer", "an empty list", "at least one layer", remedy);
    examined
}

/// The layers, each examined as if it were alone in the cell of all.
fn parts(written: &StudyFile, layers: &[StackLayerTable], folder: &Path, name: &str) -> Vec<Examined> {
    let alone =
        |i: usize, common: &StackTable| of_layer_alone(written, &layers[i], common, folder, name).of(i);
    let mut common = written.stack.clone().unwrap_or_default();
    let mut parts: Vec<Option<Examined>> = layers.iter().map(|_| None).collect();
    // files of grains may give the cell, which is then that of all layers
    let is_given = |layer: &StackLayerTable| layer.microstructure.is_some();
    for i in (0..layers.len()).filter(|&i| is_given(&layers[i])) {
        let part = alone(i, &common);
        if common.period_um.is_none() && part.packing_faults.0.is_empty() {
            common.period_um = Some(Pair::Each(part.study.layer.period_um));
        }
        parts[i] = Some(part);
    }
    if layers.iter().any(is_given) {
        common.cell = CellRule::Fixed;
    } else if common.period_um.is_none() && common.cell == CellRule::Varied {
        let usual_um = layers.iter().map(|layer| grains::nominal_period_um(&layer.pigments));
        common.period_um = Some(Pair::Both(usual_um.fold(0.0, f64::max)));
    }
    let examined = parts.into_iter().enumerate();
    examined.map(|(i, known)| known.unwrap_or_else(|| alone(i, &common))).collect()
}

/// One layer examined as if it were alone.
fn of_layer_alone(
    written: &StudyFile,
    layer: &StackLayerTable,
    common: &StackTable,
    folder: &Path,
    name: &str,
) -> Examined {
    let mut file = StudyFile { stack: None, ..written.clone() };
    file.layer = LayerTable::of_stack(layer, common);
    file.pigments = layer.pigments.clone();
    if let (Some(_), ThicknessWritten::Several(all)) = (&common.composed, &layer.thickness_um) {
        // what is wrong in a list is reported with the plates
        let first_um = all.iter().copied().find(|um| limits::THICKNESS_UM.holds(*um));
        file.layer.thickness_um = ThicknessWritten::Even(first_um.unwrap_or(1.0));
    }
    examine_layer(&file, folder, name)
}

impl Examined {
    /// With errors that name the fields of the layer with this number.
    fn of(mut self, i: usize) -> Self {
        for faults in [&mut self.packing_faults, &mut self.wave_faults] {
            faults.0.iter_mut().for_each(|fault| *fault = of_layer(fault.clone(), i));
        }
        self
    }
}

/// Keys of a single layer that are those of `[stack]`.
const COMMON: [&str; 6] = ["cell", "period_um", "index_in", "index_out", "mixing", "contrast"];

/// An error of a single layer with the names that its fields have in a stack.
fn of_layer(fault: Fault, i: usize) -> Fault {
    let common = |text: String| {
        let text = text.replace("[layer.composed]", "[stack.composed]");
        COMMON.iter().fold(text, |text, key| text.replace(&format!("layer.{key}"), &format!("stack.{key}")))
    };
    let field = common(fault.field);
    let field = match field.strip_prefix("layer") {
        Some(rest) => format!("layer[{i}]{rest}"),
        None if field.starts_with("pigment") => format!("layer[{i}].{field}"),
        None => field,
    };
    Fault { field, found: fault.found, allowed: common(fault.allowed), remedy: common(fault.remedy) }
}

/// Adds errors, those of tables that all layers share only once.
fn collect(all: &mut Faults, more: &mut Faults) {
    for fault in more.0.drain(..) {
        if !all.0.contains(&fault) {
            all.push(fault);
        }
    }
}

/// What only a stack can have wrong, as it is written.
fn check_layers(written: &StudyFile, layers: &[StackLayerTable], faults: &mut Faults) {
    if layers.len() > MOST_LAYERS {
        let allowed = format!("at most {MOST_LAYERS} layers");
        faults.add("layer", format!("{} layers", layers.len()), allowed, "join layers that are alike");
    }
    if !written.pigments.is_empty() {
        let remedy = "write [[layer.pigment]] below the [[layer]] that holds it";
        faults.add("pigment", "pigments beside [[layer]]", "pigments of the layers of a stack", remedy);
    }
    let names: Vec<String> = (0..layers.len()).map(|i| name_of(layers, i)).collect();
    for (i, name) in names.iter().enumerate() {
        let others = names[..i].iter().map(String::as_str);
        faults.name(format!("layer[{i}].name"), name, others, "layer");
    }
    check_joints(layers, faults);
    check_faces(layers, faults);
    check_given_once(layers, faults);
}

/// Joints are between layers, and open ones between packed layers.
fn check_joints(layers: &[StackLayerTable], faults: &mut Faults) {
    let is_given = |i: usize| layers.get(i).is_some_and(|layer| layer.microstructure.is_some());
    for (i, layer) in layers.iter().enumerate() {
        if i + 1 == layers.len() && layer.joint.is_some() {
            let allowed = "nothing on the last layer, behind which there is none";
            faults.add(format!("layer[{i}].joint"), "a joint", allowed, "remove it");
        }
        if layer.joint == Some(Joint::Open) && (is_given(i) || is_given(i + 1)) {
            let allowed = "\"wall\" beside a layer whose grains are given";
            let remedy = "write joint = \"wall\": given grains stay within their layer";
            faults.add(format!("layer[{i}].joint"), "\"open\"", allowed, remedy);
        }
    }
}

/// Outer faces alone may be rough.
fn check_faces(layers: &[StackLayerTable], faults: &mut Faults) {
    for (i, layer) in layers.iter().enumerate() {
        let is_last = i + 1 == layers.len();
        let (is_outer, face) = match layer.relief.map(|relief| relief.face) {
            None => continue,
            Some(RoughFace::Incident) => (i == 0, "the first layer has a face on the incident side"),
            Some(RoughFace::Exit) => (is_last, "the last layer has a face on the exit side"),
        };
        if !is_outer {
            let remedy = "remove it: faces between layers are plane";
            faults.add(
                format!("layer[{i}].relief"),
                "a relief inside",
                format!("outer faces: {face}"),
                remedy,
            );
        }
    }
}

/// What one layer of a stack may have, but not two.
fn check_given_once(layers: &[StackLayerTable], faults: &mut Faults) {
    let is_rough: Vec<usize> = (0..layers.len()).filter(|&i| layers[i].relief.is_some()).collect();
    let is_uneven: Vec<usize> = (0..layers.len()).filter(|&i| layers[i].thickness_um.std() > 0.0).collect();
    let is_listed = |i: &usize| matches!(layers[*i].thickness_um, ThicknessWritten::Several(_));
    let listed: Vec<usize> = (0..layers.len()).filter(is_listed).collect();
    if let [_, second, ..] = is_rough[..] {
        let remedy = "keep one: a packing has one rough face";
        faults.add(format!("layer[{second}].relief"), "a second relief", "one relief in a stack", remedy);
    }
    if let [first, second, ..] = is_uneven[..] {
        let allowed = format!("one uneven layer in a stack; layer[{first}] is one");
        let remedy = "give the others their mean thickness, or run one study for each";
        faults.add(format!("layer[{second}].thickness_um.std"), "a second spread", allowed, remedy);
    }
    if let [first, second, ..] = listed[..] {
        let allowed = format!("one thickness: layer[{first}] has a list already");
        let remedy = "give one thickness here, and sweep over it";
        faults.add(format!("layer[{second}].thickness_um"), "a second list", allowed, remedy);
    }
}

/// The name of a layer, or a numbered one.
fn name_of(layers: &[StackLayerTable], i: usize) -> String {
    layers[i].name.clone().unwrap_or_else(|| format!("layer {}", i + 1))
}

/// Layers share one cell, also where files of grains give it.
fn check_periods(parts: &[Examined], faults: &mut Faults) {
    let [x, y] = parts[0].study.layer.period_um;
    let differs = |part: &Examined| {
        let [own_x, own_y] = part.study.layer.period_um;
        (own_x - x).abs() > ROUNDING * x || (own_y - y).abs() > ROUNDING * y
    };
    let wrong = parts.iter().position(differs);
    if let Some(i) = wrong.filter(|_| faults.0.is_empty()) {
        let [own_x, own_y] = parts[i].study.layer.period_um;
        let found = format!("grains in a cell of {own_x} × {own_y} µm");
        let allowed = format!("the cell of the first layer, {x} × {y} µm");
        let remedy = "make both equal: the layers of a stack share one cell";
        faults.add(format!("layer[{i}].microstructure"), found, allowed, remedy);
    }
}

/// A stack is solved whole.
fn check_thickness(parts: &[Examined], faults: &mut Faults) {
    let is_clear = parts.iter().all(|part| part.study.pigments.is_empty());
    let limit = if is_clear { limits::THICKNESS_UM } else { limits::STACK_UM };
    let sum_um: f64 = parts.iter().map(|part| part.study.layer.thickness_um).sum();
    // a layer that is no thickness at all is reported where it stands
    let each = |part: &Examined| limits::THICKNESS_UM.holds(part.study.layer.thickness_um);
    if parts.iter().all(each) && !limit.holds(sum_um) {
        let thickness = |part: &Examined| part.study.layer.thickness_um;
        let thickest =
            (0..parts.len()).max_by(|&a, &b| thickness(&parts[a]).total_cmp(&thickness(&parts[b])));
        let i = thickest.unwrap_or(0);
        let allowed = format!("a sum over all layers {limit}: a stack with grains is solved whole");
        let remedy =
            "take thinner layers; or compose the layers: add [stack.composed], with slab_um for thick ones";
        let found = format!("{} µm in all", brief(sum_um));
        faults.add(format!("layer[{i}].thickness_um"), found, allowed, remedy);
    }
}

/// Slabs and lists of thicknesses are for stacks that are composed.
fn check_slabs(layers: &[StackLayerTable], faults: &mut Faults) {
    for (i, layer) in layers.iter().enumerate() {
        let Some(um) = layer.slab_um else { continue };
        let allowed = "nothing where the stack is solved whole";
        let remedy = "add [stack.composed], or remove it";
        faults.add(format!("layer[{i}].slab_um"), um, allowed, remedy);
    }
}

/// Grains reach across an open joint, so that both sides must have one binder.
fn check_binders(layers: &[StackLayerTable], parts: &[Examined], faults: &mut Faults) {
    for i in (1..layers.len()).filter(|&i| layers[i - 1].joint == Some(Joint::Open)) {
        let before = &parts[i - 1].study.layer.binder;
        let here = &parts[i].study.layer.binder;
        let mut pairs = before.index.iter().zip(&here.index);
        if pairs.any(|(a, b)| (a - b).norm() > SAME_INDEX) {
            let found = format!("\"open\" between binders {} and {}", before.source, here.source);
            let allowed = "open joints between layers of one binder (with the same dissolved pigments)";
            let remedy = "write joint = \"wall\", or give both layers one binder.index";
            faults.add(format!("layer[{}].joint", i - 1), found, allowed, remedy);
        }
    }
}

/// The study of all layers.
fn together(layers: &[StackLayerTable], parts: &[Examined]) -> Study {
    let mut study = parts[0].study.clone();
    study.stack = Vec::new();
    study.pigments = Vec::new();
    study.dissolved = Vec::new();
    study.remarks = Vec::new();
    study.layer.thickness_um = 0.0;
    study.variation.thickness_std_um = 0.0;
    let mut requests = Vec::new();
    for (i, part) in parts.iter().enumerate() {
        let Study { layer, pigments, dissolved, packing, variation, remarks, .. } = &part.study;
        let joint = layers[i].joint.unwrap_or_default();
        study.layer.thickness_um += layer.thickness_um;
        study.variation.thickness_std_um += variation.thickness_std_um;
        study.stack.push(StackLayer {
            name: name_of(layers, i),
            thickness_um: layer.thickness_um,
            thickness_std_um: variation.thickness_std_um,
            binder: layer.binder.clone(),
            pigments: pigments.len(),
            joint,
        });
        requests.push(StackedRequest { request: packing.clone(), joint });
        study.pigments.extend(pigments.iter().cloned());
        study.dissolved.extend(dissolved.iter().cloned());
        for remark in remarks {
            if !study.remarks.contains(remark) {
                study.remarks.push(remark.clone());
            }
        }
    }
    name_apart(&mut study);
    // other layers behind than in front: what comes back from the paper is solved for itself
    study.angles.exit_strata = study.angles.strata;
    let has_given = |part: &&Examined| !part.study.packing.is_drawn();
    if let Some(given) = parts.iter().find(has_given) {
        study.variation.cell = given.study.variation.cell;
        study.layer.period_um = given.study.layer.period_um;
    }
    let varies =
        |part: &&Examined| !part.study.pigments.is_empty() || part.study.variation.thickness_std_um > 0.0;
    let realisations = parts.iter().filter(varies).map(|part| part.study.realisations);
    study.realisations = realisations.min().unwrap_or(1);
    study.packing = PackingRequest {
        period_um: study.layer.period_um,
        thickness_um: study.layer.thickness_um,
        pigments: study.pigments.iter().map(|pigment| pigment.grains.clone()).collect(),
        relief: layers.iter().find_map(|layer| layer.relief),
        given: Vec::new(),
        voxels: Vec::new(),
        layers: requests,
        ..study.packing
    };
    study
}

/// Pigments of the same name in several layers get the names of their layers as well.
fn name_apart(study: &mut Study) {
    let names: Vec<String> = study.pigments.iter().map(|pigment| pigment.name.clone()).collect();
    let is_doubled = |name: &String| names.iter().filter(|other| *other == name).count() > 1;
    let layers: Vec<String> =
        study.stack.iter().flat_map(|layer| vec![layer.name.clone(); layer.pigments]).collect();
    for (Pigment { name, .. }, layer) in study.pigments.iter_mut().zip(layers) {
        if is_doubled(name) {
            *name = format!("{name} in {layer}");
        }
    }
}
