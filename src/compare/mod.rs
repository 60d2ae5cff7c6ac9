//! Statistical comparison of two renders.
//!
//! Renders are random, so their difference is meaningless unless it is compared with their noise. If both files contain
//! the variance of each pixel, [`compare`] applies Welch's t-test (Jung, Hanika, Dachsbacher, "Detecting Bias in Monte
//! Carlo Renderers using Welch's t-test", JCGT 9(2), 2020) to pixels, to blocks of pixels and to the whole image, and
//! corrects for the number of tests. If one has none, the scatter of the difference itself is used (`scatter.rs` states
//! the assumptions). It also reports error metrics ([`Metrics`]) and the difference as seen by a viewer ([`flip`]).
//! `docs/compare.md` explains all of it to users.

mod correction;
mod estimate;
mod findable;
pub mod flip;
mod metrics;
mod missed;
pub(crate) mod non_finite;
mod options;
mod scatter;
mod student;
mod text;
mod uniformity;
mod verdict;
mod welch;

#[cfg(test)]
mod tests;

pub use correction::Correction;
pub use estimate::{CompareError, Estimate, Pool};
pub use findable::{Findable, POWER};
pub use metrics::{ChannelMeans, Metrics, TileDifference};
pub use non_finite::NonFinite;
pub use options::{Noise, NoiseSource, Options};
pub use scatter::Neighbors;
pub use student::{two_sided_p, two_sided_t};
pub use text::{CHANNELS, blocks, extent, probability, rate, relative};
pub use uniformity::{BINS, Uniformity};
pub use verdict::{Finding, Level, Statistic, Verdict};

use crate::film::{Image, LightPathUse, PixelBounds};
use crate::math::Rgb;
use missed::Missed;
use rayon::prelude::*;
use scatter::{MeanScatter, NeighborScatter, Scatter};
use std::fmt;
use verdict::{BlockTest, Candidate, test_level};
use welch::{Known, WelchTest};

/// One of the two images.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// The image.
    A,
    /// The reference.
    B,
}

impl fmt::Display for Side {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{self:?}")
    }
}

/// The answer of [`compare`].
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// The result of the t-tests.
    pub verdict: Verdict,
    /// The noise estimate they used.
    pub noise: NoiseSource,
    /// How both images use light paths, where that differs: then one of them may lack light that the other knows well, and a
    /// darker block has more noise than its variance.
    pub light_paths: Option<[LightPathUse; 2]>,
    /// What would have been found: for each block size but single pixels, and for the whole image. Empty without noise.
    pub findable: Vec<Findable>,
    /// Values that are infinite or NaN.
    pub non_finite: NonFinite,
    /// How uniformly the p-values are distributed, for each block size with enough blocks.
    pub uniformity: Vec<Uniformity>,
    /// How far pixels depend on their neighbors; the tests of blocks assume that they do not.
    pub neighbors: Neighbors,
    /// Error metrics.
    pub metrics: Metrics,
}

impl Comparison {
    /// Returns `true` if nothing indicates that the images differ: no test, and no value that is finite in one image
    /// only. Whether anything could have been found is another question: see [`Comparison::answer`].
    pub fn agrees(&self) -> bool {
        self.verdict.agrees() && self.non_finite.unmatched == 0
    }

    /// The answer to whether the images agree.
    pub fn answer(&self) -> Answer {
        match self.agrees() {
            false => Answer::Differ,
            true if self.is_empty() || self.doubt().is_some() => Answer::CannotTell,
            true => Answer::Agree,
        }
    }

    /// Where noise is so strong, or known from so few bright samples, that a block of the largest size, or the whole image,
    /// could be black in one of the images and pass. Without variances of the whole image only: blocks that are nearly black
    /// in both would be all that is found.
    pub fn doubt(&self) -> Option<&Findable> {
        let side = match self.noise {
            NoiseSource::Stored => self.findable.iter().filter_map(|found| found.side).max(),
            _ => None,
        };
        let of_size = |found: &&Findable| found.side.is_none() || found.side == side;
        let all = self.findable.iter().filter(of_size);
        all.filter(|found| found.relative >= 1.0)
            .max_by(|x, y| x.relative.total_cmp(&y.relative))
    }

