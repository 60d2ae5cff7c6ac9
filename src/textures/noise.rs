//! Perlin's gradient noise and the sums of octaves made of it.
//!
//! Sources: Perlin, "Improving noise" (SIGGRAPH 2002), with his reference permutation; Pharr,
//! Jakob and Humphreys 2016, §10.6. The choice of gradients is pbrt-v3's, which differs from
//! Perlin's for two of the sixteen hash values (docs/scene-language.md §3.9).

use super::solid::SolidPoint;
use crate::math::Vec3;
use crate::math::float::{clamp_nan_low, floors};
use crate::params::ParamReader;
use wide::{f32x4, i32x4};

/// Perlin's reference permutation of 0…255.
const PERMUTATION: [u8; 256] = include!("permutation.in");

/// Ratio of successive octaves' frequencies. Just below 2, so that lattice points of different
/// octaves, where noise is 0, do not coincide.
const LACUNARITY: f32 = 1.99;

/// What an octave too fine to be seen brings to [`Octaves::turbulence`]: about the mean of the
/// noise's magnitude.
const MEAN_MAGNITUDE: f32 = 0.2;

/// From here on floats are multiples of 256.
const FAR: f32 = (1u32 << 31) as f32;

/// Gradient noise: 0 at points with whole coordinates, within about ±1, with details of size 1.
/// Repeats after 256 units. What is not finite counts as a lattice point.
pub(super) fn noise(p: Vec3) -> f32 {
    let is_near = p.abs().cmplt(Vec3::splat(FAR)).all();
    let p = if is_near { p } else { folded(p) };
    let p = f32x4::new([p.x, p.y, p.z, 0.0]);
    let cell = floors(p);
    let d = p - f32x4::from_i32x4(cell);
    let [wx, wy, wz, _] = fade(d).to_array();
    let [dx, dy, dz, _] = d.to_array();
    let [x, y, z, _] = cell.to_array().map(|c| c as u8);
    // Four corners with the same x side by side: y runs first.
    let ys = f32x4::new([dy, dy - 1.0, dy, dy - 1.0]);
    let zs = f32x4::new([dz, dz, dz - 1.0, dz - 1.0]);
    let corners = |i: u8| {
        let of_x = permuted(x.wrapping_add(i));
        let [a, b] = [y, y.wrapping_add(1)].map(|y| permuted(of_x.wrapping_add(y)));
        let hash = |of_y: u8, k: u8| permuted(of_y.wrapping_add(z).wrapping_add(k));
        let hashes = [hash(a, 0), hash(b, 0), hash(a, 1), hash(b, 1)];
        products(hashes, [f32x4::splat(dx - f32::from(i)), ys, zs])
    };
    let wx = f32x4::splat(wx);
    let along_x = (f32x4::ONE - wx) * corners(0) + wx * corners(1);
    let [a, b, c, d] = along_x.to_array();
    lerp(wz, lerp(wy, a, b), lerp(wy, c, d))
}

/// A point with the noise of one that is far away, or not finite.
#[cold]
fn folded(p: Vec3) -> Vec3 {
    if p.is_finite() {
        Vec3::select(p.abs().cmplt(Vec3::splat(FAR)), p, Vec3::ZERO)
    } else {
        Vec3::ZERO
    }
}

/// Noise in the plane: [`noise`] at z = ½.
pub(super) fn noise2(x: f32, y: f32) -> f32 {
    noise(Vec3::new(x, y, 0.5))
}

fn permuted(i: u8) -> u8 {
    PERMUTATION[usize::from(i)]
}

/// Products of the distances from four corners and the gradients that the low four bits of their hashes choose.
#[inline(always)]
fn products(hashes: [u8; 4], [x, y, z]: [f32x4; 3]) -> f32x4 {
    let lanes = bytemuck::cast::<i32x4, f32x4>;
    let h = i32x4::new(hashes.map(|h| i32::from(h & 15)));
    // 12 and 13.
    let on_edge = (h & i32x4::splat(14)).simd_eq(i32x4::splat(12));
    let first = lanes(h.simd_lt(i32x4::splat(8)) | on_edge).bitselect(x, y);
    let second = lanes(h.simd_lt(i32x4::splat(4)) | on_edge).bitselect(y, z);
    // The lowest two bits are their signs.
    (first ^ lanes((h & i32x4::splat(1)) << 31)) + (second ^ lanes((h & i32x4::splat(2)) << 30))
}

/// Perlin's 6t⁵ − 15t⁴ + 10t³: first and second derivatives vanish at both ends.
#[inline(always)]
fn fade(t: f32x4) -> f32x4 {
    let t3 = t * t * t;
    f32x4::splat(6.0) * t3 * t * t - f32x4::splat(15.0) * t3 * t + f32x4::splat(10.0) * t3
}

