//! Writes `docs/generated/efficiency.md`: the time to equal error of `bdpt` against pbrt-v3's own, for every scene of the census.
//!
//! `cargo run --release --features studies --example census_efficiency` renders the scenes of `tests/scenes/census/pbrt.txt`, which holds pbrt-v3's
//! figures, with 64 seeds each: some twenty minutes of one processor. Arguments, in any order: another number of seeds; `sobol`,
//! which adds a column with samples of that sampler instead of the scene's; `cornell=SECONDS`, which tells how fast this machine is
//! ([`CORNELL`]); and parts of names, for these scenes alone, which are then printed and not written.

#![allow(clippy::print_stdout, reason = "it is a program")]

use fstop::build::build;
use fstop::film::Image;
use fstop::math::color::luminance;
use fstop::render::{Progress, TILE_SIZE, render};
use fstop::samplers::SamplerSpec;
use fstop::scene::{ReadSettings, read_scene};
use fstop::syntax::SourceMap;
use fstop::tradeoff::clock::processor_time;
use std::error::Error;
use std::path::Path;

type Answer<T> = Result<T, Box<dyn Error + Send + Sync>>;

const SEEDS: u64 = 64;

/// Seeds of which an error is estimated, as pbrt-v3's is from 8 to 32 runs: where few pixels of few images have most of the error, more of them
/// find more. In `areatri_onesided` a corner of the lamp reaches into a pixel that one image in 64 shows, and has nine tenths of its group's error.
const GROUP: usize = 16;

/// Below this part of an image's mean luminance darkness does not count any more, as in pbrt-v3's figures.
const FLOOR: f64 = 0.01;

/// Of each scene; and of all, the geometric mean.
const GOALS: [f64; 2] = [4.0, 8.0];

/// Processor seconds that fstop's first edition took for `scenes/cornell` with one thread where pbrt-v3 was timed. A machine on which it takes longer is
/// slower by that. Which commit that was is not recorded: 1d204d67, the last before, is taken for it; nor that the census was timed on the same machine.
const CORNELL: f64 = 4.36;

const HEAD: &str = "# Efficiency of `bdpt`: measured

Written by `cargo run --release --features studies --example census_efficiency`, not by hand. [Light paths](../notes/light-paths.md#measured) says where the
error and the time are.

Seconds of processor time × mean squared relative error of an image: pbrt-v3's over fstop's, in the scenes of the census with `Integrator \"bdpt\"`
(40 × 40 pixels, 64 to 256 samples each). pbrt-v3's figures are those of `tests/scenes/census/pbrt.txt`. fstop's time is the least
of the seeds' (others use the machine, too; seeds alone differ by a few per cent), one thread, scene parsing and pilot pass included. The error is the mean over pixels of the variance of the luminance between seeds, over
the squares of the mean and of a hundredth of the image's mean, as pbrt-v3's between its 8 to 32 runs: of 16 seeds, and the median of all groups of so many; with one
group, as pbrt-v3 has it, chance decides where few pixels of few images have most of the error. Beside the factor are those by the groups of most and of least error.

";

/// What the arguments ask for.
struct Wanted {
    seeds: u64,
    sobol: bool,
    /// Of the first edition here, if they are known.
    cornell: Option<f64>,
    names: Vec<String>,
}

impl Wanted {
    /// What seconds of this machine are multiplied by.
    fn speed(&self) -> f64 {
        self.cornell.map_or(1.0, |seconds| CORNELL / seconds)
    }

    /// What the page says of it.
    fn head(&self) -> String {
        let speed = self.cornell.map_or_else(String::new, |seconds| {
            format!(
                "The machine takes {seconds:.2} s for the Cornell box with fstop's first edition, where that of pbrt-v3's figures took {CORNELL} s: \
                 its seconds are multiplied by {:.2}.\n\n",
                self.speed()
            )
        });
        format!("{HEAD}{speed}{} seeds for each scene.\n\n", self.seeds)
    }
}

/// The cost of an image of pbrt-v3: processor time in seconds, and mean squared relative error.
struct Cost {
    seconds: f64,
    error: f64,
}

/// The same of an image of fstop.
struct Measured {
    seconds: f64,
    /// By groups of seeds.
    errors: Vec<f64>,
}

impl Measured {
    /// The median.
    fn error(&self) -> f64 {
        let mut errors = self.errors.clone();
        errors.sort_by(f64::total_cmp);
        let middle = errors.len() / 2;
        match errors.len() % 2 {
            0 => 0.5 * (errors[middle - 1] + errors[middle]),
            _ => errors[middle],
        }
    }

    /// How many times as much theirs costs, if an image of ours has this error.
    fn factor(&self, theirs: &Cost, error: f64) -> f64 {
        theirs.seconds * theirs.error / (self.seconds * error)
    }

    /// A cell of the table, and its number.
    fn cell(&self, theirs: &Cost) -> (String, f64) {
        let factor = self.factor(theirs, self.error());
        let bounds = [f64::max, f64::min]
            .map(|pick| self.errors.iter().copied().reduce(pick).unwrap_or(f64::NAN))
            .map(|error| self.factor(theirs, error));
        let [least, most] = bounds;
        (format!("{factor:.1} ({least:.1} – {most:.1})"), factor)
    }
}

fn main() -> Answer<()> {
    let wanted = wanted()?;
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let page = one.install(|| measure_all(&wanted))?;
    if wanted.names.is_empty() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        std::fs::write(root.join("docs/generated/efficiency.md"), page)?;
    }
    Ok(())
}

