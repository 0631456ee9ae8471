//! Composed layers: the slabs they are cut into, and what they cannot hold.

use super::light::check_list;
use crate::appearance::viewing::Viewing;
use crate::input::fault::EMPTY_LIST;
use crate::input::file::{ComposedTable, LayerTable};
use crate::input::forms::ThicknessWritten;
use crate::input::study::{Composed, Study, StudyKind};
use crate::input::{Faults, LightRule, StudyFile, as_written, limits};
use crate::numerics::allowed::{brief, shown};

/// Realisations below which a jackknife says little.
const USABLE: usize = 8;

impl LayerTable {
    /// The slabs of a layer that is declared composed.
    pub(super) fn composed(&self, faults: &mut Faults) -> Option<Composed> {
        let Some(table) = &self.composed else {
            if let ThicknessWritten::Several(all) = &self.thickness_um {
                let found = if all.is_empty() { EMPTY_LIST } else { "a list" };
                let remedy = "add [layer.composed], or give one thickness";
                faults.add("layer.thickness_um", found, "one thickness, µm", remedy);
            }
            return None;
        };
        let thicknesses_um = self.thickness_um.all();
        let remedy = "paints are 10 to 100 µm thick";
        check_list("layer.thickness_um", &thicknesses_um, limits::THICKNESS_UM, remedy, faults);
        let &first_um = thicknesses_um.first()?;
        if self.thickness_um.std() > 0.0 {
            let remedy = "give a list of thicknesses, or remove [layer.composed]";
            let found = self.thickness_um.std();
            faults.add("layer.thickness_um.std", found, "0 where it is composed", remedy);
        }
        faults.number("layer.composed.slab_um", table.slab_um, limits::THICKNESS_UM, "2 is usual");
        let directions = table.directions.unwrap_or(ComposedTable::OF_A_LAYER);
        for (zone, count) in directions.into_iter().enumerate() {
            let field = format!("layer.composed.directions[{zone}]");
            let remedy = "3 is usual; 5 shows what more directions change";
            faults.whole(&field, count, limits::ZONE_DIRECTIONS, remedy);
        }
        if let Some(index) = table.joint_index {
            let remedy = "write the layer as [[layer]] and the key below [stack.composed]: plates of a library are layers of a stack";
            faults.add("layer.composed.joint_index", index, "nothing in a layer that is alone", remedy);
        }
        if table.slab_um > 0.5 * first_um * (1.0 + limits::ROUNDED) {
            let half_um = brief(0.5 * first_um);
            let allowed = format!("at most {half_um} µm, half of the thinnest layer: two slabs");
            let remedy = "take thinner slabs, or remove [layer.composed]: so thin a layer is solved at once";
            faults.add("layer.composed.slab_um", table.slab_um, allowed, remedy);
        }
        let slabs = (first_um / table.slab_um).round().max(2.0);
        let slab_um = first_um / slabs;
        Some(Composed {
            slab_um,
            directions,
            thicknesses_um,
            mixing: None,
            layers: Vec::new(),
            varied: None,
            joint_index: None,
        })
    }
}

/// The layer whose slabs have been checked.
pub(super) fn complete(study: &mut Study, composed: Composed) {
    study.layer.thickness_um = composed.thicknesses_um.first().copied().unwrap_or(f64::NAN);
    study.packing.thickness_um = composed.slab_um;
    study.variation.light = LightRule::Listed;
    study.kind = StudyKind::Composed(composed);
    if study.judgement.viewing != Viewing::default() || study.judgement.target_lab.is_some() {
        let of_exports =
            "other conditions have an effect in files of `inkwave export` only, targets have none";
        study.remarks.push(format!("[colour]: colours of a composed layer are D65 and 2°; {of_exports}"));
    }
    if study.realisations < USABLE {
        study.remarks.push(format!(
            "run.realisations = {}: error bars of a composed layer need {USABLE} or more",
            study.realisations
        ));
    }
}

