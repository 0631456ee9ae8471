//! Grains in given places and fractal clusters: what a packing writes, a study reads back, and wrong files are refused with place and count.

mod contacts;
mod positions;
mod realisations;
mod refusals;

use inkwave::ink::{Packing, pack};
use inkwave::input::Study;
use inkwave::input::check::check;
use inkwave::input::fault::Fault;
use inkwave::input::file::StudyFile;
use inkwave::wave::Scene;
use std::path::Path;

const PIGMENTS: &str = "[[pigment]]\nname = 'a'\nindex = 1.9\nshell = [{ thickness_nm = 15, index = 1.3 }]\n\
    [[pigment]]\nname = 'b'\nindex = 1.7\n";
const LIGHT: &str = "[light]\nwavelengths_nm = [500]\n";
/// Keys of a file of positions that states its units.
const STATED: &str = ", unit = 'um', size = 'radius'";

fn study(folder: &Path, text: &str) -> Result<Study, String> {
    let file: StudyFile = toml::from_str(text).map_err(|e| e.to_string())?;
    let told = |faults: Vec<Fault>| {
        faults.iter().map(|fault| format!("{fault}; {}", fault.remedy)).collect::<Vec<String>>().join("; ")
    };
    check(&file, folder, "test").map_err(told)
}

/// A packing of coated spheres and rods, of two pigments.
fn packed(realisation: usize) -> Packing {
    let text = format!(
        "[layer]\nthickness_um = 0.8\nperiod_um = [1.0, 1.2]\ncell = 'fixed'\nbinder.index = 1.5\n{PIGMENTS}{LIGHT}"
    );
    let text = text
        .replace("name = 'a'", "name = 'a'\nvolume_fraction = 0.1\ndiameter_nm = 150")
        .replace("name = 'b'", "name = 'b'\nvolume_fraction = 0.1\ndiameter_nm = 180\nshape = 'cylinder'");
    pack(&study(Path::new("."), &text).expect("a study").packing_request(realisation), &mut ()).expect("room")
}

fn given(folder: &Path, microstructure: &str, period: &str) -> Result<Study, String> {
    let layer = format!(
        "[layer]\nthickness_um = 0.8\nbinder.index = 1.5\n{period}\nmicrostructure = {microstructure}\n"
    );
    study(folder, &format!("{layer}{PIGMENTS}{LIGHT}"))
}

/// A study of one pigment in a cell of 2 × 2 × 1 µm, whose spheres are in a file.
fn cell(folder: &Path, name: &str, text: &str, keys: &str) -> Result<Study, String> {
    std::fs::write(folder.join(name), text).expect("written");
    let period = if text.contains("BOX BOUNDS") || text.contains("Lattice") { "" } else { "period_um = 2" };
    let layer = format!(
        "[layer]\nthickness_um = 1\nbinder.index = 1.5\n{period}\nmicrostructure = {{ spheres = '{name}'{keys} }}\n"
    );
    study(folder, &format!("{layer}[[pigment]]\nname = 'a'\nindex = 1.7\n{LIGHT}"))
}

fn scene(study: &Study) -> Scene {
    Scene::from_packing(&pack(&study.packing_request(0), &mut ()).expect("the given grains"))
}
