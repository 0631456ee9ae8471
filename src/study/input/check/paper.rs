//! The paper: its albedo as a number, a list or a table, and its contact with the layer. Directions
//! of the light: 0°, 45° and strata over the hemisphere, as paper and picture need them, or a list.

use super::Tabulation;
use super::light::check_list;
use crate::appearance::paper::{Albedo, Coupling, PRINT_DEG};
use crate::input::file::{AnglesTable, CouplingName, LayerTable, PaperTable, PigmentTable};
use crate::input::forms::{AlbedoWritten, FluorescenceWritten};
use crate::input::measured::{
    MeasuredCondition, MeasuredContent, MeasuredGeometry, MeasuredReading, MeasuredRequest, MeasuredSpectrum,
    Patch,
};
use crate::input::study::{Angles, Paper, StudyKind};
use crate::input::{Faults, limits};
use crate::material::columns::{in_other_unit, micrometres};
use std::path::Path;

pub(super) const REMEDY: &str = "0 is black, 1 is a perfect white, 0.9 is good paper";

impl PaperTable {
    /// Reads the paper, of which scatterers in optical contact are embedded in a medium of index
    /// `index_out`; remarks say what was taken where a file leaves something open.
    pub(super) fn checked(
        &self,
        index_out: f64,
        tables: &Tabulation,
        faults: &mut Faults,
        remarks: &mut Vec<String>,
    ) -> Paper {
        let coupling = match self.coupling {
            CouplingName::Gap => Coupling::Gap,
            CouplingName::OpticalContact => Coupling::OpticalContact { index: index_out },
        };
        let mut reader = BackingReader { coupling, tables, faults, remarks };
        if let Some(both) = self.more_than_one() {
            let allowed =
                "one source of the albedo: paper.albedo, paper.measured, or a pair m1_csv and m2_csv";
            reader.faults.add(both, "a second source of the albedo", allowed, "remove one of them");
        }
        if let Some(pair @ FluorescenceWritten::Pair { .. }) = &self.fluorescence {
            return reader.of_pair(pair);
        }
        let paper = match &self.measured {
            Some(measured) => reader.measured(measured, self.fluorescence.is_some()),
            None => self.with_albedo(&mut reader),
        };
        match &self.fluorescence {
            Some(written) => reader.brightened(paper, written),
            None => paper,
        }
    }

    /// A key that says the albedo once more.
    fn more_than_one(&self) -> Option<&'static str> {
        let pair = matches!(self.fluorescence, Some(FluorescenceWritten::Pair { .. }));
        match (&self.albedo, &self.measured) {
            (Some(_), Some(_)) => Some("paper.measured"),
            (Some(_), None) | (None, Some(_)) if pair => Some("paper.fluorescence"),
            _ => None,
        }
    }

    fn with_albedo(&self, reader: &mut BackingReader) -> Paper {
        let BackingReader { coupling, tables, faults, remarks } = reader;
        let usual = AlbedoWritten::Constant(USUAL_ALBEDO);
        let paper = |source: String, albedo: Albedo| Paper {
            source,
            albedo,
            coupling: *coupling,
            measured: None,
            fluorescence: None,
            dots: None,
        };
        match self.albedo.as_ref().unwrap_or(&usual) {
            AlbedoWritten::Constant(value) => {
                faults.number("paper.albedo", *value, limits::ALBEDO, REMEDY);
                paper(value.to_string(), Albedo::Constant(*value))
            }
            AlbedoWritten::Rows(rows) => {
                let source = format!("listed at {} wavelengths", rows.len());
                let albedo = spectral("paper.albedo", rows.clone(), tables.wavelengths_nm, faults);
                paper(source, albedo)
            }
            AlbedoWritten::Csv { csv, patch, unit, condition } => {
                let request = MeasuredRequest {
                    patch: patch.clone(),
                    one_must_be_named: true,
                    unit: *unit,
                    condition: *condition,
                    geometries: Vec::new(),
                    used_nm: range(tables.wavelengths_nm),
                    ..MeasuredRequest::default()
                };
                let path = tables.folder.join(csv);
                let albedo = match read("paper.albedo", &path, &request, faults, remarks) {
                    Some(read) => {
                        remarks.extend(holds_mirrored(&path, read.geometry.as_ref()));
                        remarks.extend(measured_outside(&path, read.geometry.as_ref(), *coupling));
                        let used = used_rows(read.rows, request.used_nm);
                        spectral("paper.albedo.csv", used, tables.wavelengths_nm, faults)
                    }
                    // a fault of the file is one already
                    None => Albedo::Constant(1.0),
                };
                paper(source_of(&path, csv, patch.as_ref()), albedo)
            }
        }
    }
}

