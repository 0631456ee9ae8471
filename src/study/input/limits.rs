//! Allowed ranges of a study's numbers, used by both the checks and the schema.

use crate::numerics::allowed::{Allowed, Each, Whole};
use schemars::Schema;
use schemars::transform::Transform;

/// Relative rounding of a length that messages write with six digits: who types it has typed it.
pub const ROUNDED: f64 = 1e-6;
/// Longer lists of wavelengths or angles are mistakes.
pub const LONGEST_LIST: usize = 10_000;

/// Vacuum wavelength of a case under the key without a unit, µm: larger ones are nm by mistake,
/// smaller ones metres.
pub const LIGHT_UM: Allowed = Allowed::between(0.1, 20.0, "µm");
/// Wavelengths of a case under the key in nm: smaller ones are µm by mistake.
pub const LIGHT_NM: Allowed = Allowed::between(100.0, 20_000.0, "nm");
/// Lengths of a case that need no remark: larger ones may be nm by mistake, smaller ones metres.
pub const USUAL_LENGTH_UM: Allowed = Allowed::between(1e-4, 20.0, "µm");
/// A positive length in a case.
pub const ABOVE_ZERO: Allowed = Allowed::above(0.0, f64::MAX, "µm");
/// A non-negative length in a case.
pub const NOT_NEGATIVE: Allowed = Allowed::between(0.0, f64::MAX, "µm");
/// Thickness of a layer.
pub const THICKNESS_UM: Allowed = Allowed::above(0.0, 1000.0, "µm");
/// Thickness of a single layer with grains that is solved whole.
pub const WHOLE_UM: Allowed = Allowed::above(0.0, 100.0, "µm");
/// Thickness of a stack with grains, all layers together: it is solved whole.
pub const STACK_UM: Allowed = Allowed::above(0.0, 30.0, "µm");
/// Period of a cell.
pub const PERIOD_UM: Allowed = Allowed::above(0.0, 1000.0, "µm");
/// Overlap of given spheres that is taken as a contact.
pub const OVERLAP_UM: Allowed = Allowed::between(0.0, 100.0, "µm");
/// Equal cuts of a file of voxels, along x or y.
pub const CUTS: Whole = Whole::between(1, 100);
/// Edge of a voxel.
pub const VOXEL_NM: Allowed = Allowed::between(0.1, 10_000.0, "nm");
/// Real refractive index.
pub const INDEX: Allowed = Allowed::between(0.1, 10.0, "");
/// Index of the half-spaces that the plates of a library are solved between.
pub const JOINT_INDEX: Allowed = Allowed::between(1.1, 3.0, "");
/// Imaginary part of an index, which absorbs.
pub const ABSORPTION: Allowed = Allowed::between(0.0, 10.0, "");
/// Wavelength at which n is known beside κ: above that of the pole in the ultraviolet.
pub const ANCHOR_NM: Allowed = Allowed::between(250.0, LONGEST_WAVE_NM, "nm");
/// Standard error of a known n.
pub const N_ERROR: Allowed = Allowed::between(0.0, 1.0, "");
/// Path of the light through a dilution.
pub const PATH_MM: Allowed = Allowed::above(0.0, 1000.0, "mm");
/// Mass of a pigment in a litre of a dilution.
pub const CONCENTRATION: Allowed = Allowed::above(0.0, 1000.0, "g/l");
/// Density of a pigment.
pub const DENSITY: Allowed = Allowed::between(0.1, 30.0, "g/cm³");
/// Largest share of a pigment in the volume of a dilution.
pub const DILUTE: f64 = 0.1;
/// Volume fraction: no random packing exceeds 0.64; thin layers reach less, which packing reports.
pub const VOLUME_FRACTION: Allowed = Allowed::above(0.0, 0.64, "");
/// Lightness L* of a print.
pub const LIGHTNESS: Allowed = Allowed::between(0.0, 150.0, "");
/// Coordinates a* and b* of a print.
pub const CHROMA: Allowed = Allowed::between(-300.0, 300.0, "");
/// Albedo of a paper.
pub const ALBEDO: Allowed = Allowed::between(0.0, 1.0, "");
/// Dots per cm of a screen.
pub const RULING_PER_CM: Allowed = Allowed::between(1.0, 1000.0, "per cm");
/// Spread length of a paper.
pub const SPREAD_UM: Allowed = Allowed::between(0.0, 10_000.0, "µm");
/// Physical gain of a coverage of a half.
pub const DOT_GAIN: Allowed = Allowed::between(0.0, 0.25, "");
/// Share of an area, of quanta absorbed, or of quanta emitted.
pub const SHARE: Allowed = Allowed::between(0.0, 1.0, "");
/// Longest vacuum wavelength, nm.
pub const LONGEST_WAVE_NM: f64 = 10_000.0;
/// A vacuum wavelength.
pub const WAVELENGTH_NM: Allowed = Allowed::between(100.0, LONGEST_WAVE_NM, "nm");
/// Vacuum wavelengths.
pub const WAVELENGTHS_NM: Each<Allowed> = Each { entry: WAVELENGTH_NM, most: LONGEST_LIST };
/// Step of a range of wavelengths.
pub const STEP_NM: Allowed = Allowed::above(0.0, LONGEST_WAVE_NM, "nm");
/// Wavelengths of one realisation.
pub const PER_REALISATION: Whole = Whole::between(2, LONGEST_LIST);
/// Directions in a zone of a composed layer.
pub const ZONE_DIRECTIONS: Whole = Whole::between(2, 16);
/// Number of directions: 0°, 45° and at least one stratum.
pub const DIRECTIONS: Whole = Whole::between(3, 64);
/// Angle from the normal.
pub const POLAR_DEG: Allowed = Allowed::below(0.0, 90.0, "°");
/// Angles from the normal.
pub const POLARS_DEG: Each<Allowed> = Each { entry: POLAR_DEG, most: LONGEST_LIST };
/// Largest angle of the picture.
pub const PICTURE_MAX_DEG: Allowed = Allowed::above(0.0, 89.0, "°");
/// Azimuth of the plane of incidence.
pub const AZIMUTH_DEG: Allowed = Allowed::between(-360.0, 360.0, "°");
/// Number of packings.
pub const REALISATIONS: Whole = Whole::between(1, 100_000);
/// Target 95 % interval of colours, ΔE₀₀.
pub const TARGET_DELTA_E: Allowed = Allowed::between(1e-3, 100.0, "");
/// Share of packings without room.
pub const FAILED_PACKINGS: Allowed = Allowed::between(0.0, 1.0, "");
/// Accuracy of an order's amplitude.
pub const ACCURACY: Allowed = Allowed::between(1e-6, 0.3, "");
/// Points or planes of a grid per µm.
pub const PER_UM: Allowed = Allowed::between(2.0, 400.0, "per µm");
/// Relative residual of a solve.
pub const TOLERANCE: Allowed = Allowed::between(1e-13, 1e-2, "");
/// Operator applications of a solve.
pub const APPLICATIONS: Whole = Whole::between(1, 1_000_000);
/// Side of the picture, pixels.
pub const PICTURE_PIXELS: Whole = Whole::between(16, 8192);

/// Attaches the range of each entry to the schema of a list or an array of any length.
#[derive(Clone, Copy, Debug)]
pub struct Entries<T>(pub T);

impl<T: Transform> Transform for Entries<T> {
    fn transform(&mut self, schema: &mut Schema) {
        if let Some(items) = schema.get_mut("items").and_then(|items| items.try_into().ok()) {
            self.0.transform(items);
        }
    }
}
