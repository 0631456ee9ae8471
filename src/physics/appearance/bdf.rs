//! BRDF and BTDF: ensemble averages of far fields of several realisations at one incidence, with
//! standard errors.
//!
//! Orders sit on a uniform lattice in direction cosines (α, β) = (kx, ky)/k0, cell area λ²/(Lx Ly);
//! since cos θ dω = dα dβ, the estimate at an order is f = ⟨e⟩ Lx Ly/λ² per steradian, with no
//! cosine and no bin area (vacuum on that side; in a medium of index n, dα dβ = n² cos θ dω). One
//! order of one realisation is speckle with a relative deviation of 1; smoothing and averaging tame
//! it.

pub use super::bdf_orders::{Lobe, OrderMean, Totals};
use super::bdf_orders::{View, coherent_efficiency, totals, view};
use crate::numerics::estimate::Estimate;
use crate::wave::{FarField, Incidence, Order};
use ndarray::Array2;
use num_complex::Complex64;
use thiserror::Error;

/// Why far fields yield no distribution function, or none in the requested direction.
#[derive(Debug, Error, PartialEq)]
pub enum BdfError {
    /// No far fields were given.
    #[error("no far fields: a BDF needs at least one realisation")]
    Empty,
    /// Far fields that cannot be averaged together.
    #[error(
        "far field {index} differs from the first in {field}; average realisations of one incidence and period"
    )]
    Mixed {
        /// Place of the far field in the list.
        index: usize,
        /// What differs.
        field: &'static str,
    },
    /// An amplitude that is not finite.
    #[error("far field {index}, order ({m}, {n}): not finite; check the solve behind it")]
    NotFinite {
        /// Place of the far field in the list.
        index: usize,
        /// Order along x.
        m: i32,
        /// Order along y.
        n: i32,
    },
    /// A bandwidth that is not positive.
    #[error(
        "smoothing bandwidth = {value} (direction cosines): must be greater than 0 and finite, at least {spacing:.4} to reach a neighbour"
    )]
    Bandwidth {
        /// The bandwidth in direction cosines.
        value: f64,
        /// Distance between neighbouring orders in direction cosines.
        spacing: f64,
    },
    /// No order near the requested direction.
    #[error(
        "direction cosines ({alpha}, {beta}) are outside the unit circle, or no order lies within the bandwidth {bandwidth}"
    )]
    NothingThere {
        /// kx/k0.
        alpha: f64,
        /// ky/k0.
        beta: f64,
        /// The bandwidth in direction cosines.
        bandwidth: f64,
    },
}

/// A smoothed BDF value, 1/sr; `effective_orders` = (ΣK)²/ΣK² is the number of orders of one
/// realisation that it averages.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Smoothed {
    /// The distribution function, 1/sr.
    pub bdf: Estimate,
    /// Number of equally weighted orders with the same statistical scatter.
    pub effective_orders: f64,
}

/// Data of one side: the orders that propagate there and the efficiencies of every realisation,
/// indexed \[realisation, order\].
#[derive(Clone, Debug, PartialEq)]
pub(super) struct LobeData {
    pub(super) orders: Vec<OrderMean>,
    pub(super) efficiencies: Array2<f64>,
    pub(super) totals: Totals,
}

