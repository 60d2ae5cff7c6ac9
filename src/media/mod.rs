//! Participating media: those made by `MakeNamedMedium`, and the media on either side of a surface.
//!
//! A *spec* holds a directive's parameters in world space; a *medium* is the compiled form in render space.
//! Coefficients are per scene unit, in linear RGB. Media absorb and scatter; only pbrt-v2's [volumes](volume) emit
//! (docs/scene-language.md §3.12, §4.3 and §A.1).

mod boxes;
mod common;
mod density_grid;
pub mod heterogeneous;
pub mod homogeneous;
mod majorants;
mod numbers;
pub mod phase;
pub mod presets;
pub mod volume;
pub mod volumes;

pub use heterogeneous::{Heterogeneous, HeterogeneousSpec};
pub use homogeneous::Homogeneous;
pub use phase::HenyeyGreenstein;
pub use volume::{Volume, VolumeSpec};
pub use volumes::Volumes;

use crate::handles::{InterfaceId, LightId, MediumId};
use crate::math::ray::Ray;
use crate::math::transform::Transform;
use crate::math::{Rgb, Vec3};
use crate::params::ParamReader;
use crate::samplers::SampleStream;

/// The types that `MakeNamedMedium` may name.
pub const KINDS: [&str; 2] = ["heterogeneous", "homogeneous"];

/// A medium as specified by `MakeNamedMedium`, in world space.
#[derive(Clone, Debug, PartialEq)]
pub enum MediumSpec {
    /// The same everywhere.
    Homogeneous(Homogeneous),
    /// Density varies in a box.
    Heterogeneous(Box<HeterogeneousSpec>),
    /// The sum of pbrt-v2's volumes.
    Volumes(Vec<VolumeSpec>),
}

impl MediumSpec {
    /// Reads a medium under the transformation `world_from_medium`. `None`, after reporting the reason, if there is
    /// none.
    pub fn from_params(reader: &ParamReader, world_from_medium: &Transform) -> Option<MediumSpec> {
        match reader.kind() {
            "homogeneous" => Some(MediumSpec::Homogeneous(Homogeneous::from_params(reader))),
            "heterogeneous" => {
                let spec = HeterogeneousSpec::from_params(reader, world_from_medium)?;
                Some(MediumSpec::Heterogeneous(Box::new(spec)))
            }
            _ => {
                reader.unknown_kind_replaced(&KINDS, "no medium is defined");
                None
            }
        }
    }
}

/// A medium in render space.
#[derive(Clone, Debug)]
pub enum Medium {
    /// The same everywhere.
    Homogeneous(Homogeneous),
    /// Density varies in a box.
    Heterogeneous(Box<Heterogeneous>),
    /// The sum of pbrt-v2's volumes.
    Volumes(Volumes),
}

/// A sampled free path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flight {
    /// The distance at which light is scattered; `None` if it is transmitted.
    pub scattered: Option<f32>,
    /// Factor of the throughput: value over density.
    pub weight: Rgb,
}

/// Both ways of a ray through a medium, one of which a [`Flight`] chooses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BothWays {
    /// A distance at which light is scattered, in scene units.
    pub t: f32,
    /// Factor of the throughput there: value over density.
    pub scattered: Rgb,
    /// Factor of the throughput where it is not: the transmittance.
    pub passed: Rgb,
}

impl Flight {
    /// Transmitted without attenuation.
    pub const UNDISTURBED: Flight = Flight {
        scattered: None,
        weight: Rgb::ONE,
    };
}

impl Medium {
    /// Compiles `spec`.
    pub fn new(spec: MediumSpec, render_from_world: &Transform) -> Medium {
        match spec {
            MediumSpec::Homogeneous(medium) => Medium::Homogeneous(medium),
            MediumSpec::Heterogeneous(spec) => {
                Medium::Heterogeneous(Box::new(Heterogeneous::new(*spec, render_from_world)))
            }
            MediumSpec::Volumes(specs) => {
                let place = |spec| Volume::new(spec, render_from_world);
                Medium::Volumes(Volumes::new(specs.into_iter().map(place).collect()))
            }
        }
    }

    /// Samples a free path along `ray` before the distance `t_max`, where the ray ends, and the phase function if it
    /// scatters. `throughput`, the path's so far, determines which channel matters most.
    pub fn sample(
        &self,
        ray: &Ray,
        t_max: f32,
        throughput: Rgb,
        stream: &mut SampleStream,
    ) -> (Flight, HenyeyGreenstein) {
        match self {
            Medium::Homogeneous(m) => (m.sample(t_max, throughput, stream), m.phase),
            Medium::Heterogeneous(m) => (m.sample(ray, t_max, stream), m.phase),
            Medium::Volumes(m) => {
                let (flight, volume) = m.sample(ray, t_max, throughput, stream);
                (flight, m.phase(volume).copied().unwrap_or_default())
            }
        }
    }

