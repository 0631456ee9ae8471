//! n from κ by the relation of Kramers and Kronig (time factor e^(−iωt)), with ω = 1/λ in µm⁻¹:
//!
//!   n(ω) = n∞ + c p(ω) + (2/π) P∫ ω′κ(ω′)/(ω′² − ω²) dω′,   p = (ωλ_p)²/(1 − (ωλ_p)²).
//!
//! κ is linear in ω between nodes, so that the integral is a sum of logarithms. Absorption in the
//! ultraviolet beyond the table is one pole: the constant n∞ it gives far to the red, and its slope
//! c p. How strong it is follows from n itself: the higher n, the nearer its bands, by the law that
//! S. H. Wemple and M. DiDomenico found for a hundred solids (Phys. Rev. B 3 (1971) 1338),
//!
//!   n² − 1 = E_d E_0/(E_0² − E²),   of which dn/dE² ≈ (n² − 1)³/(2 n E_d²),
//!
//! with E_d of 15 to 30 eV. One known n, the anchor, takes the place of n∞. What a band just beyond
//! an end of the table may add is an error of n, by κ and its slope there.

use std::f64::consts::PI;

/// Wavelength of the pole in the ultraviolet, µm, for tables that begin at twice it or later.
pub const POLE_UM: f64 = 0.2;
/// Least strength c of the pole, and its standard error: silica, calcite and the listed polymers
/// have 0.06 to 0.18 (a test reads them from their records).
pub const POLE_STRENGTH: [f64; 2] = [0.1, 0.1];
/// E_d of Wemple and DiDomenico, eV: 15 of silica and 26 of rutile and ZnS; and what it leaves open
/// of the strength.
const DISPERSION_EV: f64 = 24.0;
const OPEN: f64 = 0.65;
/// Photon energy times wavelength, eV µm.
const EV_UM: f64 = 1.239_842;
/// κ beyond an end of the table falls linearly to 0 within the first share of the end's ω; that it
/// does so within the second instead is the standard error.
const TAIL: [f64; 2] = [0.15, 0.45];
/// Share of an end's ω over which the slope of κ is taken there.
const SLOPE: f64 = 0.05;
/// Logarithmic slopes are taken of κ of at least this share of that at the end.
const LEAST_SHARE: f64 = 1e-3;
/// Longest scale of a band beyond the table, as shares of its range of ω and of the end's ω.
const LONGEST: [f64; 2] = [0.5, 0.4];
/// Nodes of a band beyond the table.
const BAND_NODES: usize = 100;
/// Rows of a table: the sums take the square of their number.
pub const MOST_ROWS: usize = 4000;

/// What is known of n beside κ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum KnownIndex {
    /// n at one wavelength.
    At {
        /// Vacuum wavelength, µm, above that of the pole.
        wavelength_um: f64,
        /// n there.
        n: f64,
    },
    /// n far to the red of all absorption in the ultraviolet, without the bands of the table.
    Infinity(f64),
}

/// n at the rows of a table of κ, and how its independent errors change it there.
#[derive(Clone, Debug, PartialEq)]
pub struct RealPart {
    /// n, one per row.
    pub n: Vec<f64>,
    /// Change by one standard error of the absorption at shorter wavelengths than the table's.
    pub ultraviolet: Vec<f64>,
    /// What longer wavelengths add.
    pub infrared: Vec<f64>,
}

/// An end of a table of κ.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// The short wavelengths.
    Short,
    /// The long wavelengths.
    Long,
}

/// The absorption band of which κ at an end of the table is the flank: a Lorentz band whose slope
/// d ln κ/dω = g it has there.
///
/// A flank has one height and one slope, and no band: with a half width h its centre is x further
/// out, where g = 2x/(x² + h²). Taken is the band that is a quarter of its peak at the table's end,
/// x = √3 h = 3/(2g), between the band that the table nearly holds (x < h, up to twice κ at its
/// end) and the far flank of one of any height (h → 0, x → 2/g). Where κ is flat, a band is as wide
/// as the longest scale, with its centre at the end; where κ falls outwards, its centre is inside.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Flank {
    /// ω of the end.
    omega: f64,
    /// 1 where the band lies at larger ω, −1 where at smaller.
    outwards: f64,
    /// κ at the end.
    kappa: f64,
    /// Distance of the centre from the end, outwards.
    centre: f64,
    /// Half the width at half the height.
    half_width: f64,
}

