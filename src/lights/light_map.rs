//! Images that lights are shaped by.
//!
//! As in pbrt-v3 they are first enlarged to powers of two, looked up bilinearly, and wrap around in
//! *both* directions, so that opposite edges blend with each other. Row 0, the image's top, is at
//! v = 0; values are taken as they are stored, without gamma (docs/scene-language.md §3.10).
//! Source: Pharr, Jakob and Humphreys 2016, §10.4.3.

use crate::math::float::floor;
use crate::math::{Rgb, Vec2};
use std::f64::consts::PI;

/// An image ready to be looked up.
#[derive(Clone, Debug)]
pub struct LightMap {
    /// Columns; a power of two.
    pub(super) width: usize,
    /// Rows; a power of two.
    pub(super) height: usize,
    /// Row by row, the top one first.
    pub(super) texels: Vec<Rgb>,
    /// Width over height of the image as it was given.
    pub(super) aspect: f32,
}

impl LightMap {
    /// From an image's rows, the top one first. Texels that are not finite become black.
    /// `None` for an image without texels, or with fewer than its size says.
    pub fn new(width: usize, height: usize, mut texels: Vec<Rgb>) -> Option<LightMap> {
        if width == 0 || height == 0 || width.checked_mul(height)? != texels.len() {
            return None;
        }
        for texel in &mut texels {
            if !texel.is_finite() {
                *texel = Rgb::ZERO;
            }
        }
        let aspect = width as f32 / height as f32;
        let (width, height, texels) = enlarge_to_powers_of_two(width, height, texels);
        Some(LightMap {
            width,
            height,
            texels,
            aspect,
        })
    }

    fn texel(&self, x: i64, y: i64) -> Rgb {
        // Sides are powers of two: masking wraps negative positions too.
        let x = x as usize & (self.width - 1);
        let y = y as usize & (self.height - 1);
        self.texels[y * self.width + x]
    }

    /// The texels at `uv`, (0, 0) the upper left and (1, 1) the lower right corner, interpolated.
    pub fn lookup(&self, uv: Vec2) -> Rgb {
        let s = uv.x * self.width as f32 - 0.5;
        let t = uv.y * self.height as f32 - 0.5;
        let ((x, below_s), (y, below_t)) = (floor(s), floor(t));
        let (ds, dt) = (s - below_s, t - below_t);
        let top = self.texel(x, y) * (1.0 - ds) + self.texel(x.wrapping_add(1), y) * ds;
        let bottom = self.texel(x, y.wrapping_add(1)) * (1.0 - ds)
            + self.texel(x.wrapping_add(1), y.wrapping_add(1)) * ds;
        top * (1.0 - dt) + bottom * dt
    }

    /// Mean of the texels weighted by `weight` of their centers' (u, v).
    pub fn mean(&self, weight: impl Fn(f64, f64) -> f64) -> Rgb {
        let (mut sum, mut weights) = (glam::DVec3::ZERO, 0.0);
        for (y, row) in self.texels.chunks_exact(self.width).enumerate() {
            let v = (y as f64 + 0.5) / self.height as f64;
            for (x, texel) in row.iter().enumerate() {
                let weight = weight((x as f64 + 0.5) / self.width as f64, v);
                sum += weight * texel.as_dvec3();
                weights += weight;
            }
        }
        (sum / weights).as_vec3()
    }

    /// Mean over the sphere of directions, where v is the polar angle over π.
    pub fn sphere_mean(&self) -> Rgb {
        self.mean(|_, v| (PI * v).sin())
    }
}

/// Resamples to the next powers of two where a side is none, as pbrt-v3 does with all its
/// images: each new texel from four old ones by a Lanczos filter of half width 2, wrapping
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

    #[test]
    fn texel_centers_show_their_texels_and_edges_wrap() {
        let texels: Vec<Rgb> = (0..32).map(|i| Rgb::splat(i as f32)).collect();
        let map = LightMap::new(8, 4, texels).unwrap();
        for (i, expected) in [(0, 0.0), (9, 9.0), (31, 31.0)] {
            let uv = Vec2::new((i % 8) as f32 + 0.5, (i / 8) as f32 + 0.5) / Vec2::new(8.0, 4.0);
            assert_eq!(map.lookup(uv), Rgb::splat(expected));
        }
        // Half-way between the last column and the first; and between the last row and the first.
        assert_eq!(map.lookup(Vec2::new(0.0, 0.125)), Rgb::splat(3.5));
        assert_eq!(map.lookup(Vec2::new(0.0625, 0.0)), Rgb::splat(12.0));
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
    fn odd_images_are_refused_or_cleaned() {
        assert!(LightMap::new(0, 4, vec![]).is_none());
        assert!(LightMap::new(2, 2, vec![Rgb::ONE; 3]).is_none());
        assert!(LightMap::new(usize::MAX, 2, vec![]).is_none());
        let map =
            LightMap::new(2, 1, vec![Rgb::splat(f32::NAN), Rgb::splat(f32::INFINITY)]).unwrap();
        assert_eq!(map.sphere_mean(), Rgb::ZERO);
    }
}
