//! Latitude-longitude images of light coming from all around, and sampling them.
//!
//! Coordinates are u = azimuth/2π from +x over +y, v = polar angle/π from +z, both in [0, 1);
//! image row 0, its top, is at v = 0 (docs/scene-language.md §3.10). As [`LightMap`]s do, they wrap around in
//! *both* directions, so that the poles blend with each other.
//! Source: Pharr, Jakob and Humphreys 2016, §12.6 and §14.2.4.

use super::light_map::LightMap;
use super::sky_density::SkyDensity;
use crate::math::Rgb;
use crate::math::color::luminance;
use std::f64::consts::PI;

/// Up to so many texels the density has four cells in each (256 × 128), beyond, one: the error is the same for texels that small
/// (1.0019 times in a meadow under 512 × 256 texels), and the tables stay in the processor's caches.
const MAX_FINE_TEXELS: usize = 1 << 15;

/// Weights of the texel before, the texel itself and the one after it in the mean, over a part of
/// that texel, of the linear interpolation between their centers.
struct Blend([f32; 3]);

/// The two halves of a texel.
const HALF_TEXELS: [Blend; 2] = [Blend([0.25, 0.75, 0.0]), Blend([0.0, 0.75, 0.25])];

/// All of it.
const WHOLE_TEXELS: [Blend; 1] = [Blend([0.125, 0.75, 0.125])];

/// What the density's cells are in an image of so many texels.
fn parts_for(texels: usize) -> &'static [Blend] {
    if texels <= MAX_FINE_TEXELS {
        &HALF_TEXELS
    } else {
        &WHOLE_TEXELS
    }
}

impl Blend {
    fn of(&self, before: f32, here: f32, after: f32) -> f32 {
        self.0[0] * before + self.0[1] * here + self.0[2] * after
    }
}

/// An image ready to be looked up and sampled.
#[derive(Clone, Debug)]
pub struct EnvironmentMap {
    /// The image.
    pub(super) map: LightMap,
    /// About proportional to luminance × sin θ for [`Receiver::Alone`](super::sky_density::Receiver::Alone), and
    /// positive wherever the map is not black for all.
    pub(super) density: SkyDensity,
    /// Mean over the sphere of directions.
    pub(super) mean: Rgb,
}

impl EnvironmentMap {
    /// Prepares sampling of `map`.
    pub fn new(map: LightMap) -> EnvironmentMap {
        EnvironmentMap {
            density: Luminances::of(&map).density(parts_for(map.texels.len())),
            mean: map.sphere_mean(),
            map,
        }
    }
}

/// How bright a map's texels are.
struct Luminances {
    width: usize,
    height: usize,
    values: Vec<f32>,
}

impl Luminances {
    fn of(map: &LightMap) -> Luminances {
        Luminances {
            width: map.width,
            height: map.height,
            // Magnitudes of the channels: a negative one, which a damaged image may have, must
            // not hide a positive one.
            values: map.texels.iter().map(|t| luminance(t.abs())).collect(),
        }
    }

    /// Cells in which the function is a single bilinear patch, or four such patches in large
    /// images; each holds the mean of its luminance × sin θ at its middle, which vanishes only
    /// where the function does.
    fn density(&self, parts: &[Blend]) -> SkyDensity {
        let (columns, rows) = (parts.len() * self.width, parts.len() * self.height);
        let mut values = Vec::with_capacity(columns * rows);
        let mut row = vec![0.0; self.width];
        for j in 0..rows {
            let sin_theta = (PI * (j as f64 + 0.5) / rows as f64).sin() as f32;
            self.blend_rows(j / parts.len(), &parts[j % parts.len()], &mut row);
            let last = self.width - 1;
            for x in 0..self.width {
                let (before, after) = (row[x.wrapping_sub(1) & last], row[(x + 1) & last]);
                values.extend(
                    parts
                        .iter()
                        .map(|p| sin_theta * p.of(before, row[x], after)),
                );
            }
        }
        SkyDensity::new(&values, columns)
    }

