//! The `heterogeneous` medium: density given on a grid in a box.
//!
//! Besides the parameters of [`homogeneous`](super::homogeneous), which apply to density 1: `nx`, `ny`, `nz` (integer,
//! 1): resolution. `density` (floats, required): nx·ny·nz values, x varying fastest. `p0` (point, (0,0,0)), `p1`
//! (point, (1,1,1)): corners of the box, under the current transformation. Outside the box there is no medium. σₐ + σₛ
//! must be the same in all channels; otherwise red's is used for all, as in pbrt-v3.
//!
//! Free paths are sampled by delta tracking (Woodcock et al. 1965), transmittance is estimated by ratio tracking
//! (Novák, Selle and Jarosz 2014), both with local majorants for parts of the box.
//! Source: Pharr, Jakob and Humphreys 2016, §11.3.2 and §15.2.2; docs/scene-language.md §3.12.

use super::boxes::{self, BoxSpace};
use super::density_grid::{self, DensityGrid};
use super::numbers::Numbers;
use super::presets::Coefficients;
use super::{Flight, HenyeyGreenstein, common};
use crate::math::ray::Ray;
use crate::math::transform::Transform;
use crate::math::{DVec3, Rgb, Vec3};
use crate::params::ParamReader;
use crate::samplers::SampleStream;

/// Transmittance below which ratio tracking uses Russian roulette, as in pbrt-v3.
const ROULETTE_BELOW: f32 = 0.1;

/// The parameters of `MakeNamedMedium`.
#[derive(Clone, Debug, PartialEq)]
pub struct HeterogeneousSpec {
    sigma_s: Rgb,
    /// The extinction coefficient for density 1, the same in all channels.
    sigma_t: f32,
    phase: HenyeyGreenstein,
    grid: DensityGrid,
    /// From the unit cube to world space.
    world_from_grid: Transform,
}

impl HeterogeneousSpec {
    /// Reads the parameters under the transformation `world_from_medium`. `None`, after reporting an error, if the
    /// densities are missing or their number is not that of the voxels.
    pub fn from_params(
        reader: &ParamReader,
        world_from_medium: &Transform,
    ) -> Option<HeterogeneousSpec> {
        let coefficients = common::coefficients(reader);
        let phase = common::phase(reader);
        let [p0, p1] = [("p0", DVec3::ZERO), ("p1", DVec3::ONE)].map(|(n, p)| reader.point3(n, p));
        let world_from_grid =
            *world_from_medium * Transform::translate(p0) * Transform::scale(p1 - p0);
        let resolution = density_grid::resolution(reader);
        let sigma_t = uniform_extinction(reader, coefficients);
        let grid = DensityGrid::from_params(reader, resolution, sigma_t, &world_from_grid)?;
        if !world_from_grid.is_invertible() {
            reader.warn(
                "p1",
                "the medium's box has no volume: there is nothing in it",
            );
        }
        Some(HeterogeneousSpec {
            sigma_s: coefficients.sigma_s,
            sigma_t,
            phase,
            grid,
            world_from_grid,
        })
    }
}

/// The extinction coefficient of all channels.
fn uniform_extinction(reader: &ParamReader, coefficients: Coefficients) -> f32 {
    let sigma_t = coefficients.sigma_t();
    // A unit in the last place is not a difference: sums of decimal numbers are rounded.
    let spread = sigma_t.max_element() - sigma_t.min_element();
    if spread > 2.0 * f32::EPSILON * sigma_t.max_element() {
        let [r, g, b] = sigma_t.to_array();
        let message = format!(
            "`sigma_a` + `sigma_s` of a heterogeneous medium should be the same in all channels, \
             found ({r}, {g}, {b}): red's is used for all, as in pbrt-v3"
        );
        reader.warn("sigma_a", message);
    }
    sigma_t.x
}

/// A medium of varying density, in render space.
#[derive(Clone, Debug)]
pub struct Heterogeneous {
    albedo: Rgb,
    sigma_t: f32,
    /// The phase function.
    pub(super) phase: HenyeyGreenstein,
    grid: DensityGrid,
    space: BoxSpace,
}

/// The segment of a ray inside the box, in the grid's space.
struct Chord {
    o: Vec3,
    d: Vec3,
    /// Distance at which the ray enters.
    start: f64,
    length: f32,
}

impl Heterogeneous {
    /// Places the medium in render space.
    pub fn new(spec: HeterogeneousSpec, render_from_world: &Transform) -> Heterogeneous {
        let placed = (*render_from_world * spec.world_from_grid).with_translations_matched();
        let albedo = spec.sigma_s / spec.sigma_t;
        // Without extinction or volume the medium is empty.
        let empty = !(placed.is_invertible() && albedo.is_finite());
        Heterogeneous {
            albedo: if empty { Rgb::ZERO } else { albedo },
            sigma_t: if empty { 0.0 } else { spec.sigma_t },
            phase: spec.phase,
            grid: spec.grid,
            space: BoxSpace::new(&placed),
        }
    }

