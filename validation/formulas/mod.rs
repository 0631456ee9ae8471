//! Independent formulas: closed forms that share no code with the program.

pub mod films;
pub mod form_factors;
pub mod halftone;
pub mod mie;
pub mod opaque;
pub mod returns;
pub mod stacks;
pub mod uniaxial;
