//! The layers of an image, made of the [sums](super::sums) of its pixels.

use super::coverage::ImageMatte;
use super::planes::Planes;
use super::rows::{self, ALBEDO, NORMAL, ROWS, SAMPLES, SEEN};
use super::sums::LayerPixels;
use super::{Layer, LayerSet, light_channels};
use crate::film::SharedRow;
use crate::math::instruction_set::{Instructions, Kernel, WIDEST, vectorize};
use crate::math::{DVec3, Rgb, Vec4};
use arrayvec::ArrayVec;
use glam::Mat4;

/// A layer of all pixels of an image.
#[derive(Clone, Copy, Debug)]
pub struct ImageLayer<'a> {
    /// Which.
    pub layer: Layer,
    first: usize,
    planes: &'a Planes,
}

impl<'a> ImageLayer<'a> {
    /// Its channels, those of [`Layer::channels`]: each row by row, as the image's pixels.
    pub fn channels(&self) -> impl Iterator<Item = &'a [f32]> + use<'a> {
        self.planes.some(self.first, self.layer.channels().len())
    }

    /// Its first three channels together, where it has so many.
    pub fn triples(&self) -> Vec<Rgb> {
        let channels: Vec<_> = self.channels().collect();
        let [x, y, z, ..] = channels.as_slice() else {
            return Vec::new();
        };
        let pairs = x.iter().zip(*y);
        pairs
            .zip(*z)
            .map(|((&x, &y), &z)| Rgb::new(x, y, z))
            .collect()
    }
}

/// All layers of an image.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ImageLayers {
    /// Those that are means over pixels, in the order of [`Layer::ALL`], with their first planes.
    means: Vec<(Layer, usize)>,
    planes: Planes,
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
        let mut planes = 0;
        let has_means = |layer: &Layer| !layer.is_matte() && *layer != Layer::Lights;
        let means = set.iter().filter(has_means).map(|layer| {
            let first = planes;
            planes += layer.channels().len();
            (layer, first)
        });
        ImageLayers {
            means: means.collect(),
            planes: Planes::new(planes, pixels),
            mattes: Vec::new(),
            // Not a list of copies: that would be made of an image that is there for a while even if none is wanted.
            lights: (0..set.lights()).map(|_| vec![Rgb::ZERO; pixels]).collect(),
        }
    }

    /// Means over pixels, in the order of [`Layer::ALL`].
    pub fn means(&self) -> impl Iterator<Item = ImageLayer<'_>> {
        let planes = &self.planes;
        self.means.iter().map(move |&(layer, first)| ImageLayer {
            layer,
            first,
            planes,
        })
    }

    /// The mean of this layer.
    pub fn mean(&self, layer: Layer) -> Option<ImageLayer<'_>> {
        self.means().find(|own| own.layer == layer)
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
        let mut rest = rows;
        let place = |number: usize| {
            while let [row, others @ ..] = rest
                && row.own + row.pixels <= number
            {
                rest = others;
            }
            let row = rest.first().filter(|row| row.own <= number)?;
            Some(row.other + (number - row.own))
        };
        pixels.coverage.develop(&mut self.mattes, seen, place);
    }

    /// The same but for Cryptomattes.
    pub(super) fn develop_sums(&mut self, pixels: &LayerPixels, rows: &[SharedRow], scale: f64) {
        vectorize::<WIDEST, _>(Means {
            targets: &self.targets(pixels),
            planes: &mut self.planes,
            pixels,
            rows,
        });
        if self.lights.is_empty() {
            return;
        }
        for row in rows {
            let sums = pixels.row(row.own, row.pixels);
            for (i, sums) in sums.chunks_exact(pixels.count()).enumerate() {
                self.develop_lights(row.other + i, sums, scale);
            }
        }
    }

    /// Where the means of each row of sums go.
    fn targets(&self, pixels: &LayerPixels) -> ArrayVec<Target, ROWS> {
        let target = |which: &u8| {
            let row = usize::from(*which);
            let mut planes = [None; 4];
            for &(layer, first) in &self.means {
                let at = rows::place(layer).filter(|(own, _)| *own == row);
                let places = at.map_or(4..4, |(_, place)| place..4);
                for (i, place) in places.take(layer.channels().len()).enumerate() {
                    planes[place] = Some(first + i);
                }
            }
            Target { row, planes }
        };
        pixels.rows.iter().map(target).collect()
    }

    /// The names of the channels of all but Cryptomattes, where layers of light have these names.
    pub(crate) fn channels(&self, lights: &[String]) -> Vec<String> {
        let own = self.means.iter().flat_map(|(layer, _)| layer.channels());
        let lights =
            { lights.iter().take(self.lights.len()) }.flat_map(|name| light_channels(name));
        own.map(ToString::to_string).chain(lights).collect()
    }

    /// The values of a pixel in these channels.
    pub(crate) fn values(&self, pixel: usize) -> impl Iterator<Item = f32> {
        let own = self.means().flat_map(|mean| mean.channels());
        let own = own.map(move |values| values.get(pixel).copied().unwrap_or_default());
        let lights = self.lights.iter().flat_map(move |values| {
            let light = values.get(pixel).copied().unwrap_or_default();
            light.to_array()
        });
        own.chain(lights)
    }

    /// Negative where a filter's lobes make it so, so that they add up to the colors where these are not.
    fn develop_lights(&mut self, index: usize, sums: &[f64], scale: f64) {
        let first = sums.len().saturating_sub(3 * self.lights.len());
        let all = sums.get(SAMPLES).copied().unwrap_or_default();
        let sums = sums.get(first..).unwrap_or_default().chunks_exact(3);
        for (values, sums) in self.lights.iter_mut().zip(sums) {
            if let Some(slot) = values.get_mut(index) {
                let mean = DVec3::from_slice(sums) * (scale / all.max(1.0));
                *slot = mean.as_vec3();
            }
        }
    }
}

