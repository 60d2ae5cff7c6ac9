//! Latitude-longitude pictures of light coming from all around, and sampling them.
//!
//! Coordinates are u = azimuth/2π from +x over +y, v = polar angle/π from +z, both in [0, 1);
//! picture row 0, its top, is at v = 0 (scene-language 3.10). As in pbrt-v3 pictures are first
//! enlarged to powers of two, looked up bilinearly, and wrap around in *both* directions, so that
//! the poles blend with each other.
//! Source: Pharr, Jakob and Humphreys 2016, §10.4.3, §12.6 and §14.2.4.

use crate::math::color::luminance;
use crate::math::distribution::Distribution2D;
use crate::math::{Rgb, Vec2};
use std::f64::consts::PI;

/// Up to so many texels the density has four cells in each (2048 × 1024); beyond, one.
const MOST_FINE_TEXELS: usize = 1 << 21;

/// Weights of the texel before, the texel itself and the one after it in the mean, over a part of
/// that texel, of the linear interpolation between their centres.
struct Blend([f32; 3]);

/// The two halves of a texel.
const HALF_TEXELS: [Blend; 2] = [Blend([0.25, 0.75, 0.0]), Blend([0.0, 0.75, 0.25])];

/// All of it.
const WHOLE_TEXELS: [Blend; 1] = [Blend([0.125, 0.75, 0.125])];

/// What the density's cells are in a picture of so many texels.
fn parts_for(texels: usize) -> &'static [Blend] {
    if texels <= MOST_FINE_TEXELS {
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

/// A picture ready to be looked up and sampled.
#[derive(Clone, Debug)]
pub struct EnvironmentMap {
    width: usize,
    height: usize,
    texels: Vec<Rgb>,
    density: Distribution2D,
    mean: Rgb,
}

impl EnvironmentMap {
    /// From a picture's rows, the top one first. Texels that are not finite become black.
    /// `None` for a picture without texels, or with fewer than its size says.
    pub fn new(width: usize, height: usize, mut texels: Vec<Rgb>) -> Option<EnvironmentMap> {
        if width == 0 || height == 0 || width.checked_mul(height)? != texels.len() {
            return None;
        }
        for texel in &mut texels {
            if !texel.is_finite() {
                *texel = Rgb::ZERO;
            }
        }
        let (width, height, texels) = enlarge_to_powers_of_two(width, height, texels);
        let picture = Bilinear {
            width,
            height,
            texels: &texels,
        };
        let density = picture.density(parts_for(texels.len()));
        let mean = picture.mean();
        Some(EnvironmentMap {
            width,
            height,
            texels,
            density,
            mean,
        })
    }

    /// The texels at `uv`, interpolated.
    pub fn lookup(&self, uv: Vec2) -> Rgb {
        Bilinear {
            width: self.width,
            height: self.height,
            texels: &self.texels,
        }
        .at(uv)
    }

    /// A point, and its density over the unit square, about proportional to luminance × sin θ and
    /// positive wherever the map is not black.
    pub fn sample(&self, u: Vec2) -> (Vec2, f32) {
        self.density.sample(u)
    }

    /// Density of [`EnvironmentMap::sample`].
    pub fn pdf(&self, uv: Vec2) -> f32 {
        self.density.pdf(uv)
    }

    /// Mean over the sphere of directions.
    pub fn mean(&self) -> Rgb {
        self.mean
    }
}

/// Texels with power-of-two sides as a continuous, periodic function.
struct Bilinear<'a> {
    width: usize,
    height: usize,
    texels: &'a [Rgb],
}

