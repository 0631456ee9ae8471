//! Memory of a packing, known before its grains are drawn.

use crate::ink::{PackError, PackingRequest};

/// Memory per grain and per sphere, bytes: bodies in their frame and in the cell, up to four cells
/// of a grid per sphere with the lists of their neighbours, contacts, and the grains as they are
/// returned. An estimate from the sizes of these structures.
const GRAIN_BYTES: f64 = 900.0;
const SPHERE_BYTES: f64 = 900.0;

impl PackingRequest {
    /// Refuses a packing that takes more memory than there is, bytes.
    ///
    /// # Errors
    /// [`PackError::BadInput`] with the number of grains and what would do.
    pub fn fits(&self, memory: f64) -> Result<(), PackError> {
        if !self.layers.is_empty() {
            return self.layers.iter().try_for_each(|layer| layer.request.fits(memory));
        }
        let mut grains = 0.0;
        let mut bytes = 0.0;
        let mut count = |number: f64, spheres: f64| {
            grains += number;
            bytes += number * (GRAIN_BYTES + spheres * SPHERE_BYTES);
        };
        let cut = usize::try_from(self.stream).unwrap_or(usize::MAX);
        if let Some(voxels) = self.voxels.get(cut) {
            count(voxels.boxes.len() as f64, 1.0);
        } else if let Some(given) = self.given.get(cut) {
            given.iter().for_each(|grain| count(1.0, grain.spheres.len() as f64));
        } else {
            for pigment in &self.pigments {
                let spheres = pigment.shape.template().spheres.len();
                count(pigment.expected(self.window_um3()), spheres as f64);
            }
        }
        let gb = |bytes: f64| format!("{:.1} GB", 1e-9 * bytes);
        let found = format!("about {grains:.0} grains in the cell, whose packing takes {}", gb(bytes));
        let allowed = format!("the {} of memory that are left", gb(memory));
        let remedy =
            "narrow period_um, take larger grains or a smaller share, or allow more memory (ulimit -v)";
        PackError::unless(bytes <= memory, "period_um", found, allowed, remedy)
    }
}

#[cfg(test)]
mod tests {
    use crate::ink::{PackingRequest, PigmentGrains, Shape};

    /// Refused before a grain is drawn, by the number of grains and of the spheres that make them.
    #[test]
    fn packings_beyond_the_memory_are_refused() {
        let request = |period: f64, shape: Shape| PackingRequest {
            period_um: [period; 2],
            pigments: vec![PigmentGrains::of(shape, 200.0, 0.2)],
            ..Default::default()
        };
        // 0.2 · 600² µm³ over π/6 · 0.2³ µm³: 17 million
        let error = request(600.0, Shape::Sphere).fits(4e9).expect_err("4 GB").to_string();
        assert!(
            error.contains("period_um") && error.contains("17188734 grains") && error.contains("4.0 GB"),
            "{error}"
        );
        assert!(request(60.0, Shape::Sphere).fits(4e9).is_ok());
        let rods = Shape::Cylinder { length_in_radii: 6.0, spheres: 40 };
        assert!(request(60.0, rods.clone()).fits(4e9).is_err() && request(10.0, rods).fits(4e9).is_ok());
    }
}
