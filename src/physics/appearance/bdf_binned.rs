//! BDFs of an ensemble whose periods differ: the orders of every realisation, rotated into one
//! plane of incidence, are binned on the lattice of the nominal period.
//!
//! Each bin holds the sum of all orders nearest to it, so totals are conserved exactly and the mean
//! over realisations is an unbiased histogram of the distribution in direction cosines. The
//! specular order is alone in bin (0, 0): every other order is more than half a lattice step away
//! from it.

use super::bdf::{Bdf, BdfError, LobeData};
use super::bdf_orders::{Lobe, OrderMean, View, totals, view};
use crate::wave::{FarField, Incidence};
use ndarray::Array2;
use std::collections::BTreeMap;

/// Index of a bin on the lattice.
type BinPlace = (i32, i32);

impl Bdf {
    /// Averages far fields of one polar angle and nearly one wavelength; periods and azimuths may
    /// differ. `period_um` is the nominal period. Azimuths are measured from the plane of incidence
    /// (azimuth 0).
    ///
    /// # Errors
    /// No far fields, or fields at different polar angles or lit from different sides.
    pub fn from_varied_cells(fields: &[FarField], period_um: [f64; 2]) -> Result<Self, BdfError> {
        let first = fields.first().ok_or(BdfError::Empty)?;
        let Incidence { polar_deg, from, .. } = first.incidence;
        let same = |i: Incidence| (i.polar_deg - polar_deg).abs() < 1e-9 && i.from == from;
        if let Some(index) = fields.iter().position(|f| !same(f.incidence)) {
            return Err(BdfError::Mixed { index, field: "incidence" });
        }
        let count = fields.len() as f64;
        let wavelength_um = fields.iter().map(|f| f.incidence.wavelength_um).sum::<f64>() / count;
        let incidence = Incidence { wavelength_um, azimuth_deg: 0.0, ..first.incidence };
        let [x, y] = first.specular().direction;
        let lattice = Lattice { centre: [x.hypot(y), 0.0], step: period_um.map(|l| wavelength_um / l) };
        let lobes = [Lobe::Reflected, Lobe::Transmitted].map(|lobe| lattice.collect(fields, lobe));
        Ok(Self { incidence, period_um, realisations: fields.len(), lobes })
    }
}

/// The nominal lattice in direction cosines around the specular direction.
struct Lattice {
    centre: [f64; 2],
    step: [f64; 2],
}

impl Lattice {
    fn direction(&self, (m, n): BinPlace) -> [f64; 2] {
        [self.centre[0] + f64::from(m) * self.step[0], self.centre[1] + f64::from(n) * self.step[1]]
    }

    /// The nearest bin; near the rim, the nearest bin whose centre lies inside `reach`, the largest
    /// cosine that propagates.
    fn place(&self, direction: [f64; 2], reach: f64) -> BinPlace {
        let nearest = |i: usize| ((direction[i] - self.centre[i]) / self.step[i]).round() as i32;
        let around = (-1..=1).flat_map(|i| (-1..=1).map(move |j| (nearest(0) + i, nearest(1) + j)));
        let distance = |place: &BinPlace, [x, y]: [f64; 2]| {
            let bin = self.direction(*place);
            (bin[0] - x).hypot(bin[1] - y)
        };
        let inside = |place: &BinPlace| *place != (0, 0) && distance(place, [0.0; 2]) < reach;
        let best = around.filter(inside).map(|place| (distance(&place, direction), place));
        best.min_by(|a, b| a.0.total_cmp(&b.0)).map_or((nearest(0), nearest(1)), |(_, place)| place)
    }

    fn collect(&self, fields: &[FarField], lobe: Lobe) -> LobeData {
        let present = fields.iter().flat_map(|f| &f.orders).filter(|o| view(o, lobe).propagates);
        let reach = present.map(|o| o.direction[0].hypot(o.direction[1])).fold(0.0, f64::max).max(1.0);
        let mut cells: BTreeMap<BinPlace, Vec<f64>> = BTreeMap::new();
        for (r, field) in fields.iter().enumerate() {
            for order in field.orders.iter().filter(|o| view(o, lobe).propagates) {
                let place = match (order.m, order.n) {
                    (0, 0) => (0, 0),
                    _ => self.place(turned(order.direction, -field.incidence.azimuth_deg), reach),
                };
                cells.entry(place).or_insert_with(|| vec![0.0; fields.len()])[r] +=
                    view(order, lobe).efficiency;
            }
        }
        self.lobe(fields, lobe, cells)
    }

    fn lobe(&self, fields: &[FarField], lobe: Lobe, cells: BTreeMap<BinPlace, Vec<f64>>) -> LobeData {
        let density = 1.0 / (self.step[0] * self.step[1]);
        let columns: Vec<(BinPlace, Vec<f64>)> = cells.into_iter().collect();
        let order = |(place, samples): &(BinPlace, Vec<f64>)| {
            OrderMean::new(place.0, place.1, self.direction(*place), samples, None, density)
        };
        let orders = columns.iter().map(order).collect();
        let efficiencies = Array2::from_shape_fn((fields.len(), columns.len()), |(r, k)| columns[k].1[r]);
        let specular = columns.iter().position(|(place, _)| *place == (0, 0));
        let straight: Vec<View> = fields.iter().map(|f| view(f.specular(), lobe)).collect();
        LobeData { orders, totals: totals(&efficiencies, specular, &straight), efficiencies }
    }
}

fn turned([x, y]: [f64; 2], by_deg: f64) -> [f64; 2] {
    let (sin, cos) = by_deg.to_radians().sin_cos();
    [x * cos - y * sin, x * sin + y * cos]
}
