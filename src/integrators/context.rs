//! What an integrator works with: a camera ray, the world, its lights and the samples.

use super::Sight;
use super::bdpt::{SpareVertices, WaveBuffers};
use super::emitters::Emitters;
use super::path::Wave;
use super::witness::{Met, Place, Watch};
use crate::cameras::{Camera, CameraRay, CameraSample};
use crate::film::{PixelBounds, SplatBuffer};
use crate::filters::Filter;
use crate::handles::{LightId, LightLayer};
use crate::lights::{LightGroups, LightSelector};
use crate::math::ray::{Ray, RayDifferentials};
use crate::math::{Rgb, UVec2, Vec3};
use crate::samplers::{SampleStream, Sampler};
use crate::world::World;

/// The lights as integrators sample them.
#[derive(Debug)]
pub(super) struct Lights {
    /// For integrators of paths, which choose a light by its estimated contribution.
    pub selector: LightSelector,
    /// For `directlighting` and `whitted`, which sample every light or any.
    pub groups: LightGroups,
    /// For integrators that trace paths from lights.
    pub emitters: Option<Emitters>,
}

/// Memory that the samples of a thread use one after the other.
#[derive(Default)]
pub struct Workspace {
    pub(super) vertices: SpareVertices,
    /// For `bdpt`, which walks many paths side by side.
    pub(super) buffers: Option<Box<WaveBuffers>>,
    /// For `path` and `volpath`, which do so as well.
    pub(super) wave: Option<Box<Wave>>,
    /// What light paths bring that camera paths are joined to, where those of the light pass are.
    pub splats: Option<SplatBuffer>,
}

/// Camera paths that are handed over together: enough to fill vectors when most of them have ended, and so few that all that is known of
/// them stays in a cache near the processor.
pub const WAVE: usize = 128;

/// The camera's end of a path, and its sample points.
pub struct CameraPath<'a> {
    /// How the camera ray was made.
    pub end: CameraEnd<'a>,
    /// Those of the camera ray, if they are wanted.
    pub differentials: Option<RayDifferentials>,
    /// Of the path, after the camera's.
    pub stream: &'a mut SampleStream,
    /// What looks at the path, for layers.
    pub watch: Option<&'a mut Watch>,
}

/// Camera paths, at most [`WAVE`], and what they are traced in.
pub(super) struct Bundle<'a, 'p> {
    pub world: &'a World,
    pub lights: &'a Lights,
    pub paths: &'a mut [CameraPath<'p>],
    pub workspace: &'a mut Workspace,
    /// What [`Workspace::splats`] are for.
    pub light_job: Option<&'a LightJob<'a>>,
}

impl Bundle<'_, '_> {
    /// One of the paths by itself.
    #[inline(always)]
    pub(super) fn context(&mut self, path: usize) -> Context<'_> {
        let CameraPath {
            end,
            differentials,
            stream,
            watch,
        } = &mut self.paths[path];
        Context {
            world: self.world,
            lights: self.lights,
            stream,
            differentials: differentials.as_ref(),
            end,
            workspace: self.workspace,
            watch: watch.as_deref_mut(),
        }
    }
}

/// All that the radiance along a camera ray depends on, besides the integrator.
pub(super) struct Context<'a> {
    pub world: &'a World,
    pub lights: &'a Lights,
    pub stream: &'a mut SampleStream,
    pub differentials: Option<&'a RayDifferentials>,
    /// How the ray was made.
    pub end: &'a CameraEnd<'a>,
    pub workspace: &'a mut Workspace,
    /// For layers, for counts, and for samples that are traced again because they were not finite.
    pub watch: Option<&'a mut Watch>,
}

