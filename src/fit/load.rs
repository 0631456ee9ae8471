//! From the file of a fit to checked studies and spectra.

use super::file::{FitFile, FitGeometry, FitTable, KNOWN_ERROR, MeasuredTable, PriorName};
use super::prior::SHORTEST_NM;
use crate::input::check::check;
use crate::input::fault::{Fault, Faults, StudyError};
use crate::input::field::set;
use crate::input::forms::AlbedoWritten;
use crate::input::limits::{ANCHOR_NM, INDEX};
use crate::input::load::{read_file, read_table, stem};
use crate::input::measured::{MeasuredContent, MeasuredGeometry, MeasuredReading, MeasuredRequest};
use crate::input::study::Study;
use crate::numerics::allowed::Allowed;
use std::path::{Path, PathBuf};
use toml::{Table, Value};

/// Largest reflectance factor accepted: a layer does not emit light, but calibrations may err.
const BRIGHTEST: f64 = 1.02;
/// Smallest reflectance factor accepted: instrument noise at black.
const DARKEST: f64 = -0.02;
/// Largest file that is compared with others byte by byte: spectra are smaller by far.
const LARGEST_COMPARED: u64 = 1 << 22;
/// Fewest cells whose differences give an error.
const FEWEST_CELLS: usize = 6;
/// Distance of n from the binder's below which a composed coat scatters too little for its table.
const LEAST_CONTRAST: f64 = 0.05;

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
    /// Measured values at the study's wavelengths; none where the layer is to be predicted only.
    pub values: Option<Vec<f64>>,
}

impl Drawdown {
    /// Albedo of its backing at a wavelength.
    pub fn albedo(&self, nm: f64) -> Option<f64> {
        self.study.paper.albedo.at(nm).ok()
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

    /// Index of the binder in the middle of the spectrum.
    pub fn binder_index(&self) -> f64 {
        let index = &self.coats[0].layer.binder.index;
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
    let mut reading = FitReading { folder, base_folder, base, pigment: [0; 2], remarks, faults };
    reading.prepare(&file);
    let task = reading.task(&file, path);
    match (task, reading.faults.0) {
        (Some(task), faults) if faults.is_empty() => Ok(task),
        (_, faults) => Err(StudyError::Values { path: path.to_owned(), text, faults }),
    }
}

struct FitReading<'a> {
    folder: &'a Path,
    base_folder: PathBuf,
    base: Table,
    /// Places of the pigment in the base and in the studies, which count those with grains only.
    pigment: [usize; 2],
    remarks: Vec<String>,
    faults: Faults,
}

impl FitReading<'_> {
    /// Finds the pigment and makes the base a study of listed wavelengths with a placeholder index.
    fn prepare(&mut self, file: &FitFile) {
        let FitTable { noise, n, kappa, pigment, .. } = &file.fit;
        let usual = "0.003 is usual: 0.3 % of a perfect white";
        self.faults.number("fit.noise", *noise, Allowed::between(1e-5, 0.1, ""), usual);
        for (field, [from, to], allowed) in [("fit.n", n, [1.0, 4.0]), ("fit.kappa", kappa, [0.0, 4.0])] {
            if !(allowed[0] <= *from && from < to && *to <= allowed[1]) {
                let range = format!("[from, to] with {} ≤ from < to ≤ {}", allowed[0], allowed[1]);
                let remedy = "leave it out: [1.3, 2.0] and [0, 0.6]";
                self.faults.add(field, format!("[{from}, {to}]"), range, remedy);
            }
        }
        self.check_known(&file.fit);
        if self.base.get("layer").is_some_and(Value::is_array) {
            let remedy =
                "make drawdowns of one layer, and stack it with others in a study once its index is known";
            self.faults.add("base.layer", "a stack of layers", "one [base.layer]", remedy);
            return;
        }
        self.pigment = self.find_pigment(pigment.as_deref());
        let [place, _] = self.pigment;
        let placeholder = Table::from_iter([("n".into(), 1.6.into()), ("k".into(), 0.1.into())]);
        // what cannot be set is a fault of the base, which its check names
        let _ = set(&mut self.base, &format!("pigment[{place}].index"), &Value::Table(placeholder));
        if self.base.get("light").and_then(|light| light.get("wavelengths_nm")).is_none() {
            let _ = set(&mut self.base, "light.sampling", &Value::String("listed".into()));
        }
        for (table, key) in [("light", "per_realisation"), ("run", "target_delta_e")] {
            if let Some(Value::Table(table)) = self.base.get_mut(table) {
                table.remove(key);
            }
        }
    }

