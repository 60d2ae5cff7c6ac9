//! The layers of an image, made of the [sums](super::sums) of its pixels.

use super::coverage::ImageMatte;
use super::sums::{LayerPixels, SHARED};
use super::{Layer, LayerSet, light_channels};
use crate::math::{DVec3, Rgb};

/// A layer of all pixels of an image.
#[derive(Clone, Debug, PartialEq)]
pub struct ImageLayer {
    /// Which.
    pub layer: Layer,
    /// Row by row, as the image's pixels: the layer's channels, of which there may be fewer than three.
    pub values: Vec<Rgb>,
}

impl ImageLayer {
    /// These layers of so many pixels, all 0.
    pub(in super::super) fn all_of(set: LayerSet, pixels: usize) -> Vec<ImageLayer> {
        let black = |layer| ImageLayer {
            layer,
            values: vec![Rgb::ZERO; pixels],
        };
        let has_means = |layer: &Layer| layer.matte().is_none() && *layer != Layer::Lights;
        set.iter().filter(has_means).map(black).collect()
    }
}

/// All layers of an image.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ImageLayers {
    /// Means over pixels, in the order of [`Layer::ALL`].
    pub means: Vec<ImageLayer>,
    /// Cryptomattes.
    pub mattes: Vec<ImageMatte>,
    /// The image by groups of its lights: first of those that have none, then in the order in which the scene names them.
    pub lights: Vec<Vec<Rgb>>,
}

impl ImageLayers {
    /// These layers of so many pixels, all 0.
    pub(in super::super) fn new(set: LayerSet, pixels: usize) -> ImageLayers {
        ImageLayers {
            mattes: ImageMatte::all_of(set, pixels),
            ..ImageLayers::without_mattes(set, pixels)
        }
    }

    /// The same but for Cryptomattes.
    pub(super) fn without_mattes(set: LayerSet, pixels: usize) -> ImageLayers {
        ImageLayers {
            means: ImageLayer::all_of(set, pixels),
            mattes: Vec::new(),
            lights: vec![vec![Rgb::ZERO; pixels]; set.lights()],
        }
    }

    /// The mean of this layer.
    pub fn mean(&self, layer: Layer) -> Option<&ImageLayer> {
        self.means.iter().find(|own| own.layer == layer)
    }

    /// Sets pixels to what their sums tell: the one that `place` says, if any, for each of the first `count`. Light is in units of 1/`scale`.
    pub(in super::super) fn develop(
        &mut self,
        pixels: &LayerPixels,
        count: usize,
        scale: f64,
        place: impl Fn(usize) -> Option<usize>,
    ) {
        for number in 0..count {
            if let Some(index) = place(number) {
                self.develop_pixel(index, pixels.pixel(number), scale);
            }
        }
        let seen = |number: usize| pixels.pixel(number).first().copied().unwrap_or(0.0);
        for matte in &mut self.mattes {
            if let Some(kind) = matte.layer.matte() {
                pixels.mattes[kind].develop(matte, seen, &place);
            }
        }
    }

    /// Sets a pixel to what these sums tell, but for Cryptomattes.
    pub(super) fn develop_pixel(&mut self, index: usize, sums: &[f64], scale: f64) {
        develop_means(&mut self.means, index, sums);
        self.develop_lights(index, sums, scale);
    }

    /// The names of the channels of all but Cryptomattes, where layers of light have these names.
    pub(crate) fn channels(&self, lights: &[String]) -> Vec<String> {
        let own = self.means.iter().flat_map(|mean| mean.layer.channels());
        let lights =
            { lights.iter().take(self.lights.len()) }.flat_map(|name| light_channels(name));
        own.map(ToString::to_string).chain(lights).collect()
    }

    /// The values of a pixel in these channels.
    pub(crate) fn values(&self, pixel: usize) -> impl Iterator<Item = f32> {
        let own = { self.means.iter() }.map(|mean| (mean.layer.channels().len(), &mean.values));
        let lights = self.lights.iter().map(|values| (3, values));
        own.chain(lights).flat_map(move |(components, values)| {
            let value = values.get(pixel).copied().unwrap_or_default();
            value.to_array().into_iter().take(components)
        })
    }

    /// As colors are: nothing is negative.
    fn develop_lights(&mut self, index: usize, sums: &[f64], scale: f64) {
        let first = sums.len().saturating_sub(3 * self.lights.len());
        let all = sums.get(SHARED - 1).copied().unwrap_or_default();
        let sums = sums.get(first..).unwrap_or_default().chunks_exact(3);
        for (values, sums) in self.lights.iter_mut().zip(sums) {
            if let Some(slot) = values.get_mut(index) {
                let mean = DVec3::from_slice(sums) * (scale / all.max(1.0));
                *slot = mean.max(DVec3::ZERO).as_vec3();
            }
        }
    }
}

/// Sets a pixel of the image's layers to the means that these sums are of.
fn develop_means(layers: &mut [ImageLayer], index: usize, sums: &[f64]) {
    let Some((&[seen, covered, hits, _], mut own)) = sums.split_first_chunk::<SHARED>() else {
        return;
    };
    for ImageLayer { layer, values } in layers {
        let Some((sums, rest)) = own.split_at_checked(layer.sums()) else {
            return;
        };
        own = rest;
        let mean = |over: f64| {
            let mut mean = DVec3::ZERO;
            for (mean, sum) in mean.as_mut().iter_mut().zip(sums) {
                *mean = if over > 0.0 { sum / over } else { 0.0 };
            }
            mean
        };
        let value = match layer {
            // A filter with negative lobes may go beyond.
            Layer::Albedo => mean(seen).clamp(DVec3::ZERO, DVec3::ONE),
            Layer::Normal => mean(seen).clamp(DVec3::NEG_ONE, DVec3::ONE),
            Layer::Alpha if seen > 0.0 => DVec3::splat((covered / seen).clamp(0.0, 1.0)),
            Layer::Alpha => DVec3::ZERO,
            Layer::Depth | Layer::Position | Layer::Uv | Layer::Motion | Layer::Coc => mean(hits),
            Layer::Material | Layer::Instance | Layer::Lights => continue,
        };
        if let Some(slot) = values.get_mut(index) {
            // Not a negative zero, which sums may or may not begin with.
            *slot = (value + 0.0).as_vec3();
        }
    }
}
