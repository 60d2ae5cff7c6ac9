//! Sample streams: the random or low-discrepancy samples in [0, 1) for film points, lens points, light points and
//! scattered directions.
//!
//! Every sample is a pure function of (seed, pixel, sample index, dimension), so nothing
//! depends on threads, tiles or what was rendered before. Pixels are decorrelated by hashing.
//! A camera sample uses its dimensions in this order: film (2-D), time (1-D), lens (2-D, where the camera has
//! one), then those of the integrator.
//!
//! Samplers change the noise of an image, never what it converges to (docs/scene-language.md §3.4), so
//! three kinds of points serve all the scene language's types: stratified ones, random ones, and
//! Owen-scrambled ones for everything of low discrepancy (`sobol`). `docs/samplers.md` compares them.

mod adaptive;
mod best_candidate;
pub(crate) mod choice;
mod count;
mod halton;
mod low_discrepancy;
mod max_min_dist;
mod net;
mod permutation;
mod random;
mod side_by_side;
mod sobol;
mod stratified;

pub use choice::ChoiceSample;
pub use side_by_side::Pairs;
pub use stratified::Stratified;

use crate::math::hash::{mix, mix2};
use crate::math::{IVec2, Vec2};
use crate::params::ParamReader;
use random::RandomStream;
use sobol::SobolStream;
use std::num::NonZeroU32;
use stratified::StratifiedStream;

type Read = fn(&ParamReader) -> SamplerSpec;

/// The types of samplers and what reads each. A new type: its file and a line here.
const TYPES: [(&str, Read); 9] = [
    ("02sequence", low_discrepancy::from_params),
    ("adaptive", adaptive::from_params),
    ("bestcandidate", best_candidate::from_params),
    ("halton", halton::from_params),
    ("lowdiscrepancy", low_discrepancy::from_params),
    ("maxmindist", max_min_dist::from_params),
    ("random", random::from_params),
    ("sobol", sobol::from_params),
    ("stratified", stratified::from_params),
];

/// The type names a scene may give, for "did you mean".
pub fn sampler_names() -> Vec<&'static str> {
    TYPES.iter().map(|(name, _)| *name).collect()
}

/// How the samples of one pixel are distributed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Points {
    /// One point in each cell of a grid.
    Stratified(Stratified),
    /// Independent points.
    Random,
    /// Owen-scrambled low-discrepancy points like Sobol's, in four dimensions at a time.
    Sobol,
}

/// A scene's `Sampler`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SamplerSpec {
    /// How they are distributed.
    pub points: Points,
    /// Samples in every pixel, at least 1.
    pub spp: u32,
    /// Film points lie only at pixel centers (halton's `samplepixelcenter`): the filter must then
    /// be [`crate::filters::Filter::at_pixel_centers`].
    pub pixel_centers: bool,
    /// How the samples differ from those of the type that the scene names.
    pub note: Option<&'static str>,
}

impl SamplerSpec {
    /// Reads a `Sampler`. An unknown type is an error, and replaced by the default one.
    pub fn from_params(reader: &ParamReader) -> SamplerSpec {
        let Some((_, read)) = TYPES.iter().find(|(name, _)| *name == reader.kind()) else {
            reader.unknown_kind(&sampler_names());
            return SamplerSpec::sobol(reader.default_of("pixelsamples", 16.0) as u32);
        };
        read(reader)
    }

    /// Owen-scrambled points, `spp` in every pixel.
    pub fn sobol(spp: u32) -> SamplerSpec {
        SamplerSpec::new(Points::Sobol, spp)
    }

    /// Random points, `spp` in every pixel.
    pub fn random(spp: u32) -> SamplerSpec {
        SamplerSpec::new(Points::Random, spp)
    }

    fn new(points: Points, spp: u32) -> SamplerSpec {
        SamplerSpec {
            points,
            spp: spp.max(1),
            pixel_centers: false,
            note: None,
        }
    }

    /// The same kind of points with exactly `spp` (at least 1) in every pixel.
    pub fn with_spp(self, spp: u32) -> SamplerSpec {
        let spp = spp.max(1);
        let points = match self.points {
            Points::Stratified(grid) => Points::Stratified(grid.with_samples(spp)),
            other => other,
        };
        SamplerSpec {
            points,
            spp,
            ..self
        }
    }

