//! Layers: what an image knows of its pixels besides their color.
//!
//! Of each layer a pixel keeps sums over the samples that its color is made of, along the same tree ([`super::pairwise`]), so
//! that threads, tiles, shards and resumed renders change no bit of them either.
//!
//! Two kinds of means are made of the sums. *Filtered* layers (`albedo`, `normal`, `alpha`) are weighted as colors are, over
//! all samples whose ray leaves the lens: a denoiser then finds their edges where those of the picture are, and vignetting
//! does not darken them. *Geometric* layers (`depth`, `position`, `uv`, `coc`) are plain means over the samples that meet a
//! surface, for a mean with the negative weights of some filters may be over a sum that is nearly zero.

use super::pairwise::{Join, Pairwise, PixelSum};
use crate::math::{DVec3, Rgb, Vec2, Vec3};
use arrayvec::ArrayVec;
use serde::{Deserialize, Serialize};
use std::fmt;

/// A layer of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layer {
    /// The share of light from everywhere that the first surface which is not perfectly specular sends to the camera, times
    /// what mirrors and glass before it let through; 0 to 1.
    Albedo,
    /// World-space shading normal of the same surface, turned to where the ray came from; components −1 to 1.
    Normal,
    /// Of the first surface, from the plane through the camera's position across its axis; scene units. For `environment`
    /// from the position itself.
    Depth,
    /// World-space position on the first surface.
    Position,
    /// Surface parameters there, as textures see them.
    Uv,
    /// Diameter in pixels of the circle of confusion that a point of this depth has near the axis of the lens.
    Coc,
    /// The part of the pixel that surfaces cover, glass and mirrors among them; 0 to 1.
    Alpha,
}

impl Layer {
    /// All of them, in the order of their sums.
    pub const ALL: [Layer; 7] = [
        Layer::Albedo,
        Layer::Normal,
        Layer::Depth,
        Layer::Position,
        Layer::Uv,
        Layer::Coc,
        Layer::Alpha,
    ];

    /// As `--aov` calls it.
    pub fn name(self) -> &'static str {
        match self {
            Layer::Albedo => "albedo",
            Layer::Normal => "normal",
            Layer::Depth => "depth",
            Layer::Position => "position",
            Layer::Uv => "uv",
            Layer::Coc => "coc",
            Layer::Alpha => "alpha",
        }
    }

    /// The names of its channels in a file, as compositing programs expect them: components behind the layer's name, and
    /// the alpha of the picture itself.
    pub fn channels(self) -> &'static [&'static str] {
        match self {
            Layer::Albedo => &["albedo.R", "albedo.G", "albedo.B"],
            Layer::Normal => &["normal.X", "normal.Y", "normal.Z"],
            Layer::Depth => &["depth.Z"],
            Layer::Position => &["position.X", "position.Y", "position.Z"],
            Layer::Uv => &["uv.U", "uv.V"],
            Layer::Coc => &["coc.Y"],
            Layer::Alpha => &["A"],
        }
    }

    /// How many sums of its own it needs.
    fn sums(self) -> usize {
        match self {
            Layer::Alpha => 0,
            other => other.channels().len(),
        }
    }
}

/// Some layers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct LayerSet(u16);

impl LayerSet {
    /// None.
    pub const NONE: LayerSet = LayerSet(0);

    /// These and `layer`.
    #[must_use]
    pub fn with(self, layer: Layer) -> LayerSet {
        LayerSet(self.0 | 1 << layer as u16)
    }

    /// Whether `layer` is among them.
    pub fn contains(self, layer: Layer) -> bool {
        self.0 & 1 << layer as u16 != 0
    }

    /// Whether there is none.
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// They, in the order of [`Layer::ALL`].
    pub fn iter(self) -> impl Iterator<Item = Layer> {
        { Layer::ALL.into_iter() }.filter(move |layer| self.contains(*layer))
    }