/// Refuses what studies of slabs do not have: `what` is composed, by this table.
pub(super) fn refuse_beside_slabs(file: &StudyFile, what: &str, table: &str, faults: &mut Faults) {
    let mut refuse = |found: Option<String>, field: &str, allowed: &str, remedy: &str| {
        if let Some(found) = found {
            faults.add(field, found, format!("{allowed} where {what} is composed"), remedy);
        }
    };
    let remedy = format!("remove angles.count and angles.polar_deg; {table}.directions sets them");
    let own = "directions of its own";
    refuse(file.angles.count.as_ref().map(as_written), "angles.count", own, &remedy);
    refuse(file.angles.polar_deg.as_ref().map(as_written), "angles.polar_deg", own, &remedy);
    let shifted = "remove it: all realisations are solved at the wavelengths of the spectra";
    let drawn = file.light.per_realisation.as_ref().map(as_written);
    refuse(drawn, "light.per_realisation", "listed wavelengths", shifted);
    let aim = "remove it and set run.realisations; 12 to 24 are usual";
    let target = file.run.target_delta_e.map(shown);
    refuse(target, "run.target_delta_e", "a number of realisations", aim);
    let measured = "remove [compare]: compare the spectra of results.json";
    refuse(file.compare.measured.as_ref().map(as_written), "compare.measured", "no measurement", measured);
}

/// What composing does not do.
pub(super) fn refusals(file: &StudyFile, study: &Study, faults: &mut Faults) {
    if let Some(relief) = &file.layer.relief {
        let remedy = "remove [layer.relief]: inner slabs have no surface, and skins need a plane one yet";
        let allowed = "a plane surface where it is composed";
        faults.add("layer.relief", as_written(relief), allowed, remedy);
    }
    for (k, pigment) in file.pigments.iter().enumerate() {
        let Some(profile) = &pigment.profile else { continue };
        let remedy = "remove it: slabs are cut from one packing without a gradient";
        let allowed = "even layers where it is composed";
        faults.add(format!("pigment[{k}].profile"), as_written(profile), allowed, remedy);
    }
    refuse_beside_slabs(file, "it", "layer.composed", faults);
    let thinnest =
        study.wavelengths_nm.iter().map(|nm| study.embedding_index(1e-3 * nm)).fold(f64::INFINITY, f64::min);
    if !study.pigments.is_empty() && thinnest < 1.0 {
        let remedy = "lower the volume fraction of the metal, or remove [layer.composed]";
        let allowed =
            "1 or more where it is composed: slabs are solved between half-spaces of the mixture's index";
        faults.add("pigment", format!("a mixture of index {thinnest:.2}"), allowed, remedy);
    }
    if study.pigments.is_empty() {
        let remedy = "remove [layer.composed]: a clear layer is solved exactly at any thickness";
        faults.add("pigment", "none", "grains where the layer is composed", remedy);
    }
    if study.realisations < 2 && !study.pigments.is_empty() {
        let remedy = "12 to 24 are usual: one realisation has no error bar";
        faults.add("run.realisations", study.realisations, "2 or more", remedy);
    }
}

#[cfg(test)]
mod tests {
    use crate::ink::pack;
    use crate::ink::statistics::profile;
    use crate::input::check::check;
    use crate::input::fault::Fault;
    use crate::input::study::{Position, Study};
    use crate::store::identity::Key;
    use std::path::Path;

    fn study(layer: &str, rest: &str) -> Result<Study, Vec<Fault>> {
        let text = format!(
            "title = 't'\n[layer]\nbinder.index = 1.5\n{layer}\n[[pigment]]\nname = 'p'\ndiameter_nm = 250\n\
             volume_fraction = 0.2\nindex = 2.0\n[light]\nwavelengths_nm = [450, 650]\n{rest}\n"
        );
        check(&toml::from_str(&text).expect("a study file"), Path::new("."), "test")
    }

