//! Writes `docs/generated/confidence.md`: how often images that `--error 20% --confidence 95%` ends are as good as it says, and
//! whether their intervals hold the truth.
//!
//! `cargo run --release --features studies --example sure_errors` renders 40 scenes of `tests/scenes/census` with 16 × 16 pixels, 200 seeds each,
//! with and without the confidence, on all processors: half an hour of one. The argument is another number of seeds.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a panic is an answer here"
)]
#![allow(clippy::print_stderr, clippy::print_stdout)]

use fstop::build::build;
use fstop::compare::{Estimate, Options, Pool, block_p_values};
use fstop::film::Image;
use fstop::glam::DVec3;
use fstop::math::Rgb;
use fstop::render::{
    Goal, Progress, Progressive, RenderJob, TILE_SIZE, render_halves, render_until,
};
use fstop::samplers::{Sampler, SamplerSpec};
use fstop::scene::{ReadSettings, read_scene};
use fstop::syntax::SourceMap;
use std::error::Error;
use std::fmt::Write;
use std::path::{Path, PathBuf};

const SCENES: usize = 40;
const SEEDS: u64 = 200;
const PIXELS: u32 = 16 * 16;
const GOAL: f64 = 0.2;
const CONFIDENCE: f64 = 0.95;

/// Most samples a pixel.
const MOST: u32 = 256;

/// Samples a pixel of the reference.
const REFERENCE: u32 = 1 << 12;

const HEAD: &str = "# Confidence: measured

Written by `cargo run --release --features studies --example sure_errors`, not by hand. [Samplers](../samplers.md#how-sure-an-error-is) says what is
measured, and how.

40 scenes of `tests/scenes/census`, 16 × 16 pixels, Sobol's points; `--error 20%`, at most 256 samples a pixel.
*good*: of the images that ended as good enough, those whose true error is at most 20 %. *flagged*: images that did not, as few pixels have
most of the error or samples were used up. *intervals*: 95 % intervals that hold the truth, of blocks of 8 × 8 pixels and of the
whole image, channel by channel, of images that are not flagged.

";

const COLUMNS: &str = "\
| scene | spp | good | spp, 95 % sure | good | flagged | intervals: 8 × 8 | image |
|---|---:|---:|---:|---:|---:|---:|---:|
";

fn main() -> Result<(), Box<dyn Error>> {
    let seeds = std::env::args().nth(1).map(|n| n.parse()).transpose()?;
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let seeds = seeds.unwrap_or(SEEDS);
    let mut page = format!("{HEAD}{seeds} seeds for each scene.\n\n{COLUMNS}");
    let mut all = Counts::default();
    for scene in scenes(&root.join("tests/scenes/census"))? {
        let (plain, sure) = measure(&scene, seeds);
        let name = scene.file_stem().unwrap_or_default().to_string_lossy();
        let line = format!(
            "| {name} | {} | {} |",
            plain.row(),
            sure.row() + &sure.rest()
        );
        println!("{line}");
        writeln!(page, "{line}")?;
        all.add(&sure);
    }
    writeln!(page, "| all | | | {}{} |", all.row(), all.rest())?;
    println!("{}", page.lines().last().unwrap_or_default());
    std::fs::write(root.join("docs/generated/confidence.md"), page)?;
    Ok(())
}

/// The first by name, but for those of Markov chains and photons, whose pixels share their samples.
fn scenes(folder: &Path) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    let files = std::fs::read_dir(folder)?.collect::<Result<Vec<_>, _>>()?;
    let is_meant = |path: &PathBuf| {
        let name = path.to_string_lossy();
        name.ends_with(".pbrt") && !name.contains("_mlt") && !name.contains("_sppm")
    };
    let mut scenes: Vec<PathBuf> = { files.iter() }
        .map(|file| file.path())
        .filter(is_meant)
        .collect();
    scenes.sort();
    scenes.truncate(SCENES);
    Ok(scenes)
}

/// Of images of one scene.
#[derive(Default)]
struct Counts {
    images: u64,
    ended: u64,
    good: u64,
    samples: f64,
    /// Intervals of blocks and of the image that hold the truth, and all.
    blocks: [u64; 2],
    whole: [u64; 2],
}

impl Counts {
    fn add(&mut self, other: &Counts) {
        self.images += other.images;
        self.ended += other.ended;
        self.good += other.good;
        self.samples += other.samples;
        for i in [0, 1] {
            self.blocks[i] += other.blocks[i];
            self.whole[i] += other.whole[i];
        }
    }

    fn row(&self) -> String {
        let spp = self.samples / self.images.max(1) as f64;
        format!("{spp:.0} | {}", percent([self.good, self.ended]))
    }

    fn rest(&self) -> String {
        let flagged = percent([self.images - self.ended, self.images]);
        format!(
            " | {flagged} | {} | {}",
            percent(self.blocks),
            percent(self.whole)
        )
    }

