//! Checks that a pigment's volume fraction requires at least one grain and no more than can be
//! packed.

use crate::ink::PigmentGrains;
use crate::ink::packing::sizes::{MORE_ROOM, MOST_GRAINS, too_few_grains};
use crate::input::fault::Faults;
use crate::input::file::LayerTable;
use crate::input::variation::{AREA, CellRule};

/// Maximum area of a cell that is enlarged to hold a grain: sides of 1000 µm are the largest
/// allowed.
const WIDEST_UM2: f64 = 1e6;

/// Reports an error in the field `size` or `share` if there are too many or too few grains.
pub(super) fn check(
    [size, share]: [String; 2],
    grains: &PigmentGrains,
    (layer, [x, y]): (&LayerTable, [f64; 2]),
    faults: &mut Faults,
) {
    let thickness_um = layer.thickness_um.mean();
    // an invalid cell is reported separately
    if ![x, y, thickness_um].iter().all(|length| length.is_finite() && *length > 0.0) {
        return;
    }
    let (drawn, widest, cell) = match layer.cell {
        CellRule::Fixed => (x * y, x * y, "the cell"),
        CellRule::Varied => (AREA[1] * x * y, WIDEST_UM2.max(x * y), "the widest cell, 1000 × 1000 µm"),
    };
    let most = grains.expected(drawn * thickness_um);
    let least_share = grains.least_share(widest * thickness_um);
    if most > MOST_GRAINS as f64 {
        let found = format!("grains so small that a cell may hold {most:.1e} of them");
        let remedy = "sizes are in nm and periods in µm; take larger grains, a smaller layer.period_um, or \"molecular\"";
        faults.add(size, found, format!("at most {MOST_GRAINS} grains in a cell"), remedy);
    } else if grains.volume_fraction < least_share {
        let found = format!("{:e}", grains.volume_fraction);
        faults.add(share, found, too_few_grains(least_share, cell), MORE_ROOM);
    }
}
