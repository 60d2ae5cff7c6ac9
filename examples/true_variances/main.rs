//! Writes `docs/generated/variances.md` and `variances_power.md`: whether the variances of `render --variance` are true, and what they cost.
//!
//! `cargo run --release --features studies --example true_variances` renders 400 images in two halves and 400 of one set for every sampler on
//! the scenes of `examples/sampler_curves` and on the Cornell box, and 200 pairs of the whole Cornell box, on all processors: an
//! hour of one. Arguments: other numbers of images and of pairs; 0 leaves the page as it is.
//!
//! What the images really scatter by is that of their pixels from image to image, and the expectation is their mean.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a panic is an answer here"
)]
#![allow(clippy::print_stderr)]

use fstop::build::build;
use fstop::compare::{Estimate, Options, Pool, block_p_values, compare};
use fstop::film::Image;
use fstop::glam::DVec3;
use fstop::math::Rgb;
use fstop::render::{Progress, RenderJob, TILE_SIZE, render, render_halves};
use fstop::samplers::{Points, Sampler, SamplerSpec, Stratified};
use fstop::scene::{ReadSettings, read_scene};
use fstop::syntax::SourceMap;
use rayon::prelude::*;
use std::error::Error;
use std::fmt::Write;
use std::path::Path;

const SCENES: [&str; 6] = ["box", "lens", "glossy", "motion", "lamps", "cornell"];

/// Samples a pixel.
const SPP: u32 = 64;

/// Sides of the blocks whose intervals are looked at.
const SIDES: [u32; 4] = [1, 4, 8, 16];

const HEAD: &str = "# Variances: measured

Written by `cargo run --release --features studies --example true_variances`, not by hand. [Comparing renders](../compare.md#true-variances) says
what is measured, and how.

";

/// Of one sampler on one scene.
struct Measured {
    /// Squared error of images in two halves over that of images of one set.
    cost: f64,
    /// Squared error over what the files say: of two halves, and of one set as if its samples were independent.
    real: [f64; 2],
    /// Fractions of the 95 % intervals with the expectation in them: of each of [`SIDES`], and of the whole image.
    coverage: Vec<f64>,
    /// Pairs of images, the first with the second and so on, that differ.
    alarms: usize,
}

fn main() -> Result<(), Box<dyn Error>> {
    let counts: Vec<u64> = std::env::args()
        .skip(1)
        .map(|a| a.parse().unwrap())
        .collect();
    // Threads that wait for the tiles of one image take up others on top.
    let threads = rayon::ThreadPoolBuilder::new().stack_size(64 << 20);
    threads.build_global()?;
    let images = counts.first().copied().unwrap_or(400);
    let pairs = counts.get(1).copied().unwrap_or(200);
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/generated");
    if images > 0 {
        std::fs::write(folder.join("variances.md"), truth(images)?)?;
    }
    if pairs > 0 {
        std::fs::write(folder.join("variances_power.md"), power(pairs)?)?;
    }
    Ok(())
}

fn truth(images: u64) -> Result<String, Box<dyn Error>> {
    let mut page = format!("{HEAD}{images} images of {SPP} samples a pixel each.\n\n");
    page += "| scene | sampler | squared error over one set's | real over stored | the same, one set | pixels | 4 × 4 | 8 × 8 | 16 × 16 | image | differ |\n";
    page += "|---|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|\n";
    let (mut logarithm, mut count) = (0.0, 0.0);
    for scene in SCENES {
        for (name, spec) in samplers() {
            let measured = measure(scene, &spec, images);
            logarithm += measured.cost.ln();
            count += 1.0;
            write!(page, "| {scene} | {name} | {:.2} |", measured.cost)?;
            measured
                .real
                .iter()
                .try_for_each(|r| write!(page, " {r:.3} |"))?;
            let cells = measured.coverage.iter();
            cells
                .map(|c| 100.0 * c)
                .try_for_each(|c| write!(page, " {c:.1} % |"))?;
            writeln!(page, " {} of {} |", measured.alarms, images / 2)?;
            eprintln!("{}", page.lines().last().unwrap_or_default());
        }
    }
    let mean = f64::exp(logarithm / f64::max(count, 1.0));
    write!(
        page,
        "\nGeometric mean of the squared errors over one set's: {mean:.3}.\n"
    )?;
    Ok(page)
}

/// Samples that are independent of each other, and two kinds that are not.
fn samplers() -> [(&'static str, SamplerSpec); 3] {
    let grid = Points::Stratified(Stratified::new(1, 1, true, None));
    let kinds = [
        ("random", Points::Random),
        ("stratified", grid),
        ("sobol", Points::Sobol),
    ];
    kinds.map(|(name, points)| {
        let spec = SamplerSpec {
            points,
            ..SamplerSpec::sobol(SPP)
        };
        (name, spec.with_spp(SPP))
    })
}

fn job(scene: &str, pixels: u32) -> Result<RenderJob, Box<dyn Error>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let path = match scene {
        "cornell" => root.join("scenes/cornell/cornell.pbrt"),
        scene => root
            .join("examples/sampler_curves")
            .join(scene)
            .with_extension("pbrt"),
    };
    let sources = SourceMap::new();
    let file = sources.open(&path)?;
    let (scene, _) = read_scene(&sources, file, &ReadSettings::default());
    let mut frame = scene.frames.into_iter().next().ok_or("no frame")?;
    frame.options.film.shrink(pixels);
    let (built, _) = build(frame, 0);
    Ok(built.ok_or("the scene cannot be built")?.job)
}

fn in_halves(job: &mut RenderJob, spec: &SamplerSpec, seed: u64) -> Image {
    job.sampler = Sampler::new(spec, seed);
    render_halves(job, TILE_SIZE, &Progress::hidden())
        .film
        .image()
}

fn of_one_set(job: &mut RenderJob, spec: &SamplerSpec, seed: u64) -> Image {
    job.sampler = Sampler::new(spec, seed);
    render(job, TILE_SIZE, true, &Progress::hidden()).image()
}

fn estimate(image: &Image) -> Estimate<'_> {
    Estimate {
        image,
        freedom: f64::from(SPP) - 2.0,
        pool: Some(Pool {
            side: 4,
            freedom: 1.0,
        }),
        samples: Some(f64::from(SPP)),
        light_paths: None,
    }
}