fn lerp(t: f32, a: f32, b: f32) -> f32 {
    (1.0 - t) * a + t * b
}

/// Which octaves are summed: as many as asked for, fewer where a film sample's footprint is wider
/// than half their wavelength.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Octaves {
    /// The most octaves there are.
    pub most: u8,
    /// Weight of each octave relative to the one before (`roughness`).
    pub roughness: f32,
}

/// The most octaves a scene may ask for: 1.99¹²⁸ is the largest frequency in single precision.
const MAX_OCTAVES: i64 = 128;

impl Octaves {
    /// `octaves` (8) and `roughness` (0.5).
    pub(super) fn from_params(reader: &ParamReader) -> Octaves {
        Octaves {
            most: reader.integer_within("octaves", 8, 0..=MAX_OCTAVES) as u8,
            roughness: reader.float("roughness", 0.5) as f32,
        }
    }

    /// Fractional Brownian motion: Σ roughnessⁱ · noise(1.99ⁱ p). May be negative.
    pub(super) fn fbm(&self, at: &SolidPoint) -> f32 {
        let (whole, part) = self.seen(at);
        let (sum, weight, frequency) = self.sum_whole(whole, |frequency| noise(at.p * frequency));
        sum + weight * smooth_step(part) * noise(at.p * frequency)
    }

    /// Turbulence: as [`Octaves::fbm`] of the noise's magnitude, with a mean value in place of what
    /// cannot be seen. As in pbrt-v3 the partly seen octave is counted a second time among the latter.
    pub(super) fn turbulence(&self, at: &SolidPoint) -> f32 {
        let (whole, part) = self.seen(at);
        let magnitude = |frequency: f32| noise(at.p * frequency).abs();
        let (mut sum, mut weight, frequency) = self.sum_whole(whole, magnitude);
        sum += weight * lerp(smooth_step(part), MEAN_MAGNITUDE, magnitude(frequency));
        for _ in whole..self.most {
            sum += weight * MEAN_MAGNITUDE;
            weight *= self.roughness;
        }
        sum
    }

    /// The sum of the octaves seen fully, and weight and frequency of the next one.
    fn sum_whole(&self, whole: u8, octave: impl Fn(f32) -> f32) -> (f32, f32, f32) {
        let (mut sum, mut weight, mut frequency) = (0.0, 1.0, 1.0);
        for _ in 0..whole {
            sum += weight * octave(frequency);
            weight *= self.roughness;
            frequency *= LACUNARITY;
        }
        (sum, weight, frequency)
    }

    /// How many octaves are seen fully, and what part of the next one.
    fn seen(&self, at: &SolidPoint) -> (u8, f32) {
        let width2 = at.dpdx.length_squared().max(at.dpdy.length_squared());
        let most = f32::from(self.most);
        let seen = -1.0 - 0.5 * width2.log2();
        // Without a footprint (log2 0 = −∞) all of them; where it is no number, none.
        let seen = clamp_nan_low(seen, 0.0, most);
        let whole = seen.floor();
        (whole as u8, seen - whole)
    }
}

