//! The dots of a halftone print: kinds of area and the screen.

mod results;

use super::Tabulation;
use crate::appearance::halftone::{demichel, mean_spread_share, physical_coverage};
use crate::appearance::paper_series::LayerOptics;
use crate::input::file::{AreaBears, AreaTable, DotsTable, InkTable, PatchRule, StudyFile};
use crate::input::study::{Dots, MixedAreas, MixedPrint};
use crate::input::{Allowed, Faults, as_written, limits};

/// Rounding of coverages that add up to 1.
const SLACK: f64 = 1e-6;
/// Most inks and prints of one study: all overprints are summed for each.
const MOST_INKS: usize = 6;
const MOST_PRINTS: usize = 20_000;
/// Micrometres of a centimetre.
const UM_PER_CM: f64 = 1e4;

/// The screen and the kinds of area of a study's file.
pub(super) struct DotsReader<'a, 'f> {
    pub file: &'a StudyFile,
    pub tables: &'a Tabulation<'a>,
    pub faults: &'f mut Faults,
}

/// The screen of a print, checked.
struct Screen {
    ruling_per_cm: f64,
    spread_um: f64,
    physical_gain: f64,
}

impl Screen {
    /// Coverages of inks, each of whose screens knows nothing of the others.
    fn inks(&self, nominal: &[f64]) -> Vec<f64> {
        nominal.iter().map(|&c| physical_coverage(c, self.physical_gain)).collect()
    }

    /// Coverages of areas of one screen, which grow at the cost of the bare paper, all alike.
    fn areas(&self, nominal: &[f64]) -> Vec<f64> {
        let sum: f64 = nominal.iter().sum();
        let factor = if sum > 0.0 { physical_coverage(sum.min(1.0), self.physical_gain) / sum } else { 1.0 };
        nominal.iter().map(|c| factor * c).collect()
    }

    /// Share of the light that the paper spreads over areas of these coverages alike.
    fn spread(&self, coverages: &[f64]) -> f64 {
        mean_spread_share(coverages, self.ruling_per_cm / UM_PER_CM, self.spread_um)
    }
}

impl DotsReader<'_, '_> {
    /// The tints of a study; `None` where it prints a solid alone, or after an error.
    pub fn checked(mut self) -> Option<Dots> {
        let before = self.faults.0.len();
        let DotsTable { ruling_per_cm, spread_um, physical_gain, patches } = self.file.dots;
        let areas = &self.file.areas;
        if areas.is_empty() {
            let given = ruling_per_cm.is_some() || spread_um.is_some() || physical_gain != 0.0;
            if given || !self.file.inks.is_empty() {
                let field = if given { "dots" } else { "ink" };
                let remedy = match self.file.inks.is_empty() {
                    true => "add [[area]] with coverage = [0.25, 0.5, 0.75], or remove it",
                    false => {
                        "add an [[area]] for every overprint, such as inks = [\"cyan\"], with what it bears"
                    }
                };
                self.faults.add(field, "a screen without areas", "a screen with [[area]]", remedy);
            }
            return None;
        }
        self.faults.number("dots.physical_gain", physical_gain, limits::DOT_GAIN, "0 to 0.1 is usual");
        let ruling_per_cm = self.required("dots.ruling_per_cm", ruling_per_cm, limits::RULING_PER_CM);
        let spread_um = self.required("dots.spread_um", spread_um, limits::SPREAD_UM);
        let screen = Screen {
            ruling_per_cm: ruling_per_cm.unwrap_or(1.0),
            spread_um: spread_um.unwrap_or(0.0),
            physical_gain,
        };
        let is_mixed = !self.file.inks.is_empty() || areas.iter().any(|area| area.results.is_some());
        let mixed = is_mixed.then(|| self.mixed(&screen, patches));
        if let Some(mixed) = mixed {
            let mixed = mixed.filter(|_| self.faults.0.len() == before)?;
            let nominal = mixed.prints.iter().map(|print| inked(&print.nominal, &self.file.inks)).collect();
            let Screen { ruling_per_cm, spread_um, physical_gain } = screen;
            return Some(Dots { nominal, ruling_per_cm, spread_um, physical_gain, mixed: Some(mixed) });
        }
        let nominal = self.nominal_of_areas()?.into_iter().map(|areas| areas[0].min(1.0)).collect();
        if self.faults.0.len() > before {
            return None;
        }
        Some(Dots {
            nominal,
            ruling_per_cm: ruling_per_cm?,
            spread_um: spread_um?,
            physical_gain,
            mixed: None,
        })
    }

