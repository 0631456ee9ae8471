//! From the file of a fit to checked studies and spectra.

mod drawdowns;
mod numbers;
mod refusals;
mod shares;
mod source;
mod spectrum;

pub use numbers::MeasuredNumber;

use super::face::SampleFace;
use super::file::{FitFile, FitGeometry, FitTable, MeasuredTable, PriorName};
use super::prior::SHORTEST_NM;
use crate::input::fault::{Faults, StudyError};
use crate::input::field::set;
use crate::input::load::{read_file, stem};
use crate::input::study::{IndexSpectrum, Study};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use toml::{Table, Value};

/// Fewest cells whose differences give an error.
const FEWEST_CELLS: usize = 6;

/// A layer on a backing, and what was measured of it.
#[derive(Clone, Debug)]
pub struct Drawdown {
    /// For people: file and sample, or the layer.
    pub name: String,
    /// Its study; the pigment's index is a placeholder.
    pub study: Study,
    /// Place of its layer among all different ones.
    pub coat: usize,
    /// How it is measured.
    pub geometry: FitGeometry,
    /// Whether it is so thick that its card does not matter.
    pub is_opaque: bool,
    /// The sample's face.
    pub face: SampleFace,
    /// Measured values at the study's wavelengths; none where the layer is to be predicted only, or
    /// has numbers only.
    pub values: Option<Vec<f64>>,
    /// Numbers measured.
    pub numbers: Vec<MeasuredNumber>,
}

impl Drawdown {
    /// Albedo of its backing at a wavelength.
    pub fn albedo(&self, nm: f64) -> Option<f64> {
        self.study.paper.albedo.at(nm).ok()
    }

    /// Whether light that its face adds is in the reading.
    pub fn is_reflected(&self) -> bool {
        self.geometry != FitGeometry::Transmitted
    }

    /// Measured value at a wavelength of the study, by its place.
    pub fn measured(&self, wave: usize) -> f64 {
        self.values.as_ref().map_or(f64::NAN, |values| values[wave])
    }
}

/// A checked fit.
#[derive(Clone, Debug)]
pub struct FitTask {
    /// Title, for people.
    pub title: String,
    /// What is fitted, and how.
    pub settings: FitTable,
    /// Place of the pigment among those with grains, in the studies.
    pub pigment: usize,
    /// Different layers, by one study each: those measured before those predicted only.
    pub coats: Vec<Study>,
    /// Number of layers that are measured.
    pub coats_measured: usize,
    /// Measured spectra.
    pub measured: Vec<Drawdown>,
    /// Spectra to be predicted.
    pub predicted: Vec<Drawdown>,
    /// What was taken where files leave something open.
    pub remarks: Vec<String>,
}

impl FitTask {
    /// The wavelengths, nm.
    pub fn wavelengths_nm(&self) -> &[f64] {
        &self.coats[0].wavelengths_nm
    }

    /// Whether the coats are composed of slabs.
    pub fn is_composed(&self) -> bool {
        self.coats.first().is_some_and(|coat| coat.composed().is_some())
    }

    /// The medium around the pigment's grains.
    pub fn binder(&self) -> &IndexSpectrum {
        let coat = &self.coats[0];
        coat.binders()[coat.layer_of_pigment(self.pigment)]
    }

    /// Index of the binder in the middle of the spectrum.
    pub fn binder_index(&self) -> f64 {
        let index = &self.binder().index;
        index[index.len() / 2].re
    }
}

/// Reads and checks the file of a fit.
///
/// # Errors
/// The file or its base cannot be read, or values are not allowed.
pub fn load(path: &Path) -> Result<FitTask, StudyError> {
    let (text, file): (String, FitFile) = read_file(path)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let (base, base_folder) = file.base.read(folder)?;
    let remarks = Vec::new();
    let faults = Faults::default();
    let densities = &file.fit.densities_g_per_cm3;
    let (pigment, order) = (PigmentPlace::default(), Vec::new());
    let mut reading = FitReading { folder, base_folder, base, pigment, order, densities, remarks, faults };
    reading.prepare(&file);
    let task = reading.task(&file, path);
    match (task, reading.faults.0) {
        (Some(task), faults) if faults.is_empty() => Ok(task),
        (_, faults) => Err(StudyError::Values { path: path.to_owned(), text, faults }),
    }
}

/// A pigment as the base names it.
#[derive(Debug, PartialEq)]
struct BasePigment {
    layer: Option<usize>,
    layer_name: String,
    /// Place among those of its layer.
    number: usize,
    name: String,
    has_grains: bool,
}

impl BasePigment {
    /// Whether this is its name, or that with the name of its layer.
    fn is_called(&self, requested: &str) -> bool {
        self.name == requested || (self.layer.is_some() && self.full_name() == requested)
    }

