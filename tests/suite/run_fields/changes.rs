//! One change of every field of a study file, and what it moves.

/// What the change of a field changes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Moves {
    /// Spectra, and so everything.
    Spectra,
    /// No solve, but some published number or pixel.
    Published,
    /// No number at all.
    Nothing,
}
use Moves::{Nothing, Published, Spectra};

/// What is written where, the field of interest first; nothing where a key is taken out. And what that moves.
pub type Change = (&'static [(&'static str, &'static str)], Moves);

/// Media around the layer other than air: single angles alone.
const ONE_ANGLE: (&str, &str) = ("angles", "{ polar_deg = [10] }");
const LISTED: (&str, &str) = ("light.sampling", "'listed'");
const RICE: (&str, &str) = ("pigment.1.shape", "'rice_grain'");

pub const CHANGES: &[Change] = &[
    (&[("title", "'Another name'")], Nothing),
    (&[("layer.cell", "'fixed'")], Spectra),
    // As many whole grains as at 0.8 µm in the first realisation, other ones in the second.
    (&[("layer.period_um", "0.81")], Spectra),
    (&[("layer.period_um", "0.85")], Spectra),
    (&[("layer.period_um", "[0.8, 0.9]")], Spectra),
    (&[("layer.thickness_um", "0.41")], Spectra),
    (&[("layer.thickness_um", "{ mean = 0.4, std = 0.02 }")], Spectra),
    (&[("layer.thickness_um", "{ mean = 0.4, std = 0.03 }")], Spectra),
    (&[("layer.binder", "{ index = 1.559 }")], Spectra),
    (&[("layer.binder", "{ index = { n = 1.558, k = 0.001 } }")], Spectra),
    (&[("layer.contrast", "'real'")], Spectra),
    (&[("layer.contrast", "'imaginary'")], Spectra),
    (&[("layer.mixing", "'maxwell-garnett'"), ("pigment.1.diameter_nm", "'molecular'")], Spectra),
    (&[("light.wave", "'s'")], Spectra),
    (&[("light.wave", "'unpolarised'")], Spectra),
    (&[("layer.relief", "{ depth_um = 0.05 }")], Spectra),
    (
        &[(
            "layer.relief",
            "{ depth_um = 0.05, rule = { kind = 'following', follow = 0.5, smoothing_um = 0.1 } }",
        )],
        Spectra,
    ),
    (
        &[(
            "layer.relief",
            "{ depth_um = 0.05, rule = { kind = 'random', rms_um = 0.02, correlation_um = 0.08 } }",
        )],
        Spectra,
    ),
    (
        &[(
            "layer.relief",
            "{ depth_um = 0.05, rule = { kind = 'random', rms_um = 0.02, correlation_um = 0.09 } }",
        )],
        Spectra,
    ),
    (&[("layer.index_in", "1.2"), ONE_ANGLE, LISTED], Spectra),
    (&[("layer.index_out", "1.2"), ONE_ANGLE, LISTED], Spectra),
    (&[("pigment.1.name", "'colourless'")], Nothing),
    (&[("pigment.0.diameter_nm", "161")], Spectra),
    (&[("pigment.0.diameter_nm", "'molecular'")], Spectra),
    (
        &[
            ("pigment.0.size", "{ kind = 'normal', mean_nm = 150, standard_deviation_nm = 5 }"),
            ("pigment.0.diameter_nm", ""),
        ],
        Spectra,
    ),
    (
        &[
            ("pigment.0.size", "{ kind = 'normal', mean_nm = 150, standard_deviation_nm = 6 }"),
            ("pigment.0.diameter_nm", ""),
        ],
        Spectra,
    ),
    (&[("pigment.0.volume_fraction", "0.12")], Spectra),
    (&[("pigment.0.index", "{ n = 1.40, k = 0.2 }")], Spectra),
    (&[("pigment.0.index", "{ n = 1.41, k = 0.1 }")], Spectra),
    (&[("pigment.1.index", "1.46")], Spectra),
    (&[("pigment.0.index", "{ built_in = 'yellow' }")], Spectra),
    (&[("pigment.0.index", "{ material = 'Fe2O3' }")], Spectra),
    (&[RICE, ("pigment.1.diameter_nm", "110")], Spectra),
    (&[("pigment.1.orientation", "'perpendicular'"), RICE, ("pigment.1.diameter_nm", "110")], Spectra),
    (
        &[("pigment.1.agglomeration", "{ degree = 1.0, grains = 2 }"), ("pigment.1.diameter_nm", "80")],
        Spectra,
    ),
    (&[("pigment.1.share", "'scale_sizes'")], Spectra),
    (&[("packing.method", "'relaxation'")], Spectra),
    (&[("packing.relaxation", "{ step = 0.4 }"), ("packing.method", "'relaxation'")], Spectra),
    // What a packing is allowed to take, not what it is.
    (&[("packing.sequential", "{ attempts_per_grain = 100000 }")], Nothing),
    (&[("packing.equilibration", "{ sweeps = 3 }")], Spectra),
    (&[("paper.albedo", "0.8")], Spectra),
    (&[("paper.albedo", "[[400, 0.8], [700, 0.9]]")], Spectra),
    (&[("paper.coupling", "'optical_contact'"), ("layer.index_out", "1.4")], Spectra),
    (&[("light.from_nm", "410"), ("light.step_nm", "145")], Spectra),
    (&[("light.to_nm", "690"), ("light.step_nm", "145")], Spectra),
    (&[("light.step_nm", "100")], Spectra),
    (&[("light.per_realisation", "3")], Spectra),
    (&[("light.sampling", "'listed'")], Spectra),
    (&[("light", "{ wavelengths_nm = [420, 500, 650] }")], Spectra),
    (&[("angles.count", "4")], Spectra),
    (&[("angles.polar_deg", "[0, 30, 45]"), ("angles.count", "")], Spectra),
    (&[("angles.azimuth_deg", "10")], Spectra),
    (&[("angles.picture_max_deg", "50")], Published),
    (&[("run.realisations", "3")], Spectra),
    (&[("run.seed", "8")], Spectra),
    (&[("run.target_delta_e", "0.1")], Nothing),
    (&[("run.target_delta_e", "0.1"), ("run.target_colour", "'natural_light'")], Nothing),
    (&[("resolution.points_per_um", "16")], Spectra),
    (&[("resolution.planes_per_um", "40")], Spectra),
    (&[("resolution.scheme", "'quadratic'")], Spectra),
    (&[("resolution", "{ accuracy = 0.2 }")], Spectra),
    (&[("resolution.per_wavelength", "false")], Nothing),
    (&[("run.failed_packings", "0.5")], Nothing),
    (&[("solver.strategy", "'bicgstab'")], Published),
    (&[("solver.tolerance", "1e-7")], Published),
    (&[("solver.max_applications", "1900")], Nothing),
    (&[("output.picture_pixels", "122")], Published),
    (&[("output.mirrored_sky", "'excluded'")], Spectra),
    (&[("colour.illuminant", "'A'")], Published),
    (&[("colour.observer", "'10'")], Published),
    (&[("colour.summation", "'e308'")], Published),
    (&[("colour.target_lab", "[80, 0, 40]")], Published),
    (&[("paper.measured", "{ csv = 'measured.csv' }"), ("paper.albedo", "")], Spectra),
    (
        &[(
            "paper.fluorescence",
            "{ excitation = [[400, 0.5], [450, 0]], emission = [[450, 0], [500, 1], [550, 0]], yield = 0.5 }",
        )],
        Spectra,
    ),
    (
        &[("dots.ruling_per_cm", "60"), ("dots.spread_um", "40"), ("area", "[{ coverage = [0.5] }]")],
        Published,
    ),
    (
        &[("dots.spread_um", "80"), ("dots.ruling_per_cm", "60"), ("area", "[{ coverage = [0.5] }]")],
        Published,
    ),
    (
        &[
            ("dots.patches", "'grid'"),
            ("dots.ruling_per_cm", "60"),
            ("dots.spread_um", "40"),
            ("area", "[{ coverage = [0.5] }]"),
        ],
        Published,
    ),
    (
        &[
            ("dots.physical_gain", "0.1"),
            ("dots.ruling_per_cm", "60"),
            ("dots.spread_um", "40"),
            ("area", "[{ coverage = [0.5] }]"),
        ],
        Published,
    ),
    (&[("pigment.0.profile", "[[0.0, 0.05], [1.0, 0.15]]"), ("pigment.0.volume_fraction", "")], Spectra),
    (&[("compare.measured", "'measured.csv'")], Published),
    (&[("compare.measured", "'measured.cgats'"), ("compare.patch", "'second'")], Published),
    (&[("compare.measured", "'measured.csv'"), ("compare.unit", "'percent'")], Published),
    (&[("compare.measured", "'conditions.cgats'"), ("compare.condition", "'M1'")], Published),
];

/// Files that studies are compared with.
pub const MEASURED: [(&str, &str); 3] = [
    ("measured.csv", "wavelength_nm,reflectance\n400,0.3\n550,0.8\n700,0.9\n"),
    (
        "measured.cgats",
        "CGATS.17\nBEGIN_DATA_FORMAT\nSAMPLE_NAME SPEC_400 SPEC_550 SPEC_700\nEND_DATA_FORMAT\n\
         BEGIN_DATA\nfirst 20 30 40\nsecond 30 80 90\nEND_DATA\n",
    ),
    (
        "conditions.cgats",
        "CGATS.17\nBEGIN_DATA_FORMAT\nSAMPLE_NAME MEASUREMENT_CONDITION SPEC_400 SPEC_550 SPEC_700\nEND_DATA_FORMAT\n\
         BEGIN_DATA\ninks M0 20 30 40\ninks M1 25 35 45\nEND_DATA\n",
    ),
];

/// Where results go is no number; a layer without walls has no waves; a composed one has other results (`composed`); a
/// stack has layers of its own (claims 33 to 35).
pub const ELSEWHERE: [&str; 5] =
    ["output.folder", "layer.walls", "layer.composed", "layer.microstructure", "stack"];
