//! Paper, light, angles; run, resolution, solver, output.

use super::{Slip, slip};

const RANGE: &str = "from_nm = 400\nto_nm = 700\nstep_nm = 100";

pub const LIGHT: &[Slip] = &[
    // paper, light, angles
    slip(
        "[light]",
        "[paper]\nalbedo = 1.2\n[light]",
        ["paper.albedo", "1.2", "from 0 to 1", "0.9 is good paper"],
    ),
    slip(
        "[light]",
        "[paper]\nalbedo = 0.9\nmeasured = { csv = \"paper.csv\" }\n[light]",
        ["paper.measured", "a second source of the albedo", "one source of the albedo", "remove one"],
    ),
    slip(
        "[light]",
        "[paper]\nfluorescence = { excitation = [[300, 0.5], [420, 0]], emission = [[400, 0], [440, 1]], yield = 0.5 }\n[light]",
        ["paper.fluorescence", "light from 400 nm", "light that holds what excites", "light.from_nm = 300"],
    ),
    slip(
        "[light]",
        "[paper]\nfluorescence = { excitation = [[500, 0.5], [600, 0.5]], emission = [[400, 0], [430, 1], [460, 0]], yield = 0.5 }\n[light]",
        ["paper.fluorescence.emission", "nothing emitted", "longer waves", "yield = 0 only absorbs"],
    ),
    slip(
        "[light]",
        "[[area]]\ncoverage = 0.7\n[[area]]\ncoverage = 0.4\n[dots]\nruling_per_cm = 60\nspread_um = 40\n[light]",
        ["area.coverage", "a sum of 1.1", "at most 1", "coverages share the area"],
    ),
    slip(
        "[light]",
        "[[area]]\ncoverage = 0.7\n[dots]\nruling_per_cm = 60\n[light]",
        ["dots.spread_um", "found nothing", "since there are areas", "spread_um = 40"],
    ),
    slip(
        "[light]",
        "[[ink]]\nname = \"cyan\"\ncoverage = 0.5\n[[area]]\ninks = [\"magenta\"]\n[dots]\nruling_per_cm = 60\nspread_um = 40\n[light]",
        ["area[0].inks", "magenta", "names of [[ink]]: cyan", "correct the name"],
    ),
    slip(
        "[light]",
        "[[ink]]\nname = \"cyan\"\ncoverage = 0.5\n[[ink]]\nname = \"red\"\ncoverage = 0.5\n[[area]]\ninks = [\"cyan\", \"red\"]\n\
         [dots]\nruling_per_cm = 60\nspread_um = 40\n[light]",
        ["area.inks", "no area of cyan", "every overprint of the inks", "add an [[area]]"],
    ),
    slip(
        "[light]",
        "[[area]]\ncoverage = 0.5\nresults = \"nowhere\"\n[dots]\nruling_per_cm = 60\nspread_um = 40\n[light]",
        ["area[0].results", "nowhere", "a folder of results", "run that study first"],
    ),
    slip(
        "[light]",
        "[[area]]\ncoverage = 0.5\nresults = \" \"\n[dots]\nruling_per_cm = 60\nspread_um = 40\n[light]",
        ["area[0].results", "blanks alone", "a folder", "out/cyan"],
    ),
    slip("[light]", "[paper]\ncoupling = \"glue\"\n[light]", ["coupling", "glue", "`gap`", "write one of"]),
    slip(
        RANGE,
        "wavelengths_nm = []",
        ["light.wavelengths_nm", "0 entries", "1 to 10000 entries", "400 to 700"],
    ),
    slip(
        RANGE,
        "wavelengths_nm = [400, 300]",
        ["light.wavelengths_nm[1]", "300 after 400", "rising", "sort"],
    ),
    slip(
        RANGE,
        "wavelengths_nm = [450, nan]",
        ["light.wavelengths_nm[1]", "NaN", "from 100 to 10000 nm", "nm"],
    ),
    slip(
        RANGE,
        "wavelengths_nm = [0.45]",
        ["light.wavelengths_nm[0]", "0.45", "from 100 to 10000 nm", "in nm"],
    ),
    slip(RANGE, "from_nm = 400", ["light", "found from_nm alone", "wavelengths_nm", "from_nm = 400"]),
    slip(
        "from_nm = 400",
        "from_nm = 1",
        ["light.from_nm", "found 1", "from 100 to 10000 nm", "400 is usual"],
    ),
    slip("step_nm = 100", "step_nm = 0", ["light.step_nm", "found 0", "greater than 0", "20 is usual"]),
    slip("step_nm = 100", "step_nm = 1e-9", ["light.step_nm", "1e-9", "fewer than 10000", "20 is usual"]),
    slip(
        "step_nm = 100",
        "step_nm = 400",
        ["light.step_nm", "found 400", "at most to_nm - from_nm = 300 nm", "wavelengths_nm = [550]"],
    ),
    slip(
        "[light]\nfrom_nm = 400\nto_nm = 700\nstep_nm = 100",
        "[colour]\nsummation = \"e308\"\n[light]\nwavelengths_nm = [400, 500, 700]",
        ["colour.summation", "e308", "ASTM E308 has no weights", "from_nm, to_nm and step_nm"],
    ),
    slip("to_nm = 700", "to_nm = 300", ["light.to_nm", "300", "from_nm = 400", "700 is usual"]),
    slip("to_nm = 700", "to_nm = 900", ["pigment[0].index", "800 nm", "from 380 to 780 nm", "[light]"]),
    slip("count = 3", "polar_deg = [0, 90]", ["angles.polar_deg[1]", "90", "below 90°", "89"]),
    slip("count = 3", "polar_deg = [0, inf]", ["angles.polar_deg[1]", "inf", "below 90°", "89"]),
    slip("count = 3", "count = 3\npolar_deg = [0]", ["angles", "both", "either", "remove one"]),
    slip("count = 3", "count = 0", ["angles.count", "found 0", "3 to 64", "5 is usual"]),
    slip(
        "count = 3",
        "count = 3\npicture_max_deg = 95",
        ["angles.picture_max_deg", "95", "at most 89", "60 is usual"],
    ),
    // run, resolution, solver, output
    slip(
        "realisations = 2",
        "realisations = 0",
        ["run.realisations", "found 0", "from 1 to 100000", "24 small cells are a fair start"],
    ),
    slip(
        "points_per_um = 20\n",
        "",
        ["resolution", "found planes_per_um alone", "either accuracy", "accuracy = 1e-2"],
    ),
    slip(
        "points_per_um = 20",
        "per_wavelength = \"yes\"\npoints_per_um = 20",
        ["resolution.per_wavelength", "found string \"yes\"", "true or false", "in that form"],
    ),
    slip(
        "points_per_um = 20",
        "per_wavelength = true\npoints_per_um = 20",
        ["resolution.per_wavelength", "which are one grid", "with accuracy", "instead of points and planes"],
    ),
    slip(
        "points_per_um = 20",
        "points_per_um = nan",
        ["resolution.points_per_um", "NaN", "from 2 to 400", "12 to 16"],
    ),
    slip(
        "[output]",
        "[packing]\nsequential.attempts_per_grain = 0\n[output]",
        ["packing.sequential.attempts_per_grain", "found 0", "1 or more", "200000 is usual"],
    ),
    slip(
        "[output]",
        "[solver]\ntolerance = 0\n[output]",
        ["solver.tolerance", "found 0", "to 0.01", "leave it out"],
    ),
    slip(
        "[output]",
        "[solver]\nstrategy = \"magic\"\n[output]",
        ["strategy", "magic", "`krylov`", "write one of"],
    ),
    slip(
        "[output]",
        "[solver]\nstrategy = { idr = { shadow_space = 0 } }\n[output]",
        ["solver.strategy.idr.shadow_space", "found 0", "a whole number from 1 to 64", "12 is usual"],
    ),
    slip(
        "[output]",
        "[solver]\nstrategy = { krylov = { guided_modes = { damped = nan } } }\n[output]",
        ["solver.strategy.krylov.guided_modes.damped", "found NaN", "0 or above", "leave it out"],
    ),
    slip(
        "picture_pixels = 61",
        "picture_pixels = 61\nfolder = ' '",
        ["output.folder", "found a blank name", "the path of a folder", "leave it out"],
    ),
    slip(
        "picture_pixels = 61",
        "picture_pixels = 0",
        ["output.picture_pixels", "found 0", "from 16", "360 is usual"],
    ),
];
