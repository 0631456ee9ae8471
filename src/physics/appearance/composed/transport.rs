//! Radiative transfer in an even medium, and the coefficients of transport that describe a slab.

use super::flux::Hemisphere;
use super::ordinates::Ordinates;
use super::plate::{Plate, bounced, total};
use crate::appearance::kubelka_munk::KubelkaMunk;
use crate::numerics::dense::MatrixEntry;
use crate::numerics::root::RootSearch;
use crate::wave::grid::element::legendre;
use faer::Mat;

/// Nodes of a zone for the medium that a slab is compared with.
const NODES: usize = 8;
/// Optical thickness, over the cosine of the flattest direction, of the layer that doubling begins
/// with: Z in [`Transport::thin`] is at most a quarter of its square, of which g misses Z³/1575.
const THINNEST: f64 = 0.2;
/// Most doublings of that layer: more would be a layer of astronomical optical thickness.
const MOST_DOUBLINGS: usize = 60;
/// How the absorption over the extinction, and g, are looked for.
const SEARCH: RootSearch = RootSearch {
    difference: 1e-4,
    bounds: [[f64::NEG_INFINITY, f64::INFINITY], [-0.95, 0.97]],
    enough: [1e-9, 1e-8],
    rounds: 40,
};
/// Accepted last steps: far below any error bar.
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
        let mut layer = self.thin(medium, &cosines, thickness_um / 2.0_f64.powf(doublings));
        (0..doublings as usize).for_each(|_| layer = layer.doubled());
        let EvenLayer { reflection, transmission } = layer;
        Some(Plate {
            reflection: [reflection.clone(), reflection],
            transmission: [transmission.clone(), transmission],
        })
    }

    /// A thin layer. With F₊′ = −A F₊ + B F₋, light that comes from both sides alike (+) or with
    /// opposite signs (−) meets C± = R ± T, of which
    ///
    /// ```text
    /// (1 − C₊)/(1 + C₊) = N g(Z)      (1 + C₋)/(1 − C₋) = g(Z) M      Z = M N
    /// M = (A + B) d/2      N = (A − B) d/2      g(Z) = tanh √Z/√Z ≈ (15 + Z)/(15 + 6 Z)
    /// ```
    ///
    /// so that nothing is lost where the medium loses nothing.
    fn thin(&self, medium: &Hemisphere, cosines: &[f64], thickness_um: f64) -> EvenLayer {
        let [back, lost] = self.scattered(medium, cosines);
        let half = |sign: f64| faer::Scale(0.5 * thickness_um) * (&lost + faer::Scale(sign) * &back);
        let (m, n) = (half(1.0), half(-1.0));
        let z = &m * &n;
        let g = solved(&plus(15.0, 6.0, &z), &plus(15.0, 1.0, &z));
        // x/(1 + x)
        let lost_of_half = |x: Mat<f64>| solved(&plus(1.0, 1.0, &x), &x);
        let alike = lost_of_half(&n * &g);
        let opposite = lost_of_half(g * m);
        let onward = Mat::<f64>::identity(z.nrows(), z.nrows()) - &opposite - &alike;
        EvenLayer { reflection: opposite - alike, transmission: onward }
    }

    /// What light of every state loses, and what of it goes back, per µm: F_ij = k_s w_i
    /// p(μ_i, ±μ_j)/(4 n² μ_i μ_j), scaled to what column j loses. The nodes carry as many terms of
    /// p; the rest of the forward peak goes straight on (δ-M, W. J. Wiscombe, J. Atmos. Sci. 34
    /// (1977) 1408).
    fn scattered(&self, medium: &Hemisphere, cosines: &[f64]) -> [Mat<f64>; 2] {
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
        let mut lost = shape(1.0);
        for j in 0..n {
            let sum: f64 = (0..n).map(|i| back[(i, j)] + lost[(i, j)]).sum();
            let share = scattering / (cosines[j] * sum);
            for i in 0..n {
                back[(i, j)] *= share;
                lost[(i, j)] *= -share;
            }
            lost[(j, j)] += (scattering + self.absorption_per_um) / cosines[j];
        }
        [back, lost]
    }

    /// The medium that has a slab's coherent transmittance at 0°, and its mean reflectance and
    /// absorptance in diffuse light. `None` where there is none: where the mean over few
    /// realisations leaves no coherent light, or where Broyden's method does not settle.
    pub fn of_slab(slab: &Plate, medium: &Hemisphere, thickness_um: f64) -> Option<Self> {
        let extinction = extinction_per_um(slab, thickness_um)?;
        let [r, t] = means(slab, medium);
        let ordinates = Ordinates::for_transfer(medium.ordinates.index, [NODES; 2]);
        let plain = Hemisphere { ordinates, polarisations: 1, oblique_deg: None };
        // absorption over extinction, and g
        let transport = |k: [f64; 2]| Self {
            scattering_per_um: extinction * (1.0 - k[0]),
            absorption_per_um: extinction * k[0],
            asymmetry: k[1],
        };
        let miss = |k: [f64; 2]| {
            let [own_r, own_t] = means(&transport(k).layer(&plain, thickness_um)?, &plain);
            Some([own_r + own_t - r - t, own_r - r])
        };
        let start = [0.5 * (1.0 - r - t) / (extinction * thickness_um), 0.5];
        let (found, last_step) = SEARCH.root(start, miss)?;
        let settled = (0..2).all(|i| last_step[i].abs() < ACCEPTED[i]);
        let found = transport(found);
        (settled && found.scattering_per_um > 0.0).then_some(found)
    }
}

/// An even layer: both sides are alike.
struct EvenLayer {
    reflection: Mat<f64>,
    transmission: Mat<f64>,
}

impl EvenLayer {
    /// Two such layers, one behind another.
    fn doubled(&self) -> Self {
        let Self { reflection: r, transmission: t } = self;
        let between = bounced(r, r, t);
        Self { reflection: r + t * (r * &between), transmission: t * between }
    }
}

/// a + b X.
fn plus(a: f64, b: f64, x: &Mat<f64>) -> Mat<f64> {
    Mat::from_fn(x.nrows(), x.ncols(), |i, j| if i == j { a + b * x[(i, j)] } else { b * x[(i, j)] })
}

/// A⁻¹ X.
fn solved(a: &Mat<f64>, x: &Mat<f64>) -> Mat<f64> {
    f64::solve(&f64::factors(a.as_ref()), x.as_ref())
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
