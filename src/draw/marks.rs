//! Markers of points.

/// Number of different markers.
const MARKERS: usize = 7;

/// Outline of marker `k` in pixels around the point: disc, triangle, square, diamond, triangle on
/// its tip, plus and hourglass.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn markers_differ() {
        let all: std::collections::HashSet<_> = (0..MARKERS).map(marker).collect();
        assert_eq!(all.len(), MARKERS);
    }
}
