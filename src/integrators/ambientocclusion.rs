//! `Integrator "ambientocclusion"`: how open the surroundings of a point are (Zhukov, Iones and
//! Kronin 1998; Pharr, Jakob and Humphreys 2016, §14.3, exercise 14.1; docs/scene-language.md §3.5).
//!
//! `cossample` (bool, true): cosine-weighted directions, else uniform ones: noise only.
//! `nsamples` (integer, 64): directions per point.
//!
//! The value is ∫ V cosθ dω over the hemisphere of the true surface, V = 1 where nothing occludes:
//! π for an open point, as in pbrt-v3, which does not divide by π. Rays that miss everything are
//! black. Rays pass surfaces without material; other materials do not matter.
//!
//! pbrt-v2's integrator of that name instead shows the free fraction of uniformly chosen
//! directions: `nsamples` (2048), `maxdist` (∞): nothing farther occludes.

use super::witness::Met;
use super::{Context, MAX_NULL_SURFACES, Path, Transport};
use crate::math::frame::Frame;
use crate::math::sampling::cosine_hemisphere;
use crate::math::{Rgb, Vec2, Vec3};
use crate::params::ParamReader;
use crate::surface::SurfaceHit;
use std::f32::consts::PI;

/// The most directions per point: their error is 0.2 %.
const MAX: i64 = 65_536;

/// How directions are sampled, and the value of an unoccluded one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Directions {
    /// With density cosθ/π: π each.
    Cosine,
    /// Uniform: 2π cosθ each.
    Uniform,
    /// Uniform: 1 each (pbrt-v2).
    UniformFraction,
}

/// Parameters of `Integrator "ambientocclusion"`.
#[derive(Clone, Debug, PartialEq)]
pub struct AmbientOcclusion {
    /// `cossample`, and the dialect.
    pub directions: Directions,
    /// `nsamples`, from 1 to 65536.
    pub samples: u32,
    /// `maxdist`: nothing farther occludes.
    pub max_distance: f32,
}

impl AmbientOcclusion {
    /// Reads the parameters.
    pub fn from_params(reader: &ParamReader) -> AmbientOcclusion {
        AmbientOcclusion {
            directions: if !reader.offers("cossample") {
                Directions::UniformFraction
            } else if reader.boolean("cossample", true) {
                Directions::Cosine
            } else {
                Directions::Uniform
            },
            samples: reader.integer_within("nsamples", 64, 1..=MAX) as u32,
            max_distance: reader.float("maxdist", f64::INFINITY) as f32,
        }
    }

    /// Fewer samples, as pbrt-v2 (a quarter) and v3 (one) take under `--quick`.
    pub fn make_quick(&mut self) {
        self.samples = match self.directions {
            Directions::UniformFraction => (self.samples / 4).max(1),
            Directions::Cosine | Directions::Uniform => 1,
        };
    }

    /// The estimate at one point, on the side that the camera ray hits.
    fn openness(&self, context: &mut Context, surface: &SurfaceHit) -> f32 {
        let frame = Frame::from_normal(if surface.n.dot(surface.wo) < 0.0 {
            -surface.n
        } else {
            surface.n
        });
        let mut sum = 0.0;
        for _ in 0..self.samples {
            let (wi, value) = self.direction(context.stream.next_2d());
            let mut ray = surface.spawn_ray(frame.to_world(wi));
            ray.t_max = self.max_distance;
            context.occlusion();
            if !context.world.occluded(&ray) {
                sum += value;
            }
        }
        sum / self.samples as f32
    }

    /// A direction about +z, and its value if unoccluded.
    fn direction(&self, u: Vec2) -> (Vec3, f32) {
        if self.directions == Directions::Cosine {
            return (cosine_hemisphere(u), PI);
        }
        let z = u.x;
        let (sin_phi, cos_phi) = (2.0 * PI * u.y).sin_cos();
        let r = (1.0 - z * z).max(0.0).sqrt();
        let value = match self.directions {
            Directions::UniformFraction => 1.0,
            _ => 2.0 * PI * z,
        };
        (Vec3::new(r * cos_phi, r * sin_phi, z), value)
    }
}

impl Transport for AmbientOcclusion {
    /// No vertex is reported: the value is always finite.
    fn radiance(&self, mut context: Context) -> Rgb {
        let mut ray = *context.ray();
        for _ in 0..=MAX_NULL_SURFACES {
            let Some(hit) = context.world.intersect(&ray) else {
                context.arrive(0, Met::Background, Rgb::ZERO);
                return Rgb::ZERO;
            };
            context.arrive(0, Met::Surface(hit.material), Rgb::ZERO);
            if hit.material.is_some() {
                let open = Rgb::splat(self.openness(&mut context, &hit.surface));
                context.part(None, open);
                return open;
            }
            ray = hit.surface.spawn_ray(ray.d);
        }
        Rgb::ZERO
    }

    fn path(&self) -> Option<Path> {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::params::Dialect;
    use crate::params::testing::{Surroundings, read, read_in};

    /// Free all around: π, and 1 in pbrt-v2.
    #[test]
    fn an_open_point_counts_the_hemisphere() {
        for (directions, expected) in [
            (Directions::Cosine, PI),
            (Directions::Uniform, PI),
            (Directions::UniformFraction, 1.0),
        ] {
            let ambient = AmbientOcclusion {
                directions,
                samples: 1,
                max_distance: f32::INFINITY,
            };
            let (n, mut sum, mut up) = (200, 0.0, Vec3::ZERO);
            for i in 0..n * n {
                let u = Vec2::new((i % n) as f32 + 0.5, (i / n) as f32 + 0.5) / n as f32;
                let (wi, value) = ambient.direction(u);
                assert!(wi.z >= 0.0 && (wi.length() - 1.0).abs() < 1e-5);
                sum += f64::from(value) / f64::from(n * n);
                up += wi / (n * n) as f32;
            }
            // A midpoint sum of 200² points, in single precision.
            assert!(
                (sum - f64::from(expected)).abs() < 1e-4,
                "{directions:?}: {sum}"
            );
            let mean_height = if directions == Directions::Cosine {
                2.0 / 3.0
            } else {
                0.5
            };
            assert!((up - Vec3::new(0.0, 0.0, mean_height)).length() < 1e-3);
        }
    }

    #[test]
    fn parameters_follow_the_dialect() {
        let v3 = read("ambientocclusion", "\"bool cossample\" \"false\"", |r| {
            AmbientOcclusion::from_params(r)
        });
        assert_eq!(
            (v3.value.directions, v3.value.samples),
            (Directions::Uniform, 64)
        );
        let v2 = Surroundings {
            dialect: Dialect::V2,
            word: "Integrator",
            ..Surroundings::default()
        };
        let v2 = read_in(&v2, "ambientocclusion", "\"float maxdist\" 3", |r| {
            AmbientOcclusion::from_params(r)
        });
        assert_eq!((v2.value.max_distance, v2.value.samples), (3.0, 2048));
        assert_eq!(v2.value.directions, Directions::UniformFraction);
        let none = read("ambientocclusion", "\"integer nsamples\" 0", |r| {
            AmbientOcclusion::from_params(r)
        });
        assert_eq!((none.value.samples, none.warnings), (1, 1));
        let endless = read("ambientocclusion", "\"integer nsamples\" 2000000000", |r| {
            AmbientOcclusion::from_params(r)
        });
        assert_eq!((endless.value.samples, endless.warnings), (65_536, 1));
    }
}
