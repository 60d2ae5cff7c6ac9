//! How strongly a light arrives where, roughly: enough to choose lights well.

use crate::math::color::luminance;
use crate::math::{Rgb, Vec3};
use std::f32::consts::{FRAC_PI_2, PI};

/// A model of the irradiance, as a luminance, that one light or several bring to a point if
/// nothing is in the way: `everywhere` + intensity × (share by direction) / distance². It bounds
/// where the lights are and where they shine, as in Conty Estevez and Kulla, "Importance Sampling
/// of Many Lights with Adaptive Tree Splitting" (2018).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LightBounds {
    /// Corner of the box that holds the lights, with the least coordinates.
    pub(super) low: Vec3,
    /// The opposite corner.
    pub(super) high: Vec3,
    /// Sum of the lights' largest intensities over all directions.
    pub(super) intensity: f32,
    /// Unit axis of the directions of those intensities.
    pub(super) axis: Vec3,
    /// Largest angle between that axis and one of the directions; π: all directions.
    pub(super) spread: f32,
    /// Angle from those directions beyond which nothing shines; before, the cosine is a bound.
    pub(super) falloff: f32,
    /// What does not depend on the place.
    pub(super) everywhere: f32,
}

impl LightBounds {
    /// Of a light that reaches nothing.
    pub(super) fn nowhere() -> LightBounds {
        LightBounds {
            low: Vec3::ZERO,
            high: Vec3::ZERO,
            intensity: 0.0,
            axis: Vec3::Z,
            spread: PI,
            falloff: FRAC_PI_2,
            everywhere: 0.0,
        }
    }

    /// Of a point with the same intensity in all directions.
    pub(super) fn point(center: Vec3, intensity: Rgb) -> LightBounds {
        LightBounds::area(center, center, intensity)
    }

    /// Of something in the box between two corners.
    pub(super) fn area(low: Vec3, high: Vec3, intensity: Rgb) -> LightBounds {
        if !low.is_finite() || !high.is_finite() {
            return LightBounds::nowhere();
        }
        LightBounds {
            low,
            high,
            intensity: magnitude(intensity),
            ..LightBounds::nowhere()
        }
    }

    /// Of a light that brings the same irradiance to every place.
    pub(super) fn everywhere(irradiance: Rgb) -> LightBounds {
        LightBounds {
            everywhere: magnitude(irradiance),
            ..LightBounds::nowhere()
        }
    }

    /// A flat emitter: only on the side of the unit normal `n`, falling with the cosine.
    pub(super) fn on_side(self, n: Vec3) -> LightBounds {
        LightBounds {
            axis: n,
            spread: 0.0,
            falloff: FRAC_PI_2,
            ..self
        }
    }

    /// Nothing where the cosine to the unit `axis` is below `dark`, all of it from `full` on.
    pub(super) fn within_cone(self, axis: Vec3, dark: f32, full: f32) -> LightBounds {
        /// A sharp edge is softened by so many radians: rounding may not make it dark.
        const SHARPEST: f32 = 1e-3;
        let spread = full.clamp(-1.0, 1.0).acos();
        LightBounds {
            axis,
            spread,
            falloff: (dark.clamp(-1.0, 1.0).acos() - spread).max(SHARPEST),
            ..self
        }
    }

    /// Returns `true` if this light is somewhere.
    pub(super) fn is_local(&self) -> bool {
        self.everywhere == 0.0
    }

    /// Middle of the box.
    pub(super) fn center(&self) -> Vec3 {
        0.5 * self.low + 0.5 * self.high
    }

    /// Diagonal of the box, squared.
    pub(super) fn diagonal2(&self) -> f32 {
        self.high.distance_squared(self.low)
    }

    /// One model for both.
    pub(super) fn merged(&self, other: &LightBounds) -> LightBounds {
        // What is dark or placeless bounds nothing.
        if other.intensity == 0.0 || self.intensity == 0.0 {
            let kept = if other.intensity == 0.0 { self } else { other };
            return LightBounds {
                everywhere: self.everywhere + other.everywhere,
                ..*kept
            };
        }
        let (axis, spread) = merged_cones(self, other);
        LightBounds {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
            intensity: self.intensity + other.intensity,
            axis,
            spread,
            falloff: self.falloff.max(other.falloff),
            everywhere: self.everywhere + other.everywhere,
        }
    }

    /// How badly one estimate for all of it may go wrong: its intensity times the measure of the
    /// directions it may shine in times the squared diagonal (the paper's cost, with the diagonal in
    /// place of the surface, because a box around lights on a line has none).
    pub(super) fn vagueness(&self) -> f32 {
        self.intensity * directions(self.spread, self.falloff) * self.diagonal2()
    }
}

