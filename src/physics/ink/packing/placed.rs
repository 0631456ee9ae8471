//! Placed grains: a packing exists only if an independent check has found no overlap in it.

use super::{optic, overlap, shell};
use crate::ink::{Grain, Layered, PackError, PackingRequest, Relief, RoughFace, Sphere};

/// Method of placement.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum Method {
    /// Random sequential addition.
    SequentialAddition,
    /// Relaxation of overlaps (P1 section 3).
    Relaxation,
    /// The coordinates were given.
    Given,
    /// The voxels were given; the grains are boxes of them, of which several make a real grain.
    Voxels,
}

impl Method {
    /// Display name of the method.
    pub fn in_words(self) -> &'static str {
        match self {
            Self::SequentialAddition => "sequential addition",
            Self::Relaxation => "relaxation of overlaps",
            Self::Given => "given",
            Self::Voxels => "given as voxels, merged to boxes",
        }
    }
}

/// Volume fraction of one pigment: as requested and as achieved with whole grains.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Share {
    /// Requested fraction of the volume of the pigment's own layer; see [`crate::ink::Relief`] for
    /// its reference volume.
    pub requested_fraction: f64,
    /// Volume fraction of the placed grains.
    pub achieved_fraction: f64,
    /// Standard error of the achieved fraction due to the union volume (zero with a closed form).
    pub fraction_error: f64,
    /// Number of grains.
    pub grains: usize,
    /// Factor applied to the drawn sizes (1 unless sizes are scaled to meet the fraction).
    pub size_factor: f64,
}

impl Share {
    /// Volume fraction of given grains; it also counts as the requested one.
    fn of_given(grains: &[Grain], pigment: usize, box_um3: f64) -> Self {
        let of_pigment = grains.iter().filter(|g| g.pigment == pigment);
        let fraction = of_pigment.clone().map(|g| g.volume_um3).sum::<f64>() / box_um3;
        Self {
            requested_fraction: fraction,
            achieved_fraction: fraction,
            fraction_error: 0.0,
            grains: of_pigment.count(),
            size_factor: 1.0,
        }
    }
}

/// Record of how a packing was made.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct PackingAccount {
    /// Method of placement.
    pub method: Method,
    /// Seed of the request.
    pub seed: u64,
    /// Stream of the seed: the number of the realisation.
    pub stream: u64,
    /// Attempts of sequential addition or steps of relaxation.
    pub steps: u64,
    /// Monte Carlo sweeps after that.
    pub sweeps: u64,
    /// Acceptance rate of Monte Carlo moves after tuning.
    pub acceptance: Option<f64>,
    /// Smallest distance between two surfaces (or to a wall) if it is below the largest radius.
    pub smallest_gap_um: Option<f64>,
    /// Notes to the user, such as a fallback of the automatic method.
    pub notes: Vec<String>,
}

impl PackingAccount {
    pub(crate) fn new(method: Method, request: &PackingRequest) -> Self {
        Self {
            method,
            seed: request.seed,
            stream: request.stream,
            steps: 0,
            sweeps: 0,
            acceptance: None,
            smallest_gap_um: None,
            notes: Vec::new(),
        }
    }
}

/// Grains in a cell that is periodic in x and y, with hard walls at z = 0 and z = H or periodic in
/// z too.
///
/// A packing can be constructed only through an all-pairs check that shares no code with the
/// packing methods.
///
/// ```
/// use inkwave_physics::ink::{Grain, PackError, Packing, Sphere};
///
/// let ball = |x: f64| Grain::new(vec![Sphere { center_um: [x, 0.5, 0.5], radius_um: 0.1 }], 0);
/// let packing = Packing::from_grains([1.0, 1.0], 1.0, true, vec![ball(0.05), ball(0.45)])?;
/// assert_eq!(packing.grains().len(), 2);
/// assert!((packing.achieved_fraction(0) - 0.00838).abs() < 1e-5); // 2 · 4π/3 · 0.1³ of 1 µm³
///
/// // 0.05 and 0.95 are neighbours across the period.
/// let close = Packing::from_grains([1.0, 1.0], 1.0, true, vec![ball(0.05), ball(0.95)]);
/// assert!(matches!(close, Err(PackError::Overlap { .. })));
/// # Ok::<(), PackError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Packing {
    period_um: [f64; 2],
    pub(super) thickness_um: f64,
    pub(super) walls: bool,
    /// Whether grains extend beyond the faces, where the layer ends.
    pub(super) cut: bool,
    pub(super) grains: Vec<Grain>,
    pub(super) shares: Vec<Share>,
    pub(super) account: PackingAccount,
    pub(super) relief: Option<Relief>,
    /// Thicknesses of the layers of a stack, µm; empty for a single layer.
    pub(super) layers_um: Vec<f64>,
    /// Per pigment, thicknesses of the layers of its grains from the core outwards, µm.
    shells_um: Vec<Vec<f64>>,
    /// Per pigment, whether its cores are birefringent.
    birefringent: Vec<bool>,
}

