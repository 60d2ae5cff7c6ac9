//! Rendering with the built binary and judging the image, for the tests against references.

use fstop::compare::{Comparison, Estimate, Options, Pool, Verdict, p_values};
use fstop::film::{FilmMetadata, Image, LoadedImage, read, write};
use fstop::math::Rgb;
use fstop::math::color::luminance;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Several renders of one scene with different seeds, averaged.
pub(crate) struct Render {
    /// The mean, with its variance.
    pub image: Image,
    /// Samples per pixel of one run.
    pub spp: f64,
    /// Samples per pixel of all runs together.
    pub samples: f64,
    /// Degrees of freedom of the variance, which every run estimates from its own samples.
    pub freedom: f64,
    /// How the variances of neighbors depend on each other.
    pub pool: Option<Pool>,
}

impl Render {
    /// Renders `scene` `runs` times with `fstop render`, seeds from `first_seed` on, and `arguments`
    /// besides.
    ///
    /// Averaging runs, rather than asking for more samples once, keeps what depends on the number of
    /// samples per pixel as the reference has it: the width of texture filters, the cut at 0.
    pub(crate) fn new(scene: &Path, first_seed: u32, runs: u32, arguments: &[&str]) -> Render {
        Render::until(scene, first_seed, [runs; 2], arguments, |_| true)
    }

    /// Renders `scene` with seeds from 1 on at most so many times, but no more often than it takes to be as good as the reference:
    /// its own noise stays, and more samples of ours would find little more.
    pub(crate) fn as_good_as(reference: &Image, scene: &Path, runs: u32) -> Render {
        // In thirds, and by the sum over all pixels, so that stopping hardly depends on what chance made of the image.
        let enough = |ours: &Image| noise(ours) <= noise(reference);
        Render::until(scene, 1, [runs.div_ceil(3), runs], &[], enough)
    }

    /// Renders `least` times, and again as often until the mean is good `enough`, but no more than `most` times.
    fn until(
        scene: &Path,
        first_seed: u32,
        [least, most]: [u32; 2],
        arguments: &[&str],
        enough: impl Fn(&Image) -> bool,
    ) -> Render {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let mut renders: Vec<LoadedImage> = vec![];
        let image = loop {
            let done = renders.len() as u32;
            for seed in first_seed + done..first_seed + (done + least).min(most) {
                let output = folder.path().join(format!("{seed}.exr"));
                render(scene, &output, seed, arguments);
                renders.push(read(&output).unwrap_or_else(|error| panic!("{error}")));
            }
            let images: Vec<&Image> = renders.iter().map(|loaded| &loaded.image).collect();
            let mean = average(&images);
            if renders.len() as u32 >= most || enough(&mean) {
                break mean;
            }
        };
        let spp = f64::from(renders[0].spp.expect("fstop writes the number of samples"));
        let runs = renders.len() as f64;
        Render {
            image,
            spp,
            samples: spp * runs,
            freedom: renders[0].freedom.unwrap_or(spp - 1.0) * runs,
            pool: renders[0].pool.map(|side| Pool {
                side,
                freedom: runs,
            }),
        }
    }

    /// Renders the scene that `text` is once, with `seed`.
    pub(crate) fn of_text(text: &str, seed: u32) -> Render {
        let mut file = tempfile::Builder::new()
            .suffix(".pbrt")
            .tempfile()
            .expect("a temporary file");
        file.write_all(text.as_bytes()).expect("room for a scene");
        Render::new(file.path(), seed, 1, &[])
    }

    /// For the comparison.
    pub(crate) fn estimate(&self) -> Estimate<'_> {
        Estimate {
            image: &self.image,
            freedom: self.freedom,
            pool: self.pool,
            samples: Some(self.samples),
            light_paths: None,
        }
    }
}

/// One call of the binary. One thread: the test harness runs as many tests at once as there are cores.
fn render(scene: &Path, output: &Path, seed: u32, arguments: &[&str]) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_fstop"));
    command.arg("render").arg(scene).arg("-o").arg(output);
    command.args([
        "--variance",
        "--quiet",
        "--threads",
        "1",
        "--seed",
        &seed.to_string(),
    ]);
    command.args(arguments);
    let result = command
        .output()
        .unwrap_or_else(|error| panic!("{command:?}: {error}"));
    let said = String::from_utf8_lossy(&result.stderr);
    assert!(
        result.status.success(),
        "{command:?} ended with {}:\n{said}",
        result.status
    );
}