    /// Kinds of area beyond this study's layer, with their shares in every print.
    fn mixed(&mut self, screen: &Screen, patches: PatchRule) -> Option<MixedAreas> {
        let layers = self.layers()?;
        if self.file.inks.is_empty() {
            let named = |area: &AreaTable| area.results.clone().unwrap_or_else(|| "layer".to_owned());
            let mut names: Vec<String> = vec!["layer".to_owned()];
            names.extend(self.file.areas.iter().filter(|area| area.results.is_some()).map(named));
            let prints = self.nominal_of_areas()?.into_iter().map(|nominal| {
                let shares = screen.areas(&nominal);
                MixedPrint { spread: screen.spread(&shares), shares, nominal }
            });
            return Some(MixedAreas { names, layers, prints: prints.collect() });
        }
        let kinds = self.kinds_of_overprints()?;
        let coverages = self.coverages(patches)?;
        let count = 1 + layers.len();
        let shares = |gained: &[f64]| {
            let mut shares = vec![0.0; count];
            for (set, share) in demichel(gained).into_iter().enumerate() {
                kinds[set].iter().for_each(|&kind| shares[kind] += share);
            }
            shares
        };
        let names = self.file.inks.iter().map(|ink| ink.name.clone()).collect();
        let prints = coverages.into_iter().map(|nominal| {
            let gained = screen.inks(&nominal);
            MixedPrint { spread: screen.spread(&gained), shares: shares(&gained), nominal }
        });
        Some(MixedAreas { names, layers, prints: prints.collect() })
    }

    /// The layers of other runs, in the order of their areas.
    fn layers(&mut self) -> Option<Vec<LayerOptics>> {
        let mut layers = Vec::new();
        for (i, area) in self.file.areas.iter().enumerate() {
            let Some(folder) = &area.results else { continue };
            let field = format!("area[{i}].results");
            if area.bears == AreaBears::Paper {
                let allowed = "nothing beside results, whose layer the area bears";
                self.faults.add(format!("area[{i}].bears"), "\"paper\"", allowed, "remove one of them");
            }
            match self.layer(folder) {
                Ok(layer) => layers.push(layer),
                Err([found, allowed, remedy]) => self.faults.add(field, found, allowed, remedy),
            }
        }
        let wanted = self.file.areas.iter().filter(|area| area.results.is_some()).count();
        (layers.len() == wanted).then_some(layers)
    }

    /// For every set of inks (bit by bit) the kind of area that bears it: none of bare paper, 0 of
    /// this study's layer, then the layers of other runs.
    fn kinds_of_overprints(&mut self) -> Option<Vec<Option<usize>>> {
        let inks = &self.file.inks;
        let before = self.faults.0.len();
        let allowed = format!("1 to {MOST_INKS} inks");
        let names: Vec<&str> = inks.iter().map(|ink| ink.name.as_str()).collect();
        if inks.len() > MOST_INKS {
            self.faults.add("ink", format!("{} inks", inks.len()), allowed, "remove some of them");
        }
        for (i, name) in names.iter().enumerate() {
            self.faults.name(format!("ink[{i}].name"), name, names[..i].iter().copied(), "ink");
        }
        if self.faults.0.len() > before {
            return None;
        }
        let mut kinds: Vec<Option<Option<usize>>> = vec![None; 1 << inks.len()];
        kinds[0] = Some(None);
        let mut next = 1;
        for (i, area) in self.file.areas.iter().enumerate() {
            let kind = match (&area.results, area.bears) {
                (Some(_), _) => {
                    next += 1;
                    Some(next - 1)
                }
                (None, AreaBears::Paper) => None,
                (None, AreaBears::Layer) => Some(0),
            };
            if let Some(coverage) = &area.coverage {
                let allowed = "nothing where [[ink]] has the coverages";
                let field = format!("area[{i}].coverage");
                self.faults.add(
                    field,
                    as_written(coverage),
                    allowed,
                    "remove it, and write inks = [\"cyan\"]",
                );
            }
            let mut set = 0;
            for (place, name) in area.inks.iter().enumerate() {
                if area.inks[..place].contains(name) {
                    let field = format!("area[{i}].inks");
                    self.faults.add(field, format!("{name} twice"), "each ink once", "remove one of the two");
                }
                match inks.iter().position(|ink| ink.name == *name) {
                    Some(ink) => set |= 1 << ink,
                    None => {
                        let allowed = format!("names of [[ink]]: {}", names.join(", "));
                        self.faults.add(format!("area[{i}].inks"), name, allowed, "correct the name");
                    }
                }
            }
            if kinds[set].replace(kind).is_some() && self.faults.0.len() == before {
                let found = if set == 0 { "no inks".to_owned() } else { area.inks.join(" + ") };
                let allowed = "each overprint once; what bears no ink is bare paper";
                self.faults.add(format!("area[{i}].inks"), found, allowed, "remove one of the areas");
            }
        }
        let lacking = kinds.iter().position(Option::is_none);
        if let Some(set) = lacking.filter(|_| self.faults.0.len() == before) {
            let of_set = inks.iter().enumerate().filter(|(ink, _)| set >> ink & 1 == 1);
            let words = of_set.map(|(_, ink)| ink.name.as_str()).collect::<Vec<_>>().join(" + ");
            let remedy = "add an [[area]] with these inks and what it bears";
            self.faults.add(
                "area.inks",
                format!("no area of {words}"),
                "every overprint of the inks",
                remedy,
            );
        }
        (self.faults.0.len() == before).then(|| kinds.into_iter().flatten().collect())
    }

