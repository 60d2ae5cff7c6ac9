//! A point of a surface, and what inputs of materials are there.

use super::Material;
use super::inputs::{INDICES, USUAL_INDEX};
use crate::inputs::{FloatInput, SpectrumInput};
use crate::math::Rgb;
use crate::math::float::clamp_nan_low;
use crate::surface::TexturePoint;
use crate::textures::Textures;

/// Maximum reflectance: keeps sums and products of absurd values finite.
const MAX_REFLECTANCE: f32 = 1e6;

/// A point, with what is looked up there.
#[derive(Clone, Copy)]
pub(super) struct Place<'p, 'm> {
    pub point: TexturePoint,
    pub textures: &'p Textures,
    /// Those of the scene, for the handles of mixes.
    pub materials: &'m [Material],
}

impl Place<'_, '_> {
    /// An input as it is.
    pub(super) fn float(&self, input: &FloatInput) -> f32 {
        self.textures.float(input, &self.point)
    }

    /// An input, clamped to low…high; NaN counts as `low`.
    pub(super) fn within(&self, input: &FloatInput, low: f32, high: f32) -> f32 {
        clamp_nan_low(self.float(input), low, high)
    }

    /// An input, clamped to 0…1.
    pub(super) fn unit(&self, input: &FloatInput) -> f32 {
        self.within(input, 0.0, 1.0)
    }

    /// An input, clamped to 0 and above.
    pub(super) fn strength(&self, input: &FloatInput) -> f32 {
        self.within(input, 0.0, MAX_REFLECTANCE)
    }

    /// A refractive index; invalid texture values count as 1.5.
    pub(super) fn refractive_index(&self, input: &FloatInput) -> f32 {
        as_refractive_index(self.float(input))
    }

    /// A color as it is.
    pub(super) fn spectrum(&self, input: &SpectrumInput) -> Rgb {
        self.textures.spectrum(input, &self.point)
    }

    /// A reflectance: negative values, and NaN, count as 0.
    pub(super) fn reflectance(&self, input: &SpectrumInput) -> Rgb {
        as_reflectance(self.spectrum(input))
    }
}

/// A color as a reflectance: see [`Place::reflectance`].
pub(super) fn as_reflectance(given: Rgb) -> Rgb {
    given.map(|x| clamp_nan_low(x, 0.0, MAX_REFLECTANCE))
}

/// A refractive index; invalid ones count as 1.5.
pub(super) fn as_refractive_index(given: f32) -> f32 {
    if given > 0.0 {
        given.clamp(*INDICES.start(), *INDICES.end())
    } else {
        USUAL_INDEX
    }
}
