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
    /// Its channels, those of [`Layer::channels`]: each row by row, as the image's pixels.
    pub channels: Vec<Vec<f32>>,
}

impl ImageLayer {
    /// These layers of so many pixels, all 0.
    pub(in super::super) fn all_of(set: LayerSet, pixels: usize) -> Vec<ImageLayer> {
        let black = |layer: Layer| ImageLayer {
            layer,
            channels: vec![vec![0.0; pixels]; layer.channels().len()],
        };
        let has_means = |layer: &Layer| layer.matte().is_none() && *layer != Layer::Lights;
        set.iter().filter(has_means).map(black).collect()
    }

    /// Its first three channels together, where it has so many.
    pub fn triples(&self) -> Vec<Rgb> {
        let [x, y, z, ..] = self.channels.as_slice() else {
            return Vec::new();
        };
        let pairs = x.iter().zip(y);
        pairs
            .zip(z)
            .map(|((&x, &y), &z)| Rgb::new(x, y, z))
            .collect()
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
        let shown: Vec<Shown> = { places.iter() }
            .map(|&(number, index)| Shown::new(pixels, number, index))
            .collect();
        let mut first = SHARED;
        for ImageLayer { layer, channels } in &mut self.means {
            for (channel, values) in channels.iter_mut().enumerate() {
                let sum = match layer {
                    Layer::Alpha => COVERED,
                    _ => first + channel,
                };
                develop_mean(values, (*layer, sum), pixels, &shown);
            }
            first += layer.sums();
        }
        if !self.lights.is_empty() {
            for &(number, index) in places {
                self.develop_lights(index, pixels.pixel(number), scale);
            }
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
        let own = self.means.iter().flat_map(|mean| &mean.channels);
        let own = own.map(move |values| values.get(pixel).copied().unwrap_or_default());
        let lights = self.lights.iter().flat_map(move |values| {
            let light = values.get(pixel).copied().unwrap_or_default();
            light.to_array()
        });
        own.chain(lights)
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

/// A pixel: its number among those that have sums, and its place in an image.
struct Shown {
    number: usize,
    index: usize,
    /// The share of it that a sample has which is seen, and one that meets a surface.
    of_seen: f64,
    of_hit: f64,
}

impl Shown {
    fn new(pixels: &LayerPixels, number: usize, index: usize) -> Shown {
        let sums = pixels.pixel(number);
        let [of_seen, of_hit] = [SEEN, HITS].map(|over| match sums.get(over) {
            Some(&over) if over > 0.0 => 1.0 / over,
            _ => 0.0,
        });
        Shown {
            number,
            index,
            of_seen,
            of_hit,
        }
    }
}

/// Sets pixels of a layer's channel to the means that their sums of this number are of.
fn develop_mean(
    values: &mut [f32],
    (layer, sum): (Layer, usize),
    pixels: &LayerPixels,
    shown: &[Shown],
) {
    // A filter with negative lobes may go beyond.
    let (of_hits, [low, high]) = match layer {
        Layer::Albedo | Layer::Alpha => (false, [0.0, 1.0]),
        Layer::Normal => (false, [-1.0, 1.0]),
        _ => (true, [f64::NEG_INFINITY, f64::INFINITY]),
    };
    let count = pixels.set.sums();
    for own in shown {
        let (sum, value) = (
            pixels.sums.get(own.number * count + sum),
            values.get_mut(own.index),
        );
        if let (Some(sum), Some(value)) = (sum, value) {
            let share = if of_hits { own.of_hit } else { own.of_seen };
            // Not a negative zero, which sums may or may not begin with.
            *value = ((sum * share).clamp(low, high) + 0.0) as f32;
        }
    }
}
