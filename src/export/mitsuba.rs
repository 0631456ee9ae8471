//! The ink on its paper as a measured material of the renderer Mitsuba 3: spectral and RGB `.bsdf`,
//! and a scene of each.
//!
//! Stored is f·cos θ_o over a grid of half vectors for each angle of incidence. With θ_m, φ_m the
//! half vector's angles in the frame of the light (φ_i = 0), column and row are u = √(2θ_m/π) and v
//! = (φ_m + π)/2π, both from 0 to 1. In this program light travels towards +x and its mirror image
//! lies at α = +sin θ; the renderer's ω_i points to the source: (α, β) = −(ω_o,x, ω_o,y). The
//! mirror part is a delta, which such a table cannot hold: it is left out and written to
//! `specular.csv`.
//!
//! # The tensor file of measured materials (`.bsdf`)
//!
//! ```text
//! "tensor_file\0"  version 1.0 (2 × u8)  number of fields (u32)
//! for each field:  length of name (u16)  name  number of dimensions (u16)  type (u8)  offset (u64)
//!                  sizes (u64 each)
//! the data of all fields, each at its offset; everything little-endian
//! ```
//! The layout was derived from existing files and is checked with Mitsuba itself
//! (`scripts/check-exports`).

use crate::appearance::tristimulus::Colorimeter;
use crate::appearance::tristimulus::visible;
use crate::evaluate::directional::{Direction, DirectionalPrint};
use crate::evaluate::ink::InkError;
use rayon::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Points along each axis of the half vector's grid. *Measured* against the formula, cos θ > 0.2,
/// median and 95th percentile: 32 points 0.7 % and 8 %, 48 0.3 % and 4 %, 96 0.09 % and 1.5 %.
const POINTS: usize = 96;
/// The renderer divides by the luminance when it draws directions: never 0, at least this share of
/// its mean.
const LEAST_LUMINANCE: f64 = 1e-4;
/// Largest distance of angles of incidence: between them the renderer keeps the half vector.
/// *Measured* with 4.5°, median and 95th percentile: 0.56 % and 3.0 %.
const WIDEST_STEP_DEG: f64 = 3.0;
/// Directions nearer to grazing than this have no orders around them.
const GRAZING_DEG: f64 = 89.9;

/// Everything that the files hold.
#[derive(Clone, Debug)]
pub struct MaterialTable {
    /// Angles of incidence, degrees.
    pub theta_deg: Vec<f64>,
    /// Wavelengths, nm.
    pub wavelengths_nm: Vec<f64>,
    /// f cos θ_o of every angle of incidence: \[wavelength\]\[row φ_m\]\[column θ_m\], flat.
    slabs: Vec<Vec<f64>>,
}

/// Cells of the half vector's grid.
const CELLS: usize = POINTS * POINTS;

impl MaterialTable {
    /// Tabulates the ink.
    pub fn new(ink: &dyn DirectionalPrint) -> Self {
        let theta_deg = incidences(&ink.nodes_deg());
        let slabs = theta_deg.par_iter().map(|&deg| slab(ink, deg)).collect();
        Self { theta_deg, wavelengths_nm: ink.wavelengths_nm().to_vec(), slabs }
    }

    /// The file for the renderer's spectral variants.
    pub fn spectral(&self, description: &str) -> Vec<u8> {
        let angles = self.theta_deg.len();
        let waves = self.wavelengths_nm.len();
        let values = self.slabs.iter().flatten().map(|&x| x as f32).collect();
        let wavelengths = self.wavelengths_nm.iter().map(|&nm| nm as f32).collect();
        let mut fields = self.common(description);
        fields.push(TensorField::floats("wavelengths", &[waves], wavelengths));
        fields.push(TensorField::floats("spectra", &[1, angles, waves, POINTS, POINTS], values));
        tensor_file(&fields)
    }

    /// The file for its RGB variants: linear sRGB, negative channels clipped; and the share of the
    /// cells with light in which a channel was negative and became 0.
    ///
    /// # Errors
    /// Wavelengths that cannot carry a colour.
    pub fn rgb(&self, description: &str) -> Result<(Vec<u8>, f64), InkError> {
        let seen = visible(&self.wavelengths_nm);
        let meter = Colorimeter::new(&self.wavelengths_nm[seen.clone()])?;
        let angles = self.theta_deg.len();
        let mut values = vec![0.0_f32; angles * 3 * CELLS];
        let mut lit = 0_usize;
        let mut clipped = 0_usize;
        for (slab, out) in self.slabs.iter().zip(values.chunks_mut(3 * CELLS)) {
            for cell in 0..CELLS {
                let spectrum: Vec<f64> = spectrum(slab, cell).collect();
                let rgb = meter.linear_rgb(meter.xyz(&spectrum[seen.clone()])?);
                lit += usize::from(spectrum.iter().any(|&x| x > 0.0));
                clipped += usize::from(rgb.iter().any(|&x| x < 0.0));
                (0..3).for_each(|c| out[c * CELLS + cell] = rgb[c].max(0.0) as f32);
            }
        }
        let mut fields = self.common(description);
        fields.push(TensorField::floats("rgb", &[1, angles, 3, POINTS, POINTS], values));
        Ok((tensor_file(&fields), clipped as f64 / lit.max(1) as f64))
    }