    /// Nominal coverages of the inks in every print.
    fn coverages(&mut self, patches: PatchRule) -> Option<Vec<Vec<f64>>> {
        let before = self.faults.0.len();
        let lists: Vec<Vec<f64>> = self.file.inks.iter().map(|ink| ink.coverage.all()).collect();
        for (i, list) in lists.iter().enumerate() {
            let field = format!("ink[{i}].coverage");
            list.iter().for_each(|c| self.faults.number(&field, *c, limits::SHARE, "0.5 covers half"));
            let count = if patches == PatchRule::Each { lists[0].len() } else { list.len() };
            let remedy = "give one coverage for each print, or dots.patches = \"grid\"";
            self.check_length(&field, list, (count, "ink[0]"), remedy);
        }
        let count = match patches {
            PatchRule::Each => lists[0].len(),
            PatchRule::Grid => lists.iter().fold(1, |count: usize, list| count.saturating_mul(list.len())),
        };
        if count > MOST_PRINTS {
            let allowed = format!("at most {MOST_PRINTS} prints");
            self.faults.add("ink.coverage", format!("{count} prints"), allowed, "give fewer coverages");
        }
        if self.faults.0.len() > before {
            return None;
        }
        let print = |k: usize| {
            let mut rest = k;
            let pick = |list: &Vec<f64>| {
                let entry = if patches == PatchRule::Each { k } else { rest % list.len() };
                rest /= list.len();
                list[entry]
            };
            lists.iter().map(pick).collect()
        };
        Some((0..count).map(print).collect())
    }

    /// Nominal coverages of this study's layer and of the areas with layers of other runs, in every
    /// print.
    fn nominal_of_areas(&mut self) -> Option<Vec<Vec<f64>>> {
        let before = self.faults.0.len();
        let areas = &self.file.areas;
        let mut lists = Vec::new();
        for (i, area) in areas.iter().enumerate() {
            if !area.inks.is_empty() {
                let allowed = "nothing without [[ink]], which have the coverages";
                let field = format!("area[{i}].inks");
                self.faults.add(field, area.inks.join(", "), allowed, "add [[ink]] with name and coverage");
            }
            let Some(coverage) = &area.coverage else {
                let remedy = "write coverage = [0.25, 0.5, 0.75]";
                self.faults.add(format!("area[{i}].coverage"), "nothing", "0 to 1, or a list", remedy);
                continue;
            };
            lists.push(coverage.all());
        }
        if self.faults.0.len() > before {
            return None;
        }
        let count = lists[0].len();
        for (i, list) in lists.iter().enumerate() {
            let field = format!("area[{i}].coverage");
            self.check_length(&field, list, (count, "area[0]"), "give one coverage for each tint");
            list.iter().for_each(|c| {
                self.faults.number(&field, *c, limits::SHARE, "0.5 covers half of the area");
            });
        }
        if self.faults.0.len() > before {
            return None;
        }
        let has_paper = areas.iter().any(|area| area.bears == AreaBears::Paper);
        let mut all = Vec::new();
        for tint in 0..count {
            let mut inked = vec![0.0];
            let mut bare = 0.0;
            for (area, list) in areas.iter().zip(&lists) {
                match (&area.results, area.bears) {
                    (Some(_), _) => inked.push(list[tint]),
                    (None, AreaBears::Layer) => inked[0] += list[tint],
                    (None, AreaBears::Paper) => bare += list[tint],
                }
            }
            let whole = inked.iter().sum::<f64>() + bare;
            if whole > 1.0 + SLACK || (has_paper && whole < 1.0 - SLACK) {
                let allowed = if has_paper { "1, since bare paper is among them" } else { "at most 1" };
                let remedy = "coverages share the area: change one, or leave out the bare paper, which is what they leave";
                self.faults.add(
                    "area.coverage",
                    format!("a sum of {whole} in tint {}", tint + 1),
                    allowed,
                    remedy,
                );
                return None;
            }
            all.push(inked);
        }
        Some(all)
    }

    /// Reports coverages that are none, or not as many as those of the first.
    fn check_length(&mut self, field: &str, list: &[f64], (count, first): (usize, &str), remedy: &str) {
        if list.is_empty() {
            let allowed = "a share of the area from 0 to 1, or a list with one or more of them";
            self.faults.empty(field, allowed, "write coverage = [0.25, 0.5, 0.75]");
        } else if list.len() != count {
            let allowed = format!("{count} entries, as in {first}");
            self.faults.add(field, format!("{} entries", list.len()), allowed, remedy);
        }
    }

    /// A number of the screen, which dots need.
    fn required(&mut self, field: &str, value: Option<f64>, allowed: Allowed) -> Option<f64> {
        let remedy = "ruling_per_cm = 60 and spread_um = 40 are usual of offset prints on coated paper";
        match value {
            Some(value) => self.faults.number(field, value, allowed, remedy),
            None => self.faults.add(field, "nothing", format!("{allowed}, since there are areas"), remedy),
        }
        value
    }
}

/// Nominal share of the area that bears ink.
fn inked(nominal: &[f64], inks: &[InkTable]) -> f64 {
    match inks.is_empty() {
        true => nominal.iter().sum::<f64>().min(1.0),
        false => 1.0 - nominal.iter().map(|c| 1.0 - c).product::<f64>(),
    }
}
