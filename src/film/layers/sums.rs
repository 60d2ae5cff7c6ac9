//! What a pixel's samples tell its layers, added up along the tree of its colors ([`crate::film::pairwise`]), so
//! that threads, tiles, shards and resumed renders change no bit of them either.
//!
//! Two kinds of means are made of the sums. *Filtered* layers (`albedo`, `normal`, `alpha`) are weighted as colors are, over
//! all samples whose ray leaves the lens: a denoiser then finds their edges where those of the image are, and vignetting
//! does not darken them. *Geometric* layers (`depth`, `position`, `uv`, `motion`, `coc`) are plain means over the samples that meet a
//! surface, for a mean with the negative weights of some filters may be over a sum that is nearly zero.

use super::coverage::{Coverage, ImageMatte};
use super::{Layer, LayerSet, MatteId, light_channels};
use crate::film::pairwise::{Join, Pairwise, PixelSum};
use crate::math::{DVec2, DVec3, Rgb, UVec2, Vec2, Vec3, Vec4};
use arrayvec::ArrayVec;

/// What a camera ray that left the lens and met a surface tells the layers.
#[derive(Clone, Copy, Debug)]
pub struct LayerSample<'a> {
    /// Of the surface.
    pub surface: &'a SurfaceSample,
    /// Where render space begins, in world space; and a zero.
    pub origin: &'a [f64; 4],
    /// See [`Layer::Depth`].
    pub depth: f64,
    /// See [`Layer::Coc`].
    pub coc: f64,
    /// See [`Layer::Motion`].
    pub motion: DVec2,
    /// See [`Layer::Material`].
    pub material: MatteId,
    /// See [`Layer::Instance`].
    pub instance: MatteId,
}

/// What layers tell of a surface: numbers side by side, which vector instructions add.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SurfaceSample {
    albedo: Lanes,
    normal: Lanes,
    p: Lanes,
    uv: Lanes,
}

/// A vector, and zeros.
type Lanes = [f32; 4];

impl SurfaceSample {
    /// See [`Layer::Albedo`].
    #[inline(always)]
    pub fn albedo(&self) -> Rgb {
        Vec3::from_slice(&self.albedo)
    }

    /// See [`Layer::Normal`]; in render space, which is world space moved.
    #[inline(always)]
    pub fn normal(&self) -> Vec3 {
        Vec3::from_slice(&self.normal)
    }

    /// The point, in render space.
    #[inline(always)]
    pub fn p(&self) -> Vec3 {
        Vec3::from_slice(&self.p)
    }

    /// Sets the albedo.
    #[inline(always)]
    pub fn set_albedo(&mut self, albedo: Rgb) {
        self.albedo = lanes(albedo);
    }

    /// Sets the normal.
    #[inline(always)]
    pub fn set_normal(&mut self, normal: Vec3) {
        self.normal = lanes(normal);
    }

    /// Sets the point.
    #[inline(always)]
    pub fn set_p(&mut self, p: Vec3) {
        self.p = lanes(p);
    }

    /// Sets the surface's parameters: see [`Layer::Uv`].
    #[inline(always)]
    pub fn set_uv(&mut self, uv: Vec2) {
        self.uv = [uv.x, uv.y, 0.0, 0.0];
    }

    /// Returns `true` if albedo and normal are numbers.
    #[inline(always)]
    pub fn is_finite(&self) -> bool {
        let (albedo, normal) = (Vec4::from(self.albedo), Vec4::from(self.normal));
        // Nearly always: then no addend was anything else.
        (albedo + normal).is_finite() || albedo.is_finite() && normal.is_finite()
    }
}

#[inline(always)]
fn lanes(v: Vec3) -> Lanes {
    [v.x, v.y, v.z, 0.0]
}

/// Sums that all layers share: samples that left the lens, the weights of those that met a surface, their number, and that of all samples.
pub(super) const SHARED: usize = 4;

/// Sums of the layers of light.
#[derive(Clone, Debug, Default, PartialEq)]
struct Lights(ArrayVec<f64, { 3 * LayerSet::MAX_LIGHTS }>);

