//! Paper that was measured, and paper with a brightener.

use super::paper::{BackingReader, range, read, source_of, spectral, used_rows};
use crate::appearance::bare_paper::{BareSurface, PaperGeometry};
use crate::appearance::fluorescence::{
    Fluorescence, SHORTEST_NM, STEP_NM, rows_at, standard_excitation, summed_nm,
};
use crate::appearance::paper::{Albedo, Coupling};
use crate::appearance::viewing::{Summation, Viewing};
use crate::input::file::MeasuredPaperTable;
use crate::input::forms::FluorescenceWritten;
use crate::input::limits;
use crate::input::measured::{
    MeasuredCondition, MeasuredGeometry, MeasuredReading, MeasuredRequest, MeasuredUnit,
};
use crate::input::study::{MeasuredPaper, Paper};
use crate::material::text_table::read_text;
use std::path::Path;

/// M1 may be below M2 by this much: noise and drift of an instrument.
const NOISE: f64 = 0.01;
/// Rounding of quanta.
const ROUNDING: f64 = 1e-9;
/// Light must reach down to this for a pair of measurements: half of the usual excitation band lies
/// below, nm.
const PAIR_FROM_NM: f64 = 360.0;

/// Where a pair of measurements stands.
const PAIR: &str = "paper.fluorescence";
/// Share of a bispectral table below its diagonal, where light would be emitted at shorter waves
/// than it came at, that is noise.
const BELOW_DIAGONAL: f64 = 0.01;

/// A spectrum read for the paper, with its geometry.
struct MeasuredFactor {
    rows: Vec<[f64; 2]>,
    geometry: PaperGeometry,
}

