//! The cheapest setting that meets an error.

use super::{Candidate, Measurement, Setting};
use crate::samplers::Points;

/// The recommended settings.
#[derive(Clone, Debug, PartialEq)]
pub struct Recommendation {
    /// The requested relative error.
    pub target: f64,
    /// Settings to change, as indices of candidates: the best of each kind that is significantly better than the
    /// scene's own setting.
    pub turned: Vec<usize>,
    /// Samples per pixel.
    pub spp: u32,
    /// Expected seconds of CPU time for an image.
    pub seconds: f64,
    /// The squared error falls as the samples to the power −`slope`.
    slope: f64,
    /// `true` if sample counts must be powers of two.
    by_powers: bool,
}

/// Maximum fraction of the requested squared error that may be bias.
const SHARE_OF_BIAS: f64 = 0.25;

/// Maximum recommended samples per pixel.
const MAX_SPP: f64 = (1u32 << 24) as f64;

/// The squared error falls as the samples to the power −`slope`, fitted over the sample candidates; 1 for
/// independent samples. `None` with fewer than two counts.
pub fn slope(measured: &[(Candidate, Measurement)]) -> Option<f64> {
    let points: Vec<(f64, f64)> = measured
        .iter()
        .filter(|(candidate, m)| candidate.setting == Setting::Samples && m.variance.value > 0.0)
        .map(|(_, m)| (f64::from(m.spp).ln(), m.variance.value.ln()))
        .collect();
    let n = points.len() as f64;
    let (x, y) = points
        .iter()
        .fold((0.0, 0.0), |s, p| (s.0 + p.0 / n, s.1 + p.1 / n));
    let spread: f64 = points.iter().map(|p| (p.0 - x).powi(2)).sum();
    let together: f64 = points.iter().map(|p| (p.0 - x) * (p.1 - y)).sum();
    (spread > 0.0).then(|| -together / spread)
}

impl Recommendation {
    /// Increases the samples after the error was `miss` times the requested one.
    pub(super) fn ask_for_more(&mut self, miss: f64) {
        let more = f64::from(self.spp) * miss.max(1.0).powf(2.0 / self.slope) * 1.05;
        let before = f64::from(self.spp);
        self.spp = samples(more, self.by_powers);
        self.seconds *= f64::from(self.spp) / before;
    }
}

/// Low-discrepancy points are well distributed in powers of two.
fn samples(wanted: f64, by_powers: bool) -> u32 {
    let whole = wanted.ceil().clamp(1.0, MAX_SPP) as u32;
    match by_powers {
        true => whole.next_power_of_two(),
        false => whole,
    }
}

/// The recommendation from the measurements, the first of which is the unchanged scene.
pub fn recommend(measured: &[(Candidate, Measurement)], target: f64) -> Option<Recommendation> {
    let (_, base) = measured.first()?;
    let squared = target * target;
    let mut turned = Vec::new();
    let (mut variance, mut seconds, mut bias) = (base.variance.value, base.seconds.value, 0.0);
    // Depth and the choice of lights were measured with the scene's own integrator, and say nothing about another.
    let of_integrator = |setting| matches!(setting, Setting::MaxDepth | Setting::LightChoice);
    let mut keeps_integrator = true;
    for setting in Setting::QUALITY {
        if of_integrator(setting) && !keeps_integrator {
            continue;
        }
        let fit = |m: &Measurement| {
            let at_most = (m.squared_bias.value + m.squared_bias.within).max(0.0);
            at_most + bias <= SHARE_OF_BIAS * squared
                && m.efficiency.value - m.efficiency.within
                    > base.efficiency.value + base.efficiency.within
        };
        let candidates = measured.iter().enumerate();
        let best = candidates
            .filter(|(_, (candidate, m))| candidate.setting == setting && fit(m))
            .max_by(|(_, (_, a)), (_, (_, b))| a.efficiency.value.total_cmp(&b.efficiency.value));
        if let Some((i, (_, m))) = best {
            turned.push(i);
            keeps_integrator &= setting != Setting::Integrator;
            variance *= m.variance.value / base.variance.value;
            seconds *= m.seconds.value / base.seconds.value;
            bias += m.squared_bias.value.max(0.0);
        }
    }
    // Slopes beyond what was measured are not trusted: at least that of independent samples, and at most twice that.
    let slope = slope(measured).unwrap_or(1.0).clamp(1.0, 2.0);
    let wanted = f64::from(base.spp) * (variance / (squared - bias)).powf(1.0 / slope);
    let sets_sampler = |&&i: &&usize| measured[i].0.setting == Setting::Sampler;
    let sampler = turned.iter().find(sets_sampler).copied().unwrap_or(0);
    let by_powers = measured[sampler].0.options.sampler.points == Points::Sobol;
    let spp = samples(wanted, by_powers);
    let more = f64::from(spp) / f64::from(base.spp);
    Some(Recommendation {
        target,
        turned,
        spp,
        slope,
        by_powers,
        seconds: seconds * more,
    })
}