/// How strongly a partly seen octave counts: 0 below 0.3, 1 above 0.7, smooth in between.
fn smooth_step(part: f32) -> f32 {
    let t = ((part - 0.3) / 0.4).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::hash::{mix2, unit_float};

    fn somewhere(i: u64) -> Vec3 {
        let r = |k: u64| 40.0 * unit_float(mix2(i, k)) - 20.0;
        Vec3::new(r(1), r(2), r(3))
    }

    fn point(p: Vec3, width: f32) -> SolidPoint {
        SolidPoint {
            p,
            dpdx: Vec3::new(width, 0.0, 0.0),
            dpdy: Vec3::ZERO,
        }
    }

    const FIVE: Octaves = Octaves {
        most: 5,
        roughness: 0.6,
    };

    #[test]
    fn the_permutation_is_one() {
        let mut sorted = PERMUTATION;
        sorted.sort_unstable();
        assert!((0..=255).eq(sorted));
    }

    #[test]
    fn noise_vanishes_on_the_lattice_and_is_bounded_and_smooth() {
        for i in 0..2000 {
            let p = somewhere(i);
            assert_eq!(noise(p.round()), 0.0);
            // Gradients of length √2 over distances up to √3/2 could give 1.22; known to stay
            // within 1 (up to rounding) by the fade's weights.
            assert!(noise(p).abs() <= 1.0 + 1e-5);
            // The slope is at most a few; a jump between cells would show as more.
            let step = Vec3::new(1e-3, -1e-3, 1e-3);
            assert!((noise(p) - noise(p + step)).abs() < 2e-2, "{p}");
        }
    }

    #[test]
    fn noise_repeats_after_256_units() {
        for i in 0..100 {
            // Eighths, so that the shifted point is exact.
            let p = (somewhere(i) * 8.0).round() / 8.0;
            assert_eq!(noise(p), noise(p + Vec3::new(256.0, -512.0, 256.0)));
        }
    }

    /// [`noise`], a corner at a time.
    fn one_by_one(p: Vec3) -> f32 {
        let d = p - p.floor();
        let [x, y, z] = p.floor().to_array().map(|c| c as i64);
        let permuted = |i: i64| i64::from(PERMUTATION[(i & 255) as usize]);
        let corner = |i: i64, j: i64, k: i64| {
            let hash = permuted(permuted(permuted(x + i) + y + j) + z + k) & 15;
            let [x, y, z] = (d - Vec3::new(i as f32, j as f32, k as f32)).to_array();
            // The midpoints of a cube's edges; four of them twice, and two of these are not those that Perlin has.
            let (first, second) = match hash {
                0..4 | 12 | 13 => (x, y),
                4..8 => (x, z),
                _ => (y, z),
            };
            let signed = |bit: i64, v: f32| if hash & bit == 0 { v } else { -v };
            signed(1, first) + signed(2, second)
        };
        let [wx, wy, wz, _] = fade(f32x4::new([d.x, d.y, d.z, 0.0])).to_array();
        let along_x = |j, k| lerp(wx, corner(0, j, k), corner(1, j, k));
        let along_y = |k| lerp(wy, along_x(0, k), along_x(1, k));
        lerp(wz, along_y(0), along_y(1))
    }

    #[test]
    fn corners_side_by_side_are_those_of_one_at_a_time() {
        for i in 0..5000 {
            for p in [somewhere(i), somewhere(i) * 1e6, -somewhere(i).abs()] {
                assert_eq!(noise(p).to_bits(), one_by_one(p).to_bits(), "{p}");
            }
        }
        // Where a coordinate has no fractions, nor a cell that 32 bits hold.
        let far = Vec3::new(0.25, -3e10, 0.5);
        assert_eq!(noise(far), one_by_one(far));
        assert_ne!(noise(far), 0.0);
    }

    #[test]
    fn mean_magnitude_is_that_of_the_noise() {
        let n = 40_000;
        let mean: f32 = (0..n).map(|i| noise(somewhere(i)).abs()).sum::<f32>() / n as f32;
        // It is pbrt's rounded number for what is about 0.2; noise of the mean here is 0.001.
        assert!((mean - MEAN_MAGNITUDE).abs() < 0.05, "{mean}");
    }

    #[test]
    fn octaves_are_cut_where_the_footprint_is_wider_than_half_a_wave() {
        // Widths 2⁻¹⁻ⁿ show n octaves.
        for (width, expected) in [
            (0.0, (5, 0.0)),
            (1e-9, (5, 0.0)),
            (0.5, (0, 0.0)),
            (0.25, (1, 0.0)),
            (0.125, (2, 0.0)),
            (7.0, (0, 0.0)),
            (f32::INFINITY, (0, 0.0)),
            (f32::NAN, (5, 0.0)),
        ] {
            let found = FIVE.seen(&point(Vec3::ONE, width));
            assert_eq!(found, expected, "{width}");
        }
        let p = Vec3::new(0.3, 1.7, -2.2);
        assert_eq!(FIVE.fbm(&point(p, 0.25)), noise(p));
        let two = noise(p) + 0.6 * noise(p * 1.99);
        assert!((FIVE.fbm(&point(p, 0.125)) - two).abs() < 1e-6);
    }

    #[test]
    fn unseen_turbulence_is_its_mean() {
        let p = Vec3::new(0.3, 1.7, -2.2);
        // All octaves unseen: Σ 0.2 · 0.6ⁱ, and the first one twice (see the method).
        let mean: f32 = (0..5).map(|i| 0.2 * 0.6f32.powi(i)).sum::<f32>() + 0.2;
        assert!((FIVE.turbulence(&point(p, 3.0)) - mean).abs() < 1e-6);
    }

    #[test]
    fn wild_points_are_harmless() {
        let many = Octaves {
            most: 128,
            roughness: 1.0,
        };
        for x in [
            1e30,
            -1e30,
            f32::MAX,
            f32::NAN,
            f32::INFINITY,
            9.3e18,
            1e-40,
        ] {
            for p in [Vec3::splat(x), Vec3::new(0.5, x, 0.25)] {
                assert!(noise(p).is_finite());
                assert!(many.fbm(&point(p, 0.0)).is_finite());
                assert!(many.turbulence(&point(p, x)).is_finite());
            }
        }
    }
}