    /// Fields of both files. The microfacet tables are flat, so that the renderer's warps leave (u,
    /// v) as they are.
    fn common(&self, description: &str) -> Vec<TensorField> {
        let angles = self.theta_deg.len();
        let radians = self.theta_deg.iter().map(|deg| deg.to_radians() as f32).collect();
        let luminance = self.slabs.iter().flat_map(|slab| mean_over_waves(slab)).collect();
        let flat = |shape: &[usize]| vec![1.0_f32; shape.iter().product()];
        vec![
            TensorField::bytes("description", description.as_bytes().to_vec()),
            TensorField::bytes("jacobian", vec![0]),
            TensorField::floats("phi_i", &[1], vec![0.0]),
            TensorField::floats("theta_i", &[angles], radians),
            TensorField::floats("ndf", &[2, 2], flat(&[2, 2])),
            TensorField::floats("sigma", &[2, 2], flat(&[2, 2])),
            TensorField::floats("vndf", &[1, angles, 2, 2], flat(&[angles, 2, 2])),
            TensorField::floats("luminance", &[1, angles, POINTS, POINTS], luminance),
        ]
    }
}

/// The values of a cell at all wavelengths.
fn spectrum(slab: &[f64], cell: usize) -> impl Iterator<Item = f64> {
    slab.iter().skip(cell).step_by(CELLS).copied()
}

/// Mean over the wavelengths: it only steers where the renderer draws its samples.
fn mean_over_waves(slab: &[f64]) -> Vec<f32> {
    let waves = (slab.len() / CELLS) as f64;
    let means: Vec<f64> = (0..CELLS).map(|cell| spectrum(slab, cell).sum::<f64>() / waves).collect();
    let least = LEAST_LUMINANCE * means.iter().sum::<f64>() / CELLS as f64;
    means.iter().map(|&x| x.max(least).max(f64::from(f32::MIN_POSITIVE)) as f32).collect()
}

/// The rule's angles with points between them, from 0° on.
fn incidences(nodes_deg: &[f64]) -> Vec<f64> {
    let mut angles = vec![nodes_deg[0]];
    for pair in nodes_deg.windows(2) {
        let steps = ((pair[1] - pair[0]) / WIDEST_STEP_DEG).ceil().max(1.0);
        angles.extend((1..=steps as usize).map(|k| pair[0] + (pair[1] - pair[0]) * k as f64 / steps));
    }
    angles
}

/// One angle of incidence; rows v and 1 − v mirror each other.
fn slab(ink: &dyn DirectionalPrint, light_deg: f64) -> Vec<f64> {
    let waves = ink.wavelengths_nm().len();
    let mut slab = vec![0.0; waves * CELLS];
    for row in 0..POINTS.div_ceil(2) {
        for column in 0..POINTS {
            let Some((view, cosine)) = view(light_deg, [row, column]) else { continue };
            for w in 0..waves {
                let value = cosine * ink.brdf(w, light_deg, view).max(0.0);
                slab[w * CELLS + row * POINTS + column] = value;
                slab[w * CELLS + (POINTS - 1 - row) * POINTS + column] = value;
            }
        }
    }
    slab
}

/// The direction that the half vector of a cell mirrors the light into, and its cosine; `None`
/// below the horizon.
fn view(light_deg: f64, [row, column]: [usize; 2]) -> Option<(Direction, f64)> {
    let share = |i: usize| i as f64 / (POINTS - 1) as f64;
    let theta = share(column).powi(2) * FRAC_PI_2;
    let phi = TAU * share(row) - PI;
    let m = [theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos()];
    let light = [light_deg.to_radians().sin(), 0.0, light_deg.to_radians().cos()];
    let along: f64 = light.iter().zip(m).map(|(a, b)| a * b).sum();
    let out: [f64; 3] = std::array::from_fn(|i| 2.0 * along * m[i] - light[i]);
    if along <= 0.0 || out[2] <= 0.0 {
        return None;
    }
    let polar_deg = out[2].min(1.0).acos().to_degrees().min(GRAZING_DEG);
    // the renderer's ω_o against this program's direction cosines: turned by half a turn
    Some((Direction { polar_deg, azimuth_deg: (-out[1]).atan2(-out[0]).to_degrees() }, out[2]))
}

