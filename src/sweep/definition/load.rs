//! Reads a sweep file and checks its variants.

use super::axes::{Axis, plain};
use super::claims;
use super::claims::Claim;
use super::expand::{Draft, expand};
use super::file::{SheetTable, SweepFile, Where};
use crate::input::check::check;
use crate::input::fault::{Fault, Faults, StudyError};
use crate::input::file::RESULTS;
use crate::input::load::{read_file, read_table, stem};
use crate::input::locate::steps;
use crate::numerics::files;
use crate::work::variant::Variant;
use serde::{Deserialize, Serialize};
use std::path::Path;
use toml::{Table, Value};

/// Number of errors in variants that are shown; most others repeat them.
const SHOWN_FAULTS: usize = 5;

/// A sweep with checked variants.
#[derive(Clone, Debug)]
pub struct Sweep {
    /// Axes, sheet and conclusions.
    pub outline: Outline,
    /// All variants, in order.
    pub variants: Vec<Variant>,
    /// Each variant's study as a file, written to `variants/<name>`.
    pub texts: Vec<String>,
    /// Tables read by the variants, stored with the results.
    pub inputs: Vec<Input>,
}

/// Everything about a sweep except its studies; content of `sweep.json`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Outline {
    /// Title of the report.
    pub title: String,
    /// The axes, in order.
    pub axes: Vec<AxisOutline>,
    /// Layout of the contact sheets.
    pub sheet: SheetTable,
    /// The reference variant of colour differences.
    pub reference: usize,
    /// Whether the file names the reference variant.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub reference_asked: bool,
    /// Conclusions to be tested.
    pub claims: Vec<Claim>,
    /// Position of each variant on the axes.
    pub variants: Vec<Place>,
}

/// An axis and the captions of its values.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AxisOutline {
    /// Name of the axis.
    pub name: String,
    /// Labels of its settings.
    pub labels: Vec<String>,
    /// Unit of the labels; empty if they have none.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub unit: String,
}

impl AxisOutline {
    /// Caption of a value on its own: `paper 0.9`, but `yellow` rather than `ink yellow`.
    pub fn named(&self, k: usize) -> String {
        let label = self.caption(k);
        let speaks = label.chars().next().is_some_and(char::is_alphabetic);
        if speaks { label } else { format!("{} {label}", self.plain_name()) }
    }

    /// A label with its unit, if it has one.
    pub fn caption(&self, k: usize) -> String {
        let label = &self.labels[k];
        let bare = self.unit.is_empty() || label.parse::<f64>().is_err();
        if bare { label.clone() } else { format!("{label}\u{a0}{}", self.unit) }
    }

    /// The name without its unit suffix.
    pub fn plain_name(&self) -> &str {
        if self.unit.is_empty() { &self.name } else { plain(&self.name) }
    }

    /// The number of a label, alone or followed by its unit: `0.9`, `15 %`, `200 nm`.
    pub fn number(&self, k: usize) -> Option<f64> {
        let mut words = self.labels.get(k)?.split_whitespace();
        let number = words.next()?.parse().ok().filter(|x: &f64| x.is_finite())?;
        (words.count() < 2).then_some(number)
    }

    /// The name with its unit, for axes and column headings: `diameter, nm`.
    pub fn heading(&self) -> String {
        if self.unit.is_empty() { self.name.clone() } else { format!("{}, {}", self.plain_name(), self.unit) }
    }
}

/// Name and position of a variant.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Place {
    /// Name of the variant.
    pub name: String,
    /// Index of its setting on each axis.
    pub place: Vec<usize>,
}

/// A table read by some variant.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Input {
    /// Path relative to the sweep's folder.
    pub path: String,
    /// Content of the file.
    pub bytes: Vec<u8>,
}

impl Input {
    /// A table called `name`, in a folder named after the checksum of its content.
    fn new(name: &str, bytes: Vec<u8>) -> Self {
        Self { path: format!("inputs/{}/{name}", Self::checksum(&bytes)), bytes }
    }

    /// Whether the content matches the checksum in the folder's name.
    pub fn is_whole(&self) -> bool {
        Path::new(&self.path).starts_with(Path::new("inputs").join(Self::checksum(&self.bytes)))
    }

    fn checksum(bytes: &[u8]) -> String {
        blake3::hash(bytes).to_hex()[..8].to_owned()
    }
}

