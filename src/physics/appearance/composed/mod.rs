//! Layers composed of slabs that the wave equation has solved: adding and doubling of flux
//! matrices.
//!
//! A thick layer is cut into slabs of thickness h. The outermost ones ("skins") are solved together
//! with the layer's surfaces, the inner ones embedded in a medium of nearly the layer's index.
//! Every solve gives the flux of all orders; their azimuthal means on a few [`ordinates`] are the
//! columns of [`flux`] matrices, whose ensemble means are composed incoherently as [`plate`]s:
//!
//! ```text
//! T = T_B (1 − R*_A R_B)⁻¹ T_A      R = R_A + T*_A R_B (1 − R*_A R_B)⁻¹ T_A
//! ```
//!
//! with R*, T* for light from behind (van de Hulst, *Multiple Light Scattering*, 1980).
//! Interference within a slab is kept, between slabs it is lost but for the [`fringes`] of the
//! coherent light; the difference between slabs of h and of h/2 tells what that costs. Light at
//! exactly 0° keeps its coherent part |⟨a⟩|² apart, as a beam. [`transport`] describes the medium
//! that the slabs are.
//!
//! Several layers are a [`stack`]: a list of such elements and of clear layers, with a mean wave
//! that interferes over the whole of it. Adding fluxes alone is off by a factor of 4 in R at 0° of
//! two thin inks; with the mean wave as a film both ways agree within some per cent.

mod fewer_directions;
pub mod flux;
mod fraction;
pub mod fringes;
mod lattice;
pub mod ordinates;
pub mod plate;
pub mod stack;
pub mod transport;
