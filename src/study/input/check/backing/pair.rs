//! Paper with a brightener, from two measurements of it: with ultraviolet light (M1) and without
//! (M2).

use super::{MeasuredFactor, PAIR};
use crate::appearance::bare_paper::BareSurface;
use crate::appearance::fluorescence::{Fluorescence, STEP_NM, rows_at, standard_excitation, summed_nm};
use crate::appearance::paper::{Albedo, Coupling};
use crate::appearance::viewing::{Summation, Viewing};
use crate::input::check::paper::{BackingReader, range};
use crate::input::forms::FluorescenceWritten;
use crate::input::measured::{MeasuredCondition, MeasuredReading, MeasuredRequest, MeasuredUnit};
use crate::input::study::{MeasuredPaper, Paper};
use std::path::Path;

/// M1 may be below M2 by this much: noise and drift of an instrument.
const NOISE: f64 = 0.01;
/// Light must reach down to this for a pair of measurements: half of the usual excitation band lies
/// below, nm.
const PAIR_FROM_NM: f64 = 360.0;

impl BackingReader<'_> {
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
        let of_both = [(m1_csv, &bright, MeasuredCondition::M1), (m2_csv, &plain, MeasuredCondition::M2)];
        for (file, factor, wanted) in of_both {
            if let Some(stated) = factor.condition.filter(|stated| *stated != wanted) {
                let found = format!("{file}, which states {}", stated.name());
                let allowed = format!("a measurement under {}, or one that states none", wanted.name());
                let remedy = "M0 holds a part of what M1 holds; give the file of the other condition, or excitation, emission and yield";
                self.faults.add(field, found, allowed, remedy);
                return paper;
            }
        }
        if self.lacks_wavelengths(field) {
            return paper;
        }
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
        let inverse = PairInverse::new(self.coupling, &measured, &bright, [from_nm, to_nm]);
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
    fn new(
        coupling: Coupling,
        measured: &MeasuredPaper,
        bright: &MeasuredFactor,
        [from_nm, to_nm]: [f64; 2],
    ) -> Self {
        let surface = BareSurface::new(coupling);
        let rows: Vec<[f64; 2]> = measured.rows.iter().map(|[nm, _, albedo]| [*nm, *albedo]).collect();
        let usual = standard_excitation();
        let first = rows[0];
        let last = rows[rows.len() - 1];
        let kept = |nm: f64| 1.0 - rows_at(&usual, nm);
        // Without ultraviolet light nothing is read below 420 nm. A brightener hardly emits there:
        // M1 reads what is reflected. Below M1 the paper is as white, but for what the brightener
        // takes.
        let measured_from_nm = first[0];
        let shortest_nm = bright.rows.first().map_or(first[0], |row| row[0]);
        let lit = |nm: f64| {
            let factor = between(&bright.rows, nm).filter(|_| nm < measured_from_nm)?;
            Some(surface.albedo(factor, bright.geometry).clamp(0.0, 1.0))
        };
        let first = match lit(shortest_nm) {
            Some(albedo) => [shortest_nm, albedo],
            None => first,
        };
        let reflected = |nm: f64| match between(&rows, nm).or(lit(nm)) {
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
            surface,
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
            let fluoresced =
                between(&bright.rows, nm).zip(between(&plain.rows, nm)).map_or(0.0, |(m1, m2)| m1 - m2);
            lack = lack.max(-fluoresced);
            // what the paper must send up for this, and the quanta per nm for each that was taken
            let emitted = fluoresced.max(0.0) * power * (1.0 - albedo * back) / outwards;
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
