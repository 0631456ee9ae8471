//! Light between a print and its paper followed return by return, at all wavelengths together.

use super::halftone::Area;

/// A print on a paper of Donaldson's matrix.
pub struct Returns<'a> {
    /// \[wavelength\]\[kind of area\]
    pub areas: &'a [Vec<Area>],
    /// Shares of the kinds.
    pub shares: &'a [f64],
    /// Share of the light that is spread over all of them.
    pub spread: f64,
    /// What the paper sends up: \[to\]\[from\], the diagonal being what it reflects.
    pub paper: &'a [Vec<f64>],
    /// Power of the light at each wavelength.
    pub light: &'a [f64],
}

impl Returns<'_> {
    /// Radiance factors at all wavelengths after this many returns.
    pub fn factors(&self, count: usize) -> Vec<f64> {
        let wavelengths = self.light.len();
        let kinds = self.shares.len();
        let mut below: Vec<Vec<f64>> = (0..wavelengths)
            .map(|w| (0..kinds).map(|k| self.shares[k] * self.areas[w][k].entering * self.light[w]).collect())
            .collect();
        let mut seen = vec![0.0; wavelengths];
        for _ in 0..count {
            let mut next = vec![vec![0.0; kinds]; wavelengths];
            for w in 0..wavelengths {
                let sent =
                    |k: usize| (0..wavelengths).map(|from| self.paper[w][from] * below[from][k]).sum::<f64>();
                let sent: Vec<f64> = (0..kinds).map(sent).collect();
                let whole: f64 = sent.iter().sum();
                for k in 0..kinds {
                    let up = (1.0 - self.spread) * sent[k] + self.spread * self.shares[k] * whole;
                    seen[w] += self.areas[w][k].leaving * up / self.light[w];
                    next[w][k] = self.areas[w][k].back * up;
                }
            }
            below = next;
        }
        seen
    }
}

/// Factor of bare paper of this albedo behind a plane face of index n, lit at 45° and seen along the normal: Fresnel's
/// formulas by a dense sum, return by return (Saunderson 1942).
pub fn behind_face(albedo: f64, index: f64) -> f64 {
    let through = |sine: f64| {
        let cosine = (1.0 - sine * sine).sqrt();
        let inner = (1.0 - (sine / index).powi(2)).sqrt();
        let s = 4.0 * cosine * index * inner / (cosine + index * inner).powi(2);
        let p = 4.0 * cosine * index * inner / (index * cosine + inner).powi(2);
        0.5 * (s + p)
    };
    // in equal steps of sin², as diffuse light is
    let points = 400_000;
    let mean = (0..points).map(|i| through(((f64::from(i) + 0.5) / f64::from(points)).sqrt())).sum::<f64>();
    let back = 1.0 - mean / f64::from(points) / (index * index);
    let series: f64 = (0..3000).map(|k| albedo * (albedo * back).powi(k)).sum();
    through(0.5_f64.sqrt()) * through(0.0) / (index * index) * series
}
