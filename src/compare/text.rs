//! The result of a comparison in sentences.

use super::findable::{Findable, POWER};
use super::verdict::{Level, Statistic};
use super::{Comparison, NoiseSource, Side, Uniformity};
use crate::film::{LightPathUse, PixelBounds};

/// Names of the channels.
pub const CHANNELS: [&str; 3] = ["red", "green", "blue"];

impl Comparison {
    /// The verdict in one sentence.
    pub fn sentence(&self) -> String {
        if self.non_finite.unmatched > 0 {
            return format!("The images differ: {}.", self.broken_values().join(" and "));
        }
        let (p, alpha) = (self.verdict.p(), self.verdict.alpha);
        if self.is_empty() {
            let why = match self.non_finite.impossible_variances {
                [0, 0] => "no pixel has finite values in both",
                _ => "too many variances are negative or not a number",
            };
            return format!("It cannot be told whether the images agree: {why}.");
        }
        if let Some(doubt) = self.doubt().filter(|_| self.agrees()) {
            return format!(
                "It cannot be told whether the images agree: no difference was found, but {} could be black in one of \
                 them in {}, and pass, so large and so little known is its noise (that of {} effective samples).",
                place(doubt.side, doubt.bounds),
                CHANNELS[doubt.channel.min(2)],
                effective(doubt.effective_samples),
            );
        }
        match self.verdict.worst() {
            Some(level) if !self.verdict.agrees() => {
                format!("The images differ: {}{}.", describe(level), self.chance(p))
            }
            _ => format!(
                "The images agree: {} (p = {}; below {} they would differ).",
                match self.noise {
                    NoiseSource::None => "every value is the same but for the tolerance",
                    _ => "their differences are no larger than their noise explains",
                },
                probability(p),
                rate(alpha)
            ),
        }
    }

    fn chance(&self, p: f64) -> String {
        match self.noise {
            NoiseSource::None => String::new(),
            _ => format!(
                "; by chance alone any test would say as much with a probability of {} at most",
                probability(p)
            ),
        }
    }

    /// What would have been found, in one sentence; `None` if there is no noise.
    pub fn warranty(&self) -> Option<String> {
        if self.is_empty() {
            return None;
        }
        let (blocks, whole): (Vec<&Findable>, Vec<&Findable>) =
            self.findable.iter().partition(|found| found.side.is_some());
        let parts: Vec<String> = { whole.into_iter().chain(blocks) }.map(found).collect();
        (!parts.is_empty()).then(|| {
            format!(
                "Found with a probability of {:.0} % at least: {}.",
                100.0 * POWER,
                parts.join(", ")
            )
        })
    }

    /// Cautions needed to trust the verdict: the assumptions it relies on, and signs that they are violated.
    pub fn cautions(&self) -> Vec<String> {
        let mut cautions = Vec::new();
        cautions.extend(self.caution_of_noise());
        cautions.extend(self.light_paths.map(caution_of_light_paths));
        if self.non_finite.left_out > 0 {
            cautions.push(format!(
                "{}; these pixels are left out of everything else.",
                capitalised(&self.left_out())
            ));
        }
        cautions.extend(self.caution_of_neighbors());
        cautions.extend(self.caution_of_p_values());
        cautions
    }

    fn has_dependent_pixels(&self) -> bool {
        self.neighbors.suspicious() && self.noise != NoiseSource::None
    }

    fn caution_of_neighbors(&self) -> Option<String> {
        let cause = match self.verdict.agrees() {
            true => "something moved",
            false => "what differs is larger than a pixel",
        };
        self.has_dependent_pixels().then(|| {
            format!(
                "Differences of neighboring pixels correlate ({:+.2}): either {cause}, or the \
                 images' noise is not independent from pixel to pixel (splatting filter, denoiser, \
                 scaling) and tests of blocks are too sure; then compare renders with independent pixels, \
                 or use a cell about twice as wide as the filter (--noise spatial --cell N).",
                self.neighbors.correlation
            )
        })
    }

