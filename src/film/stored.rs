//! Tiles as bytes, in checkpoints: little-endian, to the same bits on every machine.

use super::layers::Coverage;
use super::{DroppedSample, PixelStatistics, Tile};
use crate::math::UVec2;

impl Tile {
    /// Appends the tile, which is closed, to `out`.
    pub(crate) fn store(&self, out: &mut Vec<u8>) {
        out.extend(self.dropped.to_le_bytes());
        let first = self.first_dropped.map_or([u64::MAX; 3], |first| {
            let UVec2 { x, y } = first.pixel;
            [x.into(), y.into(), first.sample]
        });
        out.extend(first.map(u64::to_le_bytes).as_flattened());
        for pixel in &self.pixels {
            out.extend(pixel.to_words().map(u64::to_le_bytes).as_flattened());
        }
        let layers = self.layers().map_or(&[][..], |layers| &layers.sums);
        out.extend(layers.iter().flat_map(|sum| sum.to_le_bytes()));
        let mattes = self.layers().into_iter();
        let words = mattes.flat_map(|layers| layers.coverage.to_words());
        out.extend(words.flat_map(u64::to_le_bytes));
    }

    /// This empty tile with the contents at the start of `bytes`, which are taken away; `None` if they are too short.
    pub(crate) fn restored(mut self, bytes: &mut &[u8]) -> Option<Tile> {
        let mut word = || {
            let (first, rest) = bytes.split_first_chunk()?;
            *bytes = rest;
            Some(u64::from_le_bytes(*first))
        };
        self.dropped = word()?;
        let [x, y, sample] = [word()?, word()?, word()?];
        self.first_dropped = (sample != u64::MAX).then_some(DroppedSample {
            pixel: UVec2::new(x as u32, y as u32),
            sample,
        });
        for pixel in &mut self.pixels {
            let mut words = [0; PixelStatistics::WORDS];
            for slot in &mut words {
                *slot = word()?;
            }
            *pixel = PixelStatistics::from_words(words);
        }
        if let Some(layers) = &mut self.layers {
            layers.close();
            for sum in &mut layers.pixels.sums {
                *sum = f64::from_bits(word()?);
            }
            layers.pixels.coverage = Coverage::from_words(&mut word)?;
        }
        Some(self)
    }
}

impl PixelStatistics {
    const WORDS: usize = 7;

    fn to_words(self) -> [u64; Self::WORDS] {
        let [a, b, c] = self.mean.to_array().map(f64::to_bits);
        let [d, e, f] = self.squared_deviations.to_array().map(f64::to_bits);
        [a, b, c, d, e, f, self.count]
    }

    fn from_words([a, b, c, d, e, f, count]: [u64; Self::WORDS]) -> PixelStatistics {
        PixelStatistics {
            mean: [a, b, c].map(f64::from_bits).into(),
            squared_deviations: [d, e, f].map(f64::from_bits).into(),
            count,
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::film::{
        CameraSample, Layer, LayerSample, LayerSet, MatteId, PixelBounds, RenderSpace,
        SurfaceSample, Tile,
    };
    use crate::math::{Rgb, UVec2, Vec2, Vec3};

    #[test]
    fn tiles_come_back_bit_for_bit() {
        let bounds = PixelBounds::new(UVec2::new(2, 3), UVec2::new(7, 5));
        let layers = Layer::ALL.into_iter().fold(LayerSet::NONE, LayerSet::with);
        let layers = layers.with_lights(2);
        let blank = || Tile::new(bounds, f32::INFINITY).with_layers(layers);
        let mut tile = blank();
        for (number, pixel) in bounds.pixels().enumerate() {
            let mut surface = SurfaceSample::default();
            surface.set_albedo(Rgb::splat(0.1));
            surface.set_normal(Vec3::NEG_Z);
            surface.set_p(Vec3::new(0.1, -1e-30, 1e30) * number as f32);
            surface.set_uv(Vec2::splat(0.7));
            let seen = LayerSample {
                surface: &surface,
                space: &RenderSpace::default(),
                camera: CameraSample::new(0.3, 1e-9, Vec2::new(-0.0, 1e-40)),
                mattes: ["a", &number.to_string()].map(MatteId::of),
            };
            tile.add_layers(pixel, -1.0, Some(Some(&seen)), &[Rgb::ONE]);
            tile.add_sample(pixel, Rgb::new(0.1, 1e-30, 1e30) * number as f32, 0.3);
            tile.add_sample(
                pixel,
                Rgb::splat(if number == 4 { f32::NAN } else { 1.0 }),
                1.0,
            );
        }
        tile.close();
        let mut bytes = Vec::new();
        tile.store(&mut bytes);
        bytes.push(77);
        let mut rest = &bytes[..];
        let again = blank().restored(&mut rest).expect("a tile");
        assert_eq!(rest, [77]);
        assert!(tile.iter().eq(again.iter()));
        assert_eq!(tile.layers(), again.layers());
        assert_eq!(again.dropped(), 1);
        assert_eq!(tile.first_dropped(), again.first_dropped());
        for cut in [0, 8, bytes.len() - 2] {
            assert!(blank().restored(&mut &bytes[..cut]).is_none());
        }
    }
}