/// The mean of independent images of equal sample counts, and its variance.
fn average(images: &[&Image]) -> Image {
    let count = images.len() as f32;
    let sum = |of: &dyn Fn(&Image) -> Rgb| images.iter().map(|image| of(image)).sum::<Rgb>();
    let indices = 0..images[0].pixels.len();
    let pixels = indices
        .clone()
        .map(|i| sum(&|image| image.pixels[i]) / count)
        .collect();
    let of_mean = |of: fn(&Image) -> Option<&Vec<Rgb>>| -> Option<Vec<Rgb>> {
        of(images[0])?;
        let at = |image: &Image, i: usize| of(image).expect("as in the first")[i];
        let sums = indices.clone().map(|i| sum(&|image| at(image, i)));
        Some(sums.map(|sum| sum / (count * count)).collect())
    };
    Image {
        pixels,
        variance: of_mean(|image| image.variance.as_ref()),
        independent: of_mean(|image| image.independent.as_ref()),
        ..images[0].clone()
    }
}

/// The sum of the variances of pixels.
fn noise(image: &Image) -> f64 {
    let variance = image.variance.as_ref().expect("both have variances");
    variance.iter().map(|&v| f64::from(luminance(v))).sum()
}

/// What a person needs to see why a comparison failed: the tests' table, and where the images are
/// that this writes under the target folder.
pub(crate) fn explain(
    name: &str,
    a: &Estimate,
    b: &Estimate,
    options: &Options,
    comparison: &Comparison,
) -> String {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR"))
        .join("differences")
        .join(name);
    let images = match write_images(&folder, a, b, options) {
        Ok(()) => format!("images in {}", folder.display()),
        Err(error) => format!("no images: {error}"),
    };
    let metrics = &comparison.metrics;
    let mut text = format!("{name}\n");
    for (channel, means) in ["red", "green", "blue"].iter().zip(&metrics.channels) {
        let error = means.ratio_error.unwrap_or(f64::NAN);
        text += &format!(
            "  mean {channel}: {:.6} / {:.6} = {:.5} ± {error:.5}\n",
            means.a, means.b, means.ratio
        );
    }
    let expected = metrics.expected_mse.unwrap_or(f64::NAN);
    text += &format!(
        "  mean squared error {:.3e}, from noise alone {expected:.3e}\n",
        metrics.mse
    );
    text += &table(&comparison.verdict);
    text + &format!("  {images}\n")
}

fn table(verdict: &Verdict) -> String {
    let rows = verdict.levels.iter().map(|level| {
        let worst = &level.worst;
        let side = level.side.map_or("all".into(), |side| side.to_string());
        format!(
            "  blocks of {side:>3}: p {:.2e} of {} tests; worst at {} channel {}: {:.6} against {:.6}, t {:.2} with {:.0} degrees of freedom\n",
            level.p, level.tests, worst.bounds.min, worst.channel, worst.a, worst.b, worst.t, worst.freedom
        )
    });
    rows.collect::<String>()
        + &format!(
            "  altogether p {:.2e} where {:.0e} is asked\n",
            verdict.p(),
            verdict.alpha
        )
}

/// The image, the reference, their difference (red channel positive: too bright) and −log₁₀ p.
fn write_images(
    folder: &Path,
    a: &Estimate,
    b: &Estimate,
    options: &Options,
) -> Result<(), Box<dyn std::error::Error>> {
    std::fs::create_dir_all(folder)?;
    let metadata = FilmMetadata::default();
    let difference = a
        .image
        .pixels
        .iter()
        .zip(&b.image.pixels)
        .map(|(p, q)| *p - *q)
        .collect();
    let difference = Image {
        pixels: difference,
        variance: None,
        independent: None,
        ..a.image.clone()
    };
    for (name, image) in [
        ("picture", a.image),
        ("reference", b.image),
        ("difference", &difference),
    ] {
        write(&folder.join(format!("{name}.exr")), image, &metadata)?;
        write(&folder.join(format!("{name}.png")), image, &metadata)?;
    }
    let mut p = p_values(a, b, options)?;
    p.pixels
        .iter_mut()
        .for_each(|p| *p = p.map(|p| -p.max(1e-30).log10()));
    write(&folder.join("log-p.exr"), &p, &metadata)?;
    // p = 1e-10 is white.
    p.pixels.iter_mut().for_each(|p| *p *= 0.1);
    write(&folder.join("log-p.png"), &p, &metadata)?;
    Ok(())
}
