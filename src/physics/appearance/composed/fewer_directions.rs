//! What few directions leave open of scattered light: plates without the highest moment that the
//! nodes of their media resolve.

use super::flux::{Coherent, Hemisphere};
use super::plate::Plate;
use faer::Mat;
use num_complex::Complex64;

/// Difference of lateral wavenumbers that is rounding.
const SAME_SINE: f64 = 1e-9;

impl Hemisphere {
    /// Fluxes of all states with those of the nodes without their highest moment.
    fn without_highest_moment(&self) -> Mat<f64> {
        let nodes = self.ordinates.without_highest_moment();
        let mut filter = Mat::identity(self.states(), self.states());
        for (i, j) in (0..nodes.nrows()).flat_map(|i| (0..nodes.ncols()).map(move |j| (i, j))) {
            for p in 0..self.polarisations {
                filter[(self.state(i + 1, p), self.state(j + 1, p))] = nodes[(i, j)];
            }
        }
        filter
    }

    /// The states of the nodes with the shares that the mean wave of a side keeps of their light
    /// in a lobe, 0 reflected and 1 transmitted, which goes to the same states of `other`.
    fn straight(
        &self,
        other: &Self,
        amplitudes: &[Vec<[Complex64; 2]>],
        lobe: usize,
    ) -> impl Iterator<Item = (usize, f64)> {
        let sines = self.ordinates.sines.iter().zip(&other.ordinates.sines);
        let is_shared = |(own, other): (&f64, &f64)| (own - other).abs() < SAME_SINE;
        // a library keeps those of the first zones alone
        let nodes = sines.map(is_shared).zip(&amplitudes[1..]).enumerate().filter(|(_, (shared, _))| *shared);
        nodes.flat_map(move |(node, (_, means))| {
            let shares = means.iter().map(move |mean| mean[lobe].norm_sqr());
            shares.enumerate().map(move |(p, share)| (self.state(node + 1, p), share))
        })
    }
}

impl Plate {
    /// A plate whose scattered light lacks the highest moment that the directions of its media
    /// resolve. What goes straight on or is mirrored, `coherent`, is taken as it is. Every state
    /// sends out as much light as before.
    pub fn with_fewer_directions(&self, media: &[Hemisphere; 2], coherent: &Coherent) -> Self {
        let filters = media.each_ref().map(Hemisphere::without_highest_moment);
        let filtered = |m: &Mat<f64>, [from, to]: [usize; 2], lobe: usize| {
            let mut straight = Mat::zeros(m.nrows(), m.ncols());
            for (state, share) in media[from].straight(&media[to], &coherent[from], lobe) {
                straight[(state, state)] = share.min(m[(state, state)]);
            }
            &straight + &filters[to] * (m - &straight)
        };
        Self {
            reflection: [0, 1].map(|side| filtered(&self.reflection[side], [side, side], 0)),
            transmission: [0, 1].map(|side| filtered(&self.transmission[side], [side, 1 - side], 1)),
        }
    }
}
