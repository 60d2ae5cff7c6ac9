//! Prefiltered images: a pyramid of ever coarser copies, looked up trilinearly or by elliptically
//! weighted averaging (Williams 1983; Heckbert 1989; Pharr, Jakob and Humphreys 2016, §10.4.3–5).

use super::{TextureCoordinates, TextureValue};
use crate::math::Vec2;
use crate::math::float::{clamp_nan_low, floor, floors};
use std::f32::consts::PI;
use wide::f32x4;

/// What lies outside the image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wrap {
    /// The image again.
    Repeat,
    /// Black.
    Black,
    /// The nearest texel of its border.
    Clamp,
}

/// How a footprint is filtered.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Filter {
    /// A square as wide as the longest side of the footprint.
    Trilinear,
    /// A Gaussian over the footprint's ellipse.
    Ewa {
        /// Largest ratio of the ellipse's axes; beyond it the short one is widened.
        max_anisotropy: f32,
    },
}

/// Largest eccentricity honored: a look-up visits a number of texels proportional to it.
const ANISOTROPY_LIMIT: f32 = 1024.0;

/// Entries of the Gaussian's table.
const GAUSSIAN_SIZE: usize = 128;

/// Steps from a texel to the next three.
const FOUR: f32x4 = f32x4::new([0.0, 1.0, 2.0, 3.0]);

/// An image of power-of-two size with its coarser copies; t runs with the rows.
#[derive(Clone, Debug)]
pub struct Mipmap<V> {
    levels: Vec<Level<V>>,
    wrap: Wrap,
    filter: Filter,
    /// e^(−2r²) − e^(−2) over r² in 0…1.
    gaussian: [f32; GAUSSIAN_SIZE],
}

#[derive(Clone, Debug)]
struct Level<V> {
    width: usize,
    height: usize,
    texels: Vec<V>,
}

impl<V: TextureValue> Mipmap<V> {
    /// From `height` rows of `width` texels, row 0 at t = 0; both at least 1. Sizes that are not
    /// powers of two are enlarged to the next ones, as pbrt-v3 does.
    pub fn new(
        width: usize,
        height: usize,
        texels: Vec<V>,
        wrap: Wrap,
        filter: Filter,
    ) -> Mipmap<V> {
        let filter = match filter {
            Filter::Ewa { max_anisotropy } => Filter::Ewa {
                max_anisotropy: clamp_nan_low(max_anisotropy, 1.0, ANISOTROPY_LIMIT),
            },
            Filter::Trilinear => Filter::Trilinear,
        };
        let finest = Level {
            width,
            height,
            texels,
        }
        .enlarged(wrap);
        let mut levels = vec![finest];
        levels.extend(std::iter::successors(levels[0].halved(), Level::halved));
        let gaussian = std::array::from_fn(|i| {
            let r2 = i as f32 / (GAUSSIAN_SIZE - 1) as f32;
            (-2.0 * r2).exp() - (-2.0f32).exp()
        });
        Mipmap {
            levels,
            wrap,
            filter,
            gaussian,
        }
    }

    /// The filtered value.
    pub fn lookup(&self, at: &TextureCoordinates) -> V {
        match self.filter {
            Filter::Trilinear => {
                let width = at.dstdx.abs().max(at.dstdy.abs()).max_element();
                self.trilinear(at.st, width)
            }
            Filter::Ewa { max_anisotropy } => self.elliptical(at, max_anisotropy),
        }
    }

    /// Mean over a square of side `width` (in units of the whole image), linear between levels.
    fn trilinear(&self, st: Vec2, width: f32) -> V {
        let level = (self.levels.len() - 1) as f32 + width.max(1e-8).log2();
        self.between_levels(level, |level| self.bilinear(level, st))
    }

    /// Linear interpolation between the two levels around `level`, which is kept in range.
    fn between_levels(&self, level: f32, value: impl Fn(usize) -> V) -> V {
        let last = self.levels.len() - 1;
        if level <= 0.0 {
            return value(0);
        }
        if level < last as f32 {
            let low = level as u16;
            let fraction = level - f32::from(low);
            let low = usize::from(low);
            value(low) * (1.0 - fraction) + value(low + 1) * fraction
        } else {
            // Also where the footprint is not a number.
            self.levels[last].texels[0]
        }
    }

    /// Linear in s and in t between the four texels around `st`, whose centers lie at (i + ½)/n.
    fn bilinear(&self, level: usize, st: Vec2) -> V {
        let level = &self.levels[level];
        let p = st * level.size() - 0.5;
        let ((s, below_s), (t, below_t)) = (floor(p.x), floor(p.y));
        let d = p - Vec2::new(below_s, below_t);
        level.texel(s, t, self.wrap) * ((1.0 - d.x) * (1.0 - d.y))
            + level.texel(s, t.saturating_add(1), self.wrap) * ((1.0 - d.x) * d.y)
            + level.texel(s.saturating_add(1), t, self.wrap) * (d.x * (1.0 - d.y))
            + level.texel(s.saturating_add(1), t.saturating_add(1), self.wrap) * (d.x * d.y)
    }