    /// Results of before this program's enum of kinds are read, and hashes stay: what a study is of
    /// is written with the layer, with the directions and beside them.
    #[test]
    fn what_a_study_is_of_is_written_in_its_places() {
        let whole = study("thickness_um = 10\n[layer.composed]\nslab_um = 2", "").unwrap();
        let alone = study("thickness_um = 1", "[angles]\npolar_deg = [0, 30]").unwrap();
        let written = |study: &Study| serde_json::to_value(study).unwrap();
        assert_eq!(written(&whole)["layer"]["composed"]["slab_um"], 2.0);
        assert_eq!(written(&whole)["angles"]["no_paper"], serde_json::Value::Null);
        assert!(
            written(&alone)["angles"]["no_paper"].is_string() && written(&alone).get("portion").is_none()
        );
        for study in whole.portions().into_iter().chain([whole, alone]) {
            let read: Study = serde_json::from_value(written(&study)).unwrap();
            assert_eq!((&read.kind, read.key()), (&study.kind, study.key()));
        }
    }

    /// Slabs of several layers may have one seed. *Planted*: packings named by seed and thickness.
    #[test]
    fn slabs_with_one_name_of_packings_have_the_same() {
        let composed = "thickness_um = 10\n[layer.composed]\nslab_um = 2";
        let contact = format!("index_out = 1.4\n{composed}");
        let one = study(composed, "").unwrap().portions();
        let two = study(&contact, "[paper]\ncoupling = 'optical_contact'").unwrap().portions();
        for a in one.iter().chain(&two) {
            for b in one.iter().chain(&two).filter(|b| b.packings_key() == a.packings_key()) {
                assert_eq!(Key::of_packing(&a.packing_request(0)), Key::of_packing(&b.packing_request(0)));
            }
        }
    }

    #[test]
    fn a_layer_is_cut_into_slabs_and_skins() {
        let study = study(
            "thickness_um = [10, 20]\nindex_out = 1.4\n[layer.composed]\nslab_um = 2.2",
            "[paper]\ncoupling = 'optical_contact'",
        )
        .unwrap();
        let portions = study.portions();
        let all: Vec<_> =
            portions.iter().map(|p| (p.portion().unwrap().position, p.layer.thickness_um)).collect();
        use Position::{Back, Front, Inner};
        assert_eq!(all, [(Inner, 2.0), (Front, 2.0), (Back, 2.0), (Inner, 1.0), (Front, 1.0), (Back, 1.0)]);
        // n_eff = √(0.2 · 4 + 0.8 · 2.25), and the media next to each slab
        let effective_index = 2.6_f64.sqrt();
        let media = |k: usize| portions[k].media(0.5);
        assert!((media(0).incident.re - effective_index).abs() < 1e-12 && media(0).exit == media(0).incident);
        assert_eq!((media(1).incident.re, media(1).exit), (1.0, media(0).exit));
        assert_eq!((media(2).incident, media(2).exit.re), (media(0).incident, 1.4));
        // each has packings of its own; what is solved is counted
        assert!(portions.windows(2).all(|p| p[0].packing.seed != p[1].packing.seed));
        assert_eq!(
            study.solves(),
            portions.iter().map(|p| p.realisations * p.points(0).len()).sum::<usize>()
        );
    }

    /// 20 % of 2.0 in 1.5. Maxwell Garnett: β = 0.2 · 1.75/8.5, ε = 2.25 (1 + 2β)/(1 − β).
    /// *Planted*: the volume average.
    #[test]
    fn slabs_in_maxwells_equations_lie_between_half_spaces_of_maxwell_garnett() {
        let layer = "thickness_um = 10\n[layer.composed]\nslab_um = 2";
        let beta: f64 = 0.2 * 1.75 / 8.5;
        let garnett = (2.25 * (1.0 + 2.0 * beta) / (1.0 - beta)).sqrt();
        for (wave, index) in [("scalar", 2.6_f64.sqrt()), ("unpolarised", garnett)] {
            let text = format!(
                "title = 't'\n[layer]\nbinder.index = 1.5\n{layer}\n[[pigment]]\nname = 'p'\ndiameter_nm = 250\n\
                 volume_fraction = 0.2\nindex = 2.0\n[light]\nwavelengths_nm = [450, 650]\nwave = '{wave}'\n"
            );
            let file = toml::from_str(&text).expect("a study file");
            let study = check(&file, Path::new("."), "test").expect("a sound study");
            let inner = &study.portions()[0];
            assert!((study.embedding_index(0.5) - index).abs() < 1e-12, "{wave}");
            assert_eq!(inner.media(0.5).incident.re, study.embedding_index(0.5), "{wave}");
        }
    }