impl Bilinear<'_> {
    fn texel(&self, x: i64, y: i64) -> Rgb {
        // Sides are powers of two: masking wraps negative positions too.
        let x = x as usize & (self.width - 1);
        let y = y as usize & (self.height - 1);
        self.texels[y * self.width + x]
    }

    fn at(&self, uv: Vec2) -> Rgb {
        let s = uv.x * self.width as f32 - 0.5;
        let t = uv.y * self.height as f32 - 0.5;
        let (x, y) = (s.floor(), t.floor());
        let (ds, dt) = (s - x, t - y);
        let (x, y) = (x as i64, y as i64);
        let top = self.texel(x, y) * (1.0 - ds) + self.texel(x + 1, y) * ds;
        let bottom = self.texel(x, y + 1) * (1.0 - ds) + self.texel(x + 1, y + 1) * ds;
        top * (1.0 - dt) + bottom * dt
    }

    /// Cells in which the function is a single bilinear patch, or four such patches in large
    /// pictures; each holds the mean of its luminance × sin θ at its middle, which vanishes only
    /// where the function does.
    fn density(&self, parts: &[Blend]) -> Distribution2D {
        // Magnitudes of the channels: a negative one, which a damaged picture may have, must not
        // hide a positive one.
        let luminances: Vec<f32> = self.texels.iter().map(|t| luminance(t.abs())).collect();
        let (columns, rows) = (parts.len() * self.width, parts.len() * self.height);
        let mut values = Vec::with_capacity(columns * rows);
        let mut row = vec![0.0; self.width];
        for j in 0..rows {
            let sin_theta = (PI * (j as f64 + 0.5) / rows as f64).sin() as f32;
            self.blend_rows(
                &luminances,
                j / parts.len(),
                &parts[j % parts.len()],
                &mut row,
            );
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
        Distribution2D::new(&values, columns, rows)
    }

    /// Row `y` of `values` blended with its neighbours.
    fn blend_rows(&self, values: &[f32], y: usize, blend: &Blend, result: &mut [f32]) {
        let row = |y: usize| {
            let start = (y & (self.height - 1)) * self.width;
            &values[start..start + self.width]
        };
        let (above, here, below) = (row(y.wrapping_sub(1)), row(y), row(y + 1));
        for (x, r) in result.iter_mut().enumerate() {
            *r = blend.of(above[x], here[x], below[x]);
        }
    }

    fn mean(&self) -> Rgb {
        let (mut sum, mut weights) = (glam::DVec3::ZERO, 0.0);
        for (y, row) in self.texels.chunks_exact(self.width).enumerate() {
            let sin_theta = (PI * (y as f64 + 0.5) / self.height as f64).sin();
            let row_sum: glam::DVec3 = row.iter().map(|t| t.as_dvec3()).sum();
            sum += sin_theta * row_sum;
            weights += sin_theta * self.width as f64;
        }
        (sum / weights).as_vec3()
    }
}

/// Resamples to the next powers of two where a side is none, as pbrt-v3 does with all its
/// pictures: each new texel from four old ones by a Lanczos filter of half width 2, wrapping
/// around, columns first; negative results become 0.
fn enlarge_to_powers_of_two(
    width: usize,
    height: usize,
    texels: Vec<Rgb>,
) -> (usize, usize, Vec<Rgb>) {
    if width.is_power_of_two() && height.is_power_of_two() {
        return (width, height, texels);
    }
    let (new_width, new_height) = (width.next_power_of_two(), height.next_power_of_two());
    let across: Vec<_> = (0..new_width)
        .map(|x| contributions(x, width, new_width))
        .collect();
    let mut wide = Vec::with_capacity(new_width * height);
    for row in texels.chunks_exact(width) {
        wide.extend(
            across
                .iter()
                .map(|c| c.iter().map(|&(x, weight)| row[x] * weight).sum::<Rgb>()),
        );
    }
    let mut enlarged = Vec::with_capacity(new_width * new_height);
    for y in 0..new_height {
        let down = contributions(y, height, new_height);
        enlarged.extend((0..new_width).map(|x| {
            let sum: Rgb = down
                .iter()
                .map(|&(row, weight)| wide[row * new_width + x] * weight)
                .sum();
            sum.max(Rgb::ZERO)
        }));
    }
    (new_width, new_height, enlarged)
}

/// Which of `old` texels make up number `i` of `new` ones, and their weights.
fn contributions(i: usize, old: usize, new: usize) -> [(usize, f32); 4] {
    /// Half width of the filter, in old texels.
    const HALF_WIDTH: f64 = 2.0;
    let center = (i as f64 + 0.5) * old as f64 / new as f64;
    let first = (center - HALF_WIDTH + 0.5).floor();
    let weights: [f64; 4] =
        std::array::from_fn(|k| lanczos((first + k as f64 + 0.5 - center) / HALF_WIDTH));
    let total: f64 = weights.iter().sum();
    std::array::from_fn(|k| {
        let index = (first as i64 + k as i64).rem_euclid(old as i64);
        (index as usize, (weights[k] / total) as f32)
    })
}