/// The ensemble-averaged BDF at one incidence.
///
/// ```
/// use inkwave_physics::appearance::bdf::{Bdf, Lobe};
/// use inkwave_physics::solve::{Gmres, Goal, Silent, Solver};
/// use inkwave_physics::ink::Sphere;
/// use inkwave_physics::wave::{
///     Body, FarField, Incidence, Mean, Media, Problem, Resolution, Scene, Scheme, BodyShape, Side,
/// };
///
/// // Two "realisations": one ball at two depths.
/// let solved = |depth_um: f64| -> Result<FarField, Box<dyn std::error::Error>> {
///     let ball = Sphere { center_um: [0.3, 0.3, depth_um], radius_um: 0.12 };
///     let scene = Scene::layer([0.7, 0.7], 0.4, vec![Body::new(BodyShape::Balls(vec![ball]), 0)]);
///     let media = Media {
///         incident: 1.0.into(),
///         exit: 1.0.into(),
///         backgrounds: vec![1.558.into()],
///         inclusions: vec![1.4.into()],
///     };
///     let light = Incidence {
///         wavelength_um: 0.5,
///         polar_deg: 0.0,
///         azimuth_deg: 0.0,
///         from: Side::Incident,
///     };
///     let grid = Resolution { nx: 12, ny: 12, cells: 4, scheme: Scheme::Cubic };
///     let problem = Problem::from_scene(&scene, &media, &light, grid, Mean::default())?;
///     let solution = Gmres::default().solve(&problem, Goal::default(), &mut Silent)?;
///     Ok(problem.far_field(&solution.field))
/// };
/// let bdf = Bdf::from_ensemble(&[solved(0.15)?, solved(0.25)?])?;
/// let totals = bdf.totals(Lobe::Transmitted);
/// assert_eq!(bdf.realisations, 2);
/// assert!((totals.total.value - totals.specular.value - totals.diffuse.value).abs() < 1e-12);
/// assert!(totals.total.standard_error.is_some());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Bdf {
    /// Wavelength, direction and side of the light.
    pub incidence: Incidence,
    /// Lateral periods, µm.
    pub period_um: [f64; 2],
    /// Number of far fields averaged.
    pub realisations: usize,
    /// Reflected and transmitted light.
    pub(super) lobes: [LobeData; 2],
}

/// A bandwidth (direction cosines) that always reaches the eight neighbours of an order: 1.5
/// lattice spacings.
pub fn suggested_bandwidth(wavelength_um: f64, period_um: [f64; 2]) -> f64 {
    1.5 * wavelength_um / period_um[0].min(period_um[1])
}

impl Bdf {
    /// Averages far fields of independent realisations.
    ///
    /// # Errors
    /// No far fields; far fields of different incidence, period or orders; values that are not
    /// finite.
    pub fn from_ensemble(fields: &[FarField]) -> Result<Self, BdfError> {
        let first = fields.first().ok_or(BdfError::Empty)?;
        for (index, field) in fields.iter().enumerate() {
            check(index, first, field)?;
        }
        let FarField { incidence, period_um, .. } = *first;
        let density = period_um[0] * period_um[1] / incidence.wavelength_um.powi(2);
        let lobes = [Lobe::Reflected, Lobe::Transmitted].map(|lobe| LobeData::new(fields, density, lobe));
        Ok(Self { incidence, period_um, realisations: fields.len(), lobes })
    }

    /// Orders that propagate on one side.
    pub fn orders(&self, lobe: Lobe) -> &[OrderMean] {
        &self.lobes[lobe as usize].orders
    }

    /// Whether any order other than the specular one propagates; none does if the period is shorter
    /// than the wavelength.
    pub fn scatters(&self, lobe: Lobe) -> bool {
        self.orders(lobe).iter().any(|o| (o.m, o.n) != (0, 0))
    }

    /// Totals over all orders of one side.
    pub fn totals(&self, lobe: Lobe) -> Totals {
        self.lobes[lobe as usize].totals
    }

    /// Distance between neighbouring orders in direction cosines: [λ/Lx, λ/Ly].
    pub fn spacing(&self) -> [f64; 2] {
        self.period_um.map(|l| self.incidence.wavelength_um / l)
    }

    /// Diffuse BDF at direction cosines (α, β), smoothed with the kernel K = 1 − (d/bandwidth)²
    /// over the orders within `bandwidth` (direction cosines). The specular order is left out: its
    /// neighbours fill the gap.
    ///
    /// # Errors
    /// Bandwidth not positive; directions outside the unit circle; no order within the bandwidth.
    pub fn at(&self, lobe: Lobe, direction: [f64; 2], bandwidth: f64) -> Result<Smoothed, BdfError> {
        let [alpha, beta] = direction;
        self.smooth(lobe, direction, bandwidth, |[a, b]| (a - alpha).hypot(b - beta))
    }

    /// Diffuse BDF averaged over azimuth at a polar angle (vacuum), smoothed in sin θ with the
    /// kernel of [`Bdf::at`].
    ///
    /// # Errors
    /// See [`Bdf::at`].
    pub fn azimuthal_mean(&self, lobe: Lobe, polar_deg: f64, bandwidth: f64) -> Result<Smoothed, BdfError> {
        let sin = polar_deg.to_radians().sin();
        self.smooth(lobe, [sin, 0.0], bandwidth, |[a, b]| a.hypot(b) - sin)
    }

