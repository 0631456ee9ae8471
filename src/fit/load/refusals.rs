//! Settings of a fit that are refused.

use super::shares::BINDER;
use super::{FitReading, FitTask};
use crate::fit::file::{AlsoFitted, FitFile, FitTable, KNOWN_ERROR, PriorName};
use crate::input::limits::{ANCHOR_NM, DENSITY, INDEX};
use crate::input::study::Study;
use crate::numerics::allowed::Allowed;

/// Distance of n from the binder's below which a composed coat scatters too little for its table.
const LEAST_CONTRAST: f64 = 0.05;

impl FitReading<'_> {
    /// Checks the numbers of `[fit]`.
    pub(super) fn check_settings(&mut self, fit: &FitTable) {
        let usual = "0.003 is usual: 0.3 % of a perfect white";
        self.faults.number("fit.noise", fit.noise, Allowed::between(1e-5, 0.1, ""), usual);
        let ranges = [("fit.n", fit.n, [1.0, 4.0]), ("fit.kappa", fit.kappa, [0.0, 4.0])];
        for (field, [from, to], allowed) in ranges {
            if !(allowed[0] <= from && from < to && to <= allowed[1]) {
                let range = format!("[from, to] with {} ≤ from < to ≤ {}", allowed[0], allowed[1]);
                let remedy = if from == to {
                    "n and κ are fitted together: give n that is known by fit.known_n, and a range here"
                } else {
                    "leave it out: [1.3, 2.0] and [0, 0.6]"
                };
                self.faults.add(field, format!("[{from}, {to}]"), range, remedy);
            }
        }
        for (name, density) in &fit.densities_g_per_cm3 {
            let usual = "1.1 is usual for a binder, 1.5 for an organic pigment, 4 to 5 for an oxide";
            let field = format!("fit.densities_g_per_cm3.{name}");
            self.faults.number(&field, *density, DENSITY, usual);
            let names: Vec<String> = self.all_pigments().into_iter().map(|pigment| pigment.name).collect();
            if name != BINDER && !names.contains(name) {
                let allowed = format!("{BINDER}, and the names of the base's pigments: {}", names.join(", "));
                self.faults.add(
                    &field,
                    "an unknown name",
                    allowed,
                    "write the pigment's name as in the base",
                );
            }
        }
        if fit.also.iter().enumerate().any(|(place, number)| fit.also[..place].contains(number)) {
            let found = "one number twice";
            self.faults.add("fit.also", found, "every number once", "remove one of them");
        }
        self.check_known(fit);
    }

    /// Checks n known from elsewhere.
    fn check_known(&mut self, fit: &FitTable) {
        let Some(known) = fit.known_n else { return };
        let below = "the pole of the ultraviolet is at 200 nm; give a longer wavelength";
        self.faults.number("fit.known_n.n_nm", known.n_nm, ANCHOR_NM, below);
        let measured = "give n where it was measured, such as n_nm = 589 and n = 1.65 by immersion";
        self.faults.number("fit.known_n.n", known.n, INDEX, measured);
        self.faults.number("fit.known_n.n_error", known.n_error, KNOWN_ERROR, "0.01 is usual");
        let [from, to] = fit.n;
        if from < to && !(from..=to).contains(&known.n) {
            let allowed = format!("within fit.n = [{from}, {to}]");
            self.faults.add("fit.known_n.n", known.n, allowed, "correct it, or widen fit.n");
        }
        if fit.prior != PriorName::KramersKronig {
            let allowed = "fit.prior = \"kramers-kronig\", which carries n from one wavelength to all";
            let remedy = "leave fit.prior out, or remove fit.known_n";
            self.faults.add("fit.known_n", "fit.prior = \"smooth\"", allowed, remedy);
        }
    }

    /// What is not fitted in a stack of layers: they are solved as a whole, and spread in the
    /// thickness of the fitted pigment's layer alone.
    pub(super) fn check_stack(&mut self, coat: &Study) {
        if coat.stack.is_empty() {
            return;
        }
        if coat.composed().is_some() {
            let remedy = "leave composed out, and take drawdowns of 1 to 3 µm";
            self.faults.add(
                "base.stack.composed",
                "a stack of plates",
                "layers that are solved as a whole",
                remedy,
            );
        }
        let fitted = coat.layer_of_pigment(self.pigment.in_study);
        let spread =
            coat.stack.iter().enumerate().find(|(k, layer)| *k != fitted && layer.thickness_std_um > 0.0);
        if let Some((k, layer)) = spread {
            self.faults.add(
                format!("base.layer[{k}].thickness_um.std"),
                layer.thickness_std_um,
                "0, but for the layer of the fitted pigment",
                "leave it out: what the stack has more or less than its mean is in that layer",
            );
        }
    }

    /// What the table of a composed base cannot hold.
    pub(super) fn check_composed(&mut self, file: &FitFile, task: &FitTask) {
        let [from, to] = file.fit.n;
        let binder = task.binder_index();
        if from < binder + LEAST_CONTRAST && to > binder - LEAST_CONTRAST {
            let allowed = format!(
                "a range of n all above or all below the binder's {binder:.3}, by {LEAST_CONTRAST} or more, where the base is composed: coats do not scatter in between"
            );
            let remedy = format!("write n = [{:.2}, {to}], or what you know of it", binder + 0.1);
            self.faults.add("fit.n", format!("[{from}, {to}]"), allowed, remedy);
        }
        if let Some(known) = file.fit.known_n
            && (known.n - binder) * (from - binder) <= 0.0
        {
            let side = if from > binder { "above" } else { "below" };
            let allowed = format!("n {side} the binder's {binder:.3}, as fit.n = [{from}, {to}] is");
            self.faults.add("fit.known_n.n", known.n, allowed, "correct fit.known_n, or fit.n");
        }
        let all_opaque = file.measured.iter().all(|table| table.opaque);
        if all_opaque && file.fit.also.contains(&AlsoFitted::Thickness) {
            let remedy = "leave it out: an opaque sample has no thickness";
            self.faults.add(
                "fit.also",
                "\"thickness\"",
                "\"face_light\" where all samples are opaque",
                remedy,
            );
        }
        if all_opaque && file.fit.prior == PriorName::Smooth {
            let allowed = "fit.prior = \"kramers-kronig\" with fit.known_n where all samples are opaque";
            let remedy = "leave fit.prior out: opaque coats tell absorption over scattering, and n and κ each for itself are two unknowns at every wavelength";
            self.faults.add("fit.prior", "\"smooth\"", allowed, remedy);
        }
    }
}