impl Flank {
    /// The band by the rows next to an end; `None` without absorption there.
    fn of(rows: &[[f64; 2]], end: End) -> Option<Self> {
        let omega_kappa = |[um, kappa]: &[f64; 2]| [1.0 / um, *kappa];
        let inwards: Vec<[f64; 2]> = match end {
            End::Short => rows.iter().map(omega_kappa).collect(),
            End::Long => rows.iter().rev().map(omega_kappa).collect(),
        };
        let [omega, kappa] = inwards[0];
        let span = (inwards[inwards.len() - 1][0] - omega).abs();
        let outwards = if end == End::Short { 1.0 } else { -1.0 };
        // ln(κ/κ at the end) at a distance inwards, and its slope by a parabola through the end
        let log = |distance: f64| {
            let after = inwards.iter().position(|row| (row[0] - omega).abs() >= distance);
            let after = after.unwrap_or(inwards.len() - 1).max(1);
            let [from, low] = inwards[after - 1];
            let [to, high] = inwards[after];
            let share = ((distance - (from - omega).abs()) / (to - from).abs()).min(1.0);
            (low + share * (high - low)).max(LEAST_SHARE * kappa).ln() - kappa.ln()
        };
        let near = 0.5 * (SLOPE * omega).min(span);
        let slope = (log(2.0 * near) - 4.0 * log(near)) / (2.0 * near);
        let scale = 1.0 / (slope.abs() + 1.0 / (LONGEST[0] * span).min(LONGEST[1] * omega));
        let centre = 1.5 * slope * scale * scale;
        let half_width = 0.75_f64.sqrt() * scale;
        (kappa > 0.0).then_some(Self { omega, outwards, kappa, centre, half_width })
    }

    /// κ at a distance outwards.
    fn kappa_at(&self, distance: f64) -> f64 {
        let h = self.half_width.powi(2);
        self.kappa * (self.centre.powi(2) + h) / ((distance - self.centre).powi(2) + h)
    }

    /// ∫ κ dω from the end outwards.
    fn area(&self) -> f64 {
        let height = self.kappa * (1.0 + (self.centre / self.half_width).powi(2));
        let angles = (self.centre / self.half_width).atan() + self.farthest().atan();
        height * self.half_width * angles
    }

    /// Whether the band absorbs more than the longest tail that is drawn otherwise.
    fn exceeds_tail(&self) -> bool {
        self.area() > 0.5 * TAIL[1] * self.omega * self.kappa
    }

    /// The distance of ω from its own value, to ω = 0 or 2ω, from the centre in half widths.
    fn farthest(&self) -> f64 {
        (self.omega - self.centre) / self.half_width
    }

    /// The table with this band in place of the tail at its end.
    fn beside(&self, table: &KappaNodes) -> KappaNodes {
        let from = -(self.centre / self.half_width).atan();
        let step = (self.farthest().atan() - from) / BAND_NODES as f64;
        // equal steps of the angle: close where the band is high
        let distances =
            (1..BAND_NODES).map(|i| self.centre + self.half_width * (from + step * i as f64).tan());
        let mut band: Vec<[f64; 2]> =
            distances.map(|d| [self.omega + self.outwards * d, self.kappa_at(d)]).collect();
        band.push([self.omega * (1.0 + self.outwards), 0.0]);
        let inner = 1..table.omega.len() - 1;
        let mut omega = table.omega.clone();
        let mut kappa = table.kappa.clone();
        if self.outwards > 0.0 {
            omega.truncate(inner.end);
            kappa.truncate(inner.end);
        } else {
            band.reverse();
            omega.drain(..inner.start);
            kappa.drain(..inner.start);
        }
        let place = if self.outwards > 0.0 { omega.len() } else { 0 };
        omega.splice(place..place, band.iter().map(|node| node[0]));
        kappa.splice(place..place, band.iter().map(|node| node[1]));
        KappaNodes { omega, kappa }
    }
}

/// Whether κ at an end of a table may be the flank of a band beyond it that changes n by more than
/// the usual tail. At least two rows, as [`real_part`].
pub fn may_be_cut(rows: &[[f64; 2]], end: End) -> bool {
    Flank::of(rows, end).is_some_and(|flank| flank.exceeds_tail())
}

/// κ at increasing ω, linear in between and 0 at both ends.
struct KappaNodes {
    omega: Vec<f64>,
    kappa: Vec<f64>,
}

impl KappaNodes {
    /// The rows (λ in µm, κ), with tails that fall to 0 over these shares of ω at the long and at
    /// the short end of the wavelengths.
    fn new(rows: &[[f64; 2]], [long, short]: [f64; 2]) -> Self {
        let rising = rows.iter().rev().map(|[um, kappa]| [1.0 / um, *kappa]);
        let mut omega: Vec<f64> = rising.clone().map(|row| row[0]).collect();
        let mut kappa: Vec<f64> = rising.map(|row| row[1]).collect();
        let (first, last) = (omega[0], omega[omega.len() - 1]);
        omega.insert(0, first * (1.0 - long));
        omega.push(last * (1.0 + short));
        kappa.insert(0, 0.0);
        kappa.push(0.0);
        Self { omega, kappa }
    }

