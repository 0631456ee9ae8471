//! Time of one packing of 10 × 10 × 1 µm on one core.

use criterion::{Criterion, criterion_group, criterion_main};
use inkwave::ink::pack;
use inkwave::ink::{MethodChoice, PackingRequest, PigmentGrains, Shape};
use std::hint::black_box;
use std::time::Duration;

fn request(shape: Shape, diameter_nm: f64, fraction: f64) -> PackingRequest {
    PackingRequest {
        pigments: vec![PigmentGrains::of(shape, diameter_nm, fraction)],
        method: MethodChoice::Relaxation,
        ..Default::default()
    }
}

fn packings(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("packing");
    group.sample_size(10).warm_up_time(Duration::from_millis(500)).measurement_time(Duration::from_secs(5));
    let cases = [
        ("spheres 250 nm, 30 %", request(Shape::Sphere, 250.0, 0.30)),
        ("spheres 250 nm, 50 %", request(Shape::Sphere, 250.0, 0.50)),
        ("spheres 250 nm, 55 %", request(Shape::Sphere, 250.0, 0.55)),
        ("cylinders 200 nm, 50 %", request(Shape::CYLINDER, 200.0, 0.50)),
        ("spheres 100 nm, 50 %", request(Shape::Sphere, 100.0, 0.50)),
    ];
    for (name, asked) in &cases {
        let mut stream = 0;
        // A new realisation each time: the mean over the ensemble is what a study pays.
        group.bench_function(*name, |b| {
            b.iter(|| {
                stream += 1;
                pack(black_box(&PackingRequest { stream, ..asked.clone() }), &mut ())
                    .expect("these fractions fit")
            })
        });
    }
    group.finish();
}

criterion_group!(benches, packings);
criterion_main!(benches);
