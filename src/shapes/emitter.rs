//! Shapes that light is sampled from.

use crate::math::{Vec2, Vec3};
use crate::surface::{ReferencePoint, SurfaceHit};

/// A point chosen on an emitter.
#[derive(Clone, Copy, Debug)]
pub struct EmitterSample {
    /// The point, render space.
    pub p: Vec3,
    /// Half-widths of the box around `p` that holds the exact point.
    pub p_error: Vec3,
    /// Unit normal, on the side that [`SurfaceHit::n`] has there.
    pub n: Vec3,
    /// Density per solid angle at the receiving point.
    pub pdf: f32,
}

/// A shape that light is sampled from: its own copy, nothing refers into the geometry.
#[derive(Clone, Debug)]
pub enum Emitter {}

impl Emitter {
    /// Chooses a point as seen from `from`. `None` where nothing can be seen from there or the
    /// shape has no area.
    pub fn sample(&self, _from: &ReferencePoint, _u: Vec2) -> Option<EmitterSample> {
        todo!()
    }

    /// Density per solid angle with which [`Emitter::sample`] chooses direction `wi`; `hit` is
    /// where a ray from `from` along `wi` met this emitter.
    pub fn pdf(&self, _from: &ReferencePoint, _wi: Vec3, _hit: &SurfaceHit) -> f32 {
        todo!()
    }

    /// Surface area in world units squared.
    pub fn area(&self) -> f64 {
        todo!()
    }
}
