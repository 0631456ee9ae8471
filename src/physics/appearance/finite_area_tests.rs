//! Lobes against closed forms: one square aperture, the integral over the aperture itself, and what
//! the edges lose.

use super::*;
use crate::solve::{Gmres, Goal, Silent, Solver};
use crate::wave::{Incidence, Mean, Problem, Resolution, Scene, Scheme};

const LAMBDA_UM: f64 = 0.5;
const K0: f64 = TAU / LAMBDA_UM;
/// (sin t / t)² = ½.
const HALF: f64 = 1.391_557_378_251_51;

fn media(incident: f64, exit: f64) -> Media {
    Media { incident: incident.into(), exit: exit.into(), backgrounds: vec![1.6.into()], inclusions: vec![] }
}

/// One order, reflected and transmitted alike, in vacuum; evanescent beyond the unit circle.
fn order([m, n]: [i32; 2], direction: [f64; 2], amplitude: Complex64) -> Order {
    let square = 1.0 - direction[0].powi(2) - direction[1].powi(2);
    let efficiency = square.max(0.0).sqrt() * amplitude.norm_sqr();
    Order {
        m,
        n,
        direction,
        reflected_propagates: square > 0.0,
        transmitted_propagates: square > 0.0,
        reflected: amplitude,
        transmitted: amplitude,
        reflected_efficiency: efficiency,
        transmitted_efficiency: efficiency,
        further: Default::default(),
    }
}

/// A far field of such orders, lit along the normal.
fn far(period_um: f64, orders: Vec<Order>) -> FarField {
    let incidence =
        Incidence { wavelength_um: LAMBDA_UM, polar_deg: 0.0, azimuth_deg: 0.0, from: Side::Incident };
    let total = orders.iter().map(|o| o.reflected_efficiency).sum();
    FarField {
        incidence,
        period_um: [period_um; 2],
        orders,
        reflectance: total,
        transmittance: total,
        absorptance: 0.0,
        absorbed: Vec::new(),
    }
}

/// Orders (m, n) 0.4 apart in direction, off the axes, with amplitudes of all phases; five of 25
/// are evanescent.
fn many() -> FarField {
    let label = |i: i32| [i / 5 - 2, i % 5 - 2];
    let direction = |[m, n]: [i32; 2]| [0.1 + 0.4 * f64::from(m), -0.05 + 0.4 * f64::from(n)];
    let amplitude = |i: f64| 0.2 * Complex64::new((1.7 * i).sin(), (0.9 * i * i).cos());
    let orders = (0..25).map(|i| order(label(i), direction(label(i)), amplitude(i.into())));
    far(LAMBDA_UM / 0.4, orders.collect())
}

fn lit(far: &FarField, side_um: f64) -> FiniteArea {
    FiniteArea::new(far, &media(1.0, 1.0), Lobe::Reflected, side_um).expect("a square of whole periods")
}

/// Identity, to the rounding of angles: half of the lobe's height at t = l k Δsin ϑ/2 = 1.39,
/// nothing at t = π. The factor cos²ϑ belongs to the direction, not to the lobe.
#[test]
fn a_lobe_is_narrower_by_the_side() {
    let far = far(0.5, vec![order([1, 0], [0.3, 0.0], Complex64::new(0.1, 0.2))]);
    for side in [5.0, 10.0, 40.0] {
        let lit = lit(&far, side);
        let lobe = |t: f64| {
            let sin: f64 = 0.3 + 2.0 * t / (K0 * side);
            lit.at(sin.asin().to_degrees(), 0.0).expect("a direction") / (1.0 - sin * sin)
        };
        assert!((lobe(HALF) / lobe(0.0) - 0.5).abs() < 1e-10, "{side} µm");
        assert!((lobe(-HALF) / lobe(0.0) - 0.5).abs() < 1e-10, "{side} µm");
        assert!(lobe(PI) < 1e-20 * lobe(0.0), "{side} µm");
        let zero = (2.0 * PI / (K0 * side)).asin().to_degrees();
        assert!((lit.first_zero_deg() - zero).abs() < 1e-12);
    }
}

