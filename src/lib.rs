//! Predicts what a printer-ink or paint layer looks like before it exists: solves the wave equation
//! through explicit random packings of pigment grains, and turns the scattered orders into
//! reflectance, colour and a picture.
//!
//! # The path of the light, in ten lines
//!
//! ```
//! use inkwave::appearance::bdf::{Bdf, Lobe};
//! use inkwave::appearance::tristimulus::Colorimeter;
//! use inkwave::ink::{PackingRequest, PigmentGrains, pack};
//! use inkwave::solve::{Gmres, Goal, Silent, Solver};
//! use inkwave::wave::{Incidence, Mean, Media, Problem, Resolution, Scene, Scheme, Side};
//! use num_complex::Complex64;
//!
//! let pigments = vec![PigmentGrains::spheres(200.0, 0.2)]; // 200 nm across, 20 % by volume
//! let request = PackingRequest { period_um: [0.7; 2], thickness_um: 0.3, pigments, ..Default::default() };
//! let scene = Scene::from_packing(&pack(&request, &mut ())?); // grains in their places
//! let yellow = vec![Complex64::new(1.4, 0.1)]; // absorbs: Im η > 0
//! let media = Media { incident: 1.0.into(), exit: 1.0.into(), backgrounds: vec![1.558.into()], inclusions: yellow };
//! let light = Incidence { wavelength_um: 0.45, polar_deg: 0.0, azimuth_deg: 0.0, from: Side::Incident };
//! let grid = Resolution { nx: 15, ny: 15, cells: 4, scheme: Scheme::Cubic };
//! let problem = Problem::from_scene(&scene, &media, &light, grid, Mean::default())?; // (A + V) u = b
//! let solution = Gmres::default().solve(&problem, Goal::default(), &mut Silent)?; // exists only if converged
//! let bdf = Bdf::from_ensemble(&[problem.far_field(&solution.field)])?; // orders → reflection per steradian
//!
//! let reflected = bdf.totals(Lobe::Reflected).total.value;
//! let transmitted = bdf.totals(Lobe::Transmitted).total.value;
//! assert!(reflected > 0.0 && transmitted > 0.3 && reflected + transmitted < 1.0);
//! // Spectra of such numbers become colours; a perfect white stays one.
//! let white = Colorimeter::new(&[400.0, 500.0, 600.0, 700.0])?.colour(&[1.0; 4])?;
//! assert!((white.lab[0] - 100.0).abs() < 1e-9);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! A study file does this for many wavelengths, directions and realisations, on a sufficiently fine
//! grid and with an error bar on every number: `inkwave run examples/yellow.toml`, or [`input`],
//! [`run`] and [`evaluate`] from a program.
//!
//! # The folders
//!
//! They follow the path of the light, and dependencies run one way only. `tests/suite/house.rs`
//! checks this, and that no files form a cycle; a file and the folder of its name count as one
//! module, within which uses may go both ways.
//!
//! ```text
//! numerics ← material ← ink ← wave ← solve ← appearance ← store ← input ← run ← evaluate
//!          ← work ← draw ← report ← design, fit, sweep ← bench, export, schema ← library
//! ```
//!
//! `bench` is a crate of its own, `inkwave-bench`: comparisons of strategies, grids and other
//! programs. It uses the folders up to [`draw`]; of the product, only the command `compare` and
//! [`schema`] use it.
//!
//! [`architecture`] begins with a table of where to look (contrast, paper, error bars, gate), then
//! draws the data flow with the shapes of all arrays.
//!
//! - [`numerics`]: mathematics without physics. Vectors and rotations, reproducible random draws, a
//!   value with its standard error, Fourier planes.
//! - [`material`]: refractive indices η(λ) = n + iκ, as constants, built-in synthetic pigments or
//!   files.
//! - [`ink`]: the geometry. Shapes and sizes of [grains](ink::grains), [packings](ink::packing) by
//!   sequential addition, by relaxation of overlaps or equilibrated, their
//!   [statistics](ink::statistics), and the [relief](ink::Relief) of the binder. A
//!   [`Packing`](ink::Packing) never contains overlapping grains.
//! - [`wave`]: the equation. A [`Scene`](wave::Scene) on a [`Grid`](wave::Grid) gives a
//!   [`Coverage`](wave::Coverage), the geometry's exact Fourier coefficients; with media and an
//!   [`Incidence`](wave::Incidence) it becomes a [`Problem`](wave::Problem), whose solution gives a
//!   [`FarField`](wave::FarField).
//! - [`solve`]: the strategies, behind one trait, [`Solver`](solve::Solver), and measured by one
//!   residual; a [`Registry`](solve::Registry) that strategies of other crates can join;
//!   [`accuracy`](solve::accuracy) searches for the grid that reaches a given error.
//! - [`appearance`]: reflectance and colour. Orders become a [`Bdf`](appearance::bdf::Bdf), or the
//!   lobes of a [lit square](appearance::finite_area::FiniteArea); the layer lies on paper, spectra
//!   become [colours](appearance::colour::Colour).
//! - [`store`]: storage. Records with checksums, written atomically, and the folders that hold them.
//! - [`input`]: study files, checked and turned into a [`Study`](input::study::Study); errors name
//!   field, value, range and remedy.
//! - [`run`]: the computation. One solve, one realisation, a whole study, in parallel on all cores,
//!   within the memory available.
//! - [`evaluate`]: numbers with error bars. Spectra, appearance, the uncertainty budget, the summary.
//! - [`work`]: what is solved together, in which order and by which process; its cost beforehand.
//! - [`draw`]: all drawing. Charts, rasters, the picture of the source paper, and what pages and
//!   tables are made of.
//! - [`report`]: pages and tables of a study.
//! - [`sweep`]: studies of many variants, on one machine or many.
//! - [`design`]: from a target colour to recipes.
//! - [`fit`]: from measured drawdowns to a pigment's index.
//! - [`export`]: other programs' formats.
//! - [`library`]: plates of solved layers, gathered from folders, and the page that composes them.
//! - [`schema`]: JSON Schemas and commented examples of all input files.
//!
//! # Conventions
//!
//! Lengths in µm (sizes of grains and wavelengths of files in nm), angles in degrees from the
//! layer's normal, time factor e^{−iωt}, so that Im η ≥ 0 absorbs. The layer is 0 ≤ z ≤ H; z points
//! from the *incident side* to the *exit side*. Names of fields carry their unit. `CONTRIBUTING.md`
//! has the glossary.
//!
//! # Sources
//!
//! - **P1**: A. G. Voloboy, S. V. Ershov, E. S. Klyshinsky, S. G. Pozdnyakov, *Modelling light
//!   propagation in a thin ink layer of high particle concentration* (in Russian: А. Г. Волобой, С.
//!   В. Ершов, Э. С. Клышинский, С. Г. Поздняков, «Моделирование распространения света в тонком
//!   красящем слое с высокой концентрацией частиц»), Keldysh Institute of Applied Mathematics RAS
//!   and National Research Nuclear University MEPhI, Moscow, about 2010 (the copy at hand names
//!   neither place nor year; its latest grant is of 2010). The whole simulation: geometry,
//!   diffraction, paper, colour, results.
//! - **P2**: A. G. Voloboy, S. V. Ershov, S. G. Pozdnyakov, *Diffraction task solution for lighting
//!   simulation inside ink layer* (in Russian: «Решение дифракционной задачи для моделирования
//!   освещения тонкого красящего слоя»), Keldysh Institute of Applied Mathematics RAS, preprint 75,
//!   Moscow, 2009. The mathematics; equation numbers are P2's unless P1 is named. Where a printed
//!   formula is wrong, the code that corrects it says so.

#![warn(missing_docs)]

#[doc = include_str!("architecture.md")]
pub mod architecture {}

pub mod design;
pub mod export;
pub mod fit;
pub mod library;
pub mod report;
pub mod schema;
pub mod sweep;

pub use inkwave_draw as draw;
pub use inkwave_physics::{appearance, ink, material, numerics, solve, wave};
pub use inkwave_study::{evaluate, input, run, store, work};
