//! Curves against concentration and grain size (P1 section 6): transmittance of the layer where the
//! pigment absorbs most, and chroma on paper.

use super::outcome::Outcome;
use super::reported::inks;
use super::sheets::Sheet;
use crate::draw::chart::{Chart, Curve};
use crate::ink::{Orientation, PigmentGrains, SizeDistribution};
use crate::input::file::ContrastPart;
use crate::input::study::Study;
use crate::numerics::estimate::Estimate;
use crate::sweep::definition::load::Sweep;
use std::collections::{BTreeMap, HashMap};

/// Maximum number of curves per figure: colours of the palette.
pub(super) const MOST_CURVES: usize = 7;

/// Composition of a variant, as far as curves distinguish it; sizes in hundredths of a nm and
/// fractions in millionths, so that equal numbers compare equal.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct CurveMaker {
    /// Share and size.
    at: [u64; 2],
    /// Pigments, shapes, orientations, agglomeration; equal for molecular mixtures of the same
    /// pigments.
    kind: String,
    pigments: String,
    /// Captions on the axes that do not change the composition, such as the paper or the wave.
    others: String,
}

/// Places of the abscissas, share and size, in the lists that follow.
const SHARE: usize = 0;
const SIZE: usize = 1;
/// What one step of an abscissa is, in % and nm.
const UNITS: [f64; 2] = [1e-4, 1e-2];
/// Their labels, and their names in titles.
const LABELS: [&str; 2] = ["pigment volume concentration, %", "effective grain diameter, nm (0: molecular)"];
const NAMES: [&str; 2] = ["concentration", "grain size"];

/// All curves of a sheet; empty if neither the fraction nor the size varies.
pub(crate) fn plots(sweep: &Sweep, sheet: &Sheet, outcomes: &[Outcome]) -> Vec<Chart> {
    let shown = sheet.cells.iter().flatten().flatten();
    let made: Vec<(usize, CurveMaker)> =
        shown.filter_map(|&v| Some((v, CurveMaker::of(&sweep.variants[v].study)?))).collect();
    let made = with_others(sweep, made);
    let Some(&(first, _)) = made.first() else { return Vec::new() };
    let nm = strongest_nm(&sweep.variants[first].study);
    let transmittance = |v: usize| {
        Some(outcomes[v].spectra.iter().find(|row| (row.wavelength_nm - nm).abs() < 1e-6)?.transmittance)
    };
    let chroma = |v: usize| Some(outcomes[v].colour.as_ref()?.chroma());
    let of_t = format!("transmittance at {nm:.0} nm");
    let mut plots = Vec::new();
    for x in [SHARE, SIZE] {
        for (label, y) in [(of_t.as_str(), &transmittance as &dyn Fn(usize) -> _), ("chroma C*", &chroma)] {
            plots.extend(plot(sheet, &made, x, label, y));
        }
    }
    plots
}

/// Distinguishes variants of the same composition by their paper, their wave and so on.
fn with_others(sweep: &Sweep, mut made: Vec<(usize, CurveMaker)>) -> Vec<(usize, CurveMaker)> {
    let place = |v: usize| &sweep.outline.variants[v].place;
    let axes: Vec<usize> = (0..sweep.outline.axes.len()).filter(|&a| tells_apart(sweep, &made, a)).collect();
    for (v, make) in &mut made {
        let captions = axes.iter().map(|&a| sweep.outline.axes[a].named(place(*v)[a]));
        make.others = captions.collect::<Vec<_>>().join(", ");
    }
    made
}

/// Whether an axis distinguishes two variants of the same composition. Variants with grains decide;
/// molecular mixtures follow.
fn tells_apart(sweep: &Sweep, made: &[(usize, CurveMaker)], axis: usize) -> bool {
    let all_dissolved = made.iter().all(|(_, make)| make.at[SIZE] == 0);
    let mut seen: HashMap<(Vec<usize>, &CurveMaker), usize> = HashMap::new();
    made.iter().filter(|(_, make)| all_dissolved || make.at[SIZE] > 0).any(|(v, make)| {
        let mut elsewhere = sweep.outline.variants[*v].place.clone();
        let here = elsewhere.remove(axis);
        *seen.entry((elsewhere, make)).or_insert(here) != here
    })
}

fn plot(
    sheet: &Sheet,
    made: &[(usize, CurveMaker)],
    x: usize,
    y_label: &str,
    y: &dyn Fn(usize) -> Option<Estimate>,
) -> Option<Chart> {
    let mut curves: Vec<Curve> = Vec::new();
    for name in names(made, x) {
        let mut points = BTreeMap::new();
        let mut requested = Vec::new();
        for (v, make) in made.iter().filter(|(_, make)| make.belongs(&name, x)) {
            requested.push(make.in_units(x));
            if let Some(value) = y(*v) {
                points.entry(make.at[x]).or_insert((make.in_units(x), value));
            }
        }
        // a molecular mixture alone is not a curve
        if points.len() > 1 {
            curves.push(Curve::measured(name.in_words(made), points.into_values()).asked_at(&requested));
        }
    }
    curves.truncate(MOST_CURVES);
    if curves.is_empty() {
        return None;
    }
    let title = if sheet.title.is_empty() { String::new() } else { format!("{}: ", sheet.title) };
    let title = format!("{title}{y_label} against {}", NAMES[x]);
    Some(Chart { from_zero: true, ..Chart::linear(&title, LABELS[x], y_label, curves) })
}

