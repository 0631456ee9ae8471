//! The packings of the layers of a stack, one above the other, checked again all together.

use super::placed::{Method, Packing, PackingAccount};
use super::request::{PackingRequest, PigmentGrains, StackedRequest};
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

/// Layers with open joints as one layer: centres of grains start in their own one, as many pass a
/// joint one way as the other while they move apart, and grains reach across.
pub(super) fn joined(group: &[StackedRequest]) -> PackingRequest {
    let thickness_um = group.iter().map(|layer| layer.request.thickness_um).sum::<f64>();
    let relief = group.iter().find_map(|layer| layer.request.relief);
    let usual = group.iter().map(|layer| layer.request.usual_fraction());
    let mut whole = PackingRequest {
        thickness_um,
        pigments: Vec::new(),
        relief,
        usual_fraction: Some(usual.fold(0.0, f64::max)),
        ..group[0].request.clone()
    };
    let window_um3 = whole.window_um3();
    let mut from_um = 0.0;
    for StackedRequest { request, .. } in group {
        let to_um = from_um + request.thickness_um;
        let ends = [from_um / thickness_um, (to_um / thickness_um).min(1.0)];
        for pigment in &request.pigments {
            let share = pigment.volume_fraction * request.window_um3() / window_um3;
            let profile = within(&pigment.profile, ends);
            whole.pigments.push(PigmentGrains { volume_fraction: share, profile, ..pigment.clone() });
        }
        from_um = to_um;
    }
    whole
}

/// A profile of one layer between the depths at which it begins and ends, with nothing beyond.
fn within(profile: &[[f64; 2]], [from, to]: [f64; 2]) -> Vec<[f64; 2]> {
    let even = [[0.0, 1.0], [1.0, 1.0]];
    let own = if profile.is_empty() { &even } else { profile };
    let mut rows = vec![[0.0, 0.0], [from, 0.0]];
    rows.extend(own.iter().map(|[depth, density]| [(from + (to - from) * depth).min(to), *density]));
    rows.extend([[to, 0.0], [1.0, 0.0]]);
    rows
}

/// Layers that have been packed.
pub(super) struct Stack {
    /// Where the next layer begins, µm.
    top_um: f64,
    thickness_um: f64,
    /// Number of layers so far.
    layers: usize,
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
            layers: 0,
            grains: Vec::new(),
            shares: Vec::new(),
            account: PackingAccount::new(Method::SequentialAddition, request),
            relief: None,
        }
    }

    /// Number of the layers that are packed.
    pub fn layers(&self) -> usize {
        self.layers
    }

    /// Adds a packed layer, or several with open joints, below those that are there.
    pub fn add(&mut self, group: &[StackedRequest], packing: Packing) {
        let first = self.shares.len();
        let account = packing.account();
        // the method of the layer with most grains stands for all
        if packing.grains().len() > self.grains.len() || self.grains.is_empty() {
            self.account.method = account.method;
        }
        self.account.steps += account.steps;
        self.account.sweeps += account.sweeps;
        self.account.acceptance = self.account.acceptance.or(account.acceptance);
        let notes = account.notes.iter().map(|note| format!("layer {}: {note}", self.layers + 1));
        self.account.notes.extend(notes);
        self.relief = self.relief.take().or_else(|| {
            let beyond_um = self.thickness_um - packing.thickness_um();
            packing.relief().map(|relief| relief.raised(beyond_um))
        });
        self.shares.extend(shares_of(group, &packing));
        for grain in packing.grains() {
            let mut grain = grain.lifted(self.top_um);
            grain.pigment += first;
            self.grains.push(grain);
        }
        self.top_um += group.iter().map(|layer| layer.request.thickness_um).sum::<f64>();
        self.layers += group.len();
    }

    /// The packing of all layers, whose grains are checked against each other once more.
    pub fn proven(self, request: &PackingRequest) -> Result<Packing, PackError> {
        let mut packing = Packing::proven(request, self.grains, self.shares, self.account)?;
        packing.relief = self.relief;
        packing.layers_um = request.layers.iter().map(|layer| layer.request.thickness_um).collect();
        Ok(packing)
    }
}