    /// Cautions from the distribution of the p-values: one sentence for all block sizes.
    fn caution_of_p_values(&self) -> Vec<String> {
        let shares = |bent: fn(&Uniformity) -> bool| -> Option<String> {
            let levels = self.uniformity.iter().filter(|u| bent(u));
            let share =
                |u: &Uniformity| format!("{:.1} % of {}", 100.0 * u.small, blocks(Some(u.side)));
            let shares: Vec<String> = levels.map(share).collect();
            (!shares.is_empty()).then(|| shares.join(", "))
        };
        let (small, large) = (shares(Uniformity::too_small), shares(Uniformity::too_large));
        if let (Some(small), Some(large)) = (&small, &large) {
            // One note each would say one thing and its opposite.
            return vec![format!(
                "There are too many small p-values of some sizes ({small} are below 5 %) and too few of others ({large}): the \
                 variances are not those of the noise there is."
            )];
        }
        let small = small.map(|shares| {
            format!(
                "There are too many small p-values ({shares} are below 5 %): many differences too slight \
                 to be proven one by one, or noise that is larger or more skewed than the variances say."
            )
        });
        // A filter makes single pixels smoother than their variances say and blocks noisier: a test that is too sure is not one
        // that finds too little.
        let large = large.filter(|_| !self.has_dependent_pixels());
        let large = large.map(|shares| {
            format!(
                "There are too few small p-values ({shares} are below 5 %): the variances are overestimated, \
                 as those of stratified samples are, or the renders share random numbers. Differences are \
                 found less easily than they could be."
            )
        });
        small.into_iter().chain(large).collect()
    }

    fn caution_of_noise(&self) -> Option<String> {
        let who = match self.noise {
            NoiseSource::Stored | NoiseSource::None => return None,
            NoiseSource::Spatial => String::new(),
            NoiseSource::SpatialWithout(image) => format!("{image} has no usable variances: "),
            NoiseSource::SpatialWithoutBoth => "Neither image has usable variances: ".to_owned(),
        };
        Some(capitalised(&format!(
            "{who}the noise is estimated from the scatter of the difference within blocks. That assumes \
             pixels independent of each other and differences as likely up as down (images made alike); \
             single wrong pixels are not found. For a sharper test render both with --variance."
        )))
    }

    /// Describes the infinite and NaN values, for each image that has any.
    fn broken_values(&self) -> Vec<String> {
        let of = |image: Side| {
            let (count, first) = self.non_finite.of(image)?;
            let pixels = if count == 1 { "pixel" } else { "pixels" };
            Some(format!(
                "{image} has {count} {pixels} that are infinite or not a number (the first at {}, {})",
                first.x, first.y
            ))
        };
        [Side::A, Side::B].into_iter().filter_map(of).collect()
    }

    /// Describes all that is left out.
    fn left_out(&self) -> String {
        let of = |image: Side| {
            let count = self.non_finite.impossible_variances[image as usize];
            let pixels = if count == 1 { "pixel" } else { "pixels" };
            (count > 0).then(|| {
                format!("{image} has {count} {pixels} whose variance is negative or not a number")
            })
        };
        let of_variances = [Side::A, Side::B].into_iter().filter_map(of);
        let all = self.broken_values().into_iter().chain(of_variances);
        all.collect::<Vec<_>>().join(" and ")
    }
}

fn caution_of_light_paths([a, b]: [LightPathUse; 2]) -> String {
    format!(
        "Paths from the lights bring other parts of the light in A ({}) than in B ({}): what comes by few samples of one image it may \
         have missed where the other knows it well. So a darker block is taken to lack samples as bright as the brightest \
         that its image has found. Renders with the same settings use light paths alike, and are compared without that.",
        used(a),
        used(b)
    )
}

/// How many light paths there are.
fn used(light_paths: LightPathUse) -> String {
    let LightPathUse { per_sample, joined } = light_paths;
    let joined = match joined {
        0.0 => String::new(),
        share => format!(", {share} of the camera paths joined to one"),
    };
    match per_sample {
        0.0 if joined.is_empty() => "no light paths".to_string(),
        0.0 => format!("no light paths to the lens{joined}"),
        1.0 => format!("1 light path for each sample{joined}"),
        count => format!("{count} light paths for each sample{joined}"),
    }
}