    /// Elliptically weighted average over the parallelogram of the differentials, at the level
    /// where the ellipse's short axis spans one or two texels (§10.4.5).
    fn elliptical(&self, at: &TextureCoordinates, max_anisotropy: f32) -> V {
        let (mut major, mut minor) = (at.dstdx, at.dstdy);
        if major.length_squared() < minor.length_squared() {
            std::mem::swap(&mut major, &mut minor);
        }
        let (major_length, mut minor_length) = (major.length(), minor.length());
        if minor_length == 0.0 {
            return self.bilinear(0, at.st);
        }
        if minor_length * max_anisotropy < major_length {
            let widening = major_length / (minor_length * max_anisotropy);
            minor *= widening;
            minor_length *= widening;
        }
        let last = self.levels.len() - 1;
        let level = last as f32 + minor_length.log2();
        self.between_levels(level, |level| self.ellipse(level, at.st, major, minor))
    }

    /// The Gaussian over one level's texels within the ellipse of the given half-axes.
    fn ellipse(&self, level: usize, st: Vec2, major: Vec2, minor: Vec2) -> V {
        let level = &self.levels[level];
        let p = st * level.size() - 0.5;
        let Some(Ellipse {
            form: [a, b, c],
            first,
            last,
        }) = Ellipse::new(p, major * level.size(), minor * level.size())
        else {
            return level.texel(p.x as i64, p.y as i64, self.wrap);
        };
        let (mut sum, mut weights) = (V::default(), 0.0);
        let [a, b] = [a, b].map(f32x4::splat);
        for t in first[1]..last[1] + 1 {
            let dt = t as f32 - p.y;
            let of_row = f32x4::splat(c * dt * dt);
            let row = level.row(t.into(), self.wrap);
            // Four texels side by side: of a long footprint's box more than half are outside the ellipse.
            let mut start = first[0];
            while start <= last[0] {
                let ds = f32x4::splat(start as f32) + FOUR - f32x4::splat(p.x);
                let r2 = a * ds * ds + b * ds * f32x4::splat(dt) + of_row;
                let mut inside = r2.simd_lt(f32x4::ONE).to_bitmask();
                // Beyond the box texels may only seem to be inside, where single precision does not tell them apart.
                inside &= 0b1111 >> (3 - last[0] + start).max(0);
                // Rounding takes some below 0.
                let entry = r2.fast_max(f32x4::ZERO) * f32x4::splat(GAUSSIAN_SIZE as f32);
                let entries = entry.fast_trunc_int().to_array();
                while inside != 0 {
                    let lane = inside.trailing_zeros();
                    inside &= inside - 1;
                    let weight = self.gaussian[entries[lane as usize] as usize % GAUSSIAN_SIZE];
                    sum += row.texel((start + lane as i32).into()) * weight;
                    weights += weight;
                }
                start += 4;
            }
        }
        // In single precision none may be inside of an ellipse that is long and thin.
        if weights > 0.0 {
            sum * (1.0 / weights)
        } else {
            level.texel(p.x as i64, p.y as i64, self.wrap)
        }
    }
}

/// Texels farther than this from the first are not told apart in single precision.
const FARTHEST: f32 = (1 << 24) as f32;

/// An ellipse among the texels of a level, whose centers are whole numbers.
struct Ellipse {
    /// A, B and C of its points' A s² + B s t + C t² < 1, from the middle.
    form: [f32; 3],
    /// The first and the last texel that it may hold, in s and t.
    first: [i32; 2],
    last: [i32; 2],
}

impl Ellipse {
    /// Around `p`, with these half-axes, grown by one texel so that it always holds some. `None` where texels are not told apart, or where
    /// anything is NaN.
    #[inline(always)]
    fn new(p: Vec2, major: Vec2, minor: Vec2) -> Option<Ellipse> {
        let a = major.y * major.y + minor.y * minor.y + 1.0;
        let b = -2.0 * (major.x * major.y + minor.x * minor.y);
        let c = major.x * major.x + minor.x * minor.x + 1.0;
        let f = 1.0 / (a * c - 0.25 * b * b);
        let reach = Vec2::new(c.sqrt(), a.sqrt());
        let farthest = p.abs() + reach;
        let is_near = farthest.x < FARTHEST && farthest.y < FARTHEST;
        if !is_near {
            return None;
        }
        let (low, high) = (p - reach, p + reach);
        // From the first whole number not below `low`, which is −⌊−low⌋, to the last not above `high`.
        let [s, t, last @ ..] = floors(f32x4::new([-low.x, -low.y, high.x, high.y])).to_array();
        Some(Ellipse {
            form: [a * f, b * f, c * f],
            first: [-s, -t],
            last,
        })
    }
}

/// A row of a level's texels.
struct Row<'a, V> {
    /// Empty where the row is outside of an image that is black there.
    texels: &'a [V],
    wrap: Wrap,
}

