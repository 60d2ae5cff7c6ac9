//! The `homogeneous` medium: the same everywhere.
//!
//! `preset` (string, none): a row of [`presets`](super::presets). `sigma_a` (spectrum, (.0011, .0024, .014)) and
//! `sigma_s` (spectrum, (2.55, 3.21, 3.77)): absorption and scattering coefficients per scene unit, instead of the
//! preset's. `scale` (float, 1): factor on both. `g` (float, 0): mean cosine of the [phase function](super::phase).
//! Source: Pharr, Jakob and Humphreys 2016, §11.3.1 and §15.2.1; docs/scene-language.md §3.12.

use super::presets::Coefficients;
use super::{BothWays, Flight, HenyeyGreenstein, common};
use crate::math::Rgb;
use crate::math::float::is_positive;
use crate::params::ParamReader;
use crate::samplers::SampleStream;

/// A medium that is the same everywhere.
#[derive(Clone, Debug, PartialEq)]
pub struct Homogeneous {
    sigma_s: Rgb,
    sigma_t: Rgb,
    /// The phase function.
    pub(super) phase: HenyeyGreenstein,
}

impl Homogeneous {
    /// Reads the parameters.
    pub fn from_params(reader: &ParamReader) -> Homogeneous {
        Homogeneous::new(common::coefficients(reader), common::phase(reader))
    }

    /// A medium with these coefficients, finite and at least 0.
    pub fn new(coefficients: Coefficients, phase: HenyeyGreenstein) -> Homogeneous {
        Homogeneous {
            sigma_s: coefficients.sigma_s,
            sigma_t: coefficients.sigma_t(),
            phase,
        }
    }

    /// The transmittance over the distance `t`, which may be infinite (Beer's law).
    pub fn transmittance(&self, t: f32) -> Rgb {
        // 0 times the largest number is 0, but times infinity NaN.
        let t = t.min(f32::MAX);
        (-self.sigma_t * t).exp()
    }

    /// Samples a free path before `t_max`, where the ray ends.
    ///
    /// The distance is sampled for one channel and weighted by the mean density of all (the balance heuristic). pbrt-v3
    /// chooses uniformly among the channels; here each is chosen in proportion to its `throughput` so far, which has
    /// the same expectation, and a path that has lost a channel is no longer sampled for it: weighted throughputs then
    /// never grow.
    pub fn sample(&self, t_max: f32, throughput: Rgb, stream: &mut SampleStream) -> Flight {
        let shares = channel_shares(throughput);
        let (choice, u) = (stream.next_1d(), stream.next_1d());
        let channel = channel_at(shares, choice);
        // Infinite if the channel is not attenuated; u < 1, so the logarithm is finite.
        let t = -(1.0 - u).ln() / self.sigma_t[channel];
        let scatters = t < t_max;
        let left = self.transmittance(if scatters { t } else { t_max });
        let (value, densities) = if scatters {
            (left * self.sigma_s, left * self.sigma_t)
        } else {
            (left, left)
        };
        let density = shares.dot(densities);
        // Zero only if everything that may be chosen is too small for single precision.
        let weight = if density > 0.0 {
            value / density
        } else {
            Rgb::ZERO
        };
        Flight {
            scattered: scatters.then_some(t),
            weight,
        }
    }

