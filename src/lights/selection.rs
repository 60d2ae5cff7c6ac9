//! Choosing one light.
use super::Light;
use crate::handles::LightId;
use crate::math::{Rgb, Vec3};
use crate::surface::ReferencePoint;

/// How one light is chosen among several.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SelectionStrategy {
    Uniform,
    Power,
    Spatial,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Reach {}
impl Reach {
    pub(super) fn nowhere() -> Reach {
        Reach {}
    }
    pub(super) fn point(_p: Vec3, _i: Rgb) -> Reach {
        Reach {}
    }
    pub(super) fn area(_c: Vec3, _r: f32, _i: Rgb) -> Reach {
        Reach {}
    }
    pub(super) fn everywhere(_i: Rgb) -> Reach {
        Reach {}
    }
    pub(super) fn on_side(self, _n: Vec3) -> Reach {
        self
    }
    pub(super) fn within_cone(self, _axis: Vec3, _dark: f32, _full: f32) -> Reach {
        self
    }
}
#[derive(Clone, Debug)]
pub struct LightSelector {
    count: u32,
}
impl LightSelector {
    pub fn new(
        lights: &[Light],
        _strategy: SelectionStrategy,
        _scene_radius: f32,
    ) -> LightSelector {
        LightSelector {
            count: lights.len() as u32,
        }
    }
    pub fn sample(&self, _from: &ReferencePoint, u: f32) -> Option<(LightId, f32)> {
        (self.count > 0).then(|| {
            (
                LightId(((u * self.count as f32) as u32).min(self.count - 1)),
                1.0 / self.count as f32,
            )
        })
    }
    pub fn pmf(&self, _from: &ReferencePoint, _light: LightId) -> f32 {
        1.0 / self.count as f32
    }
}
