use inkwave::ink::{PackingRequest, PigmentGrains, pack};
use inkwave::solve::*;
use inkwave::wave::*;
use num_complex::Complex64;
use std::sync::Arc;
fn main() {
    let a: Vec<f64> = std::env::args().filter_map(|a| a.parse().ok()).collect();
    let (period, lambda, kappa, ppu, cells) = (a[0], a[1], a[2], a[3], a[4] as usize);
    let request = PackingRequest {
        period_um: [period; 2],
        pigments: vec![PigmentGrains::spheres(250.0, 0.30)],
        ..PackingRequest::default()
    };
    let scene = Scene::from_packing(&pack(&request, &mut ()).unwrap());
    let n = accuracy::smooth_size((ppu * period) as usize);
    let coverage =
        Arc::new(Coverage::new(&scene, Resolution { nx: n, ny: n, cells, scheme: Scheme::Cubic }).unwrap());
    let one = Complex64::ONE;
    let media = Media {
        above: one,
        below: one,
        backgrounds: vec![1.558.into()],
        inclusions: vec![Complex64::new(1.4, kappa)],
    };
    let incidence = Incidence { wavelength_um: lambda, polar_deg: 0.0, azimuth_deg: 0.0, from: Side::Above };
    for z in [true] {
        let problem =
            Problem::new(&coverage, &media, &incidence, Mean { depends_on_z: z, absorbing: true }).unwrap();
        for t in [0.0, 0.1, 0.2, 0.4, 0.8] {
            let g = Gmres {
                guided_modes: GuidedModes { threshold: t, ..Default::default() },
                ..Default::default()
            };
            let s = g.solve(&problem, Goal::default(), &mut Silent).unwrap();
            println!(
                "modes {} L {period} lambda {lambda} kappa {kappa} n {n} zmean {z} threshold {t}: {} applications, {:.2} s, res {:.1e}",
                0, s.account.operator_applications, s.account.seconds, s.account.residual
            );
        }
    }
}