impl<V: TextureValue> Row<'_, V> {
    #[inline(always)]
    fn texel(&self, s: i64) -> V {
        let index = wrap_power_of_two(s, self.texels.len(), self.wrap);
        let texel = index.and_then(|s| self.texels.get(s));
        texel.copied().unwrap_or_default()
    }
}

impl<V: TextureValue> Level<V> {
    fn size(&self) -> Vec2 {
        Vec2::new(self.width as f32, self.height as f32)
    }

    #[inline(always)]
    fn row(&self, t: i64, wrap: Wrap) -> Row<'_, V> {
        let texels = match wrap_power_of_two(t, self.height, wrap) {
            Some(t) => &self.texels[t * self.width..][..self.width],
            None => &[],
        };
        Row { texels, wrap }
    }

    #[inline]
    fn texel(&self, s: i64, t: i64, wrap: Wrap) -> V {
        self.row(t, wrap).texel(s)
    }

    /// The next coarser level, each texel the mean of the four (at a side of 1: two) it covers;
    /// `None` from the level of one texel.
    fn halved(&self) -> Option<Level<V>> {
        if self.width == 1 && self.height == 1 {
            return None;
        }
        let (width, height) = ((self.width / 2).max(1), (self.height / 2).max(1));
        let mut texels = Vec::with_capacity(width * height);
        for t in 0..height {
            let rows = [2 * t, (2 * t + 1).min(self.height - 1)].map(|t| t * self.width);
            texels.extend((0..width).map(|s| {
                let columns = [2 * s, (2 * s + 1).min(self.width - 1)];
                let at = |row: usize, column: usize| self.texels[rows[row] + columns[column]];
                (at(0, 0) + at(0, 1) + at(1, 0) + at(1, 1)) * 0.25
            }));
        }
        Some(Level {
            width,
            height,
            texels,
        })
    }

    /// Enlarged to powers of two by a Lanczos filter of two lobes, negative results set to 0
    /// (§10.4.3).
    fn enlarged(self, wrap: Wrap) -> Level<V> {
        let (width, height) = (
            self.width.next_power_of_two(),
            self.height.next_power_of_two(),
        );
        if width == self.width && height == self.height {
            return self;
        }
        let columns = enlarging_taps(self.width, width, wrap);
        let rows = enlarging_taps(self.height, height, wrap);
        let mut wide = Vec::with_capacity(width * self.height);
        for row in self.texels.chunks_exact(self.width) {
            wide.extend(columns.iter().map(|taps| taps.sum(|s| row[s])));
        }
        let mut texels = Vec::with_capacity(width * height);
        for taps in &rows {
            texels.extend(
                (0..width).map(|s| taps.sum(|t| wide[t * width + s]).map(|v: f32| v.max(0.0))),
            );
        }
        Level {
            width,
            height,
            texels,
        }
    }
}

/// The texels that make up one texel of an enlarged row, with their weights.
struct Taps([(Option<usize>, f32); 4]);

impl Taps {
    fn sum<V: TextureValue>(&self, texel: impl Fn(usize) -> V) -> V {
        let mut sum = V::default();
        for &(index, weight) in &self.0 {
            if let Some(index) = index {
                sum += texel(index) * weight;
            }
        }
        sum
    }
}

fn enlarging_taps(from: usize, to: usize, wrap: Wrap) -> Vec<Taps> {
    let radius = 2.0;
    (0..to)
        .map(|i| {
            let center = (i as f32 + 0.5) * from as f32 / to as f32;
            let first = (center - radius + 0.5).floor();
            let weights: [f32; 4] =
                std::array::from_fn(|j| lanczos((first + j as f32 + 0.5 - center) / radius));
            let sum: f32 = weights.iter().sum();
            Taps(std::array::from_fn(|j| {
                (
                    wrap_index(first as i64 + j as i64, from, wrap),
                    weights[j] / sum,
                )
            }))
        })
        .collect()
}

/// The Lanczos-windowed sinc of two lobes over −1…1 (§7.8.1 with τ = 2).
fn lanczos(x: f32) -> f32 {
    let x = x.abs();
    if x < 1e-5 {
        1.0
    } else if x > 1.0 {
        0.0
    } else {
        let (sinc, window) = (2.0 * PI * x, PI * x);
        sinc.sin() / sinc * (window.sin() / window)
    }
}

/// The position inside 0…n−1 that position `i` represents; `None` for black.
fn wrap_index(i: i64, n: usize, wrap: Wrap) -> Option<usize> {
    let last = n as i64 - 1;
    match wrap {
        Wrap::Repeat => Some(i.rem_euclid(n as i64) as usize),
        Wrap::Clamp => Some(i.clamp(0, last) as usize),
        Wrap::Black => (0..=last).contains(&i).then_some(i as usize),
    }
}

/// The same where `n` is a power of two: masking wraps negative positions, too.
#[inline(always)]
fn wrap_power_of_two(i: i64, n: usize, wrap: Wrap) -> Option<usize> {
    match wrap {
        Wrap::Repeat => Some(i as usize & (n - 1)),
        wrap => wrap_index(i, n, wrap),
    }
}

#[cfg(test)]
mod tests;
