//! Light sources: what `LightSource` and `AreaLightSource` make, how light is sampled from them,
//! and how one of them is chosen.
//!
//! A *spec* holds a directive's parameters in world space; a *light* is the compiled form in
//! render space. All radiances are linear RGB.

pub mod diffuse;
pub mod distant;
pub mod emission;
mod emission_guide;
mod emitter_choice;
pub mod environment_map;
pub mod goniometric;
pub mod groups;
pub mod infinite;
mod kinds;
mod lanes;
mod light_bounds;
pub mod light_map;
mod light_tree;
mod light_type;
mod map_density;
pub mod point;
pub mod projection;
mod sample_count;
pub mod selection;
pub mod sky_density;
mod small_light_set;
pub mod spot;
mod strength;
mod tree;

pub(crate) use diffuse::Glow;
pub use diffuse::{DiffuseAreaLight, DiffuseAreaSpec};
pub use distant::{DistantLight, DistantSpec};
pub use emission::{Emission, EmissionDensity, LightEnd, SceneSphere};
pub use emission_guide::{EmissionGuide, RayNumbers, place_of_ray};
pub use emitter_choice::EmitterChoice;
pub use goniometric::{GoniometricLight, GoniometricSpec};
pub use groups::{LightGroup, LightGroups};
pub use infinite::{InfiniteLight, InfiniteSpec};
pub use kinds::{Light, LightKind};
pub use light_map::LightMap;
pub use point::{PointLight, PointSpec};
pub use projection::{ProjectionLight, ProjectionSpec};
pub use selection::{LightSelector, Selected, SelectionStrategy};
pub use spot::{SpotLight, SpotSpec};

use crate::math::color::is_black;
use crate::math::ray::Ray;
use crate::math::transform::Transform;
use crate::math::{Rgb, Vec2, Vec3};
use crate::params::{NamedFile, ParamReader};
use crate::surface::{ReferencePoint, SurfaceHit};
use glam::DMat3;
use light_bounds::LightBounds;
use light_type::LightType;
use point::sample_point;
use std::f32::consts::PI;
use strength::strength;

/// Bytes that a light of many takes while the tree is built by which they are chosen.
pub const MEMORY_OF_EMITTER: u64 = (size_of::<Light>() + light_tree::MEMORY_OF_LIGHT) as u64;

/// What is done about a light that cannot be made.
const LEFT_OUT: &str = "the light is left out";

/// What a `LightSource` directive asks for, in world space.
#[derive(Clone, Debug, PartialEq)]
pub struct LightSpec {
    /// The type with its parameters.
    pub kind: LightKind,
    /// `mapname`: the image that shapes the light.
    pub map: Option<NamedFile>,
}

impl LightSpec {
    /// A quarter of the samples at each point, for a quick look (`--quick`).
    pub fn make_quick(&mut self) {
        if let LightKind::Infinite(infinite) = &mut self.kind {
            infinite.samples = sample_count::quick(infinite.samples);
        }
    }

    /// The type's name, where no ray can meet the light by chance and it shines at all.
    pub fn delta_name(&self) -> Option<&'static str> {
        let light = Light::new(self, None, &Transform::IDENTITY);
        (light.is_delta() && !is_black(light.power(1.0))).then_some(self.name())
    }
}

/// The linear part of a transformation, of volume 1: freed from the scene's units so that nothing overflows.
fn of_volume_1(transform: &Transform) -> DMat3 {
    let m = DMat3::from_mat4(transform.m);
    m * (1.0 / m.determinant().abs().cbrt())
}

/// The azimuth from +x toward +y as a fraction of a full turn, in [0, 1]; absolute error below 2e-7. The arc tangent on [0, 1] is the polynomial of
/// Abramowitz and Stegun 1964, 4.4.49: faster than a call of `atan2`.
fn turns(x: f32, y: f32) -> f32 {
    let (low, high) = (x.abs().min(y.abs()), x.abs().max(y.abs()));
    let t = if high > 0.0 { low / high } else { 0.0 };
    let t2 = t * t;
    let factors = [
        0.002_866_225_7,
        -0.016_165_737,
        0.042_909_614,
        -0.075_289_64,
        0.106_562_64,
        -0.142_089,
        0.199_935_51,
        -0.333_331_45,
        1.0,
    ];
    let angle = t * factors.iter().fold(0.0, |sum, factor| sum * t2 + factor);
    let octant = angle * (0.5 / PI);
    let quadrant = if y.abs() > x.abs() {
        0.25 - octant
    } else {
        octant
    };
    let half = if x < 0.0 { 0.5 - quadrant } else { quadrant };
    if y < 0.0 { 1.0 - half } else { half }
}

/// One way for light to come to a point.
#[derive(Clone, Copy, Debug)]
pub struct LightSample {
    /// Radiance arriving along `wi` if nothing is in the way; for delta lights intensity over
    /// squared distance, or irradiance on a facing surface.
    pub radiance: Rgb,
    /// Unit direction toward the light.
    pub wi: Vec3,
    /// Density per solid angle; 1 for delta lights.
    pub pdf: f32,
    /// True where no other direction could have been chosen.
    pub delta: bool,
    /// The ray that must be free for the light to arrive.
    pub shadow: Ray,
}

impl LightSample {
    /// The only way for light to come; `None` where none comes.
    fn only(radiance: Rgb, wi: Vec3, shadow: impl FnOnce() -> Ray) -> Option<LightSample> {
        (!is_black(radiance)).then(|| LightSample {
            radiance,
            wi,
            pdf: 1.0,
            delta: true,
            shadow: shadow(),
        })
    }

    /// As one of many ways, of this density.
    fn with_pdf(self, pdf: f32) -> LightSample {
        LightSample {
            pdf,
            delta: false,
            ..self
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::hash::{mix2, unit_float};

    #[test]
    fn turns_are_those_of_the_arc_tangent() {
        let coordinate = |i: u64, k: u64| 2.0 * unit_float(mix2(i, k)) - 1.0;
        let edges = [-1.0, -0.0, 0.0, 1.0, 1e-30, -1e-30];
        let edges = edges.map(|x| edges.map(|y| (x, y)));
        let random = (0..100_000).map(|i| (coordinate(i, 0), coordinate(i, 1)));
        for (x, y) in edges.into_iter().flatten().chain(random) {
            let expected = f64::from(y).atan2(x.into()) / std::f64::consts::TAU;
            let error = f64::from(turns(x, y)) - expected;
            // A turn more or less is the same azimuth.
            let error = (error - error.round()).abs();
            assert!((x, y) == (0.0, 0.0) || error < 2e-7, "{x} {y} {error}");
        }
    }
}