impl<'a> Context<'a> {
    /// The camera ray.
    #[inline(always)]
    pub(super) fn ray(&self) -> &'a Ray {
        &self.end.ray.ray
    }

    /// Reports a vertex after `depth` scattering events, with the `radiance` collected before it.
    #[inline(always)]
    pub(super) fn arrive(&mut self, depth: u32, met: Met, radiance: Rgb) {
        if let Some(watch) = &mut self.watch
            && watch.reports()
        {
            watch.arrive(Place { depth, met }, radiance);
        }
    }

    /// Tells the layers of a step of the path, if any are wanted.
    #[inline(always)]
    pub(super) fn look(&mut self, note: impl FnOnce(&mut Sight)) {
        if let Some(watch) = &mut self.watch {
            note(&mut watch.sight);
        }
    }

    /// What looks at the path, for layers, if they are wanted; and the numbers that the path has next, which it may look on by.
    #[inline(always)]
    pub(super) fn sight(&mut self) -> Option<(&mut Sight, &SampleStream)> {
        Some((&mut self.watch.as_mut()?.sight, self.stream))
    }

    /// Returns `true` if layers ask for (u, v) of what the path meets next.
    #[inline(always)]
    pub(super) fn wants_parameters(&self) -> bool {
        { self.watch.as_deref() }.is_some_and(|watch| watch.sight.wants_parameters())
    }

    /// Returns `true` if layers are wanted, and the path has not told them all yet.
    pub(super) fn is_looked_at(&self) -> bool {
        self.watch.as_deref().is_some_and(Watch::is_looking)
    }

    /// Returns `true` if the path has told the layers all.
    #[inline(always)]
    pub(super) fn has_seen(&self) -> bool {
        { self.watch.as_deref() }.is_some_and(|watch| watch.sight.is_done())
    }

    /// Adds light that the path brings to its layer, if any are wanted; `None`: of no light.
    #[inline(always)]
    pub(super) fn part(&mut self, from: Option<LightId>, light: Rgb) {
        if let Some(watch) = &mut self.watch {
            watch.part(|| self.world.light_layer(from), light);
        }
    }

    /// Adds light to a layer, if any are wanted.
    #[inline(always)]
    pub(super) fn part_of_layer(&mut self, layer: LightLayer, light: Rgb) {
        if let Some(watch) = &mut self.watch {
            watch.part(|| layer, light);
        }
    }

    /// Adds the light of the infinite lights, as `of_light` has it.
    #[inline(always)]
    pub(super) fn parts_at_infinity(&mut self, of_light: impl Fn(&Context, LightId) -> Rgb) {
        if self
            .watch
            .as_ref()
            .is_some_and(|watch| watch.parts.is_some())
        {
            let world = self.world;
            for &id in &world.infinite_lights {
                let light = of_light(self, id);
                self.part(Some(id), light);
            }
        }
    }

    /// What is added to layers of light from now on counts for so much.
    #[inline(always)]
    pub(super) fn scale_parts(&mut self, scale: Rgb) {
        if let Some(parts) = self.watch.as_mut().and_then(|watch| watch.parts.as_mut()) {
            parts.scale(scale);
        }
    }

    /// Returns `true` if a shadow ray to a light meets nothing.
    #[inline(always)]
    pub(super) fn is_lit(&mut self, light: LightId, shadow: &Ray) -> bool {
        self.shadow(light, false);
        let is_lit = !self.world.occluded(shadow);
        if is_lit {
            self.shadow(light, true);
        }
        is_lit
    }

    /// Reports a ray that is only asked whether something is near.
    pub(super) fn occlusion(&mut self) {
        if let Some(watch) = &mut self.watch {
            watch.count(|counts| counts.occlusion += 1);
        }
    }

    /// Reports a shadow ray to a light, before it is traced and, `is_lit`, when nothing has blocked it.
    #[inline(always)]
    pub(super) fn shadow(&mut self, light: LightId, is_lit: bool) {
        if let Some(watch) = &mut self.watch {
            watch.shadow(light, is_lit);
        }
    }
}

/// The camera's end of a path: which ray it is, of all that the camera could have made.
#[derive(Clone, Copy)]
pub struct CameraEnd<'a> {
    /// The camera.
    pub camera: &'a Camera,
    /// What its ray was made from.
    pub sample: &'a CameraSample,
    /// The ray.
    pub ray: &'a CameraRay,
    /// Density of the film point, per pixel squared, among those of its pixel's samples.
    pub film_density: f32,
    /// Light paths for each sample of a pixel; 0 if none are joined to the lens.
    pub light_paths: f32,
    /// The light path that the camera path is joined to, if it is one of the light pass.
    pub paired: Option<Paired<'a>>,
}

/// A path of the light pass.
#[derive(Clone, Copy)]
pub struct Paired<'a> {
    /// What its numbers come from.
    pub sampler: &'a Sampler,
    /// Its number.
    pub number: u64,
}

impl CameraEnd<'_> {
    /// The density with which light paths that come to `p` are joined to the lens along the same ray, over that of the camera's
    /// samples, per area across the ray.
    pub(super) fn connection_density(&self, p: Vec3) -> f32 {
        if self.light_paths == 0.0 {
            return 0.0;
        }
        let lens = self.camera.connection_density(self.sample, self.ray, p);
        self.light_paths * lens / self.film_density
    }
}

/// Light that a path from a light brings to a pixel.
#[derive(Clone, Copy, Debug)]
pub struct Splat {
    /// The number of the path.
    pub path: u64,
    /// The light that it begins at.
    pub light: LightId,
    /// The pixel.
    pub pixel: UVec2,
    /// The light, with the weight and the filter's factor.
    pub value: Rgb,
    /// Where strategies have images of their own: which, and what it counts for there.
    pub shown: Option<(LightLayer, Rgb)>,
    /// The density with which camera paths, each way of making them by itself, find the same in a sample of the pixel, over that of all
    /// light paths for it: the root of the sum of squares.
    pub by_camera: f64,
}

impl Splat {
    /// Adds it to what others bring.
    pub fn add_to(&self, buffer: &mut SplatBuffer, world: &World) {
        let by_light = || (world.light_layer(Some(self.light)), self.value);
        let part = self.shown.unwrap_or_else(by_light);
        buffer.push(self.path, self.pixel, self.value, part);
    }
}

/// What light paths are traced for.
#[derive(Clone, Copy)]
pub struct LightJob<'a> {
    /// The scene.
    pub world: &'a World,
    /// The camera that they are joined to.
    pub camera: &'a Camera,
    /// The reconstruction filter, which distributes what they bring to pixels.
    pub filter: &'a Filter,
    /// The pixels that are sampled.
    pub bounds: PixelBounds,
    /// Light paths for each sample of a pixel.
    pub light_paths: f32,
}