impl Lights {
    /// Of no samples.
    fn none(set: LayerSet) -> Lights {
        Lights(std::iter::repeat_n(0.0, 3 * set.lights()).collect())
    }
}

impl Join for Lights {
    fn join(&mut self, right: &Lights) {
        add(&mut self.0, &right.0);
    }
}

#[inline(always)]
fn add(sums: &mut [f64], more: &[f64]) {
    for (sum, more) in sums.iter_mut().zip(more) {
        *sum += more;
    }
}

/// The sums of some pixels.
#[derive(Clone, Debug, PartialEq)]
pub(in super::super) struct LayerPixels {
    pub(in super::super) set: LayerSet,
    pub(in super::super) sums: Vec<f64>,
    /// Of [`Layer::MATTES`].
    pub(in super::super) mattes: [Coverage; 2],
}

impl LayerPixels {
    /// Of so many pixels without samples; `None` for no layers.
    pub(in super::super) fn new(set: LayerSet, pixels: usize) -> Option<LayerPixels> {
        let sums = vec![0.0; set.sums() * pixels];
        (!set.is_empty()).then(|| LayerPixels {
            set,
            sums,
            mattes: Default::default(),
        })
    }

    /// The sums of a pixel.
    pub(in super::super) fn pixel(&self, index: usize) -> &[f64] {
        let count = self.set.sums();
        { self.sums.get(index * count..(index + 1) * count) }.unwrap_or_default()
    }

    /// Adds those of other pixels, each of which is the one of these that `place` says, if any.
    pub(in super::super) fn merge(
        &mut self,
        more: &LayerPixels,
        pixels: usize,
        place: impl Fn(usize) -> Option<usize>,
    ) {
        for number in 0..pixels {
            if let Some(index) = place(number) {
                self.add(index, more.pixel(number).iter().copied());
            }
        }
        for (own, more) in self.mattes.iter_mut().zip(&more.mattes) {
            own.merge(more, &place);
        }
    }

    /// Adds to those of a pixel.
    pub(super) fn add(&mut self, index: usize, more: impl Iterator<Item = f64>) {
        let count = self.set.sums();
        if let Some(sums) = self.sums.get_mut(index * count..(index + 1) * count) {
            sums.iter_mut()
                .zip(more)
                .for_each(|(sum, more)| *sum += more);
        }
    }

    /// Adds light from elsewhere to the layers of light of a pixel: the mean over its samples grows by so much.
    pub(in super::super) fn add_light(
        &mut self,
        index: usize,
        lights: impl Iterator<Item = DVec3>,
    ) {
        let (set, count) = (self.set, self.set.sums());
        let Some(sums) = self.sums.get_mut(index * count..(index + 1) * count) else {
            return;
        };
        let all = sums.get(SHARED - 1).copied().unwrap_or_default();
        add_lights(set.light_sums(sums), lights.map(|light| light * all));
    }

    /// Adds those of the same pixels.
    pub(in super::super) fn join(&mut self, right: &LayerPixels) {
        add(&mut self.sums, &right.sums);
        for (own, more) in self.mattes.iter_mut().zip(&right.mattes) {
            own.merge(more, Some);
        }
    }
}

/// The sums of all layers, wanted or not, but for those of light.
#[derive(Clone, Debug, Default)]
struct Own {
    shared: [f64; SHARED],
    /// Of the four parts of a [`SurfaceSample`].
    surface: [[f64; 4]; 4],
    /// Of [`Layer::Depth`], [`Layer::Coc`] and [`Layer::Motion`].
    camera: [f64; 4],
}

/// How many there are.
const ALL_SUMS: usize = CAMERA + 4;

/// Where those of surfaces and of the camera are, if all are side by side.
const SURFACE: usize = SHARED;
const CAMERA: usize = SURFACE + 16;

impl Join for Own {
    fn join(&mut self, right: &Own) {
        add(&mut self.shared, &right.shared);
        add(
            self.surface.as_flattened_mut(),
            right.surface.as_flattened(),
        );
        add(&mut self.camera, &right.camera);
    }
}