/// A row of sums, and the planes of its four means, of those that are wanted.
struct Target {
    row: usize,
    planes: [Option<usize>; 4],
}

/// Sets pixels of `planes` to the means of the sums of `pixels`.
struct Means<'a> {
    planes: &'a mut Planes,
    targets: &'a [Target],
    pixels: &'a LayerPixels,
    rows: &'a [SharedRow],
}

impl Kernel for Means<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self, _: impl Instructions) {
        let count = self.pixels.count();
        for row in self.rows {
            let sums = self.pixels.row(row.own, row.pixels);
            for (i, sums) in sums.chunks(TOGETHER * count).enumerate() {
                let (shares, first) = (Shares::new(sums, count), row.other + i * TOGETHER);
                for (place, target) in self.targets.iter().enumerate() {
                    let means = means(sums, count, (place, target.row), &shares);
                    for (plane, means) in target.planes.iter().zip(&means) {
                        let Some(plane) = *plane else { continue };
                        let own = self.planes.row(plane, first, sums.len() / count);
                        let values = own.iter_mut().zip(means.as_flattened());
                        values.for_each(|(value, mean)| *value = *mean);
                    }
                }
            }
        }
    }
}

/// Pixels that are developed together, four by four: a row of a tile.
const TOGETHER: usize = 4 * QUADS;
const QUADS: usize = 4;

/// The shares of pixels that a sample has which is seen, and one that meets a surface.
struct Shares {
    of_seen: [f64; TOGETHER],
    of_hit: [f64; TOGETHER],
}

impl Shares {
    /// Of some pixels with so many sums each.
    #[inline(always)]
    fn new(sums: &[f64], count: usize) -> Shares {
        let mut shares = Shares {
            of_seen: [0.0; TOGETHER],
            of_hit: [0.0; TOGETHER],
        };
        let both = shares.of_seen.iter_mut().zip(&mut shares.of_hit);
        for ((of_seen, of_hit), sums) in both.zip(sums.chunks_exact(count)) {
            if let Some([seen, _, hits, _]) = sums.first_chunk() {
                (*of_seen, *of_hit) = (*seen, *hits);
            }
        }
        for shares in [&mut shares.of_seen, &mut shares.of_hit] {
            // In a loop of its own, which is compiled to vector instructions.
            for over in shares {
                *over = if *over > 0.0 { 1.0 / *over } else { 0.0 };
            }
        }
        shares
    }
}