/// Shares of the pigments of packed layers in the volumes of their own layers.
fn shares_of(group: &[StackedRequest], packing: &Packing) -> Vec<Share> {
    if group.len() == 1 {
        return packing.shares().to_vec();
    }
    let window_um3 = joined(group).window_um3();
    let of_layer =
        |layer: &StackedRequest| vec![window_um3 / layer.request.window_um3(); layer.request.pigments.len()];
    let factors = group.iter().flat_map(of_layer);
    let own = |(share, factor): (&Share, f64)| Share {
        requested_fraction: factor * share.requested_fraction,
        achieved_fraction: factor * share.achieved_fraction,
        fraction_error: factor * share.fraction_error,
        ..share.clone()
    };
    packing.shares().iter().zip(factors).map(own).collect()
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

    /// Across an open joint grains of both layers reach, and none is lost.
    #[test]
    fn grains_reach_across_open_joints() {
        let mut request = request();
        request.layers.remove(1);
        request.thickness_um = 1.0;
        let walled = pack(&request, &mut ()).expect("a packing");
        request.layers[0].joint = Joint::Open;
        let open = pack(&request, &mut ()).expect("a packing");
        let across = |packing: &Packing, pigment: usize| {
            let own = packing.grains().iter().filter(|grain| grain.pigment == pigment);
            own.filter(|g| g.extent_um(2)[0] < 0.6 - 1e-9 && g.extent_um(2)[1] > 0.6 + 1e-9).count()
        };
        for pigment in [0, 1] {
            assert_eq!(across(&walled, pigment), 0);
            assert!(across(&open, pigment) > 0, "{pigment}");
            let [asked, reached] =
                [request.pigments[pigment].volume_fraction, open.achieved_fraction(pigment)];
            // a whole number of grains
            assert!((reached / asked - 1.0).abs() < 0.05, "{asked} {reached}");
        }
        let centres = open.grains().iter().map(|g| (g.pigment, g.spheres[0].center_um[2]));
        let in_order = centres.filter(|(pigment, z)| (*z < 0.6) == (*pigment == 0)).count();
        // of 151 grains that move apart two more may pass one way than the other
        let beyond = open.grains().len() - in_order;
        assert!(beyond <= 4, "{beyond}");
    }

    /// Two crowded layers of one ink with an open joint are one layer of both thicknesses: as many
    /// grains lie at the walls, and as many about the joint. *Planted*: grains that hardly move
    /// along the depth (at the walls a tenth as many), and a joint that none passes (three
    /// times as many within 3 nm of it).
    #[test]
    fn open_joints_of_one_ink_are_none() {
        const SEEDS: u64 = 12;
        let ink = PigmentGrains::spheres(150.0, 0.3);
        let count = |thicknesses_um: &[f64]| {
            let mut near = [0.0; 3];
            for seed in 0..SEEDS {
                let cell = PackingRequest { period_um: [3.0; 2], seed, ..PackingRequest::default() };
                let layer = |thickness_um: &f64| StackedRequest {
                    request: PackingRequest {
                        thickness_um: *thickness_um,
                        pigments: vec![ink.clone()],
                        ..cell.clone()
                    },
                    joint: Joint::Open,
                };
                let layers = thicknesses_um.iter().map(layer).collect();
                let pigments = vec![ink.clone(); thicknesses_um.len().max(1)];
                let request = PackingRequest { thickness_um: 1.0, pigments, layers, ..cell };
                let packing = pack(&request, &mut ()).expect("a packing");
                for grain in packing.grains() {
                    let z = grain.spheres[0].center_um[2];
                    let places = [(0.075, 0.003), (0.925, 0.003), (0.5, 0.003)];
                    let counts = places.map(|(depth, reach)| f64::from((z - depth).abs() < reach));
                    near = std::array::from_fn(|i| near[i] + counts[i]);
                }
            }
            near
        };
        let whole = count(&[]);
        let joined = count(&[0.5, 0.5]);
        println!("{whole:?} {joined:?}");
        for (one, two) in whole.into_iter().zip(joined) {
            // significance of a difference of two counts
            assert!((one - two).abs() < 4.0 * (one + two).sqrt(), "{whole:?} {joined:?}");
        }
    }

    /// Of two layers with an open joint one holds more than usual, the other less: both are packed
    /// as ever. *Planted*: the method chosen by the share of the fuller one.
    #[test]
    fn fuller_layers_with_open_joints_are_packed_as_usual() {
        let mut request = request();
        request.layers.remove(1);
        request.thickness_um = 1.0;
        request.layers[0].joint = Joint::Open;
        for (layer, by) in request.layers.iter_mut().zip([1.2, 0.8]) {
            let usual = PigmentGrains::spheres(160.0, 0.2);
            layer.request.thickness_um = 0.5;
            layer.request.usual_fraction = Some(0.2);
            layer.request.pigments = vec![PigmentGrains { volume_fraction: 0.2 * by, ..usual }];
        }
        request.pigments = request.layers.iter().map(|layer| layer.request.pigments[0].clone()).collect();
        let packing = pack(&request, &mut ()).expect("a packing");
        assert_eq!(packing.account().method, Method::SequentialAddition);
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
