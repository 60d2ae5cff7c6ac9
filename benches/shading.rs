//! What happens at a hit, and the numbers for it: `cargo bench --bench shading`.
//!
//! `numbers`: items are random numbers, drawn in the order of a camera sample and three bounces.
//! `bsdf_*` and `lights`: items are points of a sphere that a camera looks at. `bsdf_made` evaluates the
//! material's textures and builds its lobes, `bsdf_sampled` also samples a direction, `bsdf_evaluated` also
//! evaluates value and density of another.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a panic is an answer here"
)]

use divan::Bencher;
use divan::counter::ItemsCount;
use fstop::accel::GeometryHit;
use fstop::bsdf::Bsdf;
use fstop::build::build;
use fstop::cameras::CameraSample;
use fstop::lights::{LightSelector, SelectionStrategy};
use fstop::math::ray::RayDifferentials;
use fstop::math::{IVec2, Vec2};
use fstop::render::RenderJob;
use fstop::samplers::{Points, Sampler, SamplerSpec, Stratified};
use fstop::scene::{ReadSettings, read_scene};
use fstop::syntax::SourceMap;
use std::hint::black_box;

fn main() {
    divan::main();
}

/// Samples of each measurement.
const SAMPLES: u32 = 1024;

#[divan::bench(args = ["random", "stratified", "sobol"])]
fn numbers(bencher: Bencher, name: &str) {
    let points = match name {
        "random" => Points::Random,
        "stratified" => Points::Stratified(Stratified::new(32, 32, true, None)),
        _ => Points::Sobol,
    };
    let spec = SamplerSpec {
        points,
        ..SamplerSpec::sobol(SAMPLES)
    };
    let sampler = Sampler::new(&spec, 1);
    // Film, time and lens; then for each bounce light, direction, and whether to go on.
    const BOUNCES: u32 = 3;
    let count = 5 + 7 * BOUNCES;
    bencher.counter(ItemsCount::new(SAMPLES * count)).bench(|| {
        let mut sum = Vec2::ZERO;
        for index in 0..SAMPLES {
            let mut stream = sampler.stream(IVec2::new(3, 4), index);
            sum += stream.next_2d();
            sum.x += stream.next_1d();
            sum += stream.next_2d();
            for _ in 0..BOUNCES {
                sum.x += stream.next_1d();
                sum += stream.next_2d();
                sum.x += stream.next_1d();
                sum += stream.next_2d();
                sum.x += stream.next_1d();
            }
        }
        sum
    });
}

/// A sphere of a material that fills the image, with what else is in the scene.
fn job(material: &str, lights: &str) -> RenderJob {
    let text = format!(
        "LookAt 0 0 -4  0 0 0  0 1 0\nCamera \"perspective\" \"float fov\" 20\n\
         Film \"image\" \"integer xresolution\" 32 \"integer yresolution\" 32\n\
         WorldBegin\n{lights}\n{material}\nShape \"sphere\"\nWorldEnd\n"
    );
    let sources = SourceMap::new();
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/benches/shading.pbrt");
    let file = sources.add_text(path, text);
    let (scene, diagnostics) = read_scene(&sources, file, &ReadSettings::default());
    assert!(!diagnostics.has_errors(), "{material} {lights}");
    let frame = scene.frames.into_iter().next().expect("a frame");
    build(frame, 1).0.expect("a scene that can be built").job
}

/// Where camera rays through all pixels meet the sphere.
fn hits(job: &RenderJob) -> Vec<(GeometryHit, Option<RayDifferentials>)> {
    let mut found = Vec::new();
    for pixel in 0..SAMPLES {
        let sample = CameraSample {
            raster: Vec2::new((pixel % 32) as f32 + 0.3, (pixel / 32) as f32 + 0.6),
            time: 0.5,
            lens: Vec2::splat(0.5),
            wavelength: 0.5,
        };
        let mut rays = [None];
        job.camera.rays(&[sample], true, &mut rays);
        for ray in rays.into_iter().flatten() {
            let hit = job.world.intersect(&ray.ray);
            found.extend(hit.map(|hit| (hit, ray.differentials)));
        }
    }
    assert!(found.len() > 900, "the sphere fills the image");
    found
}

/// Families of BSDFs, and textures of each kind as a `matte` surface's color.
const MATERIALS: [(&str, &str); 19] = [
    ("matte", "Material \"matte\""),
    ("oren-nayar", "Material \"matte\" \"float sigma\" 30"),
    ("mirror", "Material \"mirror\""),
    ("plastic", "Material \"plastic\""),
    ("metal", "Material \"metal\" \"float roughness\" .1"),
    ("glass", "Material \"glass\""),
    (
        "rough glass",
        "Material \"glass\" \"float uroughness\" .2 \"float vroughness\" .2",
    ),
    ("substrate", "Material \"substrate\""),
    ("translucent", "Material \"translucent\""),
    (
        "uber",
        "Material \"uber\" \"rgb opacity\" [.8 .8 .8] \"rgb Kt\" [.2 .2 .2]",
    ),
    (
        "disney",
        "Material \"disney\" \"float clearcoat\" 1 \"float sheen\" 1",
    ),
    ("hair", "Material \"hair\""),
    (
        "mix",
        "MakeNamedMaterial \"a\" \"string type\" \"matte\"\nMakeNamedMaterial \"b\" \"string type\" \"plastic\"\n\
         Material \"mix\" \"string namedmaterial1\" \"a\" \"string namedmaterial2\" \"b\"",
    ),
    (
        "matte, imagemap",
        "Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"../tests/scenes/reference/textures/tiles.png\"\n\
         Material \"matte\" \"texture Kd\" \"t\"",
    ),
    (
        "matte, trilinear",
        "Texture \"t\" \"spectrum\" \"imagemap\" \"bool trilinear\" \"true\" \"string filename\" \
         \"../tests/scenes/reference/textures/tiles.png\"\nMaterial \"matte\" \"texture Kd\" \"t\"",
    ),
    (
        "matte, checkerboard",
        "Texture \"t\" \"spectrum\" \"checkerboard\"\nMaterial \"matte\" \"texture Kd\" \"t\"",
    ),
    (
        "matte, fbm",
        "Texture \"t\" \"spectrum\" \"fbm\"\nMaterial \"matte\" \"texture Kd\" \"t\"",
    ),
    (
        "matte, marble",
        "Texture \"t\" \"spectrum\" \"marble\"\nMaterial \"matte\" \"texture Kd\" \"t\"",
    ),
    (
        "matte, fbm bumps",
        "Texture \"t\" \"float\" \"fbm\"\nMaterial \"matte\" \"texture bumpmap\" \"t\"",
    ),
];

