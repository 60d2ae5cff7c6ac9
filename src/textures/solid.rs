//! Points of three-dimensional textures.

use super::PointMap;
use crate::math::Vec3;
use crate::math::transform::Transform;
use crate::surface::TexturePoint;

/// From surfaces to the space of a solid texture: the texture's CTM itself, *not* its inverse
/// (a quirk of pbrt that scenes rely on: `Scale 4 4 4` makes the pattern four times smaller).
#[derive(Clone, Copy, Debug)]
pub struct SolidMapping(PointMap);

/// A point in a solid texture's space with its change from one film sample to the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolidPoint {
    /// Position.
    pub p: Vec3,
    /// ∂p/∂x on the film.
    pub dpdx: Vec3,
    /// ∂p/∂y on the film.
    pub dpdy: Vec3,
}

impl SolidMapping {
    /// For a texture defined under `ctm`, from world space.
    pub fn new(ctm: &Transform) -> SolidMapping {
        SolidMapping(PointMap::new(&ctm.m))
    }

    /// This mapping of world-space points for points in render space.
    pub fn from_render(&self, render_from_world: &Transform) -> SolidMapping {
        SolidMapping(self.0.from_render(render_from_world))
    }

    /// The point alone.
    pub fn position(&self, at: &TexturePoint) -> Vec3 {
        self.0.point(at.p)
    }

    /// The point and its differentials.
    pub fn point(&self, at: &TexturePoint) -> SolidPoint {
        SolidPoint {
            p: self.0.point(at.p),
            dpdx: self.0.vector(at.footprint.dpdx),
            dpdy: self.0.vector(at.footprint.dpdy),
        }
    }
}

impl SolidPoint {
    /// The point of a pattern that is 1/`factor` times as large.
    pub fn scaled(&self, factor: f32) -> SolidPoint {
        SolidPoint {
            p: self.p * factor,
            dpdx: self.dpdx * factor,
            dpdy: self.dpdy * factor,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{DVec3, Vec2};
    use crate::surface::Footprint;

    #[test]
    fn points_move_and_their_differentials_only_turn_and_scale() {
        let ctm = Transform::translate(DVec3::X) * Transform::scale(DVec3::new(2.0, 3.0, 4.0));
        let camera = DVec3::new(5.0, 0.0, 0.0);
        let mapping = SolidMapping::new(&ctm).from_render(&Transform::translate(-camera));
        let at = TexturePoint {
            p: Vec3::new(-4.0, 1.0, 1.0),
            uv: Vec2::ZERO,
            face: 0,
            footprint: Footprint {
                dpdx: Vec3::X,
                dpdy: Vec3::Z,
                ..Footprint::default()
            },
        };
        let expected = SolidPoint {
            p: Vec3::new(3.0, 3.0, 4.0),
            dpdx: Vec3::X * 2.0,
            dpdy: Vec3::Z * 4.0,
        };
        assert_eq!(mapping.point(&at), expected);
        assert_eq!(mapping.position(&at), expected.p);
        assert_eq!(expected.scaled(0.5).dpdy, Vec3::Z * 2.0);
    }
}
