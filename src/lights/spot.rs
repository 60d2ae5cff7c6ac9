//! `spot`: a point light that shines into a cone.
//!
//! `I` (spectrum, 1): intensity on the axis. `scale` (spectrum, 1): factor. `from` (point, origin),
//! `to` (point, (0,0,1)): position and where the axis points, both transformed. `coneangle`
//! (float, 30): degrees from the axis beyond which it is dark. `conedeltaangle` (float, 5): how
//! many degrees before that it begins to fall, as the fourth power of what is left in cosine.
//! Source: Pharr, Jakob and Humphreys 2016, §12.3.1; docs/scene-language.md §3.10.

use super::emission::{Directions, Emission, EmissionDensity, SceneSphere};
use super::{LightBounds, LightMap, LightSample, LightType, sample_point, strength};
use crate::math::frame::Frame;
use crate::math::sampling::sin_cos_turns;
use crate::math::transform::Transform;
use crate::math::{DVec3, Rgb, Vec2, Vec3};
use crate::params::ParamReader;
use crate::surface::ReferencePoint;
use glam::Mat3;
use std::f32::consts::PI;

/// Parameters; positions in light space, under `light_to_world`.
#[derive(Clone, Debug, PartialEq)]
pub struct SpotSpec {
    /// Where `from` and `to` are meant.
    pub light_to_world: Transform,
    /// Position.
    pub from: DVec3,
    /// A point on the axis other than `from`.
    pub to: DVec3,
    /// Intensity on the axis.
    pub intensity: Rgb,
    /// Angle from the axis where it gets dark, degrees.
    pub cone_angle: f64,
    /// Width of the penumbra, degrees.
    pub cone_delta_angle: f64,
}

impl SpotSpec {
    /// Reads the parameters. Without a direction the light points along +z.
    pub fn from_params(reader: &ParamReader, light_to_world: &Transform) -> SpotSpec {
        let from = reader.point3("from", DVec3::ZERO);
        let mut to = reader.point3("to", DVec3::Z);
        if (to - from).try_normalize().is_none() {
            reader.error(
                "to",
                "\"from\" and \"to\" of a spot light coincide; pointing it along z",
            );
            to = from + DVec3::Z;
        }
        let cone_angle = cone_angle(reader);
        SpotSpec {
            light_to_world: *light_to_world,
            from,
            to,
            intensity: strength(reader, "I"),
            cone_angle,
            cone_delta_angle: cone_delta_angle(reader, cone_angle),
        }
    }
}

/// The angle in 0…180 degrees that has the same cosine.
fn same_cosine(degrees: f64) -> f64 {
    let turned = degrees.abs() % 360.0;
    turned.min(360.0 - turned)
}

/// `coneangle` in 0…180 degrees. pbrt-v3 uses its cosine alone, and so takes other angles for ones
/// in this range, without a word.
fn cone_angle(reader: &ParamReader) -> f64 {
    let given = reader.float("coneangle", 30.0);
    let used = match given.is_finite() {
        true => same_cosine(given),
        false => 180.0,
    };
    if used != given {
        reader.warn(
            "coneangle",
            format!("`coneangle` is {given} degrees, outside 0 to 180: {used} is used"),
        );
    } else if used == 0.0 {
        reader.warn("coneangle", "`coneangle` is 0: the light lights nothing");
    }
    used
}

/// `conedeltaangle` in 0…`cone_angle` degrees. pbrt-v3 uses the cosine of the difference alone: the
/// light is full up to that angle, whatever its sign, and has a sharp edge where it is beyond the cone.
fn cone_delta_angle(reader: &ParamReader, cone_angle: f64) -> f64 {
    const DEFAULT: f64 = 5.0;
    let Some(given) = reader.find_float("conedeltaangle") else {
        return DEFAULT;
    };
    let used = match given.is_finite() {
        true => (cone_angle - same_cosine(cone_angle - given)).max(0.0),
        false => 0.0,
    };
    if !(0.0..=cone_angle).contains(&given) {
        reader.warn(
            "conedeltaangle",
            format!(
                "`conedeltaangle` is {given} degrees, outside 0 to `coneangle`: {used} is used"
            ),
        );
        return used;
    }
    given
}

