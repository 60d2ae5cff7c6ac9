//! BRDFs tabulated over half and difference angles (Rusinkiewicz 1998).

use crate::assets::merl_file::MerlFile;
use crate::math::{Rgb, Vec2, Vec3};
use std::f32::consts::{FRAC_1_PI, FRAC_PI_2};

/// Angles in radians: between half vector and normal, and, in the frame of the half vector, of the light's direction to
/// it, and around it from the plane that contains the normal.
struct Angles {
    theta_h: f32,
    theta_d: f32,
    /// From 0 to π: by reciprocity, swapping the directions adds π and leaves the value unchanged.
    phi_d: f32,
}

/// The nearest entry of a table with equal steps in √θh, θd and φd, in 1/sr, as in pbrt-v2: between the last measured
/// entries and the black ones of directions below the surface there is nothing to interpolate. The same below the
/// surface as above.
pub(super) fn nearest(table: &MerlFile, wo: Vec3, wi: Vec3) -> Rgb {
    let Some(angles) = Angles::new(wo, wi) else {
        return Rgb::ZERO;
    };
    let [count_h, count_d, count_phi] = table.counts;
    let h = bin((angles.theta_h / FRAC_PI_2).sqrt(), count_h);
    let d = bin(angles.theta_d / FRAC_PI_2, count_d);
    let phi = bin(angles.phi_d * FRAC_1_PI, count_phi);
    let entry = phi + count_phi * (d + count_d * h);
    table.values.get(entry).copied().unwrap_or(Rgb::ZERO)
}

/// The bin, of `count`, for a fraction of the range.
pub(super) fn bin(fraction: f32, count: usize) -> usize {
    ((fraction * count as f32) as usize).min(count - 1)
}

/// Angle between the normal, or its opposite, and `h`, of any length. The arccosine that pbrt-v2 uses cannot tell the
/// first angles of MERL tables apart in single precision.
pub(super) fn half_angle(h: Vec3) -> f32 {
    h.truncate().length().atan2(h.z.abs())
}

impl Angles {
    /// `None` for opposite directions. Swapping the directions does not change a bit.
    fn new(wo: Vec3, wi: Vec3) -> Option<Angles> {
        let (sum, difference) = (wo + wi, wi - wo);
        let length = sum.length();
        if length.is_nan() || length <= 0.0 {
            return None;
        }
        // Below the surface everything is flipped; the difference would be too, but φd does not depend on its sign.
        let h = if sum.z < 0.0 { -sum } else { sum } / length;
        let around = h.truncate().try_normalize().unwrap_or(Vec2::X);
        let sine = h.truncate().length();
        let along = (around * h.z).extend(-sine);
        let (x, y) = (
            difference.dot(along),
            around.perp_dot(difference.truncate()),
        );
        let (x, y) = if y < 0.0 || (y == 0.0 && x < 0.0) {
            (-x, -y)
        } else {
            (x, y)
        };
        Some(Angles {
            theta_h: half_angle(h),
            // The two are the legs of half a rhombus.
            theta_d: difference.length().atan2(length),
            phi_d: y.atan2(x),
        })
    }
}
