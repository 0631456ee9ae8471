//! The layer: its thickness, the period of its cells, and the media around it.

use super::Tabulation;
use crate::input::file::LayerTable;
use crate::input::study::Layer;
use crate::input::variation::{THICKNESS_CUT, shortest_side_um};
use crate::input::{Allowed, CellRule, Faults, limits};
use crate::material::mixing::MixingRule;
use crate::wave::Wave;

/// The space that grains must fit into, as written: lengths that are not allowed are reported where
/// they stand.
#[derive(Clone, Copy)]
pub(super) struct NominalCell {
    /// Whether realisations have cells of their own.
    pub rule: CellRule,
    /// Nominal periods along x and y, µm.
    pub period_um: [f64; 2],
    /// Mean thickness, µm.
    pub thickness_um: f64,
    /// Standard deviation of the thickness, µm.
    pub thickness_std_um: f64,
    /// Whether it is a slab of a composed layer.
    pub is_slab: bool,
}

impl NominalCell {
    /// The cell of a layer; `usual_period_um` applies where the file gives no period.
    pub(super) fn new(table: &LayerTable, usual_period_um: f64, faults: &mut Faults) -> Self {
        Self {
            rule: table.cell,
            period_um: table.checked_period_um(usual_period_um, faults),
            thickness_um: table.thickness_um.mean(),
            thickness_std_um: table.thickness_um.std(),
            is_slab: table.composed.is_some(),
        }
    }

    /// The shortest side that a cell may get, µm.
    pub(super) fn shortest_side_um(&self) -> f64 {
        shortest_side_um(self.rule, self.period_um)
    }

    /// The thinnest layer that may be drawn, µm.
    pub(super) fn thinnest_um(&self) -> f64 {
        self.thickness_um - THICKNESS_CUT * self.thickness_std_um
    }
}

impl LayerTable {
    /// The nominal period: as written, or else the usual one.
    fn checked_period_um(&self, usual_um: f64, faults: &mut Faults) -> [f64; 2] {
        let Some(written) = self.period_um else {
            // files of grains give it, unless they cannot be read
            if self.cell == CellRule::Fixed && self.microstructure.is_none() {
                let allowed = "one number or [x, y], µm, for cell = \"fixed\"";
                let remedy = "write period_um = 2.4, or let cells vary";
                faults.add("layer.period_um", "nothing", allowed, remedy);
            }
            return [usual_um; 2];
        };
        let remedy = "1.6 µm is usual, larger cells cost more; leave it out, and it follows from the grains";
        for period in written.xy() {
            faults.number("layer.period_um", period, limits::PERIOD_UM, remedy);
        }
        written.xy()
    }

    /// The layer with its binder; the index of the binder matters to the wave only.
    pub(super) fn checked(
        &self,
        cell: &NominalCell,
        tables: &Tabulation,
        faults: &mut Faults,
        wave_faults: &mut Faults,
    ) -> Layer {
        let mean_um = cell.thickness_um;
        // an empty list is reported as one
        if !self.thickness_um.all().is_empty() {
            let remedy = "a printed layer is about 1 µm thick";
            faults.number("layer.thickness_um", mean_um, limits::THICKNESS_UM, remedy);
        }
        if mean_um > 0.0 {
            let allowed = Allowed::between(0.0, mean_um / (THICKNESS_CUT + 1.0), "µm");
            let remedy = "a tenth of the mean is usual; at most a quarter of it keeps every layer thicker than nothing";
            faults.number("layer.thickness_um.std", cell.thickness_std_um, allowed, remedy);
        }
        let remedy = "give the real refractive index, 1 for air";
        faults.number("layer.index_in", self.index_in, limits::INDEX, remedy);
        faults.number("layer.index_out", self.index_out, limits::INDEX, remedy);
        Layer {
            period_um: cell.period_um,
            thickness_um: mean_um,
            index_in: self.index_in,
            index_out: self.index_out,
            contrast: self.contrast,
            binder: self.binder.index.tabulated("layer.binder.index", tables, wave_faults),
        }
    }

    /// The mixing rule: that of vanishing grains for the wave, unless the file sets another.
    pub(super) fn mixing_rule(&self, wave: Wave) -> MixingRule {
        let of_wave = if wave.is_vector() { MixingRule::MaxwellGarnett } else { MixingRule::VolumeAverage };
        self.mixing.unwrap_or(of_wave)
    }
}