/// A spot light in render space.
#[derive(Clone, Debug)]
pub struct SpotLight {
    p: Vec3,
    intensity: Rgb,
    /// Angles are measured in light space, which an uneven scale deforms.
    light_from_render: Mat3,
    /// Unit axis, light space.
    axis: Vec3,
    /// Unit axis, render space.
    render_axis: Vec3,
    cos_dark: f32,
    cos_full: f32,
}

impl SpotLight {
    /// Compiles `spec`.
    pub fn new(spec: &SpotSpec, _map: Option<LightMap>, render_from_world: &Transform) -> Self {
        let render_from_light = *render_from_world * spec.light_to_world;
        let axis = (spec.to - spec.from).normalize_or(DVec3::Z);
        SpotLight {
            p: render_from_light.point(spec.from).as_vec3(),
            intensity: spec.intensity,
            light_from_render: glam::DMat3::from_mat4(render_from_light.inverse).as_mat3(),
            axis: axis.as_vec3(),
            render_axis: render_from_light.vector(axis).normalize_or_zero().as_vec3(),
            cos_dark: spec.cone_angle.to_radians().cos() as f32,
            cos_full: (spec.cone_angle - spec.cone_delta_angle).to_radians().cos() as f32,
        }
    }

    /// Share of the intensity that goes in direction `w` away from the light.
    fn falloff(&self, w: Vec3) -> f32 {
        let cos = (self.light_from_render * w)
            .normalize_or_zero()
            .dot(self.axis);
        if cos < self.cos_dark {
            0.0
        } else if cos >= self.cos_full {
            1.0
        } else {
            ((cos - self.cos_dark) / (self.cos_full - self.cos_dark)).powi(4)
        }
    }

    /// Solid angles over 2π of the bright cone, and of one that would get the light of the penumbra, over which δ⁴
    /// averages 1/5.
    fn shares(&self) -> [f32; 2] {
        let bright = 1.0 - self.cos_full.max(self.cos_dark);
        let penumbra = (self.cos_full - self.cos_dark).max(0.0);
        [bright, penumbra / 5.0]
    }

    /// A direction, light space, as often as it is bright there: δ is the fifth root of an even number.
    fn direction(&self, u: Vec2) -> Vec3 {
        let [bright, penumbra] = self.shares();
        let share = u.x * (bright + penumbra);
        // 1 − cos θ, which keeps narrow cones exact.
        let below_1 = if share < bright || penumbra == 0.0 {
            share
        } else {
            let delta = ((share - bright) / penumbra).clamp(0.0, 1.0).powf(0.2);
            1.0 - self.cos_dark - delta * (self.cos_full - self.cos_dark)
        };
        let sin = (below_1 * (2.0 - below_1)).max(0.0).sqrt();
        let (y, x) = sin_cos_turns(u.y);
        Frame::from_normal(self.axis).to_world(Vec3::new(sin * x, sin * y, 1.0 - below_1))
    }

    /// Density per solid angle of the unit direction `d` away from the light.
    fn direction_density(&self, d: Vec3) -> f32 {
        let [bright, penumbra] = self.shares();
        let change = Directions::new(&self.light_from_render).density_change(d);
        self.falloff(d) / (2.0 * PI * (bright + penumbra)) * change
    }
}

impl LightType for SpotLight {
    fn sample(&self, from: &ReferencePoint, _u: Vec2) -> Option<LightSample> {
        sample_point(self.p, from, |w| self.intensity * self.falloff(w))
    }

    fn place(&self) -> Vec3 {
        self.p
    }

    fn emit(&self, _scene: &SceneSphere, _u_position: Vec2, u_direction: Vec2) -> Option<Emission> {
        let w = self.direction(u_direction);
        let d = Directions::new(&self.light_from_render).to_render(w);
        self.emit_toward(Vec2::ZERO, d)
    }

    fn emit_toward(&self, _u_position: Vec2, d: Vec3) -> Option<Emission> {
        let intensity = self.intensity * self.falloff(d);
        Emission::from_point(self.p, d, intensity, self.direction_density(d))
    }

    fn emission_density(&self, _scene: &SceneSphere, _n: Vec3, d: Vec3) -> EmissionDensity {
        EmissionDensity::of_point(self.direction_density(d))
    }

    /// Flux: exact for a transformation that keeps angles.
    fn power(&self, _scene_radius: f32) -> Rgb {
        let [bright, penumbra] = self.shares();
        2.0 * PI * (bright + penumbra) * self.intensity
    }

