//! The numbers of a portion as a library writes them.
//!
//! Numbers of one portion at one wavelength follow one another in this order, with m states in
//! front, n behind and d + 1 known directions (0° and the joint's nodes):
//!
//! ```text
//! R from in front (m × m), R from behind (n × n), T onward (n × m), T back (m × n), row by row
//! amplitudes [side][0 … d][polarisation][reflected, transmitted], each as real and imaginary part
//! ```

use super::super::level::{KeptStates, PortionStates};
use super::{JointMedium, Library, LibraryReplicate, LibraryStates};
use crate::appearance::composed::flux::{Coherent, Hemisphere};
use crate::appearance::composed::plate::Plate;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use faer::Mat;
use num_complex::Complex64;

/// Largest whole number that a difference of a replicate is written as.
const FULL_SCALE: f64 = 32_767.0;

impl JointMedium {
    /// Directions whose amplitudes are kept: 0° and the joint's nodes, which media of other indices
    /// have at other angles, or beyond their own.
    fn known_directions(&self) -> usize {
        1 + self.sines.len()
    }
}

impl Library {
    /// The numbers of a portion at one wavelength; `None` if they are incomplete or not finite.
    pub(super) fn unpacked(&self, packed: &LibraryStates) -> Option<KeptStates> {
        let [before, behind] = packed.between;
        let media = [self.joint.medium(before), self.joint.medium(behind)];
        if media[0].states() != packed.states[0] || media[1].states() != packed.states[1] {
            return None;
        }
        let mean = floats(&packed.mean)?;
        let known = self.joint.known_directions();
        let replicate = |replicate: &LibraryReplicate| {
            let differences = whole_numbers(&replicate.differences)?;
            let same = differences.len() == mean.len();
            let moved: Vec<f64> =
                mean.iter().zip(&differences).map(|(x, d)| x + replicate.unit * f64::from(*d)).collect();
            same.then(|| states_of(&moved, &media, known))?
        };
        let replicates = packed.replicates.iter().map(replicate).collect::<Option<Vec<_>>>()?;
        Some(KeptStates { mean: states_of(&mean, &media, known)?, media, replicates })
    }
}

/// The numbers of one portion in a row.
fn listed(states: &PortionStates, known: usize) -> Vec<f64> {
    let mut all = Vec::new();
    let matrices = states.plate.reflection.iter().chain(&states.plate.transmission);
    for matrix in matrices {
        for i in 0..matrix.nrows() {
            all.extend((0..matrix.ncols()).map(|j| matrix[(i, j)]));
        }
    }
    for side in &states.coherent {
        for lobes in side.iter().take(known).flatten() {
            all.extend(lobes.iter().flat_map(|amplitude| [amplitude.re, amplitude.im]));
        }
        // a medium that is nearly air has none beyond it
        let polarisations = side.first().map_or(0, Vec::len);
        all.resize(all.len() + 4 * polarisations * known.saturating_sub(side.len()), 0.0);
    }
    all
}

/// The other way round; `None` for another number of numbers, or for some that are not finite.
fn states_of(numbers: &[f64], media: &[Hemisphere; 2], known: usize) -> Option<PortionStates> {
    let [m, n] = [media[0].states(), media[1].states()];
    let polarisations = media[0].polarisations;
    let whole = m * m + n * n + 2 * m * n + 2 * known * polarisations * 4;
    if numbers.len() != whole || !numbers.iter().all(|x| x.is_finite()) {
        return None;
    }
    let matrix = |from: usize, rows: usize, columns: usize| {
        Mat::from_fn(rows, columns, |i, j| numbers[from + i * columns + j])
    };
    let onward = m * m + n * n;
    let plate = Plate {
        reflection: [matrix(0, m, m), matrix(m * m, n, n)],
        transmission: [matrix(onward, n, m), matrix(onward + m * n, m, n)],
    };
    let first = onward + 2 * m * n;
    let amplitude = |place: usize| Complex64::new(numbers[first + 2 * place], numbers[first + 2 * place + 1]);
    let side = |side: usize| {
        let direction = |d: usize| {
            let lobes = |p: usize| {
                let place = ((side * known + d) * polarisations + p) * 2;
                [amplitude(place), amplitude(place + 1)]
            };
            (0..polarisations).map(lobes).collect()
        };
        (0..known).map(direction).collect()
    };
    let coherent: Coherent = [side(0), side(1)];
    Some(PortionStates { plate, coherent })
}

/// What a library writes of a portion at one wavelength.
pub(super) fn packed_states(kept: &KeptStates, joint: &JointMedium) -> LibraryStates {
    let known = joint.known_directions();
    let mean = listed(&kept.mean, known);
    let replicate = |states: &PortionStates| {
        let differences: Vec<f64> = listed(states, known).iter().zip(&mean).map(|(a, b)| a - b).collect();
        let largest = differences.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        let unit = if largest > 0.0 { largest / FULL_SCALE } else { 1.0 };
        let bytes: Vec<u8> =
            differences.iter().flat_map(|x| ((x / unit).round() as i16).to_le_bytes()).collect();
        LibraryReplicate { unit, differences: STANDARD.encode(bytes) }
    };
    let bytes: Vec<u8> = mean.iter().flat_map(|x| x.to_le_bytes()).collect();
    LibraryStates {
        between: [kept.media[0].ordinates.index, kept.media[1].ordinates.index],
        states: [kept.media[0].states(), kept.media[1].states()],
        mean: STANDARD.encode(bytes),
        replicates: kept.replicates.iter().map(replicate).collect(),
    }
}

fn floats(text: &str) -> Option<Vec<f64>> {
    let bytes = STANDARD.decode(text).ok()?;
    let (whole, rest) = bytes.as_chunks::<8>();
    rest.is_empty().then(|| whole.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect())
}

fn whole_numbers(text: &str) -> Option<Vec<i16>> {
    let bytes = STANDARD.decode(text).ok()?;
    let (whole, rest) = bytes.as_chunks::<2>();
    rest.is_empty().then(|| whole.iter().map(|bytes| i16::from_le_bytes(*bytes)).collect())
}
