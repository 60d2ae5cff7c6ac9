//! What every type of light implements in its own file.

use super::emission::{Emission, EmissionDensity, LightEnd, SceneSphere, sample_of_point};
use super::{LightBounds, LightSample};
use crate::math::{Rgb, Vec2, Vec3};
use crate::surface::{ReferencePoint, SurfaceHit};

/// A type of light, in render space. See [`super::Light`] for what the functions mean; their defaults are those of
/// lights that no ray can meet by chance.
pub(super) trait LightType: Sized {
    /// `true` if `mapname` is one of its parameters.
    const MAPPED: bool = false;
    /// `true` if no ray can meet the light by chance.
    const IS_DELTA: bool = true;
    /// `true` if rays that leave the scene see the light.
    const IS_INFINITE: bool = false;
    /// `true` if its light comes from infinitely far away.
    const IS_AT_INFINITY: bool = false;

    fn sample(&self, from: &ReferencePoint, u: Vec2) -> Option<LightSample>;

    fn emit(&self, scene: &SceneSphere, u_position: Vec2, u_direction: Vec2) -> Option<Emission>;

    /// [`LightType::emit`] in a given direction; `None` for lights at infinity.
    fn emit_toward(&self, u_position: Vec2, d: Vec3) -> Option<Emission>;

    fn emission_density(&self, scene: &SceneSphere, n: Vec3, d: Vec3) -> EmissionDensity;

    fn prepare_emission(&mut self) {}

    /// Where a light without area is; anything for lights at infinity.
    fn place(&self) -> Vec3 {
        Vec3::ZERO
    }

    #[inline]
    fn sample_with_end(&self, from: &ReferencePoint, u: Vec2) -> Option<(LightSample, LightEnd)> {
        sample_of_point(self, self.place(), from, u)
    }

    fn power(&self, scene_radius: f32) -> Rgb;

    /// Roughly where, and how strongly, the light arrives.
    fn bounds(&self) -> LightBounds;

    fn pdf(&self, _from: &ReferencePoint, _wi: Vec3, _hit: Option<&SurfaceHit>) -> f32 {
        0.0
    }

    fn escaped(&self, _d: Vec3) -> Rgb {
        Rgb::ZERO
    }

    fn escaped_and_pdf(&self, _from: &ReferencePoint, _d: Vec3) -> (Rgb, f32) {
        (Rgb::ZERO, 0.0)
    }

    fn emitted(&self, _hit: &SurfaceHit) -> Rgb {
        Rgb::ZERO
    }

    fn sample_count(&self) -> u32 {
        1
    }

    fn group(&self) -> Option<u32> {
        None
    }
}
