//! Tracing, pupil sampling and set-up of the double Gauss: `cargo bench --bench lens`.
//!
//! Counters are rays: divan prints rays a second, the inverse of time per ray. The rays of `trace_*` are aimed at the exit
//! pupil's regions and nearly all pass; `useful_*` count the rays that passed, with all that a camera does for
//! one: pupil sample, trace, transform to the world, weight.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a panic is an answer here"
)]

use divan::counter::ItemsCount;
use fstop::cameras::{Clip, FilmGeometry, Form, Realistic, RealisticSpec, Shutter, Weighting};
use fstop::math::instruction_set::{InstructionSet, Instructions, Kernel};
use fstop::math::transform::Transform;
use fstop::math::{DVec3, UVec2, Vec2};
use fstop::optics::lanes::{FilmTracer, Lanes, Traced};
use fstop::optics::models::LensModel;
use fstop::optics::pupil::{RINGS, projected_solid_angle};
use fstop::optics::real::{Dual, Number};
use fstop::optics::{ExitPupil, Lens, LensRay, LensTracer, Prescription};
use glam::DMat3;
use std::hint::black_box;
use std::path::Path;

fn main() {
    divan::main();
}

fn lens() -> Lens {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/lenses/dgauss.50mm.dat");
    let prescription = Prescription::read(path.as_ref()).expect("a lens file of ours");
    Lens::new(&prescription, 36.77).expect("a lens with its film behind it")
}

const RAYS: usize = 1024;

/// A film point and a sample of the unit square.
struct Sample {
    film: [f64; 2],
    u: Vec2,
}

fn samples() -> Vec<Sample> {
    let r = |i: usize, a: f64| (0.5 + i as f64 * a).fract();
    (0..RAYS)
        .map(|i| Sample {
            film: [
                30.0 * r(i, 0.7548776662) - 15.0,
                30.0 * r(i, 0.5698402909) - 15.0,
            ],
            u: Vec2::new(r(i, 0.8191725134) as f32, r(i, 0.6710436067) as f32),
        })
        .collect()
}

struct Setting {
    lens: Lens,
    pupil: ExitPupil,
    samples: Vec<Sample>,
}

impl Setting {
    fn new() -> Setting {
        let lens = lens();
        Setting {
            pupil: ExitPupil::new(&lens, 22.0, RINGS),
            lens,
            samples: samples(),
        }
    }

    /// Points of the film and of the pupil.
    fn aims(&self) -> Vec<([f64; 2], [f64; 3])> {
        let aim = |s: &Sample| Some((s.film, self.pupil.sample(s.film, s.u)?.point));
        self.samples.iter().filter_map(aim).collect()
    }

    fn tracer(&self) -> FilmTracer {
        FilmTracer::new(&self.lens, self.pupil.plane_z())
    }

    fn bundles<const N: usize>(&self) -> Vec<[[Lanes<N>; 2]; 2]> {
        let aims = self.aims();
        let lane = |chunk: &[([f64; 2], [f64; 3])], k: usize, film: bool| {
            let at = |i: usize| chunk.get(i).unwrap_or(&chunk[0]);
            Lanes(std::array::from_fn(|i| {
                if film {
                    at(i).0[k] as f32
                } else {
                    at(i).1[k] as f32
                }
            }))
        };
        aims.chunks(N)
            .map(|c| {
                [
                    [lane(c, 0, true), lane(c, 1, true)],
                    [lane(c, 0, false), lane(c, 1, false)],
                ]
            })
            .collect()
    }
}

/// The rays that pass, of the samples.
fn useful(setting: &Setting) -> usize {
    let passes =
        |(film, pupil): &([f64; 2], [f64; 3])| setting.lens.trace_from_film(*film, *pupil).is_ok();
    setting.aims().iter().filter(|aim| passes(aim)).count()
}

/// 1024 rays from the film, 11 surfaces, f64.
#[divan::bench]
fn trace_f64(bencher: divan::Bencher) {
    let setting = Setting::new();
    let aims = setting.aims();
    bencher
        .counter(ItemsCount::new(aims.len()))
        .bench_local(|| {
            aims.iter()
                .filter(|(film, pupil)| setting.lens.trace_from_film(*film, *pupil).is_ok())
                .count()
        });
}

/// The same in f32.
#[divan::bench]
fn trace_f32(bencher: divan::Bencher) {
    let setting = Setting::new();
    let tracer = LensTracer::<f32>::new(setting.lens.surfaces());
    let film_z = setting.lens.film_z();
    let ray = |(film, pupil): &([f64; 2], [f64; 3])| {
        let from = [film[0], film[1], film_z];
        LensRay::through(from.map(|x| x as f32), pupil.map(|x| x as f32))
    };
    let rays: Vec<LensRay<f32>> = setting.aims().iter().map(ray).collect();
    bencher
        .counter(ItemsCount::new(rays.len()))
        .bench_local(|| rays.iter().filter(|r| tracer.to_scene(r).is_ok()).count());
}