/// Describes the most significant test of a level.
fn describe(level: &Level) -> String {
    let worst = &level.worst;
    let place = place(level.side, worst.bounds);
    let channel = CHANNELS[worst.channel.min(2)];
    match level.statistic {
        Statistic::Neighbors => format!(
            "in {place} the differences of neighboring pixels in {channel} belong together, as noise's do \
             not ({:.1} standard errors)",
            worst.t.abs()
        ),
        Statistic::Mean if worst.t.is_infinite() => format!(
            "{place} is {} in {channel}{}",
            difference(worst.a, worst.b),
            others(level)
        ),
        Statistic::Mean => format!(
            "{place} is {} in {channel}, {:.1} standard errors{}",
            difference(worst.a, worst.b),
            worst.t.abs(),
            others(level)
        ),
    }
}

/// Describes the number of other significant tests.
fn others(level: &Level) -> String {
    match level.rejected {
        0 | 1 => String::new(),
        n => format!(" (and {} more of {} tests)", n - 1, level.tests),
    }
}

/// What is found, of blocks of one size.
fn found(found: &Findable) -> String {
    let channel = CHANNELS[found.channel.min(2)];
    let difference = match found.relative {
        r if r < MANY => format!("a difference of {} of ", relative(r)),
        r if r.is_finite() => format!("a difference of {} the mean of ", relative(r)),
        _ => "none at all in ".to_owned(),
    };
    match found.side {
        None => format!("{difference}the whole image ({channel})"),
        Some(side) => format!(
            "{difference}the block of {side} × {side} where noise hides most ({}, {channel})",
            extent(found.bounds)
        ),
    }
}

/// An effective sample size: one decimal where there are few.
fn effective(samples: f64) -> String {
    let digits = usize::from(samples < 9.95);
    format!("{samples:.digits$}")
}

/// From here on differences are told in multiples, below in per cent.
const MANY: f64 = 10.0;

/// A relative difference, as a percentage of two digits.
pub fn relative(x: f64) -> String {
    if x.is_infinite() {
        return "∞".to_owned();
    }
    if x >= MANY {
        return format!("{x:.0} times");
    }
    let digits = (1.0 - (100.0 * x).max(1e-4).log10().floor()).clamp(0.0, 5.0);
    format!("{:.*} %", digits as usize, 100.0 * x)
}

fn place(side: Option<u32>, bounds: PixelBounds) -> String {
    match side {
        None => "the whole image".to_owned(),
        Some(1) => format!("pixel {}, {}", bounds.min.x, bounds.min.y),
        Some(_) => format!("the block {}", extent(bounds)),
    }
}

/// A rectangle, by its first and last columns and rows.
pub fn extent(bounds: PixelBounds) -> String {
    format!(
        "x {}..{} y {}..{}",
        bounds.min.x, bounds.max.x, bounds.min.y, bounds.max.y
    )
}

/// How A relates to B.
fn difference(a: f64, b: f64) -> String {
    let word = if a > b { "brighter" } else { "darker" };
    let ratio = a / b - 1.0;
    if ratio.is_finite() && ratio.abs() < 10.0 {
        format!(
            "{:.2} % {word} in A ({a:.6} against {b:.6})",
            100.0 * ratio.abs()
        )
    } else {
        format!("{word} in A ({a:.6} against {b:.6})")
    }
}

/// A name for the blocks of one size.
pub fn blocks(side: Option<u32>) -> String {
    match side {
        None => "the whole image".to_owned(),
        Some(1) => "single pixels".to_owned(),
        Some(side) => format!("blocks of {side} × {side}"),
    }
}

/// A probability rounded to two digits.
pub fn probability(p: f64) -> String {
    if p == 0.0 {
        "0".to_owned()
    } else if p < 1e-3 {
        format!("{p:.1e}")
    } else {
        format!("{p:.3}")
    }
}

/// A false-alarm rate: as it was given, or rounded to two digits if it was shared among many.
pub fn rate(alpha: f64) -> String {
    const SHORT: usize = 7;
    let text = alpha.to_string();
    match text.len() <= SHORT {
        true => text,
        false if alpha < 1e-4 => format!("{alpha:.1e}"),
        false => {
            let digits = (1.0 - alpha.log10().floor()).clamp(0.0, 6.0);
            format!("{alpha:.*}", digits as usize)
        }
    }
}

fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| {
        first.to_uppercase().chain(letters).collect()
    })
}
