//! Drawdowns: each a study made of the base, with its share, thickness, backing and face.

use super::numbers::implied_geometry;
use super::shares::{Shares, without_absent};
use super::source::MeasuredSource;
use super::{Drawdown, FitReading};
use crate::fit::face::SampleFace;
use crate::fit::file::{FitGeometry, MeasuredTable};
use crate::input::check::check;
use crate::input::fault::{Fault, as_written};
use crate::input::field::set;
use crate::input::forms::AlbedoWritten;
use crate::input::load::read_table;
use crate::input::study::Study;
use crate::numerics::allowed::Allowed;
use std::path::Path;
use toml::{Table, Value};

/// Thickness that stands for an opaque layer, µm: slabs are doubled to it without further solves.
const OPAQUE_UM: f64 = 500.0;
/// Albedo of the card that such a layer and a free one have behind them.
const NO_CARD: f64 = 0.0;
/// Light that a face adds.
const FACE_LIGHT: Allowed = Allowed::between(0.0, 0.2, "");
/// Saunderson's share from outside.
const FACE_K1: Allowed = Allowed::between(0.0, 0.2, "");
/// Saunderson's share from inside.
const FACE_K2: Allowed = Allowed::between(0.0, 0.95, "");

impl FitReading<'_> {
    pub(super) fn drawdowns(
        &mut self,
        list: &str,
        tables: &[MeasuredTable],
        coats: &mut Vec<Study>,
    ) -> Vec<Drawdown> {
        let mut all: Vec<Drawdown> = Vec::new();
        let sources: Vec<Option<MeasuredSource>> = tables
            .iter()
            .map(|table| Some(MeasuredSource::of(&self.folder.join(table.file.as_ref()?))))
            .collect();
        let mut read: Vec<Option<Vec<f64>>> = vec![None; tables.len()];
        for (i, table) in tables.iter().enumerate() {
            let field = format!("{list}[{i}]");
            let Some(study) = self.study(&field, table) else { continue };
            // a dissolved pigment is refused already
            let Some(pigment) = study.pigments.get(self.pigment.in_study) else { continue };
            let of_card = study.remarks.iter().filter(|remark| remark.starts_with("paper.albedo"));
            self.remarks
                .extend(of_card.map(|remark| remark.replace("paper.albedo", &format!("{field}.backing"))));
            let spectrum = self.spectrum(&field, table, &study);
            let geometry = spectrum.as_ref().map_or(table.geometry, |spectrum| spectrum.geometry);
            let geometry = geometry.or(implied_geometry(table, &study)).unwrap_or_default();
            let numbers = self.numbers(&field, table, &study, geometry);
            if geometry == FitGeometry::Transmitted && study.layer.index_out != 1.0 {
                let remedy = "leave index_out and paper.coupling out";
                let allowed = "1, the air behind a free layer, where geometry = \"transmittance\"";
                self.faults.add("base.layer.index_out", study.layer.index_out, allowed, remedy);
            }
            let face = self.face(&field, table, &study, geometry);
            let values = spectrum.map(|spectrum| spectrum.values);
            read[i].clone_from(&values);
            // one file under two names, a copy, or one sample with and without its name
            let again = |other: &usize| {
                let one_file =
                    sources[*other].as_ref().zip(sources[i].as_ref()).is_some_and(|(a, b)| a.is(b));
                one_file
                    && (tables[*other].patch == table.patch || (values.is_some() && read[*other] == values))
            };
            if let Some(first) = (0..i).find(again) {
                let found = format!("the spectrum of {list}[{first}] again");
                let remedy = "remove one: the same values twice are no independent data";
                self.faults.add(format!("{field}.file"), found, "each spectrum once", remedy);
            }
            if list == "measured" && table.file.is_none() && table.number.is_empty() {
                let remedy = "name a CSV, CxF3 or CGATS.17 file, or add [[measured.number]]";
                self.faults.add(format!("{field}.file"), "nothing", "the file of the spectrum", remedy);
            }
            if list == "predict" && !table.number.is_empty() {
                let remedy = "move them under [[measured]], or remove them";
                let found = format!("{} numbers", table.number.len());
                self.faults.add(format!("{field}.number"), found, "none under [[predict]]", remedy);
            }
            let same = |coat: &Study| coat.packings_key() == study.packings_key();
            let coat = coats.iter().position(same).unwrap_or(coats.len());
            if coat == coats.len() {
                coats.push(study.clone());
            }
            let percent = rounded(100.0 * pigment.grains.volume_fraction);
            let um =
                rounded(study.thicknesses_of_pigments_um(study.layer.thickness_um)[self.pigment.in_study]);
            let layer = if table.opaque {
                format!("{percent} %, opaque")
            } else {
                format!("{percent} % of {um} µm")
            };
            let patch = table.patch.as_ref().map_or(String::new(), |patch| format!(": {patch}"));
            let name = match &table.file {
                Some(file) => format!("{file}{patch} ({layer})"),
                None => layer,
            };
            let is_opaque = table.opaque;
            all.push(Drawdown { name, study, coat, geometry, is_opaque, face, values, numbers });
        }
        all
    }

    /// The study of a drawdown, with its shares, thickness and backing.
    fn study(&mut self, field: &str, table: &MeasuredTable) -> Option<Study> {
        let backing = self.backing(field, table)?;
        let shares = match self.shares(field, table) {
            Ok(shares) => shares,
            Err(fault) => {
                self.faults.push(fault);
                return None;
            }
        };
        let um = if table.opaque { Some(OPAQUE_UM) } else { table.thickness_um };
        let share_of_base = format!("{}.volume_fraction", self.pigment.path());
        let thickness_of_base = format!("{}.thickness_um", self.pigment.layer_path());
        let changes = [
            (share_of_base.as_str(), "volume_fraction", table.volume_fraction.map(Value::from)),
            (thickness_of_base.as_str(), "thickness_um", um.map(|um| self.thickness(um))),
            ("paper.albedo", "backing", Some(backing)),
        ];
        let mut changed_base = self.base.clone();
        for (name, _, value) in &changes {
            let _ = value.as_ref().map(|value| set(&mut changed_base, name, value));
        }
        let places = without_absent(&mut changed_base, &shares);
        let checked = read_table(changed_base);
        let faults = match checked.and_then(|file| check(&file, &self.base_folder, "drawdown")) {
            Ok(study) => return Some(study),
            Err(faults) => faults,
        };
        for fault in faults {
            let mut changed = changes.iter().filter(|(.., value)| value.is_some());
            let place = changed.find(|(name, ..)| fault.field.starts_with(name));
            let of_shares = shares.key.filter(|_| fault.field.ends_with(".volume_fraction"));
            let key = of_shares.or(place.map(|(_, key, _)| *key));
            let written = || format!("base.{}", self.as_written(&fault.field, &places));
            let field = key.map_or_else(written, |key| format!("{field}.{key}"));
            if !self.faults.0.iter().any(|known| known.field == field && known.found == fault.found) {
                let found = fault.found.replace("paper.albedo", &field);
                self.faults.push(Fault { field, found, ..fault });
            }
        }
        None
    }

    /// A thickness of the pigment's layer, with the base's relative spread.
    fn thickness(&self, um: f64) -> Value {
        let layer = match (self.base.get("layer"), self.pigment.layer) {
            (Some(Value::Array(layers)), Some(number)) => layers.get(number),
            (layer, _) => layer,
        };
        let written = layer.and_then(|layer| layer.get("thickness_um"));
        let number = |key: &str| {
            let value = written?.get(key)?;
            value.as_float().or(value.as_integer().map(|i| i as f64))
        };
        match (number("mean"), number("std")) {
            (Some(mean), Some(std)) if mean > 0.0 => {
                Table::from_iter([("mean".into(), um.into()), ("std".into(), (std * um / mean).into())])
                    .into()
            }
            _ => um.into(),
        }
    }

    /// What is behind a layer, as its study has it; where the card does not matter, none is named.
    fn backing(&mut self, field: &str, table: &MeasuredTable) -> Option<Value> {
        let is_free = table.geometry == Some(FitGeometry::Transmitted);
        let composed = self.base.get("layer").is_some_and(|layer| layer.get("composed").is_some());
        if table.opaque && self.pigment.layer.is_some() {
            let allowed = "false where the base is a stack, whose layers are solved as a whole";
            let remedy = "remove opaque, and give backing; or take a base with one [layer]";
            self.faults.add(format!("{field}.opaque"), "true", allowed, remedy);
            return None;
        }
        if table.opaque && !composed {
            let allowed = "a base with [layer.composed], which doubles slabs to any thickness";
            let remedy = "add [base.layer.composed] with slab_um = 2, or give thickness_um and backing";
            self.faults.add(format!("{field}.opaque"), "true", allowed, remedy);
            return None;
        }
        if table.opaque && is_free {
            let remedy = "remove opaque, and give thickness_um";
            self.faults.add(format!("{field}.opaque"), "true", "a layer that light passes", remedy);
            return None;
        }
        if let Some(um) = table.thickness_um.filter(|_| table.opaque) {
            let remedy = "remove thickness_um, or opaque";
            self.faults.add(format!("{field}.thickness_um"), um, "none where opaque = true", remedy);
            return None;
        }
        let without_card = table.opaque || is_free;
        match &table.backing {
            Some(backing) if without_card => {
                let allowed = "none where opaque = true, or geometry = \"transmittance\"";
                let found = as_written(backing);
                self.faults.add(format!("{field}.backing"), found, allowed, "remove backing");
                None
            }
            Some(backing) => Some(written(backing, self.folder)),
            None if without_card => Some(NO_CARD.into()),
            None => {
                let remedy = "write backing = 0.85 for a white card, backing = 0.04 for a black one, 0 for a free film; or opaque = true";
                let allowed = "the albedo of the card under the layer";
                self.faults.add(format!("{field}.backing"), "nothing", allowed, remedy);
                None
            }
        }
    }

    /// The shares of a drawdown's pigments, where it has its own.
    fn shares(&self, field: &str, table: &MeasuredTable) -> Result<Shares, Fault> {
        Shares::of(field, table, self.densities, &self.names())
    }

    /// The face of a sample.
    fn face(
        &mut self,
        field: &str,
        table: &MeasuredTable,
        study: &Study,
        geometry: FitGeometry,
    ) -> SampleFace {
        let Some(face) = table.face else { return SampleFace::Smooth };
        let field = format!("{field}.face");
        if geometry == FitGeometry::Transmitted {
            let remedy = "remove face: what a film passes is taken with smooth faces";
            self.faults.add(field, as_written(&face), "none where geometry = \"transmittance\"", remedy);
            return SampleFace::Smooth;
        }
        match (face.light, face.k1.zip(face.k2)) {
            (Some(light), None) if face.k1.or(face.k2).is_none() => {
                let usual = "matt and dusty faces add 0.01 to 0.02";
                self.faults.number(&format!("{field}.light"), light, FACE_LIGHT, usual);
                SampleFace::Matt { light }
            }
            (None, Some((k1, k2))) => {
                let usual = "0.03 and 0.6 are usual for a paint in air";
                self.faults.number(&format!("{field}.k1"), k1, FACE_K1, usual);
                self.faults.number(&format!("{field}.k2"), k2, FACE_K2, usual);
                SampleFace::saunderson([k1, k2], geometry, &study.layer.binder.index)
            }
            _ => {
                let found = as_written(&face);
                let allowed = "light alone, or k1 and k2 together";
                let remedy = "write face = { light = 0.012 } or face = { k1 = 0.03, k2 = 0.6 }";
                self.faults.add(field, found, allowed, remedy);
                SampleFace::Smooth
            }
        }
    }
}

/// A number as it is shown, to four decimals.
fn rounded(x: f64) -> f64 {
    (1e4 * x).round() / 1e4
}

/// An albedo as a value of TOML; its table is looked for beside the file of the fit.
fn written(albedo: &AlbedoWritten, folder: &Path) -> Value {
    let value = |albedo: &AlbedoWritten| Value::try_from(albedo).unwrap_or(Value::Boolean(false));
    match albedo {
        AlbedoWritten::Csv { csv, patch, unit, condition } => {
            let path = folder.join(csv);
            let csv = std::path::absolute(&path).unwrap_or(path).display().to_string();
            value(&AlbedoWritten::Csv { csv, patch: patch.clone(), unit: *unit, condition: *condition })
        }
        other => value(other),
    }
}
