//! Depths at which grains of a profile are placed.

/// Density of grains against depth, linear between rows, as a distribution to draw from.
#[derive(Clone, Debug)]
pub(crate) struct DepthLaw {
    /// Depth over the thickness, not falling, and density.
    rows: Vec<[f64; 2]>,
    /// Share of the grains above every row.
    above: Vec<f64>,
    /// Mean density.
    mean: f64,
}

/// Volume fraction of all grains at the depth where they are densest: of pigments with these shares
/// of the layer, each with its law, or even.
pub(crate) fn densest(laws: &[Option<DepthLaw>], fractions: &[f64]) -> f64 {
    let at = |depth: f64| {
        let local = |(law, fraction): (&Option<DepthLaw>, &f64)| {
            fraction * law.as_ref().map_or(1.0, |law| law.density(depth))
        };
        laws.iter().zip(fractions).map(local).sum::<f64>()
    };
    let ends = laws.iter().flatten().flat_map(DepthLaw::ends);
    std::iter::once(0.5).chain(ends).map(at).fold(0.0, f64::max)
}

/// Distance to either side of a row at which a step of the density is looked at.
const BESIDE: f64 = 1e-9;

impl DepthLaw {
    /// The law of rows; `None` where all depths are alike, or hold nothing.
    pub fn of(rows: &[[f64; 2]]) -> Option<Self> {
        if rows.iter().all(|row| row[1] == rows[0][1]) {
            return None;
        }
        let mut above = vec![0.0];
        for pair in rows.windows(2) {
            let [[from, first], [to, last]] = [pair[0], pair[1]];
            above.push(above[above.len() - 1] + 0.5 * (to - from) * (first + last));
        }
        let all = above[above.len() - 1];
        above.iter_mut().for_each(|share| *share /= all);
        (all > 0.0).then(|| Self { rows: rows.to_vec(), above, mean: all })
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

    /// Depths on both sides of every row: the density is largest at one of them.
    pub fn ends(&self) -> impl Iterator<Item = f64> + '_ {
        let beside = |row: &[f64; 2]| [row[0] - BESIDE, row[0] + BESIDE].map(|depth| depth.clamp(0.0, 1.0));
        self.rows.iter().flat_map(beside)
    }

    /// Density at a depth, over its mean.
    pub fn density(&self, depth: f64) -> f64 {
        let inside = |rows: &&[[f64; 2]]| depth <= rows[1][0] && rows[1][0] > rows[0][0];
        let Some(rows) = self.rows.windows(2).find(inside) else { return 0.0 };
        let [[from, first], [to, second]] = [rows[0], rows[1]];
        (first + (second - first) * ((depth - from) / (to - from)).max(0.0)) / self.mean
    }

    /// Whether the density does not vary about a depth, 0 to 1.
    pub fn is_even_at(&self, depth: f64) -> bool {
        let inside = |rows: &&[[f64; 2]]| depth <= rows[1][0] && rows[1][0] > rows[0][0];
        self.rows.windows(2).find(inside).is_none_or(|rows| rows[0][1] == rows[1][1])
    }

    /// Depths inside the layer at which the density changes at once.
    pub fn steps(&self) -> impl Iterator<Item = f64> + '_ {
        let jumps = |rows: &&[[f64; 2]]| rows[0][0] == rows[1][0] && rows[0][1] != rows[1][1];
        self.rows.windows(2).filter(jumps).map(|rows| rows[0][0]).filter(|depth| *depth > 0.0 && *depth < 1.0)
    }

    /// The depth above which a share of those grains lies that are between two depths; the nearest
    /// one between these where there are none.
    pub fn quantile_within(&self, [from, to]: [f64; 2], share: f64) -> f64 {
        let above = self.share_above(from);
        let below = self.share_above(to);
        self.quantile(above + (below - above) * share).clamp(from, to)
    }

    /// Share of the grains above a depth, 0 to 1.
    pub fn share_above(&self, depth: f64) -> f64 {
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

#[cfg(test)]
mod tests {
    use super::*;

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
}
