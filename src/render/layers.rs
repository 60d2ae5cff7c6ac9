//! What a camera sample tells the image's layers.

use super::{OfAll, PendingSample, RenderJob};
use crate::accel::Thing;
use crate::cameras::{CameraRay, DepthAndBlur, Depths};
use crate::film::{CameraSample, Layer, LayerSample, LayerSet, RenderSpace, SurfaceSample, Tile};
use crate::integrators::witness::Watch;
use crate::integrators::{FirstSurfaces, LightParts, Sight, first_surfaces};
use crate::math::instruction_set::{Instructions, Kernel};
use crate::math::{DVec3, Rgb, UVec2, Vec2, Vec3};
use crate::samplers::{SampleStream, Sampler};
use arrayvec::ArrayVec;

/// What all samples of an image have in common for its layers.
pub(super) struct Shown<'a> {
    /// Layers that tell of surfaces are among them.
    surfaces: bool,
    space: RenderSpace,
    /// Where depth or circles of confusion are wanted, and each sample has to tell them.
    depths: Option<Depths<'a>>,
    /// When [`Layer::Motion`] begins and ends, if it is wanted and anything moves.
    motion: Option<[f32; 2]>,
}

impl Shown<'_> {
    /// Of these layers.
    pub(super) fn new(job: &RenderJob) -> Shown<'_> {
        let layers = job.film.layers;
        let has_depths = layers.contains(Layer::Depth) || layers.contains(Layer::Coc);
        let depths = has_depths.then(|| job.camera.depths());
        let of_mean = depths.as_ref().and_then(Depths::of_mean);
        Shown {
            surfaces: layers.with_lights(0) != LayerSet::NONE.with(Layer::Lights),
            space: RenderSpace {
                origin: job.world_from_render.extend(0.0),
                depth: of_mean.unwrap_or_default(),
            },
            depths: depths.filter(|_| of_mean.is_none()),
            motion: job.motion_times,
        }
    }
}

/// The end of a wave: what its samples show is added to the tile's layers.
pub(super) struct Tell<'a> {
    pub shown: (&'a RenderJob, &'a OfAll<'a>),
    pub sampler: &'a Sampler,
    pub samples: (&'a [PendingSample], &'a [Option<CameraRay>]),
    /// Of those that have a ray.
    pub radiances: &'a [Rgb],
    /// One for each sample.
    pub looks: &'a [Watch],
    pub tile: &'a mut Tile,
}

impl Kernel for Tell<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self, _: impl Instructions) {
        let ((job, all), tile) = (self.shown, self.tile);
        let (waiting, rays) = self.samples;
        let mut rest = waiting.iter().zip(rays).zip(self.looks);
        let mut path = 0;
        while let Some(next) = rest.clone().next() {
            let ((waiting, ray), watch) = next;
            let (pixel, weight) = (waiting.pixel, waiting.filter_weight);
            if let Some((_, found)) = plainly_found(all, next) {
                let what = (job.mattes.of(found.thing), &all.shown.space);
                let run = Run {
                    shown: self.shown,
                    like: (pixel, weight.to_bits(), found.thing),
                    rest: &mut rest,
                    path: &mut path,
                };
                tile.add_run_of_layers(pixel, weight, what, run);
            } else {
                rest.next();
                let radiance = self.radiances.get(path).copied().unwrap_or_default();
                let sample = (ray.as_ref(), radiance);
                add(self.shown, waiting, sample, (self.sampler, watch), tile);
                path += usize::from(ray.is_some());
            }
        }
    }
}

/// The next samples, as long as they are of a pixel, have this weight and have plainly met this.
struct Run<'a, 'r, I> {
    shown: (&'a RenderJob, &'a OfAll<'a>),
    like: (UVec2, u32, Thing),
    rest: &'r mut I,
    /// How many of all samples before have a path.
    path: &'r mut usize,
}

impl<'a, I: Iterator<Item = Looked<'a>> + Clone> Iterator for Run<'a, '_, I> {
    type Item = (&'a SurfaceSample, CameraSample);

    #[inline(always)]
    fn next(&mut self) -> Option<Self::Item> {
        let next = self.rest.clone().next()?;
        let ((waiting, _), _) = next;
        let (ray, found) = plainly_found(self.shown.1, next)?;
        if (waiting.pixel, waiting.filter_weight.to_bits(), found.thing) != self.like {
            return None;
        }
        self.rest.next();
        *self.path += 1;
        let camera = of_camera(self.shown, ray.ray.time, found);
        Some((&found.surface, camera))
    }
}

/// A sample with its ray and what has looked at its path.
type Looked<'a> = ((&'a PendingSample, &'a Option<CameraRay>), &'a Watch);

/// What is to be told of a sample, where it is only what a path has met: most are of this kind.
#[inline(always)]
fn plainly_found<'a>(
    all: &OfAll,
    ((_, ray), watch): Looked<'a>,
) -> Option<(&'a CameraRay, &'a FirstSurfaces)> {
    let (ray, found) = (ray.as_ref()?, watch.found()?);
    let is_plain = all.shown.surfaces && found.surface.is_finite();
    is_plain.then_some((ray, found))
}

