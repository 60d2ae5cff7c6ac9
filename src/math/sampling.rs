//! Warping uniform samples to directions and points; each density is next to its sampler.

use super::float::floor;
use super::{Vec2, Vec3};
use std::f32::consts::{FRAC_1_PI, FRAC_PI_4, PI};

/// The largest single-precision number below 1.
pub const BELOW_ONE: f32 = 1.0 - f32::EPSILON / 2.0;

/// Maps the unit square to the unit disk, area-preserving and continuous (Shirley and Chiu 1997).
#[inline(always)]
pub fn concentric_disk(u: Vec2) -> Vec2 {
    let o = 2.0 * u - Vec2::ONE;
    // Which of the two is larger is unpredictable: selected by bits, without a branch.
    let across = if o.x.abs() > o.y.abs() { u32::MAX } else { 0 };
    let larger = select(across, o.x, o.y);
    let (sin, cos) = eighth_turn(select(across, o.y, o.x) / larger);
    let disk = larger * Vec2::new(select(across, cos, sin), select(across, sin, cos));
    // At the center there is no angle.
    if larger == 0.0 { Vec2::ZERO } else { disk }
}

/// `a` if `mask` is all ones, `b` if it is 0.
#[inline(always)]
fn select(mask: u32, a: f32, b: f32) -> f32 {
    f32::from_bits((a.to_bits() & mask) | (b.to_bits() & !mask))
}

/// Sine and cosine of t π/4, |t| ≤ 1, with an error below 1e-7: Taylor polynomials, whose first omitted terms are below
/// 2e-9 and 3e-8. Without function calls they take a fifth of the library's time; evaluated in pairs of terms (Estrin
/// 1960), which do not depend on each other.
#[inline(always)]
fn eighth_turn(t: f32) -> (f32, f32) {
    let x = FRAC_PI_4 * t;
    let x2 = x * x;
    let x4 = x2 * x2;
    let sin = (1.0 - x2 * (1.0 / 6.0))
        + x4 * ((1.0 / 120.0 - x2 * (1.0 / 5040.0)) + x4 * (1.0 / 362_880.0));
    let cos = (1.0 - x2 * 0.5) + x4 * ((1.0 / 24.0 - x2 * (1.0 / 720.0)) + x4 * (1.0 / 40_320.0));
    (x * sin, cos)
}

/// Sine and cosine of `turns` full turns, of which there may be a few, with an error at most 1e-7 above that of
/// rounding the angle.
pub fn sin_cos_turns(turns: f32) -> (f32, f32) {
    let (quarter, whole) = floor(4.0 * turns + 0.5);
    quarter_turns(quarter as i32, eighth_turn(2.0 * (4.0 * turns - whole)))
}

/// [`sin_cos_turns`] of at most one turn, in [0, 1], without a branch.
#[inline(always)]
pub fn sin_cos_turn(turn: f32) -> (f32, f32) {
    let quarter = (4.0 * turn + 0.5) as i32;
    quarter_turns(quarter, eighth_turn(2.0 * (4.0 * turn - quarter as f32)))
}

/// Sine and cosine of an angle and this many quarters of a turn, from those of the angle.
#[inline(always)]
fn quarter_turns(quarters: i32, (sin, cos): (f32, f32)) -> (f32, f32) {
    let (sin, cos) = if quarters & 1 == 0 {
        (sin, cos)
    } else {
        (cos, -sin)
    };
    if quarters & 2 == 0 {
        (sin, cos)
    } else {
        (-sin, -cos)
    }
}

/// Samples a direction about +z with density cosθ/π.
#[inline(always)]
pub fn cosine_hemisphere(u: Vec2) -> Vec3 {
    let d = concentric_disk(u);
    d.extend((1.0 - d.length_squared()).max(0.0).sqrt())
}

/// Density of [`cosine_hemisphere`].
#[inline(always)]
pub fn cosine_hemisphere_pdf(cos_theta: f32) -> f32 {
    cos_theta.max(0.0) * FRAC_1_PI
}

/// Samples a direction uniformly over the sphere.
pub fn uniform_sphere(u: Vec2) -> Vec3 {
    let z = 1.0 - 2.0 * u.x;
    let r = (1.0 - z * z).max(0.0).sqrt();
    let phi = 2.0 * PI * u.y;
    Vec3::new(r * phi.cos(), r * phi.sin(), z)
}

/// Density of [`uniform_sphere`].
pub const UNIFORM_SPHERE_PDF: f32 = 0.25 * FRAC_1_PI;

/// Samples barycentric coordinates (b0, b1) uniformly over a triangle.
pub fn uniform_triangle(u: Vec2) -> Vec2 {
    let su = u.x.sqrt();
    Vec2::new(1.0 - su, u.y * su)
}

/// Veach's power heuristic for multiple importance sampling (MIS), with exponent 2 and one sample of each of two
/// densities; 0 if both are 0, and correct even if the square of a density overflows.
#[inline(always)]
pub fn power_heuristic(f: f32, g: f32) -> f32 {
    if f == 0.0 {
        return 0.0;
    }
    let r = g / f;
    1.0 / (1.0 + r * r)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turns_have_the_sines_of_their_angles() {
        for i in -4000..=4000 {
            let turns = i as f32 / 2000.0;
            let (sin, cos) = (std::f64::consts::TAU * f64::from(turns)).sin_cos();
            let (s, c) = sin_cos_turns(turns);
            assert!((f64::from(s) - sin).abs() < 2e-7 && (f64::from(c) - cos).abs() < 2e-7);
            if (0.0..=1.0).contains(&turns) {
                assert_eq!(sin_cos_turn(turns), (s, c));
            }
        }
        // Relative precision near the poles of an image.
        assert!((sin_cos_turns(1e-9).0 / 6.283_185_5e-9 - 1.0).abs() < 1e-6);
    }

    #[test]
    fn eighths_of_turns_are_those_of_the_library() {
        for i in -1000..=1000 {
            let t = i as f32 / 1000.0;
            let (sin, cos) = eighth_turn(t);
            let (s, c) = (f64::from(t) * std::f64::consts::FRAC_PI_4).sin_cos();
            // One or two roundings.
            assert!((f64::from(sin) - s).abs() < 1.2e-7 && (f64::from(cos) - c).abs() < 1.2e-7);
        }
    }

    #[test]
    fn power_heuristic_sums_to_one() {
        for (a, b) in [(1.0, 2.0), (1e20, 1e25), (1e-20, 3.0), (0.0, 1.0)] {
            assert!((power_heuristic(a, b) + power_heuristic(b, a) - 1.0).abs() < 1e-6);
        }
        assert_eq!(power_heuristic(f32::INFINITY, 1.0), 1.0);
    }

    #[test]
    fn concentric_disk_fills_the_disk_evenly() {
        // Mean squared radius of a uniform unit disk is 1/2.
        let n = 256;
        let mut sum = 0.0f64;
        for i in 0..n {
            for j in 0..n {
                let p = concentric_disk(Vec2::new(
                    (i as f32 + 0.5) / n as f32,
                    (j as f32 + 0.5) / n as f32,
                ));
                assert!(p.length() <= 1.0 + 1e-6);
                sum += p.length_squared() as f64;
            }
        }
        assert!((sum / (n * n) as f64 - 0.5).abs() < 1e-4);
    }
}