/// The means of the sums of some pixels, so many each, in their row number `i`, which is this one: a list for each of the four.
#[inline(always)]
fn means(
    sums: &[f64],
    count: usize,
    (i, which): (usize, usize),
    shares: &Shares,
) -> [[[f32; 4]; QUADS]; 4] {
    // A filter with negative lobes may go beyond.
    let (shares, limits) = match which {
        0 | ALBEDO => (&shares.of_seen, Some([Vec4::ZERO, Vec4::ONE])),
        NORMAL => (&shares.of_seen, Some([Vec4::NEG_ONE, Vec4::ONE])),
        _ => (&shares.of_hit, None),
    };
    let mut own = [Vec4::ZERO; TOGETHER];
    for (own, (share, sums)) in own
        .iter_mut()
        .zip(shares.iter().zip(sums.chunks_exact(count)))
    {
        let sums = sums.get(4 * i..).and_then(|sums| sums.first_chunk());
        if let Some(sums) = sums {
            // Not a negative zero, which sums may or may not begin with.
            *own = Vec4::from_array(sums.map(|sum: f64| (sum * share) as f32)) + Vec4::ZERO;
        }
    }
    if let Some([low, high]) = limits {
        for own in &mut own {
            *own = own.clamp(low, high);
        }
    }
    let mut means = [[[0.0; 4]; QUADS]; 4];
    for (quad, pixels) in own.as_chunks().0.iter().enumerate() {
        let [a, b, c, d] = *pixels;
        let columns = Mat4::from_cols(a, b, c, d).transpose().to_cols_array_2d();
        for (means, values) in means.iter_mut().zip(columns) {
            means[quad] = values;
        }
    }
    means
}

#[cfg(test)]
mod tests {
    use super::super::all;
    use super::*;

    /// More pixels than are developed together, and not a multiple of four: each has the means of its own sums.
    #[test]
    fn pixels_have_the_means_of_their_sums() {
        const PIXELS: usize = TOGETHER + 7;
        let mut pixels = LayerPixels::new(all(), PIXELS).unwrap();
        let count = pixels.count();
        for (i, sum) in pixels.sums.iter_mut().enumerate() {
            *sum = (i as f64).sin();
        }
        // The third pixel has met nothing.
        let met = |pixel: usize| if pixel == 2 { [0.0, 0.0] } else { [4.0, 3.0] };
        for (pixel, sums) in pixels.sums.chunks_mut(count).enumerate() {
            [sums[SEEN], sums[rows::HITS]] = met(pixel);
        }
        let mut layers = ImageLayers::new(all(), PIXELS + 5);
        let row = SharedRow {
            own: 0,
            other: 3,
            pixels: PIXELS,
        };
        layers.develop_sums(&pixels, &[row], 1.0);
        for mean in layers.means() {
            let (row, place) = rows::place(mean.layer).unwrap();
            for (i, channel) in mean.channels().enumerate() {
                let expected = (0..PIXELS).map(|pixel| {
                    let (sum, [seen, hits]) =
                        (pixels.pixel(pixel)[4 * row + place + i], met(pixel));
                    let over = if row <= NORMAL { seen } else { hits };
                    let mean = if over > 0.0 { sum * (1.0 / over) } else { 0.0 };
                    match row {
                        0 | ALBEDO => mean.clamp(0.0, 1.0) as f32,
                        NORMAL => mean.clamp(-1.0, 1.0) as f32,
                        _ => mean as f32,
                    }
                });
                let expected: Vec<f32> = expected.collect();
                assert_eq!(channel[3..][..PIXELS], expected, "{:?} {i}", mean.layer);
                assert!(
                    channel[..3]
                        .iter()
                        .chain(&channel[PIXELS + 3..])
                        .all(|&v| v == 0.0)
                );
            }
        }
    }
}
