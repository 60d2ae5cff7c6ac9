//! How many samples find a difference.

use crate::compare::{CompareError, Estimate, Findable, Noise as Source, Options, findable};
use crate::film::{Image, LoadedImage};
use crate::math::Rgb;

/// What is to be found with a probability of 95 % ([`POWER`](crate::compare::POWER)).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aim {
    /// The relative difference.
    pub relative: f64,
    /// Side in pixels of the blocks it is in; `None` for the whole image.
    pub side: Option<u32>,
}

/// The most samples that are proposed.
pub const MAX_SPP: u32 = 1 << 24;

/// The fewest: with fewer the noise is too little known for tests to be trusted (docs/compare.md).
const MIN_SPP: u32 = 16;

/// How an aim is reached.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// Samples per pixel of the image, all its runs together: a power of two.
    pub spp: u32,
    /// What is found with them.
    pub found: Findable,
}

/// What is found, and what it takes to find more.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plan {
    /// What is found with as many samples as the pilot has.
    pub now: Findable,
    /// With the reference there is; `None` without one, or if its own noise hides the difference.
    pub kept: Option<Step>,
    /// With a reference that is rendered anew.
    pub anew: Option<Step>,
}

/// Why there is no plan.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PlanError {
    /// The noise is not known.
    #[error("{0} has no variances, or does not say how many samples it has")]
    Noise(&'static str),
    /// The suite says that there is none.
    #[error(
        "the suite says `noise = \"none\"`: images without noise are known as they are, with any number of samples"
    )]
    Noiseless,
    /// The images cannot be compared.
    #[error(transparent)]
    Compare(#[from] CompareError),
    /// There are no blocks of that size.
    #[error("the image has no blocks of that size")]
    Size,
}

impl Plan {
    /// By a pilot render and the reference, if there is one; a new one has `times` as many samples as the image. The variances are
    /// taken to fall as 1/spp with more samples than the pilot has, which is true of independent ones and less than what others
    /// gain; with fewer, to grow as those of smooth images with samples spread evenly over two dimensions, 1/spp².
    ///
    /// # Errors
    /// See [`PlanError`].
    pub fn new(
        pilot: &LoadedImage,
        reference: Option<&LoadedImage>,
        times: f64,
        aim: Aim,
        options: &Options,
    ) -> Result<Plan, PlanError> {
        if options.noise == Source::None {
            return Err(PlanError::Noiseless);
        }
        // By variances alone: what both images show does not change with the number of samples.
        let options = &Options {
            noise: Source::Stored,
            ..options.clone()
        };
        let noise = Noise::of(pilot).ok_or(PlanError::Noise("the render"))?;
        let theirs = match reference {
            Some(reference) => Some(Noise::of(reference).ok_or(PlanError::Noise("the reference"))?),
            None => None,
        };
        let found = |spp: f64, other: Scaled| {
            let own = noise.scaled(spp, 1.0);
            match findable(&own.estimate(), &other.estimate(), options) {
                // With so few samples, or runs, variances are not known any more.
                Err(CompareError::NoVariance(_)) => Ok(nothing(pilot, aim)),
                all => {
                    let asked = all?.into_iter().find(|found| found.side == aim.side);
                    asked.ok_or(PlanError::Size)
                }
            }
        };
        let anew = |spp: f64| found(spp, noise.scaled(spp * times, times));
        let Some(theirs) = theirs else {
            return Ok(Plan {
                now: anew(noise.samples)?,
                kept: None,
                anew: least(anew, aim)?,
            });
        };
        let kept = |spp: f64| found(spp, theirs.scaled(theirs.samples, 1.0));
        Ok(Plan {
            now: kept(noise.samples)?,
            kept: least(kept, aim)?,
            anew: least(anew, aim)?,
        })
    }
}

/// What is found where nothing is.
fn nothing(pilot: &LoadedImage, aim: Aim) -> Findable {
    Findable {
        side: aim.side,
        bounds: pilot.image.bounds,
        channel: 0,
        relative: f64::INFINITY,
        effective_samples: 0.0,
    }
}

/// The smallest power of two that reaches the aim, by bisection: more samples find no less.
fn least(
    found: impl Fn(f64) -> Result<Findable, PlanError>,
    aim: Aim,
) -> Result<Option<Step>, PlanError> {
    let at = |power: u32| found(f64::from(1u32 << power));
    let (mut low, mut high) = (MIN_SPP.ilog2(), MAX_SPP.ilog2());
    let mut best = at(high)?;
    if best.relative > aim.relative {
        return Ok(None);
    }
    while low < high {
        let middle = (low + high) / 2;
        let tried = at(middle)?;
        match tried.relative <= aim.relative {
            true => (high, best) = (middle, tried),
            false => low = middle + 1,
        }
    }
    Ok(Some(Step {
        spp: 1 << high,
        found: best,
    }))
}

/// An image whose noise is known.
struct Noise<'a> {
    estimate: Estimate<'a>,
    samples: f64,
    /// Its variances are the scatter of its runs, whose number is all that says how well they are known.
    is_scatter: bool,
}

