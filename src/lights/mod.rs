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
mod even_sky;
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
