//! The random draws of each realisation.

use super::study::Study;
use super::variation::{AREA, ASPECT, CellRule, Draw, LightRule, ThicknessShare, between, thickness_um};
use crate::ink::{PackingRequest, PigmentGrains, SizeDistribution};
use crate::numerics::Sequence;

/// With several pigments, whole grains are sought within this fraction of the drawn area.
const AREA_SEARCH: f64 = 0.04;
/// Maximum number of grain numbers tried on either side of the one drawn.
const MOST_TRIED: usize = 2000;
/// Steps by this fraction of the circle cover it evenly: (√5 − 1)/2.
const GOLDEN: f64 = 0.618_033_988_749_894_9;
/// Number of coordinates of the sequence.
const COORDINATES: usize = 6;

/// Rotation of a varied cell at its `j`-th wavelength.
fn turned_deg(j: usize) -> f64 {
    360.0 * (j as f64 * GOLDEN).fract()
}

impl Study {
    /// The draws of realisation `r`.
    pub fn draw(&self, r: usize) -> Draw {
        let [area, aspect, azimuth, direction, wavelength, thickness] =
            Sequence::<COORDINATES>::new(self.packing.seed).point(if self.pairs_cells() { r / 2 } else { r });
        let layer = &self.layer;
        let thickness_um = thickness_um(layer.thickness_um, self.variation.thickness_std_um, thickness);
        let (period_um, turn) = match self.variation.cell {
            CellRule::Fixed => (layer.period_um, 0.0),
            CellRule::Varied => {
                let [x, y] = layer.period_um;
                let area = self.whole_grains(between(AREA, area) * x * y, thickness_um);
                let side = (area * between(ASPECT, aspect) * x / y).sqrt();
                ([side, area / side], 360.0 * azimuth)
            }
        };
        Draw { period_um, thickness_um, azimuth_deg: self.angles.azimuth_deg + turn, direction, wavelength }
    }

    /// Azimuth of the planes of incidence and position within the strata of directions
    /// ([`Draw::azimuth_deg`], [`Draw::direction`]) of a realisation at its `j`-th wavelength.
    /// Varied cells are rotated between wavelengths, so that no two of them share a Bloch vector
    /// and their errors are as independent as one packing allows.
    pub(super) fn turn(&self, draw: &Draw, j: usize) -> (f64, f64) {
        if self.variation.cell == CellRule::Fixed {
            return (draw.azimuth_deg, draw.direction);
        }
        (draw.azimuth_deg + turned_deg(j), (draw.direction + j as f64 * GOLDEN).fract())
    }

    /// Wavelengths of a realisation, nm, increasing.
    pub fn solved_wavelengths_nm(&self, draw: &Draw) -> Vec<f64> {
        match self.variation.light {
            LightRule::Listed => self.wavelengths_nm.clone(),
            LightRule::Shifted { range_nm: [from, to], strata } => {
                let width = (to - from) / strata as f64;
                (0..strata).map(|j| from + (j as f64 + draw.wavelength) * width).collect()
            }
        }
    }

    /// Number of wavelengths of a realisation.
    pub fn solved_wavelengths(&self) -> usize {
        match self.variation.light {
            LightRule::Listed => self.wavelengths_nm.len(),
            LightRule::Shifted { strata, .. } => strata,
        }
    }

    /// Thicknesses of the layer with their shares of its area; only one if it is even.
    pub fn thicknesses(&self) -> Vec<ThicknessShare> {
        let mean_um = self.layer.thickness_um;
        let std_um = self.variation.thickness_std_um;
        let shortest_nm = self.wavelengths_nm.iter().copied().fold(f64::INFINITY, f64::min);
        if std_um > 0.0 {
            ThicknessShare::uneven(mean_um, std_um, shortest_nm)
        } else {
            ThicknessShare::even(mean_um)
        }
    }

    /// Dry thickness of the layer that holds each pigment, µm.
    fn dry_um_of_pigments(&self, thickness_um: f64) -> Vec<f64> {
        let depth_um = |request: &PackingRequest| request.relief.map_or(0.0, |relief| relief.depth_um);
        let depths_um: Vec<f64> = if self.stack.is_empty() {
            vec![depth_um(&self.packing); self.pigments.len()]
        } else {
            let layers = self.packing.layers.iter().zip(&self.stack);
            layers.flat_map(|(layer, of)| vec![depth_um(&layer.request); of.pigments]).collect()
        };
        let thicknesses_um = self.thicknesses_of_pigments_um(thickness_um);
        thicknesses_um.into_iter().zip(depths_um).map(|(um, depth_um)| um - depth_um).collect()
    }

    /// The area nearest to `area` (µm²) in which whole grains give the requested volume fractions.
    fn whole_grains(&self, area: f64, thickness_um: f64) -> f64 {
        let dry_um = self.dry_um_of_pigments(thickness_um);
        let in_layers = self.pigments.iter().zip(dry_um);
        let areas = in_layers.filter_map(|(p, dry_um)| area_of_a_grain(&p.grains, dry_um));
        let quanta: Vec<f64> = areas.collect();
        let Some(largest) = quanta.iter().copied().reduce(f64::max) else { return area };
        let grains = |share: f64| (area * share / largest).round().max(1.0) as usize;
        let nearest = grains(1.0);
        let distance = |n: usize| (n as f64 - nearest as f64).abs();
        let key = |&n: &usize| (1e9 * largest_remainder(n, largest, &quanta)).round() as u64;
        // with very many grains the nearest numbers suffice
        let fewest = grains(1.0 - AREA_SEARCH).max(nearest.saturating_sub(MOST_TRIED));
        let candidates = fewest..=grains(1.0 + AREA_SEARCH).min(nearest.saturating_add(MOST_TRIED));
        let best = candidates.min_by(|a, b| key(a).cmp(&key(b)).then(distance(*a).total_cmp(&distance(*b))));
        best.unwrap_or(nearest) as f64 * largest
    }
}

/// Largest relative deviation of the pigments' grain numbers from integers, in an area of `n` times
/// `largest`.
fn largest_remainder(n: usize, largest: f64, quanta: &[f64]) -> f64 {
    let of = |quantum: &f64| {
        let count = n as f64 * largest / quantum;
        (count - count.round()).abs() / count
    };
    quanta.iter().map(of).fold(0.0, f64::max)
}

/// Area of the cell per grain of a pigment with equal grains, µm².
fn area_of_a_grain(grains: &PigmentGrains, height_um: f64) -> Option<f64> {
    let SizeDistribution::Constant { value_nm, .. } = grains.size else { return None };
    let template = grains.shape.template();
    let volume = template.volume.um3 * grains.size.radius_um(value_nm, &template).powi(3);
    Some(volume / (grains.volume_fraction * height_um))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The golden angle, 137.507764°, the other way round.
    #[test]
    fn cells_turn_by_the_golden_angle() {
        let golden = 137.507_764_05;
        for (j, want) in
            [0.0, 360.0 - golden, 360.0 - 2.0 * golden, 720.0 - 3.0 * golden].into_iter().enumerate()
        {
            assert!((turned_deg(j) - want).abs() < 1e-6, "{j}: {}", turned_deg(j));
        }
    }
}