/// Order: an isolated lobe lacks 2|α|²/(κ₀ l) of its efficiency; the next term is the square's
/// corners', smaller by 1/(k l).
#[test]
fn a_lobe_holds_its_orders_efficiency_but_for_the_edges() {
    for direction in [[0.0, 0.0], [0.3, 0.5], [-0.6, 0.2]] {
        let amplitude = Complex64::new(0.3, -0.4);
        let far = far(0.5, vec![order([0, 1], direction, amplitude)]);
        for side in [2.0, 8.0, 32.0] {
            let lacks = far.reflectance - lit(&far, side).total();
            let edges = 2.0 * amplitude.norm_sqr() / (K0 * side);
            assert!(
                (lacks / edges - 1.0).abs() < 1.0 / (K0 * side),
                "{direction:?}, {side} µm: {lacks} {edges}"
            );
        }
    }
}

/// Order: the interfering lobes of many orders lack the light at the edges of the square, the rest
/// falls as 1/l².
#[test]
fn the_hemisphere_holds_all_orders_but_for_the_edges() {
    let far = many();
    let kept = |o: &&Order| o.reflected_propagates;
    assert_eq!(far.orders.iter().filter(kept).count(), 20);
    let mut lacked = f64::INFINITY;
    for periods in [2.0, 8.0, 32.0] {
        let side = periods * far.period_um[0];
        // ⟨|u|²⟩ along an edge: amplitudes of one row interfere, rows do not.
        let edge = |axis: usize| -> f64 {
            let label = |o: &Order| [o.m, o.n][1 - axis];
            let wave =
                |o: &Order| o.reflected * Complex64::from_polar(1.0, 0.5 * K0 * o.direction[axis] * side);
            let row = |i: i32| -> Complex64 {
                far.orders.iter().filter(kept).filter(|o| label(o) == i).map(wave).sum()
            };
            (-2..=2).map(|i| row(i).norm_sqr()).sum()
        };
        let edges = (edge(0) + edge(1)) / (K0 * side);
        let lacks = far.reflectance - lit(&far, side).total();
        assert!((lacks / edges - 1.0).abs() < 4.0 / (K0 * side), "{periods} periods: {lacks} {edges}");
        assert!(lacks < 0.3 * lacked, "falls as 1/l: {lacked} {lacks}");
        lacked = lacks;
    }
}

/// Order h²: the closed form against Kirchhoff's integral of the field over the square (P2 (4.5)),
/// by the midpoint rule.
#[test]
fn lobes_interfere_as_the_field_of_the_square_does() {
    let far = many();
    let side = 2.3;
    let points = 400;
    let lit = lit(&far, side);
    let place = |i: usize| ((i as f64 + 0.5) / points as f64 - 0.5) * side;
    let mut largest: f64 = 0.0;
    for [polar, azimuth] in [[0.0, 0.0], [25.0, 10.0], [40.0, 140.0], [60.0, 250.0], [80.0, -30.0]] {
        let polar_rad = f64::to_radians(polar);
        let azimuth_rad = f64::to_radians(azimuth);
        let direction = [polar_rad.sin() * azimuth_rad.cos(), polar_rad.sin() * azimuth_rad.sin()];
        let mut integral = Complex64::default();
        for o in far.orders.iter().filter(|o| o.reflected_propagates) {
            let along = |axis: usize| -> Complex64 {
                let q = K0 * (o.direction[axis] - direction[axis]);
                (0..points).map(|i| Complex64::from_polar(side / points as f64, q * place(i))).sum()
            };
            integral += o.reflected * along(0) * along(1);
        }
        // J/l² over the incident k0: k0² cos²ϑ/(4π² l²) |∬ u exp(−i(…)) dx dy|²
        let expected = (K0 * polar_rad.cos() * integral.norm() / (TAU * side)).powi(2);
        let found = lit.at(polar, azimuth).expect("a direction");
        largest = largest.max(expected);
        // (q h)²/24 with q about k, twice for the square of the amplitude.
        let order = (K0 * side / points as f64).powi(2) / 12.0;
        assert!((found - expected).abs() < order * largest, "{polar}°, {azimuth}°: {found} {expected}");
    }
}

