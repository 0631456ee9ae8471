//! Functions of the wavelength for fitting spectra: cubic B-splines over a range, or one value per
//! listed wavelength.

/// Basis functions of the wavelength.
#[derive(Clone, Debug, PartialEq)]
pub enum SpectralBasis {
    /// One function per listed wavelength, nm, increasing.
    Listed(Vec<f64>),
    /// Uniform cubic B-splines on `intervals` pieces of a range in nm, for wavelengths that vary
    /// between realisations.
    Splines {
        /// First and last wavelength, nm.
        range_nm: [f64; 2],
        /// Number of pieces.
        intervals: usize,
    },
}

/// Maximum number of functions that are non-zero at a wavelength.
const MOST: usize = 4;

/// Indices and values of the non-zero basis functions at a wavelength: the weights of their
/// coefficients.
pub type Weights = Vec<(usize, f64)>;

/// Widest piece of splines where the samples suffice, nm: absorption edges of pigments are some
/// 40 nm wide, and splines with pieces of that width miss T there by 0.007.
const WIDEST_NM: f64 = 20.0;
/// Samples for each function of narrower pieces.
const SAMPLES: usize = 3;

impl SpectralBasis {
    /// Splines for `cells` that have `each` wavelengths, all of them different. Every cell alone
    /// determines `each` pieces; together they determine narrower ones.
    pub fn splines(range_nm: [f64; 2], each: usize, cells: usize) -> Self {
        let needed = ((range_nm[1] - range_nm[0]) / WIDEST_NM).ceil() as usize;
        let possible = (each * cells / SAMPLES).saturating_sub(MOST - 1);
        Self::Splines { range_nm, intervals: each.max(needed.min(possible)) }
    }

    /// Number of functions.
    pub fn count(&self) -> usize {
        match self {
            Self::Listed(list) => list.len(),
            Self::Splines { intervals, .. } => intervals + MOST - 1,
        }
    }

    /// Values at a wavelength in nm. Splines are continued beyond their range by the outermost
    /// pieces; a list uses its nearest entry.
    pub fn weights(&self, nm: f64) -> Weights {
        match self {
            Self::Listed(list) => vec![(nearest(list.iter().copied(), nm), 1.0)],
            Self::Splines { range_nm: [from, to], intervals } => {
                let place = (nm - from) / (to - from) * *intervals as f64;
                let piece = (place.floor().max(0.0) as usize).min(intervals - 1);
                let values = cubic(place - piece as f64).into_iter().enumerate();
                values.map(|(k, value)| (piece + k, value)).collect()
            }
        }
    }

    /// Σ weight · coefficient.
    pub fn at(weights: &Weights, coefficients: impl Fn(usize) -> f64) -> f64 {
        weights.iter().map(|&(i, weight)| weight * coefficients(i)).sum()
    }

    /// Second differences of neighbouring coefficients, to be kept small (Eilers and Marx 1996):
    /// rows of (function, factor).
    pub fn roughness(&self) -> Vec<[(usize, f64); 3]> {
        let count = if let Self::Splines { .. } = self { self.count() } else { 0 };
        (2..count).map(|i| [(i - 2, 1.0), (i - 1, -2.0), (i, 1.0)]).collect()
    }
}

/// Place of the wavelength nearest to `nm`, the first of several.
pub(super) fn nearest(wavelengths_nm: impl IntoIterator<Item = f64>, nm: f64) -> usize {
    let distances = wavelengths_nm.into_iter().map(|listed| (listed - nm).abs()).enumerate();
    distances.min_by(|(_, a), (_, b)| a.total_cmp(b)).map_or(0, |(place, _)| place)
}

/// The four cubic B-splines on a piece, t = 0…1 along it.
fn cubic(t: f64) -> [f64; MOST] {
    let s = 1.0 - t;
    let inner = |t: f64, s: f64| (1.0 + 3.0 * t * (1.0 + t * s)) / 6.0;
    [s.powi(3) / 6.0, inner(s, t), inner(t, s), t.powi(3) / 6.0]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn splines_share_unity_and_reproduce_lines() {
        let basis = SpectralBasis::Splines { range_nm: [400.0, 700.0], intervals: 6 };
        assert_eq!(basis.count(), 9);
        for nm in [400.0, 401.3, 450.0, 612.0, 700.0] {
            let weights = basis.weights(nm);
            let sum: f64 = weights.iter().map(|s| s.1).sum();
            // Coefficients at the Greville points 350, 400, … reproduce the line λ itself.
            let line = SpectralBasis::at(&weights, |i| 350.0 + 50.0 * i as f64);
            assert!((sum - 1.0).abs() < 1e-14 && (line - nm).abs() < 1e-11, "{nm}: {sum} {line}");
        }
        for row in basis.roughness() {
            let line: f64 = row.iter().map(|&(i, f)| f * i as f64).sum();
            assert_eq!(line, 0.0);
        }
    }

    /// Eight wavelengths a cell: four cells have 32 samples, too few for the 18 functions of 20 nm,
    /// eight have 64.
    #[test]
    fn pieces_narrow_as_cells_add_wavelengths() {
        let pieces = |each, cells| SpectralBasis::splines([400.0, 700.0], each, cells).count() + 1 - MOST;
        assert_eq!([pieces(8, 1), pieces(8, 4), pieces(8, 8), pieces(8, 100)], [8, 8, 15, 15]);
        assert_eq!([pieces(15, 6), pieces(40, 2)], [15, 40]);
    }

    #[test]
    fn lists_answer_with_their_own_entry() {
        let basis = SpectralBasis::Listed(vec![450.0, 550.0]);
        assert_eq!(basis.weights(550.0), [(1, 1.0)]);
        assert!(basis.roughness().is_empty());
    }
}
