//! `Integrator "sppm"`: stochastic progressive photon mapping (Hachisuka and Jensen 2009; Pharr, Jakob and Humphreys 2016,
//! §16.2).
//!
//! Each iteration sends photons from the lights ([`photon_path`]), sorts them ([`photon_map`]), and follows one path from
//! the camera for each pixel ([`camera_path`]) to the first surface that scatters widely. There
//!
//! * emission on the way and direct light are found as by a path tracer;
//! * all other light is that of the photons in a disc around the point, over its area.
//!
//! So light is found that no other method finds: caustics of lights without area, seen in mirrors and through glass.
//!
//! **Bias.** Photons count wherever they fell in the disc: light is blurred over its width, dark borders appear where the disc
//! reaches beyond an edge, bright ones where it reaches other surfaces. The disc of a pixel shrinks with the photons it
//! has met ([`disc`]), and in the limit of many iterations, not of many photons, the bias is gone.
//!
//! **The mean.** The algorithm sums flux τ and scales it by R′²/R² whenever the radius R becomes R′; its image is τ/(π R²)
//! over the photons sent. That is Σ Φᵢ/(π Rᵢ²), where iteration i found the flux Φᵢ with the radius Rᵢ (Knaus and Zwicker
//! 2011): the plain mean over iterations of what each would show by itself. A pixel's samples are summed as by any
//! other integrator; and as iterations differ in random numbers alone, their variance is that of the image's noise.
//! Neighboring pixels share photons, and what they show differs from the truth in common.
//!
//! Differences from pbrt-v3, which all make the limit that of a path tracer:
//! * a surface with diffuse and perfectly specular lobes gathers photons and continues the path, in pbrt-v3 the
//!   mirror image is lost;
//! * a diffuse base below a glossy coat (`substrate`), and measured data, count as diffuse;
//! * light of the surroundings counts once after a rough bounce, not twice;
//! * photons on perfectly specular surfaces and on those without material do not count for points nearby;
//! * interpolated normals turn photons' light as they turn that of a path.

mod camera_path;
mod disc;
mod photon_map;
mod photon_path;

use super::context::{Context, Lights};
use super::{Path, Transport};
use crate::math::Rgb;
use crate::math::color::is_black;
use crate::math::ray::{Ray, RayDifferentials};
use crate::params::ParamReader;
use crate::samplers::SampleStream;
use crate::world::World;
use camera_path::CameraPath;

pub use camera_path::Gather;
pub use disc::Disc;
pub use photon_map::{Photon, PhotonMap};

/// Parameters of `Integrator "sppm"`.
#[derive(Clone, Debug, PartialEq)]
pub struct Sppm {
    /// `maxdepth` (5): most surfaces on the camera's part of a path, and most on the light's.
    pub max_depth: u32,
    /// `iterations`, else `numiterations` (64).
    pub iterations: u32,
    /// `photonsperiteration` (−1): paths from lights in each iteration; `None` for one a pixel.
    pub photons: Option<u32>,
    /// `radius` (1): that of discs in the first iteration, world units.
    pub radius: f32,
}

/// Radii whose squares single precision can tell from 0 and infinity.
const RADII: std::ops::RangeInclusive<f64> = 1e-15..=1e15;

impl Sppm {
    /// Reads the parameters.
    pub fn from_params(reader: &ParamReader) -> Sppm {
        let count = |name, range| reader.find_integer_within(name, range);
        let most = i64::from(u32::MAX >> 1);
        let usual = count("numiterations", 1..=most);
        let iterations = count("iterations", 1..=most).or(usual);
        let photons = reader.integer("photonsperiteration", -1).min(most);
        let mut radius = reader.float("radius", 1.0);
        if !RADII.contains(&radius) {
            let used = if radius > 1.0 { *RADII.end() } else { 1.0 };
            reader.warn(
                "radius",
                format!("`radius` is {radius}, no size of a disc: {used} is used"),
            );
            radius = used;
        }
        reader.accept("imagewritefrequency");
        Sppm {
            max_depth: super::max_depth(reader),
            iterations: iterations.map_or(64, |n| n as u32),
            photons: (photons > 0).then_some(photons as u32),
            radius: radius as f32,
        }
    }
}

/// The surfaces that a photon's path is counted on to meet, if it may meet so many: those of walls that reflect 7/8.
const COUNTED_SURFACES: u32 = 8;

impl Sppm {
    /// Paths from lights in an iteration of an image with so many pixels.
    fn paths(&self, pixels: u64) -> u64 {
        self.photons.map_or(pixels, u64::from)
    }
}

impl Transport for Sppm {
    const INDIRECT: bool = true;
    const PHOTONS: bool = true;

    /// For the photons of an iteration, which are there twice while they are sorted, and for discs.
    fn memory(&self, pixels: u64) -> u64 {
        let surfaces = self.max_depth.saturating_sub(1).min(COUNTED_SURFACES);
        let photons = self.paths(pixels).saturating_mul(surfaces.into());
        photons.saturating_mul(2 * size_of::<Photon>() as u64) + pixels * size_of::<Disc>() as u64
    }

    /// What is seen where no photons are.
    fn radiance(&self, context: Context) -> Rgb {
        let mapper = PhotonMapper::new(self, context.world, context.lights);
        let mut gather = Gather {
            map: &PhotonMap::default(),
            paths: 1.0,
            disc: &mut mapper.disc(),
        };
        let path = mapper.camera_path(*context.ray(), context.differentials, context.stream);
        let watch = context.watch;
        CameraPath { watch, ..path }.trace(&mut gather)
    }

    fn path(&self) -> Option<Path> {
        Some(Path {
            max_depth: self.max_depth,
            ..Path::default()
        })
    }
}

/// The method at work in a world.
#[derive(Clone, Copy)]
pub struct PhotonMapper<'a> {
    sppm: &'a Sppm,
    world: &'a World,
    lights: &'a Lights,
    /// Rays may meet lights by chance.
    finds_lights: bool,
}

impl<'a> PhotonMapper<'a> {
    pub(super) fn new(sppm: &'a Sppm, world: &'a World, lights: &'a Lights) -> Self {
        PhotonMapper {
            sppm,
            world,
            lights,
            finds_lights: world.sampled_lights().iter().any(|light| !light.is_delta()),
        }
    }

    /// A pixel's disc before the first iteration.
    pub fn disc(&self) -> Disc {
        Disc::new(self.sppm.radius)
    }

    /// Paths from lights in an iteration of an image with so many pixels.
    pub fn paths(&self, pixels: u64) -> u64 {
        self.sppm.paths(pixels)
    }

    /// Radiance along a camera ray in one iteration, which changes the pixel's disc.
    pub fn radiance(
        &self,
        ray: Ray,
        differentials: Option<&RayDifferentials>,
        stream: &mut SampleStream,
        gather: &mut Gather,
    ) -> Rgb {
        self.camera_path(ray, differentials, stream).trace(gather)
    }

    fn camera_path<'c>(
        &self,
        ray: Ray,
        differentials: Option<&'c RayDifferentials>,
        stream: &'c mut SampleStream,
    ) -> CameraPath<'c, 'a> {
        CameraPath {
            mapper: *self,
            stream,
            watch: None,
            ray,
            differentials,
            throughput: Rgb::ONE,
            radiance: Rgb::ZERO,
            after_delta: true,
            depth: 0,
            null_surfaces: 0,
            found: 0,
        }
    }
}

/// Nothing is left, or nothing that could be counted.
fn has_gone(light: Rgb) -> bool {
    is_black(light) || !light.is_finite()
}

#[cfg(test)]
mod tests;