    /// Returns `true` if no pixel has finite values in both images, or too many have variances that none can be: what was compared says nothing.
    pub fn is_empty(&self) -> bool {
        let NonFinite {
            left_out,
            pixels,
            impossible_variances: [a, b],
            ..
        } = self.non_finite;
        left_out > 0 && left_out == pixels || 100 * a.max(b) > pixels
    }
}

/// The answer of a comparison.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Answer {
    /// No difference was found, and large ones would have been.
    Agree,
    /// There is one.
    Differ,
    /// None was found, but somewhere not even one as large as all the light would have been.
    CannotTell,
}

/// Compares `a` with the reference `b`, which must cover the same pixels.
///
/// ```
/// use fstop::compare::{Estimate, Options, compare};
/// use fstop::film::Image;
/// use fstop::glam::{UVec2, Vec3 as Rgb};
///
/// let mut a = Image::black(UVec2::new(16, 16));
/// a.variance = Some(vec![Rgb::splat(1e-4); 256]);
/// let mut b = a.clone();
/// b.pixels[37].y = 1.0; // seventy standard deviations
/// let [a, b] = [&a, &b].map(|image| Estimate { image, freedom: 63.0, pool: None, samples: Some(64.0), light_paths: None });
/// let comparison = compare(&a, &b, &Options::default())?;
/// assert!(!comparison.agrees());
/// println!("{}", comparison.sentence());
/// # Ok::<(), fstop::compare::CompareError>(())
/// ```
///
/// Fails if the images have different pixels, or none, or lack variances that were requested.
pub fn compare(a: &Estimate, b: &Estimate, options: &Options) -> Result<Comparison, CompareError> {
    of_pair(a, b, options, |pair, non_finite| Comparison {
        verdict: pair.verdict(),
        noise: pair.noise,
        light_paths: pair.missed().map(|missed| missed.light_paths),
        findable: pair.findable(),
        uniformity: pair.uniformity(),
        neighbors: Neighbors::new(&pair.a, &pair.b, pair.noise == NoiseSource::Stored),
        metrics: Metrics::new(
            &pair.a,
            &pair.b,
            pair.noise,
            options.cell,
            non_finite.left_out,
        ),
        non_finite,
    })
}

/// What a comparison of the two would find, whatever they show: their noise alone decides. For each block size but single
/// pixels, then for the whole image; empty without noise.
///
/// # Errors
/// As [`compare`].
pub fn findable(
    a: &Estimate,
    b: &Estimate,
    options: &Options,
) -> Result<Vec<Findable>, CompareError> {
    of_pair(a, b, options, |pair, _| pair.findable())
}

/// The p-value of every pixel and channel, for an image of where two images differ. If the noise is estimated from the
/// scatter of the difference, a pixel has no p-value of its own and shows that of its block (the smallest of
/// [`Options::blocks`] that is tested).
///
/// # Errors
/// As [`compare`].
pub fn p_values(a: &Estimate, b: &Estimate, options: &Options) -> Result<Image, CompareError> {
    of_pair(a, b, options, |pair, _| {
        pair.map(None, Rgb::ONE, Candidate::p)
    })
}

/// As [`p_values`], of the blocks with this side in pixels, each of whose pixels shows that of its block.
///
/// # Errors
/// As [`compare`].
pub fn block_p_values(
    a: &Estimate,
    b: &Estimate,
    options: &Options,
    side: u32,
) -> Result<Image, CompareError> {
    let side = Some(side.max(1));
    of_pair(a, b, options, |pair, _| {
        pair.map(side, Rgb::ONE, Candidate::p)
    })
}

