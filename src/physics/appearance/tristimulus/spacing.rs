//! What a spectrum may do between the wavelengths of a grid: what that does to a colour.

use super::{Colorimeter, Interpolation, distributed, integrand, mean_step};

/// Distance of wavelengths from which every rule of integration counts as a guess, nm; at smaller
/// ones their differences are weighted by the order of the rule. *Measured* on 200 random spectra
/// like those of prints (test `coarse_sums_keep_their_colour`).
const GUESSED_NM: f64 = 80.0;
/// Distance of wavelengths from which linear interpolation counts as a guess, nm.
const LINEAR_NM: f64 = 40.0;
/// Share of a spectrum by which it may bend between wavelengths 100 nm apart, unseen, …
const BEND: f64 = 0.2;
/// … in proportion to this power of their distance, …
const BEND_POWER: i32 = 4;
/// … up to this share.
const MOST_BEND: f64 = 0.4;
/// A guide with steps below this share of the sum's is summed by its own.
const CLOSER: f64 = 0.9;

/// A spectrum similar to the one of interest that is also known between the wavelengths of the
/// grid: of a layer of grains, that of its coherent film or of any formula with the materials'
/// indices.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Guide {
    /// Its values at the wavelengths of the colorimeter.
    pub on_grid: Vec<f64>,
    /// Wavelengths from the first to the last one of the grid, nm, rising; every 5 nm or closer.
    pub fine_nm: Vec<f64>,
    /// Its values there.
    pub fine: Vec<f64>,
}

impl Colorimeter {
    /// Standard errors of Lab due to the wavelengths between those of the grid, each an independent
    /// shift: add them in squares to a covariance. For spectra that are known at the grid's
    /// wavelengths alone; one that is summed every 5 nm needs no such error.
    ///
    /// `values` are the spectrum on the grid, `xyz` its tristimulus values. The parts are
    /// differences between rules of integration (cubic, linear, every second wavelength), and what
    /// a spectrum may bend unseen between wavelengths more than some 60 nm apart. With a `guide`
    /// they concern the difference from it only, and what the grid misses of the guide is one more
    /// part: an absorption band between two wavelengths is then seen, as far as the guide has it.
    /// Without a guide a band narrower than the distance of the wavelengths can stay unseen.
    ///
    /// ```
    /// use inkwave_physics::appearance::tristimulus::{Colorimeter, Guide};
    /// // a band at 490 nm, between wavelengths 60 nm apart
    /// let band = |nm: &f64| 0.8 - 0.5 * (-0.5 * ((nm - 490.0) / 12.0).powi(2)).exp();
    /// let nm: Vec<f64> = (0..6).map(|i| 400.0 + 60.0 * f64::from(i)).collect();
    /// let fine_nm: Vec<f64> = (0..61).map(|i| 400.0 + 5.0 * f64::from(i)).collect();
    /// let values: Vec<f64> = nm.iter().map(band).collect();
    /// let fine = fine_nm.iter().map(band).collect();
    /// let guide = Guide { on_grid: values.clone(), fine, fine_nm };
    /// let meter = Colorimeter::new(&nm)?;
    /// let xyz = meter.xyz(&values)?;
    /// let error = |guide| {
    ///     let shifts = meter.spacing(&values, xyz, guide);
    ///     shifts.iter().flatten().map(|x| x * x).sum::<f64>().sqrt()
    /// };
    /// // unseen without a guide that has it
    /// assert!(error(Some(&guide)) > 5.0 && error(Some(&guide)) > 2.0 * error(None));
    /// # Ok::<(), inkwave_physics::appearance::viewing::ColourError>(())
    /// ```
    pub fn spacing(&self, values: &[f64], xyz: [f64; 3], guide: Option<&Guide>) -> Vec<[f64; 3]> {
        let parts = self.spacing_xyz(values, guide).into_iter();
        // no sum of reflectances is negative
        parts.map(|by| self.lab_moved(xyz, std::array::from_fn(|c| by[c].max(-xyz[c])))).collect()
    }

    /// Standard error of Y due to the wavelengths between those of the grid; see
    /// [`Colorimeter::spacing`].
    pub fn spacing_luminance(&self, values: &[f64], guide: Option<&Guide>) -> f64 {
        self.spacing_xyz(values, guide).iter().fold(0.0, |sum, by| sum.hypot(by[1]))
    }

    /// [`Colorimeter::spacing`] of a spectrum with fringes, which are those of the first of these
    /// films, and what the grid misses of them; the second one is a quarter of a fringe away.
    pub fn spacing_of_films(
        &self,
        values: &[f64],
        xyz: [f64; 3],
        films: Option<&[Guide; 2]>,
    ) -> Vec<[f64; 3]> {
        let mut shifts = self.spacing(values, xyz, films.map(|[film, _]| film));
        shifts.extend(films.map(|[_, quarter]| self.missed(xyz, quarter)));
        shifts
    }

