//! What a camera sample tells the image's layers.

use super::RenderJob;
use crate::cameras::CameraRay;
use crate::film::{Layer, LayerSample, MatteId};
use crate::integrators::witness::Watch;
use crate::integrators::{FirstSurfaces, LightParts, Sight, first_surfaces};
use crate::math::{DVec2, DVec3, Vec2};
use crate::samplers::SampleStream;

/// What a sample shows.
#[derive(Clone, Debug, Default)]
pub(super) struct Seen<'w> {
    /// The surfaces that it meets.
    pub surface: Option<LayerSample>,
    /// What it brings, by layers of light.
    pub parts: Option<&'w LightParts>,
}

/// Looks at one of many paths that are traced together.
pub(super) struct Look {
    pub watch: Watch,
    /// The integrator draws from a copy.
    stream: SampleStream,
}

impl Look {
    pub(super) fn new(job: &RenderJob, stream: SampleStream) -> Look {
        let mut watch = Watch::default();
        watch.look(job.film.layers.lights() > 0);
        Look { watch, stream }
    }

    /// What a camera ray shows, or `None`, which has not left the lens; see [`seen`].
    pub(super) fn seen(&self, job: &RenderJob, ray: Option<&CameraRay>, spacing: f32) -> Seen<'_> {
        match ray {
            Some(ray) => seen(job, (ray, spacing), self.stream, &self.watch),
            None => Seen::default(),
        }
    }
}

/// Of a ray that has left the lens and whose path `watch` has looked at, of samples this far apart, in pixels; see [`sample`].
pub(super) fn seen<'w>(
    job: &RenderJob,
    camera_ray: (&CameraRay, f32),
    stream: SampleStream,
    watch: &'w Watch,
) -> Seen<'w> {
    Seen {
        parts: watch.parts.as_ref(),
        surface: sample(job, camera_ray, stream, watch),
    }
}

/// `None` if the ray meets no surface. `stream` is what the integrator has drawn from.
#[inline(never)]
fn sample(
    job: &RenderJob,
    (camera_ray, spacing): (&CameraRay, f32),
    stream: SampleStream,
    watch: &Watch,
) -> Option<LayerSample> {
    let ray = &camera_ray.ray;
    let trace = || {
        let differentials = camera_ray.scaled_differentials(spacing);
        first_surfaces(&job.world, ray, differentials.as_ref(), stream)
    };
    let known = watch.sight.as_ref().and_then(Sight::known);
    let found = known.unwrap_or_else(trace)?;
    let parameters = || job.world.surface_parameters(&found.ray, &found.found);
    let uv = match job.film.layers.contains(Layer::Uv) {
        true => found.uv.unwrap_or_else(parameters),
        false => Vec2::ZERO,
    };
    let instance = if job.film.layers.contains(Layer::Instance) {
        job.mattes
            .standing(job.world.geometry.standing(&found.found))
    } else {
        MatteId::default()
    };
    let at = job.camera.depth_and_blur(found.p, ray.time);
    Some(LayerSample {
        position: found.p.as_dvec3() + job.world_from_render,
        depth: at.depth,
        uv,
        material: job.mattes.material(found.material),
        instance,
        motion: motion(job, &found),
        coc: at.coc,
        albedo: found.albedo,
        // Render space is world space moved.
        normal: found.normal,
    })
}

/// See [`Layer::Motion`]; none where nothing moves, or where the camera does not see both ends of the way.
fn motion(job: &RenderJob, found: &FirstSurfaces) -> DVec2 {
    let Some(times) = job.motion_times else {
        return DVec2::ZERO;
    };
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
