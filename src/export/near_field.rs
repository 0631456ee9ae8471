//! The wave inside the layer as a volume; VTK images (`.vti`): fields on a uniform grid, as
//! ParaView and pyvista open them.

use crate::draw::cell::plain;
use crate::wave::{Field, Problem};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use ndarray::Array2;
use num_complex::Complex64;
use std::f64::consts::TAU;
use std::fmt::Write;

/// Heights per cell of the solver's grid, between whose points the wave is interpolated.
const HEIGHTS_PER_CELL: usize = 4;

/// u(x, y, z), Bloch phase included, on the solver's points in the plane and on evenly spaced
/// heights 0 … H.
///
/// The arrays are `intensity` |u|², 1 for the incident wave alone, `u` (real and imaginary part),
/// and `contrast`, the η² − ⟨η²⟩ that the solver multiplies by: averaged around its planes and
/// band-limited in them.
pub fn image(problem: &Problem, field: &Field) -> Image {
    let grid = &problem.coverage.grid;
    let resolution = problem.coverage.grid.resolution;
    let planes = plane_values(problem, field);
    let contrasts = plane_contrasts(problem);
    let phases = phases(problem);
    let heights = HEIGHTS_PER_CELL * grid.cells() + 1;
    let points = grid.points();
    let mut wave = Vec::with_capacity(heights * points);
    let mut contrast = Vec::with_capacity(heights * points);
    for k in 0..heights {
        let (cell, t) = place(k, grid.cells());
        let shares = grid.element.shape_functions(t);
        let rows: Vec<usize> = grid.planes_of_cell(cell).collect();
        let interpolated = |values: &Array2<Complex64>, i: usize| -> Complex64 {
            rows.iter().zip(shares).map(|(&p, s)| values[[p, i]] * s).sum()
        };
        wave.extend((0..points).map(|i| interpolated(&planes, i) * phases[i]));
        contrast.extend((0..points).map(|i| interpolated(&contrasts, i)));
    }
    let intensity = wave.iter().map(|u| u.norm_sqr() as f32).collect();
    let [lx, ly] = grid.period_um;
    let height = grid.nodes_um[grid.cells()] / (heights - 1) as f64;
    Image {
        points: [resolution.nx, resolution.ny, heights],
        spacing_um: [lx / resolution.nx as f64, ly / resolution.ny as f64, height],
        origin_um: [0.0; 3],
        arrays: vec![
            PointArray { name: "intensity".into(), components: 1, values: intensity },
            PointArray::complex("u".into(), wave),
            PointArray::complex("contrast".into(), contrast),
        ],
    }
}

/// Cell that contains height `k`, and the position within it (0–1).
fn place(k: usize, cells: usize) -> (usize, f64) {
    let cell = (k / HEIGHTS_PER_CELL).min(cells - 1);
    (cell, (k - HEIGHTS_PER_CELL * cell) as f64 / HEIGHTS_PER_CELL as f64)
}

/// The periodic part of the wave at the points of every plane.
fn plane_values(problem: &Problem, field: &Field) -> Array2<Complex64> {
    let mut harmonics = Field::zeros(problem.shape());
    for (plane, mut row) in harmonics.outer_iter_mut().enumerate() {
        if let Some(row) = row.as_slice_mut() {
            problem.mean.inverse.plane_values(&field.view(), plane, row);
        }
    }
    let mut points = Array2::zeros((problem.shape().0, problem.coverage.grid.points()));
    problem.planes_to_points(&harmonics, &mut points);
    points
}

/// η² − ⟨η²⟩ at the points of every plane, averaged over the heights around it.
fn plane_contrasts(problem: &Problem) -> Array2<Complex64> {
    let grid = &problem.coverage.grid;
    let k0 = TAU / problem.incidence.wavelength_um;
    let mut masses = vec![0.0; grid.planes()];
    for cell in 0..grid.cells() {
        for (plane, weight) in grid.planes_of_cell(cell).zip(&grid.element.weights) {
            masses[plane] += grid.height_um(cell) * weight;
        }
    }
    let mut contrasts = Array2::zeros((grid.planes(), grid.points()));
    for (plane, mut row) in contrasts.outer_iter_mut().enumerate() {
        let values = problem.contrast_per_mass(plane, masses[plane]);
        row.iter_mut().zip(values).for_each(|(to, value)| *to = value / (k0 * k0));
    }
    contrasts
}

