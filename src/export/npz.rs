//! Far fields as NumPy arrays (`.npz`): all orders of every solve.
//!
//! Arrays with one row per solve are named `solve_…`; arrays with one row per order `order_…`. The
//! orders of solve s are the rows `solve_first_order[s] .. solve_first_order[s + 1]`:
//!
//! ```python
//! f = numpy.load("far-fields.npz")
//! rows = slice(f["solve_first_order"][s], f["solve_first_order"][s + 1])
//! alpha, r = f["order_alpha"][rows], f["order_reflected"][rows]
//! ```

use crate::run::Collected;
use crate::store::record::PointRecord;
use crate::wave::{Order, Side};
use ndarray::{Array1, arr2};
use ndarray_npy::{NpzWriter, WriteNpzError};
use num_complex::Complex64;
use std::io::Cursor;

/// All far fields in one archive.
///
/// # Errors
/// The archive cannot be made.
pub fn far_fields(collected: &Collected) -> Result<Vec<u8>, WriteNpzError> {
    let points = collected.realisations.iter().flat_map(|r| &r.points);
    let records: Vec<&PointRecord> = points.flatten().collect();
    archive(|npz| {
        solves(npz, &records)?;
        orders(npz, &records)
    })
}

/// An archive in memory.
pub(super) type Archive<'a> = NpzWriter<&'a mut Cursor<Vec<u8>>>;

/// An archive of the arrays that `fill` adds.
pub(super) fn archive(
    fill: impl FnOnce(&mut Archive) -> Result<(), WriteNpzError>,
) -> Result<Vec<u8>, WriteNpzError> {
    let mut bytes = Cursor::new(Vec::new());
    let mut npz = NpzWriter::new(&mut bytes);
    fill(&mut npz)?;
    npz.finish()?;
    Ok(bytes.into_inner())
}

fn solves(npz: &mut Archive, records: &[&PointRecord]) -> Result<(), WriteNpzError> {
    let numbers = |f: &dyn Fn(&PointRecord) -> f64| records.iter().map(|r| f(r)).collect::<Array1<f64>>();
    let realisation: Array1<i64> = records.iter().map(|r| r.realisation as i64).collect();
    let from_below: Array1<bool> = records.iter().map(|r| r.incidence.from != Side::Incident).collect();
    let mut first = vec![0_i64];
    records.iter().for_each(|r| first.push(first[first.len() - 1] + r.orders.len() as i64));
    npz.add_array("solve_realisation", &realisation)?;
    npz.add_array("solve_wavelength_nm", &numbers(&|r| (1e12 * r.incidence.wavelength_um).round() / 1e9))?;
    npz.add_array("solve_polar_deg", &numbers(&|r| r.incidence.polar_deg))?;
    npz.add_array("solve_azimuth_deg", &numbers(&|r| r.incidence.azimuth_deg))?;
    npz.add_array("solve_from_exit_side", &from_below)?;
    npz.add_array("solve_reflectance", &numbers(&|r| r.reflectance))?;
    npz.add_array("solve_transmittance", &numbers(&|r| r.transmittance))?;
    npz.add_array("solve_absorptance", &numbers(&|r| r.absorptance))?;
    // 0: s, 1: p, −1: the scalar wave
    let polarisation: Array1<i8> = records.iter().map(|r| r.polarisation.map_or(-1, |p| p as i8)).collect();
    npz.add_array("solve_polarisation", &polarisation)?;
    let periods: Vec<[f64; 2]> = records.iter().map(|r| r.period_um).collect();
    npz.add_array("solve_period_um", &arr2(&periods))?;
    npz.add_array("solve_first_order", &Array1::from(first))
}

fn orders(npz: &mut Archive, records: &[&PointRecord]) -> Result<(), WriteNpzError> {
    let all: Vec<Order> = records.iter().flat_map(|r| r.far_field().orders).collect();
    let numbers = |f: &dyn Fn(&Order) -> f64| all.iter().map(f).collect::<Array1<f64>>();
    let amplitudes = |f: &dyn Fn(&Order) -> Complex64| all.iter().map(f).collect::<Array1<_>>();
    npz.add_array("order_m", &all.iter().map(|o| o.m).collect::<Array1<i32>>())?;
    npz.add_array("order_n", &all.iter().map(|o| o.n).collect::<Array1<i32>>())?;
    npz.add_array("order_alpha", &numbers(&|o| o.direction[0]))?;
    npz.add_array("order_beta", &numbers(&|o| o.direction[1]))?;
    npz.add_array("order_reflected", &amplitudes(&|o| o.reflected))?;
    npz.add_array("order_transmitted", &amplitudes(&|o| o.transmitted))?;
    npz.add_array("order_reflected_crossed", &amplitudes(&|o| o.further[0][0]))?;
    npz.add_array("order_transmitted_crossed", &amplitudes(&|o| o.further[0][1]))?;
    npz.add_array("order_reflected_efficiency", &numbers(&|o| o.reflected_efficiency))?;
    npz.add_array("order_transmitted_efficiency", &numbers(&|o| o.transmitted_efficiency))
}
