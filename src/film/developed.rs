//! The image that a film becomes, made tile by tile: of a pixel whose samples are all there nothing is kept but its color and,
//! where they are wanted, its variances. An image of 24 megapixels takes 0.3 GB that way, 0.9 GB with variances.

use super::layers::{ImageLayers, LayerPixels};
use super::{DroppedSample, DroppedSplat, FilmSpec, Image, PixelBounds, PixelStatistics, Tile};
use crate::math::{Rgb, UVec2};
use glam::DVec3;

/// What is to be known of a pixel besides its color.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kept {
    /// Nothing.
    Color,
    /// The variance of its mean, if its samples are independent.
    Variance,
    /// That, and the difference of two halves, from which [pooled](Developed::pool) variances are made.
    Halves,
}

/// An image, and what was dropped of it.
#[derive(Clone, Debug)]
pub struct Developed {
    pub(super) scale: f64,
    pub(super) image: Image,
    /// Half the difference of a pixel's halves; not a number where one of them has no samples.
    pub(super) differences: Option<Vec<Rgb>>,
    pub(super) samples: u64,
    pub(super) dropped: u64,
    pub(super) first_dropped: Option<DroppedSample>,
    pub(super) paths: u64,
    pub(super) first_dropped_splat: Option<DroppedSplat>,
}

impl Developed {
    /// A black image.
    pub fn new(spec: &FilmSpec, kept: Kept) -> Developed {
        Developed::within(spec, spec.pixel_bounds(), kept)
    }

    /// A black image of these pixels.
    pub(super) fn within(spec: &FilmSpec, bounds: PixelBounds, kept: Kept) -> Developed {
        let black = || vec![Rgb::ZERO; bounds.area()];
        Developed {
            scale: f64::from(spec.scale),
            image: Image {
                resolution: spec.resolution,
                bounds,
                pixels: black(),
                variance: (kept != Kept::Color).then(black),
                independent: None,
                layers: ImageLayers::new(spec.layers, bounds.area()),
            },
            differences: (kept == Kept::Halves).then(|| vec![Rgb::NAN; bounds.area()]),
            samples: 0,
            dropped: 0,
            first_dropped: None,
            paths: 0,
            first_dropped_splat: None,
        }
    }

    /// Adds a tile with all its samples.
    pub fn place(&mut self, tile: &Tile) {
        for (pixel, statistics) in tile.iter() {
            self.set(pixel, statistics);
        }
        if let Some(layers) = tile.layers() {
            self.set_layers(tile.bounds(), layers);
        }
        self.count_dropped(tile);
    }

    /// Adds a tile in two halves, with all samples of both: its pixels are their means ([`PixelStatistics::mean_of`]).
    pub fn place_halves(&mut self, halves: &[Tile; 2]) {
        for ((pixel, a), (_, b)) in halves[0].iter().zip(halves[1].iter()) {
            self.set(pixel, &PixelStatistics::mean_of(a, b));
            self.differ(
                pixel,
                [a, b].map(|half| (half.count() > 0).then(|| half.mean())),
            );
        }
        if let [Some(a), Some(b)] = halves.each_ref().map(Tile::layers) {
            let mut both = a.clone();
            both.join_halves(b);
            self.set_layers(halves[0].bounds(), &both);
        }
        halves.iter().for_each(|half| self.count_dropped(half));
    }

    /// Sets the layers of some pixels.
    pub(super) fn set_layers(&mut self, bounds: PixelBounds, sums: &LayerPixels) {
        let Image {
            layers,
            bounds: own,
            ..
        } = &mut self.image;
        layers.develop(sums, &bounds.shared_rows(*own), self.scale);
    }

    /// Sets a pixel: mean × film scale, negative channels clamped to 0 as in pbrt-v3's film (docs/scene-language.md §4.1). The
    /// variance is that of the mean before clamping.
    pub(super) fn set(&mut self, pixel: UVec2, statistics: &PixelStatistics) {
        let Some(index) = self.image.bounds.index(pixel) else {
            return;
        };
        self.samples += statistics.count();
        let color = statistics.mean() * self.scale;
        self.image.pixels[index] = color.max(DVec3::ZERO).as_vec3();
        if let Some(variance) = &mut self.image.variance {
            let own = statistics.variance_of_mean() * (self.scale * self.scale);
            variance[index] = own.as_vec3();
        }
    }

    /// The means of a pixel's halves, where they have samples.
    pub(super) fn differ(&mut self, pixel: UVec2, means: [Option<DVec3>; 2]) {
        let index = self.image.bounds.index(pixel);
        if let (Some(differences), Some(index), [Some(p), Some(q)]) =
            (&mut self.differences, index, means)
        {
            differences[index] = (0.5 * self.scale * (p - q)).as_vec3();
        }
    }

    fn count_dropped(&mut self, tile: &Tile) {
        self.dropped = self.dropped.saturating_add(tile.dropped());
        self.first_dropped = DroppedSample::first(self.first_dropped, tile.first_dropped());
    }

    /// The image, when all tiles are there.
    pub fn image(self) -> Image {
        self.image
    }

    /// The pixels that are rendered: the crop window.
    pub fn bounds(&self) -> PixelBounds {
        self.image.bounds
    }

    /// Number of samples of all pixels.
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// Number of samples and splats dropped because they were not finite or clearly negative; each counts as black.
    pub fn dropped(&self) -> u64 {
        self.dropped
    }

    /// The first of them, row by row, regardless of how the film was divided into tiles.
    pub fn first_dropped(&self) -> Option<DroppedSample> {
        self.first_dropped
    }

    /// The first splat that was dropped.
    pub fn first_dropped_splat(&self) -> Option<DroppedSplat> {
        self.first_dropped_splat
    }

    /// Number of light paths whose splats have been added.
    pub fn paths(&self) -> u64 {
        self.paths
    }
}
