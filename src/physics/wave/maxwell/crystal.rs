//! Effective permittivity at points that uniaxial crystals reach, ε = ε_o + δ A with A = a aᵀ of
//! the optic axis a and δ = ε_e − ε_o.
//!
//! What is continuous across a crystal's surface is F = (1 − N)E + N(εE)/ε_b, so that inside
//!
//! E = (1 − G) F      G = N (ε − ε_b)/ε_nn      D = ε (1 − G) F      ε_nn = ε_o + δ u, u = aᵀNa
//!
//! With one tensor for both, D = εE holds inside whatever G is, and G on the surface decides on
//! the order of convergence only. 1/ε_nn is replaced by α + βu, equal to it at two Chebyshev
//! points of 0 ≤ u ≤ 1 (within 0.8 % for rutile); G and εG are then sums of products of media and
//! geometry, with c = ε_o − ε_b:
//!
//! G = c (αN + βuN) + δ (αNA + βuNA)      εG = ε_o G + δ [c (αNA + βuNA)ᵀ + δ (αuA + βu²A)]
//!
//! and their moments those of N, A, uN, NA, uNA, uA and u²A. In the isotropic limit δ = 0 this is
//! the rule of [`super::contrast`].

use super::sources::FIELDS;
use super::symmetric::Symmetric;
use num_complex::Complex64;

/// Number of fields of a crystal besides χ and χN.
pub const CRYSTAL_FIELDS: usize = 42;
/// Components of A, uN (six each, xx, xy, yy, xz, yz, zz), NA, uNA (nine each, by rows), uA and u²A
/// (six each) at a point, times χ.
pub type CrystalFields = [f64; CRYSTAL_FIELDS];

/// A full 3 × 3 tensor.
pub(super) type Tensor = [[Complex64; 3]; 3];

/// Permittivities of a crystal: of the ordinary ray, and δ = ε_e − ε_o.
#[derive(Clone, Copy, Debug)]
pub(super) struct Permittivity {
    pub ordinary: Complex64,
    pub step: Complex64,
}

/// TensorSums over materials at a point: E = W_C F and D = W_D F.
pub(super) struct TensorSums {
    pub electric: Tensor,
    pub displacement: Tensor,
}

impl TensorSums {
    /// Those of the background alone.
    pub fn of(background: Complex64) -> TensorSums {
        TensorSums { electric: diagonal(Complex64::ONE), displacement: diagonal(background) }
    }

    /// Adds what a material changes; without the normal's part for plain averaging.
    pub fn add(&mut self, background: Complex64, material: Permittivity, fields: &PointFields) {
        let Permittivity { ordinary, step } = material;
        let &PointFields { base: [chi, normal @ ..], crystal, along_normals } = fields;
        let contrast = ordinary - background;
        let [alpha, beta] = inverse_normal(material);
        let [a, un, ua, uua] = [0, 6, 30, 36].map(|first| &crystal[first..first + 6]);
        let [na, una] = [12, 21].map(|first| &crystal[first..first + 9]);
        for i in 0..3 {
            self.displacement[i][i] += contrast * chi;
            for j in 0..3 {
                let s = PLACE[i][j];
                self.displacement[i][j] += step * a[s];
                if !along_normals {
                    continue;
                }
                let mixed = |i: usize, j: usize| alpha * na[3 * i + j] + beta * una[3 * i + j];
                let g = contrast * (alpha * normal[s] + beta * un[s]) + step * mixed(i, j);
                let turned = contrast * mixed(j, i) + step * (alpha * ua[s] + beta * uua[s]);
                self.electric[i][j] -= g;
                self.displacement[i][j] -= ordinary * g + step * turned;
            }
        }
    }

    /// Symmetric part of W_D adj(W_C), and det W_C, by which it is to be divided.
    pub fn effective(&self) -> (Symmetric, Complex64) {
        let (adjugate, determinant) = adjugate(&self.electric);
        let entry =
            |i: usize, j: usize| (0..3).map(|k| self.displacement[i][k] * adjugate[k][j]).sum::<Complex64>();
        let mean = |i: usize, j: usize| 0.5 * (entry(i, j) + entry(j, i));
        ([mean(0, 0), mean(0, 1), mean(1, 1), mean(0, 2), mean(1, 2), mean(2, 2)], determinant)
    }
}

/// What a material has at a point.
pub(super) struct PointFields<'a> {
    /// χ and the components of χN.
    pub base: &'a [f64; FIELDS],
    /// Those of crystals; zeros for other materials.
    pub crystal: &'a CrystalFields,
    /// Whether the product is taken along normals.
    pub along_normals: bool,
}