    /// Pigment in the slab's outermost twentieths, µm of 2, over what it holds on the mean.
    fn at_faces(portion: &Study) -> [f64; 2] {
        let packings = (0..4).map(|r| pack(&portion.packing_request(r), &mut ()).expect("a packing"));
        let profiles: Vec<Vec<Vec<f64>>> = packings.map(|packing| profile(&packing, 20)).collect();
        let mean = |slice: usize| profiles.iter().map(|of| of[slice][0]).sum::<f64>() / 4.0 / 0.2;
        [mean(0), mean(19)]
    }

    /// Only the layer's own surfaces lack grains, no joint of slabs does. *Planted*: slabs between
    /// walls.
    #[test]
    fn slabs_are_as_full_at_their_joints_as_within() {
        let layer = "thickness_um = 10\nperiod_um = 1.6\nindex_out = 1.4\n[layer.composed]\nslab_um = 2";
        let portions = study(layer, "[paper]\ncoupling = 'optical_contact'").unwrap().portions();
        let [inner, front, back] = [0, 1, 2].map(|k| at_faces(&portions[k]));
        // 0.1 µm at a wall are filled to a quarter; joints of four cells of 35 grains are ± 10 %
        for (at_joint, name) in
            [(inner[0], "inner"), (inner[1], "inner"), (front[1], "front"), (back[0], "back")]
        {
            assert!((at_joint - 1.0).abs() < 0.4, "{name}: {at_joint}");
        }
        assert!(front[0] < 0.6 && back[1] < 0.6, "{front:?} {back:?}");
    }

    #[test]
    fn what_cannot_be_composed_is_refused_with_a_remedy() {
        let composed = "[layer.composed]\nslab_um = 2";
        let cases = [
            ("thickness_um = 3", composed, "", "layer.composed.slab_um"),
            ("thickness_um = [4, 8]", "", "", "layer.thickness_um"),
            ("thickness_um = [8, 4]", composed, "", "layer.thickness_um[1]"),
            ("thickness_um = { mean = 8, std = 1 }", composed, "", "layer.thickness_um.std"),
            ("thickness_um = 8\nrelief = { depth_um = 0.1 }", composed, "", "layer.relief"),
            ("thickness_um = 8", composed, "[angles]\ncount = 5", "angles.count"),
            ("thickness_um = 8\nindex_in = 1.2", composed, "", "layer.index_in"),
            ("thickness_um = 8", composed, "[run]\nrealisations = 1", "run.realisations"),
            ("thickness_um = 8", "[layer.composed]\nslab_um = 0.4", "", "pigment[0].diameter_nm"),
        ];
        for (layer, table, rest, field) in cases {
            let faults = study(&format!("{layer}\n{table}"), rest).expect_err(field);
            assert!(faults.iter().any(|f| f.field == field && !f.remedy.is_empty()), "{field}: {faults:?}");
            assert!(faults.iter().all(|f| !f.remedy.contains("list angles.polar_deg")), "{faults:?}");
        }
        for (rest, told) in [("", false), ("[colour]\nilluminant = 'D50'", true)] {
            let remarks = study(&format!("thickness_um = 8\n{composed}"), rest).unwrap().remarks;
            assert_eq!(remarks.iter().any(|remark| remark.contains("[colour]")), told);
        }
    }
}
