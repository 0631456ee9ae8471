//! VTK images (`.vti`): fields on a uniform grid, as ParaView and pyvista open them.

use crate::report::cell::plain;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use num_complex::Complex64;
use std::fmt::Write;

/// A named field: `components` numbers per point, x fastest, then y, then z.
#[derive(Clone, Debug)]
pub struct PointArray {
    /// Name that the viewer shows.
    pub name: String,
    /// 1 for numbers, 2 for complex ones.
    pub components: usize,
    /// components × points values.
    pub values: Vec<f32>,
}

/// A grid of points from the origin on.
#[derive(Clone, Debug)]
pub struct Image {
    /// Points along x, y and z.
    pub points: [usize; 3],
    /// Distances between neighbours, µm.
    pub spacing_um: [f64; 3],
    /// Place of the first point, µm.
    pub origin_um: [f64; 3],
    /// Fields on the points.
    pub arrays: Vec<PointArray>,
}

impl PointArray {
    /// A field of complex numbers.
    pub fn complex(name: String, values: impl IntoIterator<Item = Complex64>) -> Self {
        let values = values.into_iter().flat_map(|v| [v.re as f32, v.im as f32]).collect();
        Self { name, components: 2, values }
    }
}

impl Image {
    /// The complete file; arrays are little-endian, base64, preceded by their length in 8 bytes.
    pub fn vti(&self) -> String {
        let extent = self.points.map(|n| format!("0 {}", n - 1)).join(" ");
        let numbers = |x: [f64; 3]| x.map(|x| x.to_string()).join(" ");
        let mut out = format!(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n\
             <ImageData WholeExtent=\"{extent}\" Origin=\"{}\" Spacing=\"{}\">\n<Piece Extent=\"{extent}\">\n<PointData Scalars=\"{}\">\n",
            numbers(self.origin_um),
            numbers(self.spacing_um),
            xml(self.arrays.first().map_or("", |a| a.name.as_str())),
        );
        for array in &self.arrays {
            let _ = writeln!(
                out,
                "<DataArray type=\"Float32\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"binary\">{}</DataArray>",
                xml(&array.name),
                array.components,
                encode(&array.values)
            );
        }
        out + "</PointData>\n</Piece>\n</ImageData>\n</VTKFile>\n"
    }
}

/// Text inside an XML element or attribute.
fn xml(text: &str) -> String {
    plain(text).replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

fn encode(values: &[f32]) -> String {
    let length = 4 * values.len() as u64;
    let bytes: Vec<u8> =
        length.to_le_bytes().into_iter().chain(values.iter().flat_map(|x| x.to_le_bytes())).collect();
    STANDARD.encode(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_array_carries_its_length_and_its_values() {
        let array = PointArray { name: "a<b".into(), components: 1, values: vec![1.5, -2.0] };
        let image =
            Image { points: [2, 1, 1], spacing_um: [0.1; 3], origin_um: [0.0; 3], arrays: vec![array] };
        let text = image.vti();
        assert!(text.contains("Name=\"a&lt;b\"") && text.contains("WholeExtent=\"0 1 0 0 0 0\""));
        let data = text.split("binary\">").nth(1).unwrap().split('<').next().unwrap();
        let bytes = STANDARD.decode(data).unwrap();
        assert_eq!(bytes[..8], 8_u64.to_le_bytes());
        assert_eq!(bytes[8..12], 1.5_f32.to_le_bytes());
    }
}
