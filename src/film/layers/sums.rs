//! What a pixel's samples tell its layers, added up along the tree of its colors ([`crate::film::pairwise`]), so
//! that threads, tiles, shards and resumed renders change no bit of them either.
//!
//! Two kinds of means are made of the sums. *Filtered* layers (`albedo`, `normal`, `alpha`) are weighted as colors are, over
//! all samples whose ray leaves the lens: a denoiser then finds their edges where those of the image are, and vignetting
//! does not darken them. *Geometric* layers (`depth`, `position`, `uv`, `motion`, `coc`) are plain means over the samples that meet a
//! surface, for a mean with the negative weights of some filters may be over a sum that is nearly zero.

use super::coverage::Coverage;
use super::rows::{Leaf, Lights, Own, ROWS, SAMPLES, add};
use super::{CameraSample, LayerSample, LayerSet, MatteId, RenderSpace, SurfaceSample};
use crate::film::SharedRow;
use crate::film::pairwise::{Pairwise, PixelSum};
use crate::math::{DVec3, DVec4, Rgb, UVec2};
use arrayvec::ArrayVec;

/// The sums of some pixels.
#[derive(Clone, Debug, PartialEq)]
pub(in super::super) struct LayerPixels {
    pub(in super::super) set: LayerSet,
    /// The [rows](ROWS) that are wanted.
    pub(super) rows: ArrayVec<u8, ROWS>,
    /// How many sums a pixel has: those of the rows, and those of light.
    count: usize,
    pub(in super::super) sums: Vec<f64>,
    /// Of [`Layer::MATTES`].
    pub(in super::super) coverage: Coverage,
}

impl LayerPixels {
    /// Of so many pixels without samples; `None` for no layers.
    pub(in super::super) fn new(set: LayerSet, pixels: usize) -> Option<LayerPixels> {
        let mut none = LayerPixels::without_pixels(set)?;
        none.sums = vec![0.0; none.count * pixels];
        Some(none)
    }

    /// Where pixels are to be [added](LayerPixels::add).
    fn without_pixels(set: LayerSet) -> Option<LayerPixels> {
        (!set.is_empty()).then(|| LayerPixels {
            set,
            rows: set.rows().map(|row| row as u8).collect(),
            count: set.sums(),
            sums: Vec::new(),
            coverage: Coverage::default(),
        })
    }

    /// The sums of a pixel.
    #[inline]
    pub(super) fn pixel(&self, index: usize) -> &[f64] {
        self.row(index, 1)
    }

    /// Those of so many pixels, from this one on.
    #[inline]
    pub(super) fn row(&self, first: usize, pixels: usize) -> &[f64] {
        let range = first * self.count..(first + pixels) * self.count;
        self.sums.get(range).unwrap_or_default()
    }

    /// How many sums a pixel has, at least one.
    pub(super) fn count(&self) -> usize {
        self.count.max(1)
    }

    /// Adds those of other pixels, where both have them.
    pub(in super::super) fn merge(
        &mut self,
        more: &LayerPixels,
        rows: &[SharedRow],
        place: impl Fn(usize) -> Option<usize>,
    ) {
        self.merge_sums(more, rows);
        self.coverage.merge(&more.coverage, place);
    }

    /// The same but for mattes.
    pub(super) fn merge_sums(&mut self, more: &LayerPixels, rows: &[SharedRow]) {
        for row in rows {
            let range = row.other * self.count..(row.other + row.pixels) * self.count;
            let own = self.sums.get_mut(range).unwrap_or_default();
            add(own, more.row(row.own, row.pixels));
        }
    }

    /// Adds those of samples of a pixel. Mostly it is the next one: then they need not be cleared before.
    #[inline(always)]
    fn add(&mut self, index: usize, own: &Own, of_light: &Lights) {
        let range = index * self.count..(index + 1) * self.count;
        if range.start == self.sums.len() {
            let wanted = self
                .rows
                .iter()
                .filter_map(|row| own.0.get(usize::from(*row)));
            wanted.for_each(|sums| self.sums.extend(sums.to_array()));
            self.sums.extend(&of_light.0);
            return;
        }
        self.make_room(index + 1);
        let (rows, _) = self.sums.get_mut(range).unwrap_or_default().as_chunks_mut();
        for (sums, row) in rows.iter_mut().zip(&self.rows) {
            let more = own.0.get(usize::from(*row)).copied().unwrap_or_default();
            *sums = (DVec4::from_array(*sums) + more).to_array();
        }
        add(self.lights_of(index), &of_light.0);
    }

