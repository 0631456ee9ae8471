//! Keys, layer and pigments.

use super::{Slip, slip};

pub const K: &str = "index = { built_in = \"yellow\" }";

pub const INK: &[Slip] = &[
    // keys
    slip(
        "thickness_um",
        "thicknes_um",
        ["layer.thicknes_um", "unknown key", "`period_um`, `thickness_um`", "did you mean thickness_um?"],
    ),
    slip("[run]", "[runn]", ["runn", "unknown key", "`run`", "did you mean run?"]),
    slip(
        "built_in",
        "builtin",
        ["pigment[0].index.builtin", "unknown key", "`built_in`", "did you mean built_in?"],
    ),
    slip(
        "thickness_um = 0.5\n",
        "",
        ["layer.thickness_um", "found nothing", "no default", "add thickness_um"],
    ),
    slip("seed = 7", "seed = -7", ["run.seed", "-7", "a whole number from 0", "in that form"]),
    slip("seed = 7", "seed = \"7\"", ["run.seed", "string \"7\"", "a whole number from 0", "in that form"]),
    slip(
        "seed = 7",
        "seed = 7\nfailed_packings = 1.5",
        ["run.failed_packings", "1.5", "from 0 to 1", "0.1 leaves out every tenth"],
    ),
    slip("[angles]", "[angles", ["[angles", "unclosed table", "expected `]`", "correct the TOML here"]),
    // layer
    slip(
        "binder.index",
        "relief = { depth_um = 0.1, face = \"bottom\" }\nbinder.index",
        ["layer.relief.face", "bottom", "`incident`, `exit`", "write one of these"],
    ),
    slip(
        "binder.index",
        "relief = { depth_um = 0.9 }\nbinder.index",
        ["layer.relief.depth_um", "0.9", "0 up to the thickness, 0.5 µm", "lower the depth"],
    ),
    slip(
        "period_um = 0.8",
        "period_um = [0.8, 0]",
        ["layer.period_um", "found 0", "greater than 0", "larger cells"],
    ),
    slip(
        "period_um = 0.8",
        "period_um = [1, 2, 3]",
        ["period_um", "3 entries", "two numbers [x, y]", "in that form"],
    ),
    slip(
        "thickness_um = 0.5",
        "thickness_um = nan",
        ["layer.thickness_um", "NaN", "at most 1000 µm", "about 1 µm"],
    ),
    slip(
        "thickness_um = 0.5",
        "thickness_um = inf",
        ["layer.thickness_um", "inf", "at most 1000 µm", "about 1 µm"],
    ),
    slip(
        "thickness_um = 0.5",
        "thickness_um = 500",
        ["layer.thickness_um", "500 µm", "at most 100 µm", "[layer.composed]"],
    ),
    slip(
        "binder.index = 1.558",
        "binder.index = -1.5",
        ["layer.binder.index.n", "-1.5", "from 0.1 to 10", "refractive index"],
    ),
    slip(
        "thickness_um = 0.5",
        "thickness_um = 0.5\nindex_in = 1.5",
        ["layer.index_in", "1.5", "1, air above", "angles.polar_deg"],
    ),
    // pigments
    slip(
        K,
        "index = { n = 1.4, k = -0.1 }",
        ["pigment[0].index.k", "-0.1", "from 0 to 10", "change the sign"],
    ),
    slip(K, "index = { n = nan }", ["pigment[0].index.n", "NaN", "from 0.1 to 10", "refractive index"]),
    slip(
        K,
        "index = { k = 0.1 }",
        ["pigment[0].index", "found k alone", "{ n = …, k = … }", "index = { n = 1.4"],
    ),
    slip(
        K,
        "index = { built_in = \"mauve\" }",
        ["pigment[0].index.built_in", "mauve", "red, yellow, blue, green", "csv"],
    ),
    slip(
        K,
        "index = { built_in = \"TiO2 rutile\" }",
        [
            "pigment[0].index.built_in",
            "TiO2 rutile",
            "red, yellow, blue, green",
            "{ material = \"TiO2 rutile\" }",
        ],
    ),
    slip(
        K,
        "index = { material = \"red\" }",
        ["pigment[0].index.material", "red", "TiO2 rutile", "{ built_in ="],
    ),
    slip(
        K,
        "index = { material = \"rutile\" }",
        ["pigment[0].index.material", "rutile", "did you mean", "TiO2 rutile?"],
    ),
    slip(K, "index = { material = \"chalk\" }", ["pigment[0].index.material", "chalk", "TiO2 rutile", "csv"]),
    slip(
        K,
        "index = { material = \"ZnO\" }",
        ["pigment[0].index", "no value at 400 nm", "from 450 to 4000 nm", "where ZnO is known"],
    ),
    slip(
        K,
        "index = { csv = \"kappa.csv\", kramers_kronig = { n = 1.65 } }",
        ["pigment[0].index.kramers_kronig", "found n alone", "n_nm and n, or n_infinity", "n_nm = 589"],
    ),
    slip(
        K,
        "index = { csv = \"kappa.csv\", n = 1.5, kramers_kronig = { n_infinity = 1.65 } }",
        ["pigment[0].index", "n and kramers_kronig", "either of them", "keep n"],
    ),
    slip(
        K,
        "index = { n = 1.5, kramers_kronig = { n_infinity = 1.65 } }",
        ["pigment[0].index", "n and kramers_kronig", "beside csv or yaml alone", "kappa.csv"],
    ),
    slip(
        K,
        "index = { csv = \"kappa.csv\", dilution = { path_mm = 10, concentration_g_per_l = 0.02, density_g_per_cm3 = 1500 }, n = 1.6 }",
        ["pigment[0].index.dilution.density_g_per_cm3", "1500", "from 0.1 to 30", "organic pigments"],
    ),
    slip(
        K,
        "index = { material = \"PMMA\", n = 1.5 }",
        ["pigment[0].index", "n and material", "{ material = ", "{ n = 1.4, k = 0.1 }"],
    ),
    slip(
        K,
        "index = { csv = \"none.csv\" }",
        ["pigment[0].index.csv", "none.csv", "wavelength_nm,kappa", "relative to the study file"],
    ),
    slip(
        K,
        "index = { csv = \"negative.csv\", n = 1.4 }",
        ["pigment[0].index.csv", "kappa = -0.2", "kappa ≥ 0", "correct the table"],
    ),
    slip(
        K,
        "index = { csv = \"empty.csv\", n = 1.4 }",
        ["pigment[0].index.csv", "line 3, column kappa: an empty cell", "kappa ≥ 0", "correct the table"],
    ),
    slip(
        K,
        "index = { csv = \"micrometres.csv\", n = 1.4 }",
        [
            "pigment[0].index.csv",
            "0.7: these look like µm",
            "the column must be in nm",
            "multiply it by 1000",
        ],
    ),
    slip(
        K,
        "index = { csv = \"wide.csv\" }",
        ["pigment[0].index.csv", "wide.csv: no real part n", "n = 1.4", "write n beside the file"],
    ),
    slip(
        K,
        "index = { csv = \"huge.csv\", n = 1.4 }",
        ["pigment[0].index", "kappa = 100000", "of 0 to 10", "κ is below 1"],
    ),
    slip(
        "[output]",
        "[paper]\nalbedo = [[0.4, 0.8], [0.7, 0.8]]\n[output]",
        ["paper.albedo", "up to 0.7, which look like µm", "wavelengths in nm", "by 1000"],
    ),
    slip(
        "[output]",
        "[colour]\nobserver = 10\n[output]",
        ["colour.observer", "integer `10`", "a string", "quotes, numbers too, such as \"10\""],
    ),
    slip(
        "[output]",
        "[compare]\nmeasured = \"comma.csv\"\n[output]",
        ["compare.measured", "line 2: 3 cells", "(wavelength_nm,reflectance)", "(wavelength_nm;reflectance)"],
    ),
    slip(
        "[output]",
        "[compare]\nmeasured = \"dark.csv\"\n[output]",
        ["compare.measured", "the largest value is 2.9", "compare.unit", "\"percent\" or \"factor\""],
    ),
    slip(
        "[output]",
        "[compare]\nunit = \"percent\"\n[output]",
        ["compare.unit", "percent", "a unit beside compare.measured", "add compare.measured"],
    ),
    slip(
        K,
        "index = { csv = \"narrow.csv\", n = 1.4 }",
        ["pigment[0].index", "400 nm", "from 500 to 600 nm", "[light]"],
    ),
    slip(
        "volume_fraction = 0.15",
        "volume_fraction = 1.5",
        ["pigment[0].volume_fraction", "1.5", "at most 0.64", "0.3 for 30 %"],
    ),
    slip(
        "volume_fraction = 0.15",
        "volume_fraction = 0.7",
        ["pigment[0].volume_fraction", "0.7", "at most 0.64", "0.3 for 30 %"],
    ),
    slip(
        "volume_fraction = 0.15",
        "volume_fraction = -0.1",
        ["pigment[0].volume_fraction", "-0.1", "greater than 0", "0.3 for 30 %"],
    ),
    slip(
        "diameter_nm = 200",
        "diameter_nm = -200",
        ["pigment[0].diameter_nm", "-200", "above 0", "50 to 500 nm"],
    ),
    slip(
        "diameter_nm = 200",
        "diameter_nm = 450",
        ["pigment[0].diameter_nm", "450", "half the shortest side that a varied cell gets", "larger cell"],
    ),
    slip(
        "thickness_um = 0.5",
        "thickness_um = 0.15",
        ["pigment[0].diameter_nm", "200", "150 nm, the layer's thickness", "smaller grains"],
    ),
    slip(
        "diameter_nm = 200",
        "diameter_nm = 1",
        ["pigment[0].diameter_nm", "may hold 1.2e8", "at most 5000000 grains in a cell", "sizes are in nm"],
    ),
    slip(
        "volume_fraction = 0.15",
        "volume_fraction = 1e-12",
        ["pigment[0].volume_fraction", "found 1e-12", "from 4.2e-9, which is half a grain", "smaller grains"],
    ),
    slip(
        "diameter_nm = 200",
        "diameter_nm = \"big\"",
        ["pigment[0].diameter_nm", "\"big\"", "a number of nm such as 250, or \"molecular\"", "in that form"],
    ),
    slip(
        "diameter_nm = 200",
        "size = { kind = \"log_normal\", median_nm = 150, sigma = 0.1 }",
        [
            "pigment[0].size.by",
            "found nothing",
            "by = \"number\", the meaning of older files",
            "by = \"volume\"",
        ],
    ),
    slip(
        "diameter_nm = 200",
        "size = { kind = \"percentiles\", d10_nm = 200, d50_nm = 150, d90_nm = 250 }",
        ["pigment[0].size", "d10 200, d50 150, d90 250 nm", "d10_nm below d50_nm", "correct these numbers"],
    ),
    slip(
        "diameter_nm = 200",
        "size = { kind = \"percentiles\", d10_nm = 120, d50_nm = 150, d90_nm = 220 }",
        ["pigment[0].size", "the log-normal law has d10 110.8", "within 5 %", "kind = \"list\""],
    ),
    slip("diameter_nm = 200", "", ["pigment[0]", "none of them", "diameter_nm or size", "diameter_nm = 250"]),
    slip(
        "name = \"yellow\"",
        "name = \" \"",
        ["pigment[0].name", "\" \", a blank name", "a letter or a digit", "name the pigment"],
    ),
    slip(
        "diameter_nm = 200",
        "diameter_nm = 200\nshell = [{ thickness_nm = 60, index = 1.46 }, { thickness_nm = 40, index = 1.4 }]",
        ["pigment[0].shell", "layers of 100 nm in all", "less than 100.000 nm", "sizes are outer ones"],
    ),
    slip(
        "diameter_nm = 200",
        "diameter_nm = 200\nshell = [{ thickness_nm = 0, index = 1.46 }]",
        ["pigment[0].shell[0].thickness_nm", "found 0", "above 0", "leave the layer out"],
    ),
    slip(
        "diameter_nm = 200",
        "diameter_nm = \"molecular\"\nshell = [{ thickness_nm = 20, index = 1.46 }]",
        ["pigment[0].shell", "thickness_nm = 20", "dissolved pigments", "remove shell"],
    ),
    slip(
        "diameter_nm = 200",
        "diameter_nm = \"molecular\"\nagglomeration = { degree = 1.0, grains = 2 }",
        ["pigment[0].agglomeration", "grains = 2", "dissolved pigments", "remove agglomeration"],
    ),
    slip(
        "diameter_nm = 200",
        "diameter_nm = \"molecular\"\nshape = \"cylinder\"",
        ["pigment[0].shape", "cylinder", "dissolved pigments", "remove shape"],
    ),
    slip(
        "name = \"yellow\"",
        "name = \"yellow\"\nshape = \"cube\"",
        ["shape", "cube", "`sphere`", "write one of"],
    ),
    slip(
        "name = \"yellow\"",
        "name = \"yellow\"\nshape = { kind = \"disc\", thickness = 0.9 }\nagglomeration = { degree = 1, grains = 2, fractal = { dimension = 1.78 } }",
        [
            "pigment[0].agglomeration.fractal",
            "with the shape disc",
            "grains made of spheres",
            "leave `fractal` out",
        ],
    ),
    slip(
        K,
        "index = { csv = \"wide.csv\", kramers_kronig = { n_nm = 100, n = 1.65 } }",
        ["pigment[0].index.kramers_kronig.n_nm", "100", "from 250", "by no pole of the ultraviolet"],
    ),
    slip(
        K,
        "index = { csv = \"wide.csv\", kramers_kronig = { n_nm = 589, n = 1.65, n_error = 2 } }",
        ["pigment[0].index.kramers_kronig.n_error", "found 2", "from 0 to 1", "n = 1.65 by immersion"],
    ),
    slip(
        K,
        "index = { csv = \"negative.csv\", kramers_kronig = { n_infinity = 1.6 } }",
        ["pigment[0].index.csv", "row 1: kappa = -0.2", "kappa ≥ 0 and n > 0", "correct the table"],
    ),
    slip(
        K,
        "index = { yaml = \"negative_square.yml\" }",
        ["pigment[0].index", "a square of n below 0 at 400 nm", "n from 0.1 to 10", "a metal needs a table"],
    ),
    slip(
        K,
        "index = { yaml = \"small_n.yml\" }",
        ["pigment[0].index", "n = 0.01 at 400 nm", "n from 0.1 to 10", "number and coefficients"],
    ),
    slip(
        K,
        "index = { yaml = \"kappa.yml\", n = 1.5, kramers_kronig = { n_infinity = 1.65 } }",
        ["pigment[0].index", "n and kramers_kronig", "either of them", "keep n"],
    ),
    slip(
        K,
        "index = { csv = \"wide.csv\", dilution = { path_mm = 10, concentration_g_per_l = 0.02, density_g_per_cm3 = 1.5 } }",
        ["pigment[0].index", "dilution without n", "either of them beside the file", "kramers_kronig for n"],
    ),
    slip(
        K,
        "index = { csv = \"wide.csv\", n = 1.6, dilution = { path_mm = 0, concentration_g_per_l = 0.02, density_g_per_cm3 = 1.5 } }",
        ["pigment[0].index.dilution.path_mm", "found 0", "greater than 0", "a cuvette has 10 mm"],
    ),
    slip(
        K,
        "index = { csv = \"wide.csv\", n = 1.6, dilution = { path_mm = 10, concentration_g_per_l = 300, density_g_per_cm3 = 1.5 } }",
        [
            "pigment[0].index.dilution.concentration_g_per_l",
            "300, 20 % of the volume",
            "at most 10 % of the volume",
            "check its unit",
        ],
    ),
    // birefringent grains
    slip(
        K,
        "index = { ordinary = 1.6, extraordinary = 1.8 }",
        [
            "pigment[0].index.extraordinary",
            "the scalar wave, which has no polarisation",
            "Maxwell's equations (light.wave = \"unpolarised\"",
            "one index for both rays",
        ],
    ),
    slip(
        K,
        "index = { ordinary = 1.6 }",
        [
            "pigment[0].index",
            "ordinary alone",
            "{ ordinary = …, extraordinary = … } alone",
            "ordinary = 2.61",
        ],
    ),
    slip(
        K,
        "index = { n = 1.6, ordinary = 1.6, extraordinary = 1.8 }",
        ["pigment[0].index", "n, ordinary and extraordinary", "alone", "ordinary = 2.61"],
    ),
    slip(
        K,
        "index = { material = \"BaSO4\", birefringent = true }",
        [
            "pigment[0].index.birefringent",
            "true for \"BaSO4\"",
            "TiO2 rutile, ZnO, CaCO3",
            "remove birefringent",
        ],
    ),
    slip(
        K,
        "index = { ordinary = 1.6, extraordinary = { csv = \"narrow.csv\", n = 1.8 } }",
        [
            "pigment[0].index.extraordinary",
            "no value at 400 nm",
            "from 500 to 600 nm",
            "covers 400 to 700 nm",
        ],
    ),
    slip(
        K,
        "index = 1.6\noptic_axis = [0, 0, 1]",
        ["pigment[0].optic_axis", "one index", "grains with two indices", "remove optic_axis"],
    ),
    slip(
        K,
        "index = { ordinary = 1.6, extraordinary = 1.8 }\noptic_axis = [0, 0, 0]",
        ["pigment[0].optic_axis", "[0.0, 0.0, 0.0]", "finite length above 0", "[0, 0, 1] is usual"],
    ),
    slip(
        "binder.index = 1.558",
        "binder.index = { ordinary = 1.5, extraordinary = 1.6 }",
        ["layer.binder.index", "ordinary and extraordinary", "grains of pigments alone", "give one index"],
    ),
    slip(
        K,
        "index = { ordinary = 1.6, extraordinary = 1.8 }\norientation = \"in_plane\"\n[layer.composed]\nslab_um = 0.25",
        [
            "pigment[0].index.extraordinary",
            "aligned optic axes",
            "\"random\" where the layer is composed",
            "remove orientation",
        ],
    ),
];