    /// Shift of Lab by what the grid misses of a spectrum that is known between its wavelengths.
    fn missed(&self, xyz: [f64; 3], guide: &Guide) -> [f64; 3] {
        let by = self.missed_xyz(guide);
        self.lab_moved(xyz, std::array::from_fn(|c| by[c].max(-xyz[c])))
    }

    /// Shift of Y by the same.
    pub fn missed_luminance(&self, guide: &Guide) -> f64 {
        self.missed_xyz(guide)[1]
    }

    fn missed_xyz(&self, guide: &Guide) -> [f64; 3] {
        let (step_nm, light) = self.scaled_light();
        let known = self.of_guide(guide, &light, step_nm);
        difference(known, of_rule(&self.wavelengths_nm, &guide.on_grid, &light, Interpolation::Cubic))
    }

    /// The step of the sum, nm, and the weights of its places.
    fn scaled_light(&self) -> (f64, Vec<(f64, [f64; 3])>) {
        let (step_nm, light) = integrand(&self.wavelengths_nm, &self.viewing, &self.viewing);
        let scale = self.scale_per_nm * step_nm;
        (step_nm, light.into_iter().map(|(nm, row)| (nm, row.map(|w| scale * w))).collect())
    }

    /// Independent errors of X, Y, Z.
    fn spacing_xyz(&self, values: &[f64], guide: Option<&Guide>) -> Vec<[f64; 3]> {
        let grid = &self.wavelengths_nm;
        let (_, light) = self.scaled_light();
        let unknown: Vec<f64> = match guide {
            Some(guide) => values.iter().zip(&guide.on_grid).map(|(value, known)| value - known).collect(),
            None => values.to_vec(),
        };
        let sum = |nodes: &[usize], rule: Interpolation| {
            let nm: Vec<f64> = nodes.iter().map(|&j| grid[j]).collect();
            let values: Vec<f64> = nodes.iter().map(|&j| unknown[j]).collect();
            of_rule(&nm, &values, &light, rule)
        };
        let last = grid.len() - 1;
        let all: Vec<usize> = (0..=last).collect();
        let best = sum(&all, Interpolation::Cubic);
        let widest = grid.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
        let mut parts = vec![scaled(
            (widest / LINEAR_NM).powi(2).min(1.0),
            difference(sum(&all, Interpolation::Linear), best),
        )];
        for parity in [0, 1] {
            // every second wavelength, and both ends
            let half: Vec<usize> =
                all.iter().copied().filter(|&j| j % 2 == parity || j == 0 || j == last).collect();
            let weight = (widest / GUESSED_NM).powf(1.5).min(1.0);
            parts.push(scaled(weight, difference(sum(&half, Interpolation::Cubic), best)));
        }
        let largest = unknown.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
        parts.extend(grid.windows(2).map(|pair| scaled(largest, bend([pair[0], pair[1]], &light))));
        parts.extend(guide.map(|guide| self.missed_xyz(guide)));
        parts
    }
}

impl Colorimeter {
    /// X, Y, Z of a guide; summed as closely as it is known where that is closer than the light.
    fn of_guide(&self, guide: &Guide, light: &[(f64, [f64; 3])], step_nm: f64) -> [f64; 3] {
        let closer = mean_step(&guide.fine_nm) < CLOSER * step_nm;
        let own = closer.then(|| Self::under(&guide.fine_nm, &self.viewing).ok()?.xyz(&guide.fine).ok());
        own.flatten().unwrap_or_else(|| of_rule(&guide.fine_nm, &guide.fine, light, Interpolation::Cubic))
    }
}

/// X, Y, Z of a spectrum that is interpolated by a rule.
fn of_rule(grid: &[f64], values: &[f64], light: &[(f64, [f64; 3])], rule: Interpolation) -> [f64; 3] {
    let weights = distributed(grid, light.iter().copied(), rule);
    super::weighted_sum(&weights, values)
}

/// X, Y, Z of an arc between two wavelengths, as high as a spectrum of 1 may bend there.
fn bend([from, to]: [f64; 2], light: &[(f64, [f64; 3])]) -> [f64; 3] {
    let height = (BEND * ((to - from) / 100.0).powi(BEND_POWER)).min(MOST_BEND);
    let inside = light.iter().filter(|(nm, _)| (from..to).contains(nm));
    inside.fold([0.0; 3], |sum, (nm, row)| {
        let t = (nm - from) / (to - from);
        std::array::from_fn(|c| sum[c] + height * 4.0 * t * (1.0 - t) * row[c])
    })
}

fn difference(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|c| a[c] - b[c])
}

fn scaled(by: f64, xyz: [f64; 3]) -> [f64; 3] {
    xyz.map(|x| by * x)
}

#[cfg(test)]
#[path = "spacing_tests.rs"]
mod tests;