/// Compositions that differ in more than the abscissa, in order of appearance; molecular mixtures
/// belong to all sizes.
fn names(made: &[(usize, CurveMaker)], x: usize) -> Vec<CurveMaker> {
    let mut names: Vec<CurveMaker> = Vec::new();
    for (_, make) in made.iter().filter(|(_, make)| x == SHARE || make.at[SIZE] > 0) {
        let mut name = make.clone();
        name.at[x] = 0;
        if !names.contains(&name) {
            names.push(name);
        }
    }
    names
}

impl CurveMaker {
    /// `None` for layers without pigment and for grains of several sizes.
    fn of(study: &Study) -> Option<Self> {
        let grains = || study.pigments.iter().map(|p| &p.grains);
        let dissolved = study.dissolved.iter().map(|d| d.volume_fraction);
        let share: f64 = grains().map(|g| g.volume_fraction).chain(dissolved).sum();
        let sizes: Option<Vec<f64>> = grains().map(one_size).collect();
        let sizes = sizes?;
        let size = sizes.first().copied().unwrap_or(0.0);
        if share == 0.0 || sizes.iter().any(|&s| s != size) || (size > 0.0 && !study.dissolved.is_empty()) {
            return None;
        }
        let mut kinds: Vec<String> = grains().map(kind).collect();
        kinds.dedup();
        let relief = if study.packing.relief.is_some() { ", relief" } else { "" };
        let contrast = match study.layer.contrast {
            ContrastPart::Real if size > 0.0 => ", Re η² alone",
            ContrastPart::Imaginary if size > 0.0 => ", Im η² alone",
            _ => "",
        };
        let at = [(share * 1e6).round() as u64, (size * 1e2).round() as u64];
        let kind = kinds.join(" and ") + relief + contrast;
        let pigments = inks(study).join(" + ");
        Some(Self { at, kind, pigments, others: String::new() })
    }

    fn in_units(&self, x: usize) -> f64 {
        self.at[x] as f64 * UNITS[x]
    }

    /// Whether it lies on the curve of this name.
    fn belongs(&self, name: &Self, x: usize) -> bool {
        let same_ink = self.pigments == name.pigments && self.others == name.others;
        let same_kind = self.kind == name.kind || x == SIZE && self.at[SIZE] == 0;
        same_ink && same_kind && self.at[1 - x] == name.at[1 - x]
    }

    /// Name of the curve; pigments are named only if they differ.
    fn in_words(&self, made: &[(usize, Self)]) -> String {
        let mut words = Vec::new();
        if made.iter().any(|(_, other)| other.pigments != self.pigments) {
            words.push(self.pigments.clone());
        }
        if self.at[SHARE] > 0 {
            words.push(format!("{} %", self.in_units(SHARE)));
        }
        match (self.at[SIZE], self.kind.is_empty()) {
            (0, true) => words.push("molecular".into()),
            (0, false) => words.push(self.kind.clone()),
            _ => words.push(format!("{} nm {}", self.in_units(SIZE), self.kind)),
        }
        words.extend(Some(self.others.clone()).filter(|others| !others.is_empty()));
        words.join(", ")
    }
}

fn one_size(grains: &PigmentGrains) -> Option<f64> {
    match grains.size {
        SizeDistribution::Constant { value_nm, .. } => Some(value_nm),
        _ => None,
    }
}

fn kind(grains: &PigmentGrains) -> String {
    let orientation = match grains.orientation {
        Orientation::Random => "",
        Orientation::InPlane { .. } => ", lying",
        Orientation::Perpendicular { .. } => ", standing",
        Orientation::Along { .. } => ", aligned",
    };
    let agglomerated = grains.agglomeration.as_ref().is_some_and(|a| a.degree > 0.0);
    let agglomerated = if agglomerated { ", agglomerated" } else { "" };
    let shell = match grains.shell_nm.iter().sum::<f64>() {
        0.0 => String::new(),
        nm => format!(", layers of {nm} nm"),
    };
    format!("{}s{orientation}{agglomerated}{shell}", grains.shape.name())
}

/// Wavelength at which the strongest pigment absorbs most, nm.
fn strongest_nm(study: &Study) -> f64 {
    let materials = || study.materials().chain(study.dissolved.iter().map(|d| &d.material));
    let kappa = |w: usize| materials().map(|m| m.index[w].im).fold(0.0, f64::max);
    let strongest = (0..study.wavelengths_nm.len()).max_by(|&a, &b| kappa(a).total_cmp(&kappa(b)));
    study.wavelengths_nm[strongest.unwrap_or(0)]
}