/// In f32 lanes, with each set of vector instructions of this processor.
#[divan::bench(args = names(), consts = [8, 16, 32])]
fn trace_lanes<const N: usize>(bencher: divan::Bencher, name: &str) {
    let setting = Setting::new();
    let (tracer, instructions) = (&setting.tracer(), instructions(name));
    let bundles = setting.bundles::<N>();
    bencher.counter(ItemsCount::new(RAYS)).bench_local(|| {
        for [film, pupil] in &bundles {
            black_box(instructions.run(Bundle {
                tracer,
                film,
                pupil,
            }));
        }
    });
}

struct Bundle<'a, const N: usize> {
    tracer: &'a FilmTracer,
    film: &'a [Lanes<N>; 2],
    pupil: &'a [Lanes<N>; 2],
}

impl<const N: usize> Kernel for Bundle<'_, N> {
    type Output = Traced<Lanes<N>>;
    #[inline(always)]
    fn run(self, _: impl Instructions) -> Self::Output {
        self.tracer.trace(self.film, self.pupil)
    }
}

/// With derivatives by the film point, which texture filtering asks for.
#[divan::bench(args = names(), consts = [8, 16, 32])]
fn trace_lanes_with_derivatives<const N: usize>(bencher: divan::Bencher, name: &str) {
    let setting = Setting::new();
    let (tracer, instructions) = (&setting.tracer(), instructions(name));
    let bundles = setting.bundles::<N>();
    bencher.counter(ItemsCount::new(RAYS)).bench_local(|| {
        for [film, pupil] in &bundles {
            let bundle = Bundle {
                tracer,
                film,
                pupil,
            };
            black_box(instructions.run(WithDerivatives(bundle)));
        }
    });
}

struct WithDerivatives<'a, const N: usize>(Bundle<'a, N>);

impl<const N: usize> Kernel for WithDerivatives<'_, N> {
    type Output = Traced<Dual<Lanes<N>>>;
    #[inline(always)]
    fn run(self, _: impl Instructions) -> Self::Output {
        let ([x, y], pupil) = (*self.0.film, *self.0.pupil);
        let film = [Dual::parameter(x, 0), Dual::parameter(y, 1)];
        self.0.tracer.trace(&film, &pupil.map(Dual::fixed))
    }
}

/// The sets of vector instructions of this processor.
fn names() -> Vec<&'static str> {
    InstructionSet::available()
        .iter()
        .map(|i| i.name())
        .collect()
}

fn instructions(name: &str) -> InstructionSet {
    let available = InstructionSet::available();
    *available
        .iter()
        .find(|i| i.name() == name)
        .expect("one of them")
}

/// The same in f64, with derivatives by the film point.
#[divan::bench]
fn trace_with_derivatives(bencher: divan::Bencher) {
    let setting = Setting::new();
    let aims = setting.aims();
    let film_z = setting.lens.film_z();
    bencher
        .counter(ItemsCount::new(aims.len()))
        .bench_local(|| {
            aims.iter()
                .filter(|(film, pupil)| {
                    let from = [film[0], film[1], film_z];
                    setting
                        .lens
                        .tracer()
                        .to_scene_with_derivatives(from, *pupil)
                        .is_ok()
                })
                .count()
        });
}

/// From camera to world, some rotation and shift.
fn mount() -> (DMat3, DVec3) {
    (DMat3::from_rotation_y(0.3), DVec3::new(1.0, 2.0, 3.0))
}

/// A useful ray one at a time in f64, as the camera of the first issue made it: time for each that passed.
#[divan::bench]
fn useful_f64(bencher: divan::Bencher) {
    let setting = Setting::new();
    let (rotation, shift) = mount();
    bencher
        .counter(ItemsCount::new(useful(&setting)))
        .bench_local(|| {
            for s in &setting.samples {
                let Some(pupil) = setting.pupil.sample(s.film, s.u) else {
                    continue;
                };
                let Ok(ray) = setting.lens.trace_from_film(s.film, pupil.point) else {
                    continue;
                };
                let o = rotation * DVec3::from(ray.o) + shift;
                let d = (rotation * DVec3::from(ray.d)).normalize();
                let film = [s.film[0], s.film[1], setting.lens.film_z()];
                black_box((
                    o.as_vec3(),
                    d.as_vec3(),
                    projected_solid_angle(film, &pupil) as f32,
                ));
            }
        });
}