    /// The segment of the ray inside the box, before `t_max`.
    fn chord(&self, ray: &Ray, t_max: f32) -> Option<Chord> {
        let boxes::Chord { o, d, start, end } = self.space.chord(ray, f64::from(t_max))?;
        let chord = Chord {
            o: (o + d * start).as_vec3(),
            d: d.as_vec3(),
            start,
            length: (end - start) as f32,
        };
        // A box too small or too far away for single precision is ignored.
        let passes = self.sigma_t > 0.0 && chord.o.is_finite() && chord.d.is_finite();
        passes.then_some(chord)
    }

    /// Delta tracking: goes from one tentative collision to the next along the chord, and gives each one's distance,
    /// the density there and its local majorant to `collide`, until this has a result.
    #[inline]
    fn track<T>(
        &self,
        chord: &Chord,
        numbers: &mut Numbers,
        mut collide: impl FnMut(&mut Numbers, f32, f32, f32) -> Option<T>,
    ) -> Option<T> {
        for piece in self.grid.majorants().along(chord.o, chord.d, chord.length) {
            let majorant = piece.majorant * self.sigma_t;
            if majorant <= 0.0 {
                continue;
            }
            let mut t = piece.start;
            loop {
                t += numbers.step() / majorant;
                if t >= piece.end {
                    break;
                }
                let density = self.grid.density(chord.o + chord.d * t);
                let result = collide(numbers, t, density, piece.majorant);
                if result.is_some() {
                    return result;
                }
            }
        }
        None
    }

    /// An unbiased estimate of the transmittance up to the distance `t_max`.
    pub fn transmittance(&self, ray: &Ray, t_max: f32, stream: &mut SampleStream) -> f32 {
        let Some(chord) = self.chord(ray, t_max) else {
            return 1.0;
        };
        let mut left = 1.0f32;
        let lost = self.track(
            &chord,
            &mut Numbers::new(stream),
            |numbers, _, density, majorant| {
                left *= (1.0 - density / majorant).clamp(0.0, 1.0);
                if left < ROULETTE_BELOW {
                    // Russian roulette: survives with probability `left` / 0.1, and then counts as 0.1.
                    if numbers.next() * ROULETTE_BELOW >= left {
                        return Some(0.0);
                    }
                    left = ROULETTE_BELOW;
                }
                None
            },
        );
        lost.unwrap_or(left)
    }

