//! The film: accumulates samples into pixels, and writes images to files.
//!
//! A [`FilmSpec`] is the scene file's `Film` directive. Workers fill [`Tile`]s, each owned by one thread. [`Developed`] collects
//! them, and keeps of each what the image needs; where more samples or more light are to come, a [`Film`] keeps all.
//! Either becomes an [`Image`], which [`write()`] saves to an EXR, PNG, TGA or PFM file and [`read()`] reads back.
//!
//! A pixel is the mean of its own samples: reconstruction filters are importance-sampled (Ernst, Stamminger, Greiner
//! 2006) and nothing is splatted onto neighbors. So a pixel's variance can be estimated, and the image does not depend
//! on the order or the size of tiles. What paths from the lights bring, which end anywhere, is a second image with a mean
//! and a variance of its own, [`Splats`], and added to the first.
//!
//! ```
//! use fstop::film::{Film, FilmSpec, PixelBounds};
//! use fstop::glam::{UVec2, Vec3 as Rgb};
//!
//! let spec = FilmSpec { resolution: UVec2::new(4, 2), ..FilmSpec::default() };
//! let mut film = Film::new(&spec);
//! for bounds in film.bounds().tiles(2) {
//!     let mut tile = spec.tile(bounds);
//!     for pixel in bounds.pixels() {
//!         tile.add_sample(pixel, Rgb::splat(0.25), 2.0);
//!     }
//!     film.merge(tile);
//! }
//! assert_eq!(film.develop().pixel(UVec2::new(3, 1)), Rgb::splat(0.5));
//! ```

mod bounds;
mod deflate;
mod developed;
mod encoding;
mod exr;
mod image;
mod layers;
mod light_share;
mod metadata;
mod pairwise;
mod path_set;
mod pfm;
mod pixels;
mod png;
mod pool;
mod read;
pub mod sensor;
mod spec;
mod splat_variances;
mod splats;
mod stored;
mod stored_splats;
mod tile;
mod write;
mod zip_block;

#[cfg(test)]
mod tests;

pub use bounds::PixelBounds;
pub(crate) use bounds::SharedRow;
pub use developed::{Developed, Kept};
pub use encoding::Encoding;
pub(crate) use exr::pixels_encoded;
pub use image::Image;
pub(crate) use layers::GrowingLayers;
pub use layers::{
    CameraSample, ImageLayer, ImageLayers, ImageMatte, Layer, LayerSample, LayerSet, Manifest,
    MatteId, NO_GROUP, RenderSpace, SurfaceSample,
};
pub use light_share::{LightPathUse, LightShare};
pub use metadata::{FilmMetadata, Photograph};
pub(crate) use pairwise::Pairwise;
pub use path_set::PathSet;
pub use pixels::PixelStatistics;
pub use read::{LoadedImage, ReadError, read, read_within};
pub use spec::{FilmError, FilmSpec};
use splat_variances::SplatVariances;
pub use splats::{DroppedSplat, SplatBuffer, Splats};
pub(crate) use splats::{MEMORY_OF_SPLAT_BUFFER, MEMORY_OF_SPLATS};
pub(crate) use stored_splats::STORED_PIXEL;
pub use tile::{DroppedSample, Tile};
pub use write::{
    WriteError, check_name, check_output, keeps_variances, write, write_as, write_somewhere,
};

use crate::math::{Rgb, UVec2};
use glam::DVec3;
use layers::LayerPixels;
use pairwise::Join;

/// The image being rendered: statistics of every pixel inside the crop window.
#[derive(Clone, Debug)]
pub struct Film {
    resolution: UVec2,
    bounds: PixelBounds,
    scale: f32,
    pixels: Vec<PixelStatistics>,
    layers: Option<LayerPixels>,
    dropped: u64,
    first_dropped: Option<DroppedSample>,
    paths: u64,
    first_dropped_splat: Option<DroppedSplat>,
}

/// How an image is rendered, as far as the memory of its pixels depends on it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Accumulation {
    /// Each tile once.
    #[default]
    Once,
    /// With variances.
    WithVariances,
    /// With `--error` or `--time`: in two halves, pass by pass.
    InPasses,
}

