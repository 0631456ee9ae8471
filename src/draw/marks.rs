//! Markers of points, and the unbroken parts of a line.

/// Shapes that [`marker`] tells apart.
pub(super) const MARKERS: usize = 7;

/// Disc, triangle, square, diamond, triangle on its tip, plus and hourglass, in pixels around the point.
pub(super) fn marker(k: usize) -> Vec<(i32, i32)> {
    match k % MARKERS {
        0 => vec![(-1, -4), (1, -4), (4, -1), (4, 1), (1, 4), (-1, 4), (-4, 1), (-4, -1)],
        1 => vec![(0, -5), (5, 4), (-5, 4)],
        2 => vec![(-4, -4), (4, -4), (4, 4), (-4, 4)],
        3 => vec![(0, -6), (6, 0), (0, 6), (-6, 0)],
        4 => vec![(0, 5), (5, -4), (-5, -4)],
        5 => PLUS.to_vec(),
        _ => vec![(-4, -5), (4, -5), (0, 0), (4, 5), (-4, 5), (0, 0)],
    }
}

const PLUS: [(i32, i32); 12] = [
    (-1, -5),
    (1, -5),
    (1, -1),
    (5, -1),
    (5, 1),
    (1, 1),
    (1, 5),
    (-1, 5),
    (-1, 1),
    (-5, 1),
    (-5, -1),
    (-1, -1),
];

/// The parts of a line between missing points; `missing` are the abscissae without a value.
pub(super) fn unbroken<P: Clone>(points: &[P], x: impl Fn(&P) -> f64, missing: &[f64]) -> Vec<Vec<P>> {
    let apart = |a: &P, b: &P| {
        let (low, high) = (x(a).min(x(b)), x(a).max(x(b)));
        missing.iter().any(|m| *m > low && *m < high)
    };
    points.chunk_by(|a, b| !apart(a, b)).map(<[P]>::to_vec).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_break_where_a_point_is_missing() {
        let parts = unbroken(&[1.0, 2.0, 4.0, 5.0], |x| *x, &[3.0, 6.0]);
        assert_eq!(parts, [[1.0, 2.0], [4.0, 5.0]]);
        assert_eq!(unbroken(&[5.0, 4.0, 2.0], |x| *x, &[3.0]), [vec![5.0, 4.0], vec![2.0]]);
        assert_eq!(unbroken(&[1.0, 2.0], |x| *x, &[2.0]), [[1.0, 2.0]]);
    }

    #[test]
    fn markers_differ() {
        let all: std::collections::HashSet<_> = (0..MARKERS).map(marker).collect();
        assert_eq!(all.len(), MARKERS);
    }
}
