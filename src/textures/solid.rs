//! Patterns in space: `fbm`, `wrinkled` and `windy`, and what `marble` shares with them.

use super::noise::Octaves;
use super::{Compiler, PointMap, TextureClass, TextureValue, Textures};
use crate::math::Vec3;
use crate::math::transform::Transform;
use crate::params::ParamReader;
use crate::surface::TexturePoint;

/// A texture that is a pattern in space. From world to the pattern's space leads the CTM at the directive
/// itself, *not* its inverse (a quirk of pbrt that scenes rely on: `Scale 4 4 4` makes the pattern four
/// times smaller).
#[derive(Clone, Copy, Debug)]
pub struct Solid<P> {
    mapping: PointMap,
    pattern: P,
}

/// A pattern in a space of its own.
pub(super) trait Pattern {
    /// `true` if there are no float textures of it.
    const COLORS_ONLY: bool = false;

    /// Reads the parameters.
    fn from_params(reader: &ParamReader) -> Self;

    /// The value at a point.
    fn value<V: TextureValue>(&self, at: &SolidPoint) -> V;
}

impl<V: TextureValue, P: Pattern> TextureClass<V> for Solid<P> {
    const COLORS_ONLY: bool = P::COLORS_ONLY;

    fn from_params(reader: &ParamReader, ctm: &Transform) -> Solid<P> {
        Solid {
            mapping: PointMap::new(&ctm.m),
            pattern: P::from_params(reader),
        }
    }

    fn prepare(&mut self, compiler: &mut Compiler) {
        self.mapping.place(compiler.render_from_world);
    }

    fn evaluate(&self, _textures: &Textures, at: &TexturePoint) -> V {
        self.pattern.value(&SolidPoint::new(&self.mapping, at))
    }
}

/// A point in a solid texture's space with its change from one film sample to the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SolidPoint {
    /// Position.
    pub p: Vec3,
    /// ∂p/∂x on the film.
    pub dpdx: Vec3,
    /// ∂p/∂y on the film.
    pub dpdy: Vec3,
}

impl SolidPoint {
    /// A point of a surface, brought to a texture's space.
    fn new(mapping: &PointMap, at: &TexturePoint) -> SolidPoint {
        SolidPoint {
            p: mapping.point(at.p),
            dpdx: mapping.vector(at.footprint.dpdx),
            dpdy: mapping.vector(at.footprint.dpdy),
        }
    }

    /// The point of a pattern that is 1/`factor` times as large.
    pub(super) fn scaled(&self, factor: f32) -> SolidPoint {
        SolidPoint {
            p: self.p * factor,
            dpdx: self.dpdx * factor,
            dpdy: self.dpdy * factor,
        }
    }
}

/// Fractional Brownian motion: octaves of noise in space, 1.99 times finer each, those too fine for
/// the film left out. About −1 to 1. Parameters: integer `octaves` (8, at most 128), float
/// `roughness` (0.5) (Pharr, Jakob and Humphreys 2016, §10.6.3).
#[derive(Clone, Copy, Debug)]
pub struct Fbm(Octaves);

impl Pattern for Fbm {
    fn from_params(reader: &ParamReader) -> Fbm {
        Fbm(Octaves::from_params(reader))
    }

    fn value<V: TextureValue>(&self, at: &SolidPoint) -> V {
        V::splat(self.0.fbm(at))
    }
}

/// Turbulence: octaves of the magnitude of noise in space, with creases where it changes its sign;
/// octaves too fine for the film are replaced by their mean. Never negative. Parameters: integer
/// `octaves` (8, at most 128), float `roughness` (0.5) (Pharr, Jakob and Humphreys 2016, §10.6.3-10.6.4).
#[derive(Clone, Copy, Debug)]
pub struct Wrinkled(Octaves);

impl Pattern for Wrinkled {
    fn from_params(reader: &ParamReader) -> Wrinkled {
        Wrinkled(Octaves::from_params(reader))
    }

    fn value<V: TextureValue>(&self, at: &SolidPoint) -> V {
        V::splat(self.0.turbulence(at))
    }
}

/// How strongly the wind blows here: coarse noise, ten times as large as the waves.
const WIND: Octaves = Octaves {
    most: 3,
    roughness: 0.5,
};

/// The height of the waves it makes.
const WAVES: Octaves = Octaves {
    most: 6,
    roughness: 0.5,
};

/// Waves on water, as strong as a wind that varies over it; of either sign. No parameters (Pharr,
/// Jakob and Humphreys 2016, §10.6.5).
#[derive(Clone, Copy, Debug)]
pub struct Windy;

impl Pattern for Windy {
    fn from_params(_reader: &ParamReader) -> Windy {
        Windy
    }

    fn value<V: TextureValue>(&self, at: &SolidPoint) -> V {
        V::splat(WIND.fbm(&at.scaled(0.1)).abs() * WAVES.fbm(at))
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
        let mut mapping = PointMap::new(&ctm.m);
        mapping.place(&Transform::translate(-camera));
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
        assert_eq!(SolidPoint::new(&mapping, &at), expected);
        assert_eq!(expected.scaled(0.5).dpdy, Vec3::Z * 2.0);
    }
}
