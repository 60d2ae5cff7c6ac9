//! The layers of an image, made of the [sums](super::sums) of its pixels.

use super::coverage::ImageMatte;
use super::rows::{self, ALBEDO, NORMAL, SAMPLES, SEEN};
use super::sums::LayerPixels;
use super::{Layer, LayerSet, light_channels};
use crate::film::SharedRow;
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
        let has_means = |layer: &Layer| !layer.is_matte() && *layer != Layer::Lights;
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

    /// Sets pixels to what their sums tell, where both have them. Light is in units of 1/`scale`.
    pub(in super::super) fn develop(
        &mut self,
        pixels: &LayerPixels,
        rows: &[SharedRow],
        scale: f64,
    ) {
        self.develop_sums(pixels, rows, scale);
        let seen = |number: usize| pixels.pixel(number).get(SEEN).copied().unwrap_or(0.0);
        let mut rest = rows.iter().peekable();
        let place = |number: usize| {
            while rest.next_if(|row| row.own + row.pixels <= number).is_some() {}
            let row = rest.peek().filter(|row| row.own <= number)?;
            Some(row.other + (number - row.own))
        };
        pixels.coverage.develop(&mut self.mattes, seen, place);
    }

    /// The same but for Cryptomattes.
    pub(super) fn develop_sums(&mut self, pixels: &LayerPixels, rows: &[SharedRow], scale: f64) {
        let count = pixels.count();
        for row in rows {
            let sums = pixels.row(row.own, row.pixels);
            for (i, sums) in sums.chunks(TOGETHER * count).enumerate() {
                self.develop_means(pixels, sums, row.other + i * TOGETHER);
            }
            if !self.lights.is_empty() {
                for (i, sums) in sums.chunks_exact(count).enumerate() {
                    self.develop_lights(row.other + i, sums, scale);
                }
            }
        }
    }

    /// Sets pixels from number `first` on to the means of these sums of `pixels`, of [some](TOGETHER) of them at most.
    fn develop_means(&mut self, pixels: &LayerPixels, sums: &[f64], first: usize) {
        let count = pixels.count();
        let (shares, range) = (Shares::new(sums, count), first..first + sums.len() / count);
        for (i, which) in pixels.rows.iter().enumerate() {
            let which = usize::from(*which);
            let means = means(sums, count, (i, which), &shares);
            for (channel, place) in self.channels_of_row(which) {
                let values = channel.get_mut(range.clone()).unwrap_or_default();
                for (value, mean) in values.iter_mut().zip(&means[place]) {
                    *value = *mean;
                }
            }
        }
    }

    /// The channels whose sums are in this row, with their places in there.
    fn channels_of_row(&mut self, which: usize) -> impl Iterator<Item = (&mut [f32], usize)> {
        let means = self.means.iter_mut().filter_map(move |mean| {
            let (row, place) = rows::place(mean.layer)?;
            (row == which).then_some((mean, place))
        });
        means.flat_map(|(mean, place)| {
            let channels = mean.channels.iter_mut().map(Vec::as_mut_slice);
            channels.zip(place..4)
        })
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

/// Pixels that are developed together: a row of a tile.
const TOGETHER: usize = 16;

/// The shares of pixels that a sample has which is seen, and one that meets a surface.
struct Shares {
    of_seen: [f64; TOGETHER],
    of_hit: [f64; TOGETHER],
}

impl Shares {
    /// Of some pixels with so many sums each.
    fn new(sums: &[f64], count: usize) -> Shares {
        let mut shares = Shares {
            of_seen: [0.0; TOGETHER],
            of_hit: [0.0; TOGETHER],
        };
        let share = |over: f64| if over > 0.0 { 1.0 / over } else { 0.0 };
        let both = shares.of_seen.iter_mut().zip(&mut shares.of_hit);
        for ((of_seen, of_hit), sums) in both.zip(sums.chunks_exact(count)) {
            if let Some([seen, _, hits, _]) = sums.first_chunk() {
                (*of_seen, *of_hit) = (share(*seen), share(*hits));
            }
        }
        shares
    }
}

/// The means of the sums of some pixels, so many each, in their row number `i`, which is this one: a list for each of the four.
#[inline(never)]
fn means(
    sums: &[f64],
    count: usize,
    (i, which): (usize, usize),
    shares: &Shares,
) -> [[f32; TOGETHER]; 4] {
    // A filter with negative lobes may go beyond.
    let (shares, limits) = match which {
        0 | ALBEDO => (&shares.of_seen, Some([0.0, 1.0])),
        NORMAL => (&shares.of_seen, Some([-1.0, 1.0])),
        _ => (&shares.of_hit, None),
    };
    let mut means = [[0.0; TOGETHER]; 4];
    for (pixel, (share, sums)) in shares.iter().zip(sums.chunks_exact(count)).enumerate() {
        if let Some(sums) = sums.get(4 * i..4 * i + 4) {
            for (means, sum) in means.iter_mut().zip(sums) {
                means[pixel] = (sum * share) as f32;
            }
        }
    }
    // In loops of their own, which are compiled to vector instructions.
    for mean in means.as_flattened_mut() {
        // Not a negative zero, which sums may or may not begin with.
        *mean += 0.0;
    }
    if let Some([low, high]) = limits {
        for mean in means.as_flattened_mut() {
            *mean = mean.clamp(low, high);
        }
    }
    means
}