/// Identity: a film is one aperture, and its light a square's Fraunhofer pattern about the specular
/// directions, outside in the angle of incidence, in the glass in Snell's.
#[test]
fn a_film_shines_like_a_square_aperture() {
    let media = media(1.0, 1.5);
    let side = 6.0;
    let grid = Resolution { nx: 1, ny: 1, cells: 6, scheme: Scheme::Cubic };
    let light =
        Incidence { wavelength_um: LAMBDA_UM, polar_deg: 30.0, azimuth_deg: 90.0, from: Side::Incident };
    let scene = Scene::layer([1.0, 1.0], 0.3, vec![]);
    let problem = Problem::from_scene(&scene, &media, &light, grid, Mean::default()).expect("a film");
    let solution = Gmres::default().solve(&problem, Goal::default(), &mut Silent).expect("converges");
    let far = problem.far_field(&solution.field);
    for (lobe, share, index) in
        [(Lobe::Reflected, far.reflectance, 1.0), (Lobe::Transmitted, far.transmittance, 1.5)]
    {
        let lit = FiniteArea::new(&far, &media, lobe, side).expect("transparent");
        let specular_sin = 0.5 / index;
        let k = index * K0;
        let specular_cos = (1.0 - specular_sin * specular_sin).sqrt();
        for [polar, azimuth] in
            [[specular_sin.asin().to_degrees(), 90.0], [0.0, 0.0], [25.0, 80.0], [70.0, -100.0]]
        {
            let polar_rad = f64::to_radians(polar);
            let azimuth_rad = f64::to_radians(azimuth);
            let sinc = |sine: f64| {
                let t = 0.5 * k * side * sine;
                if t.abs() < 1e-12 { 1.0 } else { t.sin() / t }
            };
            let x = polar_rad.sin() * azimuth_rad.cos();
            let y = polar_rad.sin() * azimuth_rad.sin() - specular_sin;
            // share · (n l/λ)² cos²ϑ/cos ϑ₀ · sinc² sinc²
            let peak = share * (index * side / LAMBDA_UM).powi(2) / specular_cos;
            let expected = peak * polar_rad.cos().powi(2) * (sinc(x) * sinc(y)).powi(2);
            let found = lit.at(polar, azimuth).expect("a direction");
            assert!(
                (found - expected).abs() < 1e-11 * peak,
                "{lobe:?} {polar}°, {azimuth}°: {found} {expected}"
            );
        }
        assert_eq!(lit.without_specular().total(), 0.0);
        assert_eq!(lit.without_specular().at(30.0, 90.0), Ok(0.0));
    }
}

#[test]
fn what_has_no_lobes_is_refused() {
    let far = far(0.7, vec![order([0, 0], [0.0, 0.0], 0.1.into())]);
    let refusal = |far: &FarField, media: &Media, side: f64| {
        FiniteArea::new(far, media, Lobe::Transmitted, side).expect_err("refused").to_string()
    };
    for side in [0.0, -1.0, 0.69, 500.1, f64::NAN, f64::INFINITY] {
        let message = refusal(&far, &media(1.0, 1.0), side);
        assert!(message.contains("illuminated_um") && message.contains("0.7 … 500 µm"), "{message}");
        assert!(message.contains("try ten periods, 7 µm"), "{message}");
    }
    let absorber = Media { exit: Complex64::new(1.5, 0.1), ..media(1.0, 1.0) };
    assert!(refusal(&far, &absorber, 7.0).contains("transmitted light is 1.5+0.1i"));
    assert!(FiniteArea::new(&far, &absorber, Lobe::Reflected, 7.0).is_ok(), "the other side is transparent");
    let mut polarised = far.clone();
    polarised.orders[0].further[0][1] = 0.1.into();
    assert!(refusal(&polarised, &media(1.0, 1.0), 7.0).contains("polarised"));
    let mut broken = far.clone();
    broken.orders[0].transmitted = f64::NAN.into();
    assert!(refusal(&broken, &media(1.0, 1.0), 7.0).contains("order (0, 0)"));
    let lit = lit(&far, 7.0);
    for [polar, azimuth] in [[-1.0, 0.0], [90.1, 0.0], [f64::NAN, 0.0], [0.0, f64::INFINITY]] {
        assert!(lit.at(polar, azimuth).expect_err("no direction").to_string().contains("0 … 90°"));
    }
}
