//! Light sources: what `LightSource` and `AreaLightSource` make, how light is sampled from them,
//! and how one of them is chosen.
//!
//! A *spec* holds a directive's parameters in world space; a *light* is the compiled form in
//! render space. All radiances are linear RGB.

pub mod diffuse;
pub mod distant;
pub mod environment_map;
pub mod goniometric;
pub mod groups;
pub mod infinite;
mod lanes;
mod light_bounds;
pub mod light_map;
mod light_tree;
pub mod point;
pub mod projection;
mod sample_count;
pub mod selection;
pub mod sky_density;
mod small_light_set;
pub mod spot;
mod strength;
mod tree;

pub use diffuse::{DiffuseAreaLight, DiffuseAreaSpec};
pub use distant::{DistantLight, DistantSpec};
pub use goniometric::{GoniometricLight, GoniometricSpec};
pub use groups::{LightGroup, LightGroups};
pub use infinite::{InfiniteLight, InfiniteSpec};
pub use light_map::LightMap;
pub use point::{PointLight, PointSpec};
pub use projection::{ProjectionLight, ProjectionSpec};
pub use selection::{LightSelector, SelectionStrategy};
pub use spot::{SpotLight, SpotSpec};

use crate::math::color::is_black;
use crate::math::ray::Ray;
use crate::math::transform::Transform;
use crate::math::{Rgb, Vec2, Vec3};
use crate::params::{NamedFile, ParamReader};
use crate::surface::{ReferencePoint, SurfaceHit};
use glam::{DMat3, Mat3};
use light_bounds::LightBounds;

/// The `LightSource` type names a scene may give, for "did you mean".
pub const LIGHT_NAMES: [&str; 7] = [
    "distant",
    "exinfinite",
    "goniometric",
    "infinite",
    "point",
    "projection",
    "spot",
];

/// What is done about a light that cannot be made.
const LEFT_OUT: &str = "the light is left out";

/// What a `LightSource` directive asks for, in world space.
#[derive(Clone, Debug, PartialEq)]
pub enum LightSpec {
    /// An isotropic point.
    Point(PointSpec),
    /// A cone of light.
    Spot(SpotSpec),
    /// Parallel light.
    Distant(DistantSpec),
    /// Light from all around.
    Infinite(InfiniteSpec),
    /// A point whose intensity an image gives.
    Goniometric(GoniometricSpec),
    /// A slide projector.
    Projection(ProjectionSpec),
}

impl LightSpec {
    /// Reads a `LightSource` under the transformation `light_to_world`. `None`, after a report,
    /// where no light can be made of it.
    pub fn from_params(reader: &ParamReader, light_to_world: &Transform) -> Option<LightSpec> {
        if !light_to_world.is_invertible() {
            reader.accept_all();
            reader.error(
                "",
                "the transformation of this light source cannot be inverted; the light is left out",
            );
            return None;
        }
        match reader.kind() {
            "point" => Some(LightSpec::Point(PointSpec::from_params(
                reader,
                light_to_world,
            ))),
            "spot" => Some(LightSpec::Spot(SpotSpec::from_params(
                reader,
                light_to_world,
            ))),
            "distant" => Some(LightSpec::Distant(DistantSpec::from_params(
                reader,
                light_to_world,
            ))),
            "infinite" | "exinfinite" => Some(LightSpec::Infinite(InfiniteSpec::from_params(
                reader,
                light_to_world,
            ))),
            "goniometric" => Some(LightSpec::Goniometric(GoniometricSpec::from_params(
                reader,
                light_to_world,
            ))),
            "projection" => Some(LightSpec::Projection(ProjectionSpec::from_params(
                reader,
                light_to_world,
            ))),
            _ => {
                reader.unknown_kind_replaced(&LIGHT_NAMES, LEFT_OUT);
                None
            }
        }
    }

    /// A quarter of the samples at each point, for a quick look (`--quick`).
    pub fn make_quick(&mut self) {
        if let LightSpec::Infinite(infinite) = self {
            infinite.samples = sample_count::quick(infinite.samples);
        }
    }

    /// The type's name, where no ray can meet the light by chance and it shines at all.
    pub fn delta_name(&self) -> Option<&'static str> {
        let (name, strength) = match self {
            LightSpec::Point(s) => ("point", s.intensity),
            LightSpec::Spot(s) => ("spot", s.intensity),
            LightSpec::Distant(s) => ("distant", s.irradiance),
            LightSpec::Goniometric(s) => ("goniometric", s.intensity),
            LightSpec::Projection(s) => ("projection", s.intensity),
            LightSpec::Infinite(_) => return None,
        };
        (!is_black(strength)).then_some(name)
    }

    /// The image that shapes the light.
    pub fn map(&self) -> Option<&NamedFile> {
        match self {
            LightSpec::Infinite(s) => s.map.as_ref(),
            LightSpec::Goniometric(s) => s.map.as_ref(),
            LightSpec::Projection(s) => s.map.as_ref(),
            LightSpec::Point(_) | LightSpec::Spot(_) | LightSpec::Distant(_) => None,
        }
    }
}

