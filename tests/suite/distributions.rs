//! Distributions are per steradian of the medium that the light leaves into.

use inkwave::appearance::composed::flux::Hemisphere;
use inkwave::appearance::composed::ordinates::Ordinates;
use inkwave::evaluate::composed::distribution::projected_sr;
use std::f64::consts::PI;

/// The projected solid angles of all directions are ∫ cos θ dω = π, in any medium; those from which light reaches air
/// take 1/n² of it. *Planted*: the étendue, n² times as much.
#[test]
fn directions_share_the_hemisphere_of_their_medium() {
    for index in [1.0, 1.5] {
        let ordinates = Ordinates::new(index, &[], [6, 3]);
        let escapes: Vec<bool> = ordinates.sines.iter().map(|sine| *sine < 1.0).collect();
        let medium = Hemisphere { ordinates, polarisations: 1, oblique_deg: None };
        let all: Vec<f64> = (0..escapes.len()).map(|node| projected_sr(&medium, node)).collect();
        let whole: f64 = all.iter().sum();
        let cone: f64 = all.iter().zip(&escapes).filter(|(_, escapes)| **escapes).map(|(sr, _)| sr).sum();
        // Gauss's nodes integrate a constant exactly; rounding.
        assert!((whole - PI).abs() < 1e-12, "n = {index}: {whole}");
        assert!((cone - PI / (index * index)).abs() < 1e-12, "n = {index}: {cone}");
    }
}