    /// Its name; in a stack after that of its layer.
    fn full_name(&self) -> String {
        self.layer.map_or(self.name.clone(), |_| format!("{}.{}", self.layer_name, self.name))
    }
}

/// Where the pigment with the unknown index stands.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct PigmentPlace {
    /// Its layer among those of a stack.
    layer: Option<usize>,
    /// Place among the pigments of the base, or of its layer.
    in_file: usize,
    /// Place in the studies, which count pigments with grains only.
    in_study: usize,
}

impl PigmentPlace {
    /// The layer's table in the base.
    fn layer_path(self) -> String {
        self.layer.map_or("layer".to_owned(), |layer| format!("layer[{layer}]"))
    }

    /// The pigment's table in the base.
    fn path(self) -> String {
        let of_layer = self.layer.map_or(String::new(), |layer| format!("layer[{layer}]."));
        format!("{of_layer}pigment[{}]", self.in_file)
    }
}

struct FitReading<'a> {
    folder: &'a Path,
    base_folder: PathBuf,
    base: Table,
    pigment: PigmentPlace,
    /// Places of the base's pigments in its file.
    order: Vec<usize>,
    densities: &'a BTreeMap<String, f64>,
    remarks: Vec<String>,
    faults: Faults,
}

impl FitReading<'_> {
    /// Finds the pigment and makes the base a study of listed wavelengths with a placeholder index.
    fn prepare(&mut self, file: &FitFile) {
        self.check_settings(&file.fit);
        self.pigment = self.find_pigment(file.fit.pigment.as_deref());
        self.order = (0..self.names().len()).collect();
        let mut drawdowns = file.measured.iter().chain(&file.predict);
        if drawdowns.any(MeasuredTable::has_own_shares) {
            if self.pigment.layer.is_some() {
                let allowed = "one [base.layer] where drawdowns have volume_fractions or weights";
                let remedy = "give volume_fraction, which is that of the fitted pigment in its layer";
                self.faults.add("base.layer", "a stack of layers", allowed, remedy);
            }
            self.put_first();
        }
        let placeholder = Table::from_iter([("n".into(), 1.6.into()), ("k".into(), 0.1.into())]);
        if let Some(Value::Table(paper)) = self.base.get_mut("paper")
            && paper.remove("fluorescence").is_some()
        {
            self.remarks.push(
                "base.paper.fluorescence is left out: the cards are taken to have no brightener".into(),
            );
        }
        // what cannot be set is a fault of the base, which its check names
        let _ = set(&mut self.base, &format!("{}.index", self.pigment.path()), &Value::Table(placeholder));
        if self.base.get("light").and_then(|light| light.get("wavelengths_nm")).is_none() {
            let _ = set(&mut self.base, "light.sampling", &Value::String("listed".into()));
        }
        for (table, key) in
            [("light", "per_realisation"), ("run", "target_delta_e"), ("stack", "without_layers")]
        {
            if let Some(Value::Table(table)) = self.base.get_mut(table) {
                table.remove(key);
            }
        }
    }

    /// Names of the base's pigments.
    fn names(&self) -> Vec<String> {
        let pigments = self.base.get("pigment").and_then(Value::as_array).into_iter().flatten();
        pigments.map(|p| p.get("name").and_then(Value::as_str).unwrap_or_default().to_owned()).collect()
    }

    /// Puts the pigment with the unknown index before the others, so that its place is the same in
    /// drawdowns that lack some of them.
    fn put_first(&mut self) {
        let place = self.pigment.in_file;
        if let Some(Value::Array(pigments)) = self.base.get_mut("pigment")
            && place < pigments.len()
        {
            pigments[..=place].rotate_right(1);
            self.order[..=place].rotate_right(1);
            self.pigment = PigmentPlace::default();
        }
    }

    /// A field of a base whose pigments stand elsewhere in its file; `places` are those of the
    /// pigments that a drawdown has.
    fn as_written(&self, field: &str, places: &[usize]) -> String {
        let parts = field.strip_prefix("pigment[").and_then(|rest| rest.split_once(']'));
        let place = |number: &str| self.order.get(*places.get(number.parse::<usize>().ok()?)?);
        match parts.and_then(|(number, rest)| Some((place(number)?, rest))) {
            Some((place, rest)) => format!("pigment[{place}]{rest}"),
            None => field.to_owned(),
        }
    }

    fn find_pigment(&mut self, requested: Option<&str>) -> PigmentPlace {
        let all = self.all_pigments();
        let is_meant = |pigment: &&BasePigment| match requested {
            Some(requested) => pigment.is_called(requested),
            None => all.len() == 1,
        };
        let found: Vec<&BasePigment> = all.iter().filter(is_meant).collect();
        let packed: Vec<&BasePigment> = all.iter().filter(|pigment| pigment.has_grains).collect();
        let place = match found[..] {
            [found] => packed.iter().position(|pigment| pigment == &found),
            _ => None,
        };
        if place.is_none() {
            let said = requested.map_or("nothing".into(), |name| format!("{name:?}"));
            let said = match found.len() {
                0 => said,
                1 => said + ", a dissolved pigment",
                count => format!("{said}, {count} pigments"),
            };
            let names = packed.iter().map(|pigment| pigment.full_name()).collect::<Vec<_>>().join(", ");
            let (allowed, remedy) = match packed.len() {
                0 => (
                    "a pigment with grains, of which the base has none".to_owned(),
                    "give the base's pigment a diameter_nm in nm; the index of a dissolved one is no unknown of a fit",
                ),
                _ => (
                    format!("the name of one of the base's pigments with grains: {names}"),
                    "name the pigment whose index is unknown",
                ),
            };
            self.faults.add("fit.pigment", said, allowed, remedy);
        }
        let [layer, in_file] =
            found.first().map_or([None, Some(0)], |found| [found.layer, Some(found.number)]);
        PigmentPlace { layer, in_file: in_file.unwrap_or(0), in_study: place.unwrap_or(0) }
    }

    /// The pigments of the base's layer, or of all layers of its stack.
    fn all_pigments(&self) -> Vec<BasePigment> {
        let listed = |table: Option<&Value>| table.and_then(Value::as_array).cloned().unwrap_or_default();
        let named = |table: &Value| table.get("name").and_then(Value::as_str).unwrap_or_default().to_owned();
        let of_list = |list: Vec<Value>, layer: Option<usize>, layer_name: &str| -> Vec<BasePigment> {
            let pigment = |(number, table): (usize, Value)| BasePigment {
                layer,
                layer_name: layer_name.to_owned(),
                number,
                name: named(&table),
                has_grains: !table.get("diameter_nm").is_some_and(Value::is_str),
            };
            list.into_iter().enumerate().map(pigment).collect()
        };
        match self.base.get("layer") {
            Some(Value::Array(layers)) => layers
                .iter()
                .enumerate()
                .flat_map(|(k, layer)| of_list(listed(layer.get("pigment")), Some(k), &named(layer)))
                .collect(),
            _ => of_list(listed(self.base.get("pigment")), None, ""),
        }
    }

    fn task(&mut self, file: &FitFile, path: &Path) -> Option<FitTask> {
        if file.measured.is_empty() {
            let remedy = "add [[measured]] with file and backing, best on white and on black card";
            self.faults.add("measured", "none", "one or more [[measured]] spectra", remedy);
        }
        let mut coats = Vec::new();
        let measured = self.drawdowns("measured", &file.measured, &mut coats);
        let coats_measured = coats.len();
        if !file.measured.is_empty() && file.measured.iter().all(|table| table.file.is_none()) {
            let allowed =
                "the spectrum of one sample or more: numbers alone determine no index at any wavelength";
            self.faults.add("measured", "numbers only", allowed, "name a CSV, CxF3 or CGATS.17 file");
        }
        let predicted = self.drawdowns("predict", &file.predict, &mut coats);
        let first = coats.first()?;
        if !first.layer.contrast.is_full() {
            let remedy = "leave layer.contrast out: a part of the contrast has no index of its own";
            self.faults.add("base.layer.contrast", "a part", "\"full\"", remedy);
        }
        if first.realisations < FEWEST_CELLS {
            let found = first.realisations;
            let allowed = format!("{FEWEST_CELLS} or more");
            let remedy = "errors are estimated from the differences between cells: 8 are usual";
            self.faults.add("base.run.realisations", found, allowed, remedy);
        }
        self.check_stack(first);
        if let Some(reason) = first.no_paper() {
            self.faults.add("base.angles", reason, "0°, 45° and the hemisphere", "write count = 5");
        }
        let shortest = first.wavelengths_nm[0];
        if file.fit.prior == PriorName::KramersKronig && shortest < SHORTEST_NM {
            let allowed = format!(
                "{SHORTEST_NM} nm or more for fit.prior = \"kramers-kronig\", whose pole is at 200 nm"
            );
            let remedy = format!("begin at {SHORTEST_NM} nm, or write fit.prior = \"smooth\"");
            self.faults.add(
                "base.light",
                format!("{shortest} nm as the shortest wavelength"),
                allowed,
                remedy,
            );
        }
        let pigment = self.pigment.in_study;
        let settings = file.fit.clone();
        self.faults.title(file.title.as_deref());
        let title = file.title.clone().unwrap_or_else(|| stem(path));
        let mut remarks = std::mem::take(&mut self.remarks);
        remarks.dedup();
        let task = FitTask { title, settings, pigment, coats, coats_measured, measured, predicted, remarks };
        if task.is_composed() {
            self.check_composed(file, &task);
        }
        Some(task)
    }
}
