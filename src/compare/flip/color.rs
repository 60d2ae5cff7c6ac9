//! The color spaces of FLIP.

use crate::math::Rgb;
use glam::Mat3;
use libm::cbrtf;

/// Linear RGB to XYZ: Rec. 709 primaries, white (0.3127, 0.3290), as columns.
const XYZ_FROM_RGB: Mat3 = Mat3::from_cols_array(&[
    0.412_386_56,
    0.212_636_82,
    0.019_330_62,
    0.357_591_5,
    0.715_183,
    0.119_197_16,
    0.180_450_5,
    0.072_180_2,
    0.950_372_6,
]);

/// Conversions relative to the white of RGB (1, 1, 1).
#[derive(Clone, Copy, Debug)]
pub(super) struct ColorSpaces {
    rgb_from_xyz: Mat3,
    white: Rgb,
}

impl ColorSpaces {
    pub(super) fn new() -> ColorSpaces {
        ColorSpaces {
            rgb_from_xyz: XYZ_FROM_RGB.inverse(),
            white: XYZ_FROM_RGB * Rgb::ONE,
        }
    }

    /// Linear RGB to YCxCz, the linear opponent space in which the eye's blur is applied: 116 Y − 16, 500 (X − Y), 200
    /// (Y − Z), relative to white (Andersson et al. 2020, §4.1.1).
    pub(super) fn ycxcz_from_rgb(&self, rgb: Rgb) -> Rgb {
        let xyz = XYZ_FROM_RGB * rgb / self.white;
        Rgb::new(
            116.0 * xyz.y - 16.0,
            500.0 * (xyz.x - xyz.y),
            200.0 * (xyz.y - xyz.z),
        )
    }

    /// The inverse.
    pub(super) fn rgb_from_ycxcz(&self, ycxcz: Rgb) -> Rgb {
        let y = (ycxcz.x + 16.0) / 116.0;
        let xyz = Rgb::new(y + ycxcz.y / 500.0, y, y - ycxcz.z / 200.0);
        self.rgb_from_xyz * (xyz * self.white)
    }

    /// Linear RGB to CIE L*a*b*, with chroma scaled by lightness (0.01 L a, 0.01 L b) for the Hunt effect: darker
    /// colors look less saturated (§4.1.2).
    pub(super) fn hunt_lab_from_rgb(&self, rgb: Rgb) -> Rgb {
        let f = (XYZ_FROM_RGB * rgb / self.white).map(lab_curve);
        let lightness = 116.0 * f.y - 16.0;
        let hunt = 0.01 * lightness;
        Rgb::new(
            lightness,
            hunt * 500.0 * (f.x - f.y),
            hunt * 200.0 * (f.y - f.z),
        )
    }
}

/// CIE 15: the cube root, with a linear segment below (6/29)³.
fn lab_curve(t: f32) -> f32 {
    const DELTA: f32 = 6.0 / 29.0;
    if t > DELTA * DELTA * DELTA {
        cbrtf(t)
    } else {
        t / (3.0 * DELTA * DELTA) + 4.0 / 29.0
    }
}

/// HyAB, a distance between colors in L*a*b* that also holds for large differences: |ΔL| + √(Δa² + Δb²) (Abasi, Amani
/// Tehran and Fairchild 2020).
pub(super) fn hyab(p: Rgb, q: Rgb) -> f32 {
    let d = p - q;
    d.x.abs() + (d.y * d.y + d.z * d.z).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_and_black() {
        let spaces = ColorSpaces::new();
        // Single precision of values up to 116 and 500.
        let close = |a: Rgb, b: Rgb| (a - b).abs().max_element() < 1e-3;
        assert!(close(
            spaces.ycxcz_from_rgb(Rgb::ONE),
            Rgb::new(100.0, 0.0, 0.0)
        ));
        assert!(close(
            spaces.ycxcz_from_rgb(Rgb::ZERO),
            Rgb::new(-16.0, 0.0, 0.0)
        ));
        assert!(close(
            spaces.hunt_lab_from_rgb(Rgb::ONE),
            Rgb::new(100.0, 0.0, 0.0)
        ));
        assert!(close(spaces.hunt_lab_from_rgb(Rgb::ZERO), Rgb::ZERO));
        // 18 % gray has L* = 116 · 0.18^(1/3) − 16 = 49.496.
        let gray = spaces.hunt_lab_from_rgb(Rgb::splat(0.18));
        assert!(close(gray, Rgb::new(49.496, 0.0, 0.0)));
    }

    #[test]
    fn there_and_back() {
        let spaces = ColorSpaces::new();
        for rgb in [Rgb::X, Rgb::Y, Rgb::Z, Rgb::new(0.3, 0.7, 0.1)] {
            let back = spaces.rgb_from_ycxcz(spaces.ycxcz_from_rgb(rgb));
            assert!((back - rgb).abs().max_element() < 1e-5, "{rgb} {back}");
        }
    }

    /// Lindbloom's values of sRGB red: L* 53.24, a* 80.09, b* 67.20.
    #[test]
    fn red_in_lab() {
        let lab = ColorSpaces::new().hunt_lab_from_rgb(Rgb::X);
        let hunt = 0.01 * lab.x;
        // His white differs in the fourth digit.
        assert!((lab.x - 53.24).abs() < 0.05);
        assert!((lab.y / hunt - 80.09).abs() < 0.1);
        assert!((lab.z / hunt - 67.20).abs() < 0.1);
    }
}
