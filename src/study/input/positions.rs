//! Positions of spheres in other programs' files: CSV, LAMMPS dumps and extended XYZ.
//!
//! A file is recognised by its first line that is neither blank nor a remark (`#`). Every row must
//! have as many values as the file names columns: a missing one would shift all that follow.

mod columns;
mod csv;
mod frames;

use super::file::MicrostructureTable;
use crate::ink::Sphere;
use crate::numerics::files;
use frames::{dump_frame, frames, xyz_frame};
use std::path::Path;

/// Spheres of one cut through a material.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Positions {
    /// The spheres, lengths in µm.
    pub spheres: Vec<Sphere>,
    /// Pigment of every sphere as the file calls it; empty if it does not.
    pub pigments: Vec<String>,
    /// The first number where pigments are numbers: 0 in CSV, as in the program's own files, else
    /// 1.
    pub counted_from: usize,
    /// Grain of every sphere; empty if every sphere is one.
    pub grains: Vec<String>,
    /// Lowest and highest x, y, z of the box, if the file has one, µm.
    pub box_um: Option<[[f64; 2]; 3]>,
}

/// All cuts in a file: one in CSV, one per frame otherwise. Files whose columns name no unit leave
/// to `table` the unit of all lengths, and whether the column of sizes holds radii or diameters.
///
/// # Errors
/// In words: what is missing or wrong, with its line.
pub fn read_positions(path: &Path, table: &MicrostructureTable) -> Result<Vec<Positions>, String> {
    let text = files::read_text(path, files::CASE).map_err(|e| e.to_string())?;
    let first = text.lines().map(str::trim).find(|line| !is_passed_over(line)).unwrap_or_default();
    if first.starts_with("ITEM:") {
        frames(&text, dump_frame, table)
    } else if first.parse::<usize>().is_ok() {
        frames(&text, xyz_frame, table)
    } else {
        Ok(vec![csv::from_csv(&text, table)?])
    }
}

/// Whether a line holds no data: it is blank or a remark.
fn is_passed_over(line: &str) -> bool {
    let line = line.trim_start();
    line.is_empty() || line.starts_with('#')
}

#[cfg(test)]
#[path = "positions_tests.rs"]
mod tests;
