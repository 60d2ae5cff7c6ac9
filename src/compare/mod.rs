//! Do two renders show the same picture?
//!
//! Renders are random, so their difference says nothing until it is set against their noise. Where
//! both files carry the variance of each pixel, [`compare`] asks Welch's t-test (Jung, Hanika,
//! Dachsbacher, "Detecting Bias in Monte Carlo Renderers using Welch's t-test", JCGT 9(2), 2020) on
//! pixels, on blocks of pixels and on the whole picture, and corrects for the number of tests asked.
//! Besides, and without variances only, it reports differences as plain numbers ([`Metrics`]).

mod estimate;
mod metrics;
mod student;
mod welch;

#[cfg(test)]
mod tests;

pub use estimate::{CompareError, Estimate};
pub use metrics::{ChannelMeans, Metrics};
pub use student::two_sided_p;
pub use welch::{Finding, Level, Options, Verdict, p_values, welch};

/// The answer of [`compare`].
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// What the t-tests say; `None` where a picture has no variances.
    pub verdict: Option<Verdict>,
    /// Differences in numbers.
    pub metrics: Metrics,
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
/// b.pixels[37].y = 1.0; // a hundred standard deviations
/// let [a, b] = [&a, &b].map(|image| Estimate { image, freedom: 63.0, samples: Some(64.0) });
/// let verdict = compare(&a, &b, &Options::default())?.verdict.unwrap();
/// assert!(!verdict.agrees());
/// # Ok::<(), fstop::compare::CompareError>(())
/// ```
///
/// # Errors
/// Pictures of different pixels, or of none.
pub fn compare(a: &Estimate, b: &Estimate, options: &Options) -> Result<Comparison, CompareError> {
    estimate::check_pair(a, b)?;
    Ok(Comparison {
        verdict: welch(a, b, options)?,
        metrics: Metrics::new(a, b),
    })
}