    /// Checks n known from elsewhere.
    fn check_known(&mut self, fit: &FitTable) {
        let Some(known) = fit.known_n else { return };
        let below = "the pole of the ultraviolet is at 200 nm; give a longer wavelength";
        self.faults.number("fit.known_n.n_nm", known.n_nm, ANCHOR_NM, below);
        let measured = "give n where it was measured, such as n_nm = 589 and n = 1.65 by immersion";
        self.faults.number("fit.known_n.n", known.n, INDEX, measured);
        self.faults.number("fit.known_n.n_error", known.n_error, KNOWN_ERROR, "0.01 is usual");
        if fit.prior != PriorName::KramersKronig {
            let allowed = "fit.prior = \"kramers-kronig\", which carries n from one wavelength to all";
            let remedy = "leave fit.prior out, or remove fit.known_n";
            self.faults.add("fit.known_n", "fit.prior = \"smooth\"", allowed, remedy);
        }
    }

    /// What the table of a composed base cannot hold.
    fn check_composed(&mut self, file: &FitFile, task: &FitTask) {
        let [from, to] = file.fit.n;
        let binder = task.binder_index();
        if from < binder + LEAST_CONTRAST && to > binder - LEAST_CONTRAST {
            let allowed = format!(
                "a range of n all above or all below the binder's {binder:.3}, by {LEAST_CONTRAST} or more, where the base is composed: coats do not scatter in between"
            );
            let remedy = format!("write n = [{:.2}, {to}], or what you know of it", binder + 0.1);
            self.faults.add("fit.n", format!("[{from}, {to}]"), allowed, remedy);
        }
        let lists = [("measured", &task.measured), ("predict", &task.predicted)];
        for (list, drawdowns) in lists {
            for (i, drawdown) in drawdowns.iter().enumerate() {
                if drawdown.geometry == FitGeometry::Sphere {
                    let allowed = "\"45:0\" or \"natural\" where the base is composed";
                    let remedy = "measure at 45:0, or fit thin coats";
                    self.faults.add(format!("{list}[{i}].geometry"), "\"d:8\"", allowed, remedy);
                }
            }
        }
    }

    fn find_pigment(&mut self, requested: Option<&str>) -> [usize; 2] {
        let pigments = self.base.get("pigment").and_then(Value::as_array).into_iter().flatten();
        let names = pigments.clone().map(|p| p.get("name").and_then(Value::as_str).unwrap_or_default());
        let names: Vec<&str> = names.collect();
        let found = match requested {
            Some(requested) => names.iter().position(|name| *name == requested),
            None => (names.len() == 1).then_some(0),
        };
        let packed = pigments.enumerate().filter(|(_, p)| !p.get("diameter_nm").is_some_and(Value::is_str));
        let packed: Vec<usize> = packed.map(|(i, _)| i).collect();
        let place = packed.iter().position(|i| Some(*i) == found);
        if place.is_none() {
            let said = requested.map_or("nothing".into(), |name| format!("{name:?}"));
            let said = if found.is_some() { said + ", a dissolved pigment" } else { said };
            let packed = packed.iter().map(|&i| names[i]).collect::<Vec<_>>().join(", ");
            let allowed = format!("the name of one of the base's pigments with grains: {packed}");
            self.faults.add("fit.pigment", said, allowed, "name the pigment whose index is unknown");
        }
        [found.unwrap_or(0), place.unwrap_or(0)]
    }

    fn task(&mut self, file: &FitFile, path: &Path) -> Option<FitTask> {
        if file.measured.is_empty() {
            let remedy = "add [[measured]] with file and backing, best on white and on black card";
            self.faults.add("measured", "none", "one or more [[measured]] spectra", remedy);
        }
        let mut coats = Vec::new();
        let measured = self.drawdowns("measured", &file.measured, &mut coats);
        let coats_measured = coats.len();
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
        let pigment = self.pigment[1];
        let settings = file.fit.clone();
        let title = file.title.clone().unwrap_or_else(|| stem(path));
        let mut remarks = std::mem::take(&mut self.remarks);
        remarks.dedup();
        let task = FitTask { title, settings, pigment, coats, coats_measured, measured, predicted, remarks };
        if task.is_composed() {
            self.check_composed(file, &task);
        }
        Some(task)
    }

