//! The layer on a Lambertian substrate: multiple reflections between the layer and the paper (P1
//! section 5).
//!
//! With T(θ), R(θ) from the incident side and R_b(θ) from the exit side (specular plus diffuse),
//! and ρ the albedo of the paper:
//!
//! ```text
//! R̄_b = 2∫₀¹ R_b(μ) μ dμ     g = ρ/(1 − ρ R̄_b)     T̄ = 2∫₀¹ T(μ) μ dμ
//! f(i, o) = f_layer(i, o) + g T(i) T(o)/π           albedo(i) = R(i) + g T(i) T̄
//! uniform sky of radiance 1, seen at o:  R(o) + g T(o) T̄
//! ```
//!
//! T(o) of the emerging light equals T from the incident side at o by reciprocity, also with
//! roughness and absorption. [`Coupling::Gap`] is the model of P1: a thin gap, no interference
//! between layer and paper. [`Coupling::OpticalContact`] places the paper's scatterers in a medium
//! of index n in contact with the layer: the solves then have n behind the layer, R_b is integrated
//! over the angles inside that medium (total internal reflection included), and the radiance drops
//! by n² on leaving: g → g/n². Its limit for a plane film matched to the medium is Williams &
//! Clapper (1953). A clear film of 1.558 on paper of albedo 0.9 has π f(0→0) = 0.910 with a
//! (coherent) gap and 0.818 in contact.
//!
//! R̄_b is not computed by a separate quadrature. Reciprocity gives the mean transmittance from the
//! exit side as T̄/n², so
//!
//! ```text
//! R̄_b = 1 − T̄/n² − Ā_b        g = ρ/(1 − ρ (1 − T̄/n² − Ā_b))
//! ```
//!
//! and only the absorption Ā_b is needed from the exit side. A layer without absorption on a
//! perfect white then has R + g T T̄ = R + T = 1 exactly, whatever the directions solved (the
//! furnace test); with two independent quadratures, g would amplify their mismatch.
//!
//! R, T and A are those of the light that was solved: the scalar wave (s-polarised light), s, p, or
//! unpolarised. Light returned by the paper is unpolarised.

use std::cmp::Ordering;
use thiserror::Error;

/// Invalid paper, or an invalid angle.
#[derive(Debug, Error, PartialEq)]
pub enum PaperError {
    /// An angle outside the hemisphere.
    #[error("polar angle {value}°: allowed are 0° to below 90°")]
    AngleOutOfRange {
        /// The angle, degrees.
        value: f64,
    },
    /// An albedo outside 0–1.
    #[error("paper albedo = {value}: allowed 0 to 1")]
    Albedo {
        /// The albedo.
        value: f64,
    },
    /// A wavelength outside the table.
    #[error("paper albedo is given from {lo} to {hi} nm, requested at {value} nm; extend the table")]
    AlbedoRange {
        /// The wavelength, nm.
        value: f64,
        /// First wavelength of the table, nm.
        lo: f64,
        /// Last wavelength of the table, nm.
        hi: f64,
    },
    /// A table that does not increase in wavelength.
    #[error("paper albedo table: wavelength_nm = {value} does not increase, or fewer than 2 rows")]
    AlbedoTable {
        /// The wavelength, nm.
        value: f64,
    },
    /// A lossless closed cavity.
    #[error(
        "the layer reflects all light from the exit side (R̄_b = {mean}) on paper of albedo 1: the light never leaves; lower the albedo"
    )]
    TrapsAllLight {
        /// R̄_b, the mean reflectance from the exit side.
        mean: f64,
    },
}

/// Angle of incidence in print measurement (ISO 13655: 45:0), degrees; every colour needs it
/// besides 0°.
pub const PRINT_DEG: f64 = 45.0;
/// Smallest fraction of light that must escape; below it, a layer on paper is a closed cavity.
const LEAST_ESCAPE: f64 = 1e-12;

/// Whether skylight mirrored by the layer is included: P1 leaves it open.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum MirroredSky {
    /// R(o) + g T(o) T̄: all the light of a uniform sky.
    #[default]
    Included,
    /// Without the specular order, as when a viewer tilts the print to avoid glare.
    Excluded,
}

/// g = ρ/(1 − ρ R̄_b), divided by n², with R̄_b = 1 − T̄/n² − Ā_b. `transmitted` is T̄ from the
/// incident side, `absorbed` is Ā_b from the exit side, `index` is n on the exit side (1 for a
/// gap).
///
/// # Errors
/// An albedo outside 0–1, or a cavity that light cannot leave.
pub fn returned(albedo: f64, transmitted: f64, absorbed: f64, index: f64) -> Result<f64, PaperError> {
    if !(0.0..=1.0).contains(&albedo) {
        return Err(PaperError::Albedo { value: albedo });
    }
    let lost = lost(albedo, transmitted, absorbed, index)?;
    Ok(albedo / lost / (index * index))
}

/// 1/(1 − ρ R̄_b), divided by n²: what leaves of light that the paper itself emits, over T towards
/// the eye. Arguments as those of [`returned`].
///
/// # Errors
/// A cavity that light cannot leave.
pub fn emerging(albedo: f64, transmitted: f64, absorbed: f64, index: f64) -> Result<f64, PaperError> {
    Ok(1.0 / lost(albedo, transmitted, absorbed, index)? / (index * index))
}