/// The difference of every block over its standard error, channel by channel: positive where A is brighter, infinite where
/// there is a difference and no noise. Each pixel shows that of its block.
///
/// # Errors
/// As [`compare`].
pub fn block_t(
    a: &Estimate,
    b: &Estimate,
    options: &Options,
    side: u32,
) -> Result<Image, CompareError> {
    let side = Some(side.max(1));
    of_pair(a, b, options, |pair, _| {
        pair.map(side, Rgb::ZERO, Candidate::t)
    })
}

/// What `ask` says of both images without their non-finite values, if they can be compared.
fn of_pair<T>(
    a: &Estimate,
    b: &Estimate,
    options: &Options,
    ask: impl FnOnce(&Pair, NonFinite) -> T,
) -> Result<T, CompareError> {
    estimate::check_pair(a, b)?;
    let noise = NoiseSource::of(a, b, options)?;
    let (clean_a, clean_b, non_finite) = non_finite::clean(a.image, b.image);
    let image_a = clean_a.as_ref().unwrap_or(a.image);
    let image_b = clean_b.as_ref().unwrap_or(b.image);
    let pair = Pair {
        a: Estimate {
            image: image_a,
            ..*a
        },
        b: Estimate {
            image: image_b,
            ..*b
        },
        noise,
        options,
    };
    Ok(ask(&pair, non_finite))
}

/// Two images of the same size with all values finite.
struct Pair<'a> {
    a: Estimate<'a>,
    b: Estimate<'a>,
    noise: NoiseSource,
    options: &'a Options,
}

/// Minimum observations in a block to test its scatter: with fewer, signs alone ([`scatter`]) could never be
/// significant among the other blocks.
const MIN_OBSERVATIONS: u32 = 16;

impl<'a> Pair<'a> {
    fn bounds(&self) -> PixelBounds {
        self.a.image.bounds
    }