    fn drawdowns(&mut self, list: &str, tables: &[MeasuredTable], coats: &mut Vec<Study>) -> Vec<Drawdown> {
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
            let Some(pigment) = study.pigments.get(self.pigment[1]) else { continue };
            let of_card = study.remarks.iter().filter(|remark| remark.starts_with("paper.albedo"));
            self.remarks
                .extend(of_card.map(|remark| remark.replace("paper.albedo", &format!("{field}.backing"))));
            let spectrum = self.spectrum(&field, table, &study);
            let geometry =
                spectrum.as_ref().map_or(table.geometry, |spectrum| spectrum.geometry).unwrap_or_default();
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
            if list == "measured" && values.is_none() && table.file.is_none() {
                let remedy = "name a CSV, CxF3 or CGATS.17 file";
                self.faults.add(format!("{field}.file"), "nothing", "the file of the spectrum", remedy);
            }
            let same = |coat: &Study| coat.packings_key() == study.packings_key();
            let coat = coats.iter().position(same).unwrap_or(coats.len());
            if coat == coats.len() {
                coats.push(study.clone());
            }
            let percent = rounded(100.0 * pigment.grains.volume_fraction);
            let um = rounded(study.layer.thickness_um);
            let layer = format!("{percent} % of {um} µm");
            let name = table.file.clone().unwrap_or_else(|| layer.clone());
            let name = table.patch.clone().map_or(name.clone(), |patch| format!("{name}: {patch}"));
            all.push(Drawdown { name: format!("{name} ({layer})"), study, coat, geometry, values });
        }
        all
    }

    /// The study of a drawdown, with its share, thickness and backing.
    fn study(&mut self, field: &str, table: &MeasuredTable) -> Option<Study> {
        let Some(backing) = &table.backing else {
            let remedy = "write backing = 0.85 for a white card, backing = 0.04 for a black one";
            let allowed = "the albedo of the card under the layer";
            self.faults.add(format!("{field}.backing"), "nothing", allowed, remedy);
            return None;
        };
        let share_of_base = format!("pigment[{}].volume_fraction", self.pigment[0]);
        let changes = [
            (share_of_base.as_str(), "volume_fraction", table.volume_fraction.map(Value::from)),
            ("layer.thickness_um", "thickness_um", table.thickness_um.map(|um| thickness(&self.base, um))),
            ("paper.albedo", "backing", Some(written(backing, self.folder))),
        ];
        let mut changed_base = self.base.clone();
        for (name, _, value) in &changes {
            let _ = value.as_ref().map(|value| set(&mut changed_base, name, value));
        }
        let checked = read_table(changed_base);
        let faults = match checked.and_then(|file| check(&file, &self.base_folder, "drawdown")) {
            Ok(study) => return Some(study),
            Err(faults) => faults,
        };
        for fault in faults {
            let mut changed = changes.iter().filter(|(.., value)| value.is_some());
            let place = changed.find(|(name, ..)| fault.field.starts_with(name));
            let field =
                place.map_or_else(|| format!("base.{}", fault.field), |(_, key, _)| format!("{field}.{key}"));
            if !self.faults.0.iter().any(|known| known.field == field && known.found == fault.found) {
                let found = fault.found.replace("paper.albedo", &field);
                self.faults.push(Fault { field, found, ..fault });
            }
        }
        None
    }

    /// The measured values at the study's wavelengths, and their geometry.
    fn spectrum(&mut self, field: &str, table: &MeasuredTable, study: &Study) -> Option<FitSpectrum> {
        let path = self.folder.join(table.file.as_ref()?);
        let waves = &study.wavelengths_nm;
        let own_keys = |text: &str| text.replace("compare.", &format!("{field}."));
        let request = MeasuredRequest {
            patch: table.patch.clone(),
            one_must_be_named: true,
            unit: table.unit,
            condition: table.condition,
            geometries: geometries(table.geometry),
            used_nm: [waves[0], waves[waves.len() - 1]],
            ..MeasuredRequest::default()
        };
        let reading = MeasuredReading::new(&path, &request).and_then(|reading| match reading.measured {
            MeasuredContent::Spectrum(spectrum) => Ok((spectrum, reading.geometry, reading.remarks)),
            MeasuredContent::Colour(_) => Err(format!("{}: a colour, and no spectrum", path.display())),
        });
        let (spectrum, declared, remarks) = match reading {
            Ok(read) => read,
            Err(error) => {
                let allowed = "a spectrum of reflectance factors against wavelengths in nm, of one sample";
                let remedy = "correct the file, or say by patch, unit, condition or geometry what is meant";
                self.faults.add(format!("{field}.file"), own_keys(&error), allowed, remedy);
                return None;
            }
        };
        self.remarks.extend(remarks.iter().map(|remark| format!("{field}: {}", own_keys(remark))));
        let geometry = table.geometry.or(declared.as_ref().and_then(known_geometry));
        if let (None, Some(FitGeometry::Sphere | FitGeometry::UniformSky), Some(declared)) =
            (table.geometry, geometry, &declared)
        {
            self.remarks.push(format!("{field}.geometry: {}, as the file declares", declared.name()));
        }
        if let Some([nm, value]) = spectrum.rows.iter().find(|row| !(DARKEST..=BRIGHTEST).contains(&row[1])) {
            let allowed = format!("reflectance factors from {DARKEST} to {BRIGHTEST}");
            let remedy =
                "fluorescent layers cannot be fitted; for values in percent write unit = \"percent\"";
            self.faults.add(format!("{field}.file"), format!("{value} at {nm} nm"), allowed, remedy);
            return None;
        }
        let [from, to] = spectrum.range_nm();
        let values: Option<Vec<f64>> = waves.iter().map(|&nm| spectrum.at(nm)).collect();
        if values.is_none() {
            let [first, last] = [waves[0], waves[waves.len() - 1]];
            let allowed = format!("all wavelengths of the base: {first} to {last} nm");
            let remedy = "give [light] of the base a range that all files cover";
            self.faults.add(format!("{field}.file"), format!("{from} to {to} nm"), allowed, remedy);
        }
        Some(FitSpectrum { values: values?, geometry })
    }
}