impl Accumulation {
    /// All of them.
    pub const ALL: [Accumulation; 3] = [
        Accumulation::Once,
        Accumulation::WithVariances,
        Accumulation::InPasses,
    ];

    /// Bytes that a pixel takes while an image is rendered, at most: its color, those of its halves, and its `layers`. `is_lit`: paths are traced from
    /// the lights.
    pub(crate) fn memory_of_pixel(self, is_lit: bool, layers: LayerSet) -> u64 {
        let sums = layers.memory_of_sums();
        // Splats are kept by layers of light, too.
        let splats = MEMORY_OF_SPLATS * (1 + layers.lights() as u64);
        // Two halves with the tiles of one that are done, or two halves, their mean, and the image.
        let halves = 3 * (OF_STATISTICS + OF_COLOR + sums);
        let of_film = match (self, is_lit) {
            // The sums of finished tiles are kept where those of colors are.
            (Accumulation::Once, false) => OF_COLOR,
            (Accumulation::WithVariances, false) => 3 * OF_COLOR,
            (Accumulation::InPasses, false) => halves,
            (Accumulation::Once, true) => OF_STATISTICS + OF_COLOR + sums + splats,
            (Accumulation::WithVariances | Accumulation::InPasses, true) => halves + 2 * splats,
        };
        of_film + layers.memory_of_image()
    }

    /// Bytes of a pixel in the file before these are compressed.
    pub(crate) fn memory_of_file(self, layers: LayerSet) -> u64 {
        let colors = if self == Accumulation::Once { 1 } else { 3 };
        colors * OF_COLOR + layers.memory_of_image()
    }
}

/// Bytes of a pixel's sums.
pub(crate) const OF_STATISTICS: u64 = size_of::<PixelStatistics>() as u64;

const OF_COLOR: u64 = size_of::<Rgb>() as u64;

impl Film {
    /// An unexposed film.
    pub fn new(spec: &FilmSpec) -> Film {
        let bounds = spec.pixel_bounds();
        Film {
            resolution: spec.resolution,
            bounds,
            scale: spec.scale,
            pixels: vec![PixelStatistics::default(); bounds.area()],
            layers: LayerPixels::new(spec.layers, bounds.area()),
            dropped: 0,
            first_dropped: None,
            paths: 0,
            first_dropped_splat: None,
        }
    }

    /// Width and height of the full image in pixels, regardless of the crop window.
    pub fn resolution(&self) -> UVec2 {
        self.resolution
    }

    /// The pixels to be rendered: the crop window.
    pub fn bounds(&self) -> PixelBounds {
        self.bounds
    }

    /// The first sample that was dropped, row by row, regardless of how the film was divided into tiles.
    pub fn first_dropped(&self) -> Option<DroppedSample> {
        self.first_dropped
    }

    /// The statistics of one pixel; `None` outside the crop window.
    pub fn statistics(&self, pixel: UVec2) -> Option<&PixelStatistics> {
        self.pixels.get(self.bounds.index(pixel)?)
    }

    /// Merges the samples of `tile` into the film.
    ///
    /// A pixel that had no samples yet becomes a bit-for-bit copy of the tile's, so a film assembled from disjoint
    /// tiles is the same whatever their order and size. If both have samples they are pooled.
    pub fn merge(&mut self, mut tile: Tile) {
        tile.close();
        for (pixel, statistics) in tile.iter() {
            if let Some(index) = self.bounds.index(pixel) {
                self.pixels[index].join(statistics);
            }
        }
        if let (Some(own), Some(more)) = (&mut self.layers, tile.layers()) {
            let bounds = tile.bounds();
            let place = |number: usize| self.bounds.index(bounds.pixel(number)?);
            own.merge(more, &bounds.shared_rows(self.bounds), place);
        }
        self.dropped = self.dropped.saturating_add(tile.dropped());
        self.first_dropped = DroppedSample::first(self.first_dropped, tile.first_dropped());
    }

