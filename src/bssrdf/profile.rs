//! Radial scattering profiles: how much light exits at a distance from where it entered, at one point of a surface.

use super::table::Row;
use crate::math::Rgb;
use std::f32::consts::PI;

/// Quantile of a profile up to which probes reach: beyond that distance pbrt-v3 does not look for exits, and neither do
/// we (a thousandth of the light is lost).
const REACH: f32 = 0.999;

/// The radial profile of each color channel. Distances are in scene units; densities are over the plane, per area, and
/// integrate to 1 unless a channel returns no light.
#[derive(Clone, Copy, Debug)]
pub enum Profile<'a> {
    /// From a table of photon beam diffusion.
    Tabulated([TabulatedChannel<'a>; 3]),
    /// Burley's normalized diffusion.
    Normalized([NormalizedChannel; 3]),
}

impl Profile<'_> {
    /// The value at distance `r`, in 1/area.
    pub fn value(&self, r: f32) -> Rgb {
        Rgb::from_array(match self {
            Profile::Tabulated(channels) => channels.map(|c| c.value(r)),
            Profile::Normalized(channels) => channels.map(|c| c.albedo * c.density(r)),
        })
    }

    /// The density of [`Profile::sample`] per area.
    pub fn pdf(&self, channel: usize, r: f32) -> f32 {
        match self {
            Profile::Tabulated(channels) => channels[channel].pdf(r),
            Profile::Normalized(channels) => channels[channel].density(r),
        }
    }

    /// Samples a distance for one channel; `None` if it returns no light. `u` in [0, 1).
    pub fn sample(&self, channel: usize, u: f32) -> Option<f32> {
        match self {
            Profile::Tabulated(channels) => channels[channel].sample(u),
            Profile::Normalized(channels) => channels[channel].sample(u),
        }
    }

    /// The distance beyond which a channel's exits are not sampled.
    pub fn reach(&self, channel: usize) -> Option<f32> {
        self.sample(channel, REACH)
    }
}

/// One color channel of a scattering medium.
#[derive(Clone, Copy, Debug)]
pub struct TabulatedChannel<'a> {
    row: Row<'a>,
    /// Mean free path in scene units, positive; infinite if the medium does nothing.
    mean_free_path: f32,
}

impl<'a> TabulatedChannel<'a> {
    /// A medium with this mean free path and the albedo of `row`. Mean free paths below `finest`, and NaN, are raised
    /// to it.
    pub fn new(row: Row<'a>, mean_free_path: f32, finest: f32) -> TabulatedChannel<'a> {
        TabulatedChannel {
            row,
            mean_free_path: mean_free_path.max(finest),
        }
    }

    /// Exitance E(r), per area.
    fn value(&self, r: f32) -> f32 {
        let optical = r / self.mean_free_path;
        if optical.is_nan() || optical <= 0.0 {
            return 0.0;
        }
        let square = self.mean_free_path * self.mean_free_path;
        self.row.density(optical) / (2.0 * PI * optical * square)
    }

    fn pdf(&self, r: f32) -> f32 {
        let whole = self.row.effective_albedo();
        if whole > 0.0 {
            self.value(r) / whole
        } else {
            0.0
        }
    }

    fn sample(&self, u: f32) -> Option<f32> {
        let r = self.row.sample(u)? * self.mean_free_path;
        r.is_finite().then_some(r)
    }
}

/// One color channel of Burley's approximation of measured and simulated profiles by two exponentials (Burley 2015,
/// "Extending the Disney BRDF to a BSDF"; Christensen and Burley 2015).
#[derive(Clone, Copy, Debug)]
pub struct NormalizedChannel {
    /// Fraction of the light that exits again.
    albedo: f32,
    /// Scale of the shorter exponential, in scene units; the other is three times as long.
    length: f32,
}

impl NormalizedChannel {
    /// Lengths below `finest`, and NaN, are raised to it.
    pub fn new(albedo: f32, length: f32, finest: f32) -> NormalizedChannel {
        NormalizedChannel {
            albedo: albedo.max(0.0),
            length: length.max(finest),
        }
    }

