//! Linear RGB (sRGB primaries), XYZ and luminance, with pbrt-v3's rounded matrices (docs/scene-language.md §4.7).

use super::Rgb;

/// Relative luminance of linear RGB.
#[inline(always)]
pub fn luminance(rgb: Rgb) -> f32 {
    0.212_671 * rgb.x + 0.715_16 * rgb.y + 0.072_169 * rgb.z
}

/// Converts CIE XYZ to linear RGB.
pub fn rgb_from_xyz(xyz: Rgb) -> Rgb {
    Rgb::new(
        3.240_479 * xyz.x - 1.537_15 * xyz.y - 0.498_535 * xyz.z,
        -0.969_256 * xyz.x + 1.875_991 * xyz.y + 0.041_556 * xyz.z,
        0.055_648 * xyz.x - 0.204_043 * xyz.y + 1.057_311 * xyz.z,
    )
}

/// The exact sRGB decoding curve: encoded value in 0…1 to linear.
pub fn linear_from_srgb(encoded: f32) -> f32 {
    if encoded <= 0.040_45 {
        encoded / 12.92
    } else {
        ((encoded + 0.055) / 1.055).powf(2.4)
    }
}

/// The sRGB encoding curve: linear value to encoded, not clamped.
pub fn srgb_from_linear(linear: f32) -> f32 {
    if linear <= 0.003_130_8 {
        12.92 * linear
    } else {
        1.055 * linear.powf(1.0 / 2.4) - 0.055
    }
}

/// Returns `true` if every channel is zero.
#[inline(always)]
pub fn is_black(rgb: Rgb) -> bool {
    (rgb.x == 0.0) & (rgb.y == 0.0) & (rgb.z == 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn srgb_curves_are_inverse() {
        for i in 0..=1000 {
            let v = i as f32 / 1000.0;
            // Two powers in single precision: a few units in the last place of a value up to 1.
            assert!((srgb_from_linear(linear_from_srgb(v)) - v).abs() < 2e-6);
        }
    }

    #[test]
    fn white_has_unit_luminance() {
        assert!((luminance(Rgb::ONE) - 1.0).abs() < 1e-6);
    }
}
