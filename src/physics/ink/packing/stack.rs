//! The packings of the layers of a stack, one above the other, which are checked again all together.

use super::placed::{Method, Packing, PackingAccount};
use super::request::PackingRequest;
use crate::ink::{Grain, PackError, Relief, Share};

/// An error of one layer, with the name of its field in the stack.
pub(super) fn in_layer(error: PackError, i: usize) -> PackError {
    match error {
        PackError::BadInput { field, found, allowed, remedy } => {
            PackError::BadInput { field: format!("layer[{i}].{field}"), found, allowed, remedy }
        }
        other => other,
    }
}

/// Layers that have been packed.
pub(super) struct Stack {
    /// Where the next layer begins, µm.
    top_um: f64,
    thickness_um: f64,
    grains: Vec<Grain>,
    shares: Vec<Share>,
    account: PackingAccount,
    relief: Option<Relief>,
}

impl Stack {
    pub fn new(request: &PackingRequest) -> Self {
        Self {
            top_um: 0.0,
            thickness_um: request.thickness_um,
            grains: Vec::new(),
            shares: Vec::new(),
            account: PackingAccount::new(Method::SequentialAddition, request),
            relief: None,
        }
    }

    /// Adds a packed layer below those that are there.
    pub fn add(&mut self, i: usize, request: &PackingRequest, packing: Packing) {
        let first = self.shares.len();
        let account = packing.account();
        // the method of the layer with most grains stands for all
        if packing.grains().len() > self.grains.len() || self.grains.is_empty() {
            self.account.method = account.method;
        }
        self.account.steps += account.steps;
        self.account.sweeps += account.sweeps;
        self.account.acceptance = self.account.acceptance.or(account.acceptance);
        let notes = account.notes.iter().map(|note| format!("layer {}: {note}", i + 1));
        self.account.notes.extend(notes);
        self.relief = self.relief.take().or_else(|| {
            let beyond_um = self.thickness_um - packing.thickness_um();
            packing.relief().map(|relief| relief.raised(beyond_um))
        });
        self.shares.extend_from_slice(packing.shares());
        for grain in packing.grains() {
            let mut grain = grain.lifted(self.top_um);
            grain.pigment += first;
            self.grains.push(grain);
        }
        self.top_um += request.thickness_um;
    }

    /// The packing of all layers, whose grains are checked against each other once more.
    pub fn proven(self, request: &PackingRequest) -> Result<Packing, PackError> {
        let mut packing = Packing::proven(request, self.grains, self.shares, self.account)?;
        packing.relief = self.relief;
        packing.layers_um = request.layers.iter().map(|layer| layer.request.thickness_um).collect();
        Ok(packing)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ink::statistics::profile;
    use crate::ink::{Joint, PigmentGrains, StackedRequest, pack};

    /// Two inks of 0.6 and 0.4 µm with a clear layer of 0.2 µm between them.
    fn request() -> PackingRequest {
        let cell = PackingRequest { period_um: [1.5, 1.3], seed: 7, ..PackingRequest::default() };
        let layer = |thickness_um: f64, pigments: Vec<PigmentGrains>| StackedRequest {
            request: PackingRequest { thickness_um, pigments, ..cell.clone() },
            joint: Joint::Wall,
        };
        let upper = PigmentGrains::spheres(150.0, 0.2);
        let lower = PigmentGrains::spheres(200.0, 0.1);
        let layers =
            vec![layer(0.6, vec![upper.clone()]), layer(0.2, Vec::new()), layer(0.4, vec![lower.clone()])];
        PackingRequest { thickness_um: 1.2, pigments: vec![upper, lower], layers, ..cell }
    }

    /// Grains stay in their layers, numbered through, and the profile holds them there. *Planted*:
    /// without the offset in z both inks lie in the first layer.
    #[test]
    fn layers_lie_one_above_the_other() {
        let packing = pack(&request(), &mut ()).expect("a packing");
        assert_eq!(packing.layers_um(), [0.6, 0.2, 0.4]);
        for grain in packing.grains() {
            let [low, high] = grain.extent_um(2);
            let [from, to] = [[0.0, 0.6], [0.8, 1.2]][grain.pigment];
            assert!(low >= from - 1e-12 && high <= to + 1e-12, "{low} {high}");
        }
        let profile = profile(&packing, 10);
        assert_eq!(profile.len(), 30);
        for (pigment, layer) in [(0, 0), (1, 2)] {
            let own = &profile[10 * layer..10 * layer + 10];
            let mean = own.iter().map(|slice| slice[pigment]).sum::<f64>() / 10.0;
            // an identity: volumes of the slices add up to that of the grains
            assert!((mean - packing.achieved_fraction(pigment)).abs() < 1e-12, "{mean}");
            let all: f64 = profile.iter().map(|slice| slice[pigment]).sum::<f64>() / 10.0;
            assert!((all - mean).abs() < 1e-12);
        }
    }
}
