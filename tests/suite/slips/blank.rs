//! Lists without entries, blank names, values where none may stand, and wavelengths in another unit.

use super::{Slip, slip};

/// Slips in the tiny study.
pub const BLANK: &[Slip] = &[
    slip(
        "thickness_um = 0.5",
        "thickness_um = []",
        [
            "layer.thickness_um: found an empty list",
            "one thickness, µm",
            "add [layer.composed]",
            "study.toml:",
        ],
    ),
    slip(
        "thickness_um = 0.5",
        "composed = {}\nthickness_um = []",
        ["layer.thickness_um: found an empty list", "1 to 10000 entries", "greater than 0", "10 to 100 µm"],
    ),
    slip(
        "volume_fraction = 0.15",
        "profile = []",
        ["pigment[0].profile: found an empty list", "[depth, share]", "profile = [[0, 0.1], [1, 0.3]]", ""],
    ),
    slip(
        "volume_fraction = 0.15",
        "profile = [[0, 0], [1, 0]]",
        ["pigment[0].profile: found 0 at every depth", "above 0", "raise one, or remove the pigment", ""],
    ),
    slip(
        "[angles]",
        "[paper]\nalbedo = []\n[angles]",
        [
            "paper.albedo: found an empty list",
            "two or more rows",
            "[wavelength in nm, albedo]",
            "albedo = 0.9",
        ],
    ),
    slip(
        "[angles]",
        "[dots]\nruling_per_cm = 60\nspread_um = 0\n[[area]]\ncoverage = []\n[angles]",
        ["area[0].coverage: found an empty list", "0 to 1", "one or more of them", "[0.25, 0.5, 0.75]"],
    ),
    slip(
        "[angles]",
        "[dots]\nruling_per_cm = 60\nspread_um = 0\n[[ink]]\nname = ' '\ncoverage = 0.5\n[[area]]\ninks = [' ']\n[[area]]\n\
         bears = 'paper'\n[angles]",
        ["ink[0].name: found \" \", a blank name", "a name with a letter or a digit", "name the ink", ""],
    ),
    slip(
        "name = \"yellow\"",
        "name = \"\"",
        ["pigment[0].name: found \"\", a blank name", "a letter or a digit", "name the pigment", ""],
    ),
    slip(
        "diameter_nm = 200",
        "diameter_nm = 200\nagglomeration = { degree = 0.5, grains = { values = [], weights = [] } }",
        ["pigment[0].agglomeration.grains", "found values [] with weights []", "2 to 500 grains", ""],
    ),
    slip(
        "thickness_um = 0.5",
        "composed = { slab_um = 2 }\nthickness_um = 10",
        ["angles.count: found", "directions of its own where it is composed", "remove angles.count", ""],
    ),
    slip(
        super::K,
        "index = { csv = \"angstrom.csv\", n = 1.4 }",
        ["pigment[0].index", "from 3000 to 8000 nm", "look like ångström", "if so, divide them by 10"],
    ),
    slip(
        "[angles]",
        "[compare]\nmeasured = \"angstrom_print.csv\"\n[angles]",
        ["compare.measured", "values from 3000 to 8000 nm", "look like ångström", "if so, divide them by 10"],
    ),
    slip(
        "[angles]",
        "[paper]\nalbedo = [[0.3, 0.8], [20, 0.9]]\n[angles]",
        ["paper.albedo", "from 0.3 to 20 nm", "look like µm", "if so, multiply them by 1000"],
    ),
    slip(
        "planes_per_um = 40",
        "planes_per_um = 4",
        [
            "resolution.planes_per_um: found 4 per µm",
            "cells 0.5 µm high",
            "by 2.9 rad at most",
            "accuracy = 1e-2",
        ],
    ),
    slip(
        "from_nm = 400\nto_nm = 700\nstep_nm = 100",
        "wavelengths_nm = [0.45, 0.55]",
        ["light.wavelengths_nm[0]: found 0.45", "from 100 to 10000 nm", "look like µm", "in nm, times 1000"],
    ),
    slip(
        "from_nm = 400\nto_nm = 700\nstep_nm = 100",
        "wavelengths_nm = 450",
        [
            "light.wavelengths_nm: found integer `450`",
            "a list in brackets, such as [1, 2]",
            "in that form",
            "",
        ],
    ),
];

/// Slips in the tiny stack.
pub const BLANK_IN_STACKS: &[Slip] = &[
    slip(
        "thickness_um = 0.4",
        "thickness_um = []",
        ["layer[1].thickness_um: found an empty list", "one thickness, µm", "add [stack.composed]", ""],
    ),
    slip(
        "name = 'top'",
        "name = ' '",
        ["layer[1].name: found \" \", a blank name", "a letter or a digit", "name the layer", ""],
    ),
    slip(
        "title = 'stack'",
        "title = ' '",
        ["title: found \" \", a blank title", "a letter", "leave it out", ""],
    ),
    slip(
        "[stack]",
        "[stack]\ncomposed = {}",
        ["angles.polar_deg: found [0.0]", "directions of its own", "stack.composed.directions sets them", ""],
    ),
    slip(
        "[angles]\npolar_deg = [0]\n",
        "[resolution]\npoints_per_um = 4\nplanes_per_um = 40\n[stack.composed]\n",
        [
            "resolution.points_per_um: found 4 per µm",
            "in bottom: whole layer",
            "or more: ",
            "accuracy = 1e-2",
        ],
    ),
    slip(
        "[angles]\npolar_deg = [0]\n",
        "[resolution]\npoints_per_um = 12\nplanes_per_um = 5\n[stack.composed]\n",
        [
            "resolution.planes_per_um: found 5 per µm",
            "cells 0.4 µm high in top: whole layer",
            "rad",
            "raise it",
        ],
    ),
];