/// Reads the sweep file at `path` and checks it and all its variants.
///
/// # Errors
/// The file or its base cannot be read, is not TOML, or some variant is not allowed.
pub fn load(path: &Path) -> Result<Sweep, StudyError> {
    let (text, mut file): (String, SweepFile) = read_file(path)?;
    file.title.get_or_insert_with(|| stem(path));
    let (base, base_folder) = file.base.read(path.parent().unwrap_or(Path::new("")))?;
    let mut faults = Faults::default();
    faults.title(file.title.as_deref());
    let axes: Vec<Axis> =
        file.axis.iter().enumerate().map(|(i, table)| Axis::read(i, table, &mut faults)).collect();
    let drafts = expand(&file, &base, &axes, &mut faults);
    let mut reading = Reading { axes: &axes, folder: &base_folder, texts: Vec::new(), inputs: Vec::new() };
    let mut variants = Vec::new();
    for draft in &drafts {
        variants.extend(reading.variant(draft, &mut faults)?);
    }
    if axes.iter().any(varies_dots) {
        variants.iter_mut().for_each(|variant| variant.study.remarks.push(OF_DOTS.to_owned()));
    }
    let outline = outline(&file, &axes, &drafts, &mut faults);
    if faults.0.is_empty() {
        let studies: Vec<_> = variants.iter().map(|variant| &variant.study).collect();
        claims::check_variants(&outline.claims, &studies, &mut faults);
    }
    if faults.0.is_empty() {
        return Ok(Sweep { outline, variants, texts: reading.texts, inputs: reading.inputs });
    }
    let more = faults.0.len().saturating_sub(SHOWN_FAULTS);
    faults.0.truncate(SHOWN_FAULTS);
    if let (Some(last), true) = (faults.0.last_mut(), more > 0) {
        last.remedy.push_str(&format!(" ({more} more of this kind)"));
    }
    Err(StudyError::Values { path: path.to_owned(), text, faults: faults.0 })
}

/// The remark of a sweep over the dots of a print.
const OF_DOTS: &str = "an axis varies the dots of a print: the colours, charts and sheets of a sweep are those of the solid, and the tints are \
     in the results of every variant (`prints`); a list of coverages in one run has a whole ramp";

/// Whether an axis varies the dots of a print.
fn varies_dots(axis: &Axis) -> bool {
    let mut fields = axis.settings.iter().flat_map(|setting| setting.set.keys());
    fields.any(|field| ["dots", "area", "ink"].contains(&steps(field).next().unwrap_or_default()))
}

fn outline(file: &SweepFile, axes: &[Axis], drafts: &[Draft], faults: &mut Faults) -> Outline {
    let names = |axis: &Axis| axis.settings.iter().map(|s| s.label.clone()).collect();
    let shown = |a: &Axis| AxisOutline { name: a.name.clone(), labels: names(a), unit: a.unit.clone() };
    for (key, name) in [("rows", &file.sheet.rows), ("columns", &file.sheet.columns)] {
        if let Some(name) = name.as_ref().filter(|name| !axes.iter().any(|axis| axis.name == **name)) {
            let field = format!("sheet.{key}");
            faults.add(field, format!("{name:?}"), "the name of an axis", "name one of the axes");
        }
    }
    if let Some(rows) = file.sheet.rows.as_ref().filter(|_| file.sheet.rows == file.sheet.columns)
        && faults.0.is_empty()
    {
        let remedy = "leave one of them out, or name another axis";
        faults.add(
            "sheet.columns",
            format!("{rows:?}, which are the rows"),
            "another axis than sheet.rows",
            remedy,
        );
    }
    let sound = faults.0.is_empty();
    let claims = if sound { claims::claims(file, axes, drafts, faults) } else { Vec::new() };
    let everything = Where::new();
    let reference = file.reference.as_ref().unwrap_or(&everything);
    let first = drafts.iter().position(|d| super::expand::matches(reference, axes, &d.place));
    if first.is_none() && sound {
        let remedy = "name axes and values of a variant that is not excluded";
        faults.add("reference", "no such variant", "a variant of the sweep", remedy);
    }
    Outline {
        title: file.title.clone().unwrap_or_default(),
        axes: axes.iter().map(shown).collect(),
        sheet: file.sheet.clone(),
        reference: first.unwrap_or(0),
        reference_asked: file.reference.is_some(),
        claims,
        variants: drafts.iter().map(|d| Place { name: d.name.clone(), place: d.place.clone() }).collect(),
    }
}