    /// For a quick look: one sample in every pixel, except for `random`, as in pbrt-v3.
    pub fn quick(self) -> SamplerSpec {
        if self.points == Points::Random {
            self
        } else {
            self.with_spp(1)
        }
    }
}

/// A sampler, which makes the streams.
#[derive(Clone, Debug)]
pub struct Sampler {
    points: Points,
    spp: u32,
    /// The number of samples is not known in advance: there may be more than `spp`, or fewer.
    is_progressive: bool,
    seed: u64,
}

impl Sampler {
    /// From the scene's; another `seed` gives another, independent image.
    pub fn new(spec: &SamplerSpec, seed: u64) -> Sampler {
        Sampler {
            points: spec.points,
            spp: spec.spp.max(1),
            is_progressive: false,
            seed: mix(seed),
        }
    }

    /// Samples in every pixel.
    pub fn spp(&self) -> u32 {
        self.spp
    }

    /// One of two samplers of the same kind that are independent of each other and of this one, for any number of samples.
    pub fn half(&self, which: usize) -> Sampler {
        Sampler {
            seed: mix2(self.seed, 1 + which as u64),
            is_progressive: true,
            ..*self
        }
    }

    /// One of the same kind for a pilot pass, independent of this one and of its halves: the same whatever the seed is. Weights of multiple importance sampling
    /// depend on what a pilot pass finds. Were they others for each seed, two images would differ by more than their variances tell, where paths that have a small
    /// part of the light are so rare that none comes to a pixel: by what the weights leave to them.
    pub fn pilot(&self) -> Sampler {
        Sampler {
            seed: PILOT,
            is_progressive: true,
            ..*self
        }
    }

    /// One of two such samplers that have this one's samples between them, each well distributed by itself. The first has
    /// the odd one.
    pub fn half_of_samples(&self, which: usize) -> Sampler {
        let spp = (self.spp + 1 - which as u32) / 2;
        let points = match self.points {
            Points::Stratified(grid) => Points::Stratified(grid.with_samples(spp.max(1))),
            other => other,
        };
        Sampler {
            points,
            spp,
            is_progressive: false,
            ..self.half(which)
        }
    }

    /// Returns `true` if the samples of a pixel depend on each other.
    pub fn is_dependent(&self) -> bool {
        self.points != Points::Random
    }

    /// Returns `true` if the variance is to be found from two halves: the samples depend on each other, and are enough.
    pub fn is_halved(&self) -> bool {
        self.is_dependent() && self.spp >= MIN_HALVED
    }

    /// The number of samples, if points are to be distributed for it: a power of two needs no more than the sequence.
    fn fixed_count(&self) -> Option<NonZeroU32> {
        match self.is_progressive || self.spp.is_power_of_two() {
            true => None,
            false => NonZeroU32::new(self.spp),
        }
    }

    /// The streams of a pixel's samples.
    pub fn of_pixel(&self, pixel: IVec2) -> PixelSampler {
        let packed = u64::from(pixel.x as u32) | u64::from(pixel.y as u32) << 32;
        PixelSampler {
            points: self.points,
            seed: mix2(self.seed, packed),
            fixed_count: self.fixed_count(),
        }
    }

    /// The stream of one camera sample: see [`PixelSampler::stream`].
    pub fn stream(&self, pixel: IVec2, index: u32) -> SampleStream {
        self.of_pixel(pixel).stream(index)
    }
}

/// A sampler at one pixel.
#[derive(Clone, Copy, Debug)]
pub struct PixelSampler {
    points: Points,
    /// The sampler's, and the pixel.
    seed: u64,
    /// See [`Sampler::fixed_count`].
    fixed_count: Option<NonZeroU32>,
}

impl PixelSampler {
    /// The stream of one camera sample. Indices at or beyond [`Sampler::spp`] are allowed and continue with
    /// new points.
    #[inline]
    pub fn stream(&self, index: u32) -> SampleStream {
        match self.points {
            Points::Stratified(grid) => {
                SampleStream::Stratified(StratifiedStream::new(grid, self.seed, index))
            }
            Points::Random => SampleStream::Random(RandomStream::new(self.seed, index)),
            Points::Sobol => {
                SampleStream::Sobol(SobolStream::new(self.seed, index, self.fixed_count))
            }
        }
    }
}