/// Place of component (i, j) among xx, xy, yy, xz, yz, zz.
const PLACE: [[usize; 3]; 3] = [[0, 1, 3], [1, 2, 4], [3, 4, 5]];

/// Coefficients α and β of 1/(ε_o + δu).
fn inverse_normal(material: Permittivity) -> [Complex64; 2] {
    let points = [-0.5, 0.5].map(|side| 0.5 + side * std::f64::consts::FRAC_1_SQRT_2);
    let [first, last] = points.map(|u| 1.0 / (material.ordinary + material.step * u));
    let beta = (last - first) / (points[1] - points[0]);
    [first - beta * points[0], beta]
}

fn diagonal(value: Complex64) -> Tensor {
    let mut tensor = [[Complex64::default(); 3]; 3];
    (0..3).for_each(|i| tensor[i][i] = value);
    tensor
}

/// Adjugate and determinant.
fn adjugate(m: &Tensor) -> (Tensor, Complex64) {
    // Cyclic indices carry the sign of every cofactor.
    let cofactor = |i: usize, j: usize| {
        let [r, s] = [(i + 1) % 3, (i + 2) % 3];
        let [p, q] = [(j + 1) % 3, (j + 2) % 3];
        m[r][p] * m[s][q] - m[r][q] * m[s][p]
    };
    let adjugate: Tensor = std::array::from_fn(|i| std::array::from_fn(|j| cofactor(j, i)));
    (adjugate, (0..3).map(|k| m[0][k] * adjugate[k][0]).sum())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::vector::{dot, unit};

    /// Across a flat face, whatever its normal and the axis, the mean of half background and half
    /// crystal keeps E along the face and D across it: the closed form of a laminate. *Planted*: NA
    /// in place of its transpose, δ without its square.
    #[test]
    fn a_face_gives_the_laminate_of_its_halves() {
        let background = Complex64::new(2.25, 0.0);
        let [o, e] = [Complex64::new(6.8, 0.1), Complex64::new(8.2, 0.3)];
        let material = Permittivity { ordinary: o, step: e - o };
        for (normal, axis) in [([0.0, 0.0, 1.0], [0.0, 0.6, 0.8]), ([1.0, 2.0, -1.0], [0.3, -0.2, 0.9])] {
            let [normal, axis] = [normal, axis].map(unit);
            let u = dot(normal, axis).powi(2);
            let crystal = crate::wave::maxwell::moments::crystal_fields(&square(normal), axis);
            let crystal = crystal.map(|f| 0.5 * f);
            let mut base = [0.5; FIELDS];
            base[1..].iter_mut().zip(square(normal)).for_each(|(b, n)| *b *= n);
            let mut sums = TensorSums::of(background);
            sums.add(
                background,
                material,
                &PointFields { base: &base, crystal: &crystal, along_normals: true },
            );
            let (tensor, determinant) = sums.effective();
            // With tangential E and normal D given: means of (E, D) over both halves, by the true
            // 1/ε_nn.
            let epsilon =
                |i: usize, j: usize| (if i == j { o } else { 0.0.into() }) + (e - o) * axis[i] * axis[j];
            let across: Vec<Complex64> =
                (0..3).map(|j| (0..3).map(|i| normal[i] * epsilon(i, j)).sum()).collect();
            let full: Complex64 = (0..3).map(|j| across[j] * normal[j]).sum();
            let kronecker = |i: usize, j: usize| f64::from(u8::from(i == j));
            let inner: Tensor = std::array::from_fn(|i| {
                std::array::from_fn(|j| {
                    kronecker(i, j) - normal[i] * (across[j] - background * normal[j]) / full
                })
            });
            let mut want =
                TensorSums { electric: diagonal(0.5.into()), displacement: diagonal(0.5 * background) };
            for i in 0..3 {
                for j in 0..3 {
                    want.electric[i][j] += 0.5 * inner[i][j];
                    let d: Complex64 = (0..3).map(|k| epsilon(i, k) * inner[k][j]).sum();
                    want.displacement[i][j] += 0.5 * d;
                }
            }
            let (expected, by) = want.effective();
            for (found, expected) in tensor.iter().zip(expected) {
                // the linear 1/ε_nn is off by 0.8 % at most
                assert!((found / determinant - expected / by).norm() < 0.03, "{found} {expected} {u}");
            }
        }
    }

    fn square([x, y, z]: [f64; 3]) -> [f64; 6] {
        [x * x, x * y, y * y, x * z, y * z, z * z]
    }
}