fn measure(scene: &str, spec: &SamplerSpec, count: u64) -> Measured {
    let job = || job(scene, 32 * 32).expect("a scene");
    let seeds = (0..count).into_par_iter();
    let halved = { seeds.clone() }.map_init(job, |job, i| in_halves(job, spec, 2 * i));
    let halved: Vec<Image> = halved.collect();
    let whole = seeds.map_init(job, |job, i| of_one_set(job, spec, 2 * i + 1));
    let whole: Vec<Image> = whole.collect();
    let [of_halves, of_sets] = [&halved, &whole].map(|images| scatter(images));
    Measured {
        cost: of_halves / of_sets,
        real: [of_halves / stored(&halved), of_sets / stored(&whole)],
        coverage: coverage(&halved, &mean(&halved)),
        alarms: { halved.par_chunks_exact(2) }
            .filter(|pair| differ(&pair[0], &pair[1]))
            .count(),
    }
}

/// The mean of the images, as an exact one.
fn mean(images: &[Image]) -> Image {
    let mut mean = images[0].clone();
    let mut sums = vec![DVec3::ZERO; mean.pixels.len()];
    for image in images {
        for (sum, pixel) in sums.iter_mut().zip(&image.pixels) {
            *sum += pixel.as_dvec3();
        }
    }
    let means = { sums.iter() }.map(|sum| (sum / images.len() as f64).as_vec3());
    mean.pixels = means.collect();
    mean.variance = Some(vec![Rgb::ZERO; sums.len()]);
    mean.independent = None;
    mean
}