/// 1 − ρ R̄_b of a layer that loses the share 1 − R̄_b of the light from the paper, written so that
/// for a perfect white it is that share without rounding.
pub fn lost_in_a_round(albedo: f64, lost: f64) -> f64 {
    (1.0 - albedo) + albedo * lost
}

/// 1 − ρ R̄_b; arguments as those of [`returned`].
fn lost(albedo: f64, transmitted: f64, absorbed: f64, index: f64) -> Result<f64, PaperError> {
    let escaping = transmitted / (index * index);
    let lost = lost_in_a_round(albedo, escaping + absorbed);
    if lost.is_nan() || lost < LEAST_ESCAPE {
        return Err(PaperError::TrapsAllLight { mean: 1.0 - escaping - absorbed });
    }
    Ok(lost)
}

/// What is between the layer and the paper.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum Coupling {
    /// A thin gap of vacuum, wide enough to be incoherent (P1).
    #[default]
    Gap,
    /// The paper's scatterers sit in a medium of this index that touches the layer.
    OpticalContact {
        /// Real index of the paper's medium, at least 1.
        index: f64,
    },
}

impl Coupling {
    /// Index of the exit half-space required in the solves.
    pub fn index_out(self) -> f64 {
        match self {
            Self::Gap => 1.0,
            Self::OpticalContact { index } => index,
        }
    }
}

/// Albedo ρ of the paper, 0–1: the same at every wavelength, or (wavelength_nm, ρ) rows, linear in
/// between.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(untagged, expecting = "an albedo: a number from 0 to 1, or rows of wavelength in nm and albedo")
)]
pub enum Albedo {
    /// One albedo for all wavelengths, 0 to 1.
    Constant(f64),
    /// Rows of wavelength in nm and albedo, linear between.
    Spectral(Vec<[f64; 2]>),
}

impl Albedo {
    /// The albedo ρ(λ) at a wavelength in nm.
    ///
    /// # Errors
    /// Values outside 0–1, tables that do not increase, wavelengths outside the table.
    pub fn at(&self, wavelength_nm: f64) -> Result<f64, PaperError> {
        let value = match self {
            Self::Constant(value) => *value,
            Self::Spectral(rows) => interpolate(rows, wavelength_nm)?,
        };
        if (0.0..=1.0).contains(&value) { Ok(value) } else { Err(PaperError::Albedo { value }) }
    }
}

fn interpolate(rows: &[[f64; 2]], nm: f64) -> Result<f64, PaperError> {
    let unordered = rows.windows(2).find(|w| w[1][0].partial_cmp(&w[0][0]) != Some(Ordering::Greater));
    if rows.len() < 2 || unordered.is_some() {
        return Err(PaperError::AlbedoTable { value: unordered.map_or(nm, |w| w[1][0]) });
    }
    let lo = rows[0][0];
    let hi = rows[rows.len() - 1][0];
    if !(lo..=hi).contains(&nm) {
        return Err(PaperError::AlbedoRange { value: nm, lo, hi });
    }
    let after = rows.partition_point(|r| r[0] < nm).clamp(1, rows.len() - 1);
    let [x0, y0] = rows[after - 1];
    let [x1, y1] = rows[after];
    Ok(y0 + (nm - x0) / (x1 - x0) * (y1 - y0))
}

/// The paper under the layer.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Substrate {
    /// Share of the light that the paper returns.
    pub albedo: Albedo,
    /// What is between ink and paper.
    #[cfg_attr(feature = "serde", serde(default))]
    pub coupling: Coupling,
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// The furnace: no losses on a perfect white send back all light, whatever the means.
        #[test]
        fn a_lossless_layer_on_white_paper_sends_everything_back(t in 0.01..1.0f64, index in 1.0..2.0f64, at in 0.0..1.0f64) {
            let g = returned(1.0, t, 0.0, index).unwrap();
            // identity: rounding
            prop_assert!(((1.0 - at) + g * at * t - 1.0).abs() < 1e-14);
        }

        /// The geometric series: what enters, is reflected by the paper, comes back from the layer,
        /// and so on.
        #[test]
        fn the_returns_are_a_geometric_series(rho in 0.0..0.95f64, t in 0.05..0.6f64, a in 0.0..0.4f64, index in 1.0..1.6f64) {
            let back = 1.0 - t / (index * index) - a;
            let series: f64 = (0..2000).map(|k| rho * (rho * back).powi(k)).sum::<f64>() / (index * index);
            prop_assert!((returned(rho, t, a, index).unwrap() - series).abs() < 1e-12);
        }
    }

    #[test]
    fn what_cannot_be_is_refused() {
        assert!(matches!(returned(1.0, 0.0, 0.0, 1.0), Err(PaperError::TrapsAllLight { .. })));
        assert!(matches!(returned(1.5, 0.5, 0.0, 1.0), Err(PaperError::Albedo { .. })));
        assert!(returned(0.9, f64::NAN, 0.0, 1.0).is_err());
    }
}
