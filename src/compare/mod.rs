//! Statistical comparison: do two renders show the same image?
//!
//! Renders are random, so their difference is meaningless unless it is compared with their noise. If both files contain
//! the variance of each pixel, [`compare`] applies Welch's t-test (Jung, Hanika, Dachsbacher, "Detecting Bias in Monte
//! Carlo Renderers using Welch's t-test", JCGT 9(2), 2020) to pixels, to blocks of pixels and to the whole image, and
//! corrects for the number of tests. If one has none, the scatter of the difference itself is used (`scatter.rs` states
//! the assumptions). It also reports error metrics ([`Metrics`]) and the difference as seen by a viewer ([`flip`]).
//! `docs/compare.md` explains all of it to users.

mod correction;
mod estimate;
pub mod flip;
mod metrics;
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
pub use estimate::{CompareError, Estimate};
pub use metrics::{ChannelMeans, Metrics, TileDifference};
pub use non_finite::NonFinite;
pub use options::{Noise, NoiseSource, Options};
pub use scatter::Neighbors;
pub use student::two_sided_p;
pub use text::{CHANNELS, blocks, extent, probability};
pub use uniformity::{BINS, Uniformity};
pub use verdict::{Finding, Level, Statistic, Verdict};

use crate::film::{Image, PixelBounds};
use crate::math::Rgb;
use rayon::prelude::*;
use scatter::{MeanScatter, NeighborScatter, Scatter};
use std::fmt;
use verdict::{BlockTest, test_level};
use welch::WelchTest;

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
    /// Values that are infinite or NaN.
    pub non_finite: NonFinite,
    /// Whether the p-values are uniformly distributed, for each block size with enough blocks.
    pub uniformity: Vec<Uniformity>,
    /// Whether pixels are independent of their neighbors, which the tests of blocks assume.
    pub neighbors: Neighbors,
    /// Error metrics.
    pub metrics: Metrics,
}

impl Comparison {
    /// Returns `true` if nothing indicates that the images differ: no test, and no value that is finite in one image
    /// only.
    pub fn agrees(&self) -> bool {
        self.verdict.agrees() && self.non_finite.unmatched == 0
    }
}

/// Compares `a` with the reference `b`, which must cover the same pixels.
///
/// ```
/// use fstop::compare::{Estimate, Options, compare};
/// use fstop::film::Image;
/// use fstop::math::{Rgb, UVec2};
///
/// let mut a = Image::black(UVec2::new(16, 16));
/// a.variance = Some(vec![Rgb::splat(1e-4); 256]);
/// let mut b = a.clone();
/// b.pixels[37].y = 1.0; // seventy standard deviations
/// let [a, b] = [&a, &b].map(|image| Estimate { image, freedom: 63.0, samples: Some(64.0) });
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
        uniformity: pair.uniformity(),
        neighbors: Neighbors::new(&pair.a, &pair.b, pair.noise == NoiseSource::Stored),
        metrics: Metrics::new(&pair.a, &pair.b, pair.noise, non_finite.left_out),
        non_finite,
    })
}

/// The p-value of every pixel and channel, for an image of where two images differ. If the noise is estimated from the
/// scatter of the difference, a pixel has no p-value of its own and shows that of its block (the smallest of
/// [`Options::blocks`] that is tested).
///
/// # Errors
/// As [`compare`].
pub fn p_values(a: &Estimate, b: &Estimate, options: &Options) -> Result<Image, CompareError> {
    of_pair(a, b, options, |pair, _| pair.p_values())
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
            a: self.a,
            b: self.b,
            tolerance: self.options.relative_tolerance,
            common: known.filter(|_| common),
            noiseless: self.noise == NoiseSource::None,
        }
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

    fn verdict(&self) -> Verdict {
        let Options {
            alpha, correction, ..
        } = *self.options;
        let sides: Vec<Option<u32>> = self.sides().into_iter().map(Some).chain([None]).collect();
        let questions = if self.noise.is_spatial() { 2 } else { 1 };
        let share = correction.share(alpha, questions * sides.len());
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
        self.sides().into_iter().filter_map(of).collect()
    }

    fn p_values(&self) -> Image {
        let bounds = self.bounds();
        let mut image = Image {
            pixels: vec![Rgb::ONE; bounds.area()],
            variance: None,
            ..self.a.image.clone()
        };
        let side = if self.noise.is_spatial() {
            self.sides().into_iter().min()
        } else {
            Some(1)
        };
        let Some(side) = side else { return image };
        let blocks: Vec<PixelBounds> = bounds.tiles(side).collect();
        let values = blocks.par_iter().map(|&block| {
            let candidates = if self.noise.is_spatial() {
                MeanScatter(self.scatter()).ask(block)
            } else {
                self.welch(self.options.common_variance).ask(block)
            };
            Rgb::from(candidates.map(|candidate| candidate.p() as f32))
        });
        for (block, p) in blocks.iter().zip(values.collect::<Vec<_>>()) {
            for index in block.pixels().filter_map(|pixel| bounds.index(pixel)) {
                if let Some(pixel) = image.pixels.get_mut(index) {
                    *pixel = p;
                }
            }
        }
        image
    }
}