/// Adds to the layers of `tile` what a sample of `sampler` shows, whose path has brought this `radiance` while `watch` looked at it; without a
/// ray it has not left the lens.
#[inline(never)]
pub(super) fn add(
    shown: (&RenderJob, &OfAll),
    waiting: &PendingSample,
    (ray, radiance): (Option<&CameraRay>, Rgb),
    (sampler, watch): (&Sampler, &Watch),
    tile: &mut Tile,
) {
    let lights = match (ray, &watch.parts) {
        (Some(ray), Some(parts)) => lights(parts, (waiting.weight(ray), radiance), tile),
        _ => ArrayVec::new(),
    };
    let (job, all) = shown;
    let known = watch.sight.as_ref().and_then(Sight::known);
    let found = match (ray, known) {
        (Some(_), Some(known)) if all.shown.surfaces => known.copied(),
        (Some(ray), None) if all.shown.surfaces => {
            traced(shown, ray, waiting.stream_again(job, sampler))
        }
        _ => None,
    };
    let found = found.map(finite);
    let sample = ray.map(|ray| {
        found.as_ref().map(|found| LayerSample {
            surface: &found.surface,
            space: &all.shown.space,
            camera: of_camera(shown, ray.ray.time, found),
            mattes: job.mattes.of(found.thing),
        })
    });
    let sample = sample.as_ref().map(Option::as_ref);
    tile.add_layers(waiting.pixel, waiting.filter_weight, sample, &lights);
}

/// What a path brings, of this radiance, by layers of light.
#[inline(never)]
fn lights(
    parts: &LightParts,
    (weight, radiance): (Rgb, Rgb),
    tile: &Tile,
) -> ArrayVec<Rgb, { LayerSet::MAX_LIGHTS }> {
    let factor = tile.factor_of_parts(radiance, weight);
    parts.scaled(factor, tile.lights()).collect()
}

/// By a ray for the layers alone.
#[inline(never)]
fn traced(
    (job, all): (&RenderJob, &OfAll),
    camera_ray: &CameraRay,
    stream: SampleStream,
) -> Option<FirstSurfaces> {
    let differentials = camera_ray.scaled_differentials(all.spacing);
    let wants_uv = job.film.layers.contains(Layer::Uv);
    let ray = &camera_ray.ray;
    first_surfaces(&job.world, ray, differentials.as_ref(), stream, wants_uv)
}

/// How the camera sees at this time what has been met: what [`RenderSpace::depth`] does not tell.
#[inline(always)]
fn of_camera((job, all): (&RenderJob, &OfAll), time: f32, found: &FirstSurfaces) -> CameraSample {
    // Not by `map`, whose function is not always inlined.
    let at = match &all.shown.depths {
        Some(depths) => depths.at(found.surface.p(), time),
        None => DepthAndBlur::default(),
    };
    let motion = match all.shown.motion {
        Some(times) => motion(job, time, found, times),
        None => Vec2::ZERO,
    };
    CameraSample::new(at.depth, at.coc, motion)
}

/// With albedo and normal black where they are not numbers: one sample would spoil its pixel.
fn finite(mut found: FirstSurfaces) -> FirstSurfaces {
    if !found.surface.is_finite() {
        found.surface.set_albedo(Rgb::ZERO);
        found.surface.set_normal(Vec3::ZERO);
    }
    found
}

/// See [`Layer::Motion`], of what is met at this time; none where the camera does not see both ends of the way.
#[inline(never)]
fn motion(job: &RenderJob, time: f32, found: &FirstSurfaces, times: [f32; 2]) -> Vec2 {
    let p = found.surface.p().as_dvec3();
    let geometry = &job.world.geometry;
    let moved = { found.moving }.and_then(|found| geometry.moved(&found, p, time, times));
    if moved.is_none() && !job.camera.moves() {
        return Vec2::ZERO;
    }
    let ends = moved.unwrap_or([p; 2]).map(|end: DVec3| end.as_vec3());
    let shift = job.camera.shift(ends, times).unwrap_or(Vec2::ZERO);
    Vec2::new(shift.x, -shift.y)
}