/// The measure of directions within `spread` of an axis, and, weighted by the cosine, within
/// `falloff` of those (the same paper's orientation measure).
fn directions(spread: f32, falloff: f32) -> f32 {
    let end = (spread + falloff).min(PI);
    let (sin, cos) = spread.sin_cos();
    let fall = 2.0 * end * sin - (spread - 2.0 * end).cos() - 2.0 * spread * sin + cos;
    2.0 * PI * (1.0 - cos) + FRAC_PI_2 * fall
}

/// Axis and half angle of the narrowest cone around two (the same paper's union of cones).
fn merged_cones(a: &LightBounds, b: &LightBounds) -> (Vec3, f32) {
    let (wide, narrow) = if a.spread >= b.spread { (a, b) } else { (b, a) };
    if wide.spread >= PI {
        return (wide.axis, PI);
    }
    let angle = wide
        .axis
        .cross(narrow.axis)
        .length()
        .atan2(wide.axis.dot(narrow.axis));
    if (angle + narrow.spread).min(PI) <= wide.spread {
        return (wide.axis, wide.spread);
    }
    let spread = 0.5 * (wide.spread + angle + narrow.spread);
    let across = (narrow.axis - wide.axis * wide.axis.dot(narrow.axis)).try_normalize();
    match across {
        Some(across) if spread < PI => {
            let (sin, cos) = (spread - wide.spread).sin_cos();
            ((wide.axis * cos + across * sin).normalize(), spread)
        }
        _ => (wide.axis, PI),
    }
}

/// How bright a color is, channels of either sign; 0 where it is not finite.
pub(super) fn magnitude(rgb: Rgb) -> f32 {
    let y = luminance(rgb.abs());
    if y.is_finite() { y } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn face(x: f32, n: Vec3) -> LightBounds {
        let half = Vec3::new(0.5, 0.0, 0.5);
        LightBounds::area(Vec3::X * x - half, Vec3::X * x + half, Rgb::ONE).on_side(n.normalize())
    }

    #[test]
    fn faces_of_one_plane_keep_their_dark_side_together() {
        let merged = face(-1.0, Vec3::Y).merged(&face(1.0, Vec3::Y));
        assert_eq!((merged.axis, merged.spread), (Vec3::Y, 0.0));
        assert_eq!(
            (merged.low, merged.high),
            (Vec3::new(-1.5, 0.0, -0.5), Vec3::new(1.5, 0.0, 0.5))
        );
        assert!((merged.intensity - 2.0).abs() < 1e-6);
    }

    #[test]
    fn merged_cones_hold_both() {
        let directions = [Vec3::X, Vec3::Y, Vec3::new(1.0, 2.0, -3.0), Vec3::NEG_X];
        for a in directions {
            for b in directions {
                for c in directions {
                    let all = face(0.0, a).merged(&face(0.0, b)).merged(&face(0.0, c));
                    for d in [a, b, c] {
                        let angle = all.axis.dot(d.normalize()).clamp(-1.0, 1.0).acos();
                        // Single-precision angles.
                        assert!(angle <= all.spread + 1e-3, "{a} {b} {c}");
                    }
                }
            }
        }
        let opposite = face(0.0, Vec3::X).merged(&face(0.0, Vec3::NEG_X));
        assert_eq!(opposite.spread, PI);
        // Side by side: half of the right angle between them.
        let corner = face(0.0, Vec3::X).merged(&face(0.0, Vec3::Y));
        assert!((corner.spread - PI / 4.0).abs() < 1e-6);
        assert!((corner.axis - Vec3::new(1.0, 1.0, 0.0).normalize()).length() < 1e-6);
    }

    #[test]
    fn the_measure_of_directions_is_that_of_spheres_and_hemispheres() {
        assert!((directions(PI, FRAC_PI_2) - 4.0 * PI).abs() < 1e-5);
        // A flat face: the cosine over a hemisphere.
        assert!((directions(0.0, FRAC_PI_2) - PI).abs() < 1e-5);
    }

    #[test]
    fn the_dark_changes_nothing() {
        let dark = LightBounds::area(Vec3::splat(9.0), Vec3::splat(10.0), Rgb::ZERO);
        let light = face(1.0, Vec3::Y);
        assert_eq!(light.merged(&dark), light);
        assert_eq!(dark.merged(&light), light);
        let sky = LightBounds::everywhere(Rgb::ONE);
        assert_eq!(light.merged(&sky).everywhere, sky.everywhere);
    }
}
