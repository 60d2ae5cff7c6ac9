//! What a sample tells the layers.

use super::MatteId;
use crate::math::{DVec2, Rgb, Vec2, Vec3, Vec4};

/// What a camera ray that left the lens and met a surface tells the layers.
#[derive(Clone, Copy, Debug)]
pub struct LayerSample<'a> {
    /// Of the surface.
    pub surface: &'a SurfaceSample,
    /// Where render space begins, in world space, scene units; and a zero.
    pub origin: &'a [f64; 4],
    /// See [`super::Layer::Depth`].
    pub depth: f64,
    /// See [`super::Layer::Coc`].
    pub coc: f64,
    /// See [`super::Layer::Motion`].
    pub motion: DVec2,
    /// Of [`super::Layer::MATTES`].
    pub mattes: [MatteId; 2],
}

/// What layers tell of a surface: numbers side by side, which vector instructions add.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SurfaceSample {
    pub(super) albedo: Lanes,
    pub(super) normal: Lanes,
    pub(super) p: Lanes,
    pub(super) uv: Lanes,
}

/// A vector, and zeros.
pub(super) type Lanes = [f32; 4];

impl SurfaceSample {
    /// See [`super::Layer::Albedo`].
    #[inline(always)]
    pub fn albedo(&self) -> Rgb {
        Vec3::from_slice(&self.albedo)
    }

    /// See [`super::Layer::Normal`]; in render space, which is world space moved.
    #[inline(always)]
    pub fn normal(&self) -> Vec3 {
        Vec3::from_slice(&self.normal)
    }

    /// The point, in render space.
    #[inline(always)]
    pub fn p(&self) -> Vec3 {
        Vec3::from_slice(&self.p)
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

    /// Returns `true` if albedo and normal are numbers.
    #[inline(always)]
    pub fn is_finite(&self) -> bool {
        let (albedo, normal) = (Vec4::from(self.albedo), Vec4::from(self.normal));
        // Nearly always: then no addend was anything else.
        (albedo + normal).is_finite() || albedo.is_finite() && normal.is_finite()
    }
}

#[inline(always)]
fn set(lanes: &mut Lanes, v: Vec3) {
    (lanes[0], lanes[1], lanes[2]) = (v.x, v.y, v.z);
}
