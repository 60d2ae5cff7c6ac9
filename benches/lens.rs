//! Tracing, pupil sampling and set-up of the double Gauss: `cargo bench --bench lens`.

use fstop::math::Vec2;
use fstop::optics::pupil::RINGS;
use fstop::optics::{ExitPupil, Lens, LensRay, LensTracer, Prescription};

fn main() {
    divan::main();
}

fn lens() -> Lens {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/lenses/dgauss.50mm.dat");
    let prescription = Prescription::read(path.as_ref()).expect("a lens file of ours");
    Lens::new(&prescription, 36.77).expect("a lens with its film behind it")
}

/// Film points and pupil points of rays of which most pass.
fn aims(lens: &Lens) -> Vec<([f64; 2], [f64; 3])> {
    let pupil = ExitPupil::new(lens, 22.0, RINGS);
    let r = |i: i32, a: f64| (0.5 + f64::from(i) * a).fract();
    (0..1024)
        .filter_map(|i| {
            let film = [
                30.0 * r(i, 0.7548776662) - 15.0,
                30.0 * r(i, 0.5698402909) - 15.0,
            ];
            let u = Vec2::new(r(i, 0.8191725134) as f32, r(i, 0.6710436067) as f32);
            Some((film, pupil.sample(film, u)?.point))
        })
        .collect()
}

/// 1024 rays from the film, 11 surfaces, f64.
#[divan::bench]
fn trace_f64(bencher: divan::Bencher) {
    let lens = lens();
    let aims = aims(&lens);
    bencher.bench_local(|| {
        aims.iter()
            .filter(|(film, pupil)| lens.trace_from_film(*film, *pupil).is_ok())
            .count()
    });
}

/// The same in f32.
#[divan::bench]
fn trace_f32(bencher: divan::Bencher) {
    let lens = lens();
    let tracer = LensTracer::<f32>::new(lens.surfaces());
    let rays: Vec<LensRay<f32>> = aims(&lens)
        .iter()
        .map(|(film, pupil)| {
            let from = [film[0], film[1], lens.film_z()];
            LensRay::through(from.map(|x| x as f32), pupil.map(|x| x as f32))
        })
        .collect();
    bencher.bench_local(|| rays.iter().filter(|r| tracer.to_scene(r).is_ok()).count());
}

/// The same in f64, with derivatives by the film point.
#[divan::bench]
fn trace_with_derivatives(bencher: divan::Bencher) {
    let lens = lens();
    let aims = aims(&lens);
    bencher.bench_local(|| {
        aims.iter()
            .filter(|(film, pupil)| {
                let from = [film[0], film[1], lens.film_z()];
                lens.tracer()
                    .to_scene_with_derivatives(from, *pupil)
                    .is_ok()
            })
            .count()
    });
}

/// Finding the exit pupil's regions.
#[divan::bench]
fn exit_pupil(bencher: divan::Bencher) {
    let lens = lens();
    bencher.bench_local(|| ExitPupil::new(&lens, 22.0, RINGS));
}
