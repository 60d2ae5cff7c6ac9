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

/// What layers tell of a surface: numbers side by side, so that one cache line has room for them and for the rest of what most samples need.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SurfaceSample([f32; 12]);

/// Where they are. Four from any of these on are added by vector instructions: behind those of a kind there are others.
pub(super) const OF_UV: usize = 0;
pub(super) const OF_ALBEDO: usize = 2;
pub(super) const OF_NORMAL: usize = 5;
/// A zero comes after these.
pub(super) const OF_P: usize = 8;

impl SurfaceSample {
    /// Four numbers from this place on.
    #[inline(always)]
    pub(super) fn four(&self, at: usize) -> Vec4 {
        Vec4::from_slice(&self.0[at..])
    }

    #[inline(always)]
    fn three(&self, at: usize) -> Vec3 {
        Vec3::from_slice(&self.0[at..])
    }

    /// One number after the other: they are apart where they come from.
    #[inline(always)]
    fn set(&mut self, at: usize, v: Vec3) {
        (self.0[at], self.0[at + 1], self.0[at + 2]) = (v.x, v.y, v.z);
    }

    /// See [`super::Layer::Albedo`].
    #[inline(always)]
    pub fn albedo(&self) -> Rgb {
        self.three(OF_ALBEDO)
    }

    /// See [`super::Layer::Normal`]; in render space, which is world space moved.
    #[inline(always)]
    pub fn normal(&self) -> Vec3 {
        self.three(OF_NORMAL)
    }

    /// The point, in render space.
    #[inline(always)]
    pub fn p(&self) -> Vec3 {
        self.three(OF_P)
    }

    /// Sets the albedo.
    #[inline(always)]
    pub fn set_albedo(&mut self, albedo: Rgb) {
        self.set(OF_ALBEDO, albedo);
    }

    /// Sets the normal.
    #[inline(always)]
    pub fn set_normal(&mut self, normal: Vec3) {
        self.set(OF_NORMAL, normal);
    }

    /// Sets the point.
    #[inline(always)]
    pub fn set_p(&mut self, p: Vec3) {
        self.set(OF_P, p);
    }

    /// Sets the surface's parameters: see [`super::Layer::Uv`].
    #[inline(always)]
    pub fn set_uv(&mut self, uv: Vec2) {
        (self.0[OF_UV], self.0[OF_UV + 1]) = (uv.x, uv.y);
    }

    /// Makes albedo and normal black where they are not numbers: one sample would spoil its pixel.
    #[inline(always)]
    pub fn make_finite(&mut self) {
        // Nor is their sum then.
        let both = self.albedo() + self.normal();
        if !both.element_sum().is_finite() {
            self.make_black();
        }
    }

    /// Makes albedo and normal black.
    #[inline(always)]
    pub fn make_black(&mut self) {
        self.set_albedo(Rgb::ZERO);
        self.set_normal(Vec3::ZERO);
    }
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
