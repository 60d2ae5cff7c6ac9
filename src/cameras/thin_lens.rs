//! Depth of field without a lens design: the thin lens.

use crate::math::sampling::concentric_disk;
use crate::math::{DVec2, Vec2};
use crate::params::ParamReader;

/// `lensradius` 0 and `focaldistance` 1e6 (1e30 for pbrt-v2 files), in camera units, of
/// `perspective` and `orthographic` (docs/scene-language.md §3.1). The lens lies in z = 0.
/// Source: Pharr, Jakob and Humphreys 2016, §6.2.3.
#[derive(Clone, Debug, PartialEq)]
pub struct ThinLens {
    /// Radius; 0 is a pinhole.
    pub radius: f64,
    /// Distance of the plane (not sphere) in focus; may be infinite.
    pub focal_distance: f64,
}

impl Default for ThinLens {
    fn default() -> ThinLens {
        ThinLens {
            radius: 0.0,
            focal_distance: 1e6,
        }
    }
}

impl ThinLens {
    /// Reads the parameters. A negative radius is that of a pinhole, as in pbrt-v3, with a warning;
    /// other numbers that mean nothing are errors.
    pub fn from_params(params: &ParamReader) -> ThinLens {
        let default = ThinLens::default();
        let focal_distance = params.float("focaldistance", default.focal_distance);
        let radius = params.float("lensradius", default.radius);
        let pinhole = ThinLens {
            radius: 0.0,
            focal_distance,
        };
        if radius == 0.0 {
            return pinhole;
        }
        if radius < 0.0 {
            params.warn(
                "lensradius",
                format!("lensradius is {radius}: a pinhole is used"),
            );
            return pinhole;
        }
        // Infinity is sharp, as for a photographer; what is not a number is not.
        let (name, x, fits) = match radius.is_finite() {
            true => ("focaldistance", focal_distance, focal_distance > 0.0),
            false => ("lensradius", radius, false),
        };
        if !fits {
            params.error(name, format!("{name} is {x}; expected a positive number"));
            return pinhole;
        }
        ThinLens { radius, ..pinhole }
    }

    /// The point of the lens for `u` in the unit square.
    pub fn point(&self, u: Vec2) -> DVec2 {
        if self.radius > 0.0 {
            self.radius * concentric_disk(u).as_dvec2()
        } else {
            DVec2::ZERO
        }
    }

    /// What to add to the z = 1 direction of the ray through the lens' middle so that it meets that
    /// ray in the plane of focus when it starts at `point` instead. Divided by the distance, so that
    /// 1e30 and infinity are no trouble. Nothing for a pinhole, whatever its distance.
    pub fn turn(&self, point: DVec2) -> DVec2 {
        if self.radius > 0.0 {
            -point / self.focal_distance
        } else {
            DVec2::ZERO
        }
    }

    /// In words.
    pub fn describe(&self) -> String {
        if self.radius > 0.0 {
            format!(
                "thin lens of radius {}, focused at {}",
                self.radius, self.focal_distance
            )
        } else {
            "pinhole".to_string()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::params::testing::read;

    fn lens(radius: f64, focal_distance: f64) -> ThinLens {
        ThinLens {
            radius,
            focal_distance,
        }
    }

    #[test]
    fn infinity_is_a_focus_and_odd_numbers_are_said() {
        for (text, expected, errors, warnings) in [
            ("", lens(0.0, 1e6), 0, 0),
            (r#""float lensradius" 2"#, lens(2.0, 1e6), 0, 0),
            (
                r#""float lensradius" 2 "float focaldistance" inf"#,
                lens(2.0, f64::INFINITY),
                0,
                0,
            ),
            (r#""float lensradius" -2"#, lens(0.0, 1e6), 0, 1),
            (r#""float lensradius" inf"#, lens(0.0, 1e6), 1, 0),
            (
                r#""float lensradius" 2 "float focaldistance" -3"#,
                lens(0.0, -3.0),
                1,
                0,
            ),
            // Without a lens the distance has no effect.
            (r#""float focaldistance" -3"#, lens(0.0, -3.0), 0, 0),
            (r#""float focaldistance" 0"#, lens(0.0, 0.0), 0, 0),
        ] {
            let outcome = read("perspective", text, ThinLens::from_params);
            let turned = outcome.value.turn(outcome.value.point(Vec2::ZERO));
            assert!(turned.is_finite(), "{text}");
            assert_eq!(outcome.value, expected, "{text}");
            assert_eq!((outcome.errors, outcome.warnings), (errors, warnings));
        }
    }

    #[test]
    fn focused_at_infinity_rays_of_one_film_point_are_parallel() {
        let lens = lens(3.0, f64::INFINITY);
        for u in [Vec2::new(0.1, 0.2), Vec2::new(0.9, 0.7)] {
            assert_eq!(lens.turn(lens.point(u)), DVec2::ZERO);
        }
    }
}