    fn welch(&self, common: bool) -> WelchTest<'a> {
        let known = self.a.samples.zip(self.b.samples);
        WelchTest {
            a: Known::new(self.a),
            b: Known::new(self.b),
            tolerance: self.options.relative_tolerance,
            common: known.filter(|_| common),
            missed: self.missed().filter(|_| common),
            noiseless: self.noise == NoiseSource::None,
        }
    }

    fn missed(&self) -> Option<Missed> {
        let is_stored = self.noise == NoiseSource::Stored && self.options.common_variance;
        is_stored.then(|| Missed::of(&self.a, &self.b)).flatten()
    }

    fn scatter(&self) -> Scatter<'a> {
        Scatter {
            a: self.a,
            b: self.b,
            tolerance: self.options.relative_tolerance,
            cell: self.options.cell.max(1),
        }
    }

    /// The block sizes that can be tested.
    fn sides(&self) -> Vec<u32> {
        let cell = self.options.cell.max(1);
        let observations = |side: u32| side.div_ceil(cell).saturating_pow(2);
        let testable =
            |side: u32| !self.noise.is_spatial() || observations(side) >= MIN_OBSERVATIONS;
        let sides = self.options.blocks.iter().copied();
        sides.filter(|&side| side > 0 && testable(side)).collect()
    }

    /// The blocks' sides, `None` for the whole image, and the false-alarm rate of each question about blocks of one side.
    fn levels(&self) -> (Vec<Option<u32>>, f64) {
        let Options {
            alpha, correction, ..
        } = *self.options;
        let sides: Vec<Option<u32>> = self.sides().into_iter().map(Some).chain([None]).collect();
        let questions = if self.noise.is_spatial() { 2 } else { 1 };
        let share = correction.share(alpha, questions * sides.len());
        (sides, share)
    }

    fn verdict(&self) -> Verdict {
        let Options {
            alpha, correction, ..
        } = *self.options;
        let (sides, share) = self.levels();
        let ask = |side| -> Vec<Level> {
            if self.noise.is_spatial() {
                let mean = self.level(&MeanScatter(self.scatter()), side, share);
                let neighbors = self.level(&NeighborScatter(self.scatter()), side, share);
                mean.into_iter().chain(neighbors).collect()
            } else {
                let test = self.welch(self.options.common_variance);
                self.level(&test, side, share).into_iter().collect()
            }
        };
        Verdict {
            alpha,
            correction,
            levels: sides.into_iter().flat_map(ask).collect(),
        }
    }

    fn findable(&self) -> Vec<Findable> {
        if self.noise == NoiseSource::None {
            return Vec::new();
        }
        let correction = self.options.correction;
        let (sides, share) = self.levels();
        let bounds = self.bounds();
        let pixels = self.b.image.pixels.iter();
        let light: f64 = pixels.map(|p| p.as_dvec3().element_sum()).sum();
        let mean = light / (3.0 * bounds.area().max(1) as f64);
        let worst = |side: Option<u32>| {
            let blocks = bounds.tiles(side.unwrap_or(u32::MAX)).count();
            let alpha = correction.share(share, 3 * blocks);
            match self.noise.is_spatial() {
                true => Findable::worst(&MeanScatter(self.scatter()), bounds, side, alpha, mean),
                false => {
                    let test = self.welch(self.options.common_variance);
                    Findable::worst(&test, bounds, side, alpha, mean)
                }
            }
        };
        let large = sides.into_iter().filter(|&side| side != Some(1));
        large.filter_map(worst).collect()
    }

    fn level<T: BlockTest>(&self, test: &T, side: Option<u32>, share: f64) -> Option<Level> {
        test_level(test, self.bounds(), side, share, self.options.correction)
    }

    /// By plain Welch's test, whose p-values would be uniform; those of the common variance are too large.
    fn uniformity(&self) -> Vec<Uniformity> {
        let of = |side| match self.noise {
            NoiseSource::None => None,
            NoiseSource::Stored => {
                let test = WelchTest {
                    tolerance: 0.0,
                    ..self.welch(false)
                };
                Uniformity::of(&test, self.bounds(), side)
            }
            _ => Uniformity::of(&MeanScatter(self.scatter()), self.bounds(), side),
        };
        // The variances of what is smaller than a square are known to be too large.
        let pool = |estimate: &Estimate| match (&estimate.image.independent, estimate.pool) {
            (Some(_), Some(pool)) => pool.side,
            _ => 0,
        };
        let least = pool(&self.a).max(pool(&self.b));
        let sides = self.sides().into_iter().filter(|side| *side >= least);
        sides.filter_map(of).collect()
    }

    /// What the tests of the means of blocks say, in every pixel of each; `none` if there are no blocks to test.
    fn map(&self, side: Option<u32>, none: Rgb, say: fn(&Candidate) -> f64) -> Image {
        let bounds = self.bounds();
        let mut image = Image {
            pixels: vec![none; bounds.area()],
            variance: None,
            independent: None,
            ..self.a.image.clone()
        };
        let smallest = || match self.noise.is_spatial() {
            true => self.sides().into_iter().min(),
            false => Some(1),
        };
        let side = side.or_else(smallest);
        let Some(side) = side else { return image };
        let blocks: Vec<PixelBounds> = bounds.tiles(side).collect();
        let values = match self.noise.is_spatial() {
            true => values(&MeanScatter(self.scatter()), &blocks, say),
            false => values(&self.welch(self.options.common_variance), &blocks, say),
        };
        for (block, value) in blocks.iter().zip(values) {
            for index in block.pixels().filter_map(|pixel| bounds.index(pixel)) {
                if let Some(pixel) = image.pixels.get_mut(index) {
                    *pixel = value;
                }
            }
        }
        image
    }
}

/// What a test says of each block, by channel.
fn values(test: &impl BlockTest, blocks: &[PixelBounds], say: fn(&Candidate) -> f64) -> Vec<Rgb> {
    let values = blocks.par_iter().map(|&block| {
        let candidates = test.ask(block);
        Rgb::from(candidates.map(|candidate| say(&candidate) as f32))
    });
    values.collect()
}