/// Albedo of paper where none is given.
const USUAL_ALBEDO: f64 = 0.9;

/// What reading a backing needs, and what it finds.
pub(super) struct BackingReader<'a> {
    pub coupling: Coupling,
    pub tables: &'a Tabulation<'a>,
    pub faults: &'a mut Faults,
    pub remarks: &'a mut Vec<String>,
}

/// The file name only, for the same table is the same paper in any folder, and the sample.
pub(super) fn source_of(path: &Path, csv: &str, patch: Option<&Patch>) -> String {
    let name = path.file_name().map_or(csv.into(), |name| name.to_string_lossy());
    match patch {
        Some(patch) => format!("{name}: {patch}"),
        None => name.into_owned(),
    }
}

/// Remark on an inner albedo whose file says that it was measured from outside.
fn measured_outside(path: &Path, geometry: Option<&MeasuredGeometry>, coupling: Coupling) -> Option<String> {
    let Coupling::OpticalContact { .. } = coupling else { return None };
    let stated = geometry.filter(|stated| **stated != MeasuredGeometry::Sphere(Some(true)))?;
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    Some(format!(
        "paper.albedo: {name} states {}, so these are factors of bare paper and lower than its albedo behind the surface: \
         measured = {{ csv = … }} finds that from them",
        stated.name()
    ))
}

/// Remark on an albedo that was measured with mirrored light.
fn holds_mirrored(path: &Path, geometry: Option<&MeasuredGeometry>) -> Option<String> {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    (geometry == Some(&MeasuredGeometry::Sphere(Some(true)))).then(|| {
        format!(
            "paper.albedo: {name} holds the light that the surface mirrors (specular light included), some 4 %, which an \
             albedo does not"
        )
    })
}

/// The rows that a study needs: what it does not ask for is not judged.
pub(super) fn used_rows(rows: Vec<[f64; 2]>, [from_nm, to_nm]: [f64; 2]) -> Vec<[f64; 2]> {
    let first = rows.iter().rposition(|row| row[0] <= from_nm).unwrap_or(0);
    let last = rows.iter().position(|row| row[0] >= to_nm).unwrap_or(rows.len() - 1);
    let used = &rows[first.min(last)..=last.max(first)];
    if used.len() < 2 { rows } else { used.to_vec() }
}

/// A table that covers every wavelength of the study.
pub(super) fn spectral(
    field: &str,
    rows: Vec<[f64; 2]>,
    wavelengths_nm: &[f64],
    faults: &mut Faults,
) -> Albedo {
    let albedo = Albedo::Spectral(rows.clone());
    if rows.is_empty() {
        let allowed = "two or more rows [wavelength in nm, albedo]";
        faults.empty(field, allowed, "write for example albedo = [[400, 0.8], [700, 0.9]], or albedo = 0.9");
    } else if let Some(i) = rows.iter().position(|row| !limits::ALBEDO.holds(row[1])) {
        let found = format!("{} at {} nm", rows[i][1], rows[i][0]);
        faults.add(format!("{field}[{i}]"), found, format!("albedos {}", limits::ALBEDO), REMEDY);
    } else if let Some(largest) = micrometres(rows.iter().map(|row| row[0])) {
        let found = format!("wavelengths up to {largest}, which look like µm");
        faults.add(field, found, "wavelengths in nm", "multiply the wavelengths by 1000");
    } else if let Some(error) = wavelengths_nm.iter().find_map(|&nm| albedo.at(nm).err()) {
        let allowed = "two or more rows [wavelength in nm, albedo], rising, that cover [light]";
        let rises = rows.len() > 1 && rows.is_sorted_by(|one, next| one[0] < next[0]);
        let other_unit = in_other_unit(
            [rows.first(), rows.last()].map(|row| row.map_or(0.0, |row| row[0])),
            range(wavelengths_nm),
        );
        let usual = match rises {
            false => {
                "sort the rows by wavelength, each once; one albedo for all wavelengths is a number, albedo = 0.9"
            }
            true => {
                "extend the table: colours need 400 to 700 nm; or, for spectra alone, keep [light] inside it"
            }
        };
        let remedy = other_unit.filter(|_| rises).unwrap_or_else(|| usual.to_owned());
        faults.add(field, error, allowed, remedy);
    }
    albedo
}