/// The layers of a tile, to which the samples of a pixel are added one after the other.
#[derive(Clone, Debug)]
pub(in super::super) struct TileLayers {
    pub(in super::super) pixels: LayerPixels,
    /// Where the sums that are wanted are among all.
    wanted: ArrayVec<u8, ALL_SUMS>,
    /// The pixel whose samples are being added, and its number, if it has one.
    pixel: UVec2,
    open: Option<u32>,
    /// The weight of a sample, without its sign.
    unit: f32,
    leaf: Own,
    in_leaf: u32,
    leaves: Pairwise<Own>,
    /// The same of light, if any is wanted.
    leaf_of_light: Lights,
    leaves_of_light: Pairwise<Lights>,
}

impl TileLayers {
    pub(in super::super) fn new(set: LayerSet, pixels: usize) -> Option<Box<TileLayers>> {
        let pixels = LayerPixels::new(set, pixels)?;
        Some(Box::new(TileLayers {
            pixels,
            wanted: wanted(set),
            pixel: UVec2::MAX,
            open: None,
            unit: 0.0,
            leaf: Own::default(),
            in_leaf: 0,
            leaves: Pairwise::default(),
            leaf_of_light: Lights::none(set),
            leaves_of_light: Pairwise::default(),
        }))
    }

    /// Samples of this pixel follow, whose number in the tile is `index`, if it is in there.
    #[inline(always)]
    pub(in super::super) fn open(&mut self, pixel: UVec2, index: impl FnOnce() -> Option<usize>) {
        if pixel != self.pixel {
            self.close();
            self.pixel = pixel;
            self.open = index().map(|index| index as u32);
        }
    }

    /// Adds a sample of the pixel: `None` for one whose ray does not leave the lens, `Some(None)` for one that meets nothing. `lights` is what it
    /// brings to the pixel, by layers of light.
    #[inline(always)]
    pub(in super::super) fn add(
        &mut self,
        weight: f32,
        sample: Option<Option<&LayerSample>>,
        lights: &[Rgb],
    ) {
        let Some(pixel) = self.open else {
            return;
        };
        match sample {
            Some(Some(found)) => {
                self.leaf.add(f64::from(weight), found);
                self.cover(pixel, weight, found);
            }
            Some(None) => add(&mut self.leaf.shared, &[1.0, 0.0, 0.0, 1.0]),
            None => self.leaf.shared[3] += 1.0,
        }
        if !lights.is_empty() {
            let lights = lights.iter().map(|light| light.as_dvec3());
            add_lights(&mut self.leaf_of_light.0, lights);
        }
        self.in_leaf += 1;
        if self.in_leaf == PixelSum::LEAF {
            self.next_leaf();
        }
    }

    #[inline(always)]
    fn cover(&mut self, pixel: u32, weight: f32, sample: &LayerSample) {
        if weight.abs() > self.unit {
            self.unit = weight.abs();
        }
        let count = if weight < 0.0 { -1 } else { 1 };
        let (set, [materials, instances]) = (self.pixels.set, &mut self.pixels.mattes);
        if set.contains(Layer::Material) {
            materials.add(pixel, sample.material, count);
        }
        if set.contains(Layer::Instance) {
            instances.add(pixel, sample.instance, count);
        }
    }

    #[inline(never)]
    fn next_leaf(&mut self) {
        let (own, lights) = self.leaf();
        self.leaves.push(own);
        if let Some(lights) = lights {
            self.leaves_of_light.push(lights);
        }
    }

    /// The leaf as far as it is filled. Starts the next one.
    fn leaf(&mut self) -> (Own, Option<Lights>) {
        self.in_leaf = 0;
        let set = self.pixels.set;
        let lights = || std::mem::replace(&mut self.leaf_of_light, Lights::none(set));
        let lights = (set.lights() > 0).then(lights);
        (std::mem::take(&mut self.leaf), lights)
    }