    /// Both ways of a ray that ends at `t_max`: that it is stopped before, and that it passes. `None` where the medium stops nothing.
    ///
    /// Distances have the density of [`Homogeneous::sample`] over the probability that the ray is stopped at all (a forced collision; Lux and
    /// Koblinger, *Monte Carlo Particle Transport Methods*, 1991).
    pub fn both_ways(
        &self,
        t_max: f32,
        throughput: Rgb,
        stream: &mut SampleStream,
    ) -> Option<BothWays> {
        let depths = self.sigma_t * t_max.min(f32::MAX);
        // In thin media 1 − exp(−x) would be rounding alone.
        let stopped = Rgb::from_array(depths.to_array().map(|x| -(-x).exp_m1()));
        let shares = channel_shares(throughput);
        let parts = shares * stopped;
        let all = parts.element_sum();
        let (choice, u) = (stream.next_1d(), stream.next_1d());
        let channel = channel_at(parts, choice * all);
        is_positive(all).then(|| {
            // Rounding may lead beyond the end.
            let t = (-(-u * stopped[channel]).ln_1p() / self.sigma_t[channel]).min(t_max);
            let left = self.transmittance(t);
            let density = shares.dot(left * self.sigma_t) / all;
            BothWays {
                t,
                scattered: left * self.sigma_s / density,
                passed: (-depths).exp(),
            }
        })
    }
}

/// Probabilities of the channels.
fn channel_shares(throughput: Rgb) -> Rgb {
    let throughput = throughput.abs();
    let shares = throughput / throughput.element_sum();
    if shares.is_finite() {
        shares
    } else {
        Rgb::splat(1.0 / 3.0)
    }
}

