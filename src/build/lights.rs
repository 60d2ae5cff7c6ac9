//! Places lights and loads their maps.

use crate::assets::image_data::ImageData;
use crate::budget::Budget;
use crate::lights::{Light, LightMap, LightSpec};
use crate::math::transform::Transform;
use crate::params::NamedFile;
use crate::syntax::{Diagnostic, Diagnostics};

/// Places every light in render space. A map that cannot be read is reported; the light then emits as if it had none,
/// as in pbrt-v3.
pub(super) fn place(
    specs: &[LightSpec],
    render_from_world: &Transform,
    diagnostics: &Diagnostics,
    budget: &Budget,
) -> Vec<Light> {
    let place = |spec: &LightSpec| {
        let file = spec.map.as_ref();
        let map = file.and_then(|file| load(file, diagnostics, budget));
        Light::new(spec, map, render_from_world)
    };
    specs.iter().map(place).collect()
}

fn load(file: &NamedFile, diagnostics: &Diagnostics, budget: &Budget) -> Option<LightMap> {
    match ImageData::load(&file.path, budget) {
        Ok(image) => {
            let texels = (0..image.height).flat_map(|y| (0..image.width).map(move |x| (x, y)));
            let texels = texels.map(|(x, y)| image.pixel(x, y)).collect();
            LightMap::new(image.width, image.height, texels)
        }
        Err(error) => {
            let diagnostic = Diagnostic::error(error.to_string()).at(file.span);
            diagnostics.push(diagnostic.recoverable().failed_if(error.is_failure));
            None
        }
    }
}