/// The linear part of render-to-light, freed from the scene's units so that nothing overflows.
fn light_from_render(render_from_light: &Transform) -> Mat3 {
    let m = DMat3::from_mat4(render_from_light.m);
    let m = m * (1.0 / m.determinant().abs().cbrt());
    m.inverse().as_mat3()
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

/// A light source in render space.
#[derive(Clone, Debug)]
pub enum Light {
    /// An isotropic point.
    Point(PointLight),
    /// A cone of light.
    Spot(SpotLight),
    /// Parallel light.
    Distant(DistantLight),
    /// A shape that emits.
    DiffuseArea(DiffuseAreaLight),
    /// Light from all around.
    Infinite(InfiniteLight),
    /// A point whose intensity an image gives.
    Goniometric(GoniometricLight),
    /// A slide projector.
    Projection(ProjectionLight),
}

impl Light {
    /// The light of a `LightSource`. `map` is the image of one that names one
    /// ([`LightSpec::map`]) and whose file could be read.
    pub fn new(spec: &LightSpec, map: Option<LightMap>, render_from_world: &Transform) -> Light {
        match spec {
            LightSpec::Point(s) => Light::Point(PointLight::new(s, render_from_world)),
            LightSpec::Spot(s) => Light::Spot(SpotLight::new(s, render_from_world)),
            LightSpec::Distant(s) => Light::Distant(DistantLight::new(s, render_from_world)),
            LightSpec::Infinite(s) => {
                Light::Infinite(InfiniteLight::new(s, map, render_from_world))
            }
            LightSpec::Goniometric(s) => {
                Light::Goniometric(GoniometricLight::new(s, map, render_from_world))
            }
            LightSpec::Projection(s) => {
                Light::Projection(ProjectionLight::new(s, map, render_from_world))
            }
        }
    }

    /// Chooses a way for light to come to `from`, by `u` in [0, 1)². `None` where none was found:
    /// it counts as a sample that brings nothing.
    #[inline]
    pub fn sample(&self, from: &ReferencePoint, u: Vec2) -> Option<LightSample> {
        match self {
            Light::Point(l) => l.sample(from),
            Light::Spot(l) => l.sample(from),
            Light::Distant(l) => l.sample(from),
            Light::DiffuseArea(l) => l.sample(from, u),
            Light::Infinite(l) => l.sample(from, u),
            Light::Goniometric(l) => l.sample(from),
            Light::Projection(l) => l.sample(from),
        }
    }

    /// Density per solid angle with which [`Light::sample`] chooses the unit direction `wi`; 0 for
    /// delta lights. An area light needs `hit`, where a ray from `from` along `wi` met it.
    pub fn pdf(&self, from: &ReferencePoint, wi: Vec3, hit: Option<&SurfaceHit>) -> f32 {
        match (self, hit) {
            (Light::DiffuseArea(l), Some(hit)) => l.pdf(from, wi, hit),
            (Light::Infinite(l), _) => l.pdf(from, wi),
            _ => 0.0,
        }
    }

    /// Radiance along a ray in unit direction `d` that leaves the scene.
    pub fn escaped(&self, d: Vec3) -> Rgb {
        match self {
            Light::Infinite(l) => l.radiance(d),
            _ => Rgb::ZERO,
        }
    }

    /// [`Light::escaped`] and [`Light::pdf`] of a direction that meets nothing, together.
    pub fn escaped_and_pdf(&self, from: &ReferencePoint, d: Vec3) -> (Rgb, f32) {
        match self {
            Light::Infinite(l) => l.radiance_and_pdf(from, d),
            _ => (Rgb::ZERO, 0.0),
        }
    }

    /// Radiance that leaves the surface point `hit` of this area light toward `hit.wo`.
    pub fn emitted(&self, hit: &SurfaceHit) -> Rgb {
        match self {
            Light::DiffuseArea(l) => l.emitted(hit),
            _ => Rgb::ZERO,
        }
    }

    /// Flux into a scene whose bounding sphere has radius `scene_radius`.
    pub fn power(&self, scene_radius: f32) -> Rgb {
        match self {
            Light::Point(l) => l.power(),
            Light::Spot(l) => l.power(),
            Light::Distant(l) => l.power(scene_radius),
            Light::DiffuseArea(l) => l.power(),
            Light::Infinite(l) => l.power(scene_radius),
            Light::Goniometric(l) => l.power(),
            Light::Projection(l) => l.power(),
        }
    }

    /// True where no ray can meet the light by chance.
    pub fn is_delta(&self) -> bool {
        !matches!(self, Light::DiffuseArea(_) | Light::Infinite(_))
    }

    /// True where rays that leave the scene see the light.
    pub fn is_infinite(&self) -> bool {
        matches!(self, Light::Infinite(_))
    }

    /// How many samples `directlighting` takes of this light under its strategy "all".
    pub fn sample_count(&self) -> u32 {
        match self {
            Light::DiffuseArea(l) => l.sample_count(),
            Light::Infinite(l) => l.sample_count(),
            _ => 1,
        }
    }

    /// Lights with the same number are pieces of one thing, such as a mesh's triangles.
    fn group(&self) -> Option<u32> {
        match self {
            Light::DiffuseArea(l) => Some(l.group()),
            _ => None,
        }
    }

    /// Roughly where, and how strongly, the light arrives.
    fn reach(&self) -> LightBounds {
        match self {
            Light::Point(l) => l.reach(),
            Light::Spot(l) => l.reach(),
            Light::Distant(l) => l.reach(),
            Light::DiffuseArea(l) => l.reach(),
            Light::Infinite(l) => l.reach(),
            Light::Goniometric(l) => l.reach(),
            Light::Projection(l) => l.reach(),
        }
    }
}
