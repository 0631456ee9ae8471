//! Radiative transfer in an even medium, and the coefficients of transport that describe a slab.

use super::flux::Hemisphere;
use super::ordinates::Ordinates;
use super::plate::{Plate, total};
use crate::appearance::kubelka_munk::KubelkaMunk;
use crate::wave::grid::element::legendre;
use faer::Mat;

/// Nodes of a zone for the medium that a slab is compared with.
const NODES: usize = 8;
/// Optical thickness, over the cosine of the flattest direction, of the layer that doubling begins
/// with.
const THINNEST: f64 = 1e-6;
/// Most doublings of that layer: more would be a layer of astronomical optical thickness.
const MOST_DOUBLINGS: usize = 60;
/// Rounds of Newton's method, the step of its differences, and the last moves at which it ends.
const ROUNDS: usize = 12;
const STEP: f64 = 1e-4;
/// Accepted last move of the absorption over the extinction, and of g: far below any error bar.
const ACCEPTED: [f64; 2] = [1e-6, 1e-5];
/// Mean transmittance of the stack whose doubling gives K and S: light in it is diffuse.
const DIFFUSE: f64 = 0.2;
/// Most doublings towards it.
const DOUBLINGS: usize = 14;

/// Coefficients of radiative transfer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transport {
    /// Scattering coefficient k_s, 1/µm.
    pub scattering_per_um: f64,
    /// Absorption coefficient k_a, 1/µm.
    pub absorption_per_um: f64,
    /// Mean cosine g of the scattering angle.
    pub asymmetry: f64,
}

impl Transport {
    /// Transport mean free path 1/(k_s (1 − g)), µm.
    pub fn mean_free_path_um(&self) -> f64 {
        1.0 / (self.scattering_per_um * (1.0 - self.asymmetry))
    }

    /// A layer with Henyey–Greenstein scattering by doubling; states have one polarisation. `None`
    /// unless its optical thickness is a number that doubling reaches.
    pub fn layer(&self, medium: &Hemisphere, thickness_um: f64) -> Option<Plate> {
        let cosines = medium.cosines();
        let flattest = cosines.iter().copied().fold(1.0, f64::min);
        let depth = (self.scattering_per_um + self.absorption_per_um) * thickness_um / flattest;
        let doublings = (depth / THINNEST).max(1.0).log2().ceil();
        if !(depth.is_finite() && self.asymmetry.is_finite()) || doublings > MOST_DOUBLINGS as f64 {
            return None;
        }
        let doublings = doublings as usize;
        let mut layer = self.thin(medium, &cosines, thickness_um / (1_u64 << doublings) as f64);
        (0..doublings).for_each(|_| layer = layer.then(&layer));
        Some(layer)
    }

    /// Single scattering: F_ij = k_s d w_i p(μ_i, ±μ_j)/(4 n² μ_i μ_j), scaled to what column j
    /// loses. The nodes carry as many terms of p; the rest of the forward peak goes straight on
    /// (δ-M, W. J. Wiscombe, J. Atmos. Sci. 34 (1977) 1408).
    fn thin(&self, medium: &Hemisphere, cosines: &[f64], thickness_um: f64) -> Plate {
        let n = cosines.len();
        let weights = medium.weights();
        let terms = medium.ordinates.weights.iter().filter(|w| **w > 0.0).count();
        let polynomials: Vec<Vec<f64>> =
            cosines.iter().map(|&mu| (0..terms).map(|l| legendre(l, mu)).collect()).collect();
        let straight = self.asymmetry.powi(terms as i32);
        let scattering = self.scattering_per_um * (1.0 - straight);
        let moment = |l: usize| (self.asymmetry.powi(l as i32) - straight) / (1.0 - straight);
        let term = |l: usize, sign: f64| (2 * l + 1) as f64 * sign.powi(l as i32) * moment(l);
        let phase = |i: usize, j: usize, sign: f64| -> f64 {
            (0..terms).map(|l| term(l, sign) * polynomials[i][l] * polynomials[j][l]).sum()
        };
        let shape = |sign: f64| Mat::from_fn(n, n, |i, j| weights[i] / cosines[i] * phase(i, j, sign));
        let mut back = shape(-1.0);
        let mut onward = shape(1.0);
        for j in 0..n {
            let sum: f64 = (0..n).map(|i| back[(i, j)] + onward[(i, j)]).sum();
            let path = thickness_um / cosines[j];
            for i in 0..n {
                back[(i, j)] *= scattering * path / sum;
                onward[(i, j)] *= scattering * path / sum;
            }
            onward[(j, j)] += 1.0 - (scattering + self.absorption_per_um) * path;
        }
        Plate { reflection: [back.clone(), back], transmission: [onward.clone(), onward] }
    }

