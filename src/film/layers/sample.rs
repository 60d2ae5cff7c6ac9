//! What a sample tells the layers.

use super::MatteId;
use crate::math::{Rgb, Vec2, Vec3};

/// What a camera ray that left the lens and met a surface tells the layers.
#[derive(Clone, Copy, Debug)]
pub struct LayerSample<'a> {
    /// Of the surface.
    pub surface: &'a SurfaceSample,
    /// Where render space begins, in world space, scene units; and a zero.
    pub origin: &'a [f64; 4],
    /// See [`super::Layer::Depth`].
    pub depth: f32,
    /// See [`super::Layer::Coc`].
    pub coc: f32,
    /// See [`super::Layer::Motion`].
    pub motion: Vec2,
    /// Of [`super::Layer::MATTES`].
    pub mattes: [MatteId; 2],
}

/// What layers tell of a surface: numbers side by side, which vector instructions add.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SurfaceSample {
    /// Albedo, 0, normal, 0: what is filtered.
    pub(super) filtered: [f32; 8],
    /// Point, 0, (u, v), 0, 0.
    pub(super) plain: [f32; 8],
}

impl SurfaceSample {
    /// See [`super::Layer::Albedo`].
    #[inline(always)]
    pub fn albedo(&self) -> Rgb {
        Vec3::from_slice(&self.filtered)
    }

    /// See [`super::Layer::Normal`]; in render space, which is world space moved.
    #[inline(always)]
    pub fn normal(&self) -> Vec3 {
        Vec3::from_slice(&self.filtered[4..])
    }

    /// The point, in render space.
    #[inline(always)]
    pub fn p(&self) -> Vec3 {
        Vec3::from_slice(&self.plain)
    }

    /// Sets the albedo.
    #[inline(always)]
    pub fn set_albedo(&mut self, albedo: Rgb) {
        albedo.write_to_slice(&mut self.filtered);
    }

    /// Sets the normal.
    #[inline(always)]
    pub fn set_normal(&mut self, normal: Vec3) {
        normal.write_to_slice(&mut self.filtered[4..]);
    }

    /// Sets the point.
    #[inline(always)]
    pub fn set_p(&mut self, p: Vec3) {
        p.write_to_slice(&mut self.plain);
    }

    /// Sets the surface's parameters: see [`super::Layer::Uv`].
    #[inline(always)]
    pub fn set_uv(&mut self, uv: Vec2) {
        uv.write_to_slice(&mut self.plain[4..]);
    }

    /// Returns `true` if albedo and normal are numbers.
    #[inline(always)]
    pub fn is_finite(&self) -> bool {
        // Not zero times one of them, but for numbers.
        self.filtered.map(|x| x * 0.0) == [0.0; 8]
    }
}