impl<'a> Noise<'a> {
    fn of(loaded: &'a LoadedImage) -> Option<Noise<'a>> {
        let estimate = Estimate::of(loaded);
        let samples = estimate.samples?;
        estimate.has_variance().then_some(Noise {
            estimate,
            samples,
            is_scatter: loaded.freedom.is_none() && loaded.runs.is_some_and(|runs| runs > 1),
        })
    }

    /// As with another number of samples, in `runs` times as many runs.
    fn scaled(&self, samples: f64, runs: f64) -> Scaled<'a> {
        let more = samples / self.samples;
        let observations = if self.is_scatter { runs } else { more };
        let fall = if more < 1.0 { more * more } else { more };
        let less = |variances: &Vec<Rgb>| variances.iter().map(|v| *v / fall as f32).collect();
        let image = self.estimate.image;
        Scaled {
            estimate: Estimate {
                // One degree of freedom is that of the mean; of less than one nothing is known.
                freedom: ((self.estimate.freedom + 1.0) * observations - 1.0).max(0.0),
                samples: Some(samples),
                ..self.estimate
            },
            image: Image {
                variance: image.variance.as_ref().map(less),
                independent: image.independent.as_ref().map(less),
                ..image.clone()
            },
        }
    }
}

struct Scaled<'a> {
    /// All but the image.
    estimate: Estimate<'a>,
    image: Image,
}

impl Scaled<'_> {
    fn estimate(&self) -> Estimate<'_> {
        Estimate {
            image: &self.image,
            ..self.estimate
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::UVec2;

    /// A flat image whose noise is known exactly: what is found is q standard errors of the difference of two block means,
    /// so the samples follow from q², σ² and the aim by hand.
    #[test]
    fn samples_follow_from_the_noise() {
        let mut image = Image::black(UVec2::new(64, 64));
        image.pixels.fill(Rgb::ONE);
        image.variance = Some(vec![Rgb::splat(0.04 / 64.0); 64 * 64]);
        let pilot = LoadedImage {
            spp: Some(64),
            freedom: Some(1e9),
            ..LoadedImage::of(image)
        };
        let options = Options::default();
        let plan = |relative, reference, times| {
            let aim = Aim {
                relative,
                side: Some(32),
            };
            Plan::new(&pilot, reference, times, aim, &options).expect("a plan")
        };
        // 1e-3 among four sizes of tests, and 12 of blocks of 32, is 2.08e-5: normal quantiles of 4.256, and 1.645 for 95 %.
        let q = 4.256 + 1.645;
        let error = |spp: f64, runs: f64| (0.04 / spp * (1.0 + 1.0 / runs)).sqrt() / 32.0;
        let now = plan(0.01, None, 1.0).now.relative;
        // The tolerance of 1e-5 is added; the quantile is rounded, and degrees of freedom are.
        assert!(
            (now - q * error(64.0, 1.0) - 1e-5).abs() < 1e-2 * now,
            "{now}"
        );
        for runs in [1.0, 4.0] {
            let step = plan(0.001, None, runs).anew.expect("samples");
            let needed = |spp: u32| q * error(f64::from(spp), runs) + 1e-5;
            assert!(
                needed(step.spp) <= 0.001 && needed(step.spp / 2) > 0.001,
                "{}",
                step.spp
            );
        }
        // With the reference at 64 samples no number is enough for what it hides.
        let hidden = plan(0.7 * now, Some(&pilot), 1.0);
        assert_eq!(
            (hidden.kept, hidden.anew.map(|step| step.spp)),
            (None, Some(256))
        );
        let shown = plan(0.8 * now, Some(&pilot), 1.0).kept.expect("samples");
        // 1/64 + 1/n = 0.64 · 2/64 takes n = 229.
        assert_eq!(shown.spp, 256);
    }

    /// The scatter of two runs is as well known with any number of samples: the proposal follows from the noise, not from where
    /// the pilot's samples would leave no degree of freedom.
    #[test]
    fn two_runs_are_two_runs_with_any_number_of_samples() {
        let plan = |spp: u32, noise| {
            let mut image = Image::black(UVec2::new(64, 64));
            image.pixels.fill(Rgb::ONE);
            image.variance = Some(vec![Rgb::splat(0.09 / (2.0 * spp as f32)); 64 * 64]);
            let pilot = LoadedImage {
                spp: Some(spp),
                runs: Some(2),
                ..LoadedImage::of(image)
            };
            let aim = Aim {
                relative: 0.0035,
                side: Some(32),
            };
            let options = Options {
                noise,
                ..Options::default()
            };
            Plan::new(&pilot, None, 2.0, aim, &options)
        };
        let noise = Source::Auto;
        let found = |spp| plan(spp, noise).expect("a plan").anew.expect("samples").spp;
        // 4.256 + 1.645 standard errors of √(0.09/n · 3/2) / 32 are 0.35 % at n = 377; the variances' own uncertainty, of 1,024 degrees
        // of freedom and more, adds less than a per cent.
        assert_eq!((found(8), found(64), found(256)), (512, 512, 512));
        // With fewer than the pilot's 2,048, variances are taken to be as 1/spp²: 512 would not do.
        assert_eq!(found(1024), 1024);
        assert_eq!(plan(64, Source::None), Err(PlanError::Noiseless));
    }

    /// Where fewer samples leave no degree of freedom, nothing is found: the scatter of the pilot is not asked instead.
    #[test]
    fn variances_that_would_not_be_known_find_nothing() {
        let mut image = Image::black(UVec2::new(64, 64));
        image.pixels.fill(Rgb::ONE);
        image.variance = Some(vec![Rgb::splat(1e-9); 64 * 64]);
        let pilot = LoadedImage {
            spp: Some(1024),
            freedom: Some(2.0),
            ..LoadedImage::of(image)
        };
        let aim = Aim {
            relative: 0.5,
            side: Some(32),
        };
        let plan = Plan::new(&pilot, None, 1.0, aim, &Options::default()).expect("a plan");
        // (2 + 1) n / 1024 − 1 is one degree of freedom from n = 683 on.
        assert_eq!(plan.anew.map(|step| step.spp), Some(1024));
    }
}