    /// Has at least so many pixels.
    fn make_room(&mut self, pixels: usize) {
        if self.sums.len() < pixels * self.count {
            self.sums.resize(pixels * self.count, 0.0);
        }
    }

    /// Those of light of a pixel, which are its last.
    fn lights_of(&mut self, index: usize) -> &mut [f64] {
        let end = (index + 1) * self.count;
        let lights = 3 * self.set.lights();
        self.sums.get_mut(end - lights..end).unwrap_or_default()
    }

    /// Adds light from elsewhere to the layers of light of a pixel: the mean over its samples grows by so much.
    pub(in super::super) fn add_light(
        &mut self,
        index: usize,
        lights: impl Iterator<Item = DVec3>,
    ) {
        let all = self.pixel(index).get(SAMPLES).copied().unwrap_or_default();
        Lights::add_to(self.lights_of(index), lights.map(|light| light * all));
    }

    /// Adds those of the same pixels by other samples, so that means over both are the plain means of their means, as those of colors are
    /// ([`PixelStatistics::mean_of`](crate::film::PixelStatistics::mean_of)): where one half has more samples each of them counts less.
    pub(in super::super) fn join_halves(&mut self, right: &LayerPixels) {
        let count = self.count();
        self.make_room(right.sums.len() / count);
        let both = [&self.sums, &right.sums];
        let samples = |sums: &Vec<f64>, pixel: usize| {
            let place = pixel * count + SAMPLES;
            sums.get(place).copied().unwrap_or_default()
        };
        let weights = |pixel: usize| balance(both.map(|sums| samples(sums, pixel)));
        self.coverage.join(&right.coverage, weights);
        let pixels = self.sums.chunks_exact_mut(count);
        for (own, other) in pixels.zip(right.sums.chunks_exact(count)) {
            let samples = [&*own, other].map(|sums| sums.get(SAMPLES).copied().unwrap_or_default());
            let [a, b] = balance(samples).map(f64::from);
            for (sum, more) in own.iter_mut().zip(other) {
                *sum = a * *sum + b * more;
            }
        }
    }

    /// Adds those of the same pixels.
    pub(in super::super) fn join(&mut self, right: &LayerPixels) {
        // One that is not closed has not all pixels.
        if self.sums.len() < right.sums.len() {
            self.sums.resize(right.sums.len(), 0.0);
        }
        add(&mut self.sums, &right.sums);
        self.coverage.merge(&right.coverage, Some);
    }
}

/// How often samples count of halves that have so many, so that both count the same: whole numbers, so that equal halves are as they are, and
/// small enough for counts of samples not to overflow.
fn balance(samples: [f64; 2]) -> [i32; 2] {
    let [a, b] = samples.map(|samples| samples as u64);
    if a == b || a == 0 || b == 0 {
        return [1, 1];
    }
    let divisor = gcd(a, b);
    let weights = [b / divisor, a / divisor];
    let most = (i32::MAX as u64 / (2 * a.max(b))).max(1);
    let over = weights[0].max(weights[1]).div_ceil(most);
    weights.map(|weight| (weight / over).max(1) as i32)
}

fn gcd(a: u64, b: u64) -> u64 {
    match b {
        0 => a,
        _ => gcd(b, a % b),
    }
}

/// The layers of a tile, to which the samples of a pixel are added one after the other.
#[derive(Clone, Debug)]
pub(in super::super) struct TileLayers {
    pub(in super::super) pixels: LayerPixels,
    /// The pixel whose samples are being added, and its number, if it has one.
    pixel: UVec2,
    open: Option<u32>,
    /// How many pixels there are.
    count: usize,
    /// Its last samples that have met the same.
    run: Run,
    leaf: Leaf,
    in_leaf: u32,
    space: RenderSpace,
    leaves: Pairwise<Own>,
    /// The same of light, if any is wanted.
    leaf_of_light: Lights,
    leaves_of_light: Pairwise<Lights>,
}

