//! The layers of an image, made of the [sums](super::sums) of its pixels.

use super::coverage::ImageMatte;
use super::sums::{COVERED, HITS, LayerPixels, SAMPLES, SEEN, SHARED};
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

    /// Sets pixels to what their sums tell: for each in turn the one that `places` say, if any. Light is in units of 1/`scale`.
    pub(in super::super) fn develop(
        &mut self,
        pixels: &LayerPixels,
        places: &[Option<usize>],
        scale: f64,
    ) {
        let numbered = places.iter().enumerate();
        let shown = numbered.filter_map(|(number, place)| Some((number, (*place)?)));
        self.develop_sums(pixels, &shown.collect::<Vec<_>>(), scale);
        let place = |number: usize| places.get(number).copied().flatten();
        let seen = |number: usize| pixels.pixel(number).first().copied().unwrap_or(0.0);
        for matte in &mut self.mattes {
            if let Some(kind) = matte.layer.matte() {
                pixels.mattes[kind].develop(matte, seen, place);
            }
        }
    }

    /// Sets pixels to what sums tell, but for Cryptomattes: by the numbers that both have.
    pub(super) fn develop_sums(
        &mut self,
        pixels: &LayerPixels,
        places: &[(usize, usize)],
        scale: f64,
    ) {
        let mut first = SHARED;
        for ImageLayer { layer, values } in &mut self.means {
            let shown = (*layer, first);
            match layer.channels().len() {
                1 => develop_mean::<1>(values, shown, pixels, places),
                2 => develop_mean::<2>(values, shown, pixels, places),
                _ => develop_mean::<3>(values, shown, pixels, places),
            }
            first += layer.sums();
        }
        for &(number, index) in places {
            self.develop_lights(index, pixels.pixel(number), scale);
        }
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
        let all = sums.get(SAMPLES).copied().unwrap_or_default();
        let sums = sums.get(first..).unwrap_or_default().chunks_exact(3);
        for (values, sums) in self.lights.iter_mut().zip(sums) {
            if let Some(slot) = values.get_mut(index) {
                let mean = DVec3::from_slice(sums) * (scale / all.max(1.0));
                *slot = mean.max(DVec3::ZERO).as_vec3();
            }
        }
    }
}

/// Sets pixels of a layer, of `N` channels, to the means that their sums are of, the first of which is there.
fn develop_mean<const N: usize>(
    values: &mut [Rgb],
    (layer, first): (Layer, usize),
    pixels: &LayerPixels,
    places: &[(usize, usize)],
) {
    let first = if layer == Layer::Alpha {
        COVERED
    } else {
        first
    };
    // A filter with negative lobes may go beyond.
    let (over, [low, high]) = match layer {
        Layer::Albedo | Layer::Alpha => (SEEN, [0.0, 1.0]),
        Layer::Normal => (SEEN, [-1.0, 1.0]),
        _ => (HITS, [f64::NEG_INFINITY, f64::INFINITY]),
    };
    for &(number, index) in places {
        let sums = pixels.pixel(number);
        let (Some(sums), Some(&over)) = (sums.get(first..first + N), sums.get(over)) else {
            continue;
        };
        let mut value = Rgb::ZERO;
        for (value, sum) in value.as_mut().iter_mut().zip(sums) {
            let mean = if over > 0.0 { sum / over } else { 0.0 };
            // Not a negative zero, which sums may or may not begin with.
            *value = (mean.clamp(low, high) + 0.0) as f32;
        }
        if let Some(slot) = values.get_mut(index) {
            *slot = value;
        }
    }
}
