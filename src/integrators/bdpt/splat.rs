//! The light pass (t = 1): vertices of light paths are joined to the lens, and what they bring goes to the pixels around the film
//! point where it lands.

use super::light_path::{LightTracer, LightVertex};
use super::weights::{square, weight};
use crate::cameras::{Aim, Landing, LensSample};
use crate::film::PixelBounds;
use crate::integrators::LightJob;
use crate::integrators::volpath::transmittance;
use crate::math::{Rgb, UVec2, Vec2, color::is_black};
use crate::samplers::SampleStream;

/// Traces one light path onto the film.
pub(super) fn splat_path(
    tracer: &LightTracer,
    job: &LightJob,
    stream: &mut SampleStream,
    splat: &mut impl FnMut(UVec2, Rgb),
) {
    let time = job.camera.shutter().time(stream.next_1d());
    let wavelength = stream.next_1d_if(job.camera.disperses());
    tracer.trace(time, tracer.bdpt.max_depth, stream, |vertex, stream| {
        let lens = if job.camera.has_lens() {
            stream.next_2d()
        } else {
            Vec2::splat(0.5)
        };
        let at = LensSample { lens, wavelength };
        // No light where nothing can be joined.
        let _ = join(tracer, job, &vertex, &at, stream, splat);
    });
}

/// Joins a vertex to the lens.
fn join(
    tracer: &LightTracer,
    job: &LightJob,
    end: &LightVertex,
    at: &LensSample,
    stream: &mut SampleStream,
    splat: &mut impl FnMut(UVec2, Rgb),
) -> Option<()> {
    let from = end.vertex.reference_point();
    let aim: Aim = job.camera.aim(&from, at)?;
    let scattered = end.vertex.importance(aim.wi)?;
    let landing: Landing = job.camera.land(&aim)?;
    let joined = end.throughput * scattered.value * landing.importance;
    if is_black(joined) {
        return None;
    }
    let medium = end.vertex.medium_toward(tracer.world, aim.wi);
    let left = transmittance(tracer.world, stream, &aim.shadow, medium);
    if is_black(left) {
        return None;
    }
    // The camera's own samples come here with this density, in a pixel where those of the film have density 1.
    let cosine = f64::from(end.vertex.cosine(aim.wi));
    let camera = f64::from(landing.density) * cosine / f64::from(job.light_paths);
    let light = end.history.earlier(camera, scattered.reverse.into());
    for_pixels(job, landing.raster, |pixel, value, density| {
        let weight = weight(light * square(density.into()), 0.0);
        splat(pixel, joined * left * (value * weight));
    });
    Some(())
}

/// The pixels that count whose filter reaches the film point, with the filter's value and the density of their samples there.
fn for_pixels(job: &LightJob, raster: Vec2, mut visit: impl FnMut(UVec2, f32, f32)) {
    let radius = job.filter.radius();
    let PixelBounds { min, max } = job.bounds;
    // Pixel j's center is at j + ½.
    let low = (raster - radius - 0.5).ceil().max(min.as_vec2());
    let high = (raster + radius - 0.5).floor().min(max.as_vec2() - 1.0);
    let valid = low.cmple(high).all();
    if !valid {
        return;
    }
    let (low, high) = (low.as_uvec2(), high.as_uvec2());
    for y in low.y..=high.y {
        for x in low.x..=high.x {
            let pixel = UVec2::new(x, y);
            let offset = raster - pixel.as_vec2() - 0.5;
            let (density, weight) = job.filter.at(offset);
            if density > 0.0 {
                visit(pixel, density * weight, density);
            }
        }
    }
}