impl Packing {
    /// A packing of given grains; fails if two of them, or a grain and a wall, overlap.
    pub fn from_grains(
        period_um: [f64; 2],
        thickness_um: f64,
        walls: bool,
        grains: Vec<Grain>,
    ) -> Result<Self, PackError> {
        let request = PackingRequest { period_um, thickness_um, walls, seed: 0, ..Default::default() };
        let kinds = grains.iter().map(|g| g.pigment + 1).max().unwrap_or(0);
        Self::placed_before(&request, grains, kinds, Method::Given)
    }

    /// The given grains of a request's realisation, if it has any.
    pub(crate) fn given(request: &PackingRequest) -> Option<Result<Self, PackError>> {
        let cut = usize::try_from(request.stream).ok()?;
        let pigments = request.pigments.len();
        if let Some(voxels) = request.voxels.get(cut) {
            let [lx, ly] = request.period_um;
            let grains = voxels.grains([lx, ly, request.thickness_um]);
            return Some(Self::placed_before(request, grains, pigments, Method::Voxels));
        }
        let grains = request.given.get(cut)?.clone();
        Some(Self::placed_before(request, grains, pigments, Method::Given))
    }

    /// Given grains of `kinds` pigments in a request's cell.
    fn placed_before(
        request: &PackingRequest,
        grains: Vec<Grain>,
        kinds: usize,
        method: Method,
    ) -> Result<Self, PackError> {
        let box_um3 = request.period_um[0] * request.period_um[1] * request.thickness_um;
        let shares = (0..kinds).map(|pigment| Share::of_given(&grains, pigment, box_um3)).collect();
        Self::proven(request, grains, shares, PackingAccount::new(method, request))
    }

    /// The only constructor: checks every pair, and that the layers leave a core in every grain.
    pub(super) fn proven(
        request: &PackingRequest,
        mut grains: Vec<Grain>,
        shares: Vec<Share>,
        mut account: PackingAccount,
    ) -> Result<Self, PackError> {
        let period_um = request.period_um;
        let thickness_um = request.thickness_um;
        let walls = request.walls;
        let size_um = [period_um[0], period_um[1], thickness_um];
        account.smallest_gap_um = overlap::smallest_gap(size_um, walls, &grains)?;
        optic::give_axes(request, &mut grains);
        let bare = Self {
            period_um,
            thickness_um,
            walls,
            cut: false,
            grains,
            shares,
            account,
            relief: None,
            layers_um: Vec::new(),
            shells_um: Vec::new(),
            birefringent: request.pigments.iter().map(|pigment| pigment.optic_axis.is_some()).collect(),
        };
        bare.with_shells(request.shells_um())
    }

    /// The packing with layers in its grains: per pigment, their thicknesses from the core
    /// outwards, µm. Layers that leave no core are an error.
    pub fn with_shells(self, mut shells_um: Vec<Vec<f64>>) -> Result<Self, PackError> {
        shells_um.resize(shells_um.len().max(self.shares.len()), Vec::new());
        let depth = |g: &Grain| shells_um[g.pigment].iter().sum::<f64>();
        let deepest = |g: &Grain| shell::deepest_um(&g.spheres, g.solid.as_ref().map(|s| &s.form));
        match self.grains.iter().find(|g| depth(g) > 0.0 && depth(g) >= deepest(g)) {
            None => Ok(Self { shells_um, ..self }),
            Some(grain) => {
                let found = format!("layers of {} µm in a grain of pigment {}", depth(grain), grain.pigment);
                let allowed = "layers in which a core remains";
                Err(PackError::input("shells_um", found, allowed, "take thinner layers"))
            }
        }
    }