/// e^{iq·x} with the reduced Bloch vector at the points of a plane, x fastest.
fn phases(problem: &Problem) -> Vec<Complex64> {
    let resolution = problem.coverage.grid.resolution;
    let [lx, ly] = problem.coverage.grid.period_um;
    let [qx, qy] = problem.harmonics.find(0, 0).map_or([0.0; 2], |origin| problem.lateral[origin]);
    (0..problem.coverage.grid.points())
        .map(|i| {
            let x = (i % resolution.nx) as f64 * lx / resolution.nx as f64;
            let y = (i / resolution.nx) as f64 * ly / resolution.ny as f64;
            Complex64::cis(qx * x + qy * y)
        })
        .collect()
}

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
    use crate::ink::Sphere;
    use crate::wave::{Body, BodyShape, Coverage, Incidence, Mean, Media, Resolution, Scene, Scheme, Side};
    use std::sync::Arc;

    /// A ball of the binder's own index scatters nothing: the wave is the plane wave itself, at
    /// every point.
    #[test]
    fn without_contrast_the_wave_is_the_incident_one() {
        let ball = Sphere { center_um: [0.4, 0.3, 0.25], radius_um: 0.2 };
        let scene = Scene::layer([1.0, 0.8], 0.5, vec![Body::new(BodyShape::Balls(vec![ball]), 0)]);
        let one = Complex64::ONE;
        let media = Media { incident: one, exit: one, backgrounds: vec![one], inclusions: vec![one] };
        let incidence =
            Incidence { wavelength_um: 0.5, polar_deg: 50.0, azimuth_deg: 30.0, from: Side::Incident };
        let resolution = Resolution { nx: 12, ny: 10, cells: 5, scheme: Scheme::Cubic };
        let coverage = Arc::new(Coverage::new(&scene, resolution).unwrap());
        let problem = Problem::new(&coverage, &media, &incidence, Mean::default()).unwrap();
        let image = image(&problem, &problem.background_wave());
        let k = TAU / 0.5;
        let theta = 50.0_f64.to_radians();
        let phi = 30.0_f64.to_radians();
        let wave = [theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos()].map(|c| k * c);
        let [nx, ny, nz] = image.points;
        assert_eq!([nx, ny, nz], [12, 10, 21]);
        assert!(image.arrays[2].values.iter().all(|v| v.abs() < 1e-12), "no contrast");
        for i in 0..nx * ny * nz {
            let place = [i % nx, i / nx % ny, i / (nx * ny)];
            let phase: f64 = (0..3).map(|a| wave[a] * place[a] as f64 * image.spacing_um[a]).sum();
            let u = &image.arrays[1].values[2 * i..2 * i + 2];
            // cubic interpolation over a tenth of a micrometre: (k h)^4/384 of the wave
            let apart = (Complex64::new(f64::from(u[0]), f64::from(u[1])) - Complex64::cis(phase)).norm();
            assert!(apart < 2e-3, "{place:?}: {apart}");
        }
    }

    /// Between the middle of a ball and the binder beside it, the contrast steps by η² − η_binder².
    #[test]
    fn the_contrast_in_the_middle_of_a_ball_is_the_balls() {
        let ball = Sphere { center_um: [0.5, 0.4, 0.25], radius_um: 0.2 };
        let scene = Scene::layer([1.0, 0.8], 0.5, vec![Body::new(BodyShape::Balls(vec![ball]), 0)]);
        let binder = Complex64::new(1.5, 0.0);
        let grain = Complex64::new(1.8, 0.1);
        let one = Complex64::ONE;
        let media = Media { incident: one, exit: one, backgrounds: vec![binder], inclusions: vec![grain] };
        let incidence =
            Incidence { wavelength_um: 0.5, polar_deg: 0.0, azimuth_deg: 0.0, from: Side::Incident };
        let resolution = Resolution { nx: 30, ny: 24, cells: 10, scheme: Scheme::Cubic };
        let coverage = Arc::new(Coverage::new(&scene, resolution).unwrap());
        let problem = Problem::new(&coverage, &media, &incidence, Mean::default()).unwrap();
        let image = image(&problem, &problem.background_wave());
        let [nx, ny, nz] = image.points;
        let contrast = |x: usize, y: usize| {
            let place = 2 * (x + nx * (y + ny * (nz / 2)));
            let v = &image.arrays[2].values[place..place + 2];
            Complex64::new(f64::from(v[0]), f64::from(v[1]))
        };
        // Inside minus outside; the ringing of a band-limited edge is below a tenth so far from it.
        let step = contrast(nx / 2, ny / 2) - contrast(0, 0);
        let expected = grain * grain - binder * binder;
        assert!((step - expected).norm() < 0.1 * expected.norm(), "{step} instead of {expected}");
    }

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
