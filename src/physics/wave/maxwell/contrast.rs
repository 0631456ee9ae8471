//! The contrast as a symmetric tensor per point: V = k0² (ε_eff − ε̄) from the normal-field
//! moments.
//!
//! F = (1 − N)E + N(ε/ε_b)E is continuous across a grain's surface, so that moments of its
//! coefficients multiply a continuous field (Li's factorisation rules in every direction): E = W_C
//! F, D = W_D F with
//!
//! W_C = 1 + Σ_i (ε_b/ε_i − 1) m_i      W_D = ε_b + Σ_i (ε_i − ε_b)(χ_i 1 − m_i)      ε_eff =
//! sym(W_D W_C⁻¹)
//!
//! The symmetric part keeps reciprocity and energy balance exact. A flat horizontal face gives the
//! harmonic mean for zz and the arithmetic one for xx and yy.

use super::crystal::{CRYSTAL_FIELDS, CrystalFields, Permittivity, PointFields, TensorSums};
use super::moments::{ChannelFields, NormalMoments};
use super::sources::FIELDS;
use super::symmetric::{Symmetric, adjugate, symmetric_product};
use crate::wave::{Media, WaveError};
use num_complex::Complex64;
use rayon::prelude::*;

/// Smallest |det W_C|: below it the band-limited moments are numerically singular.
const LEAST_DETERMINANT: f64 = 1e-3;

/// Rule for the product of contrast and field where a grain's surface cuts through a point's
/// neighbourhood.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum Averaging {
    /// Along the surface normal: observed order 2.5 or higher.
    #[default]
    Normal,
    /// Volume-averaged ε in every direction: order 1 for fields across a surface. For comparison
    /// only.
    Naive,
}

/// Tensor V on every Gauss plane, divided by its number of points (inverse transforms are
/// unnormalised).
pub(super) fn tensors(
    moments: &NormalMoments,
    media: &Media,
    k0: f64,
    mean_k2: &[Complex64],
    averaging: Averaging,
) -> Result<Vec<Vec<Symmetric>>, WaveError> {
    let grid = &moments.grid;
    let square = |eta: Complex64| eta * eta;
    let rays = moments.channels.iter().map(|c| media.rays_of(c.material).map(square));
    let epsilons: Vec<_> =
        rays.map(|[ordinary, other]| Permittivity { ordinary, step: other - ordinary }).collect();
    let planes = moments.planes.par_iter().enumerate().map(|(plane, present)| Plane {
        present,
        epsilons: &epsilons,
        background: square(media.backgrounds[grid.background[plane / 2]]),
        mean: mean_k2[plane / 2],
        k2: (k0 * k0).into(),
        averaging,
    });
    planes.map(|plane| plane.tensors(grid.points())).collect()
}

/// One Gauss plane, with the data from which its tensors follow.
struct Plane<'a> {
    present: &'a [ChannelFields],
    /// Permittivity of every channel's material.
    epsilons: &'a [Permittivity],
    /// Permittivity of the background.
    background: Complex64,
    /// Mean k̄², 1/µm².
    mean: Complex64,
    /// Vacuum k0², 1/µm².
    k2: Complex64,
    averaging: Averaging,
}

impl Plane<'_> {
    fn tensors(&self, points: usize) -> Result<Vec<Symmetric>, WaveError> {
        let shift = self.background * self.k2 - self.mean;
        if self.present.is_empty() {
            // A difference of the size of rounding is set to zero: homogeneous layers then need no
            // iteration at all.
            let exact = shift.norm() < 1e-14 * self.mean.norm();
            return Ok(if exact { Vec::new() } else { vec![diagonal(shift / points as f64); points] });
        }
        (0..points).map(|point| self.tensor(point, points as f64)).collect()
    }

    /// Tensor V at one of `points` points, divided by their number.
    fn tensor(&self, point: usize, points: f64) -> Result<Symmetric, WaveError> {
        let mut tensor = self.effective(point)?.map(|e| e * self.k2 / points);
        [0, 2, 5].into_iter().for_each(|i| tensor[i] -= self.mean / points);
        Ok(tensor)
    }
}

impl Plane<'_> {
    /// Effective permittivity at a point.
    fn effective(&self, point: usize) -> Result<Symmetric, WaveError> {
        let is_anisotropic =
            |c: &ChannelFields| c.crystals.is_some() && self.epsilons[c.channel].step != Complex64::ZERO;
        if !self.present.iter().any(is_anisotropic) {
            let inclusions = self.present.iter();
            let inclusions = inclusions.map(|c| (self.epsilons[c.channel].ordinary, &c.fields[point]));
            return effective(self.background, inclusions, self.averaging);
        }
        let along_normals = self.averaging == Averaging::Normal;
        let mut sums = TensorSums::of(self.background);
        for channel in self.present {
            let crystal = channel.crystals.as_ref().map_or(&NO_CRYSTAL, |all| &all[point]);
            let fields = PointFields { base: &channel.fields[point], crystal, along_normals };
            sums.add(self.background, self.epsilons[channel.channel], &fields);
        }
        let (product, determinant) = sums.effective();
        divided(product, determinant)
    }
}

/// The fields of a material that is no crystal.
const NO_CRYSTAL: CrystalFields = [0.0; CRYSTAL_FIELDS];

/// The tensor over det W_C, unless that is too small.
fn divided(tensor: Symmetric, determinant: Complex64) -> Result<Symmetric, WaveError> {
    if determinant.norm() < LEAST_DETERMINANT {
        return Err(WaveError::NotInVectorMode {
            what: "this contrast",
            reason: "the normal-field tensor is nearly singular at a point of the grid",
            remedy: "raise the resolution; indices that differ by 2 or more may be out of the vector wave's reach",
        });
    }
    Ok(tensor.map(|v| v / determinant))
}

fn diagonal(value: Complex64) -> Symmetric {
    let zero = Complex64::default();
    [value, zero, value, zero, zero, value]
}

/// Effective permittivity ε_eff at one point from the inclusions' (ε_i, fields).
fn effective<'a>(
    background: Complex64,
    inclusions: impl Iterator<Item = (Complex64, &'a [f64; FIELDS])>,
    averaging: Averaging,
) -> Result<Symmetric, WaveError> {
    let mut e = diagonal(Complex64::ONE);
    let mut d = diagonal(background);
    for (epsilon, [chi, normal @ ..]) in inclusions {
        let ratio = background / epsilon - 1.0;
        let step = epsilon - background;
        [0, 2, 5].into_iter().for_each(|i| d[i] += step * chi);
        if averaging == Averaging::Normal {
            for (i, m) in normal.iter().enumerate() {
                e[i] += ratio * m;
                d[i] -= step * m;
            }
        }
    }
    let (adjugate, determinant) = adjugate(&e);
    divided(symmetric_product(&d, &adjugate), determinant)
}
