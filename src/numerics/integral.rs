//! Integrals of functions with features that are not known beforehand.

use std::collections::VecDeque;

/// How far the pieces of an integral are halved.
#[derive(Clone, Copy, Debug)]
pub struct Halving {
    /// Equal pieces that are begun with, at least 1.
    pub begun: usize,
    /// Most pieces: then it ends, whatever the rules say.
    pub most: usize,
    /// Difference of the two rules from which a piece is halved.
    pub error: f64,
}

/// ∫₀¹ of several functions, in equal pieces that are halved until two rules agree. `rules` are
/// nodes and weights on 0…1 of the integral, and of its check.
pub fn halved<const N: usize>(
    rules: &[Vec<(f64, f64)>; 2],
    halving: Halving,
    functions: &impl Fn(f64) -> [f64; N],
) -> [f64; N] {
    let mut sum = [0.0; N];
    let width = 1.0 / halving.begun as f64;
    let mut pieces: VecDeque<(f64, f64)> = (0..halving.begun).map(|k| (width * k as f64, width)).collect();
    let mut count = halving.begun;
    while let Some((from, width)) = pieces.pop_front() {
        let [mean, check] = rules.each_ref().map(|rule| {
            rule.iter().fold([0.0; N], |mut sum, (x, weight)| {
                let values = functions(from + width * x);
                sum.iter_mut().zip(values).for_each(|(sum, value)| *sum += width * weight * value);
                sum
            })
        });
        let error =
            mean.iter().zip(check).fold(0.0, |most: f64, (mean, check)| most.max((mean - check).abs()));
        if error > halving.error && count < halving.most {
            count += 1;
            let half = 0.5 * width;
            pieces.extend([(from, half), (from + half, half)]);
        } else {
            sum.iter_mut().zip(mean).for_each(|(sum, mean)| *sum += mean);
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A line of Lorentz's shape that both rules miss at first: its area is that of the arc
    /// tangent. It ends where it never settles. *Planted*: pieces that are not halved.
    #[test]
    fn narrow_lines_are_found_and_the_search_ends() {
        let rules = [vec![(0.25, 0.5), (0.75, 0.5)], vec![(0.5, 1.0)]];
        let (place, width) = (0.3, 0.01);
        let line = |x: f64| [width / ((x - place).powi(2) + width * width)];
        let area = ((1.0 - place) / width).atan() + (place / width).atan();
        let [found] = halved(&rules, Halving { begun: 1, most: 4096, error: 1e-9 }, &line);
        // both rules agree to 1e-9 in some thousand pieces
        assert!((found - area).abs() < 1e-5, "{found} {area}");
        let [rough] = halved(&rules, Halving { begun: 1, most: 1, error: 1e-9 }, &line);
        assert!((rough - area).abs() > 0.1, "{rough} {area}");
    }
}