/// Lanczos' window of two lobes over −1 … 1.
fn lanczos(x: f64) -> f64 {
    let sinc = |x: f64| {
        if x.abs() < 1e-5 {
            1.0
        } else {
            (PI * x).sin() / (PI * x)
        }
    };
    if x.abs() > 1.0 {
        0.0
    } else {
        sinc(2.0 * x) * sinc(x)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A picture with a bright spot and black parts.
    fn spotted(width: usize, height: usize) -> EnvironmentMap {
        let mut texels = vec![Rgb::ZERO; width * height];
        for (i, texel) in texels.iter_mut().enumerate() {
            if i % 3 == 0 {
                *texel = Rgb::splat((i % 7) as f32 * 0.1);
            }
        }
        texels[width * (height / 3) + width / 5] = Rgb::new(80.0, 60.0, 40.0);
        EnvironmentMap::new(width, height, texels).unwrap()
    }

    #[test]
    fn texel_centers_show_their_texels_and_edges_wrap() {
        let texels: Vec<Rgb> = (0..32).map(|i| Rgb::splat(i as f32)).collect();
        let map = EnvironmentMap::new(8, 4, texels).unwrap();
        for (i, expected) in [(0, 0.0), (9, 9.0), (31, 31.0)] {
            let uv = Vec2::new((i % 8) as f32 + 0.5, (i / 8) as f32 + 0.5) / Vec2::new(8.0, 4.0);
            assert_eq!(map.lookup(uv), Rgb::splat(expected));
        }
        // Half-way between the last column and the first; and between the last row and the first.
        assert_eq!(map.lookup(Vec2::new(0.0, 0.125)), Rgb::splat(3.5));
        assert_eq!(map.lookup(Vec2::new(0.0625, 0.0)), Rgb::splat(12.0));
    }

    #[test]
    fn density_is_positive_where_the_map_is_and_integrates_to_one() {
        for (width, height) in [(16, 8), (13, 5), (1, 1), (2, 64)] {
            let map = spotted(width, height);
            let n = 512;
            let mut total = 0.0;
            for i in 0..n * n {
                let uv = Vec2::new((i % n) as f32 + 0.5, (i / n) as f32 + 0.5) / n as f32;
                let pdf = map.pdf(uv);
                assert!(pdf > 0.0 || map.lookup(uv) == Rgb::ZERO);
                total += f64::from(pdf) / f64::from(n * n);
            }
            // Cells are whole numbers of grid points, except for 2 × 64 texels where they are too.
            assert!((total - 1.0).abs() < 1e-3, "{width} × {height}: {total}");
        }
    }

    #[test]
    fn coarse_cells_are_positive_where_fine_ones_are() {
        let map = spotted(32, 16);
        let picture = Bilinear {
            width: 32,
            height: 16,
            texels: &map.texels,
        };
        let (fine, coarse) = (
            picture.density(&HALF_TEXELS),
            picture.density(&WHOLE_TEXELS),
        );
        for i in 0..64 * 32 {
            let uv =
                Vec2::new((i % 64) as f32 + 0.5, (i / 64) as f32 + 0.5) / Vec2::new(64.0, 32.0);
            let (f, c) = (fine.pdf(uv), coarse.pdf(uv));
            // f is one quarter of the four whose mean the coarse cell holds, with a sin θ up to
            // 1.5 times as large in the row next to the pole; 2 % more for the normalisation.
            assert!(f <= 4.0 * 1.5 * 1.02 * c);
        }
        // Both integrate the same function but for sin θ taken at rows of another height.
        assert!((fine.integral() / coarse.integral() - 1.0).abs() < 1e-2);
    }

    #[test]
    fn sampling_estimates_the_mean() {
        for (width, height) in [(16, 8), (13, 5)] {
            let map = spotted(width, height);
            let n = 512;
            let mut sum = 0.0;
            for i in 0..n * n {
                let u = Vec2::new((i % n) as f32 + 0.5, (i / n) as f32 + 0.5) / n as f32;
                let (uv, pdf) = map.sample(u);
                assert!((map.pdf(uv) / pdf - 1.0).abs() < 1e-5);
                // dω = 2π² sinθ du dv; the sphere has 4π.
                let sphere = std::f32::consts::FRAC_PI_2 * (std::f32::consts::PI * uv.y).sin();
                sum += f64::from(map.lookup(uv).x * sphere / pdf) / f64::from(n * n);
            }
            // The mean counts sin θ at texel centres only: off by O(1/height²) of it.
            let expected = f64::from(map.mean().x);
            assert!((sum / expected - 1.0).abs() < 0.05, "{sum} but {expected}");
        }
    }

    #[test]
    fn enlarging_keeps_constants_and_powers_of_two() {
        let (w, h, texels) = enlarge_to_powers_of_two(5, 3, vec![Rgb::splat(0.7); 15]);
        assert_eq!((w, h), (8, 4));
        assert!(
            texels
                .iter()
                .all(|t| (*t - Rgb::splat(0.7)).abs().max_element() < 1e-6)
        );
        // A side that is a power of two already passes through the same filter unchanged.
        let columns: Vec<Rgb> = (0..12).map(|i| Rgb::splat((i % 4) as f32)).collect();
        let (w, h, texels) = enlarge_to_powers_of_two(4, 3, columns);
        assert_eq!((w, h), (4, 4));
        for (i, t) in texels.iter().enumerate() {
            assert!((t.x - (i % 4) as f32).abs() < 1e-6);
        }
    }

    #[test]
    fn odd_pictures_are_refused_or_cleaned() {
        assert!(EnvironmentMap::new(0, 4, vec![]).is_none());
        assert!(EnvironmentMap::new(2, 2, vec![Rgb::ONE; 3]).is_none());
        assert!(EnvironmentMap::new(usize::MAX, 2, vec![]).is_none());
        let map = EnvironmentMap::new(2, 1, vec![Rgb::splat(f32::NAN), Rgb::splat(f32::INFINITY)])
            .unwrap();
        assert_eq!(map.mean(), Rgb::ZERO);
        let (uv, pdf) = map.sample(Vec2::splat(0.4));
        assert!(uv.is_finite() && pdf.is_finite());
    }
}
