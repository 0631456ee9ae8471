//! `layer.microstructure`: grains in given places.

use crate::input::limits;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Grains in given places instead of packed ones, from a simulation or a microscope: `spheres` or
/// `voxels`. z runs from the lit face to the paper.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MicrostructureTable {
    /// One file or several, relative to the study file; every cut (a CSV file, a frame of a dump)
    /// is a realisation. CSV with x_um, y_um, z_um and radius_um or diameter_um (or _nm, _mm, _m),
    /// optionally pigment and grain; a LAMMPS dump; extended XYZ. A box in the file must be that of
    /// the layer: its height the thickness, its sides the period.
    #[schemars(example = &"positions.csv")]
    pub spheres: Option<FileNames>,
    /// Unit of the lengths in a dump, an XYZ file, or columns of CSV without a unit.
    #[schemars(example = LengthUnit::Um)]
    pub unit: Option<LengthUnit>,
    /// What the column of sizes in a dump or an XYZ file holds, whatever its name.
    #[schemars(example = SizeColumn::Radius)]
    pub size: Option<SizeColumn>,
    /// Overlap of spheres, of different grains or with a face of the layer, that is taken as a
    /// contact, µm (default: a thousandth of the smaller diameter). Simulations of soft spheres
    /// leave such overlaps; spheres that have them are shrunk about their centres until they only
    /// touch, and the volume that this takes is reported.
    #[schemars(transform = limits::OVERLAP_UM.mark(), example = 0.001)]
    pub overlap_um: Option<f64>,
    /// One file or several of labelled voxels, each a realisation: a NumPy array (.npy) of integers
    /// with axes x, y, z, as PoreSpy writes it, or a stack of TIFF pages (.tif), whose pages are z,
    /// rows y and columns x. Label 0 is the binder. The numbers are taken as they are stored, also
    /// of pictures whose white is 0.
    #[schemars(example = &"cut.npy")]
    pub voxels: Option<FileNames>,
    /// Edge of a voxel, nm: one number or `[x, y, z]`. The layer's thickness must be that of the
    /// voxels along z.
    #[schemars(example = 20)]
    pub voxel_nm: Option<VoxelEdges>,
    /// Pigment of every label (default: label 1 is the first pigment, 2 the second and so on); or
    /// one pigment, to which every label but 0 belongs, as in images with a label for every grain.
    #[schemars(example = BTreeMap::from_iter(Some(("1", "yellow"))))]
    pub labels: Option<LabelPigments>,
    /// How a cut of voxels goes on along x and y (default: `"periodic"`).
    #[schemars(example = Continuation::Mirrored)]
    pub continuation: Option<Continuation>,
    /// Divides each file along x and y into equal cuts, each a realisation (default: `[1, 1]`).
    #[schemars(transform = limits::Entries(limits::CUTS), example = (2, 2))]
    pub cuts: Option<[usize; 2]>,
}

impl MicrostructureTable {
    /// As the schema shows it.
    pub(super) fn example() -> Self {
        Self { spheres: Some(FileNames::One("positions.csv".into())), ..Self::default() }
    }
}

/// One file or several.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(untagged, expecting = "a file name or a list of file names")]
pub enum FileNames {
    /// One file.
    One(String),
    /// Several files.
    Several(Vec<String>),
}

impl FileNames {
    /// All of them.
    pub fn all(&self) -> &[String] {
        match self {
            FileNames::One(file) => std::slice::from_ref(file),
            FileNames::Several(files) => files,
        }
    }
}

/// Pigments of the labels in an image.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(untagged, expecting = "the name of a pigment, or a table of labels with their pigments")]
pub enum LabelPigments {
    /// Every label but 0 is of this pigment.
    One(String),
    /// Pigment of every label.
    Each(BTreeMap<String, String>),
}

/// Edges of a voxel.
#[derive(Clone, Copy, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(untagged, expecting = "one number or [x, y, z], nm")]
pub enum VoxelEdges {
    /// A cube.
    Cube(#[schemars(transform = limits::VOXEL_NM.mark())] f64),
    /// Along x, y and z.
    Each(#[schemars(transform = limits::Entries(limits::VOXEL_NM))] [f64; 3]),
}

impl VoxelEdges {
    /// Along x, y and z, nm.
    pub fn xyz(self) -> [f64; 3] {
        match self {
            VoxelEdges::Cube(edge) => [edge; 3],
            VoxelEdges::Each(edges) => edges,
        }
    }
}

/// How a cut of voxels goes on along x and y.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Continuation {
    /// As it is. Unless the cut is periodic itself, grains are cut off at its faces: that adds
    /// surface, and so scattering, of the order of the grains' size over that of the cut.
    #[default]
    Periodic,
    /// With its mirror images: the cell is twice as wide along x and y and has no seams, but grains
    /// at the faces become symmetric pairs, and order within the cell is that of one cut.
    Mirrored,
}

/// Unit of the lengths in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum LengthUnit {
    /// Micrometres.
    Um,
    /// Nanometres.
    Nm,
    /// Millimetres.
    Mm,
    /// Metres.
    M,
}

impl LengthUnit {
    /// The unit in µm.
    pub fn um(self) -> f64 {
        match self {
            LengthUnit::Um => 1.0,
            LengthUnit::Nm => 1e-3,
            LengthUnit::Mm => 1e3,
            LengthUnit::M => 1e6,
        }
    }
}

/// Meaning of a column of sizes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SizeColumn {
    /// Radii.
    Radius,
    /// Diameters.
    Diameter,
}
