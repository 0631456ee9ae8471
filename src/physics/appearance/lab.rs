//! CIE 1976 L*, a*, b*, and the colour difference CIEDE2000.

use std::f64::consts::{PI, TAU};

/// Below this ratio to white the cube root is replaced by its tangent: (24/116)³.
const LINEAR_BELOW: f64 = 0.008856451679035631;

/// L*, a*, b* of tristimulus values X, Y, Z beside those of white, all in the same unit (CIE
/// 15:2018, equations 8.3 to 8.11).
pub(super) fn lab_from_xyz(xyz: [f64; 3], white: [f64; 3]) -> [f64; 3] {
    let compressed = |t: f64| if t > LINEAR_BELOW { t.cbrt() } else { 841.0 / 108.0 * t + 16.0 / 116.0 };
    let x = compressed(xyz[0] / white[0]);
    let y = compressed(xyz[1] / white[1]);
    let z = compressed(xyz[2] / white[2]);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// ΔE₀₀ with k_L = k_C = k_H = 1 between two colours given as L*, a*, b* (G. Sharma, W. Wu and
/// E. N. Dalal, Color Res. Appl. 30 (2005) 21; equation numbers are theirs).
pub fn ciede2000(first: [f64; 3], second: [f64; 3]) -> f64 {
    let [l1, a1, b1] = first;
    let [l2, a2, b2] = second;

    // (2)–(7): chroma and hue with a* stretched for colours near grey
    let mean_ab = (length(a1, b1) + length(a2, b2)) / 2.0;
    let stretch = 1.0 + 0.5 * (1.0 - saturation(mean_ab));
    let chroma1 = length(a1 * stretch, b1);
    let chroma2 = length(a2 * stretch, b2);
    let hue1 = b1.atan2(a1 * stretch).rem_euclid(TAU);
    let hue2 = b2.atan2(a2 * stretch).rem_euclid(TAU);

    // (8)–(11): differences; that of hue the shorter way round
    let between = match hue2 - hue1 {
        angle if angle > PI => angle - TAU,
        angle if angle < -PI => angle + TAU,
        angle => angle,
    };
    let lightness_difference = l2 - l1;
    let chroma_difference = chroma2 - chroma1;
    let hue_difference = 2.0 * (chroma1 * chroma2).sqrt() * (between / 2.0).sin();

    // (12)–(14): means; without chroma the hue has no weight
    let lightness = (l1 + l2) / 2.0;
    let chroma = (chroma1 + chroma2) / 2.0;
    let hue = if (hue1 - hue2).abs() > PI {
        ((hue1 + hue2 + TAU) / 2.0).rem_euclid(TAU)
    } else {
        (hue1 + hue2) / 2.0
    };

    // (15)–(21): weights, and the rotation of the ellipses in the blue
    let by_hue = 1.0 - 0.17 * (hue - 30.0_f64.to_radians()).cos()
        + 0.24 * (2.0 * hue).cos()
        + 0.32 * (3.0 * hue + 6.0_f64.to_radians()).cos()
        - 0.20 * (4.0 * hue - 63.0_f64.to_radians()).cos();
    let from_middle = (lightness - 50.0).powi(2);
    let lightness_part = lightness_difference / (1.0 + (0.015 * from_middle) / (20.0 + from_middle).sqrt());
    let chroma_part = chroma_difference / (1.0 + 0.045 * chroma);
    let hue_part = hue_difference / (1.0 + 0.015 * chroma * by_hue);
    let angle = 30.0_f64.to_radians() * (-((hue.to_degrees() - 275.0) / 25.0).powi(2)).exp();
    let rotation = -(2.0 * saturation(chroma)) * (2.0 * angle).sin();

    // (22)
    (lightness_part.powi(2) + chroma_part.powi(2) + hue_part.powi(2) + rotation * chroma_part * hue_part)
        .sqrt()
}

fn length(a: f64, b: f64) -> f64 {
    (a * a + b * b).sqrt()
}

/// √(C⁷ / (C⁷ + 25⁷)): 0 for grey, 1 for strong colours.
fn saturation(chroma: f64) -> f64 {
    (chroma.powi(7) / (chroma.powi(7) + 25_f64.powi(7))).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// White, black, and half of white: L* = 116 ∛0.5 − 16; the linear part meets the cube root.
    #[test]
    fn lightness_runs_from_black_to_white() {
        let white = [95.0, 100.0, 109.0];
        assert_eq!(lab_from_xyz(white, white), [100.0, 0.0, 0.0]);
        assert!(lab_from_xyz([0.0; 3], white).iter().all(|x| x.abs() < 1e-12));
        let grey = lab_from_xyz(white.map(|x| 0.5 * x), white);
        assert!((grey[0] - (116.0 * 0.5_f64.cbrt() - 16.0)).abs() < 1e-12 && grey[1] == 0.0);
        let below = lab_from_xyz(white.map(|x| LINEAR_BELOW * (1.0 - 1e-12) * x), white);
        let above = lab_from_xyz(white.map(|x| LINEAR_BELOW * (1.0 + 1e-12) * x), white);
        assert!((below[0] - above[0]).abs() < 1e-9);
    }

    /// Pairs of Sharma, Wu and Dalal's table that tell wrong programs from right ones: hues on both
    /// sides of 0°, a hue difference of 180°, blue, grey. *Planted*: hues averaged the long way
    /// round.
    #[test]
    fn published_pairs_are_met() {
        let pairs = [
            ([50.0, 2.6772, -79.7751], [50.0, 0.0, -82.7485], 2.0425),
            ([50.0, 0.0, 0.0], [50.0, -1.0, 2.0], 2.3669),
            ([50.0, 2.49, -0.001], [50.0, -2.49, 0.001], 7.1792),
            ([50.0, 2.49, -0.001], [50.0, -2.49, 0.0011], 7.2195),
            ([50.0, 2.5, 0.0], [61.0, -5.0, 29.0], 22.8977),
            ([50.0, 2.5, 0.0], [50.0, 3.2972, 0.0], 1.0),
            ([61.2901, 3.7196, -5.3901], [61.4292, 2.2480, -4.9620], 1.8731),
            ([22.7233, 20.0904, -46.6940], [23.0331, 14.9730, -42.5619], 2.0373),
        ];
        for (first, second, published) in pairs {
            for difference in [ciede2000(first, second), ciede2000(second, first)] {
                assert!((difference - published).abs() < 5.1e-5, "{first:?} {second:?}: {difference}");
            }
        }
    }
}
