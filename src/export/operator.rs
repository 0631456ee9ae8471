//! The discrete problem of a scalar solve as NumPy arrays (`.npz`), with its solution: whoever has
//! them can apply the operator without this program, as `python/apply_operator.py` does.
//!
//! Planes are the points of all cells along z: node j is plane `degree` · j, with the inner points
//! of cell j behind it; unknowns are harmonics (columns) of the nodes, and of the bubbles of each
//! cell in the rows of its inner points. Fields on planes are planes × ny × nx.

use crate::solve::Account;
use crate::wave::{Coverage, Field, Problem, Scheme};
use ndarray::{Array1, Array2, Array4};
use ndarray_npy::{NpzWriter, WriteNpzError};
use num_complex::Complex64;
use std::f64::consts::TAU;
use std::io::Cursor;

type OperatorArchive<'a> = NpzWriter<&'a mut Cursor<Vec<u8>>>;

/// The archive: grid, media, moments of the coverage, right-hand side, solution and its residual.
///
/// # Errors
/// The archive cannot be made.
pub fn operator(problem: &Problem, field: &Field, account: &Account) -> Result<Vec<u8>, WriteNpzError> {
    let mut bytes = Cursor::new(Vec::new());
    let mut npz = NpzWriter::new(&mut bytes);
    grid(&mut npz, problem)?;
    media(&mut npz, problem)?;
    npz.add_array("source", &problem.source())?;
    npz.add_array("solution", field)?;
    npz.add_array("residual", &Array1::from_elem(1, account.residual))?;
    npz.finish()?;
    Ok(bytes.into_inner())
}

/// Points, elements along z, harmonics and their wavenumbers, 1/µm.
fn grid(npz: &mut OperatorArchive, problem: &Problem) -> Result<(), WriteNpzError> {
    let grid = &problem.coverage.grid;
    let element = &grid.element;
    let list = |values: &[f64]| Array1::from(values.to_vec());
    npz.add_array("period_um", &list(&grid.period_um))?;
    npz.add_array("nodes_um", &list(&grid.nodes_um))?;
    // 1 where a cell's waves are exact, 0 for second differences.
    npz.add_array(
        "exact_cells",
        &Array1::from_elem(1, i8::from(grid.resolution.scheme != Scheme::SecondDifference)),
    )?;
    npz.add_array("element_points", &list(&element.points))?;
    npz.add_array("element_weights", &list(&element.weights))?;
    npz.add_array("bubble_lambda", &list(&element.lambda))?;
    let inner = element.degree - 1;
    npz.add_array("bubble_values", &Array2::from_shape_fn((inner, inner), |(b, p)| element.bubbles[b][p]))?;
    let harmonics = &problem.harmonics.orders;
    npz.add_array("harmonics", &Array2::from_shape_fn((harmonics.len(), 2), |(i, axis)| harmonics[i][axis]))?;
    let lateral = &problem.lateral;
    npz.add_array("lateral", &Array2::from_shape_fn((lateral.len(), 2), |(i, axis)| lateral[i][axis]))?;
    npz.add_array("kappa", &Array2::from_shape_fn((2, lateral.len()), |(side, i)| problem.kappa[side][i]))
}

/// k² of the mean medium and of the backgrounds, 1/µm², contrasts k²(η² − η_background²), and the
/// moments of what has them, µm; folded fields belong to pairs of contrasts, µm³.
fn media(npz: &mut OperatorArchive, problem: &Problem) -> Result<(), WriteNpzError> {
    let (coverage, media) = (&problem.coverage, &problem.media);
    let k0 = TAU / problem.incidence.wavelength_um;
    let k2 = |eta: Complex64| (k0 * eta) * (k0 * eta);
    let backgrounds = coverage.grid.background.iter().map(|&b| k2(media.backgrounds[b]));
    npz.add_array("mean_k2", &Array1::from(problem.mean.mean_k2().to_vec()))?;
    npz.add_array("background_k2", &backgrounds.collect::<Array1<_>>())?;
    let channels = coverage.channels.iter();
    let contrasts = channels.map(|c| k2(media.index_of(c.material)) - k2(media.backgrounds[c.background]));
    npz.add_array("contrasts", &contrasts.collect::<Array1<_>>())?;
    npz.add_array("moments", &on_planes(coverage, &coverage.moments))?;
    let pairs = &coverage.pairs;
    npz.add_array("folded_pairs", &Array2::from_shape_fn((pairs.len(), 2), |(k, i)| pairs[k][i] as i64))?;
    npz.add_array("folded", &on_planes(coverage, &coverage.folded))
}

/// Fields × planes × ny × nx.
fn on_planes(coverage: &Coverage, fields: &[Array2<f64>]) -> Array4<f64> {
    let grid = &coverage.grid;
    let (nx, ny) = (grid.resolution.nx, grid.resolution.ny);
    Array4::from_shape_fn((fields.len(), grid.planes(), ny, nx), |(f, plane, y, x)| {
        fields[f][[plane, y * nx + x]]
    })
}
