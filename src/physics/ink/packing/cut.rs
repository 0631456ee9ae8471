//! A layer cut out of a packing by two horizontal planes.

use crate::ink::grains::volume::in_slices;
use crate::ink::{Grain, Packing, Sphere};

impl Grain {
    /// The grain moved along z.
    pub(super) fn lifted(&self, by_um: f64) -> Self {
        let mut moved = self.clone();
        moved.spheres.iter_mut().for_each(|sphere| sphere.center_um[2] += by_um);
        moved.solid.iter_mut().for_each(|solid| solid.center_um[2] += by_um);
        moved
    }

    /// Volume of the grain between z = 0 and z = `height_um`, µm³.
    fn volume_below(&self, height_um: f64) -> f64 {
        let [low, high] = self.extent_um(2);
        if low >= 0.0 && high <= height_um {
            return self.volume_um3;
        }
        let solid = self.solid.as_ref();
        let within = in_slices(&self.spheres, solid, height_um, 1)[0];
        let whole: f64 = self.spheres.iter().map(Sphere::volume_um3).sum();
        // Overlapping spheres of a union are scaled to its volume, as in profiles.
        if solid.is_some() { within } else { self.volume_um3 * within / whole }
    }
}

impl Packing {
    /// The layer between two heights: grains across the planes are cut there, and their volume
    /// inside is what counts. Grains of a cell that is periodic in z continue beyond its faces.
    pub(crate) fn between(mut self, from_um: f64, to_um: f64) -> Self {
        let thickness_um = to_um - from_um;
        let period = self.thickness_um();
        let images = if self.walls() { &[0.0][..] } else { &[-1.0, 0.0, 1.0] };
        let images_inside = |grain: &Grain| -> Vec<Grain> {
            let lifted = images.iter().map(|image| grain.lifted(image * period - from_um));
            lifted.filter(|g| g.extent_um(2)[0] < thickness_um && g.extent_um(2)[1] > 0.0).collect()
        };
        let grains: Vec<Grain> = self.grains().iter().flat_map(images_inside).collect();
        let box_um3 = self.period_um()[0] * self.period_um()[1] * thickness_um;
        for (pigment, share) in self.shares.iter_mut().enumerate() {
            let of_pigment = grains.iter().filter(|grain| grain.pigment == pigment);
            let volume = of_pigment.clone().map(|grain| grain.volume_below(thickness_um)).sum::<f64>();
            share.achieved_fraction = volume / box_um3;
            share.grains = of_pigment.count();
        }
        self.thickness_um = thickness_um;
        self.grains = grains;
        self.walls = false;
        self.cut = true;
        self
    }
}

#[cfg(test)]
mod tests {
    use crate::ink::{PackingRequest, PigmentGrains, Shape, pack};

    fn request(shape: Shape) -> PackingRequest {
        PackingRequest {
            period_um: [1.5, 1.5],
            thickness_um: 1.2,
            pigments: vec![PigmentGrains::of(shape, 200.0, 0.2)],
            ..Default::default()
        }
    }

    /// The parts of a packing have its volume, and a periodic one has the same share everywhere on
    /// the mean. *Planted*: without the images across the faces the lowest part has too little.
    #[test]
    fn the_parts_have_the_volume_of_the_whole() {
        let discs = Shape::Disc { diameter: 1.0, thickness: 0.4 };
        for (shape, walls) in [(Shape::Sphere, true), (Shape::Sphere, false), (discs, false)] {
            // one body sampled on 24² lines: 1e-3 of its volume; two cuts through a tenth of them
            let tolerance = if shape == Shape::Sphere { 1e-12 } else { 1e-4 };
            let whole = PackingRequest { walls, ..request(shape) };
            let all = pack(&whole, &mut ()).unwrap().achieved_fraction(0);
            let cuts = [[0.0, 0.5], [0.5, 1.2]];
            let parts = cuts.map(|cut_um| {
                let part = pack(&PackingRequest { cut_um: Some(cut_um), ..whole.clone() }, &mut ()).unwrap();
                assert!((part.thickness_um() - (cut_um[1] - cut_um[0])).abs() < 1e-12);
                part.thickness_um() / 1.2 * part.achieved_fraction(0)
            });
            let sum: f64 = parts.iter().sum();
            assert!((sum - all).abs() < tolerance, "{walls}: {parts:?} {all}");
        }
    }

    #[test]
    fn cuts_outside_the_packing_or_upside_down_are_refused() {
        for cut_um in [[0.5, 0.2], [0.3, 0.3], [-0.1, 0.5], [0.5, 1.3], [f64::NAN, 1.0], [0.0, f64::INFINITY]]
        {
            let wrong = PackingRequest { cut_um: Some(cut_um), ..request(Shape::Sphere) };
            let error = pack(&wrong, &mut ()).expect_err("refused").to_string();
            assert!(error.contains("cut_um") && error.contains("1.2 µm"), "{error}");
        }
    }

    /// At a wall the outermost tenth of a micrometre lacks grains, at a cut it does not.
    #[test]
    fn cuts_are_not_depleted() {
        let near = |cut_um: [f64; 2], walls: bool| {
            let of = |stream: u64| {
                let request =
                    PackingRequest { walls, stream, cut_um: Some(cut_um), ..request(Shape::Sphere) };
                pack(&request, &mut ()).unwrap().achieved_fraction(0)
            };
            (0..6).map(of).sum::<f64>() / 6.0
        };
        let wall = near([0.0, 0.05], true);
        let cut = near([0.0, 0.05], false);
        // Six cells of 1.5 µm hold some 90 grains at the plane: 0.2 ± 0.02.
        assert!(wall < 0.12 && (cut - 0.2).abs() < 0.06, "{wall} {cut}");
    }
}
