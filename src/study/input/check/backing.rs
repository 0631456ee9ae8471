//! Paper that was measured, and paper with a brightener.

mod bispectral;
mod pair;

use super::paper::{BackingReader, PaperSpectrum, range, read, source_of, spectral, used_rows};
use crate::appearance::bare_paper::{BareSurface, PaperGeometry};
use crate::appearance::fluorescence::{Fluorescence, SHORTEST_NM, STEP_NM, summed_nm};
use crate::appearance::paper::Albedo;
use crate::input::file::MeasuredPaperTable;
use crate::input::forms::FluorescenceWritten;
use crate::input::limits;
use crate::input::measured::{MeasuredCondition, MeasuredGeometry, MeasuredRequest};
use crate::input::study::{MeasuredPaper, Paper};
use bispectral::donaldson;
use std::path::Path;

/// Rounding of quanta.
const ROUNDING: f64 = 1e-9;

/// Where a pair of measurements stands.
const PAIR: &str = "paper.fluorescence";

/// A spectrum read for the paper, with its geometry.
struct MeasuredFactor {
    rows: Vec<[f64; 2]>,
    geometry: PaperGeometry,
    /// The instrument's light, if the file states it.
    condition: Option<MeasuredCondition>,
}

impl BackingReader<'_> {
    /// Paper whose factor was measured; where it is brightened the albedo goes on at shorter waves.
    pub fn measured(&mut self, table: &MeasuredPaperTable, is_brightened: bool) -> Paper {
        let request = MeasuredRequest {
            patch: table.patch.clone(),
            one_must_be_named: true,
            unit: table.unit,
            condition: table.condition,
            geometries: Vec::new(),
            ..MeasuredRequest::default()
        };
        let path = self.tables.folder.join(&table.csv);
        let source = source_of(&path, &table.csv, table.patch.as_ref());
        let mut paper = Paper {
            source,
            albedo: Albedo::Constant(1.0),
            coupling: self.coupling,
            measured: None,
            fluorescence: None,
            dots: None,
        };
        let Some(factor) = self.factor("paper.measured", &path, &request, table.geometry) else {
            return paper;
        };
        if is_brightened && !self.is_without_emission(&factor, table) {
            return paper;
        }
        let Some(measured) = self.behind_surface("paper.measured.csv", &factor, table.condition) else {
            return paper;
        };
        let rows = measured.rows.iter().map(|[nm, _, albedo]| [*nm, *albedo]).collect();
        let rows = if is_brightened { self.extended(rows) } else { rows };
        paper.albedo = spectral("paper.measured.csv", rows, self.tables.wavelengths_nm, self.faults);
        paper.measured = Some(measured);
        paper
    }

    /// Whether a factor of brightened paper was measured without what the brightener emits.
    fn is_without_emission(&mut self, factor: &MeasuredFactor, table: &MeasuredPaperTable) -> bool {
        match table.condition.or(factor.condition) {
            Some(condition @ (MeasuredCondition::M0 | MeasuredCondition::M1)) => {
                let found = format!("{} beside paper.fluorescence", condition.name());
                let allowed = "M2, without ultraviolet light: M0 and M1 hold what the brightener emits, which would count twice";
                let remedy = "give both measurements, fluorescence = { m1_csv = \"…\", m2_csv = \"…\" }, or the M2 one here";
                self.faults.add("paper.measured.condition", found, allowed, remedy);
                false
            }
            Some(_) => true,
            None => {
                self.remarks.push(
                    "paper.measured: taken as measured without ultraviolet light (M2), and so without what the brightener emits"
                        .into(),
                );
                true
            }
        }
    }

    /// A file's factor with its geometry: that of the file, or the one given beside it.
    fn factor(
        &mut self,
        field: &str,
        path: &Path,
        request: &MeasuredRequest,
        written: Option<PaperGeometry>,
    ) -> Option<MeasuredFactor> {
        let PaperSpectrum { rows, geometry: stated, condition } =
            read(field, path, request, self.faults, self.remarks)?;
        let key = format!("{field}.geometry");
        let is_pair = field == PAIR;
        let remedy = if is_pair {
            "measure it at 45:0, as M0, M1 and M2 are; or give excitation, emission and yield"
        } else {
            "write geometry = \"45:0\", \"d:8\", \"d:8 excluded\", \"d:0\" or \"natural\" beside the file"
        };
        let known = match &stated {
            None => None,
            Some(MeasuredGeometry::LitAt45) => Some(PaperGeometry::LitAt45),
            Some(MeasuredGeometry::Sphere(Some(true))) => Some(PaperGeometry::Sphere),
            Some(MeasuredGeometry::Sphere(Some(false))) => Some(PaperGeometry::SphereExcluded),
            Some(MeasuredGeometry::DiffuseNormal) => Some(PaperGeometry::DiffuseNormal),
            Some(MeasuredGeometry::UniformSky) => Some(PaperGeometry::NaturalLight),
            Some(MeasuredGeometry::Sphere(None))
                if written.is_some_and(|written| {
                    !matches!(written, PaperGeometry::Sphere | PaperGeometry::SphereExcluded)
                }) =>
            {
                let found = format!(
                    "{:?}, where the file states {:?}",
                    written.unwrap_or_default().name(),
                    MeasuredGeometry::Sphere(None).name()
                );
                let allowed = "\"d:8\" (the mirrored light included) or \"d:8 excluded\"";
                self.faults.add(&key, found, allowed, "write which of both it is");
                return None;
            }
            Some(other) if written.is_none() => {
                self.faults.add(
                    if is_pair { field } else { key.as_str() },
                    other.name(),
                    "a geometry that the surface can be taken off for",
                    remedy,
                );
                return None;
            }
            Some(_) => None,
        };
        if let (Some(known), Some(written)) = (known, written)
            && known != written
        {
            let found = format!("{:?}, where the file states {:?}", written.name(), known.name());
            self.faults.add(&key, found, "what the file states", "leave it out");
            return None;
        }
        if known.is_none() && written.is_none() {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            self.remarks.push(match is_pair {
                true => format!("{field}: {name} states no geometry: taken as 45:0, that of M0 to M2"),
                false => {
                    format!("{field}: {name} states no geometry: taken as 45:0; {key} = \"d:8\" says another")
                }
            });
        }
        let [from_nm, to_nm] = range(self.tables.wavelengths_nm);
        let rows = used_rows(rows, [from_nm.min(to_nm), to_nm]);
        Some(MeasuredFactor { rows, geometry: written.or(known).unwrap_or_default(), condition })
    }

    /// The albedo behind the surface that a factor was measured through.
    fn behind_surface(
        &mut self,
        field: &str,
        factor: &MeasuredFactor,
        condition: Option<MeasuredCondition>,
    ) -> Option<MeasuredPaper> {
        let surface = BareSurface::new(self.coupling);
        let geometry = factor.geometry;
        let rows: Vec<[f64; 3]> =
            factor.rows.iter().map(|&[nm, value]| [nm, value, surface.albedo(value, geometry)]).collect();
        if let Some([nm, value, albedo]) = rows.iter().find(|row| !limits::ALBEDO.holds(row[2])) {
            let remedy = if *albedo > 1.0 {
                "paper that returns more than comes in is brightened: fluorescence = { m1_csv = \"…\", m2_csv = \"…\" }; or \
                 state unit, geometry or coupling"
            } else {
                "state unit or geometry: the surface alone mirrors more"
            };
            let found = format!("{value:.4} at {nm} nm, an albedo of {albedo:.4} behind the surface");
            self.faults.add(field, found, "factors whose albedo is from 0 to 1", remedy);
            return None;
        }
        let middle = rows[rows.len() / 2];
        self.remarks.push(format!(
            "{}: measured at {}; behind the paper's surface the albedo is {:.3} at {} nm, where {:.3} was measured",
            field.trim_end_matches(".csv"),
            geometry.name(),
            middle[2],
            middle[0],
            middle[1]
        ));
        Some(MeasuredPaper { geometry, condition, rows })
    }

    /// Rows that go on with their first value down to the first wavelength of the light.
    fn extended(&self, rows: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
        let from_nm = range(self.tables.wavelengths_nm)[0];
        let first = rows[0];
        let lead = (from_nm < first[0]).then_some([from_nm, first[1]]);
        lead.into_iter().chain(rows).collect()
    }

    /// Paper with a brightener of known bands or with a bispectral table.
    pub fn brightened(&mut self, mut paper: Paper, written: &FluorescenceWritten) -> Paper {
        let before = self.faults.0.len();
        let fluorescence = match written {
            FluorescenceWritten::Bands { excitation, emission, quantum_yield } => {
                self.rows("paper.fluorescence.excitation", excitation, 1.0);
                self.rows("paper.fluorescence.emission", emission, f64::MAX);
                let remedy = "0.5 to 0.9 are usual";
                self.faults.number("paper.fluorescence.yield", *quantum_yield, limits::SHARE, remedy);
                Fluorescence::Bands {
                    excitation: excitation.clone(),
                    emission: emission.clone(),
                    quantum_yield: *quantum_yield,
                }
            }
            FluorescenceWritten::Donaldson { donaldson_csv } => {
                match donaldson(&self.tables.folder.join(donaldson_csv)) {
                    Ok(table) => table,
                    Err(error) => {
                        let allowed = "a table of factors, emitted wavelengths down the first column, those of the light in the header";
                        let remedy = "correct the file; its path is relative to the study file";
                        self.faults.add("paper.fluorescence.donaldson_csv", error, allowed, remedy);
                        return paper;
                    }
                }
            }
            FluorescenceWritten::Pair { .. } => return paper,
        };
        if self.faults.0.len() > before || self.lacks_wavelengths("paper.fluorescence") {
            return paper;
        }
        self.light_excites(&fluorescence);
        self.emits(&fluorescence);
        if let Fluorescence::Bands { excitation, .. } = &fluorescence
            && excitation.iter().any(|row| row[1] > 0.0)
        {
            paper.albedo = self.left_by(&paper, &fluorescence);
        }
        self.quanta(&paper.albedo, &fluorescence);
        paper.fluorescence = Some(fluorescence);
        paper
    }

    /// What a paper reflects of the light that a brightener leaves it. A measurement lacks what the
    /// brightener takes already.
    fn left_by(&self, paper: &Paper, brightener: &Fluorescence) -> Albedo {
        let albedo = &paper.albedo;
        let measured = paper.measured.as_ref().map_or(&[][..], |measured| &measured.rows);
        let is_measured =
            |nm: f64| measured.first().zip(measured.last()).is_some_and(|(a, b)| (a[0]..=b[0]).contains(&nm));
        let [from_nm, to_nm] = range(self.tables.wavelengths_nm);
        let mut nm = summed_nm(from_nm, to_nm);
        nm.extend(self.tables.wavelengths_nm);
        if let Albedo::Spectral(rows) = albedo {
            nm.extend(rows.iter().map(|row| row[0]).filter(|nm| (from_nm..=to_nm).contains(nm)));
        }
        nm.sort_by(f64::total_cmp);
        nm.dedup();
        let taken = |nm: f64| if is_measured(nm) { 0.0 } else { brightener.absorbed(nm) };
        let row = |nm: f64| Some([nm, albedo.at(nm).ok()? * (1.0 - taken(nm))]);
        Albedo::Spectral(nm.into_iter().filter_map(row).collect())
    }

    /// Whether the wavelengths are too few for what excites and what is emitted; none at all have
    /// been told by another error.
    pub(super) fn lacks_wavelengths(&mut self, field: &str) -> bool {
        let wavelengths_nm = self.tables.wavelengths_nm;
        if let [nm] = wavelengths_nm {
            let allowed = "two or more wavelengths, from those that excite to those that are emitted";
            let remedy = "light.from_nm = 300 and light.to_nm = 700, or leave the brightener out";
            self.faults.add(field, format!("light of {nm} nm alone"), allowed, remedy);
        }
        wavelengths_nm.len() < 2
    }

    /// Rows that rise in wavelength and hold values from 0.
    fn rows(&mut self, field: &str, rows: &[[f64; 2]], most: f64) {
        let allowed = "two or more rows [nm, value], rising, values from 0 (shares up to 1)";
        let wrong = |row: &&[f64; 2]| !(row[0].is_finite() && (0.0..=most).contains(&row[1]));
        if let Some([nm, value]) = rows.iter().find(wrong) {
            self.faults.add(
                field,
                format!("{value} at {nm} nm"),
                allowed,
                "excitation is a share of the quanta",
            );
        } else if rows.len() < 2 || rows.windows(2).any(|pair| pair[1][0] <= pair[0][0]) {
            let found = format!("{} rows that do not rise", rows.len());
            self.faults.add(field, found, allowed, "sort them by wavelength");
        }
    }

    /// Bands that absorb with a yield must emit within the light of the study.
    fn emits(&mut self, fluorescence: &Fluorescence) {
        let Fluorescence::Bands { excitation, quantum_yield, .. } = fluorescence else { return };
        let absorbs = excitation.iter().any(|row| row[1] > 0.0);
        let [from_nm, to_nm] = range(self.tables.wavelengths_nm);
        let matrix = fluorescence.matrix(&summed_nm(from_nm, to_nm));
        let is_dark = matrix.iter().flatten().all(|factor| *factor == 0.0);
        if absorbs && *quantum_yield > 0.0 && is_dark {
            let found =
                format!("a yield of {quantum_yield}, and nothing emitted from {from_nm} to {to_nm} nm");
            let allowed = "emission at longer waves than the excitation, both within [light]";
            let remedy = "correct the rows of excitation and emission, or light.from_nm and light.to_nm; yield = 0 only absorbs";
            self.faults.add("paper.fluorescence.emission", found, allowed, remedy);
        }
    }

    /// The light of the study must hold what excites.
    fn light_excites(&mut self, fluorescence: &Fluorescence) {
        let Some([first, _]) = fluorescence.excited_nm() else { return };
        let [from_nm, _] = range(self.tables.wavelengths_nm);
        let lowest = first.max(SHORTEST_NM);
        if from_nm > lowest + STEP_NM {
            let found = format!("excitation from {first} nm, light from {from_nm} nm");
            let allowed = "light that holds what excites, from 300 nm";
            let remedy =
                format!("light.from_nm = {lowest}: the layer absorbs there as well, and is solved there");
            self.faults.add("paper.fluorescence", found, allowed, remedy);
        }
    }

    /// A paper gives no more quanta than it takes.
    fn quanta(&mut self, albedo: &Albedo, fluorescence: &Fluorescence) {
        let [from_nm, to_nm] = range(self.tables.wavelengths_nm);
        let most = fluorescence
            .most_quanta(|nm| albedo.at(nm).unwrap_or(0.0), &summed_nm(from_nm, to_nm.max(780.0)));
        if most > 1.0 + ROUNDING {
            let found = format!("{most:.3} quanta reflected and emitted for each that comes in");
            let remedy = "lower yield or excitation, or the albedo at the wavelengths that excite";
            self.faults.add("paper.fluorescence", found, "at most 1", remedy);
        }
    }
}