impl BackingReader<'_> {
    /// Paper whose factor was measured; `extended` where the albedo goes on at shorter waves.
    pub fn measured(&mut self, table: &MeasuredPaperTable, extended: bool) -> Paper {
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
        let Some(measured) = self.behind_surface("paper.measured.csv", &factor, table.condition) else {
            return paper;
        };
        let rows = measured.rows.iter().map(|[nm, _, albedo]| [*nm, *albedo]).collect();
        let rows = if extended { self.extended(rows) } else { rows };
        paper.albedo = spectral("paper.measured.csv", rows, self.tables.wavelengths_nm, self.faults);
        paper.measured = Some(measured);
        paper
    }

    /// A file's factor with its geometry: that of the file, or the one given beside it.
    fn factor(
        &mut self,
        field: &str,
        path: &Path,
        request: &MeasuredRequest,
        written: Option<PaperGeometry>,
    ) -> Option<MeasuredFactor> {
        let (rows, stated) = read(field, path, request, self.faults, self.remarks)?;
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
        Some(MeasuredFactor { rows, geometry: written.or(known).unwrap_or_default() })
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
        if self.faults.0.len() > before || self.tables.wavelengths_nm.len() < 2 {
            return paper;
        }
        self.light_excites(&fluorescence);
        if let Fluorescence::Bands { excitation, .. } = &fluorescence
            && excitation.iter().any(|row| row[1] > 0.0)
        {
            paper.albedo = self.left_by(&paper.albedo, &fluorescence);
        }
        self.quanta(&paper.albedo, &fluorescence);
        paper.fluorescence = Some(fluorescence);
        paper
    }

    /// What an albedo reflects of the light that a brightener leaves it.
    fn left_by(&self, albedo: &Albedo, brightener: &Fluorescence) -> Albedo {
        let [from_nm, to_nm] = range(self.tables.wavelengths_nm);
        let mut nm = summed_nm(from_nm, to_nm);
        nm.extend(self.tables.wavelengths_nm);
        if let Albedo::Spectral(rows) = albedo {
            nm.extend(rows.iter().map(|row| row[0]).filter(|at| (from_nm..=to_nm).contains(at)));
        }
        nm.sort_by(f64::total_cmp);
        nm.dedup();
        let row = |nm: f64| Some([nm, albedo.at(nm).ok()? * (1.0 - brightener.absorbed(nm))]);
        Albedo::Spectral(nm.into_iter().filter_map(row).collect())
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

    /// The request, without its condition if the file states none, and with factors as its unit
    /// where the file leaves it open: brightened paper exceeds a perfect white, and no paper is as
    /// dark as a percent or two.
    fn stated_or_not(&mut self, path: &Path, request: MeasuredRequest) -> MeasuredRequest {
        let anything = MeasuredRequest { condition: None, ..request.clone() };
        let unit = Some(MeasuredUnit::Factor);
        let as_factors = |request: &MeasuredRequest| MeasuredRequest { unit, ..request.clone() };
        let tried = [request.clone(), anything.clone(), as_factors(&request), as_factors(&anything)];
        let is_readable = |request: &&MeasuredRequest| MeasuredReading::new(path, request).is_ok();
        let Some(readable) = tried.iter().find(is_readable) else { return request };
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        if readable.condition.is_none() {
            let taken = request.condition.map_or("", MeasuredCondition::name);
            self.remarks.push(format!("{PAIR}: {name} states no {taken}, and is taken as measured under it"));
        }
        if readable.unit != request.unit {
            self.remarks.push(format!(
                "{PAIR}: {name} states no unit, and is taken as factors of a perfect white: {PAIR}.unit = \"percent\" says another"
            ));
        }
        readable.clone()
    }

    /// Paper measured with and without ultraviolet light.
    pub fn of_pair(&mut self, written: &FluorescenceWritten) -> Paper {
        let mut paper = Paper {
            source: String::new(),
            albedo: Albedo::Constant(1.0),
            coupling: self.coupling,
            measured: None,
            fluorescence: None,
            dots: None,
        };
        let FluorescenceWritten::Pair { m1_csv, m2_csv, patch, unit } = written else { return paper };
        let request = |condition| MeasuredRequest {
            patch: patch.clone(),
            one_must_be_named: true,
            unit: *unit,
            condition: Some(condition),
            geometries: Vec::new(),
            ..MeasuredRequest::default()
        };
        paper.source = format!("{m1_csv} (M1) and {m2_csv} (M2)");
        let field = PAIR;
        let with = self.tables.folder.join(m1_csv);
        let without = self.tables.folder.join(m2_csv);
        let bright = self.stated_or_not(&with, request(MeasuredCondition::M1));
        let Some(bright) = self.factor(field, &with, &bright, None) else { return paper };
        let plain = self.stated_or_not(&without, request(MeasuredCondition::M2));
        let Some(plain) = self.factor(field, &without, &plain, None) else { return paper };
        let [from_nm, to_nm] = range(self.tables.wavelengths_nm);
        if from_nm > PAIR_FROM_NM {
            let allowed = format!("light from {PAIR_FROM_NM} nm or below, which excites a brightener");
            let remedy = "light.from_nm = 300: the layer absorbs there as well, and is solved there";
            self.faults.add(field, format!("light from {from_nm} nm"), allowed, remedy);
            return paper;
        }
        for [nm, m2] in &plain.rows {
            let m1 = between(&bright.rows, *nm);
            if let Some(m1) = m1.filter(|m1| *m1 < m2 - NOISE) {
                let found = format!("M1 = {m1:.4} below M2 = {m2:.4} at {nm} nm");
                let remedy = "exchange the files, or measure again: light only adds to fluorescence";
                self.faults.add(field, found, "M1 of M2 or more at every wavelength", remedy);
                return paper;
            }
        }
        let Some(measured) = self.behind_surface(field, &plain, Some(MeasuredCondition::M2)) else {
            return paper;
        };
        let inverse = PairInverse::new(self.coupling, &measured, from_nm, to_nm);
        let (fluorescence, lack) = inverse.fluorescence(&bright, &plain);
        if let Fluorescence::Bands { quantum_yield, .. } = &fluorescence {
            if *quantum_yield > 1.0 {
                let found =
                    format!("{quantum_yield:.2} quanta emitted per quantum that the usual band takes");
                let remedy = "light.from_nm = 300, or give excitation, emission and yield";
                self.faults.add(field, found, "at most 1", remedy);
                return paper;
            }
            self.remarks.push(format!(
                "{field}: a usual excitation band about 365 nm was taken; it emits {quantum_yield:.2} quanta per quantum, and \
                 M1 of the bare paper is returned within {lack:.4}"
            ));
        }
        paper.albedo = Albedo::Spectral(inverse.elastic);
        paper.measured = Some(measured);
        paper.fluorescence = Some(fluorescence);
        paper
    }
}

/// A value of rising rows within their range.
fn between(rows: &[[f64; 2]], nm: f64) -> Option<f64> {
    let inside = (rows.first()?[0]..=rows.last()?[0]).contains(&nm);
    inside.then(|| rows_at(rows, nm))
}

/// Emission of bare paper from its factors with and without ultraviolet light.
struct PairInverse {
    surface: BareSurface,
    /// What the paper reflects, in steps of the sum and at the ends.
    elastic: Vec<[f64; 2]>,
    /// What its brightener absorbs.
    excitation: Vec<[f64; 2]>,
    summed_nm: Vec<f64>,
}

impl PairInverse {
    fn new(coupling: Coupling, measured: &MeasuredPaper, from_nm: f64, to_nm: f64) -> Self {
        let rows: Vec<[f64; 2]> = measured.rows.iter().map(|[nm, _, albedo]| [*nm, *albedo]).collect();
        let usual = standard_excitation();
        let first = rows[0];
        let last = rows[rows.len() - 1];
        let kept = |nm: f64| 1.0 - rows_at(&usual, nm);
        // below what was measured the paper is as white, but for what the brightener takes
        let reflected = |nm: f64| match between(&rows, nm) {
            Some(value) => value,
            None if nm < first[0] => (first[1] * kept(nm) / kept(first[0])).min(kept(nm)),
            None => last[1],
        };
        let summed_nm = summed_nm(from_nm, to_nm);
        let mut all_nm = summed_nm.clone();
        all_nm.extend([from_nm, to_nm]);
        all_nm.sort_by(f64::total_cmp);
        all_nm.dedup();
        let taken = |nm: f64| rows_at(&usual, nm).min(1.0 - reflected(nm));
        Self {
            surface: BareSurface::new(coupling),
            elastic: all_nm.iter().map(|&nm| [nm, reflected(nm)]).collect(),
            excitation: summed_nm.iter().map(|&nm| [nm, taken(nm)]).collect(),
            summed_nm,
        }
    }

