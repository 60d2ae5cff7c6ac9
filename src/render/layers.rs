//! What a camera sample tells the image's layers.

use super::{OfAll, PendingSample, RenderJob};
use crate::cameras::{CameraRay, DepthAndBlur, Depths};
use crate::film::{Layer, LayerSample, LayerSet, MatteId, Tile};
use crate::integrators::witness::Watch;
use crate::integrators::{FirstSurfaces, Sight, first_surfaces};
use crate::math::{DVec2, DVec3, Rgb, UVec2, Vec2};
use crate::samplers::{SampleStream, Sampler};
use arrayvec::ArrayVec;

/// What all samples of an image have in common for its layers.
pub(super) struct Shown<'a> {
    /// Layers that tell of surfaces are among them.
    surfaces: bool,
    uv: bool,
    instance: bool,
    /// Where depth or circles of confusion are wanted.
    depths: Option<Depths<'a>>,
}

impl Shown<'_> {
    /// Of these layers.
    pub(super) fn new(job: &RenderJob) -> Shown<'_> {
        let layers = job.film.layers;
        let has_depths = layers.contains(Layer::Depth) || layers.contains(Layer::Coc);
        Shown {
            surfaces: layers.with_lights(0) != LayerSet::NONE.with(Layer::Lights),
            uv: layers.contains(Layer::Uv),
            instance: layers.contains(Layer::Instance),
            depths: has_depths.then(|| job.camera.depths()),
        }
    }
}

/// Adds to the layers of `tile` what a sample of `sampler` shows, whose path has brought this `radiance` while `watch` looked at it, before its
/// color is added; without a ray it has not left the lens.
#[inline(always)]
pub(super) fn add(
    (job, all): (&RenderJob, &OfAll),
    waiting: &PendingSample,
    (ray, radiance): (Option<&CameraRay>, Rgb),
    (sampler, watch): (&Sampler, &Watch),
    tile: &mut Tile,
) {
    let mut lights = ArrayVec::<Rgb, { LayerSet::MAX_LIGHTS }>::new();
    if let (Some(ray), Some(parts)) = (ray, &watch.parts) {
        let factor = tile.factor_of_parts(radiance, waiting.weight(ray));
        lights.extend(parts.scaled(factor, tile.lights()));
    }
    let (pixel, weight) = (waiting.pixel, waiting.filter_weight);
    let known = watch.sight.as_ref().and_then(Sight::known);
    match (ray, known) {
        (Some(_), Some(Some(found))) if all.shown.surfaces => {
            let sample = told((job, all), found);
            tile.add_layers(pixel, weight, Some(Some(&sample)), &lights);
        }
        _ => {
            let sample = ray.map(|ray| match known {
                None if all.shown.surfaces => {
                    let stream = waiting.stream_again(job, sampler);
                    traced((job, all), ray, stream)
                }
                _ => None,
            });
            let sample = sample.as_ref().map(Option::as_ref);
            add_other(tile, (pixel, weight), sample, &lights);
        }
    }
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
) -> Option<LayerSample> {
    let differentials = camera_ray.scaled_differentials(all.spacing);
    let found = first_surfaces(&job.world, &camera_ray.ray, differentials.as_ref(), stream)?;
    Some(told((job, all), &found))
}

/// What surfaces tell.
#[inline(always)]
fn told((job, all): (&RenderJob, &OfAll), found: &FirstSurfaces) -> LayerSample {
    let parameters = || job.world.surface_parameters(&found.ray, &found.found);
    let uv = match all.shown.uv {
        true => found.uv.unwrap_or_else(parameters),
        false => Vec2::ZERO,
    };
    let instance = match all.shown.instance {
        true => {
            let standing = || job.world.geometry.standing(&found.found);
            job.mattes.standing(found.standing.unwrap_or_else(standing))
        }
        false => MatteId::default(),
    };
    // Not by `map`, whose function is not always inlined.
    let at = match &all.shown.depths {
        Some(depths) => depths.at(found.p, found.ray.time),
        None => DepthAndBlur::default(),
    };
    let (albedo, normal) = found.finite();
    LayerSample {
        position: found.p.as_dvec3() + job.world_from_render,
        depth: at.depth,
        uv,
        material: job.mattes.material(found.material),
        instance,
        motion: motion(job, found),
        coc: at.coc,
        albedo,
        // Render space is world space moved.
        normal,
    }
}

/// See [`Layer::Motion`]; none where nothing moves, or where the camera does not see both ends of the way.
#[inline(always)]
fn motion(job: &RenderJob, found: &FirstSurfaces) -> DVec2 {
    let moves = || job.world.moves() || job.camera.moves();
    match job.motion_times {
        Some(times) if moves() => moved(job, found, times),
        _ => DVec2::ZERO,
    }
}

#[inline(never)]
fn moved(job: &RenderJob, found: &FirstSurfaces, times: [f32; 2]) -> DVec2 {
    let p = found.p.as_dvec3();
    let moved = job
        .world
        .geometry
        .moved(&found.found, p, found.ray.time, times);
    if moved.is_none() && !job.camera.moves() {
        return DVec2::ZERO;
    }
    let ends = moved.unwrap_or([p; 2]).map(|end: DVec3| end.as_vec3());
    let shift = job.camera.shift(ends, times).unwrap_or(Vec2::ZERO);
    DVec2::new(shift.x.into(), (-shift.y).into())
}
