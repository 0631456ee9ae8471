//! How layers of grains a few hundred nanometres across look, from the wave equation: packings of
//! grains, their scattered light, and its reflectance, distribution functions and colour.
//!
//! This is the physics of the program `inkwave`, usable without it: no study files, no storage, no
//! pictures. [`first_layer`] solves a first layer, step by step.
//!
//! # The equation
//!
//! A *layer* 0 ≤ z ≤ H repeats along x and y with the periods Lx and Ly. It consists of *grains*
//! (rigid bodies of pigment) in a *binder* (the medium between them). A plane wave of vacuum
//! wavelength λ falls on it from one of the two half-spaces. With k₀ = 2π/λ and the complex
//! refractive index η(x, y, z), the field u obeys
//!
//! ```text
//! Δu + k₀² η² u = 0                        scalar wave
//! ∇ × ∇ × E − k₀² η² E = 0                 Maxwell's equations
//! ```
//!
//! both with exact conditions for waves that leave the layer into the half-spaces. The scalar wave
//! is exact for s-polarised light on plane layers and an approximation for everything else.
//!
//! Lateral periodicity makes u a sum of *harmonics* exp(i(kx x + ky y)) with kx = qx + 2πm/Lx, ky =
//! qy + 2πn/Ly, where (qx, qy) is the lateral wavevector of the light; a harmonic that leaves the
//! layer is the *order* (m, n), and (0, 0) is the specular one. Along z the layer is divided into
//! *cells* (finite elements). With the lateral average ⟨k²⟩ of k₀²η² in every cell and the
//! *contrast* V = k₀²η² − ⟨k²⟩, the discrete equation is
//!
//! ```text
//! (A + V) u = b      or      (1 + A⁻¹V) u = u₀,   u₀ = A⁻¹b
//! ```
//!
//! A is the operator of the *mean medium* ⟨k²⟩, in which every harmonic travels by itself, so that
//! A⁻¹ is exact and cheap; b is the incident wave. A *strategy* (GMRES by default) iterates on the
//! second form; the *residual* of all strategies is ‖u₀ − (1 + A⁻¹V) u‖ / ‖u₀‖. V comes from the
//! exact Fourier coefficients of the grains' cuts with planes, the *coverage*: no voxels.
//!
//! # From orders to colour
//!
//! An order's *efficiency* is its share of the incident power. Their sums are the reflectance R and
//! the transmittance T; the absorptance A is the volume integral of the loss, and R + T + A = 1 up
//! to the residual. Real layers do not repeat, so several random packings (*realisations*) are
//! solved and averaged: what remains of an order in the mean amplitude is its *coherent* part, the
//! rest is *diffuse*. Orders per solid angle make the bidirectional distribution functions (BRDF
//! and BTDF), which approximate those of an endless layer. With paper behind the layer, and over
//! the wavelengths of the visible range, these give reflectance spectra and colours.
//!
//! # Conventions
//!
//! - Time factor e^{−iωt}: η = n + iκ with κ ≥ 0 absorbs.
//! - z points from the *incident side* (z < 0), where light usually comes from, to the *exit side*
//!   (z > H). Angles of incidence are counted from the layer's normal, in the half-space of
//!   incidence.
//! - The incident amplitude is 1. Reflected amplitudes refer to the illuminated face, transmitted
//!   ones to the opposite face.
//! - Lengths are in µm, sizes of grains and wavelengths of spectra in nm, angles in degrees,
//!   distribution functions in sr⁻¹. Names carry the unit (`period_um`, `wavelength_nm`).
//!   Efficiencies and volume fractions are shares of one; R and T are reflectance and transmittance
//!   in this sense.
//! - A value with an error is an [`Estimate`](numerics::estimate::Estimate): a mean with its
//!   standard error over realisations.
//! - Sums do not depend on the number of threads, and a seed reproduces a packing bit for bit.
//!
//! # Modules
//!
//! Dependencies run one way, in the order of the light:
//!
//! - [`numerics`]: vectors, random draws, estimates, Fourier planes, dense matrices.
//! - [`material`]: from names, tables and records to η(λ) of pigments and binders.
//! - [`ink`]: from a request for grains to a [`Packing`](ink::Packing) without overlaps, and its
//!   statistics.
//! - [`wave`]: from a scene, media, light and a grid to the discrete [`Problem`](wave::Problem),
//!   and from its solution to the [`FarField`](wave::FarField).
//! - [`solve`]: from a problem to its [`Solution`](solve::Solution) by one of several strategies;
//!   the grid for a required accuracy.
//! - [`appearance`]: from far fields to distribution functions, paper and colour; thick layers from
//!   thin slabs.
//!
//! # Features
//!
//! None is on by default.
//!
//! - `serde`: types that files hold are read and written by serde. Records of refractiveindex.info
//!   are read, of which the named materials ([`material::named`]) consist.
//! - `schema`: these types have JSON schemas with their allowed ranges.
//! - `lapack`: dense LU through the system's LAPACK instead of faer.
//!
//! # Sources
//!
//! P1 and P2 are papers by A. G. Voloboy, S. V. Ershov and others (Keldysh Institute of Applied
//! Mathematics): *Modelling light propagation in a thin ink layer of high particle concentration*
//! (about 2010), and *Diffraction task solution for lighting simulation inside ink layer*, preprint
//! 75 (2009). Equation numbers are P2's unless P1 is named.

#![warn(missing_docs, unnameable_types)]

pub mod appearance;
pub mod ink;
pub mod material;
pub mod solve;
pub mod wave;

#[doc = include_str!("first_layer.md")]
pub mod first_layer {}

pub use inkwave_numerics as numerics;