    /// Pools what has been added to the last pixel.
    #[inline(never)]
    pub(in super::super) fn close(&mut self) {
        let (own, lights) = match self.in_leaf {
            0 => (None, None),
            _ => {
                let (own, lights) = self.leaf();
                (Some(own), lights)
            }
        };
        for matte in &mut self.pixels.mattes {
            matte.see_unit(self.unit);
        }
        if let (Some(own), Some(index)) = (self.leaves.take(own), self.open) {
            let all = own.side_by_side();
            let sums = self.wanted.iter().map(|&place| all[usize::from(place)]);
            let lights = self.leaves_of_light.take(lights).unwrap_or_default();
            self.pixels.add(index as usize, sums.chain(lights.0));
        }
    }
}

impl Own {
    fn side_by_side(&self) -> [f64; ALL_SUMS] {
        let mut all = [0.0; ALL_SUMS];
        all[..SHARED].copy_from_slice(&self.shared);
        all[SURFACE..CAMERA].copy_from_slice(self.surface.as_flattened());
        all[CAMERA..].copy_from_slice(&self.camera);
        all
    }

    /// Adds a sample that has met a surface: whatever is wanted, so that there are no branches.
    #[inline(always)]
    fn add(&mut self, weight: f64, sample: &LayerSample) {
        add(&mut self.shared, &[1.0, weight, 1.0, 1.0]);
        let SurfaceSample {
            albedo,
            normal,
            p,
            uv,
        } = *sample.surface;
        let [of_albedo, of_normal, of_p, of_uv] = &mut self.surface;
        add(of_albedo, &scaled(albedo, weight));
        add(of_normal, &scaled(normal, weight));
        let mut position = scaled(p, 1.0);
        add(&mut position, sample.origin);
        add(of_p, &position);
        add(of_uv, &scaled(uv, 1.0));
        let DVec2 { x, y } = sample.motion;
        add(&mut self.camera, &[sample.depth, sample.coc, x, y]);
    }
}

#[inline(always)]
fn scaled([a, b, c, d]: Lanes, by: f64) -> [f64; 4] {
    // Written out: `array::map` is not always inlined.
    let [a, b, c, d]: [f64; 4] = [a.into(), b.into(), c.into(), d.into()];
    [a * by, b * by, c * by, d * by]
}

/// Where the sums of these layers are among all.
fn wanted(set: LayerSet) -> ArrayVec<u8, ALL_SUMS> {
    let places = |layer: Layer| {
        let first = match layer {
            Layer::Albedo => SURFACE,
            Layer::Normal => SURFACE + 4,
            Layer::Position => SURFACE + 8,
            Layer::Uv => SURFACE + 12,
            Layer::Depth => CAMERA,
            Layer::Coc => CAMERA + 1,
            Layer::Motion => CAMERA + 2,
            Layer::Material | Layer::Instance | Layer::Lights | Layer::Alpha => 0,
        };
        first as u8..(first + layer.sums()) as u8
    };
    (0..SHARED as u8)
        .chain(set.iter().flat_map(places))
        .collect()
}

impl LayerSet {
    /// Those of a pixel's sums that are of light.
    fn light_sums(self, sums: &mut [f64]) -> &mut [f64] {
        let first = sums.len().saturating_sub(3 * self.lights());
        sums.get_mut(first..).unwrap_or_default()
    }
}