/// The sum over pixels and channels of the variance from image to image.
fn scatter(images: &[Image]) -> f64 {
    let n = images.len() as f64;
    let pixel = |i: usize| images.iter().map(move |image| image.pixels[i].as_dvec3());
    let squares = (0..images[0].pixels.len()).map(|i| {
        let mean = pixel(i).sum::<DVec3>() / n;
        let square = |x: DVec3| ((x - mean) * (x - mean)).element_sum();
        pixel(i).map(square).sum::<f64>()
    });
    squares.sum::<f64>() / (n - 1.0)
}

/// The same as the images say.
fn stored(images: &[Image]) -> f64 {
    let variances = images
        .iter()
        .flat_map(|image| image.variance.iter().flatten());
    let sum: f64 = variances.map(|v| v.as_dvec3().element_sum()).sum();
    sum / images.len() as f64
}

/// Whether `compare` says that two images differ.
fn differ(a: &Image, b: &Image) -> bool {
    let comparison = compare(&estimate(a), &estimate(b), &Options::default());
    !comparison.expect("images of one size").agrees()
}

fn coverage(images: &[Image], truth: &Image) -> Vec<f64> {
    let options = Options {
        common_variance: false,
        relative_tolerance: 0.0,
        ..Options::default()
    };
    let exact = Estimate {
        image: truth,
        freedom: f64::INFINITY,
        pool: None,
        samples: None,
        light_paths: None,
    };
    let inside = |side: u32| {
        let [inside, all] = { images.par_iter() }
            .map(|image| held(image, &exact, &options, side))
            .reduce(|| [0; 2], |a, b| [a[0] + b[0], a[1] + b[1]]);
        inside as f64 / all as f64
    };
    SIDES.into_iter().chain([u32::MAX]).map(inside).collect()
}

/// Intervals of blocks that hold the truth, and all, each block once for every noisy channel of a pixel in it.
fn held(image: &Image, truth: &Estimate, options: &Options, side: u32) -> [u64; 2] {
    let p = block_p_values(&estimate(image), truth, options, side).expect("of one size");
    let noisy = image.variance.as_ref().expect("films have variances");
    let pixels = p.pixels.iter().zip(noisy);
    let channels = pixels.flat_map(|(p, v)| (0..3).filter(|&c| v[c] > 0.0).map(move |c| p[c]));
    channels.fold([0, 0], |[held, all], p| {
        [held + u64::from(p >= 0.05), all + 1]
    })
}

/// How often half a percent more light is found in the Cornell box, and how often a difference where there is none.
fn power(pairs: u64) -> Result<String, Box<dyn Error>> {
    let mut text =
        format!("{HEAD}Differences found by `compare` as it is, {SPP} samples a pixel.\n\n");
    text +=
        "| Cornell box, 300 × 300 pixels | of the same | of 0.5 % more light |\n|---|---:|---:|\n";
    let job = || job("cornell", 300 * 300).expect("a scene");
    // The scene's own.
    for (name, spec) in samplers().into_iter().filter(|(name, _)| *name == "sobol") {
        let of_pair = |job: &mut RenderJob, i: u64| {
            let [a, b] = [0, 1].map(|k| in_halves(job, &spec, 10_000 + 2 * i + k));
            [1.0, 1.005].map(|factor| u64::from(differ(&times(&a, factor), &b)))
        };
        let found = { (0..pairs).into_par_iter() }
            .map_init(job, of_pair)
            .reduce(|| [0; 2], |a, b| [a[0] + b[0], a[1] + b[1]]);
        writeln!(
            text,
            "| {name}: found in | {} of {pairs} | {} of {pairs} |",
            found[0], found[1]
        )?;
        eprintln!("{}", text.lines().last().unwrap_or_default());
    }
    Ok(text)
}

fn times(image: &Image, factor: f64) -> Image {
    let mut brighter = image.clone();
    brighter.pixels.iter_mut().for_each(|p| *p *= factor as f32);
    let both = [brighter.variance.as_mut(), brighter.independent.as_mut()];
    let variances = both.into_iter().flatten().flatten();
    variances.for_each(|v| *v *= (factor * factor) as f32);
    brighter
}