    /// Reads names between commas, in any order.
    ///
    /// # Errors
    /// The first name that no layer has, in a sentence with those that there are.
    pub fn parse(list: &str) -> Result<LayerSet, String> {
        { list.split(',') }.try_fold(LayerSet::NONE, |set, name| {
            let name = name.trim();
            let found = Layer::ALL.into_iter().find(|layer| layer.name() == name);
            let layer = found.ok_or_else(|| {
                let all = Layer::ALL.map(Layer::name).join(", ");
                format!("no layer is called \"{name}\"; there are {all}")
            })?;
            Ok(set.with(layer))
        })
    }

    /// Numbers that are added up for each pixel.
    fn sums(self) -> usize {
        if self.is_empty() {
            return 0;
        }
        SHARED + self.iter().map(Layer::sums).sum::<usize>()
    }

    /// Bytes of a pixel's sums.
    pub fn memory_of_sums(self) -> u64 {
        (self.sums() * size_of::<f64>()) as u64
    }

    /// Bytes of a pixel in the image and in its file, which is made in memory.
    pub fn memory_of_image(self) -> u64 {
        let channels: usize = self.iter().map(|layer| layer.channels().len()).sum();
        (self.iter().count() * size_of::<Rgb>() + channels * size_of::<f32>()) as u64
    }
}

/// The names, between commas.
impl fmt::Display for LayerSet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, layer) in self.iter().enumerate() {
            let comma = if index > 0 { "," } else { "" };
            write!(f, "{comma}{}", layer.name())?;
        }
        Ok(())
    }
}

/// What a camera ray that left the lens tells the layers.
#[derive(Clone, Copy, Debug)]
pub struct LayerSample {
    /// See [`Layer::Position`].
    pub position: DVec3,
    /// See [`Layer::Depth`].
    pub depth: f64,
    /// See [`Layer::Uv`].
    pub uv: Vec2,
    /// See [`Layer::Coc`].
    pub coc: f64,
    /// See [`Layer::Albedo`].
    pub albedo: Rgb,
    /// See [`Layer::Normal`].
    pub normal: Vec3,
}

/// Sums that all layers share: samples that left the lens, the weights of those that met a surface, and their number.
const SHARED: usize = 3;

/// Most sums of a pixel.
const MAX_SUMS: usize = SHARED + 3 + 3 + 1 + 3 + 2 + 1;

/// Sums over samples of one pixel: the shared ones, then each layer's.
#[derive(Clone, Debug, Default, PartialEq)]
struct Sums(ArrayVec<f64, MAX_SUMS>);

impl Join for Sums {
    fn join(&mut self, right: &Sums) {
        add(&mut self.0, &right.0);
    }
}

fn add(sums: &mut [f64], more: &[f64]) {
    for (sum, more) in sums.iter_mut().zip(more) {
        *sum += more;
    }
}

/// The sums of some pixels.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct LayerPixels {
    pub(super) set: LayerSet,
    pub(super) sums: Vec<f64>,
}

impl LayerPixels {
    /// Of so many pixels without samples; `None` for no layers.
    pub(super) fn new(set: LayerSet, pixels: usize) -> Option<LayerPixels> {
        let sums = vec![0.0; set.sums() * pixels];
        (!set.is_empty()).then_some(LayerPixels { set, sums })
    }

    /// The sums of a pixel.
    pub(super) fn pixel(&self, index: usize) -> &[f64] {
        let count = self.set.sums();
        { self.sums.get(index * count..(index + 1) * count) }.unwrap_or_default()
    }

    /// Adds to those of a pixel.
    pub(super) fn add(&mut self, index: usize, more: &[f64]) {
        let count = self.set.sums();
        if let Some(sums) = self.sums.get_mut(index * count..(index + 1) * count) {
            add(sums, more);
        }
    }

    /// Adds those of the same pixels.
    pub(super) fn join(&mut self, right: &LayerPixels) {
        add(&mut self.sums, &right.sums);
    }
}

