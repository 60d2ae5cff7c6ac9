//! What a camera sample tells the image's layers.

use super::{OfAll, PendingSample, RenderJob};
use crate::accel::Thing;
use crate::cameras::{CameraRay, DepthAndBlur, Depths};
use crate::film::{Layer, LayerSample, LayerSet, MatteId, Tile};
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
    /// Of render space, in world space; and a zero.
    origin: [f64; 4],
    /// Where depth or circles of confusion are wanted.
    depths: Option<Depths<'a>>,
    /// When [`Layer::Motion`] begins and ends, if it is wanted and anything moves.
    motion: Option<[f32; 2]>,
}

impl Shown<'_> {
    /// Of these layers.
    pub(super) fn new(job: &RenderJob) -> Shown<'_> {
        let layers = job.film.layers;
        let has_depths = layers.contains(Layer::Depth) || layers.contains(Layer::Coc);
        Shown {
            surfaces: layers.with_lights(0) != LayerSet::NONE.with(Layer::Lights),
            origin: job.world_from_render.extend(0.0).to_array(),
            depths: has_depths.then(|| job.camera.depths()),
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
        let (waiting, rays) = self.samples;
        let (mut path, mut last) = (0, LastMattes::default());
        for ((waiting, ray), watch) in waiting.iter().zip(rays).zip(self.looks) {
            let ray = ray.as_ref();
            let from = (self.sampler, watch);
            if watch.parts.is_none() {
                let sample = (waiting, ray, &[][..]);
                add_surfaces(self.shown, sample, from, &mut last, self.tile);
            } else {
                let radiance = self.radiances.get(path).copied().unwrap_or_default();
                add(self.shown, waiting, (ray, radiance), from, self.tile);
            }
            path += usize::from(ray.is_some());
        }
    }
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
    let mut last = LastMattes::default();
    let sample = (waiting, ray, &lights[..]);
    add_surfaces(shown, sample, (sampler, watch), &mut last, tile);
}

/// The same where what it brings to layers of light is known.
#[inline(always)]
fn add_surfaces(
    (job, all): (&RenderJob, &OfAll),
    (waiting, ray, lights): (&PendingSample, Option<&CameraRay>, &[Rgb]),
    (sampler, watch): (&Sampler, &Watch),
    last: &mut LastMattes,
    tile: &mut Tile,
) {
    let at = (waiting.pixel, waiting.filter_weight);
    let known = watch.sight.as_ref().and_then(Sight::known);
    match (ray, known) {
        (Some(ray), Some(Some(found))) if all.shown.surfaces => {
            add_found((job, all), at, (ray.ray.time, found), lights, (last, tile));
        }
        (Some(ray), None) if all.shown.surfaces => {
            let stream = waiting.stream_again(job, sampler);
            match traced((job, all), ray, stream) {
                Some(found) => {
                    add_found((job, all), at, (ray.ray.time, &found), lights, (last, tile));
                }
                None => add_other(tile, at, Some(None), lights),
            }
        }
        _ => add_other(tile, at, ray.map(|_| None), lights),
    }
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

/// What is not as common.
#[inline(never)]
fn add_other(
    tile: &mut Tile,
    (pixel, weight): (UVec2, f32),
    sample: Option<Option<&LayerSample>>,
    lights: &[Rgb],
) {
    tile.add_layers(pixel, weight, sample, lights);
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

/// What surfaces tell at this time.
#[inline(always)]
fn add_found(
    (job, all): (&RenderJob, &OfAll),
    (pixel, weight): (UVec2, f32),
    (time, found): (f32, &FirstSurfaces),
    lights: &[Rgb],
    (last, tile): (&mut LastMattes, &mut Tile),
) {
    let mended;
    let found = match found.surface.is_finite() {
        true => found,
        false => {
            mended = without_albedo(found);
            &mended
        }
    };
    // Not by `map`, whose function is not always inlined.
    let at = match &all.shown.depths {
        Some(depths) => depths.at(found.surface.p(), time),
        None => DepthAndBlur::default(),
    };
    let motion = match all.shown.motion {
        Some(times) => motion(job, time, found, times),
        None => Vec2::ZERO,
    };
    let sample = LayerSample {
        surface: &found.surface,
        origin: &all.shown.origin,
        depth: at.depth as f32,
        coc: at.coc as f32,
        motion,
        mattes: last.of(job, found.thing),
    };
    tile.add_layers(pixel, weight, Some(Some(&sample)), lights);
}

/// The mattes of the sample before, which mostly are those of the next one.
#[derive(Default)]
struct LastMattes {
    of: Option<Thing>,
    mattes: [MatteId; 2],
}

impl LastMattes {
    #[inline(always)]
    fn of(&mut self, job: &RenderJob, thing: Thing) -> [MatteId; 2] {
        if Some(thing) != self.of {
            (self.of, self.mattes) = (Some(thing), job.mattes.of(thing));
        }
        self.mattes
    }
}

/// With albedo and normal black, which are not numbers: one sample would spoil its pixel.
#[cold]
fn without_albedo(found: &FirstSurfaces) -> FirstSurfaces {
    let mut mended = *found;
    mended.surface.set_albedo(Rgb::ZERO);
    mended.surface.set_normal(Vec3::ZERO);
    mended
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
