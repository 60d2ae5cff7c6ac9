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

/// What layers tell of a surface: numbers side by side, which vector instructions add.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SurfaceSample {
    pub(super) albedo: Vec4,
    pub(super) normal: Vec4,
    pub(super) p: Vec4,
    pub(super) uv: Vec4,
}

impl SurfaceSample {
    /// See [`super::Layer::Albedo`].
    #[inline(always)]
    pub fn albedo(&self) -> Rgb {
        self.albedo.truncate()
    }

    /// See [`super::Layer::Normal`]; in render space, which is world space moved.
    #[inline(always)]
    pub fn normal(&self) -> Vec3 {
        self.normal.truncate()
    }

    /// The point, in render space.
    #[inline(always)]
    pub fn p(&self) -> Vec3 {
        self.p.truncate()
    }

    /// Sets the albedo.
    #[inline(always)]
    pub fn set_albedo(&mut self, albedo: Rgb) {
        self.albedo = albedo.extend(0.0);
    }

    /// Sets the normal.
    #[inline(always)]
    pub fn set_normal(&mut self, normal: Vec3) {
        self.normal = normal.extend(0.0);
    }

    /// Sets the point.
    #[inline(always)]
    pub fn set_p(&mut self, p: Vec3) {
        self.p = p.extend(0.0);
    }

    /// Sets the surface's parameters: see [`super::Layer::Uv`].
    #[inline(always)]
    pub fn set_uv(&mut self, uv: Vec2) {
        self.uv = Vec4::new(uv.x, uv.y, 0.0, 0.0);
    }

    /// Returns `true` if albedo and normal are numbers.
    #[inline(always)]
    pub fn is_finite(&self) -> bool {
        // Zero times anything but a number is not zero.
        (self.albedo * 0.0 + self.normal * 0.0) == Vec4::ZERO
    }
}
