use super::super::flux::{Hemisphere, Lit, Sides};
use super::*;
use crate::numerics::Sequence;
use crate::wave::Side;
use num_complex::Complex64;

/// Light at 0° that is scattered alike to all sides: reflected by a cell of these periods, in
/// wavelengths, with this phase.
fn scattered([x, y]: [f64; 2], phase: f64) -> Vec<Order> {
    let etendue = 1.0 / (x * y * PI);
    let last = (1.5 * x.max(y)).ceil() as i32;
    let mut orders = Vec::new();
    for m in -last..=last {
        for n in -last..=last {
            let direction = [f64::from(m) / x, f64::from(n) / y];
            let propagates = direction[0].hypot(direction[1]) < 1.0;
            orders.push(Order {
                m,
                n,
                direction,
                reflected_propagates: propagates,
                transmitted_propagates: false,
                reflected: Complex64::from_polar(1.0, phase),
                transmitted: 0.0.into(),
                reflected_efficiency: if propagates { etendue } else { 0.0 },
                transmitted_efficiency: 0.0,
                further: Default::default(),
            });
        }
    }
    orders
}

/// What is scattered alike to all sides is seen alike from 45° and from the nodes, in cells of one
/// and a half wavelengths and above. *Planted*: fluxes as the orders have them (12 % more at 45°).
#[test]
fn light_scattered_alike_to_all_sides_is_seen_so_in_small_cells() {
    for period in [1.5, 2.0, 3.0] {
        let medium =
            Hemisphere { ordinates: Ordinates::new(1.0, &[], [3, 3]), polarisations: 1, oblique_deg: None };
        let sides = Sides { media: [medium.clone(), medium.clone()], alike: true };
        let draws = Sequence::<2>::new(3);
        let cells: Vec<_> = (0..400)
            .map(|r| {
                let [area, aspect] = draws.point(r);
                let area = (0.7 + 0.6 * area) * period * period;
                let side: f64 = (area * (0.6 + 0.8 * aspect)).sqrt();
                // no phase in common: no coherent light
                let orders = scattered([side, area / side], 2.4 * r as f64);
                let lit = Lit {
                    from: Side::Incident,
                    direction: 0,
                    polarisation: 0,
                    absorptance: 0.0,
                    orders: &orders,
                };
                sides.fluxes(std::iter::once(lit))
            })
            .collect();
        let mean = sides.mean(&cells, None);
        let shares = medium.ordinates.shares(0.5_f64.sqrt());
        let of_node = |node: usize| mean.reflection[0][(node + 1, 0)] / medium.ordinates.weights[node];
        let seen: f64 = shares.iter().map(|(node, share)| share * of_node(*node)).sum();
        assert!((seen - 1.0).abs() < 0.02, "{period}: {seen}");
        let all: Vec<f64> = (0..3).map(of_node).collect();
        assert!(all.iter().all(|one| (one - 1.0).abs() < 0.05), "{period}: {all:?}");
    }
}