    /// Samples a free path before `t_max`, where the ray ends.
    pub fn sample(&self, ray: &Ray, t_max: f32, stream: &mut SampleStream) -> Flight {
        let Some(chord) = self.chord(ray, t_max) else {
            return Flight::UNDISTURBED;
        };
        let scattered = self.track(
            &chord,
            &mut Numbers::new(stream),
            |numbers, t, density, majorant| (density > numbers.next() * majorant).then_some(t),
        );
        scattered.map_or(Flight::UNDISTURBED, |t| Flight {
            scattered: Some((chord.start + f64::from(t)) as f32),
            weight: self.albedo,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::IVec2;
    use crate::params::testing::{Outcome, read};
    use crate::samplers::{Sampler, SamplerSpec};

    fn spec(params: &str) -> Outcome<Option<HeterogeneousSpec>> {
        let text = format!("\"rgb sigma_a\" [1 1 1] \"rgb sigma_s\" [3 3 3] {params}");
        read("heterogeneous", &text, |reader| {
            HeterogeneousSpec::from_params(reader, &Transform::IDENTITY)
        })
    }

    /// A cloud with a hole: 20 × 3 × 7 voxels, more than the majorants have cells in one axis.
    fn cloud() -> Heterogeneous {
        let values: Vec<String> = (0..20 * 3 * 7)
            .map(|i| {
                let v = if i % 20 > 8 && i % 20 < 13 {
                    0
                } else {
                    i * 7919 % 13
                };
                v.to_string()
            })
            .collect();
        let params = format!(
            "\"integer nx\" 20 \"integer ny\" 3 \"integer nz\" 7 \"float density\" [{}] \
             \"point p0\" [-1 -1 -1] \"point p1\" [1 2 1] \"float scale\" .1",
            values.join(" ")
        );
        let turned = Transform::rotate(30.0, DVec3::ONE);
        Heterogeneous::new(spec(&params).value.unwrap(), &turned)
    }

    /// Origin, direction, end distance, and a point halfway through the cloud.
    const RAYS: [([f32; 3], [f32; 3], f32, f32); 4] = [
        ([-4.0, 0.1, 0.2], [1.0, 0.05, 0.02], f32::INFINITY, 4.4),
        ([0.1, 0.5, 0.0], [0.5, 0.3, 0.8], f32::INFINITY, 0.6),
        ([3.0, 3.0, 3.0], [-1.0, -0.9, -1.0], 4.6, 4.0),
        ([0.0, 0.0, -5.0], [0.0, 0.0, 1.0], 5.5, 5.2),
    ];

    fn ray(o: [f32; 3], d: [f32; 3]) -> Ray {
        Ray::new(o.into(), Vec3::from(d).normalize(), 0.0)
    }

    /// ∫ σₜ along the ray by the midpoint rule.
    fn depth(medium: &Heterogeneous, ray: &Ray, t_max: f32) -> f64 {
        let (n, end) = (100_000, t_max.min(12.0));
        let step = f64::from(end) / f64::from(n);
        let density = |i: i32| {
            let t = (f64::from(i) + 0.5) * step;
            let p = ray.o.as_dvec3() + ray.d.as_dvec3() * t;
            let q = medium.space.0.transform_point3(p).as_vec3();
            let inside = q.cmpge(Vec3::ZERO).all() && q.cmple(Vec3::ONE).all();
            if inside {
                f64::from(medium.grid.density(q))
            } else {
                0.0
            }
        };
        (0..n).map(density).sum::<f64>() * step * f64::from(medium.sigma_t)
    }

    #[test]
    fn tracking_agrees_with_the_integral_of_the_density() {
        let medium = cloud();
        let n = 40_000;
        let sampler = Sampler::new(&SamplerSpec::random(n), 5);
        for (o, d, t_max, half) in RAYS {
            let ray = ray(o, d);
            let expected = (-depth(&medium, &ray, t_max)).exp();
            assert!(
                (0.01..0.9).contains(&expected),
                "a test that shows something: {expected}"
            );
            let (mut ratio, mut passed) = (0.0, 0.0);
            // The distribution of scattering distances, against the integral up to there.
            let mut before = 0.0;
            for i in 0..n {
                let mut stream = sampler.stream(IVec2::ZERO, i);
                ratio += f64::from(medium.transmittance(&ray, t_max, &mut stream));
                let flight = medium.sample(&ray, t_max, &mut stream);
                match flight.scattered {
                    Some(t) => {
                        assert!(t > 0.0 && t < t_max);
                        assert!((flight.weight - Rgb::splat(0.75)).length() < 1e-6);
                        before += f64::from(u8::from(t < half));
                    }
                    None => passed += 1.0,
                }
            }
            // Four standard errors of values between 0 and 1.
            let allowed = 4.0 * 0.5 / f64::from(n).sqrt();
            let n = f64::from(n);
            assert!(
                (ratio / n - expected).abs() < allowed,
                "{} but {expected}",
                ratio / n
            );
            assert!(
                (passed / n - expected).abs() < allowed,
                "{} but {expected}",
                passed / n
            );
            let expected = 1.0 - (-depth(&medium, &ray, half)).exp();
            assert!(
                (before / n - expected).abs() < allowed,
                "{} but {expected}",
                before / n
            );
        }
    }

    #[test]
    fn odd_grids_have_a_meaning() {
        for (params, warnings) in [
            ("\"float density\" 1", 0),
            ("\"float density\" 0", 0),
            ("\"float density\" -3", 1),
            ("\"float density\" 1e30", 1),
            ("\"integer nx\" 3 \"float density\" [1 1e300 -1e300]", 2),
            ("\"float density\" 1 \"point p1\" [0 1 1]", 1),
            ("\"float density\" 1 \"point p1\" [1e-30 1e-30 1e-30]", 0),
            ("\"float density\" 1 \"point p1\" [-2 1 1]", 0),
            ("\"float density\" 1 \"float scale\" 0", 0),
            (
                "\"float density\" 1 \"rgb sigma_s\" [0 0 0] \"rgb sigma_a\" [0 1 0]",
                1,
            ),
            ("\"float density\" 1 \"float scale\" 1e19", 1),
        ] {
            let outcome = spec(params);
            assert_eq!(
                (outcome.errors, outcome.warnings),
                (0, warnings),
                "{params}: {}",
                outcome.text
            );
            let medium = Heterogeneous::new(outcome.value.unwrap(), &Transform::IDENTITY);
            let sampler = Sampler::new(&SamplerSpec::random(20), 5);
            for (o, d, t_max, _) in RAYS {
                let ray = ray(o, d);
                for i in 0..20 {
                    let mut stream = sampler.stream(IVec2::ZERO, i);
                    let left = medium.transmittance(&ray, t_max, &mut stream);
                    assert!((0.0..=1.0).contains(&left), "{params}: {left}");
                    let flight = medium.sample(&ray, t_max, &mut stream);
                    assert!(flight.weight.is_finite() && flight.weight.min_element() >= 0.0);
                    assert!(flight.scattered.is_none_or(|t| t >= 0.0 && t <= t_max));
                }
            }
        }
    }

    #[test]
    fn what_makes_no_grid_is_an_error() {
        for params in [
            "",
            "\"float density\" []",
            "\"float density\" [1 2] \"integer nx\" 3",
            "\"float density\" [1 2] \"integer nx\" 2147483647 \"integer ny\" 2147483647 \"integer nz\" 2147483647",
        ] {
            let outcome = spec(params);
            assert!(
                outcome.value.is_none() && outcome.errors == 1,
                "{params}: {}",
                outcome.text
            );
        }
        let outcome = spec("\"float density\" 1 \"integer nx\" -5");
        assert!(outcome.value.is_some() && outcome.warnings == 1);
    }
}