fn add_lights(sums: &mut [f64], lights: impl Iterator<Item = DVec3>) {
    for (sums, light) in sums.chunks_exact_mut(3).zip(lights) {
        add(sums, &light.to_array());
    }
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

#[cfg(test)]
mod tests {
    use super::super::all;
    use super::*;
    use crate::film::{FilmSpec, PixelBounds, Tile};

    fn surface(index: u32) -> SurfaceSample {
        let x = index as f32 * 0.618;
        let mut surface = SurfaceSample::default();
        surface.set_albedo(Rgb::splat(0.1));
        surface.set_normal(Vec3::new(0.6, -0.8, 0.0));
        surface.set_p(Vec3::new(x, 1e9 * x.sin(), 1e-9));
        surface.set_uv(Vec2::splat(x.fract()));
        surface
    }

    /// Samples whose sums depend on their order.
    fn sample(index: u32, surface: &SurfaceSample) -> LayerSample<'_> {
        let x = f64::from(index) * 0.618;
        LayerSample {
            surface,
            origin: &[0.1, 0.1, 0.1, 0.0],
            depth: (20.0 * x.fract()).exp(),
            coc: x.cos(),
            motion: DVec2::new(x.sin(), x),
            material: MatteId::of(["a", "b", "c"][index as usize % 3]),
            instance: MatteId::of(&index.to_string()),
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
            let surface = surface(index);
            let sample = (index % 7 != 0).then(|| sample(index, &surface));
            let seen = (index % 5 != 0).then_some(sample.as_ref());
            let lights = [Rgb::new(0.1, 1e-9, 1e9) * index as f32, Rgb::ONE];
            let weight = if index % 3 == 0 { -1.0 } else { 1.0 };
            tile.add_layers(UVec2::ZERO, weight, seen, &lights);
            tile.add_sample(UVec2::ZERO, Rgb::ONE, 1.0);
        }
        tile.close();
        tile
    }

    #[test]
    fn blocks_of_any_power_of_two_make_the_same_bits() {
        let sums = |tile: &Tile| {
            let mut pixels = tile.layers.as_ref().unwrap().pixels.clone();
            pixels.mattes = pixels.mattes.map(|coverage| coverage.canonical());
            pixels
        };
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
        let mut tile = TileLayers::new(all(), 1).unwrap();
        let mut surface = SurfaceSample::default();
        surface.set_albedo(Rgb::new(0.5, 0.25, 1.0));
        surface.set_normal(Vec3::Z);
        surface.set_p(Vec3::new(1.0, 2.0, 3.0));
        surface.set_uv(Vec2::new(0.25, 0.5));
        let found = LayerSample {
            surface: &surface,
            origin: &[0.0, 1e6, 0.0, 0.0],
            depth: 4.0,
            coc: 8.0,
            motion: DVec2::new(3.0, -2.0),
            material: MatteId::of("a"),
            instance: MatteId::of("b"),
        };
        // One blocked in the lens, one that meets nothing, two that meet the same point.
        for sample in [None, Some(None), Some(Some(&found)), Some(Some(&found))] {
            tile.open(UVec2::ONE, || Some(0));
            tile.add(1.0, sample, &[Rgb::ONE, Rgb::new(0.5, 1.0, -2.0)]);
        }
        tile.open(UVec2::ZERO, || None);
        tile.add(1.0, Some(Some(&found)), &[]);
        tile.close();
        tile.pixels
            .add_light(0, [DVec3::ZERO, DVec3::ONE].into_iter());
        let mut layers = ImageLayers::new(all(), 1);
        layers.develop(&tile.pixels, 1, 2.0, Some);
        let third = 2.0 / 3.0;
        let expected = [
            (surface.albedo().as_dvec3() * third).as_vec3(),
            (DVec3::Z * third).as_vec3(),
            Rgb::new(4.0, 0.0, 0.0),
            Rgb::new(1.0, 1_000_002.0, 3.0),
            Rgb::new(0.25, 0.5, 0.0),
            Rgb::new(3.0, -2.0, 0.0),
            Rgb::new(8.0, 0.0, 0.0),
            Rgb::splat(third as f32),
        ];
        for (layer, expected) in layers.means.iter().zip(expected) {
            assert_eq!(layer.values[0], expected, "{:?}", layer.layer);
        }
        assert_eq!(layers.lights[0], [Rgb::splat(2.0)]);
        assert_eq!(layers.lights[1], [Rgb::new(3.0, 4.0, 0.0)]);
        assert_eq!(layers.lights[2], [Rgb::ZERO]);
        for (matte, id) in layers.mattes.iter().zip([found.material, found.instance]) {
            let ranks = matte.ranks(0);
            assert_eq!(ranks[0], (id.number(), third as f32));
            assert_eq!(ranks[1], (0.0, 0.0));
        }
    }
}