/// The layers of a tile, to which the samples of a pixel are added one after the other.
#[derive(Clone, Debug)]
pub(super) struct TileLayers {
    pub(super) pixels: LayerPixels,
    leaf: Sums,
    in_leaf: u32,
    leaves: Pairwise<Sums>,
}

impl TileLayers {
    pub(super) fn new(set: LayerSet, pixels: usize) -> Option<Box<TileLayers>> {
        let pixels = LayerPixels::new(set, pixels)?;
        Some(Box::new(TileLayers {
            pixels,
            leaf: zeros(set),
            in_leaf: 0,
            leaves: Pairwise::default(),
        }))
    }

    /// Adds a sample: `None` for one whose ray does not leave the lens, `Some(None)` for one that meets nothing.
    pub(super) fn add(&mut self, weight: f32, sample: Option<Option<&LayerSample>>) {
        if let Some(found) = sample {
            self.leaf.0[0] += 1.0;
            if let Some(found) = found {
                self.add_found(f64::from(weight), found);
            }
        }
        self.in_leaf += 1;
        if self.in_leaf == PixelSum::LEAF {
            self.next_leaf();
        }
    }

    fn add_found(&mut self, weight: f64, sample: &LayerSample) {
        let set = self.pixels.set;
        let mut rest = self.leaf.0.as_mut_slice();
        let mut add = |more: &[f64]| {
            if let Some((own, others)) = std::mem::take(&mut rest).split_at_mut_checked(more.len())
            {
                { own.iter_mut().zip(more) }.for_each(|(sum, more)| *sum += more);
                rest = others;
            }
        };
        add(&[0.0, weight, 1.0]);
        if set.contains(Layer::Albedo) {
            add(&(sample.albedo.as_dvec3() * weight).to_array());
        }
        if set.contains(Layer::Normal) {
            add(&(sample.normal.as_dvec3() * weight).to_array());
        }
        if set.contains(Layer::Depth) {
            add(&[sample.depth]);
        }
        if set.contains(Layer::Position) {
            add(&sample.position.to_array());
        }
        if set.contains(Layer::Uv) {
            add(&sample.uv.as_dvec2().to_array());
        }
        if set.contains(Layer::Coc) {
            add(&[sample.coc]);
        }
    }

    fn next_leaf(&mut self) {
        self.in_leaf = 0;
        let leaf = std::mem::replace(&mut self.leaf, zeros(self.pixels.set));
        self.leaves.push(leaf);
    }

    /// Pools what has been added for this pixel.
    pub(super) fn close(&mut self, index: usize) {
        let rest = (self.in_leaf > 0).then(|| {
            self.in_leaf = 0;
            std::mem::replace(&mut self.leaf, zeros(self.pixels.set))
        });
        if let Some(sums) = self.leaves.take(rest) {
            self.pixels.add(index, &sums.0);
        }
    }
}

fn zeros(set: LayerSet) -> Sums {
    Sums(std::iter::repeat_n(0.0, set.sums()).collect())
}

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
    pub(super) fn all_of(set: LayerSet, pixels: usize) -> Vec<ImageLayer> {
        let black = |layer| ImageLayer {
            layer,
            values: vec![Rgb::ZERO; pixels],
        };
        set.iter().map(black).collect()
    }
}

