//! The far field: complex amplitudes and efficiencies of all orders.

use super::{Field, Incidence, Problem, Setting};
use num_complex::Complex64;

/// One diffraction order (m, n), counted from the specular order.
///
/// `direction` is (kx, ky)/k0, the direction cosines if the half-space is vacuum. The reflected
/// amplitude refers to the illuminated face, the transmitted one to the opposite face; the
/// reflected (0, 0) amplitude is u₀₀ − 1 (P2 (4.10) corrected). Efficiencies are Re κ_mn/κ₀₀ |·|²,
/// zero for evanescent orders.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Order {
    /// Index along x.
    pub m: i32,
    /// Index along y.
    pub n: i32,
    /// Lateral wavevector (kx, ky)/k0.
    pub direction: [f64; 2],
    /// Whether it propagates in the half-space the light came from.
    pub reflected_propagates: bool,
    /// Whether it propagates in the opposite half-space.
    pub transmitted_propagates: bool,
    /// Amplitude R_mn relative to the incident wave.
    pub reflected: Complex64,
    /// Amplitude T_mn relative to the incident wave.
    pub transmitted: Complex64,
    /// Fraction of the incident power reflected into this order.
    pub reflected_efficiency: f64,
    /// Fraction of the incident power transmitted into this order.
    pub transmitted_efficiency: f64,
    /// Further amplitudes \[reflected, transmitted\] incoherent with the first ones, zero for the
    /// scalar wave: light of the other polarisation, and for unpolarised light both amplitudes of
    /// the other incident polarisation. Powers add, with a common flux factor.
    pub further: [[Complex64; 2]; FURTHER],
}

/// Number of pairs of amplitudes besides the first: crossed, and two of the second incident
/// polarisation.
pub const FURTHER: usize = 3;

/// All orders of one solve with their energy balance: R + T + A = 1, A from the discrete quadratic
/// form.
///
/// ```
/// use inkwave_physics::solve::{Gmres, Goal, Silent, Solver};
/// use inkwave_physics::wave::{Incidence, Mean, Media, Problem, Resolution, Scene, Scheme, Side};
/// use num_complex::Complex64;
///
/// // An absorbing film on glass: one order, exact at any number of cells.
/// let backgrounds = vec![Complex64::new(1.6, 0.05)];
/// let scene = Scene::layer([1.0, 1.0], 0.5, vec![]);
/// let media = Media { incident: 1.0.into(), exit: 1.5.into(), backgrounds, inclusions: vec![] };
/// let light =
///     Incidence { wavelength_um: 0.55, polar_deg: 30.0, azimuth_deg: 0.0, from: Side::Incident };
/// let grid = Resolution { nx: 1, ny: 1, cells: 6, scheme: Scheme::Cubic };
/// let problem = Problem::from_scene(&scene, &media, &light, grid, Mean::default())?;
/// let solution = Gmres::default().solve(&problem, Goal::default(), &mut Silent)?;
/// let far = problem.far_field(&solution.field);
/// assert!(far.energy_error().abs() < 1e-12 && far.absorptance > 0.3);
/// assert_eq!(far.specular().reflected_efficiency, far.reflectance);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct FarField {
    /// The incident light.
    pub incidence: Incidence,
    /// Lateral periods, µm.
    pub period_um: [f64; 2],
    /// All orders that propagate on either side, and evanescent ones of similar wavenumber.
    pub orders: Vec<Order>,
    /// R, the sum of the reflected efficiencies.
    pub reflectance: f64,
    /// T, the sum of the transmitted efficiencies.
    pub transmittance: f64,
    /// A, the absorbed fraction of the incident power.
    pub absorptance: f64,
    /// What of A is absorbed in every background medium with its bodies; empty with one background.
    pub absorbed: Vec<f64>,
}

impl FarField {
    /// Energy error R + T + A − 1: zero to the solver's residual at any resolution.
    pub fn energy_error(&self) -> f64 {
        self.reflectance + self.transmittance + self.absorptance - 1.0
    }

    /// Unpolarised light from s and p light of the same direction: the mean of efficiencies and
    /// totals. All amplitudes are kept separately, divided by √2, so that their powers add up.
    pub fn unpolarised(s: &FarField, p: &FarField) -> FarField {
        let orders = s.orders.iter().zip(&p.orders).map(|(s, p)| Order::unpolarised(s, p)).collect();
        FarField {
            orders,
            reflectance: 0.5 * (s.reflectance + p.reflectance),
            transmittance: 0.5 * (s.transmittance + p.transmittance),
            absorptance: 0.5 * (s.absorptance + p.absorptance),
            absorbed: s.absorbed.iter().zip(&p.absorbed).map(|(s, p)| 0.5 * (s + p)).collect(),
            ..s.clone()
        }
    }