/// A useful ray in lanes.
#[divan::bench(args = names(), consts = [8, 16, 32])]
fn useful_lanes<const N: usize>(bencher: divan::Bencher, name: &str) {
    let setting = Setting::new();
    let (rotation, shift) = mount();
    let model = LensModel::exact(&setting.lens, setting.pupil.plane_z());
    let bundles: Vec<[[Lanes<N>; 2]; 2]> = setting
        .samples
        .chunks(N)
        .map(|c| {
            let lane = |f: &dyn Fn(&Sample) -> f32| {
                Lanes(std::array::from_fn(|i| f(c.get(i).unwrap_or(&c[0]))))
            };
            [
                [lane(&|s| s.film[0] as f32), lane(&|s| s.film[1] as f32)],
                [lane(&|s| s.u.x), lane(&|s| s.u.y)],
            ]
        })
        .collect();
    let rotation = rotation
        .transpose()
        .to_cols_array_2d()
        .map(|r| r.map(|x| x as f32));
    let shift = shift.as_vec3().to_array();
    let instructions = instructions(name);
    bencher
        .counter(ItemsCount::new(useful(&setting)))
        .bench_local(|| {
            for [film, u] in &bundles {
                black_box(instructions.run(UsefulRays {
                    model: &model,
                    pupil: &setting.pupil,
                    film,
                    u,
                    rotation: &rotation,
                    shift: &shift,
                }));
            }
        });
}

struct UsefulRays<'a, const N: usize> {
    model: &'a LensModel,
    pupil: &'a ExitPupil,
    film: &'a [Lanes<N>; 2],
    u: &'a [Lanes<N>; 2],
    rotation: &'a [[f32; 3]; 3],
    shift: &'a [f32; 3],
}

impl<const N: usize> Kernel for UsefulRays<'_, N> {
    type Output = ([Lanes<N>; 3], [Lanes<N>; 3], Lanes<N>, u32);
    #[inline(always)]
    fn run(self, _: impl Instructions) -> Self::Output {
        let rays = self.model.rays(self.pupil, self.film, self.u);
        let LensRay { o, d } = rays.traced.ray;
        let turn = |v: &[Lanes<N>; 3], r: &[f32; 3]| {
            v[0].times(r[0]) + v[1].times(r[1]) + v[2].times(r[2])
        };
        let [a, b, c] = self.rotation;
        let o = [
            turn(&o, a).plus(self.shift[0]),
            turn(&o, b).plus(self.shift[1]),
            turn(&o, c).plus(self.shift[2]),
        ];
        let d = LensRay::new(o, [turn(&d, a), turn(&d, b), turn(&d, c)]).d;
        (o, d, rays.projected_solid_angle, rays.traced.passed.count())
    }
}

/// Finding the exit pupil's regions.
#[divan::bench]
fn exit_pupil(bencher: divan::Bencher) {
    let lens = lens();
    bencher.bench_local(|| ExitPupil::new(&lens, 22.0, RINGS));
}

/// Setting up a camera of each lens of ours and of the golden data, focused at infinity, for full frame (43 mm of diagonal)
/// and for a film far larger than most image circles (120 mm): at most 50 ms of one core.
#[divan::bench(args = cameras(), sample_count = 5)]
fn camera_set_up(bencher: divan::Bencher, name: &str) {
    let (file, diagonal) = name.split_once(" on ").expect("as `cameras` makes them");
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let prescription = Prescription::read(&root.join(file)).expect("a lens file of ours");
    let distance = Lens::focused(&prescription, f64::INFINITY).expect("a lens that focuses");
    let spec = RealisticSpec {
        lens_name: file.to_string(),
        nominal_focal_length: None,
        lens: Lens::new(&prescription, distance).expect("a lens with its film behind it"),
        form: Form::Pbrt3,
        weighting: Weighting::Physical,
        compat: Default::default(),
        pupil_sampling: Default::default(),
        model: Default::default(),
        precision: Default::default(),
        stop_shape: None,
        bands: Vec::new(),
        ghosts: false,
        coating: None,
        film_diagonal: None,
        shutter: Shutter::default(),
        shift: [0.0; 2],
        tilt: [0.0; 2],
        autofocus: None,
        exposure: Default::default(),
        clip: Clip::NONE,
    };
    let film = FilmGeometry {
        resolution: UVec2::new(6000, 4000),
        diagonal_mm: diagonal.parse().expect("a number"),
    };
    bencher.bench_local(|| Realistic::new(&spec, &film, &Transform::IDENTITY).is_ok());
}

/// Lens file and film diagonal, mm.
fn cameras() -> Vec<String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut files = Vec::new();
    for folder in ["lenses", "tests/golden"] {
        let entries = std::fs::read_dir(root.join(folder)).expect("a folder of ours");
        let names = entries.flatten().map(|e| e.file_name());
        let lenses = names.filter_map(|n| Some(n.to_str()?.to_string()));
        files.extend(
            lenses
                .filter(|n| n.ends_with(".dat"))
                .map(|n| format!("{folder}/{n}")),
        );
    }
    files.sort();
    let both = |file: &String| [43.267, 120.0].map(|d| format!("{file} on {d}"));
    files.iter().flat_map(both).collect()
}
