//! All claims, one file each (two share the reference cases).

use crate::claim::Claim;

pub mod agreement;
mod backing;
mod bodies;
mod cell_size;
mod coated;
mod colour;
mod composed;
mod crystals;
mod dilute;
mod directions;
mod distribution;
pub mod energy;
mod furnace;
mod gradients;
pub mod intervals;
mod kramers_kronig;
mod layers;
mod masstones;
mod maxwell_garnett;
mod molecular;
mod orders;
mod packing;
mod paper;
mod published;
mod reciprocity;
mod references;
mod slab;
mod small_grains;
mod stack_inks;
mod stack_plates;
mod stack_transport;
mod stacks;
mod tau;
mod two_levels;
mod varied_cells;
mod vector;
mod weighted;

pub const ALL: [Claim; 46] = [
    slab::CLAIM,
    layers::CLAIM,
    energy::CLAIM,
    reciprocity::CLAIM,
    tau::CLAIM,
    agreement::CLAIM,
    orders::CLAIM,
    references::ACCURACY,
    dilute::CLAIM,
    molecular::CLAIM,
    packing::CLAIM,
    distribution::CLAIM,
    paper::CLAIM,
    colour::CLAIM,
    references::HONESTY,
    cell_size::CLAIM,
    furnace::CLAIM,
    varied_cells::CLAIM,
    vector::ACCURACY,
    vector::TENSOR,
    directions::SCALAR,
    directions::VECTOR,
    small_grains::CLAIM,
    intervals::CLAIM,
    maxwell_garnett::CLAIM,
    composed::CLAIM,
    coated::CLAIM,
    bodies::CLAIM,
    published::CLAIM,
    two_levels::CLAIM,
    gradients::CLAIM,
    stack_plates::CLAIM,
    stack_transport::CLAIM,
    stack_inks::CLAIM,
    stacks::CLEAR,
    stacks::PLACED,
    stacks::OPEN,
    weighted::NUMBERS,
    weighted::WIDE,
    kramers_kronig::CLAIM,
    masstones::CLAIM,
    backing::MEASURED,
    backing::BRIGHTENED,
    backing::DOTS,
    backing::LATTICE,
    crystals::CLAIM,
];