/// First and last wavelength.
pub(super) fn range(wavelengths_nm: &[f64]) -> [f64; 2] {
    let first = wavelengths_nm.first().copied().unwrap_or(f64::NEG_INFINITY);
    [first, wavelengths_nm.last().copied().unwrap_or(f64::INFINITY)]
}

/// A spectrum that a key of the paper names, and what its file states.
pub(super) struct PaperSpectrum {
    /// \[wavelength in nm, value\]
    pub rows: Vec<[f64; 2]>,
    pub geometry: Option<MeasuredGeometry>,
    pub condition: Option<MeasuredCondition>,
}

/// Reads the spectrum that a key of the paper names from a file of measurements.
pub(super) fn read(
    field: &str,
    path: &Path,
    request: &MeasuredRequest,
    faults: &mut Faults,
    remarks: &mut Vec<String>,
) -> Option<PaperSpectrum> {
    let with_keys_of_paper = |text: &str| text.replace("compare.", &format!("{field}."));
    let spectrum = MeasuredReading::new(path, request).and_then(|reading| match reading.measured {
        MeasuredContent::Spectrum(MeasuredSpectrum { rows, .. }) => {
            let MeasuredReading { geometry, condition, remarks, .. } = reading;
            Ok((PaperSpectrum { rows, geometry, condition }, remarks))
        }
        MeasuredContent::Colour(_) => Err(format!("{}: a colour, and no spectrum", path.display())),
    });
    let (spectrum, remarks_of_file) = match spectrum {
        Ok(read) => read,
        Err(error) => {
            let allowed = "a readable table with the columns wavelength_nm and albedo, or a spectrum as CGATS.17 or CxF3";
            let remedy = "correct the file, or name a sample beside it: { csv = \"…\", patch = \"…\" }; its path is relative \
                          to the study file";
            faults.add(format!("{field}.csv"), with_keys_of_paper(&error), allowed, remedy);
            return None;
        }
    };
    let in_words = |remark: &String| format!("{field}: {}", with_keys_of_paper(remark));
    remarks.extend(remarks_of_file.iter().map(in_words));
    Some(spectrum)
}

/// Default number of directions: 0°, 45° and three strata.
const USUAL_COUNT: usize = 5;
/// Number of directions that are not strata.
const EXACT: usize = 2;

/// What around the layer decides on paper and picture.
#[derive(Clone, Copy)]
pub(super) struct Surroundings {
    pub index_in: f64,
    pub index_out: f64,
    /// Contact between layer and paper.
    pub coupling: Coupling,
    /// Whether the layer is statistically the same from both sides but for the media about it: not
    /// with a relief on one face, a profile over the depth, or grains in given places.
    pub is_reversible: bool,
    pub is_composed: bool,
}

impl Surroundings {
    /// Those of a layer.
    pub(super) fn of(layer: &LayerTable, pigments: &[PigmentTable], coupling: Coupling) -> Self {
        let has_profile = pigments.iter().any(|pigment| pigment.profile.is_some());
        Self {
            index_in: layer.index_in,
            index_out: layer.index_out,
            coupling,
            is_reversible: layer.relief.is_none() && layer.microstructure.is_none() && !has_profile,
            is_composed: layer.composed.is_some(),
        }
    }