    /// Kernel-weighted BDF, with the effective number of orders of one realisation.
    fn smooth(
        &self,
        lobe: Lobe,
        direction: [f64; 2],
        bandwidth: f64,
        distance: impl Fn([f64; 2]) -> f64,
    ) -> Result<Smoothed, BdfError> {
        let [dx, dy] = self.spacing();
        if !(bandwidth.is_finite() && bandwidth > 0.0) {
            return Err(BdfError::Bandwidth { value: bandwidth, spacing: dx.max(dy) });
        }
        let data = &self.lobes[lobe as usize];
        let kernel = |o: &OrderMean| match (o.m, o.n) {
            (0, 0) => 0.0,
            _ => (1.0 - (distance(o.direction) / bandwidth).powi(2)).max(0.0),
        };
        let weights: Vec<f64> = data.orders.iter().map(kernel).collect();
        let (sum, squares) = weights.iter().fold((0.0, 0.0), |(s, q), w| (s + w, q + w * w));
        if !(direction[0].hypot(direction[1]) < 1.0 && sum > 0.0) {
            return Err(BdfError::NothingThere { alpha: direction[0], beta: direction[1], bandwidth });
        }
        let rows = data.efficiencies.outer_iter();
        let sums = rows.map(|row| row.iter().zip(&weights).map(|(e, w)| e * w).sum::<f64>());
        let values: Vec<f64> = sums.map(|total| total / sum / (dx * dy)).collect();
        Ok(Smoothed { bdf: Estimate::of_mean(&values), effective_orders: sum * sum / squares })
    }
}

impl LobeData {
    fn new(fields: &[FarField], density: f64, lobe: Lobe) -> Self {
        let first = &fields[0].orders;
        let kept: Vec<usize> = (0..first.len()).filter(|&k| view(&first[k], lobe).propagates).collect();
        let column = |&k: &usize| -> Vec<View> { fields.iter().map(|f| view(&f.orders[k], lobe)).collect() };
        let columns: Vec<Vec<View>> = kept.iter().map(column).collect();
        let shape = (fields.len(), kept.len());
        let efficiencies = Array2::from_shape_fn(shape, |(r, k)| columns[k][r].efficiency);
        let order = |(&k, column): (&usize, &Vec<View>)| {
            let Order { m, n, direction, .. } = first[k];
            let samples: Vec<f64> = column.iter().map(|view| view.efficiency).collect();
            OrderMean::new(m, n, direction, &samples, coherent_efficiency(column.iter()), density)
        };
        let orders: Vec<OrderMean> = kept.iter().zip(&columns).map(order).collect();
        let specular = orders.iter().position(|o| o.m == 0 && o.n == 0);
        let totals = totals(&efficiencies, specular, specular.map_or(&[][..], |k| &columns[k]));
        Self { orders, efficiencies, totals }
    }
}

fn check(index: usize, first: &FarField, field: &FarField) -> Result<(), BdfError> {
    let mixed = |field| Err(BdfError::Mixed { index, field });
    if field.incidence != first.incidence {
        return mixed("incidence");
    }
    if field.period_um != first.period_um {
        return mixed("period_um");
    }
    let same = |(a, b): (&Order, &Order)| {
        let propagation = |o: &Order| (o.reflected_propagates, o.transmitted_propagates);
        (a.m, a.n) == (b.m, b.n) && propagation(a) == propagation(b)
    };
    if field.orders.len() != first.orders.len() || !field.orders.iter().zip(&first.orders).all(same) {
        return mixed("orders");
    }
    let finite = |o: &&Order| {
        let amplitudes = o.amplitudes().flatten().all(Complex64::is_finite);
        amplitudes && o.reflected_efficiency.is_finite() && o.transmitted_efficiency.is_finite()
    };
    let Some(o) = field.orders.iter().find(|o| !finite(o)) else { return Ok(()) };
    Err(BdfError::NotFinite { index, m: o.m, n: o.n })
}

#[cfg(test)]
#[path = "bdf_tests.rs"]
pub mod tests;