/// Samples of a pixel, one after the other, of the same weight that have met the same.
#[derive(Clone, Copy, Debug, Default)]
struct Run {
    weight: f32,
    mattes: [MatteId; 2],
    samples: i32,
}

impl TileLayers {
    pub(in super::super) fn new(set: LayerSet, pixels: usize) -> Option<Box<TileLayers>> {
        let mut own = LayerPixels::without_pixels(set)?;
        own.sums.reserve_exact(pixels * own.count);
        Some(Box::new(TileLayers {
            pixels: own,
            count: pixels,
            pixel: UVec2::MAX,
            open: None,
            run: Run::default(),
            leaf: Leaf::default(),
            in_leaf: 0,
            space: RenderSpace::default(),
            leaves: Pairwise::default(),
            leaf_of_light: Lights::none(set),
            leaves_of_light: Pairwise::default(),
        }))
    }

    /// Samples of this pixel follow, whose number in the tile is `index`, if it is in there.
    #[inline(always)]
    pub(in super::super) fn open(&mut self, pixel: UVec2, index: impl FnOnce() -> Option<usize>) {
        if pixel != self.pixel {
            self.close_pixel();
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
        if self.open.is_none() {
            return;
        }
        match sample {
            Some(Some(found)) => {
                self.space = *found.space;
                self.leaf.add(weight, found.surface, Some(found.camera));
                self.cover(weight, found.mattes, 1);
            }
            other => self.leaf.add_empty(other.is_some()),
        }
        if !lights.is_empty() {
            let lights = lights.iter().map(|light| light.as_dvec3());
            Lights::add_to(&mut self.leaf_of_light.0, lights);
        }
        self.in_leaf += 1;
        if self.in_leaf == PixelSum::LEAF {
            self.next_leaf();
        }
    }

    /// Samples of the pixel that is open follow that have met the same with this weight, and bring no light to layers of their own: its mattes, and where
    /// its points are.
    #[inline(never)]
    pub(in super::super) fn begin_run(
        &mut self,
        weight: f32,
        mattes: [MatteId; 2],
        space: &RenderSpace,
    ) {
        self.space = *space;
        self.cover(weight, mattes, 0);
    }

    /// Adds them.
    #[inline(always)]
    pub(in super::super) fn add_run<'a>(
        &mut self,
        samples: impl Iterator<Item = (&'a SurfaceSample, Option<CameraSample>)>,
    ) {
        // In the processor's registers, one leaf after the other.
        let (weight, mut leaf, mut in_leaf) = (self.run.weight, self.leaf, self.in_leaf);
        let mut count = 0;
        for (surface, camera) in samples {
            leaf.add(weight, surface, camera);
            in_leaf += 1;
            count += 1;
            if in_leaf == PixelSum::LEAF {
                self.leaf = leaf;
                self.next_leaf();
                (leaf, in_leaf) = (Leaf::default(), 0);
            }
        }
        (self.leaf, self.in_leaf) = (leaf, in_leaf);
        self.run.samples += count;
    }

    /// Counts samples for Cryptomattes.
    #[inline(always)]
    fn cover(&mut self, weight: f32, mattes: [MatteId; 2], samples: i32) {
        if (weight, mattes) != (self.run.weight, self.run.mattes) {
            self.end_run();
            (self.run.weight, self.run.mattes) = (weight, mattes);
        }
        self.run.samples += samples;
    }

    #[inline(never)]
    fn end_run(&mut self) {
        let Run {
            weight,
            mattes,
            samples,
        } = std::mem::take(&mut self.run);
        let (Some(pixel), set) = (self.open.filter(|_| samples > 0), self.pixels.set) else {
            return;
        };
        if set.has_mattes() {
            let count = if weight < 0.0 { -samples } else { samples };
            let coverage = &mut self.pixels.coverage;
            coverage.add(pixel, set.wanted_ids(mattes), count, weight.abs());
        }
    }

    /// Keeps the leaf, which is full, and starts the next one.
    #[inline(never)]
    fn next_leaf(&mut self) {
        self.in_leaf = 0;
        self.leaves.push(self.leaf.sums(&self.space));
        self.leaf = Leaf::default();
        let set = self.pixels.set;
        if set.lights() > 0 {
            let none = Lights::none(set);
            let full = std::mem::replace(&mut self.leaf_of_light, none);
            self.leaves_of_light.push(full);
        }
    }

    /// Pools what has been added to the last pixel, and has all pixels.
    pub(in super::super) fn close(&mut self) {
        self.close_pixel();
        self.pixels.make_room(self.count);
    }

    #[inline(never)]
    fn close_pixel(&mut self) {
        self.end_run();
        let mut all = self.leaf.sums(&self.space);
        self.leaf = Leaf::default();
        self.leaves.take_into(&mut all);
        self.leaves_of_light.take_into(&mut self.leaf_of_light);
        if let Some(index) = self.open {
            self.pixels.add(index as usize, &all, &self.leaf_of_light);
        }
        self.in_leaf = 0;
        self.leaf_of_light.0.fill(0.0);
    }
}

#[cfg(test)]
mod tests {
    use super::super::rows::SEEN;
    use super::super::{ImageLayers, Layer, all};
    use super::*;
    use crate::film::{FilmSpec, PixelBounds, Tile};
    use crate::math::{Vec2, Vec3};

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
        let x = index as f32 * 0.618;
        LayerSample {
            surface,
            space: const {
                &RenderSpace {
                    origin: DVec4::new(0.1, 0.1, 0.1, 0.0),
                    depth: DVec4::new(0.1, 0.2, 0.3, 0.4),
                }
            },
            camera: CameraSample::new(
                (20.0 * f64::from(x.fract())).exp(),
                f64::from(x).cos(),
                Vec2::new(x.sin(), x),
            ),
            mattes: [["a", "b", "c"][index as usize % 3], &index.to_string()].map(MatteId::of),
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
            pixels.coverage = pixels.coverage.canonical();
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

    /// Halves of other numbers of samples count the same.
    #[test]
    fn means_of_halves_are_the_means_of_their_means() {
        let own = |samples: std::ops::Range<u32>| {
            let tile = tile_of(samples);
            tile.layers.as_ref().unwrap().pixels.clone()
        };
        let developed = |pixels: &LayerPixels| {
            let mut layers = ImageLayers::new(pixels.set, 1);
            let row = SharedRow {
                own: 0,
                other: 0,
                pixels: 1,
            };
            layers.develop(pixels, &[row], 1.0);
            let alpha = layers.mean(Layer::Alpha).unwrap();
            let alpha = alpha.channels().next().unwrap()[0];
            let covered: f32 = layers.mattes[0].ranks(0).iter().map(|rank| rank.1).sum();
            (layers.lights[0][0].x, alpha, covered)
        };
        let (a, b) = (own(0..20), own(20..32));
        let mut both = a.clone();
        both.join_halves(&b);
        let (lights, alpha, covered) = developed(&both);
        let expected = 0.5 * (developed(&a).0 + developed(&b).0);
        // Rounding.
        assert!(
            (lights - expected).abs() < 1e-6 * expected,
            "{lights} {expected}"
        );
        // By 20 and 12 samples; parts are of those that are seen.
        let seen = [(&a, 3.0), (&b, 5.0)].map(|(half, weight)| weight * half.pixel(0)[SEEN] as f32);
        let mean = |[a, b]: [f32; 2]| (a * seen[0] + b * seen[1]) / (seen[0] + seen[1]);
        for (found, of_halves) in [
            (alpha, [&a, &b].map(|half| developed(half).1)),
            (covered, [&a, &b].map(|half| developed(half).2)),
        ] {
            let expected = mean(of_halves);
            assert!((found - expected).abs() < 1e-6, "{found} {expected}");
        }
        // As they are where both have as many.
        let (mut halves, mut joined) = (own(0..16), own(0..16));
        halves.join_halves(&own(16..32));
        joined.join(&own(16..32));
        assert_eq!(halves.sums, joined.sums);
        for samples in [[3.0, 5.0], [1e9, 1e9 + 1.0], [1.0, 2e9], [0.0, 7.0]] {
            let weights = balance(samples);
            let fits = |(n, w): (f64, i32)| w >= 1 && n * f64::from(w) <= f64::from(i32::MAX);
            assert!(
                samples.into_iter().zip(weights).all(fits),
                "{samples:?} {weights:?}"
            );
        }
    }

    #[test]
    fn things_that_nobody_asks_for_are_not_told_apart() {
        let coverage_of = |instances: [&str; 3]| {
            let mut layers = TileLayers::new(LayerSet::NONE.with(Layer::Material), 1).unwrap();
            layers.open(UVec2::ZERO, || Some(0));
            let surface = surface(0);
            for instance in instances {
                let sample = LayerSample {
                    mattes: ["grass", instance].map(MatteId::of),
                    ..sample(0, &surface)
                };
                layers.add(1.0, Some(Some(&sample)), &[]);
            }
            layers.close();
            layers.pixels.coverage
        };
        assert_eq!(coverage_of(["a", "b", "c"]), coverage_of(["a", "a", "a"]));
    }

    #[test]
    fn pixels_come_in_any_order() {
        let layers_of = |order: &[u32]| {
            let mut layers = TileLayers::new(all(), 4).unwrap();
            for &number in order {
                layers.open(UVec2::new(number, 0), || Some(number as usize));
                let surface = surface(number);
                let sample = sample(number, &surface);
                layers.add(0.5, Some(Some(&sample)), &[Rgb::splat(0.1)]);
            }
            layers.close();
            layers.pixels.coverage = layers.pixels.coverage.canonical();
            layers.pixels
        };
        let in_order = layers_of(&[0, 2, 2, 3]);
        assert_eq!(layers_of(&[2, 0, 3, 2]), in_order);
        assert_eq!(layers_of(&[3, 2, 0, 2]), in_order);
        assert!(in_order.pixel(1).iter().all(|sum| *sum == 0.0));
        assert_eq!(in_order.row(0, 4).len(), in_order.sums.len());
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
            space: &RenderSpace {
                origin: DVec4::new(0.0, 1e6, 0.0, 0.0),
                depth: DVec4::new(0.0, 0.0, -1.0, 7.0),
            },
            camera: CameraSample::new(0.0, 8.0, Vec2::new(3.0, -2.0)),
            mattes: ["a", "b"].map(MatteId::of),
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
        let row = SharedRow {
            own: 0,
            other: 0,
            pixels: 1,
        };
        layers.develop(&tile.pixels, &[row], 2.0);
        let third = 2.0 / 3.0;
        let expected = [
            (surface.albedo().as_dvec3() * third)
                .as_vec3()
                .to_array()
                .to_vec(),
            (DVec3::Z * third).as_vec3().to_array().to_vec(),
            vec![4.0],
            vec![1.0, 1_000_002.0, 3.0],
            vec![0.25, 0.5],
            vec![3.0, -2.0],
            vec![8.0],
            vec![third as f32],
        ];
        assert_eq!(layers.means().count(), expected.len());
        for (layer, expected) in layers.means().zip(expected) {
            let channels: Vec<_> = layer.channels().collect();
            assert_eq!(channels.concat(), expected, "{:?}", layer.layer);
        }
        assert_eq!(layers.lights[0], [Rgb::splat(2.0)]);
        assert_eq!(layers.lights[1], [Rgb::new(3.0, 4.0, -2.0)]);
        assert_eq!(layers.lights[2], [Rgb::ZERO]);
        for (matte, id) in layers.mattes.iter().zip(found.mattes) {
            let ranks = matte.ranks(0);
            assert_eq!(ranks[0], (id.number(), third as f32));
            assert_eq!(ranks[1], (0.0, 0.0));
        }
    }
}
