//! All claims, one file each (two share the reference cases).

use crate::claim::Claim;

pub mod agreement;
mod bodies;
mod cell_size;
mod coated;
mod colour;
mod composed;
mod dilute;
mod directions;
mod distribution;
pub mod energy;
mod furnace;
mod gradients;
pub mod intervals;
mod layers;
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
mod tau;
mod two_levels;
mod varied_cells;
mod vector;

pub const ALL: [Claim; 34] = [
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
];