    /// A quarter of the light is in the shorter exponential.
    fn density(&self, r: f32) -> f32 {
        let d = self.length;
        if !(r > 0.0 && d.is_finite()) {
            return 0.0;
        }
        // The pole at 0 is integrable; this cuts off a millionth of the light.
        let r = r.max(1e-6 * d);
        ((-r / d).exp() + (-r / (3.0 * d)).exp()) / (8.0 * PI * d * r)
    }

    fn sample(&self, u: f32) -> Option<f32> {
        if !(self.albedo > 0.0 && self.length.is_finite()) {
            return None;
        }
        let (u, d) = if u < 0.25 {
            (4.0 * u, self.length)
        } else {
            ((u - 0.25) / 0.75, 3.0 * self.length)
        };
        Some(-d * (1.0 - u.min(1.0 - f32::EPSILON / 2.0)).ln())
    }
}

#[cfg(test)]
mod tests {
    use super::super::table::tests::water;
    use super::*;

    const FINEST: f32 = 1e-12;

    fn profiles() -> [(&'static str, Profile<'static>, [f32; 3]); 2] {
        let albedos = [0.3, 0.9, 0.99];
        let lengths = [1.0, 0.02, 40.0];
        let tabulated: [_; 3] = std::array::from_fn(|c| {
            TabulatedChannel::new(water().row(albedos[c]), lengths[c], FINEST)
        });
        let normalized =
            std::array::from_fn(|c| NormalizedChannel::new(albedos[c], lengths[c], FINEST));
        let effective = tabulated.map(|c| c.row.effective_albedo());
        [
            ("tabulated", Profile::Tabulated(tabulated), effective),
            ("normalized", Profile::Normalized(normalized), albedos),
        ]
    }

    /// ∫ f 2πr dr up to `end`, in equal steps of the square root of r.
    fn over_the_plane(end: f32, f: impl Fn(f32) -> f32) -> f64 {
        let steps = 100_000;
        let width = end.sqrt() / steps as f32;
        (0..steps)
            .map(|i| (i as f32 + 0.5) * width)
            .map(|s| f64::from(f(s * s) * 2.0 * PI * s * s * 2.0 * s * width))
            .sum()
    }

    #[test]
    fn densities_integrate_to_one_and_values_to_the_albedo() {
        for (name, profile, albedos) in profiles() {
            for (c, albedo) in albedos.into_iter().enumerate() {
                let end = 60.0 * profile.sample(c, 0.5).unwrap();
                let density = over_the_plane(end, |r| profile.pdf(c, r));
                let value = over_the_plane(end, |r| profile.value(r)[c]) as f32;
                // The tail beyond 60 medians, and single precision.
                assert!((density - 1.0).abs() < 2e-3, "{name} {c}: {density}");
                assert!(
                    (value - albedo).abs() < 2e-3 * albedo,
                    "{name} {c}: {value}"
                );
            }
        }
    }

    #[test]
    fn distances_follow_their_density() {
        for (name, profile, _) in profiles() {
            for c in 0..3 {
                // Quantiles of the two exponentials are not monotonic in u, so count instead.
                let n = 2000;
                let median = profile.sample(c, 0.5).unwrap();
                let drawn = (0..n).map(|k| profile.sample(c, (k as f32 + 0.5) / n as f32).unwrap());
                let nearer = drawn.filter(|&r| r < median).count() as f64 / f64::from(n);
                let expected = over_the_plane(median, |r| profile.pdf(c, r));
                assert!(
                    (nearer - expected).abs() < 2e-3,
                    "{name} {c}: {nearer} for {expected}"
                );
            }
        }
    }

    #[test]
    fn media_without_extent_or_without_end_do_no_harm() {
        for length in [0.0, -1.0, f32::NAN, f32::INFINITY, 1e-30, 1e30] {
            let channels = [
                Profile::Tabulated([TabulatedChannel::new(water().row(0.5), length, FINEST); 3]),
                Profile::Normalized([NormalizedChannel::new(0.5, length, FINEST); 3]),
            ];
            for profile in channels {
                for r in [0.0, 1e-20, 1.0, 1e20, f32::INFINITY, f32::NAN] {
                    assert!(profile.value(r).is_finite(), "{length} {r}");
                    assert!(profile.pdf(0, r) >= 0.0);
                }
                assert!(
                    profile
                        .sample(0, 0.7)
                        .is_none_or(|r| r >= 0.0 && r.is_finite())
                );
            }
        }
    }
}
