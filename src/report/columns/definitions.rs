//! The list of all columns: unit, type and description of each, in the order of the light.

pub(super) const NUMBER: &str = "number";

/// Tables of comparisons.
const COMPARISON: &[&str] = &["comparison.csv", "residuals.csv"];

pub(super) const COLUMNS: &[Definition] = &[
    number("wavelength_nm", "nm", "vacuum wavelength"),
    number(
        "thickness_um",
        "µm",
        "thickness of the layer; of a stack that of the layer with a list of thicknesses, or of all layers where none has one",
    ),
    only(
        &["spectra.csv", "absorbed.csv"],
        number("polar_deg", "°", "polar angle of the incident light, from the layer's normal"),
    ),
    // the layer alone
    only(&["spectra.csv"], plain("reflectance", "layer alone, without paper: total reflectance R")),
    plain(
        "specular_reflectance",
        "layer alone, without paper: R of the cells' specular order, mean |r|², which holds the mirror image and the diffuse light \
         of that order",
    ),
    only(&["spectra.csv"], plain("transmittance", "layer alone, without paper: total transmittance T")),
    plain(
        "specular_transmittance",
        "layer alone, without paper: T of the cells' unscattered order, mean |t|², which holds the coherent light and the diffuse \
         light of that order, more of it the smaller the cell",
    ),
    plain(
        "coherent_transmittance",
        "layer alone, without paper, in composed layers at 0°: coherent transmittance |mean t|², what goes straight on through a \
         layer of any size",
    ),
    only(&["spectra.csv"], plain("absorptance", "layer alone, without paper: absorbed share A")),
    only(
        &["absorbed.csv"],
        plain("absorptance", "share of the light that this layer absorbs, without paper"),
    ),
    plain("reflectance_normal", "layer alone, without paper: R of light at 0°"),
    plain("transmittance_normal", "layer alone, without paper: T of light at 0°"),
    plain("reflectance_45", "layer alone, without paper: R of light at 45°"),
    plain("transmittance_45", "layer alone, without paper: T of light at 45°"),
    plain("reflectance_diffuse", "layer alone, without paper: R of diffuse light, polarised as the study's"),
    only(
        &["instruments.csv"],
        plain("transmittance_diffuse", "layer alone, without paper: T of unpolarised diffuse light"),
    ),
    plain(
        "transmittance_diffuse",
        "layer alone, without paper: T of diffuse light, polarised as the study's",
    ),
    plain(
        "absorptance_behind",
        "layer alone, without paper: absorbed share of unpolarised diffuse light from behind, as the paper sends it",
    ),
    plain("mirrored", "layer alone, without paper: share of light at 0° that is mirrored"),
    only(&["absorbed.csv", "left-out.csv"], words("layer", "name of the layer of the stack")),
    plain("absorptance_normal", "stack alone, without paper: what the layer absorbs of light at 0°"),
    // on the paper
    plain(
        "natural_light",
        "layer on its paper: under a uniform sky, seen along the normal; a perfect white: 1",
    ),
    plain(
        "lit_at_45",
        "layer on its paper: lit at 45° and seen along the normal, π × BRDF; a perfect white: 1",
    ),
    plain("lit_at_45_without", "stack on its paper without this layer: at 45:0"),
    plain("natural_light_without", "stack on its paper without this layer: under a uniform sky"),
    plain("lit_at_45_alone", "this layer of the stack alone on the paper: at 45:0"),
    plain("natural_light_alone", "this layer of the stack alone on the paper: under a uniform sky"),
    plain("density_of_stack", "density of the stack at 45:0, −log₁₀ of its factor over the bare paper's"),
    plain("density_of_layers", "sum of the densities at 45:0 of the stack's layers, each alone on the paper"),
    plain(
        "density_ratio",
        "density_of_stack over density_of_layers (trapping in light): 1 where layers only filter; empty where the sum is below 0.05",
    ),
    plain("sphere_at_8", "layer on its paper: in a sphere, seen at 8° with mirrored light (d:8)"),
    plain("sphere_at_8_excluded", "layer on its paper: in a sphere, seen at 8° without mirrored light (d:8)"),
    plain(
        "diffuse_normal",
        "layer on its paper: under diffuse light, seen along the normal without mirrored light (d:0)",
    ),
    plain("over_black", "layer over black: lit at 45° and seen along the normal, π × BRDF"),
    plain("over_white", "layer over white of albedo 0.8: lit at 45° and seen along the normal, π × BRDF"),
    // prints in dots, and under the lights of instruments
    words("condition", "light of the instrument by ISO 13655, M0 to M2; empty on paper without a brightener"),
    words("print", "the print in words: its condition and the nominal coverages of its inks"),
    plain("nominal_coverage", "coverage as it was asked for: 0 is bare paper, 1 the solid"),
    plain("coverage", "coverage with the physical gain of the dots"),
    plain("spread_share", "share of the light that the paper spreads over dots and paper alike, 0 to 1"),
    only(&["prints.csv"], plain("L", "print at 45:0: L*")),
    only(&["prints.csv"], plain("a", "print at 45:0: a*")),
    only(&["prints.csv"], plain("b", "print at 45:0: b*")),
    plain("apparent_coverage", "coverage by Murray and Davies from Y of paper, print and solid"),
    plain("density", "visual density over the paper, -log10(Y/Y of the paper)"),
    plain("additivity", "of an overprint of solids: its density over the sum of those of its inks"),
    plain("optical_gain", "apparent_coverage less coverage: what the paper's spread of light adds"),
    plain("yule_nielsen_n", "n of Yule and Nielsen that gives Y of the print"),
    plain("radiance_factor", "print at 45:0, a perfect white being 1; above 1 where the paper emits"),
    // distributions
    words("from", "side that the light comes from: incident (z < 0) or exit"),
    number("polar_in_deg", "°", "polar angle of the incident light, from the normal"),
    number("azimuth_in_deg", "°", "azimuth of the incident light, from x towards y"),
    words("lobe", "side that the light leaves to: reflected or transmitted"),
    number("polar_out_deg", "°", "polar angle of the outgoing light, from the normal"),
    number("projected_sr", "sr", "projected solid angle that the direction stands for"),
    integer("m", "index of the order along x"),
    integer("n", "index of the order along y"),
    plain("alpha", "direction cosine kx/k₀ of the outgoing light"),
    plain("beta", "direction cosine ky/k₀ of the outgoing light"),
    Definition {
        kind: "boolean",
        ..plain(
            "specular",
            "whether this is the order (0, 0), a mirror image or straight on, and no density per steradian",
        )
    },
    plain("efficiency", "layer alone, without paper: power of the order over the incident power"),
    number("bdf_per_sr", "1/sr", "layer alone, without paper: BRDF or BTDF"),
    number("bdf_standard_error", "1/sr", "one standard error of bdf_per_sr"),
    integer("realisations", "number of realisations averaged"),
    plain("efficiency_grid_error", "error of the efficiency due to the grid"),
    // what the medium is
    number(
        "absorption_per_um",
        "1/µm",
        "absorption coefficient: of Kubelka and Munk in kubelka-munk.csv, of the packed medium elsewhere",
    ),
    number(
        "scattering_per_um",
        "1/µm",
        "scattering coefficient: of Kubelka and Munk in kubelka-munk.csv, of the packed medium elsewhere",
    ),
    plain("effective_index", "index of the packed medium for coherent light"),
    number("coherent_path_um", "µm", "length over which coherent light falls to 1/e of its power"),
    plain("asymmetry", "mean cosine of the scattering angle"),
    number("transport_path_um", "µm", "transport mean free path"),
    number("kubelka_munk_absorption_per_um", "1/µm", "K of Kubelka and Munk, surfaces off"),
    number("kubelka_munk_scattering_per_um", "1/µm", "S of Kubelka and Munk, surfaces off"),
    number("hiding_thickness_um", "µm", "thickness whose contrast ratio over black and white is 0.98"),
    // weighted numbers
    only(&["numbers.csv"], words("name", "name of the number in the study")),
    only(&["numbers.csv"], words("about", "what is weighted, with which weights, and what is made of it")),
    only(&["numbers.csv"], plain("value", "the weighted number")),
    // a measurement
    plain("measured", "the measurement of [compare]; in conclusions.csv the number that a claim is about"),
    plain("predicted", "layer on its paper, as the measurement sees it"),
    // sweeps
    words("variant", "name of the variant, and of its folder under variants"),
    integer("solves", "number of solves asked for"),
    integer("solves_finished", "number of solves finished"),
    integer("failures", "number of packings and solves without a result"),
    plain("L", "layer on its paper under natural light: L* (CIE 1931 observer, D65)"),
    plain("a", "layer on its paper under natural light: a*"),
    plain("b", "layer on its paper under natural light: b*"),
    plain("C", "layer on its paper under natural light: chroma C*"),
    number("h_deg", "°", "layer on its paper under natural light: hue"),
    plain("delta_e_2000", "colour difference ΔE₀₀ from the reference variant"),
    plain("delta_e_2000_to_target", "colour difference ΔE₀₀ from the target of [compare]"),
    plain("contrast_ratio", "Y over black by Y over white of albedo 0.8"),
    // conclusions
    words("id", "name of the claim"),
    words("statement", "the claim in words"),
    words("inequality", "the claim as a formula"),
    only(&["conclusions.csv"], plain("standard_error", "one standard error of measured")),
    words("verdict", "confirmed, refuted or undecided"),
    words("remark", "what the verdict rests on, and what would decide it"),
    words("source", "where the claim is made"),
    words("quote", "the claim in the source's words"),
    words("translation", "the quote in English"),
    words("because", "why the inequality tests the claim"),
    // a fitted pigment
    only(&["pigment.csv"], plain("n", "real part of the pigment's refractive index")),
    plain("kappa", "imaginary part of the pigment's refractive index, which absorbs"),
    plain("n_error", "one standard error of n"),
    plain("kappa_error", "one standard error of kappa"),
    plain("correlation", "correlation of the errors of n and kappa, −1 to 1"),
    // exports
    only(&["specular.csv"], number("polar_deg", "°", "polar angle of the incident light, from the normal")),
    only(&["specular.csv"], plain("specular_reflectance", "mirror part of R, which the material leaves out")),
    plain(
        "albedo_without_specular",
        "layer on its paper: albedo from the totals R and T, mirror part left out",
    ),
    plain("albedo_of_brdf", "layer on its paper: albedo as the integral of the material's BRDF"),
    plain("difference_standard_error", "one standard error of the difference of both albedos: both parts"),
    plain("difference_by_chance", "its part by chance: jackknife over the realisations"),
    plain(
        "difference_of_fits",
        "its part from fits that differ by more, root mean square over the hemisphere",
    ),
    number("light_polar_deg", "°", "polar angle of the light"),
    number("view_polar_deg", "°", "polar angle of the view"),
    number("azimuth_deg", "°", "azimuth of the view from the direction in which the light travels"),
    number("brdf_per_sr", "1/sr", "layer on its paper: BRDF without the mirror part"),
    only(&["grains.csv"], words("pigment", "name of the pigment")),
    only(&["grains.csv"], integer("grain", "number of the grain")),
    only(&["grains.csv"], words("agglomerate", "number of the agglomerate, if the grain is in one")),
    plain("axis_x", "direction of the grain's axis along x"),
    plain("axis_y", "direction of the grain's axis along y"),
    plain("axis_z", "direction of the grain's axis along z"),
    number("x_um", "µm", "centre of a sphere along x"),
    number("y_um", "µm", "centre of a sphere along y"),
    number("z_um", "µm", "centre of a sphere along z"),
    number("radius_um", "µm", "radius of a sphere"),
    // packings alone
    only(&["statistics.csv"], words("quantity", "what was measured on the packings")),
    only(&["statistics.csv"], words("unit", "unit of the quantity, 1 for shares and counts")),
    only(&["statistics.csv"], plain("mean", "mean over the packings")),
    only(&["statistics.csv"], plain("standard_error", "one standard error of mean")),
    // comparisons
    only(COMPARISON, words("case", "name of the case, where several files are compared")),
    only(COMPARISON, plain("pigment_n", "real part of the first pigment's index, in a matrix of cases")),
    only(COMPARISON, plain("pigment_kappa", "imaginary part of the first pigment's index")),
    only(COMPARISON, number("period_um", "µm", "period of the square cell, in a matrix of cases")),
    only(COMPARISON, words("strategy", "name of the strategy, or of another program")),
    only(COMPARISON, plain("knob", "value of another program's own knob for accuracy")),
    only(COMPARISON, words("mean", "whether the mean medium includes the absorption, or is real")),
    only(COMPARISON, words("scheme", "discretisation along z")),
    only(COMPARISON, integer("nx", "points of the grid along x")),
    only(COMPARISON, integer("ny", "points of the grid along y")),
    only(COMPARISON, integer("cells", "cells of the grid along z")),
    only(COMPARISON, integer("unknowns", "complex unknowns")),
    only(COMPARISON, plain("error", "largest error of any order's amplitude against the reference")),
    only(COMPARISON, plain("error_estimate", "largest error as inkwave solve estimates it")),
    only(COMPARISON, plain("residual", "relative residual of the discrete problem")),
    only(COMPARISON, integer("steps", "steps of the strategy")),
    only(COMPARISON, integer("operator_applications", "applications of the operator")),
    only(COMPARISON, number("seconds", "s", "median wall-clock time of a solve")),
    only(COMPARISON, number("processor_seconds", "s", "median processor time of a solve, all threads")),
    only(COMPARISON, number("own_seconds", "s", "what another program measured of its own solve")),
    only(COMPARISON, number("bytes", "B", "memory of problem and strategy, or of another program")),
    only(COMPARISON, words("outcome", "converged, or why there is no result")),
    only(COMPARISON, words("grid", "grid, scheme and mean in words")),
    only(COMPARISON, integer("look", "number of the recorded residual")),
    only(COMPARISON, plain("applications", "applications of the operator until then")),
];

/// A column as the list defines it.
pub(super) struct Definition {
    /// Tables that it is defined for; empty: all others.
    pub tables: &'static [&'static str],
    pub name: &'static str,
    pub kind: &'static str,
    pub unit: &'static str,
    pub about: &'static str,
}

/// A column of numbers with a unit.
const fn number(name: &'static str, unit: &'static str, about: &'static str) -> Definition {
    Definition { tables: &[], name, kind: NUMBER, unit, about }
}

/// A column of shares, ratios or other numbers without a unit.
const fn plain(name: &'static str, about: &'static str) -> Definition {
    number(name, "", about)
}

/// A column of whole numbers.
const fn integer(name: &'static str, about: &'static str) -> Definition {
    Definition { kind: "integer", ..plain(name, about) }
}

/// A column of words.
const fn words(name: &'static str, about: &'static str) -> Definition {
    Definition { kind: "string", ..plain(name, about) }
}

/// A column of one table, where others of that name hold something else.
const fn only(table: &'static [&'static str], definition: Definition) -> Definition {
    Definition { tables: table, ..definition }
}
