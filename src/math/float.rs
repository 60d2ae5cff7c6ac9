//! Rounding-error bounds and neighboring floats.

use super::Vec3;
use wide::{f32x4, i32x4};

/// Half the spacing of `f32` at 1: the largest relative error of one rounded operation.
pub const UNIT_ROUNDOFF: f32 = f32::EPSILON * 0.5;

/// `x` moved into `low`…`high`; what is no number counts as `low`, where `clamp` would keep it.
pub fn clamp_nan_low(x: f32, low: f32, high: f32) -> f32 {
    x.max(low).min(high)
}

/// Offsets the origin of a spawned ray from a computed point off the surface, to the side of direction `w`, just beyond
/// the box of half-widths `error` that is known to contain the exact point (Pharr, Jakob and Humphreys 2016, §3.9.5).
#[inline(always)]
pub fn offset_ray_origin(p: Vec3, error: Vec3, n: Vec3, w: Vec3) -> Vec3 {
    let distance = n.abs().dot(error);
    let offset = if w.dot(n) < 0.0 {
        -distance * n
    } else {
        distance * n
    };
    let moved = p + offset;
    Vec3::new(
        round_away(moved.x, offset.x),
        round_away(moved.y, offset.y),
        round_away(moved.z, offset.z),
    )
}

/// `v` moved by one or two floats in the direction of `offset`'s sign; `v` itself if the offset is zero. |v| ε is one
/// to two spacings of the floats at `v`; unlike `next_up` this has no branch.
#[inline(always)]
fn round_away(v: f32, offset: f32) -> f32 {
    let step = (v.abs() * f32::EPSILON + f32::MIN_POSITIVE).copysign(offset);
    if offset == 0.0 { v } else { v + step }
}

/// Returns `true` if `x` is above 0 and finite. Written like this it takes two comparisons; of `x > 0.0 && x.is_finite()` the compiler
/// makes twenty instructions with integers.
#[inline(always)]
pub fn is_positive(x: f32) -> bool {
    x > 0.0 && x < f32::INFINITY
}

/// The largest integer not above `x`, as an integer and as a float. `f32::floor` is a function call on processors
/// without SSE4.1, which a portable build must support; values beyond the integer range saturate.
#[inline]
pub fn floor(x: f32) -> (i64, f32) {
    let whole = x as i64;
    let value = whole as f32;
    if value > x {
        (whole.saturating_sub(1), value - 1.0)
    } else {
        (whole, value)
    }
}

/// The largest integers not above these, which are less than 2³¹ in magnitude.
#[inline(always)]
pub fn floors(x: f32x4) -> i32x4 {
    let whole = x.fast_trunc_int();
    // −1 where truncation went up, to 0 from below.
    let above = f32x4::from_i32x4(whole).simd_gt(x);
    whole + bytemuck::cast::<f32x4, i32x4>(above)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The bound γₙ = nε / (1 − nε) on the relative error of n chained operations
    /// (Higham 2002, §3.1; Pharr, Jakob and Humphreys 2016, §3.9.1).
    const fn gamma(n: u32) -> f32 {
        let ne = n as f32 * UNIT_ROUNDOFF;
        ne / (1.0 - ne)
    }

    #[test]
    fn what_is_no_number_is_within_the_range_too() {
        for (x, moved) in [
            (f32::NAN, 1.0),
            (f32::INFINITY, 2.0),
            (-3.0, 1.0),
            (1.5, 1.5),
        ] {
            assert_eq!(clamp_nan_low(x, 1.0, 2.0), moved);
        }
    }

    #[test]
    fn positive_numbers_are_finite() {
        for x in [0.0, -0.0, -1.0, f32::INFINITY, f32::NAN, f32::NEG_INFINITY] {
            assert!(!is_positive(x), "{x}");
        }
        for x in [f32::from_bits(1), f32::MIN_POSITIVE, 1.0, f32::MAX] {
            assert!(is_positive(x), "{x}");
        }
    }

    #[test]
    fn floors_are_those_of_the_library() {
        for x in [
            0.0,
            0.7,
            1.0,
            -0.0,
            -0.3,
            -1.0,
            -1.5,
            8_388_607.5,
            -8_388_607.5,
            3e9,
            -3e9,
        ] {
            let (whole, value) = floor(x);
            assert_eq!((whole as f32, value), (x.floor(), x.floor()), "{x}");
            if x.abs() < 2f32.powi(31) {
                assert_eq!(floors(f32x4::splat(x)).to_array(), [whole as i32; 4], "{x}");
            }
        }
        assert_eq!(floor(f32::NAN).0, 0);
        assert_eq!(floor(f32::NEG_INFINITY).0, i64::MIN);
    }

    #[test]
    fn offset_origin_clears_the_error_box_at_every_scale() {
        for scale in [1e-6f32, 1.0, 1e6] {
            let p = Vec3::new(0.3, -0.7, 0.9) * scale;
            let error = p.abs() * gamma(7);
            let n = Vec3::new(0.48, 0.6, 0.64);
            for side in [1.0f32, -1.0] {
                let o = offset_ray_origin(p, error, n, side * n);
                // Every corner of the box lies on or behind the plane through `o`.
                let d = f64::from(side) * (o.as_dvec3() - p.as_dvec3()).dot(n.as_dvec3());
                assert!(d >= f64::from(n.abs().dot(error)) * 0.999_999);
            }
        }
    }
}
