//! What a path brings, by the layers of the lights that it comes from.

use crate::film::LayerSet;
use crate::handles::LightLayer;
use crate::math::Rgb;

/// Sums by layer of light.
#[derive(Clone, Copy, Debug)]
pub struct LightParts {
    parts: [Rgb; LayerSet::MAX_LIGHTS],
    /// What light that is added counts for.
    scale: Rgb,
}

impl Default for LightParts {
    fn default() -> LightParts {
        LightParts {
            parts: [Rgb::ZERO; LayerSet::MAX_LIGHTS],
            scale: Rgb::ONE,
        }
    }
}

impl LightParts {
    /// The sums of the first `count` layers, times `factor`.
    pub fn scaled(&self, factor: Rgb, count: usize) -> impl Iterator<Item = Rgb> {
        self.parts.into_iter().take(count).map(move |part| {
            let value = part * factor;
            // Of a sample that is dropped, nothing.
            if value.is_finite() { value } else { Rgb::ZERO }
        })
    }

    /// What is added from now on counts for so much.
    pub(super) fn scale(&mut self, scale: Rgb) {
        self.scale = scale;
    }

    /// Adds light.
    pub(super) fn add(&mut self, layer: LightLayer, light: Rgb) {
        if let Some(part) = self.parts.get_mut(layer.index()) {
            *part += light * self.scale;
        }
    }
}