    /// (2/π) P∫ ω′κ/(ω′² − ω²) dω′.
    fn integral(&self, w: f64) -> f64 {
        let hats = self.omega.windows(3).zip(&self.kappa[1..]);
        hats.map(|(nodes, kappa)| kappa * transform([nodes[0], nodes[1], nodes[2]], w)).sum()
    }
}

/// n at rows (λ in µm rising, κ). At least two rows, at most [`MOST_ROWS`].
pub fn real_part(rows: &[[f64; 2]], known: KnownIndex) -> RealPart {
    let [near, far] = TAIL;
    let central = KappaNodes::new(rows, [near; 2]);
    let beyond = |end: End, tails: [f64; 2]| {
        let flank = Flank::of(rows, end).filter(Flank::exceeds_tail);
        flank.map_or_else(|| KappaNodes::new(rows, tails), |flank| flank.beside(&central))
    };
    let longer = beyond(End::Long, [far, near]);
    let shorter = beyond(End::Short, [near, far]);
    let pole_um = POLE_UM.min(0.5 * rows[0][0]);
    let of_ultraviolet = match known {
        KnownIndex::Infinity(n) => n,
        KnownIndex::At { wavelength_um, n } => n - central.integral(1.0 / wavelength_um),
    };
    let [strength, error] = pole_strength(of_ultraviolet, pole_um);
    let pole = |w: f64| (w * pole_um).powi(2) / (1.0 - (w * pole_um).powi(2));
    // [n, change by the ultraviolet, change by the infrared] up to constants
    let parts = |w: f64| {
        let middle = central.integral(w);
        let ultraviolet = error * pole(w) + shorter.integral(w) - middle;
        [middle + strength * pole(w), ultraviolet, longer.integral(w) - middle]
    };
    let constant = match known {
        KnownIndex::Infinity(n) => [n, 0.0, 0.0],
        KnownIndex::At { wavelength_um, n } => {
            let [own, ultraviolet, infrared] = parts(1.0 / wavelength_um);
            [n - own, -ultraviolet, -infrared]
        }
    };
    let all: Vec<[f64; 3]> = rows.iter().map(|[um, _]| parts(1.0 / um)).collect();
    let column = |i: usize| all.iter().map(|parts| parts[i] + constant[i]).collect();
    RealPart { n: column(0), ultraviolet: column(1), infrared: column(2) }
}

/// Strength of the pole and its standard error, where absorption in the ultraviolet alone gives
/// this n.
fn pole_strength(n: f64, pole_um: f64) -> [f64; 2] {
    let slope = (n * n - 1.0).max(0.0).powi(3) / (2.0 * n.max(1.0) * DISPERSION_EV.powi(2));
    // the slope of p with E², far to the red of the pole
    let of_pole = (pole_um / EV_UM).powi(2);
    let nearer = (POLE_UM / pole_um).powi(2);
    let [least, error] = POLE_STRENGTH.map(|usual| usual * nearer);
    let strength = least.max(slope / of_pole);
    [strength, error.max(OPEN * strength)]
}

/// Change of n at the rows by a change of κ there, with n kept where it is known.
pub fn change(rows: &[[f64; 2]], known: KnownIndex) -> Vec<f64> {
    let nodes = KappaNodes::new(rows, [TAIL[0]; 2]);
    let kept = match known {
        KnownIndex::Infinity(_) => 0.0,
        KnownIndex::At { wavelength_um, .. } => nodes.integral(1.0 / wavelength_um),
    };
    rows.iter().map(|[um, _]| nodes.integral(1.0 / um) - kept).collect()
}

/// The function that is 1 at the middle node and linear to 0 at the others.
pub fn hat([a, b, c]: [f64; 3], w: f64) -> f64 {
    ((w - a) / (b - a)).min((c - w) / (c - b)).max(0.0)
}

/// (2/π) P∫ ω′h/(ω′² − ω²) dω′ of a hat: (1/π) ∫ h (1/(ω′ − ω) + 1/(ω′ + ω)) dω′.
pub fn transform(nodes: [f64; 3], w: f64) -> f64 {
    (over(nodes, w) + over(nodes, -w)) / PI
}

/// P∫ h(x)/(x − w) dx of a hat; the logarithms' poles cancel.
fn over([a, b, c]: [f64; 3], w: f64) -> f64 {
    let log = |x: f64| if (x - w).abs() < 1e-12 { 0.0 } else { (x - w).abs().ln() };
    let (rising, falling) = ((w - a) / (b - a), (c - w) / (c - b));
    rising * (log(b) - log(a)) + falling * (log(c) - log(b))
}

#[cfg(test)]
#[path = "kramers_kronig_tests.rs"]
mod tests;