    fn bounds(&self) -> LightBounds {
        LightBounds::point(self.p, self.intensity).within_cone(
            self.render_axis,
            self.cos_dark,
            self.cos_full,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec2;
    use crate::math::sampling::uniform_sphere;
    use crate::params::testing::read;

    fn spot(light_to_world: Transform) -> SpotLight {
        let spec = SpotSpec {
            light_to_world,
            from: DVec3::new(0.0, 1.0, 0.0),
            to: DVec3::new(0.0, 1.0, 2.0),
            intensity: Rgb::new(1.0, 2.0, 3.0),
            cone_angle: 40.0,
            cone_delta_angle: 15.0,
        };
        SpotLight::new(&spec, None, &Transform::translate(DVec3::X))
    }

    #[test]
    fn penumbras_out_of_range_are_those_of_pbrt() {
        for (given, used, warnings) in [
            ("10", 10.0, 0),
            ("0", 0.0, 0),
            ("40", 40.0, 0),
            ("-10", 0.0, 1),
            // Full up to |40 − 60| degrees, or to |40 − 300| = 100 with a sharp edge at 40.
            ("60", 20.0, 1),
            ("300", 0.0, 1),
            ("inf", 0.0, 1),
        ] {
            let text = format!("\"float conedeltaangle\" {given}");
            let outcome = read("spot", &text, |reader| cone_delta_angle(reader, 40.0));
            assert_eq!(
                (outcome.value, outcome.warnings),
                (used, warnings),
                "{given}"
            );
        }
    }

    #[test]
    fn shines_into_its_cone_only() {
        let light = spot(Transform::IDENTITY);
        let toward =
            |degrees: f32| Vec3::new(0.0, degrees.to_radians().sin(), degrees.to_radians().cos());
        assert_eq!(light.p, Vec3::new(1.0, 1.0, 0.0));
        assert_eq!(light.falloff(toward(24.9)), 1.0);
        assert_eq!(light.falloff(toward(40.1)), 0.0);
        let cos = |degrees: f32| degrees.to_radians().cos();
        let delta = (cos(30.0) - cos(40.0)) / (cos(25.0) - cos(40.0));
        assert!((light.falloff(toward(30.0)) - delta.powi(4)).abs() < 1e-5);
    }

    #[test]
    fn power_is_the_integral_of_the_intensity() {
        let light = spot(Transform::rotate(70.0, DVec3::new(1.0, 2.0, 0.5)));
        let n = 400;
        let mut mean = 0.0;
        for i in 0..n * n {
            let u = Vec2::new((i % n) as f32 + 0.5, (i / n) as f32 + 0.5) / n as f32;
            mean += f64::from(light.falloff(uniform_sphere(u))) / f64::from(n * n);
        }
        let expected = light.power(1.0).x / (4.0 * PI);
        // A grid of 400² points over a function with a kink.
        assert!(
            (mean as f32 / expected - 1.0).abs() < 5e-3,
            "{mean} but {expected}"
        );
    }

    #[test]
    fn an_uneven_scale_deforms_the_cone() {
        // Twice as wide in x: what is 45° there is atan(1/2) ≈ 26.6° in light space, in the
        // penumbra's bright end, but 45° in y stays dark.
        let light = spot(Transform::scale(DVec3::new(2.0, 1.0, 1.0)));
        let diagonal = std::f32::consts::FRAC_1_SQRT_2;
        assert!(light.falloff(Vec3::new(diagonal, 0.0, diagonal)) > 0.5);
        assert_eq!(light.falloff(Vec3::new(0.0, diagonal, diagonal)), 0.0);
    }

    #[test]
    fn odd_cone_angles_are_those_of_the_same_cosine() {
        for (given, used, warnings) in [
            ("30", 30.0, 0),
            ("180", 180.0, 0),
            ("0", 0.0, 1),
            ("-10", 10.0, 1),
            ("200", 160.0, 1),
            ("730", 10.0, 1),
            ("inf", 180.0, 1),
        ] {
            let outcome = read("spot", &format!("\"float coneangle\" {given}"), cone_angle);
            assert_eq!(
                (outcome.value, outcome.warnings),
                (used, warnings),
                "{given}"
            );
        }
    }
}
