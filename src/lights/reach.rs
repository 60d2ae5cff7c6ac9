//! How strongly a light arrives where, roughly: enough to choose lights well.

use crate::math::color::luminance;
use crate::math::{Rgb, Vec3};

/// A model of the irradiance, as a luminance, that one light or several bring to a point if
/// nothing is in the way: `everywhere` + intensity × (share by direction) / distance², the
/// distance never counting as less than `radius`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Reach {
    pub(super) center: Vec3,
    pub(super) radius: f32,
    /// Largest intensity over all directions.
    pub(super) intensity: f32,
    /// Unit direction of that intensity.
    pub(super) axis: Vec3,
    /// The share of the intensity is `slope` × cos(angle from the axis) + `base`, within 0…1.
    pub(super) slope: f32,
    pub(super) base: f32,
    /// What does not depend on the place.
    pub(super) everywhere: f32,
}

impl Reach {
    /// Of a light that reaches nothing.
    pub(super) fn nowhere() -> Reach {
        let (center, axis) = (Vec3::ZERO, Vec3::Z);
        Reach {
            center,
            radius: 0.0,
            intensity: 0.0,
            axis,
            slope: 0.0,
            base: 1.0,
            everywhere: 0.0,
        }
    }

    /// Of a point with the same intensity in all directions.
    pub(super) fn point(center: Vec3, intensity: Rgb) -> Reach {
        Reach::area(center, 0.0, intensity)
    }

    /// Of something within `radius` of `center`.
    pub(super) fn area(center: Vec3, radius: f32, intensity: Rgb) -> Reach {
        Reach {
            center,
            radius,
            intensity: magnitude(intensity),
            ..Reach::nowhere()
        }
    }

    /// Of a light that brings the same irradiance to every place.
    pub(super) fn everywhere(irradiance: Rgb) -> Reach {
        Reach {
            everywhere: magnitude(irradiance),
            ..Reach::nowhere()
        }
    }

    /// A flat emitter: only on the side of the unit normal `n`, falling with the cosine.
    pub(super) fn on_side(self, n: Vec3) -> Reach {
        Reach {
            axis: n,
            slope: 1.0,
            base: 0.0,
            ..self
        }
    }

    /// Nothing where the cosine to the unit `axis` is below `dark`, all of it from `full` on.
    pub(super) fn within_cone(self, axis: Vec3, dark: f32, full: f32) -> Reach {
        // Sharp edges become a ramp of a thousandth.
        let slope = 1.0 / (full - dark).max(1e-3);
        Reach {
            axis,
            slope,
            base: -dark * slope,
            ..self
        }
    }

    /// Is this light somewhere?
    pub(super) fn is_local(&self) -> bool {
        self.everywhere == 0.0
    }

    /// One model for all of `parts`, of which there is at least one.
    pub(super) fn merged(parts: &[Reach]) -> Reach {
        let Some((first, rest)) = parts.split_first() else {
            return Reach::nowhere();
        };
        if rest.is_empty() {
            return *first;
        }
        let intensity: f32 = parts.iter().map(|r| r.intensity).sum();
        let center = if intensity > 0.0 {
            parts
                .iter()
                .map(|r| r.center * (r.intensity / intensity))
                .sum()
        } else {
            parts.iter().map(|r| r.center).sum::<Vec3>() / parts.len() as f32
        };
        let radius = parts
            .iter()
            .map(|r| r.center.distance(center) + r.radius)
            .fold(0.0, f32::max);
        let everywhere = parts.iter().map(|r| r.everywhere).sum();
        let merged = Reach {
            center,
            radius,
            intensity,
            everywhere,
            ..Reach::nowhere()
        };
        // Faces that look the same way keep their dark side (a thousandth: 2.6 degrees).
        let aligned = |r: &Reach| {
            r.slope == first.slope && r.base == first.base && r.axis.dot(first.axis) > 0.999
        };
        if rest.iter().all(aligned) {
            Reach {
                axis: first.axis,
                slope: first.slope,
                base: first.base,
                ..merged
            }
        } else {
            merged
        }
    }
}

/// How bright a colour is, channels of either sign; 0 where it is not finite.
pub(super) fn magnitude(rgb: Rgb) -> f32 {
    let y = luminance(rgb.abs());
    if y.is_finite() { y } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faces_of_one_plane_keep_their_dark_side_together() {
        let face = |x: f32| Reach::area(Vec3::X * x, 0.5, Rgb::ONE).on_side(Vec3::Y);
        let merged = Reach::merged(&[face(-1.0), face(1.0)]);
        assert_eq!(
            (merged.axis, merged.slope, merged.base),
            (Vec3::Y, 1.0, 0.0)
        );
        assert_eq!((merged.center, merged.radius), (Vec3::ZERO, 1.5));
        assert!((merged.intensity - 2.0).abs() < 1e-6);
        let turned = Reach::area(Vec3::ZERO, 0.5, Rgb::ONE).on_side(Vec3::Z);
        assert_eq!(Reach::merged(&[face(0.0), turned]).slope, 0.0);
    }
}
