//! From a point of the film to the pixels that light there counts for.

use super::LightJob;
use crate::film::PixelBounds;
use crate::math::{UVec2, Vec2};

/// Returns `true` if any pixel's filter may reach the film point, as it is or around the edge of the image.
pub(super) fn reaches_film(job: &LightJob, raster: Vec2) -> bool {
    let PixelBounds { min, max } = job.bounds;
    let reach = job.filter.radius();
    let inside = raster.cmpge(min.as_vec2() - reach) & raster.cmple(max.as_vec2() + reach);
    inside.all()
        || !job
            .camera
            .raster_copies(raster, reach.max_element())
            .is_empty()
}

/// The pixels that count whose filter reaches the film point, with the filter's value and the density of their samples there.
pub(super) fn for_pixels(job: &LightJob, raster: Vec2, mut visit: impl FnMut(UVec2, f32, f32)) {
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