    /// Reports what the picture does not show: it shows an ink in air, on paper behind an air gap
    /// or in contact with it.
    fn check(&self, faults: &mut Faults) {
        let otherwise = if self.is_composed {
            "give it an allowed value: a composed layer lies on its paper"
        } else {
            "list angles.polar_deg for a study without paper and picture"
        };
        if self.index_in != 1.0 {
            faults.add("layer.index_in", self.index_in, "1, air above the ink", otherwise);
        }
        let below = self.index_out;
        let (is_wrong, allowed) = match self.coupling {
            Coupling::Gap => (below != 1.0, "1, the thin gap to the paper"),
            Coupling::OpticalContact { .. } => {
                (below.is_nan() || below <= 1.0, "greater than 1, the medium of the paper's scatterers")
            }
        };
        if is_wrong {
            let remedy = format!("choose paper.coupling to suit, or {otherwise}");
            faults.add("layer.index_out", below, allowed, remedy);
        }
    }
}

/// The directions of the light, and what they allow to be computed.
pub(super) struct Directions {
    pub angles: Angles,
    /// The ink on its paper, or the layer alone.
    pub kind: StudyKind,
}

impl AnglesTable {
    /// The directions of the light.
    pub(super) fn checked(&self, surroundings: &Surroundings, faults: &mut Faults) -> Directions {
        faults.number("angles.azimuth_deg", self.azimuth_deg, limits::AZIMUTH_DEG, "0 is the x direction");
        let largest_deg = self.picture_max_deg;
        faults.number("angles.picture_max_deg", largest_deg, limits::PICTURE_MAX_DEG, "60 is usual");
        match (&self.polar_deg, self.count) {
            (Some(list), None) => {
                let remedy = "give angles from the normal; 89 is nearly grazing";
                check_list("angles.polar_deg", list, limits::POLAR_DEG, remedy, faults);
                self.listed(list.clone(), surroundings)
            }
            (None, count) => {
                let count = count.unwrap_or(USUAL_COUNT);
                surroundings.check(faults);
                let remedy = "5 is usual; 0° and 45° are always among them";
                faults.whole("angles.count", count, limits::DIRECTIONS, remedy);
                self.over_hemisphere(vec![0.0, PRINT_DEG], count.saturating_sub(EXACT), surroundings)
            }
            (Some(_), Some(_)) => {
                let allowed = "either angles.count or angles.polar_deg";
                faults.add("angles", "both count and polar_deg", allowed, "remove one of them");
                self.alone(Vec::new(), String::new())
            }
        }
    }

    /// Listed angles allow paper and colour if they include 0° and 45° and the surroundings permit
    /// it.
    fn listed(&self, exact_deg: Vec<f64>, surroundings: &Surroundings) -> Directions {
        let is_absent = |deg: &f64| !exact_deg.iter().any(|listed| (listed - deg).abs() < 1e-9);
        let absent = [0.0, PRINT_DEG].into_iter().filter(is_absent);
        let absent: Vec<String> = absent.map(|deg: f64| deg.to_string()).collect();
        if !absent.is_empty() {
            let reason = format!(
                "angles.polar_deg does not list {}: paper and colour need 0 and 45, or angles.count instead of a list",
                absent.join(" and ")
            );
            return self.alone(exact_deg, reason);
        }
        let mut unsuited = Faults::default();
        surroundings.check(&mut unsuited);
        match unsuited.0.first() {
            Some(fault) => self.alone(exact_deg, format!("no paper and colour: {fault}")),
            None => self.over_hemisphere(exact_deg, USUAL_COUNT - EXACT, surroundings),
        }
    }

    fn alone(&self, exact_deg: Vec<f64>, reason: String) -> Directions {
        let AnglesTable { azimuth_deg, picture_max_deg, .. } = *self;
        let angles = Angles { exact_deg, strata: 0, exit_strata: 0, azimuth_deg, picture_max_deg };
        Directions { angles, kind: StudyKind::LayerAlone(reason) }
    }

    fn over_hemisphere(&self, exact_deg: Vec<f64>, strata: usize, around: &Surroundings) -> Directions {
        // One even layer between plane walls in vacuum is statistically the same from both sides:
        // solves from the incident side give Ā_b.
        let is_symmetric = around.coupling == Coupling::Gap && around.is_reversible;
        let exit_strata = if is_symmetric { 0 } else { strata };
        let AnglesTable { azimuth_deg, picture_max_deg, .. } = *self;
        let angles = Angles { exact_deg, strata, exit_strata, azimuth_deg, picture_max_deg };
        Directions { angles, kind: StudyKind::InkOnPaper }
    }
}
