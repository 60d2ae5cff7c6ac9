//! `marble`.

use super::TextureValue;
use super::noise::Octaves;
use super::solid::{Pattern, SolidPoint};
use crate::math::Rgb;
use crate::math::float::clamp_nan_low;
use crate::params::ParamReader;

/// Colors of the stone, control points of a spline whose segment i has the points i … i + 3.
const COLORS: [Rgb; 9] = [
    PALE,
    PALE,
    PALE,
    Rgb::new(0.5, 0.5, 0.5),
    Rgb::new(0.6, 0.59, 0.58),
    PALE,
    PALE,
    Rgb::new(0.2, 0.2, 0.33),
    PALE,
];

const PALE: Rgb = Rgb::new(0.58, 0.58, 0.6);

const SEGMENTS: usize = COLORS.len() - 3;

/// Brightens the spline's colors.
const GAIN: f32 = 1.5;

/// Veined stone: layers along y of the texture's space, displaced by noise, colored by a spline.
/// Spectrum only. Parameters: integer `octaves` (8, at most 128), float `roughness` (0.5), float
/// `scale` (1) of the pattern's frequency, float `variation` (0.2) of the displacement (Pharr, Jakob
/// and Humphreys 2016, §10.6.6).
///
/// pbrt-v3 runs past the end of the spline's second segment, to far brighter colors than the stone's, by
/// a slip of one number; the six segments of the book (and of pbrt-v2) are used here.
#[derive(Clone, Copy, Debug)]
pub struct Marble {
    octaves: Octaves,
    scale: f32,
    variation: f32,
}

impl Pattern for Marble {
    const COLORS_ONLY: bool = true;

    fn from_params(reader: &ParamReader) -> Marble {
        Marble {
            octaves: Octaves::from_params(reader),
            scale: reader.float("scale", 1.0) as f32,
            variation: reader.float("variation", 0.2) as f32,
        }
    }

    fn value<V: TextureValue>(&self, at: &SolidPoint) -> V {
        let at = at.scaled(self.scale);
        let layer = at.p.y + self.variation * self.octaves.fbm(&at);
        V::from_texel(color(0.5 + 0.5 * layer.sin()))
    }
}

/// The spline's color at `t` in 0…1; that at 0 where `t` is no number.
fn color(t: f32) -> Rgb {
    let t = clamp_nan_low(t, 0.0, 1.0) * SEGMENTS as f32;
    let first = (t as usize).min(SEGMENTS - 1);
    let t = t - first as f32;
    // de Casteljau's algorithm on the segment's four points.
    let mut points: [Rgb; 4] = std::array::from_fn(|i| COLORS[first + i]);
    for left in (1..4).rev() {
        for i in 0..left {
            points[i] = points[i].lerp(points[i + 1], t);
        }
    }
    GAIN * points[0]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colors_stay_within_those_of_the_spline() {
        let low = COLORS.into_iter().fold(Rgb::INFINITY, Rgb::min) * GAIN;
        let high = COLORS.into_iter().fold(Rgb::NEG_INFINITY, Rgb::max) * GAIN;
        for i in 0..=1000 {
            let c = color(i as f32 / 1000.0);
            // A Bézier curve lies within its points' hull; 1e-6 for rounding.
            assert!((c + 1e-6).cmpge(low).all() && (c - 1e-6).cmple(high).all());
        }
    }

    #[test]
    fn the_dark_vein_is_reached() {
        // Points 4 to 7 at 0.9 of segment 4: weights 0.001, 0.027, 0.243 and 0.729.
        let t = 4.9 / 6.0;
        let blue = 1.5 * (0.001 * 0.58 + (0.027 + 0.243) * 0.6 + 0.729 * 0.33);
        assert!((color(t).z - blue).abs() < 1e-5);
        assert_eq!(color(0.0), GAIN * PALE);
        // The last segment ends on the last point.
        assert!((color(1.0) - GAIN * PALE).length() < 1e-6);
        assert_eq!(color(f32::NAN), color(0.0));
    }
}