/// A scene that renders at once: a ball and a flat patch of the ink on a grey table, lit by a lamp
/// and a pale sky.
pub fn scene(bsdf_file: &str, title: &str) -> String {
    let title = title.replace("--", "–").replace(['<', '>', '&'], " ");
    include_str!("scene.xml").replace("{bsdf}", bsdf_file).replace("{title}", &title)
}

/// A named array, last axis fastest.
#[derive(Clone, Debug, PartialEq)]
pub struct TensorField {
    /// The name that the reader looks for.
    pub name: &'static str,
    /// Sizes along every axis; their product is the number of values.
    pub shape: Vec<usize>,
    kind: ValueKind,
    bytes: Vec<u8>,
}

/// What a field holds, with the format's number for it.
#[derive(Clone, Copy, Debug, PartialEq)]
enum ValueKind {
    Byte = 1,
    Float = 10,
}

const MAGIC: &[u8; 12] = b"tensor_file\0";
const VERSION: [u8; 2] = [1, 0];
/// Data starts at multiples of this.
const ALIGNMENT: usize = 8;

impl TensorField {
    /// An array of numbers in single precision.
    pub fn floats(name: &'static str, shape: &[usize], values: Vec<f32>) -> Self {
        let bytes = values.iter().flat_map(|x| x.to_le_bytes()).collect();
        Self { name, shape: shape.to_vec(), kind: ValueKind::Float, bytes }
    }

    /// A list of bytes.
    pub fn bytes(name: &'static str, bytes: Vec<u8>) -> Self {
        Self { name, shape: vec![bytes.len()], kind: ValueKind::Byte, bytes }
    }

    /// What the file says of the field, whose data begin at `offset`.
    fn header(&self, offset: usize) -> Vec<u8> {
        let mut header = (self.name.len() as u16).to_le_bytes().to_vec();
        header.extend(self.name.as_bytes());
        header.extend((self.shape.len() as u16).to_le_bytes());
        header.push(self.kind as u8);
        header.extend(std::iter::once(&offset).chain(&self.shape).flat_map(|&n| (n as u64).to_le_bytes()));
        header
    }
}

/// The complete file.
pub fn tensor_file(fields: &[TensorField]) -> Vec<u8> {
    let headers: usize = fields.iter().map(|field| field.header(0).len()).sum();
    let mut out = [MAGIC.as_slice(), &VERSION, &(fields.len() as u32).to_le_bytes()].concat();
    let mut data = vec![0; out.len() + headers];
    for field in fields {
        data.resize(data.len().next_multiple_of(ALIGNMENT), 0);
        out.extend(field.header(data.len()));
        data.extend(&field.bytes);
    }
    data[..out.len()].copy_from_slice(&out);
    data
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mirror_image_is_where_the_half_vector_is_the_normal() {
        let (view, cosine) = view(40.0, [10, 0]).unwrap();
        // rounding of acos near 40°
        assert!((view.polar_deg - 40.0).abs() < 1e-9 && view.azimuth_deg.abs() < 1e-9);
        assert!((cosine - 40.0_f64.to_radians().cos()).abs() < 1e-12);
    }

    #[test]
    fn incidences_keep_the_nodes_and_fill_wide_gaps() {
        assert_eq!(incidences(&[0.0, 2.0, 7.0]), vec![0.0, 2.0, 4.5, 7.0]);
    }

    #[test]
    fn a_field_is_where_its_header_says() {
        let numbers = TensorField::floats("theta_i", &[3], vec![0.0, 0.5, 1.25]);
        let file = tensor_file(&[TensorField::bytes("description", b"ink".to_vec()), numbers]);
        assert_eq!(&file[..12], MAGIC);
        assert_eq!(u32::from_le_bytes(file[14..18].try_into().unwrap()), 2);
        // second header: after 18 bytes and the first one (2 + 11 + 2 + 1 + 8 + 8)
        let second = 18 + 32;
        assert_eq!(&file[second + 2..second + 9], b"theta_i");
        assert_eq!((file[second + 9], file[second + 11]), (1, 10));
        let offset = u64::from_le_bytes(file[second + 12..second + 20].try_into().unwrap()) as usize;
        let at = |i: usize| f32::from_le_bytes(file[offset + 4 * i..offset + 4 * i + 4].try_into().unwrap());
        assert_eq!([at(0), at(1), at(2)], [0.0, 0.5, 1.25]);
        assert_eq!(file.len(), offset + 12);
    }
}