    /// Adds the light of paths from the lights to every pixel that has samples: the mean of what each of `splats` says, which
    /// are independent, but for those without paths. Once, when the film has all samples.
    pub fn add_light(&mut self, splats: &[Splats]) {
        let has_paths = |splats: &&Splats| splats.paths().count() > 0;
        let estimates: Vec<&Splats> = splats.iter().filter(has_paths).collect();
        let part = 1.0 / estimates.len() as f64;
        for splats in &estimates {
            let variances = SplatVariances::new(splats);
            for (pixel, statistics) in self.bounds.pixels().zip(&mut self.pixels) {
                let variance = variances.at(pixel) * (part * part);
                *statistics = statistics.plus(splats.mean(pixel) * part, variance);
            }
        }
        if let Some(layers) = self
            .layers
            .as_mut()
            .filter(|layers| layers.set.lights() > 0)
        {
            for (index, pixel) in self.bounds.pixels().enumerate() {
                for splats in &estimates {
                    let lights = 0..layers.set.lights();
                    let means = lights.map(|layer| splats.mean_of_layer(pixel, layer) * part);
                    layers.add_light(index, means);
                }
            }
        }
        for splats in estimates {
            self.paths += splats.paths().count();
            self.dropped = self.dropped.saturating_add(splats.dropped());
            let first = splats.first_dropped();
            self.first_dropped_splat = DroppedSplat::first(self.first_dropped_splat, first);
        }
    }

    /// The film whose every pixel is the mean of its two halves' ([`PixelStatistics::mean_of`]); both films must have
    /// the same [`FilmSpec`], and no light added yet.
    pub fn mean_of(a: &Film, b: &Film) -> Film {
        let pairs = a.pixels.iter().zip(&b.pixels);
        let mut layers = a.layers.clone();
        if let (Some(both), Some(more)) = (&mut layers, &b.layers) {
            both.join_halves(more);
        }
        Film {
            layers,
            pixels: pairs.map(|(p, q)| PixelStatistics::mean_of(p, q)).collect(),
            dropped: a.dropped.saturating_add(b.dropped),
            first_dropped: DroppedSample::first(a.first_dropped, b.first_dropped),
            ..*a
        }
    }

    /// Sets every pixel of `bounds` to the given statistics.
    pub fn fill(&mut self, bounds: PixelBounds, statistics: &PixelStatistics) {
        for pixel in bounds.pixels() {
            if let Some(index) = self.bounds.index(pixel) {
                self.pixels[index] = *statistics;
            }
        }
    }

    /// Number of samples of all pixels.
    pub fn samples(&self) -> u64 {
        self.pixels.iter().map(PixelStatistics::count).sum()
    }

    /// Every pixel's statistics, row by row.
    pub fn pixels(&self) -> &[PixelStatistics] {
        &self.pixels
    }

    /// The image of all samples and all light, with the variances of independent samples.
    pub fn develop(&self) -> Image {
        self.developed(Kept::Variance).image()
    }

    /// The same with [pooled](Developed::pool) variances by the means of a pixel's halves where they have samples.
    pub fn developed_halves(&self, means: impl Fn(UVec2) -> [Option<DVec3>; 2]) -> Developed {
        let mut developed = self.developed(Kept::Halves);
        for pixel in self.bounds.pixels() {
            developed.differ(pixel, means(pixel));
        }
        developed.pool();
        developed
    }

    /// The image, and what was dropped; without [`pooled`](Developed::pool) variances.
    pub fn developed(&self, kept: Kept) -> Developed {
        let spec = FilmSpec {
            resolution: self.resolution,
            scale: self.scale,
            layers: { self.layers.as_ref() }.map_or(LayerSet::NONE, |layers| layers.set),
            ..FilmSpec::default()
        };
        let mut developed = Developed {
            dropped: self.dropped,
            first_dropped: self.first_dropped,
            paths: self.paths,
            first_dropped_splat: self.first_dropped_splat,
            ..Developed::within(&spec, self.bounds, kept)
        };
        for (pixel, statistics) in self.bounds.pixels().zip(&self.pixels) {
            developed.set(pixel, statistics);
        }
        if let Some(layers) = &self.layers {
            developed.set_layers(self.bounds, layers);
        }
        developed
    }
}
