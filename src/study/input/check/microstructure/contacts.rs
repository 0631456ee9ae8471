//! Contacts of soft spheres: simulations of spheres that repel each other by their overlap leave
//! some hundredths of a per cent of a diameter of it, which are taken as contacts. Spheres that
//! have them are shrunk about their centres until they only touch.

use crate::ink::packing::overlap::{SphereOfGrain, SphereOverlap, each_overlap};
use crate::ink::{Grain, PackError, Sphere};
use crate::input::Fault;
use crate::numerics::vector::V3;
use std::ops::ControlFlow;

/// Overlap that is a contact unless the study says another, in diameters of the smaller sphere. The
/// share of volume that shrinking takes is about three times as large at most, far below the error
/// of any measured volume fraction.
const USUAL: f64 = 1e-3;
/// Deeper overlaps, in diameters of the smaller sphere, are no contacts whatever the study says:
/// without them the spheres would be others.
const MOST: f64 = 0.1;
/// Further overlaps are not counted.
const MOST_COUNTED: usize = 1_000_000;

/// Which overlaps are contacts.
#[derive(Clone, Copy, Debug, Default)]
pub struct ContactRule {
    /// The deepest one, µm; `None` for the usual share of the smaller diameter.
    pub overlap_um: Option<f64>,
}

/// Contacts of one cut or several.
#[derive(Clone, Copy, Debug, Default)]
pub struct Contacts {
    /// Overlaps of spheres with each other and with faces of the layer.
    count: usize,
    /// Overlaps among them that are too deep.
    refused: usize,
    /// Deepest overlap, µm, the diameter of the smaller sphere, and its place.
    deepest_um: f64,
    diameter_um: f64,
    place_um: V3,
    /// Volume of the grains before and after their spheres were shrunk, µm³.
    volumes_um3: [f64; 2],
}

impl ContactRule {
    /// The deepest overlap that is a contact of spheres of which the smaller one has this radius,
    /// µm.
    pub fn limit_um(&self, radius_um: f64) -> f64 {
        let diameter = 2.0 * radius_um;
        self.overlap_um.unwrap_or(USUAL * diameter).min(MOST * diameter)
    }

    /// The grains with spheres that touch where they overlapped. If an overlap is too deep, the
    /// grains are of no use.
    ///
    /// # Errors
    /// A grain is wider than the period.
    pub fn resolve(&self, mut grains: Vec<Grain>, cell: V3) -> Result<(Vec<Grain>, Contacts), PackError> {
        let mut contacts = Contacts::default();
        let mut factors: Vec<Vec<f64>> = Vec::new();
        each_overlap(cell, &grains, |SphereOverlap { first, second, depth_um }| {
            let sphere_at = |place: SphereOfGrain| grains[place.grain].spheres[place.sphere];
            let one = sphere_at(first);
            let other = second.map(sphere_at);
            let smaller = other.map_or(one.radius_um, |other| other.radius_um.min(one.radius_um));
            contacts.add(depth_um, Sphere { radius_um: smaller, ..one });
            if depth_um > self.limit_um(smaller) {
                contacts.refused += 1;
                return if contacts.refused < MOST_COUNTED {
                    ControlFlow::Continue(())
                } else {
                    ControlFlow::Break(())
                };
            }
            factors.resize_with(grains.len(), Vec::new);
            // both by the same factor; a face does not give way
            let radii = one.radius_um + other.map_or(0.0, |other| other.radius_um);
            for SphereOfGrain { grain, sphere } in [Some(first), second].into_iter().flatten() {
                let of_grain = &mut factors[grain];
                of_grain.resize(grains[grain].spheres.len(), 1.0);
                of_grain[sphere] = of_grain[sphere].min((radii - depth_um) / radii);
            }
            ControlFlow::Continue(())
        })?;
        if contacts.refused > 0 {
            return Ok((grains, contacts));
        }
        let volume = |grains: &[Grain]| grains.iter().map(|grain| grain.volume_um3).sum::<f64>();
        contacts.volumes_um3[0] = volume(&grains);
        for (grain, factors) in grains.iter_mut().zip(&factors).filter(|(_, factors)| !factors.is_empty()) {
            let mut spheres = std::mem::take(&mut grain.spheres);
            spheres.iter_mut().zip(factors).for_each(|(sphere, factor)| sphere.radius_um *= factor);
            *grain = Grain::new(spheres, grain.pigment);
        }
        contacts.volumes_um3[1] = volume(&grains);
        Ok((grains, contacts))
    }
}

impl Contacts {
    fn add(&mut self, depth_um: f64, smaller: Sphere) {
        self.count += 1;
        if depth_um > self.deepest_um {
            self.deepest_um = depth_um;
            self.diameter_um = 2.0 * smaller.radius_um;
            self.place_um = smaller.center_um;
        }
    }

    /// These contacts and those of another cut.
    pub fn and(self, other: Self) -> Self {
        let deeper = if other.deepest_um > self.deepest_um { other } else { self };
        Self {
            count: self.count + other.count,
            refused: self.refused + other.refused,
            volumes_um3: [0, 1].map(|i| self.volumes_um3[i] + other.volumes_um3[i]),
            ..deeper
        }
    }

    /// What is wrong, if an overlap is too deep.
    pub fn refused(&self, rule: ContactRule) -> Option<Fault> {
        if self.refused == 0 {
            return None;
        }
        let [x, y, z] = self.place_um;
        let more = if self.refused >= MOST_COUNTED { " or more" } else { "" };
        let share = 100.0 * self.deepest_um / self.diameter_um;
        let found = format!(
            "{}{more} pairs of grains (or grains and faces) overlap, by up to {:.3e} µm ({share:.3} % of the smaller sphere's \
             diameter) at ({x:.4}, {y:.4}, {z:.4}) µm",
            self.refused, self.deepest_um
        );
        let limit = match rule.overlap_um {
            Some(overlap) => format!("overlap_um = {overlap}, and a tenth of the smaller diameter"),
            None => "0.1 % of the smaller sphere's diameter (key overlap_um)".to_owned(),
        };
        let allowed = format!(
            "grains apart from each other and from their periodic images, but for contacts up to {limit}"
        );
        let remedy = if self.deepest_um <= MOST * self.diameter_um {
            format!(
                "contacts of soft spheres: write overlap_um = {:.1e} in layer.microstructure, and they are shrunk until they \
                     touch; spheres of one grain share a number in the column grain (mol in dumps)",
                1.05 * self.deepest_um
            )
        } else {
            "such overlaps are no contacts, for which there is overlap_um: spheres of one grain share a number in the column \
             grain (mol in dumps); else correct the sizes"
                .to_owned()
        };
        Some(Fault::new(super::FIELD, found, allowed, remedy))
    }

    /// What was made of the contacts, if there are any.
    pub fn in_words(&self) -> Option<String> {
        let [before, after] = self.volumes_um3;
        (self.count > 0).then(|| {
            format!(
                "layer.microstructure: {} contacts overlap by up to {:.2e} µm ({:.3} % of a diameter); their spheres are shrunk about \
                 their centres until they touch, which takes {:.3} % of the pigment's volume",
                self.count,
                self.deepest_um,
                100.0 * self.deepest_um / self.diameter_um,
                100.0 * (1.0 - after / before)
            )
        })
    }
}