    /// The medium that has a slab's coherent transmittance at 0°, and its mean reflectance and
    /// absorptance in diffuse light. `None` where there is none: where the mean over few
    /// realisations leaves no coherent light, or where Newton's method does not settle.
    pub fn of_slab(slab: &Plate, medium: &Hemisphere, thickness_um: f64) -> Option<Self> {
        let extinction = extinction_per_um(slab, thickness_um)?;
        let [r, t] = means(slab, medium);
        let ordinates = Ordinates::for_transfer(medium.ordinates.index, [NODES; 2]);
        let plain = Hemisphere { ordinates, polarisations: 1, oblique_deg: None };
        let transport = |k: [f64; 2]| Self {
            scattering_per_um: extinction - k[0],
            absorption_per_um: k[0],
            asymmetry: k[1],
        };
        let miss = |k: [f64; 2]| {
            let [own_r, own_t] = means(&transport(k).layer(&plain, thickness_um)?, &plain);
            Some([own_r + own_t - r - t, own_r - r])
        };
        let mut k = [0.5 * (1.0 - r - t) / thickness_um, 0.5];
        let mut settled = false;
        for _ in 0..ROUNDS {
            let here = miss(k)?;
            let scale = STEP * extinction;
            let by_a = miss([k[0] + scale, k[1]])?;
            let by_g = miss([k[0], k[1] + STEP])?;
            let a = [0, 1].map(|i| (by_a[i] - here[i]) / scale);
            let g = [0, 1].map(|i| (by_g[i] - here[i]) / STEP);
            let determinant = a[0] * g[1] - a[1] * g[0];
            let moves =
                [here[0] * g[1] - here[1] * g[0], a[0] * here[1] - a[1] * here[0]].map(|x| x / determinant);
            k = [k[0] - moves[0], (k[1] - moves[1]).clamp(-0.95, 0.97)];
            settled = moves[0].abs() < ACCEPTED[0] * extinction && moves[1].abs() < ACCEPTED[1];
            if moves[0].abs() < 1e-9 * extinction && moves[1].abs() < 1e-8 {
                break;
            }
        }
        let found = transport(k);
        (settled && found.scattering_per_um > 0.0).then_some(found)
    }
}

/// Extinction of coherent light at 0° in a slab, 1/µm; `None` if nothing of it is left, or nothing
/// is lost, in the mean.
pub fn extinction_per_um(slab: &Plate, thickness_um: f64) -> Option<f64> {
    let passed = slab.transmission[0][(0, 0)];
    (passed > 0.0 && passed < 1.0).then(|| -passed.ln() / thickness_um)
}

/// Mean reflectance and transmittance of an element between equal media, in diffuse light.
pub fn means(element: &Plate, medium: &Hemisphere) -> [f64; 2] {
    let light = diffuse(medium);
    [&element.reflection[0], &element.transmission[0]].map(|m| total(&(m * &light)))
}

/// A unit flux of diffuse light.
pub fn diffuse(medium: &Hemisphere) -> Mat<f64> {
    let weights = medium.weights();
    let sum: f64 = weights.iter().sum();
    Mat::from_fn(weights.len(), 1, |i, _| weights[i] / sum)
}

/// K and S of a stack of slabs without surfaces: the two-flux layer by which a thick stack grows
/// when it is doubled, M(2L) M(L)⁻¹ with M = 1/T [[T² − R², R], [−R, 1]].
pub fn two_flux(slab: &Plate, medium: &Hemisphere, thickness_um: f64) -> Option<KubelkaMunk> {
    let mut stack = slab.clone();
    let mut thickness_um = thickness_um;
    for _ in 0..DOUBLINGS {
        if means(&stack, medium)[1] < DIFFUSE {
            break;
        }
        (stack, thickness_um) = (stack.then(&stack), 2.0 * thickness_um);
    }
    let [r1, t1] = means(&stack, medium);
    let [r2, t2] = means(&stack.then(&stack), medium);
    // the last column of the product, up to 1/(t1 t2)·t1
    let m2 = [[t2 * t2 - r2 * r2, r2], [-r2, 1.0]].map(|row| row.map(|x| x / t2));
    let inverse = [[1.0, -r1], [r1, t1 * t1 - r1 * r1]].map(|row| row.map(|x| x / t1));
    let entry = |i: usize, j: usize| m2[i][0] * inverse[0][j] + m2[i][1] * inverse[1][j];
    KubelkaMunk::from_layer(entry(0, 1) / entry(1, 1), 1.0 / entry(1, 1), thickness_um)
}

#[cfg(test)]
#[path = "transport_tests.rs"]
mod tests;