/// A number as it is shown, to four decimals.
fn rounded(x: f64) -> f64 {
    (1e4 * x).round() / 1e4
}

/// A measured spectrum at the wavelengths of a study.
struct FitSpectrum {
    values: Vec<f64>,
    /// By the key, or as the file declares; none where both are silent.
    geometry: Option<FitGeometry>,
}

/// The geometries of files that suit a key; without it any that can be predicted.
fn geometries(key: Option<FitGeometry>) -> Vec<MeasuredGeometry> {
    let sphere = || vec![MeasuredGeometry::Sphere(Some(true)), MeasuredGeometry::Sphere(None)];
    match key {
        Some(FitGeometry::LitAt45) => vec![MeasuredGeometry::LitAt45],
        Some(FitGeometry::Sphere) => sphere(),
        Some(FitGeometry::UniformSky) => vec![MeasuredGeometry::UniformSky],
        None => vec![
            MeasuredGeometry::LitAt45,
            MeasuredGeometry::Sphere(Some(true)),
            MeasuredGeometry::UniformSky,
        ],
    }
}

/// The geometry that a file's is predicted by. A sphere whose specular light may be included or not
/// needs the key.
fn known_geometry(declared: &MeasuredGeometry) -> Option<FitGeometry> {
    match declared {
        MeasuredGeometry::LitAt45 => Some(FitGeometry::LitAt45),
        MeasuredGeometry::Sphere(Some(true)) => Some(FitGeometry::Sphere),
        MeasuredGeometry::UniformSky => Some(FitGeometry::UniformSky),
        MeasuredGeometry::Sphere(_) | MeasuredGeometry::Other(_) => None,
    }
}

/// Where a spectrum comes from.
struct MeasuredSource {
    /// The file without links and dots; none where there is no such file.
    path: Option<PathBuf>,
    content: Option<Vec<u8>>,
}

impl MeasuredSource {
    fn of(path: &Path) -> Self {
        let content = std::fs::metadata(path).ok().filter(|file| file.len() <= LARGEST_COMPARED);
        Self { path: path.canonicalize().ok(), content: content.and_then(|_| std::fs::read(path).ok()) }
    }

    /// Whether both are one file, or a file and its copy.
    fn is(&self, other: &Self) -> bool {
        let one_path = self.path.is_some() && self.path == other.path;
        one_path || (self.content.is_some() && self.content == other.content)
    }
}

/// A thickness with the base's relative spread.
fn thickness(base: &Table, um: f64) -> Value {
    let written = base.get("layer").and_then(|layer| layer.get("thickness_um"));
    let number = |key: &str| {
        let value = written?.get(key)?;
        value.as_float().or(value.as_integer().map(|i| i as f64))
    };
    match (number("mean"), number("std")) {
        (Some(mean), Some(std)) if mean > 0.0 => {
            Table::from_iter([("mean".into(), um.into()), ("std".into(), (std * um / mean).into())]).into()
        }
        _ => um.into(),
    }
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