    /// The bands whose bare paper reads `bright` under D50, and the largest difference that is
    /// left.
    fn fluorescence(&self, bright: &MeasuredFactor, plain: &MeasuredFactor) -> (Fluorescence, f64) {
        let daylight = Viewing::new("D50", "2", Summation::Plain).unwrap_or_default();
        let [inwards, outwards] = self.surface.passed(bright.geometry);
        let back = 1.0 - self.surface.escaping();
        let mut taken = 0.0;
        let mut lack: f64 = 0.0;
        let mut emission = Vec::new();
        for &nm in &self.summed_nm {
            let power = daylight.power(nm);
            let albedo = rows_at(&self.elastic, nm);
            let more =
                between(&bright.rows, nm).zip(between(&plain.rows, nm)).map_or(0.0, |(m1, m2)| m1 - m2);
            lack = lack.max(-more);
            // what the paper must send up for this, and the quanta per nm for each that was taken
            let emitted = more.max(0.0) * power * (1.0 - albedo * back) / outwards;
            let emitted = if taken > 0.0 { emitted } else { 0.0 };
            emission.push([nm, if taken > 0.0 { emitted * nm / taken } else { 0.0 }]);
            let below = (inwards * power + back * emitted) / (1.0 - albedo * back);
            taken += STEP_NM * rows_at(&self.excitation, nm) * nm * below;
        }
        // the rows are steps of one width, and vanish at the ends of what is measured
        let quantum_yield =
            emission.windows(2).map(|p| 0.5 * (p[1][0] - p[0][0]) * (p[0][1] + p[1][1])).sum();
        (Fluorescence::Bands { excitation: self.excitation.clone(), emission, quantum_yield }, lack)
    }
}

/// Reads a bispectral table: what is emitted, of longer wavelength than its light.
fn donaldson(path: &Path) -> Result<Fluorescence, String> {
    let text = read_text(path).map_err(|error| error.to_string())?;
    let lines = text.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with('#'));
    let mut lines = lines.map(|line| line.split([',', ';', '\t']).map(str::trim).collect::<Vec<_>>());
    let header = lines.next().ok_or("no rows")?;
    let number = |cell: &&str| {
        cell.parse::<f64>().ok().filter(|x| x.is_finite()).ok_or_else(|| format!("{cell:?} is no number"))
    };
    let excitation_nm = header[1..].iter().map(number).collect::<Result<Vec<_>, _>>()?;
    let widths: Vec<f64> = excitation_nm.windows(2).map(|pair| pair[1] - pair[0]).collect();
    if widths.is_empty() || widths.iter().any(|w| *w <= 0.0 || (w - widths[0]).abs() > 1e-6 * widths[0].abs())
    {
        return Err(format!(
            "{} wavelengths of the light that do not rise in equal steps",
            excitation_nm.len()
        ));
    }
    let mut emission_nm: Vec<f64> = Vec::new();
    let mut factors = Vec::new();
    let mut emitted_later = 0.0;
    let mut left_out = 0.0;
    for cells in lines {
        let nm = number(cells.first().ok_or("an empty row")?)?;
        let row = cells[1..].iter().map(number).collect::<Result<Vec<_>, _>>()?;
        if row.len() != excitation_nm.len() {
            return Err(format!(
                "{} factors at {nm} nm, {} wavelengths of the light",
                row.len(),
                excitation_nm.len()
            ));
        }
        if emission_nm.last().is_some_and(|last| nm <= *last) {
            return Err(format!("emitted wavelengths that do not rise at {nm} nm"));
        }
        if let Some(negative) = row.iter().find(|x| **x < 0.0) {
            return Err(format!("{negative} at {nm} nm: factors are 0 or more"));
        }
        for (from, factor) in excitation_nm.iter().zip(&row) {
            emitted_later += if nm > *from { *factor } else { 0.0 };
            left_out += if nm < *from { *factor } else { 0.0 };
        }
        let emitted =
            excitation_nm.iter().zip(row).map(|(from, factor)| if nm > *from { factor } else { 0.0 });
        factors.push(emitted.collect::<Vec<f64>>());
        emission_nm.push(nm);
    }
    if emission_nm.len() < 2 {
        return Err(format!("{} emitted wavelengths, 2 are the least", emission_nm.len()));
    }
    if emitted_later == 0.0 || left_out > BELOW_DIAGONAL * emitted_later {
        return Err(format!(
            "{:.3} in all emitted at waves longer than those of the light, {:.3} at shorter ones, of which there is nothing: \
             exchange rows and columns, so that emitted wavelengths stand in the first column",
            emitted_later, left_out
        ));
    }
    Ok(Fluorescence::Table { excitation_nm, emission_nm, factors })
}