fn material_names() -> impl Iterator<Item = &'static str> {
    MATERIALS.iter().map(|(name, _)| *name)
}

fn shot_of_material(name: &str) -> RenderJob {
    let found = MATERIALS.iter().find(|(known, _)| *known == name);
    job(found.expect("one of the names").1, "")
}

#[divan::bench(args = material_names())]
fn bsdf_made(bencher: Bencher, name: &str) {
    let job = shot_of_material(name);
    let hits = hits(&job);
    bencher.counter(ItemsCount::new(hits.len())).bench(|| {
        for (hit, differentials) in &hits {
            let material = job.world.material(hit.material).expect("all have one");
            let mut bsdf = Bsdf::empty();
            job.world
                .fill_bsdf(material, &hit.surface, differentials.as_ref(), &mut bsdf);
            // Moving it would cost more than making it.
            black_box(&bsdf);
        }
    });
}

/// Two numbers for thing `i`, spread evenly.
fn numbers_of(i: usize) -> Vec2 {
    Vec2::new(
        (0.5 + i as f32 * 0.754_877_7).fract(),
        (0.5 + i as f32 * 0.569_840_3).fract(),
    )
}

#[divan::bench(args = material_names())]
fn bsdf_sampled(bencher: Bencher, name: &str) {
    let job = shot_of_material(name);
    let hits = hits(&job);
    bencher.counter(ItemsCount::new(hits.len())).bench(|| {
        for (i, (hit, differentials)) in hits.iter().enumerate() {
            let surface = &hit.surface;
            let material = job.world.material(hit.material).expect("all have one");
            let mut bsdf = Bsdf::empty();
            job.world
                .fill_bsdf(material, surface, differentials.as_ref(), &mut bsdf);
            let u = numbers_of(i);
            black_box(bsdf.sample(surface.wo, u.y, u));
        }
    });
}

#[divan::bench(args = material_names())]
fn bsdf_evaluated(bencher: Bencher, name: &str) {
    let job = shot_of_material(name);
    let hits = hits(&job);
    bencher.counter(ItemsCount::new(hits.len())).bench(|| {
        for (i, (hit, differentials)) in hits.iter().enumerate() {
            let surface = &hit.surface;
            let material = job.world.material(hit.material).expect("all have one");
            let mut bsdf = Bsdf::empty();
            job.world
                .fill_bsdf(material, surface, differentials.as_ref(), &mut bsdf);
            let wi = fstop::math::sampling::uniform_sphere(numbers_of(i));
            black_box(bsdf.f_and_pdf(surface.wo, wi));
        }
    });
}

/// Choosing a light of the scene and a point of it.
#[divan::bench(args = ["point", "triangles", "sphere", "sky", "64 spheres"])]
fn lights(bencher: Bencher, name: &str) {
    let light = "AttributeBegin\nAreaLightSource \"diffuse\"";
    let ball = |i: usize| {
        format!(
            "{light}\nTranslate {} 3 {}\nShape \"sphere\" \"float radius\" .1\nAttributeEnd\n",
            i / 8,
            i % 8
        )
    };
    let text = match name {
        "point" => "LightSource \"point\" \"point from\" [0 3 0]".to_string(),
        "triangles" => format!(
            "{light}\nShape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \
             \"point P\" [-1 3 -1 1 3 -1 1 3 1 -1 3 1]\nAttributeEnd"
        ),
        "sphere" => ball(0),
        "sky" => {
            "LightSource \"infinite\" \"string mapname\" \"../tests/scenes/reference/textures/sky.exr\""
                .to_string()
        }
        _ => (0..64).map(ball).collect(),
    };
    let job = job("Material \"matte\"", &text);
    let hits = hits(&job);
    let world = &job.world;
    let (_, radius) = world.geometry.bounds().bounding_sphere();
    let selector = LightSelector::new(world.sampled_lights(), SelectionStrategy::Spatial, radius);
    bencher.counter(ItemsCount::new(hits.len())).bench(|| {
        for (i, (hit, _)) in hits.iter().enumerate() {
            let from = hit.surface.reference_point();
            let u = numbers_of(i);
            let choice = selector.sample(&from, u.y);
            black_box(choice.and_then(|chosen| world.light(chosen.light).sample(&from, u)));
        }
    });
}
