//! Depths at which grains of a profile are placed.

use super::placed::Packing;
use super::request::{PackingRequest, PigmentGrains};
use crate::ink::grains::volume::in_slices;

/// Density of grains against depth, linear between rows, as a distribution to draw from.
#[derive(Clone, Debug)]
pub(crate) struct DepthLaw {
    /// Depth over the thickness, not falling, and density.
    rows: Vec<[f64; 2]>,
    /// Share of the grains above every row.
    above: Vec<f64>,
}

impl DepthLaw {
    /// The law of rows; `None` without any, where all depths are alike.
    pub fn of(rows: &[[f64; 2]]) -> Option<Self> {
        let mut above = vec![0.0];
        for pair in rows.windows(2) {
            let [[from, first], [to, last]] = [pair[0], pair[1]];
            above.push(above[above.len() - 1] + 0.5 * (to - from) * (first + last));
        }
        let all = above[above.len() - 1];
        above.iter_mut().for_each(|share| *share /= all);
        (all > 0.0).then(|| Self { rows: rows.to_vec(), above })
    }

    /// The depth above which a share of the grains lies, both 0 to 1.
    pub fn quantile(&self, share: f64) -> f64 {
        let last = self.rows.len() - 2;
        let segment = self.above[1..=last].iter().take_while(|above| **above <= share).count();
        let [from, first] = self.rows[segment];
        let [to, second] = self.rows[segment + 1];
        let within = self.above[segment + 1] - self.above[segment];
        if within <= 0.0 || first + second <= 0.0 {
            return from;
        }
        // share of the segment's area: first t + (second − first) t²/2 = m, in the stable form
        let m = 0.5 * (first + second) * (share - self.above[segment]) / within;
        let root = (first * first + 2.0 * (second - first) * m).max(0.0).sqrt();
        if first + root > 0.0 { from + (to - from) * 2.0 * m / (first + root) } else { from }
    }

    /// Share of the grains above a depth, 0 to 1.
    fn share_above(&self, depth: f64) -> f64 {
        let segments = self.rows.windows(2).zip(self.above.windows(2));
        for (rows, above) in segments {
            let [[from, first], [to, second]] = [rows[0], rows[1]];
            if depth < to && first + second > 0.0 {
                let t = ((depth - from) / (to - from)).max(0.0);
                let part = (first * t + 0.5 * (second - first) * t * t) / (0.5 * (first + second));
                return above[0] + part * (above[1] - above[0]);
            }
        }
        1.0
    }
}

/// What is wrong with the rows of a profile: field, value and what is allowed.
pub(super) fn defect(pigment: &PigmentGrains) -> Option<(String, String, String)> {
    let rows = &pigment.profile;
    let (first, last) = rows.first().zip(rows.last())?;
    let allowed = "rows [depth, share] from depth 0 to depth 1, in order, with shares from 0 to 0.64 that are not all 0";
    let is_sound =
        |[depth, share]: &[f64; 2]| (0.0..=1.0).contains(depth) && share.is_finite() && *share >= 0.0;
    let is_whole = rows.len() >= 2 && first[0] == 0.0 && last[0] == 1.0;
    let rises = rows.windows(2).all(|pair| pair[1][0] >= pair[0][0]);
    let good = is_whole && rises && rows.iter().all(is_sound) && DepthLaw::of(rows).is_some();
    (!good).then(|| ("profile".to_owned(), format!("{rows:?}"), allowed.to_owned()))
}

/// Shares of the thirds of a layer, as asked and as reached, for every pigment with a profile.
pub(super) fn notes(request: &PackingRequest, packing: &Packing) -> Vec<String> {
    const PARTS: usize = 3;
    let mut notes = Vec::new();
    for (k, pigment) in request.pigments.iter().enumerate() {
        let Some(law) = DepthLaw::of(&pigment.profile) else { continue };
        let [lx, ly] = packing.period_um();
        let height = packing.thickness_um() / PARTS as f64;
        let mut reached = [0.0; PARTS];
        for grain in packing.grains().iter().filter(|grain| grain.pigment == k) {
            let within = in_slices(&grain.spheres, grain.solid.as_ref(), height, PARTS);
            let scale = grain.volume_um3 / within.iter().sum::<f64>() / (lx * ly * height);
            reached.iter_mut().zip(within).for_each(|(sum, part)| *sum += scale * part);
        }
        let asked = |part: usize| {
            let at = |i: usize| law.share_above(i as f64 / PARTS as f64);
            PARTS as f64 * pigment.volume_fraction * (at(part + 1) - at(part))
        };
        let listed = |values: &dyn Fn(usize) -> f64| {
            (0..PARTS).map(|part| format!("{:.3}", values(part))).collect::<Vec<_>>().join(", ")
        };
        notes.push(format!(
            "pigment {}: shares {} in the thirds of the depth, asked {}",
            k + 1,
            listed(&|part| reached[part]),
            listed(&asked)
        ));
    }
    notes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ink::pack;

    /// Quantiles invert the shares, also across depths that hold nothing.
    #[test]
    fn quantiles_invert_shares() {
        for rows in [
            vec![[0.0, 0.2], [1.0, 0.4]],
            vec![[0.0, 0.0], [1.0, 0.3]],
            vec![[0.0, 0.3], [0.4, 0.0], [1.0, 0.2]],
            vec![[0.0, 0.0], [0.5, 0.0], [0.5, 1.0], [1.0, 1.0]],
        ] {
            let law = DepthLaw::of(&rows).expect("a law");
            for i in 1..50 {
                let share = f64::from(i) / 50.0;
                let depth = law.quantile(share);
                assert!((law.share_above(depth) - share).abs() < 1e-12, "{rows:?} {share} {depth}");
            }
        }
    }

    /// Dilute and crowded packings follow the profile. *Planted*: the profile upside down.
    #[test]
    fn packings_follow_their_profile() {
        for shares in [[0.04, 0.12], [0.2, 0.4]] {
            let rows = vec![[0.0, shares[0]], [1.0, shares[1]]];
            let mean = 0.5 * (shares[0] + shares[1]);
            let grains = PigmentGrains { profile: rows, ..PigmentGrains::spheres(120.0, mean) };
            let request = PackingRequest {
                period_um: [2.5; 2],
                thickness_um: 1.2,
                pigments: vec![grains],
                ..PackingRequest::default()
            };
            let packing = pack(&request, &mut ()).expect("a packing");
            // middles of the halves: a quarter and three quarters of the depth
            let of_half = |half: usize| {
                let grains = packing.grains().iter();
                let volumes = grains.map(|g| in_slices(&g.spheres, None, 0.6, 2)[half]);
                volumes.sum::<f64>() / (2.5 * 2.5 * 0.6)
            };
            let want = |depth: f64| shares[0] + (shares[1] - shares[0]) * depth;
            // 300 grains and more: 6 % of either half
            for (half, depth) in [(0, 0.25), (1, 0.75)] {
                let off = of_half(half) / want(depth) - 1.0;
                assert!(off.abs() < 0.15, "{shares:?} {half}: {}", of_half(half));
            }
            assert!(packing.account().notes.iter().any(|note| note.contains("thirds of the depth")));
        }
    }
}
