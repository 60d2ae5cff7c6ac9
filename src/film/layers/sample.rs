//! What a sample tells the layers.

use super::MatteId;
use crate::math::{DVec4, Rgb, Vec2, Vec3, Vec4};

/// What a camera ray that left the lens and met a surface tells the layers.
#[derive(Clone, Copy, Debug)]
pub struct LayerSample<'a> {
    /// Of the surface.
    pub surface: &'a SurfaceSample,
    /// Where the surface's point is.
    pub space: &'a RenderSpace,
    /// Of the camera.
    pub camera: CameraSample,
    /// Of [`super::Layer::MATTES`].
    pub mattes: [MatteId; 2],
}

/// Render space, in which all samples of an image have their points.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RenderSpace {
    /// Where it begins, in world space, scene units; and a zero.
    pub origin: DVec4,
    /// The dot product of this and a point, with 1 for w, is its [depth](super::Layer::Depth): the depth of a mean of points is the mean of their depths. 0
    /// where samples tell it.
    pub depth: DVec4,
}

/// What layers tell of how a camera sees a point.
#[derive(Clone, Copy, Debug)]
pub struct CameraSample(pub(super) Vec4);

impl CameraSample {
    /// See [`super::Layer::Depth`], [`super::Layer::Coc`] and [`super::Layer::Motion`]. The depth is added to that by [`RenderSpace::depth`]: one of both is 0.
    #[inline(always)]
    pub fn new(depth: f64, coc: f64, motion: Vec2) -> CameraSample {
        CameraSample(Vec4::new(depth as f32, coc as f32, motion.x, motion.y))
    }
}

/// What layers tell of a surface: numbers side by side, which vector instructions add, and a zero after each three.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(16))]
pub struct SurfaceSample {
    pub(super) albedo: [f32; 4],
    pub(super) normal: [f32; 4],
    pub(super) p: [f32; 4],
    pub(super) uv: [f32; 4],
}

impl SurfaceSample {
    /// See [`super::Layer::Albedo`].
    #[inline(always)]
    pub fn albedo(&self) -> Rgb {
        Vec4::from_array(self.albedo).truncate()
    }

    /// See [`super::Layer::Normal`]; in render space, which is world space moved.
    #[inline(always)]
    pub fn normal(&self) -> Vec3 {
        Vec4::from_array(self.normal).truncate()
    }

    /// The point, in render space.
    #[inline(always)]
    pub fn p(&self) -> Vec3 {
        Vec4::from_array(self.p).truncate()
    }

    /// Sets the albedo.
    #[inline(always)]
    pub fn set_albedo(&mut self, albedo: Rgb) {
        set(&mut self.albedo, albedo);
    }

    /// Sets the normal.
    #[inline(always)]
    pub fn set_normal(&mut self, normal: Vec3) {
        set(&mut self.normal, normal);
    }

    /// Sets the point.
    #[inline(always)]
    pub fn set_p(&mut self, p: Vec3) {
        set(&mut self.p, p);
    }

    /// Sets the surface's parameters: see [`super::Layer::Uv`].
    #[inline(always)]
    pub fn set_uv(&mut self, uv: Vec2) {
        (self.uv[0], self.uv[1]) = (uv.x, uv.y);
    }

    /// Makes albedo and normal black where they are not numbers: one sample would spoil its pixel.
    #[inline(always)]
    pub fn make_finite(&mut self) {
        let [[a, b, c, _], [x, y, z, _]] = [self.albedo, self.normal];
        // Nor is their sum then.
        if !(a + b + c + x + y + z).is_finite() {
            self.make_black();
        }
    }

    /// Makes albedo and normal black.
    #[inline(always)]
    pub fn make_black(&mut self) {
        (self.albedo, self.normal) = ([0.0; 4], [0.0; 4]);
    }
}

/// One number after the other: they are apart where they come from.
#[inline(always)]
fn set(own: &mut [f32; 4], v: Vec3) {
    (own[0], own[1], own[2]) = (v.x, v.y, v.z);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_a_number_is_black() {
        let n = Vec3::new(0.6, 0.0, -0.8);
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            for (albedo, normal) in [(Rgb::new(0.1, bad, 0.0), n), (Rgb::ONE, n.with_z(bad))] {
                let mut sample = SurfaceSample::default();
                sample.set_albedo(albedo);
                sample.set_normal(normal);
                sample.set_p(Vec3::ONE);
                sample.make_finite();
                let own = [sample.albedo(), sample.normal(), sample.p()];
                assert_eq!(own, [Rgb::ZERO, Vec3::ZERO, Vec3::ONE]);
            }
        }
        let mut sample = SurfaceSample::default();
        sample.set_albedo(Rgb::new(1e30, 0.0, 1.0));
        sample.set_normal(n);
        let before = sample;
        sample.make_finite();
        assert_eq!(sample, before);
    }
}
