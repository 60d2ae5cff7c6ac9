//! How an image's numbers are stored in a file, where there is a choice.

use super::{Image, Layer};

/// A choice for each kind of file.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Encoding {
    /// `.exr`: in half floats what loses nothing that is seen: colors, albedo, normals and alpha. They have 11 bits; beyond
    /// ±65504 they are clamped. Variances would become 0, and places and depths would be off by a pixel: they keep 32 bits.
    pub half: bool,
    /// `.png` and `.tga`: the image is brighter by so many stops, factors of 2.
    pub stops: f64,
}

impl Encoding {
    /// Returns `true` if a channel of this layer, or of the colors, is stored in half floats.
    pub(super) fn halves(&self, layer: Option<Layer>) -> bool {
        let fits = match layer {
            None | Some(Layer::Albedo | Layer::Normal | Layer::Alpha | Layer::Lights) => true,
            Some(Layer::Depth | Layer::Position | Layer::Uv | Layer::Motion | Layer::Coc) => false,
            Some(Layer::Material | Layer::Instance) => false,
        };
        self.half && fits
    }

    /// What linear values are multiplied by in an image to look at.
    pub(super) fn gain(&self) -> f32 {
        self.stops.exp2() as f32
    }
}

/// The half float next to `value`, which is clamped to the finite ones. What is not a number stays so.
pub(super) fn half(value: f32) -> ::half::f16 {
    let most = ::half::f16::MAX.to_f32();
    ::half::f16::from_f32(value.clamp(-most, most))
}

impl Image {
    /// Pixels whose colors half floats cannot hold: [`Encoding::half`] clamps them.
    #[must_use]
    pub fn beyond_half(&self) -> usize {
        let most = ::half::f16::MAX.to_f32();
        let is_beyond = |pixel: &&crate::math::Rgb| pixel.max_element() > most;
        self.pixels.iter().filter(is_beyond).count()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Rgb, UVec2};

    #[test]
    fn half_floats_are_finite() {
        let as_half = |value: f32| half(value).to_f32();
        assert_eq!(as_half(1e9), 65504.0);
        assert_eq!(as_half(f32::INFINITY), 65504.0);
        assert_eq!(as_half(-1e9), -65504.0);
        // Just below, from where rounding would go to infinity.
        assert_eq!(as_half(65530.0), 65504.0);
        assert_eq!(as_half(0.5), 0.5);
        assert!(half(f32::NAN).is_nan());
        let mut image = Image::black(UVec2::new(2, 1));
        image.pixels[1] = Rgb::new(0.0, 65505.0, 0.0);
        assert_eq!(image.beyond_half(), 1);
    }
}
