//! Ranges of tables, and gaps between their rows too wide to interpolate without a warning.

/// Spectra usually have rows every 5 to 20 nm; a wider gap than this can hide an absorption band,
/// nm.
const WORTH_TELLING_NM: f64 = 50.0;

/// The widest gap between increasing `rows_nm` within a range of wavelengths, if wide enough to
/// report.
pub fn widest_gap_nm(rows_nm: &[f64], [from, to]: [f64; 2]) -> Option<[f64; 2]> {
    let gaps = rows_nm.windows(2).map(|pair| [pair[0], pair[1]]);
    widest(gaps.filter(|gap| gap[0] < to && gap[1] > from && gap[1] - gap[0] > WORTH_TELLING_NM))
}

/// The widest of some gaps.
pub(super) fn widest(gaps: impl Iterator<Item = [f64; 2]>) -> Option<[f64; 2]> {
    gaps.max_by(|a, b| (a[1] - a[0]).total_cmp(&(b[1] - b[0])))
}

/// The range common to all ranges.
pub(super) fn common(ranges: impl Iterator<Item = [f64; 2]>) -> [f64; 2] {
    ranges.fold([0.0, f64::INFINITY], |[lo, hi], [a, b]| [f64::max(lo, a), f64::min(hi, b)])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_widest_gap_inside_the_range_counts() {
        let rows = [300.0, 400.0, 450.0, 530.0, 590.0, 900.0];
        assert_eq!(widest_gap_nm(&rows, [400.0, 590.0]), Some([450.0, 530.0]));
        assert_eq!(widest_gap_nm(&rows, [400.0, 450.0]), None);
        assert_eq!(widest_gap_nm(&rows, [500.0, 500.0]), Some([450.0, 530.0]));
        assert_eq!(widest_gap_nm(&rows, [450.0, 450.0]), None, "a wavelength on a row");
        assert_eq!(widest_gap_nm(&[400.0, 700.0], [420.0, 680.0]), Some([400.0, 700.0]));
    }
}
