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
//!
//! The discrete problem of a scalar solve as NumPy arrays (`.npz`), with its solution:
//! enough to apply the operator without this program, as `python/apply_operator.py` does.
//!
//! Planes are the points of all cells along z: node j is plane `degree` · j, with the inner points
//! of cell j behind it; unknowns are harmonics (columns) of the nodes, and of the bubbles of each
//! cell in the rows of its inner points. Fields on planes are planes × ny × nx.

use crate::run::Collected;
use crate::solve::Account;
use crate::store::record::PointRecord;
use crate::wave::{Coverage, Field, Order, Problem, Scheme, Side};
use ndarray::{Array1, Array2, Array4, arr1, arr2};
use ndarray_npy::{NpzWriter, WriteNpzError};
use num_complex::Complex64;
use std::f64::consts::TAU;
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

/// The archive: grid, media, moments of the coverage, right-hand side, solution and its residual.
///
/// # Errors
/// The archive cannot be made.
pub fn operator(problem: &Problem, field: &Field, account: &Account) -> Result<Vec<u8>, WriteNpzError> {
    archive(|npz| {
        grid(npz, problem)?;
        media(npz, problem)?;
        solution(npz, problem, field, account.residual)
    })
}

/// Right-hand side, solution and its residual.
fn solution(npz: &mut Archive, problem: &Problem, field: &Field, residual: f64) -> Result<(), WriteNpzError> {
    npz.add_array("source", &problem.source())?;
    npz.add_array("solution", field)?;
    npz.add_array("residual", &arr1(&[residual]))
}

/// Points, elements along z, harmonics and their wavenumbers, 1/µm.
fn grid(npz: &mut Archive, problem: &Problem) -> Result<(), WriteNpzError> {
    let grid = &problem.coverage.grid;
    let element = &grid.element;
    npz.add_array("period_um", &arr1(&grid.period_um))?;
    npz.add_array("nodes_um", &arr1(&grid.nodes_um))?;
    // 1 where a cell's waves are exact, 0 for second differences.
    npz.add_array("exact_cells", &arr1(&[i8::from(grid.resolution.scheme != Scheme::SecondDifference)]))?;
    npz.add_array("element_points", &arr1(&element.points))?;
    npz.add_array("element_weights", &arr1(&element.weights))?;
    npz.add_array("bubble_lambda", &arr1(&element.lambda))?;
    let inner = element.degree - 1;
    npz.add_array("bubble_values", &Array2::from_shape_fn((inner, inner), |(b, p)| element.bubbles[b][p]))?;
    npz.add_array("harmonics", &arr2(&problem.harmonics.orders))?;
    npz.add_array("lateral", &arr2(&problem.lateral))?;
    let kappa = &problem.kappa;
    npz.add_array("kappa", &Array2::from_shape_fn((2, kappa[0].len()), |(side, i)| kappa[side][i]))
}

/// k² of the mean medium and of the backgrounds, 1/µm², contrasts k²(η² − η_background²), and the
/// moments of what has them, µm; folded fields belong to pairs of contrasts, µm³.
fn media(npz: &mut Archive, problem: &Problem) -> Result<(), WriteNpzError> {
    let coverage = &problem.coverage;
    let media = &problem.media;
    let k0 = TAU / problem.incidence.wavelength_um;
    let k2 = |eta: Complex64| (k0 * eta) * (k0 * eta);
    let backgrounds = coverage.grid.background.iter().map(|&b| k2(media.backgrounds[b]));
    npz.add_array("mean_k2", &arr1(&problem.mean.mean_k2))?;
    npz.add_array("background_k2", &backgrounds.collect::<Array1<_>>())?;
    let channels = coverage.channels.iter();
    let contrasts = channels.map(|c| k2(media.index_of(c.material)) - k2(media.backgrounds[c.background]));
    npz.add_array("contrasts", &contrasts.collect::<Array1<_>>())?;
    npz.add_array("moments", &on_planes(coverage, &coverage.moments))?;
    let pairs: Vec<[i64; 2]> = coverage.pairs.iter().map(|pair| pair.map(|k| k as i64)).collect();
    npz.add_array("folded_pairs", &arr2(&pairs))?;
    npz.add_array("folded", &on_planes(coverage, &coverage.folded))
}

/// Fields × planes × ny × nx.
fn on_planes(coverage: &Coverage, fields: &[Array2<f64>]) -> Array4<f64> {
    let grid = &coverage.grid;
    let nx = grid.resolution.nx;
    let ny = grid.resolution.ny;
    let shape = (fields.len(), grid.planes(), ny, nx);
    Array4::from_shape_fn(shape, |(f, plane, y, x)| fields[f][[plane, y * nx + x]])
}
