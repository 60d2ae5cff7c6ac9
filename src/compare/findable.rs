//! What a comparison could have found: "agree" is worth no more.
//!
//! A test at level α' finds a difference of (q₁ + q₂) standard errors with a probability of 95 %, where q₁ is Student's
//! quantile of the test and q₂ that of the power (M. Kutner et al., "Applied Linear Statistical Models", 5th edition 2005,
//! §2.3, without the noncentral distribution, which is within a few per cent of it from five degrees of freedom on).

use super::student::two_sided_t;
use super::verdict::{BlockTest, Candidate};
use super::welch::freedom_with;
use crate::film::PixelBounds;
use rayon::prelude::*;
use std::collections::HashMap;

/// The probability of being found.
pub const POWER: f64 = 0.95;

/// Blocks that are cut by the image's edge to less than this part of their area do not count: they are not what the size
/// promises.
const MIN_AREA_FRACTION: f64 = 0.25;

/// Dark blocks are judged by this part of the image's mean: there a difference as large as all of the light is none to look at. With
/// a hundredth two renders of the Cornell box (64 samples) could not be told to agree, for the green at one edge.
const FLOOR: f64 = 0.1;

/// The smallest difference that would have been found in the block, of one size, where least can be found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Findable {
    /// Side of the blocks in pixels; `None` for the whole image.
    pub side: Option<u32>,
    /// The block.
    pub bounds: PixelBounds,
    /// 0 red, 1 green, 2 blue.
    pub channel: usize,
    /// The difference, relative to the block's mean in the reference, or to a tenth of the image's where that is more.
    /// Infinite where nothing can be found.
    pub relative: f64,
    /// The effective sample size, of both images together: (light / standard error of the difference)², with the light that `relative` is
    /// relative to. Of images whose samples find equal light or none it is 1 / (1/a + 1/b), where a and b samples find it; below the
    /// smaller of a and b if the larger [variance per sample](super::Options) counts for both. Of one image it would be Kish's
    /// (Σx)² / Σx² (L. Kish, "Survey Sampling" 1965, §8.2). With the noise of light that may have been missed. Infinite without noise, 0 where so few
    /// observations prove nothing.
    pub effective_samples: f64,
}

impl Findable {
    /// The worst of all blocks of one size, each tested at the level `alpha`; `mean` is the reference's, of all channels.
    pub(super) fn worst<T: BlockTest>(
        test: &T,
        image: PixelBounds,
        side: Option<u32>,
        alpha: f64,
        mean: f64,
    ) -> Option<Findable> {
        let full = side.map_or(0.0, |side| f64::from(side).powi(2));
        let least = MIN_AREA_FRACTION * full.min(image.area() as f64);
        let blocks: Vec<PixelBounds> = image.tiles(side.unwrap_or(u32::MAX)).collect();
        let asked: Vec<_> = { blocks.into_par_iter() }
            .filter(|block| block.area() as f64 >= least)
            .map(|block| (block, test.ask(block)))
            .collect();
        let mut quantiles = Quantiles::new(alpha);
        let mut worst: Option<Findable> = None;
        for (bounds, candidates) in asked {
            for (channel, candidate) in candidates.iter().enumerate() {
                let light = candidate.means[1].abs().max(FLOOR * mean.abs());
                // Equal pixels are equal, however few.
                let is_equal = candidate.error == 0.0 && candidate.means[0] == candidate.means[1];
                let can_be_found = candidate.floor_of_all < alpha || is_equal;
                let least = match can_be_found {
                    true => candidate.smallest(&mut quantiles),
                    false => f64::INFINITY,
                };
                let relative = if least == 0.0 { 0.0 } else { least / light };
                if worst.is_none_or(|worst| relative > worst.relative) {
                    worst = Some(Findable {
                        side,
                        bounds,
                        channel,
                        relative,
                        effective_samples: match candidate.error_with(least) {
                            _ if !can_be_found => 0.0,
                            0.0 => f64::INFINITY,
                            error => (light / error).powi(2),
                        },
                    });
                }
            }
        }
        worst
    }
}

impl Candidate {
    /// The smallest difference that is as many standard errors as it takes.
    fn smallest(&self, quantiles: &mut Quantiles) -> f64 {
        let own = match self.error {
            0.0 => self.tolerated,
            error => quantiles.at(self.freedom) * error + self.tolerated,
        };
        match self.missed {
            Some(missed) if missed.portion > 0.0 && own.is_finite() => {
                // Known as well as light that may be missed is, or better.
                let lacking = self.smallest_with(missed.portion, quantiles.at(f64::INFINITY));
                let variance = (self.error * self.error, self.freedom);
                let freedom = freedom_with(variance, missed.portion * lacking);
                own.max(self.smallest_with(missed.portion, quantiles.at(freedom)))
            }
            _ => own,
        }
    }

    /// The smallest difference that is so many standard errors, where its variance grows by `portion` for each unit of it.
    fn smallest_with(&self, portion: f64, errors: f64) -> f64 {
        let square = errors * errors;
        let half = 0.5 * square * portion;
        let own = square * (self.error * self.error + portion * self.tolerated);
        self.tolerated + half + (half * half + own).sqrt()
    }

    /// Standard error of the difference if so much light is missed.
    fn error_with(&self, missed: f64) -> f64 {
        match self.missed {
            Some(light) if light.portion > 0.0 => self.error.hypot((light.portion * missed).sqrt()),
            _ => self.error,
        }
    }
}

/// Sums of both quantiles, for degrees of freedom that are rounded down to a sixteenth of an octave.
struct Quantiles {
    alpha: f64,
    known: HashMap<i32, f64>,
}

impl Quantiles {
    const STEPS: f64 = 16.0;

    fn new(alpha: f64) -> Quantiles {
        let known = HashMap::new();
        Quantiles { alpha, known }
    }

    fn at(&mut self, freedom: f64) -> f64 {
        if freedom.is_nan() || freedom <= 0.0 {
            return f64::INFINITY;
        }
        // From 2²⁰ on all are normal.
        let step = (freedom.log2().clamp(-8.0, 20.0) * Quantiles::STEPS).floor();
        let alpha = self.alpha;
        *self.known.entry(step as i32).or_insert_with(|| {
            let freedom = (step / Quantiles::STEPS).exp2();
            two_sided_t(alpha, freedom) + two_sided_t(2.0 * (1.0 - POWER), freedom)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Normal: 3.2905 at one in a thousand, 1.6449 for 95 %.
    #[test]
    fn quantiles_by_the_tables() {
        let sum = Quantiles::new(1e-3).at(1e9);
        // The tables' digits.
        assert!((sum - 3.2905 - 1.6449).abs() < 1e-4, "{sum}");
        assert!(Quantiles::new(1e-3).at(0.0).is_infinite());
        let few = Quantiles::new(1e-3).at(10.0);
        // 4.587 + 1.812 at ten, and no more than a sixteenth of an octave fewer.
        assert!((6.399..6.399 * 1.02).contains(&few), "{few}");
    }
}