    fn judge(&mut self, done: &Progressive, truth: &Image, is_flagged: bool) {
        let image = done.film.clone().image();
        self.images += 1;
        self.samples += done.spp;
        if is_flagged {
            return;
        }
        self.ended += 1;
        self.good += u64::from(true_error(&image, truth) <= GOAL);
        let freedom = done.spp.round() - 2.0;
        for (side, counts) in [(8, &mut self.blocks), (u32::MAX, &mut self.whole)] {
            let held = intervals(&image, truth, freedom, side);
            *counts = [counts[0] + held[0], counts[1] + held[1]];
        }
    }
}

fn percent([part, all]: [u64; 2]) -> String {
    match all {
        0 => "–".to_string(),
        all => format!("{:.1} %", 100.0 * part as f64 / all as f64),
    }
}

/// Without the confidence, and with it.
fn measure(scene: &Path, seeds: u64) -> (Counts, Counts) {
    let truth = reference(scene);
    let processors = std::thread::available_parallelism().map_or(1, usize::from);
    let of_thread = &|first: usize| {
        let mut job = job(scene);
        let (mut plain, mut sure) = (Counts::default(), Counts::default());
        for seed in (first as u64..seeds).step_by(processors) {
            job.sampler = Sampler::new(&SamplerSpec::sobol(16), 1 + seed);
            for (confidence, counts) in [(None, &mut plain), (Some(CONFIDENCE), &mut sure)] {
                let goal = Goal {
                    error: Some(GOAL),
                    confidence,
                    time: None,
                    max_spp: MOST,
                };
                let done = render_until(&job, TILE_SIZE, &goal, &Progress::hidden());
                counts.judge(&done, &truth, done.ended != fstop::render::Ended::Error);
            }
        }
        (plain, sure)
    };
    let mut all = (Counts::default(), Counts::default());
    std::thread::scope(|threads| {
        let start = |first| threads.spawn(move || of_thread(first));
        let started: Vec<_> = (0..processors).map(start).collect();
        for thread in started {
            let (plain, sure) = thread.join().expect("no panic");
            all.0.add(&plain);
            all.1.add(&sure);
        }
    });
    all
}

fn job(scene: &Path) -> RenderJob {
    let sources = SourceMap::new();
    let file = sources.open(scene).unwrap();
    let (scene, _) = read_scene(&sources, file, &ReadSettings::default());
    let mut frame = scene.frames.into_iter().next().expect("a frame");
    frame.options.film.shrink(PIXELS);
    build(frame, 0).0.expect("a scene without errors").job
}

fn reference(scene: &Path) -> Image {
    let mut job = job(scene);
    job.sampler = Sampler::new(&SamplerSpec::sobol(REFERENCE), 1 << 32);
    render_halves(&job, 4, &Progress::hidden()).film.image()
}

/// As `Progressive::error` is defined, against the truth.
fn true_error(image: &Image, truth: &Image) -> f64 {
    let values = 3.0 * truth.pixels.len() as f64;
    let sum: DVec3 = truth.pixels.iter().map(|p| p.as_dvec3()).sum();
    let floor = (0.01 * sum.element_sum() / values).powi(2);
    let square = |(p, t): (&Rgb, &Rgb)| {
        let (p, t) = (p.as_dvec3(), t.as_dvec3());
        ((p - t) * (p - t) / (t * t + floor)).element_sum()
    };
    let squares = image.pixels.iter().zip(&truth.pixels).map(square);
    // What the reference has of it.
    let variances = truth.variance.iter().flatten().zip(&truth.pixels);
    let own = |(v, t): (&Rgb, &Rgb)| {
        let (v, t) = (v.as_dvec3(), t.as_dvec3());
        (v / (t * t + floor)).element_sum()
    };
    let square = squares.sum::<f64>() - variances.map(own).sum::<f64>();
    (square.max(0.0) / values).sqrt()
}

/// Intervals of blocks that hold the truth, and all.
fn intervals(image: &Image, truth: &Image, freedom: f64, side: u32) -> [u64; 2] {
    let estimate = |image, freedom| Estimate {
        image,
        freedom,
        pool: Some(Pool {
            side: 4,
            freedom: 1.0,
        }),
        samples: None,
        light_paths: None,
    };
    let own = estimate(image, freedom);
    let exact = estimate(truth, f64::from(REFERENCE) - 2.0);
    let options = Options {
        relative_tolerance: 0.0,
        ..Options::default()
    };
    let p = block_p_values(&own, &exact, &options, side).expect("of one size");
    let corners = image.bounds.tiles(side).map(|block| block.min);
    // Those of black blocks, which are exact, say nothing.
    let p = corners.flat_map(|corner| p.pixel(corner).to_array());
    let held = p.filter(|p| *p < 1.0);
    held.fold([0, 0], |[held, all], p| {
        [held + u64::from(p >= 0.05), all + 1]
    })
}