    /// Both ways of a ray before the distance `t_max`, where it ends, and the phase function where it scatters. `None` for media that vary, whose
    /// transmittance is not known, and where the medium stops nothing.
    pub fn both_ways(
        &self,
        t_max: f32,
        throughput: Rgb,
        stream: &mut SampleStream,
    ) -> Option<(BothWays, HenyeyGreenstein)> {
        match self {
            Medium::Homogeneous(m) => Some((m.both_ways(t_max, throughput, stream)?, m.phase)),
            Medium::Heterogeneous(_) | Medium::Volumes(_) => None,
        }
    }

    /// An unbiased estimate of the radiance that the medium itself emits back along the first `t_max` of `ray`.
    pub fn emission(&self, ray: &Ray, t_max: f32, stream: &mut SampleStream) -> Rgb {
        match self {
            Medium::Homogeneous(_) | Medium::Heterogeneous(_) => Rgb::ZERO,
            Medium::Volumes(m) => m.emission(ray, t_max, stream),
        }
    }

    /// Returns `true` if light from infinitely far away is attenuated all along its way. In other media this is limited
    /// to the last two scene radii, as in pbrt-v3.
    pub fn is_crossed_whole(&self) -> bool {
        matches!(self, Medium::Volumes(_))
    }

    /// The transmittance up to the distance `t_max` along `ray`; an unbiased estimate if the medium varies.
    pub fn transmittance(&self, ray: &Ray, t_max: f32, stream: &mut SampleStream) -> Rgb {
        match self {
            Medium::Homogeneous(m) => m.transmittance(t_max),
            Medium::Heterogeneous(m) => Rgb::splat(m.transmittance(ray, t_max, stream)),
            Medium::Volumes(m) => m.transmittance(ray, t_max, stream),
        }
    }
}

/// The media on either side of a surface; `None` is vacuum.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct MediumInterface {
    /// The side opposite the normal.
    pub inside: Option<MediumId>,
    /// The side that the normal points to.
    pub outside: Option<MediumId>,
}

impl MediumInterface {
    /// Returns `true` if the two media differ. Otherwise rays keep the medium they are in (docs/scene-language.md
    /// §2.4).
    pub fn is_transition(&self) -> bool {
        self.inside != self.outside
    }

    /// The medium that a ray in direction `d` enters, from a surface whose geometric normal is `n`.
    pub fn toward(&self, d: Vec3, n: Vec3) -> Option<MediumId> {
        self.beyond(d.dot(n) > 0.0)
    }

    /// The medium on the side that the normal points to, if `outward`, or on the other.
    pub(crate) fn beyond(&self, outward: bool) -> Option<MediumId> {
        if outward { self.outside } else { self.inside }
    }
}

/// A scene's media as specifications.
#[derive(Debug, Default)]
pub struct MediaSpec {
    /// By [`MediumId`].
    pub media: Vec<MediumSpec>,
    /// Medium interfaces, by [`InterfaceId`].
    pub interfaces: Vec<MediumInterface>,
    /// The medium around the camera.
    pub camera: Option<MediumId>,
}

impl MediaSpec {
    /// Returns `true` if pbrt-v2's volumes are among them.
    pub fn has_volumes(&self) -> bool {
        (self.media.iter()).any(|medium| matches!(medium, MediumSpec::Volumes(_)))
    }
}

/// A scene's media, ready for rendering.
#[derive(Debug, Default)]
pub struct Media {
    media: Vec<Medium>,
    interfaces: Vec<MediumInterface>,
    /// Those around the lights, by [`LightId`], as far as there are any.
    around_lights: Vec<MediumInterface>,
    /// The medium around the camera.
    pub camera: Option<MediumId>,
}

impl Media {
    /// Compiles all media.
    pub fn new(
        spec: MediaSpec,
        around_lights: Vec<MediumInterface>,
        render_from_world: &Transform,
    ) -> Media {
        let compile = |medium| Medium::new(medium, render_from_world);
        Media {
            media: spec.media.into_iter().map(compile).collect(),
            interfaces: spec.interfaces,
            around_lights,
            camera: spec.camera,
        }
    }

    /// Returns `true` if there are none.
    pub fn is_empty(&self) -> bool {
        self.media.is_empty()
    }

    /// Returns `true` if the transmittance of any is a stochastic estimate, which draws samples.
    pub fn are_estimated(&self) -> bool {
        let mut media = self.media.iter();
        media.any(|medium| !matches!(medium, Medium::Homogeneous(_)))
    }

    /// The medium that light enters which leaves a light at a point with the normal `n`, zero for a light without area, in
    /// direction `d`: the outside one there, as at the camera.
    pub fn at_light(&self, id: LightId, n: Vec3, d: Vec3) -> Option<MediumId> {
        let around = self.around_lights.get(id.index())?;
        match n == Vec3::ZERO {
            true => around.outside,
            false => around.toward(d, n),
        }
    }

    /// The medium of light that comes from infinity: vacuum, unless no surface ends the one that the camera is in.
    pub fn at_infinity(&self) -> Option<MediumId> {
        self.camera.filter(|_| self.interfaces.is_empty())
    }

    /// The medium with this handle.
    pub fn medium(&self, id: MediumId) -> &Medium {
        &self.media[id.index()]
    }

    /// The medium interface with this handle.
    pub fn interface(&self, id: InterfaceId) -> &MediumInterface {
        &self.interfaces[id.index()]
    }
}