    /// Row `y` blended with its neighbors.
    fn blend_rows(&self, y: usize, blend: &Blend, result: &mut [f32]) {
        let row = |y: usize| {
            let start = (y & (self.height - 1)) * self.width;
            &self.values[start..start + self.width]
        };
        let (above, here, below) = (row(y.wrapping_sub(1)), row(y), row(y + 1));
        for (x, r) in result.iter_mut().enumerate() {
            *r = blend.of(above[x], here[x], below[x]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lights::sky_density::Receiver;
    use crate::math::Vec2;

    /// An image with a bright spot and black parts.
    fn spotted(width: usize, height: usize) -> EnvironmentMap {
        let mut texels = vec![Rgb::ZERO; width * height];
        for (i, texel) in texels.iter_mut().enumerate() {
            if i % 3 == 0 {
                *texel = Rgb::splat((i % 7) as f32 * 0.1);
            }
        }
        texels[width * (height / 3) + width / 5] = Rgb::new(80.0, 60.0, 40.0);
        EnvironmentMap::new(LightMap::new(width, height, texels).unwrap())
    }

    #[test]
    fn density_is_positive_where_the_map_is_and_integrates_to_one() {
        for (width, height) in [(16, 8), (13, 5), (1, 1), (2, 64)] {
            let map = spotted(width, height);
            let n = 512;
            let mut total = 0.0;
            for i in 0..n * n {
                let uv = Vec2::new((i % n) as f32 + 0.5, (i / n) as f32 + 0.5) / n as f32;
                let pdf = map.density.pdf(Receiver::Alone, uv);
                assert!(pdf > 0.0 || map.map.lookup(uv) == Rgb::ZERO);
                total += f64::from(pdf) / f64::from(n * n);
            }
            // Cells are whole numbers of grid points, except for 2 × 64 texels where they are too.
            assert!((total - 1.0).abs() < 1e-3, "{width} × {height}: {total}");
        }
    }

    #[test]
    fn coarse_cells_are_positive_where_fine_ones_are() {
        let map = spotted(32, 16);
        let image = Luminances::of(&map.map);
        let (fine, coarse) = (image.density(&HALF_TEXELS), image.density(&WHOLE_TEXELS));
        for i in 0..64 * 32 {
            let uv =
                Vec2::new((i % 64) as f32 + 0.5, (i / 64) as f32 + 0.5) / Vec2::new(64.0, 32.0);
            let (f, c) = (
                fine.pdf(Receiver::Alone, uv),
                coarse.pdf(Receiver::Alone, uv),
            );
            // f is one quarter of the four whose mean the coarse cell holds, with a sin θ up to
            // 1.5 times as large in the row next to the pole; 2 % more for the normalisation.
            assert!(f <= 4.0 * 1.5 * 1.02 * c);
        }
    }

    #[test]
    fn sampling_estimates_the_mean() {
        for (width, height) in [(16, 8), (13, 5)] {
            let map = spotted(width, height);
            let n = 512;
            let mut sum = 0.0;
            for i in 0..n * n {
                let u = Vec2::new((i % n) as f32 + 0.5, (i / n) as f32 + 0.5) / n as f32;
                let (uv, pdf) = map.density.sample(Receiver::Alone, u);
                assert!((map.density.pdf(Receiver::Alone, uv) / pdf - 1.0).abs() < 1e-5);
                // dω = 2π² sinθ du dv; the sphere has 4π.
                let sphere = std::f32::consts::FRAC_PI_2 * (std::f32::consts::PI * uv.y).sin();
                sum += f64::from(map.map.lookup(uv).x * sphere / pdf) / f64::from(n * n);
            }
            // The mean counts sin θ at texel centers only: off by O(1/height²) of it.
            let expected = f64::from(map.mean.x);
            assert!((sum / expected - 1.0).abs() < 0.05, "{sum} but {expected}");
        }
    }
}