/// State needed to read the variants.
struct Reading<'a> {
    axes: &'a [Axis],
    folder: &'a Path,
    texts: Vec<String>,
    inputs: Vec<Input>,
}

impl Reading<'_> {
    /// Reads a variant; `None` if it has errors.
    fn variant(&mut self, draft: &Draft, faults: &mut Faults) -> Result<Option<Variant>, StudyError> {
        let file = read_table(draft.study.clone());
        match file.and_then(|file| check(&file, self.folder, &draft.name)) {
            Ok(study) => {
                let mut written = Value::Table(draft.study.clone());
                self.keep_inputs("", &mut written)?;
                self.texts.push(toml::to_string(&written).unwrap_or_default());
                Ok(Some(Variant { name: draft.name.clone(), study }))
            }
            Err(found) => {
                found.into_iter().for_each(|fault| self.fault(draft, fault, faults));
                Ok(None)
            }
        }
    }

    /// Reports an error of a variant once: at the axis that set the field, otherwise at the base.
    fn fault(&self, draft: &Draft, fault: Fault, faults: &mut Faults) {
        let sets = |axis: &Axis, k: usize| {
            axis.settings[k].set.keys().any(|name| same_field(&draft.study, name, &fault.field))
        };
        let axis = self.axes.iter().zip(&draft.place).position(|(axis, &k)| sets(axis, k));
        let field = axis.map_or(format!("base.{}", fault.field), |a| format!("axis[{a}].values"));
        let end = format!("for {}", fault.field);
        let known =
            |f: &Fault| f.field == field && f.found.starts_with(&fault.found) && f.found.ends_with(&end);
        if !faults.0.iter().any(known) {
            let found = format!("{} in variant {} {end}", fault.found, draft.name);
            faults.push(Fault { field, found, ..fault });
        }
    }

    /// Copies the files that a study, or the value of a key in it, refers to, and refers to the
    /// copies instead.
    fn keep_inputs(&mut self, key: &str, value: &mut Value) -> Result<(), StudyError> {
        match value {
            Value::String(name) if FILES.contains(&key) => self.keep_input(name),
            Value::String(folder) if key == FOLDER_OF_RESULTS => {
                let mut name = Path::new(folder.as_str()).join(RESULTS).display().to_string();
                self.keep_input(&mut name)?;
                *folder = Path::new(&name).parent().unwrap_or(Path::new("")).display().to_string();
                Ok(())
            }
            Value::Array(items) => items.iter_mut().try_for_each(|item| self.keep_inputs(key, item)),
            Value::Table(table) => table.iter_mut().try_for_each(|(key, value)| self.keep_inputs(key, value)),
            _ => Ok(()),
        }
    }

    fn keep_input(&mut self, name: &mut String) -> Result<(), StudyError> {
        let from = self.folder.join(name.as_str());
        let bytes = files::read_bytes(&from, files::CASE)
            .map_err(|source| StudyError::Unreadable { path: from.clone(), source })?;
        let file = from.file_name().map_or_else(|| "table.csv".into(), |f| f.to_string_lossy().into_owned());
        let input = Input::new(&file, bytes);
        *name = format!("../../{}", input.path);
        if !self.inputs.contains(&input) {
            self.inputs.push(input);
        }
        Ok(())
    }
}

/// Whether two dotted names refer to the same field of `study`, as far as the shorter one goes:
/// `pigment.0.index`, `pigment.yellow.index`, `pigment[0].index.k`.
fn same_field(study: &Table, one: &str, other: &str) -> bool {
    let (one, other): (Vec<&str>, Vec<&str>) = (steps(one).collect(), steps(other).collect());
    let entry = other.get(1).and_then(|i| study.get(other[0])?.get(i.parse::<usize>().ok()?)?.get("name"));
    let mut pairs = one.iter().zip(&other).enumerate();
    pairs.all(|(k, (a, b))| a == b || *a == "*" || k == 1 && entry.and_then(Value::as_str) == Some(*a))
}

/// Keys of a study that name files: of indices and albedos, of measurements, of paper that
/// fluoresces, of microstructures.
const FILES: [&str; 8] =
    ["csv", "yaml", "measured", "m1_csv", "m2_csv", "donaldson_csv", "spheres", "voxels"];