    /// Lateral periods (Lx, Ly), µm.
    pub fn period_um(&self) -> [f64; 2] {
        self.period_um
    }

    /// Thickness H, µm.
    pub fn thickness_um(&self) -> f64 {
        self.thickness_um
    }

    /// Thicknesses of the layers in the order of the light, µm: one, or those of a stack.
    pub fn layers_um(&self) -> &[f64] {
        if self.layers_um.is_empty() { std::slice::from_ref(&self.thickness_um) } else { &self.layers_um }
    }

    /// Whether there are walls at z = 0 and z = H; false if the cell is periodic in z too, or cut.
    pub fn walls(&self) -> bool {
        self.walls
    }

    /// Whether grains extend beyond z = 0 and z = H, where the layer ends
    /// ([`PackingRequest::cut_um`]).
    pub fn is_cut(&self) -> bool {
        self.cut
    }

    /// All grains, each with the index of its pigment.
    pub fn grains(&self) -> &[Grain] {
        &self.grains
    }

    /// All grains, without the rest of the packing.
    pub fn into_grains(self) -> Vec<Grain> {
        self.grains
    }

    /// Requested and achieved volume fraction of each pigment.
    pub fn shares(&self) -> &[Share] {
        &self.shares
    }

    /// Per pigment, thicknesses of the layers of its grains from the core outwards, µm.
    pub fn shells_um(&self) -> &[Vec<f64>] {
        &self.shells_um
    }

    /// Number of materials in the grains: the cores of all pigments come first, then their layers.
    pub fn materials(&self) -> usize {
        self.shells_um.len() + self.shells_um.iter().map(Vec::len).sum::<usize>()
    }

    /// Place of a material's extraordinary index behind the indices of all materials, if it is a
    /// birefringent core: in the order of the pigments.
    pub fn extraordinary(&self, material: usize) -> Option<usize> {
        let is_birefringent = self.birefringent.get(material).copied().unwrap_or(false);
        let before = || self.birefringent[..material].iter().filter(|is| **is).count();
        is_birefringent.then(|| self.materials() + before())
    }

    /// The nested bodies of a grain from the outside inwards; each lies in the one before it.
    pub fn nested(&self, grain: &Grain) -> Vec<Layered> {
        let shell = &self.shells_um[grain.pigment];
        let first =
            self.shells_um.len() + self.shells_um[..grain.pigment].iter().map(Vec::len).sum::<usize>();
        let layers = shell.iter().enumerate().rev().map(|(i, &thickness)| (first + i, thickness));
        let mut depth = 0.0;
        let mut bodies = Vec::with_capacity(shell.len() + 1);
        for (material, thickness) in layers.chain([(grain.pigment, 0.0)]) {
            let solid = grain.solid.as_ref().map(|solid| solid.inset(depth));
            let spheres = match &solid {
                None => shell::inside(&grain.spheres, depth),
                Some(solid) => vec![Sphere { center_um: solid.center_um, radius_um: solid.form.reach_um() }],
            };
            bodies.push(Layered { material, spheres, solid });
            depth += thickness;
        }
        bodies
    }

    /// Volume fraction achieved with whole grains of a pigment (0 for an unknown one).
    pub fn achieved_fraction(&self, pigment: usize) -> f64 {
        self.shares.get(pigment).map_or(0.0, |s| s.achieved_fraction)
    }

    /// Method of placement.
    pub fn method(&self) -> Method {
        self.account.method
    }

    /// How the packing was made.
    pub fn account(&self) -> &PackingAccount {
        &self.account
    }

    /// The binder's surface, if grains protrude from it.
    pub fn relief(&self) -> Option<&Relief> {
        self.relief.as_ref()
    }

    /// Lowest and highest z of the ink at (x, y): from the binder's surface to the opposite face;
    /// beyond it there is the medium of the rough side between the grains.
    pub fn filled_um(&self, x_um: f64, y_um: f64) -> [f64; 2] {
        let height = self.relief.as_ref().map_or(self.thickness_um, |r| r.height_um(x_um, y_um));
        match self.relief.as_ref().map(|relief| relief.face) {
            Some(RoughFace::Exit) => [0.0, height],
            _ => [self.thickness_um - height, self.thickness_um],
        }
    }
}
