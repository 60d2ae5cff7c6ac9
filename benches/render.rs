//! Whole small renders, scene file to film: `cargo bench --bench render`.
//!
//! Items are camera samples: divan prints samples a second. `built_from_text` is the time from text to
//! world. One thread, but for `rendered_on_two_threads`.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a panic is an answer here"
)]

use divan::Bencher;
use divan::counter::ItemsCount;
use fstop::build::{PreparedScene, build};
use fstop::render::{Progress, RenderJob, TILE_SIZE, render};
use fstop::samplers::{Sampler, SamplerSpec};
use fstop::scene::{ReadSettings, read_scene};
use fstop::syntax::SourceMap;
use std::path::Path;

fn main() {
    divan::main();
}

/// Of `tests/scenes/reference`, one for each thing that takes time.
const SCENES: [&str; 8] = [
    "int_cornell_path",
    "int_veach_mis",
    "int_volpath_fog",
    "light_infinite_map",
    "mat_subsurface",
    "realistic_dgauss50_full",
    "shape_instancing",
    "tex_imagemap",
];

/// Samples a pixel.
const SPP: u32 = 4;

fn built(scene: &str) -> PreparedScene {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/scenes/reference");
    let sources = SourceMap::new();
    let file = sources.open(&folder.join(scene).with_extension("pbrt"));
    let (scene, _) = read_scene(
        &sources,
        file.expect("a scene file"),
        &ReadSettings::default(),
    );
    let frame = scene.frames.into_iter().next().expect("a frame");
    build(frame, 1).0.expect("a scene that can be built")
}

/// With Sobol' points, whatever the scene names.
fn job(scene: &str) -> RenderJob {
    let mut job = built(scene).job;
    job.sampler = Sampler::new(&SamplerSpec::sobol(SPP), 1);
    job
}

fn pool(threads: usize) -> rayon::ThreadPool {
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .expect("a pool")
}

fn bench_render(bencher: Bencher, scene: &str, threads: usize) {
    let (job, pool) = (job(scene), pool(threads));
    let samples = job.film.pixel_bounds().area() * SPP as usize;
    bencher
        .counter(ItemsCount::new(samples))
        .bench_local(|| pool.install(|| render(&job, TILE_SIZE, false, &Progress::hidden())));
}

#[divan::bench(args = SCENES, sample_count = 10)]
fn rendered(bencher: Bencher, scene: &str) {
    bench_render(bencher, scene, 1);
}

#[divan::bench(args = ["int_cornell_path", "realistic_dgauss50_full"], sample_count = 10)]
fn rendered_on_two_threads(bencher: Bencher, scene: &str) {
    bench_render(bencher, scene, 2);
}

#[divan::bench(args = SCENES, sample_count = 10)]
fn built_from_text(bencher: Bencher, scene: &str) {
    let pool = pool(1);
    bencher.bench_local(|| pool.install(|| built(scene)));
}