/// Key of a study that names a folder of results, those of the layer that an area bears.
const FOLDER_OF_RESULTS: &str = "results";

#[cfg(test)]
mod tests {
    use super::load;

    /// *Planted*: copies of the pigments' own tables alone.
    #[test]
    fn every_table_of_a_study_is_kept_with_the_sweep() {
        let folder = tempfile::tempdir().expect("a folder");
        let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("written");
        write("shell.csv", "wavelength_nm,kappa,n\n400,0,1.5\n700,0,1.5\n");
        write("grains.csv", "x_um,y_um,z_um,radius_um\n0.5,0.5,0.5,0.1\n");
        let sweep = |pigment: &str, layer: &str| {
            format!(
                "[[axis]]\nfield = 'layer.binder.index'\nvalues = [1.5]\n[base.layer]\nthickness_um = 1\n{layer}\n\
                 [[base.pigment]]\nindex = 2.0\n{pigment}\n"
            )
        };
        let shell = "shell = [{ thickness_nm = 20, index = { csv = 'shell.csv' } }]";
        let grains = "period_um = 1\nmicrostructure.spheres = 'grains.csv'";
        for text in
            [sweep(&format!("diameter_nm = 250\nvolume_fraction = 0.1\n{shell}"), ""), sweep("", grains)]
        {
            write("sweep.toml", &text);
            let sweep = load(&folder.path().join("sweep.toml")).expect("a sweep");
            assert_eq!(sweep.inputs.len(), 1, "{text}");
            assert!(sweep.texts[0].contains(&format!("../../{}", sweep.inputs[0].path)), "{text}");
        }
    }

    /// *Planted*: said of no sweep, and of every one.
    #[test]
    fn a_sweep_over_dots_says_that_its_colours_are_the_solids() {
        let folder = tempfile::tempdir().expect("a folder");
        let sweep = |field: &str| {
            let text = format!(
                "[[axis]]\nfield = '{field}'\nvalues = [0.3, 0.7]\n[base.layer]\nthickness_um = 1\nbinder.index = 1.5\n[base.dots]\n\
                 ruling_per_cm = 60\nspread_um = 40\n[[base.area]]\ncoverage = 0.5\n"
            );
            std::fs::write(folder.path().join("sweep.toml"), text).expect("written");
            load(&folder.path().join("sweep.toml")).expect("a sweep")
        };
        let tells = |field: &str| {
            let remarks = sweep(field).variants.into_iter().map(|variant| variant.study.remarks.concat());
            remarks.map(|remark| remark.contains("those of the solid")).collect::<Vec<bool>>()
        };
        assert_eq!(tells("area[0].coverage"), [true; 2]);
        assert_eq!(tells("layer.thickness_um"), [false; 2]);
    }

    /// A pair of measurements of brightened paper. *Planted*: the keys of the pair left out.
    #[test]
    fn measurements_of_a_paper_are_kept_with_the_sweep() {
        let folder = tempfile::tempdir().expect("a folder");
        let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("written");
        let rows = |blue: f64| -> String {
            let row = |nm: i32| format!("{nm},{}\n", if nm == 440 { blue } else { 0.85 });
            (300..=740).step_by(10).map(row).collect()
        };
        write("m1.csv", &format!("wavelength_nm,reflectance\n{}", rows(0.95)));
        write("m2.csv", &format!("wavelength_nm,reflectance\n{}", rows(0.85)));
        write(
            "sweep.toml",
            "[[axis]]\nfield = 'layer.binder.index'\nvalues = [1.5, 1.6]\n[base.layer]\nthickness_um = 1\n\
             [base.paper]\nfluorescence = { m1_csv = 'm1.csv', m2_csv = 'm2.csv' }\n\
             [base.light]\nfrom_nm = 300\nto_nm = 700\nstep_nm = 20\n",
        );
        let sweep = load(&folder.path().join("sweep.toml")).expect("a sweep");
        let kept: Vec<&str> =
            sweep.inputs.iter().map(|input| input.path.rsplit('/').next().unwrap()).collect();
        assert_eq!(kept, ["m1.csv", "m2.csv"]);
        for (text, input) in sweep.texts.iter().flat_map(|text| sweep.inputs.iter().map(move |i| (text, i))) {
            assert!(text.contains(&format!("../../{}", input.path)), "{text}");
        }
    }
}