    /// The specular order (0, 0).
    pub fn specular(&self) -> &Order {
        self.orders.iter().find(|o| o.m == 0 && o.n == 0).expect("order (0, 0) is always kept")
    }
}

impl Order {
    /// All amplitudes \[reflected, transmitted\], mutually incoherent ones separately.
    pub fn amplitudes(&self) -> impl Iterator<Item = [Complex64; 2]> + use<> {
        std::iter::once([self.reflected, self.transmitted]).chain(self.further)
    }

    fn unpolarised(s: &Order, p: &Order) -> Order {
        let share = |amplitudes: [Complex64; 2]| amplitudes.map(|a| std::f64::consts::FRAC_1_SQRT_2 * a);
        let [reflected, transmitted] = share([s.reflected, s.transmitted]);
        Order {
            reflected,
            transmitted,
            further: [s.further[0], [p.reflected, p.transmitted], p.further[0]].map(share),
            reflected_efficiency: 0.5 * (s.reflected_efficiency + p.reflected_efficiency),
            transmitted_efficiency: 0.5 * (s.transmitted_efficiency + p.transmitted_efficiency),
            ..*s
        }
    }
}

/// Largest lateral wavenumber of listed evanescent orders, in units of that of the denser
/// half-space.
const EVANESCENT_REACH: f64 = 3.0;

/// What leaves through one face in one harmonic: the amplitudes of the incident and of the crossed
/// polarisation, and the efficiency.
pub(in crate::wave) type Leaving = ([Complex64; 2], f64);

impl Setting {
    /// The far field with the absorbed fraction `absorptance`; R and T are sums over the orders.
    /// `leaving` evaluates the field on a side in a harmonic, less an incident wave of the given
    /// amplitude.
    pub(in crate::wave) fn far_field_of(
        &self,
        period_um: [f64; 2],
        absorptance: f64,
        leaving: impl Fn(usize, usize, f64) -> Leaving,
    ) -> FarField {
        let index = self.media.incident.re.max(self.media.exit.re).max(1.0);
        let reach = EVANESCENT_REACH * index * self.k0;
        let specular = self.harmonics.orders[self.incident_harmonic];
        let orders = self.harmonics.orders.iter();
        let labelled = orders.map(|[m, n]| [m - specular[0], n - specular[1]]).enumerate();
        let listed = |&(i, [m, n]): &(usize, [i32; 2])| {
            self.lateral[i][0].hypot(self.lateral[i][1]) <= reach || (m.abs() <= 2 && n.abs() <= 2)
        };
        let mut orders: Vec<Order> =
            labelled.filter(listed).map(|(i, label)| self.order(i, label, &leaving)).collect();
        orders.sort_by_key(|o| (o.m, o.n));
        let reflectance = orders.iter().map(|o| o.reflected_efficiency).sum();
        let transmittance = orders.iter().map(|o| o.transmitted_efficiency).sum();
        FarField {
            incidence: self.incidence,
            period_um,
            orders,
            reflectance,
            transmittance,
            absorptance,
            absorbed: Vec::new(),
        }
    }

    /// The order (m, n), which is harmonic `i`.
    fn order(&self, i: usize, [m, n]: [i32; 2], leaving: &impl Fn(usize, usize, f64) -> Leaving) -> Order {
        let back = self.entry_side();
        let onward = 1 - self.entry_side();
        let incident = if i == self.incident_harmonic { 1.0 } else { 0.0 };
        let ([reflected, crossed_back], reflected_efficiency) = leaving(back, i, incident);
        let ([transmitted, crossed_onward], transmitted_efficiency) = leaving(onward, i, 0.0);
        Order {
            m,
            n,
            direction: self.lateral[i].map(|k| k / self.k0),
            reflected_propagates: self.kappa[back][i].re > 0.0,
            transmitted_propagates: self.kappa[onward][i].re > 0.0,
            reflected,
            transmitted,
            reflected_efficiency,
            transmitted_efficiency,
            further: [[crossed_back, crossed_onward], Default::default(), Default::default()],
        }
    }
}

impl Problem {
    /// Evaluates the orders at the first and last node (P2 (3.8), (3.9) with moduli) and the energy
    /// balance.
    pub fn far_field(&self, u: &Field) -> FarField {
        let faces = [0, self.shape().0 - 1];
        let far =
            self.far_field_of(self.coverage.grid.period_um, self.absorptance(u), |side, i, incident| {
                let amplitude = u[[faces[side], i]] - incident;
                let efficiency = self.kappa[side][i].re / self.incident_kappa() * amplitude.norm_sqr();
                ([amplitude, Complex64::ZERO], efficiency)
            });
        FarField { absorbed: self.absorbed(u), ..far }
    }
}