/// The channel that has `at` in its part, where those of the channels follow each other.
fn channel_at(parts: Rgb, at: f32) -> usize {
    if at < parts.x {
        0
    } else if at < parts.x + parts.y {
        1
    } else {
        2
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::IVec2;
    use crate::samplers::{Sampler, SamplerSpec};

    fn medium(sigma_a: [f32; 3], sigma_s: [f32; 3]) -> Homogeneous {
        let coefficients = Coefficients {
            sigma_a: Rgb::from_array(sigma_a),
            sigma_s: Rgb::from_array(sigma_s),
        };
        Homogeneous::new(coefficients, HenyeyGreenstein::new(0.0))
    }

    /// Mean weights of free paths that are transmitted and of those that scatter, over `n` samples.
    fn means(medium: &Homogeneous, t_max: f32, throughput: Rgb, n: u32) -> (Rgb, Rgb) {
        let sampler = Sampler::new(&SamplerSpec::sobol(n), 1);
        let (mut passed, mut scattered) = (Rgb::ZERO, Rgb::ZERO);
        for i in 0..n {
            let mut stream = sampler.stream(IVec2::ZERO, i);
            let flight = medium.sample(t_max, throughput, &mut stream);
            match flight.scattered {
                Some(t) => {
                    assert!(t < t_max);
                    scattered += flight.weight / n as f32;
                }
                None => passed += flight.weight / n as f32,
            }
        }
        (passed, scattered)
    }

    /// Beer's law: exp(−σₜ t) is transmitted, and of the rest the fraction σₛ / σₜ scatters.
    #[test]
    fn expectations_follow_beers_law_in_every_channel() {
        let m = medium([0.1, 0.5, 0.0], [0.4, 0.1, 2.0]);
        for throughput in [Rgb::ONE, Rgb::new(1.0, 0.05, 0.3), Rgb::ZERO] {
            for t_max in [0.3, 2.0] {
                let (passed, scattered) = means(&m, t_max, throughput, 65536);
                for c in 0..3 {
                    let left = (-m.sigma_t[c] * t_max).exp();
                    let albedo = m.sigma_s[c] / m.sigma_t[c];
                    // 65,536 well-distributed samples; a rarely chosen channel has weights up to 20, hence 1 %.
                    assert!((passed[c] - left).abs() < 0.01, "{c} {t_max}: {passed}");
                    let expected = (1.0 - left) * albedo;
                    assert!((scattered[c] - expected).abs() < 0.01, "{c}: {scattered}");
                    assert!((m.transmittance(t_max)[c] - left).abs() < 1e-6);
                }
            }
        }
    }

    /// The same where both ways are taken, however thin the medium.
    #[test]
    fn both_ways_follow_beers_law() {
        let sampler = Sampler::new(&SamplerSpec::sobol(4096), 1);
        for (scale, throughput) in [
            (1.0, Rgb::ONE),
            (1.0, Rgb::new(1.0, 0.05, 0.3)),
            (1e-7, Rgb::ONE),
        ] {
            let m = medium(
                [0.1 * scale, 0.5 * scale, 0.0],
                [0.4 * scale, 0.0, 2.0 * scale],
            );
            let t_max = 1.5;
            let mut mean = Rgb::ZERO;
            for i in 0..4096 {
                let mut stream = sampler.stream(IVec2::ZERO, i);
                let ways = m.both_ways(t_max, throughput, &mut stream).unwrap();
                assert!((0.0..=t_max).contains(&ways.t));
                assert_eq!(ways.passed, m.transmittance(t_max));
                mean += ways.scattered / 4096.0;
            }
            for c in 0..3 {
                let albedo = f64::from(m.sigma_s[c]) / f64::from(m.sigma_t[c]);
                let expected = -albedo * (f64::from(-m.sigma_t[c]) * f64::from(t_max)).exp_m1();
                // 4,096 well-distributed samples; a rarely chosen channel has weights up to 20, hence 1 %.
                let error = (f64::from(mean[c]) - expected).abs();
                assert!(error <= 0.01 * expected, "{c} {scale}: {mean}");
            }
        }
    }

    /// Keeps the variance of paths through dense media low: throughput times weight never has a larger sum.
    #[test]
    fn weighted_throughput_never_grows() {
        let m = medium([0.1, 0.02, 0.0], [3.0, 0.5, 0.1]);
        let sampler = Sampler::new(&SamplerSpec::random(1000), 3);
        for i in 0..1000 {
            let mut stream = sampler.stream(IVec2::ZERO, i);
            let mut throughput = Rgb::new(0.2, 1.0, 0.6);
            for _ in 0..20 {
                let before = throughput.element_sum();
                throughput *= m.sample(1.0, throughput, &mut stream).weight;
                // Rounding of some twenty operations.
                assert!(throughput.element_sum() <= before * 1.000_01);
            }
        }
    }

    #[test]
    fn extreme_coefficients_have_a_meaning() {
        let sampler = Sampler::new(&SamplerSpec::random(64), 3);
        for sigma in [0.0, 1e-30, 1.0, 1e20] {
            for t_max in [0.0, 1.0, f32::INFINITY] {
                let m = medium([0.0; 3], [sigma, 0.0, sigma]);
                let left = m.transmittance(t_max);
                assert!(left.is_finite() && left.y == 1.0);
                for throughput in [Rgb::ONE, Rgb::Y, Rgb::ZERO, Rgb::INFINITY] {
                    let mut stream = sampler.stream(IVec2::ZERO, 7);
                    // Nothing is stopped in a channel that is not attenuated.
                    let ways = m.both_ways(t_max, throughput, &mut stream);
                    let may_stop = sigma > 0.0 && t_max > 0.0 && throughput != Rgb::Y;
                    assert_eq!(ways.is_some(), may_stop, "{sigma} {t_max} {throughput}");
                    let is_right = |ways: BothWays| {
                        ways.t <= t_max && ways.scattered.is_finite() && ways.passed == left
                    };
                    assert!(ways.is_none_or(is_right), "{sigma} {t_max} {throughput}");
                }
                for i in 0..64 {
                    let mut stream = sampler.stream(IVec2::ZERO, i);
                    let flight = m.sample(t_max, Rgb::ONE, &mut stream);
                    assert!(flight.weight.is_finite() && flight.weight.min_element() >= 0.0);
                    assert!(flight.scattered.is_none_or(|t| t < t_max));
                    assert!(sigma > 0.0 || flight.scattered.is_none());
                }
            }
        }
        // An infinite medium transmits nothing of an attenuated channel.
        assert_eq!(
            medium([1.0; 3], [0.0; 3]).transmittance(f32::INFINITY),
            Rgb::ZERO
        );
    }
}