/// Sets a pixel of the image's layers to the means that these sums are of.
pub(super) fn develop(layers: &mut [ImageLayer], index: usize, sums: &[f64]) {
    let Some((&[seen, covered, hits], mut own)) = sums.split_first_chunk::<SHARED>() else {
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
            Layer::Depth | Layer::Position | Layer::Uv | Layer::Coc => mean(hits),
        };
        if let Some(slot) = values.get_mut(index) {
            // Not a negative zero, which sums may or may not begin with.
            *slot = (value + 0.0).as_vec3();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::{FilmSpec, PixelBounds, Tile};
    use crate::math::UVec2;

    fn all() -> LayerSet {
        Layer::ALL.into_iter().fold(LayerSet::NONE, LayerSet::with)
    }

    #[test]
    fn names_are_read_and_written() {
        assert_eq!(LayerSet::parse(&all().to_string()), Ok(all()));
        let some = LayerSet::parse("depth, albedo").unwrap();
        assert_eq!(some.to_string(), "albedo,depth");
        assert_eq!(some.iter().count(), 2);
        let error = LayerSet::parse("albedo,dpeth").unwrap_err();
        assert!(error.contains("\"dpeth\"") && error.contains("depth"));
        assert!(LayerSet::parse("").is_err());
        assert_eq!(all().sums(), MAX_SUMS);
    }

    /// Samples whose sums depend on their order.
    fn sample(index: u32) -> LayerSample {
        let x = f64::from(index) * 0.618;
        LayerSample {
            position: DVec3::new(x, 1e9 * x.sin(), 1e-9),
            depth: (20.0 * x.fract()).exp(),
            uv: Vec2::splat(x.fract() as f32),
            coc: x.cos(),
            albedo: Rgb::splat(0.1),
            normal: Vec3::new(0.6, -0.8, 0.0),
        }
    }

    fn tile_of(samples: std::ops::Range<u32>) -> Tile {
        let spec = FilmSpec {
            resolution: UVec2::ONE,
            layers: all(),
            ..FilmSpec::default()
        };
        let mut tile = spec.tile(PixelBounds::new(UVec2::ZERO, UVec2::ONE));
        for index in samples {
            let sample = (index % 7 != 0).then(|| sample(index));
            let seen = (index % 5 != 0).then_some(sample.as_ref());
            tile.add_layers(UVec2::ZERO, if index % 3 == 0 { -1.0 } else { 1.0 }, seen);
            tile.add_sample(UVec2::ZERO, Rgb::ONE, 1.0);
        }
        tile.close();
        tile
    }

    #[test]
    fn blocks_of_any_power_of_two_make_the_same_bits() {
        let sums = |tile: &Tile| tile.layers.as_ref().unwrap().pixels.clone();
        for count in [1, 17, 100, 1000] {
            let whole = sums(&tile_of(0..count));
            for size in [16, 64, 128] {
                let mut blocks = Pairwise::default();
                for start in (0..count).step_by(size) {
                    blocks.push(tile_of(start..count.min(start + size as u32)));
                }
                let joined = sums(&blocks.take(None).unwrap());
                assert_eq!(joined, whole, "{count} in {size}");
            }
        }
    }

    #[test]
    fn means_are_of_the_samples_that_count() {
        let mut layers = ImageLayer::all_of(all(), 1);
        let mut tile = TileLayers::new(all(), 1).unwrap();
        let found = LayerSample {
            position: DVec3::new(1.0, 2.0, 3.0),
            depth: 4.0,
            uv: Vec2::new(0.25, 0.5),
            coc: 8.0,
            albedo: Rgb::new(0.5, 0.25, 1.0),
            normal: Vec3::Z,
        };
        // One blocked in the lens, one that meets nothing, two that meet the same point.
        for sample in [None, Some(None), Some(Some(&found)), Some(Some(&found))] {
            tile.add(1.0, sample);
        }
        tile.close(0);
        develop(&mut layers, 0, tile.pixels.pixel(0));
        let third = 2.0 / 3.0;
        let expected = [
            (found.albedo.as_dvec3() * third).as_vec3(),
            (DVec3::Z * third).as_vec3(),
            Rgb::new(4.0, 0.0, 0.0),
            Rgb::new(1.0, 2.0, 3.0),
            Rgb::new(0.25, 0.5, 0.0),
            Rgb::new(8.0, 0.0, 0.0),
            Rgb::splat(third as f32),
        ];
        for (layer, expected) in layers.iter().zip(expected) {
            assert_eq!(layer.values[0], expected, "{:?}", layer.layer);
        }
    }
}