fn wanted() -> Answer<Wanted> {
    let mut wanted = Wanted {
        seeds: SEEDS,
        sobol: false,
        cornell: None,
        names: vec![],
    };
    for argument in std::env::args().skip(1) {
        match argument.parse() {
            Ok(seeds) => wanted.seeds = u64::max(seeds, 2),
            Err(_) if argument == "sobol" => wanted.sobol = true,
            Err(_) => match argument.strip_prefix("cornell=") {
                Some(seconds) => {
                    let seconds: f64 = seconds.parse()?;
                    if !(seconds > 0.0 && seconds.is_finite()) {
                        return Err(format!("{argument}: seconds are above 0").into());
                    }
                    wanted.cornell = Some(seconds);
                }
                None => wanted.names.push(argument),
            },
        }
    }
    Ok(wanted)
}

/// Measures the scenes that are wanted and returns the page.
fn measure_all(wanted: &Wanted) -> Answer<String> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/scenes/census");
    let samplers: &[&str] = match wanted.sobol {
        true => &["random", "sobol"],
        false => &["random"],
    };
    let mut page = wanted.head();
    let mut say = |line: String| {
        println!("{line}");
        page += &line;
        page += "\n";
    };
    let factors: String = { samplers.iter() }
        .map(|sampler| format!(" factor, `{sampler}` |"))
        .collect();
    say(format!("| scene | seconds | error |{factors}"));
    say("|---|---:|---:|".to_string() + &"---:|".repeat(samplers.len()));
    let mut factors = vec![vec![]; samplers.len()];
    for line in std::fs::read_to_string(folder.join("pbrt.txt"))?.lines() {
        let Some((name, theirs)) = of_line(line)? else {
            continue;
        };
        if !wanted.names.is_empty() && !wanted.names.iter().any(|part| name.contains(part)) {
            continue;
        }
        let mut row = format!("| {name} |");
        for (i, sampler) in samplers.iter().enumerate() {
            let mut ours = measure(&folder, name, wanted.seeds, *sampler == "sobol")?;
            ours.seconds *= wanted.speed();
            if i == 0 {
                row += &format!(" {:.3} | {:.3e} |", ours.seconds, ours.error());
            }
            let (cell, factor) = ours.cell(&theirs);
            factors[i].push(factor);
            row += &format!(" {cell} |");
        }
        say(row);
    }
    for (sampler, factors) in samplers.iter().zip(&factors) {
        say(format!("\n{}", summary(sampler, factors)));
    }
    Ok(page)
}

/// A scene and pbrt-v3's cost.
fn of_line(line: &str) -> Answer<Option<(&str, Cost)>> {
    let fields: Vec<&str> = line.split_whitespace().collect();
    Ok(match fields[..] {
        [name, seconds, error] if name != "#" => Some((
            name,
            Cost {
                seconds: seconds.parse()?,
                error: error.parse()?,
            },
        )),
        _ => None,
    })
}

fn summary(sampler: &str, factors: &[f64]) -> String {
    let count = factors.len();
    let mean = (factors.iter().map(|f| f.ln()).sum::<f64>() / count as f64).exp();
    let least = factors.iter().copied().fold(f64::INFINITY, f64::min);
    let reached = factors.iter().filter(|&&f| f >= GOALS[0]).count();
    format!(
        "`{sampler}`: geometric mean {mean:.2} (goal {}), least {least:.2} (goal {}), {reached} of {count} scenes reach {}.",
        GOALS[1], GOALS[0], GOALS[0]
    )
}

/// Renders a scene with every seed.
fn measure(folder: &Path, name: &str, seeds: u64, sobol: bool) -> Answer<Measured> {
    let path = folder.join(name).with_extension("pbrt");
    let mut seconds = f64::INFINITY;
    let mut images = vec![];
    for seed in 1..=seeds {
        let started = processor_time();
        images.push(image(&path, seed, sobol)?);
        seconds = seconds.min((processor_time() - started).as_secs_f64());
    }
    let group = GROUP.min(images.len());
    let errors = images.chunks_exact(group).map(error).collect();
    Ok(Measured { seconds, errors })
}

fn image(path: &Path, seed: u64, sobol: bool) -> Answer<Image> {
    let sources = SourceMap::new();
    let file = sources.open(path)?;
    let (scene, _) = read_scene(&sources, file, &ReadSettings::default());
    let mut frame = scene.frames.into_iter().next().ok_or("no frame")?;
    let sampler = &mut frame.options.sampler;
    if sobol {
        *sampler = SamplerSpec::sobol(sampler.spp);
    }
    let built = build(frame, seed).0.ok_or("the scene cannot be built")?;
    Ok(render(&built.job, TILE_SIZE, false, &Progress::hidden()).image())
}

/// The expected mean squared relative error of one of the images.
fn error(images: &[Image]) -> f64 {
    let count = images.len() as f64;
    let moments: Vec<[f64; 2]> = { 0..images[0].pixels.len() }
        .map(|i| {
            let values = images
                .iter()
                .map(|image| f64::from(luminance(image.pixels[i])));
            let mean = values.clone().sum::<f64>() / count;
            let squares = values.map(|value| (value - mean).powi(2));
            [mean, squares.sum::<f64>() / (count - 1.0)]
        })
        .collect();
    let pixels = moments.len() as f64;
    let dark = FLOOR * moments.iter().map(|[mean, _]| mean).sum::<f64>() / pixels;
    let errors = moments
        .iter()
        .map(|[mean, variance]| variance / (mean.powi(2) + dark.powi(2)));
    errors.sum::<f64>() / pixels
}