/// Fewer samples make halves of a single one, which has no variance to be corrected.
const MIN_HALVED: u32 = 4;

/// The seed of pilot passes.
const PILOT: u64 = mix(0x7069_6c6f_7400_0001);

/// Sets the streams of light paths apart from those of pixels.
const LIGHT: u64 = 0x6c69_6768_7470_6174;

/// Sets those of ghosts apart from both.
const GHOST: u64 = 0x6768_6f73_746c_6967;

/// Bits of a light path's number within a sequence.
const PATHS_OF_SEQUENCE: u32 = 32;

impl Sampler {
    /// The stream of a path from a light, which belongs to no pixel: all paths of an image are one sequence, independent
    /// of the pixels' (a new one after 2³² of them, the most that points are made for). A region of the film sees its
    /// light come from a small part of the unit hypercube, in which a long sequence is stratified, but many short ones
    /// are not. They are Owen-scrambled whatever the pixels' are: there are no strata for a number that is not known in
    /// advance, and random points made the caustic of a mirror twice as noisy (variance, `census/spot_mirrorpanel_bdpt`).
    pub fn light_stream(&self, number: u64) -> SampleStream {
        self.stream_without_pixel(LIGHT, number)
    }

    /// The same of a ghost's sample.
    pub fn ghost_stream(&self, number: u64) -> SampleStream {
        self.stream_without_pixel(GHOST, number)
    }

    fn stream_without_pixel(&self, salt: u64, number: u64) -> SampleStream {
        let seed = mix2(mix2(self.seed, salt), number >> PATHS_OF_SEQUENCE);
        SampleStream::Sobol(SobolStream::new(seed, number as u32, None))
    }
}

/// The dimensions of one camera sample, one after the other, all in [0, 1).
#[derive(Clone, Copy, Debug)]
pub enum SampleStream {
    /// See [`Points::Stratified`].
    Stratified(StratifiedStream),
    /// See [`Points::Random`].
    Random(RandomStream),
    /// See [`Points::Sobol`].
    Sobol(SobolStream),
}

impl SampleStream {
    /// The next dimension.
    pub fn next_1d(&mut self) -> f32 {
        match self {
            SampleStream::Stratified(s) => s.next_1d(),
            SampleStream::Random(s) => s.next_1d(),
            SampleStream::Sobol(s) => s.next_1d(),
        }
    }

    /// The next dimension if it is `needed`, else an arbitrary value: later dimensions are the same either way.
    #[inline]
    pub fn next_1d_if(&mut self, needed: bool) -> f32 {
        if needed {
            return self.next_1d();
        }
        self.skip_1d();
        0.0
    }

    /// Skips a dimension, which costs less than computing it.
    #[inline]
    pub fn skip_1d(&mut self) {
        match self {
            SampleStream::Stratified(s) => _ = s.next_1d(),
            SampleStream::Random(s) => _ = s.next_1d(),
            SampleStream::Sobol(s) => s.skip_1d(),
        }
    }

    /// Skips a pair of dimensions, which costs less than computing it.
    #[inline]
    pub fn skip_2d(&mut self) {
        match self {
            SampleStream::Stratified(s) => _ = s.next_2d(),
            SampleStream::Random(s) => _ = s.next_2d(),
            SampleStream::Sobol(s) => s.skip_2d(),
        }
    }

    /// The numbers of another way that a path takes from here, beside that which these serve: dimensions that nothing else has, the same for all samples
    /// of a pixel that have come as far. Were the ways to share dimensions, one after the other, those of the second would be others in each sample,
    /// depending on where the first has ended, and not be stratified together.
    pub fn fork(&mut self) -> SampleStream {
        match self {
            SampleStream::Stratified(s) => SampleStream::Stratified(s.fork()),
            SampleStream::Random(s) => SampleStream::Random(s.fork()),
            SampleStream::Sobol(s) => SampleStream::Sobol(s.fork()),
        }
    }

    /// The next pair, well distributed in the unit square.
    pub fn next_2d(&mut self) -> Vec2 {
        match self {
            SampleStream::Stratified(s) => s.next_2d(),
            SampleStream::Random(s) => s.next_2d(),
            SampleStream::Sobol(s) => s.next_2d(),
        }
    }
}

#[cfg(test)]
mod tests;
