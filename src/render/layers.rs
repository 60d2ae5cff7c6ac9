//! What a camera sample tells the image's layers.

use super::RenderJob;
use crate::cameras::CameraRay;
use crate::film::{Layer, LayerSample};
use crate::integrators::witness::Watch;
use crate::integrators::{Sight, first_surfaces};
use crate::math::ray::RayDifferentials;
use crate::samplers::SampleStream;

/// Of a ray that has left the lens and whose path `watch` has looked at; `None` if it meets no surface. `stream` is what the
/// integrator has drawn from.
#[inline(never)]
pub(super) fn sample(
    job: &RenderJob,
    camera_ray: &CameraRay,
    differentials: Option<&RayDifferentials>,
    stream: SampleStream,
    watch: &mut Watch,
) -> Option<LayerSample> {
    let ray = &camera_ray.ray;
    let known = watch.sight.take().as_ref().and_then(Sight::known);
    let found = known.unwrap_or_else(|| first_surfaces(&job.world, ray, differentials, stream))?;
    let uv = if found.is_bare && job.film.layers.contains(Layer::Uv) {
        job.world.surface_parameters(ray)
    } else {
        found.uv
    };
    let at = job.camera.depth_and_blur(found.p, ray.time);
    Some(LayerSample {
        position: found.p.as_dvec3() + job.world_from_render,
        depth: at.depth,
        uv,
        coc: at.coc,
        albedo: found.albedo,
        // Render space is world space moved.
        normal: found.normal,
    })
}
