//! `dots`.

use super::noise::noise2;
use super::value::textures_of;
use super::{Compiler, Mapping, TextureClass, TextureValue, Textures};
use crate::inputs::TexturesRead;
use crate::math::Vec2;
use crate::math::transform::Transform;
use crate::params::ParamReader;
use crate::surface::TexturePoint;

/// Radius of a dot, in cells.
const RADIUS: f32 = 0.35;

/// Farthest that a dot lies from the middle of its cell, along each axis: it stays within the cell.
const MAX_SHIFT: f32 = 0.5 - RADIUS;

/// Round dots in about half of the unit cells in (s, t), each at a random place of its cell.
/// Parameters: `inside` (1), `outside` (0), of the texture's own kind; a 2-D mapping. As in pbrt
/// the names are exchanged: `inside` is the value *around* the dots, `outside` that *of* the dots
/// (Pharr, Jakob and Humphreys 2016, §10.6.2; docs/scene-language.md §3.9).
#[derive(Clone, Copy, Debug)]
pub struct Dots<V: TextureValue> {
    /// From points to (s, t).
    pub mapping: Mapping,
    /// Value around the dots.
    pub inside: V::Input,
    /// Value of the dots.
    pub outside: V::Input,
}

impl<V: TextureValue> TextureClass<V> for Dots<V> {
    const FILTERS: bool = false;

    fn from_params(reader: &ParamReader, ctm: &Transform) -> Self {
        Dots {
            mapping: Mapping::from_params(reader, ctm),
            inside: V::input_from_params(reader, "inside", 1.0),
            outside: V::input_from_params(reader, "outside", 0.0),
        }
    }

    fn inputs(&self) -> TexturesRead {
        textures_of::<V>([self.inside, self.outside])
    }

    fn prepare(&mut self, compiler: &mut Compiler) {
        self.mapping.place(compiler.render_from_world);
    }

    fn evaluate(&self, textures: &Textures, at: &TexturePoint) -> V {
        let input = if in_dot(self.mapping.position(at)) {
            self.outside
        } else {
            self.inside
        };
        V::lookup(input, textures, at)
    }
}

/// Returns `true` if a dot covers this point; `false` at one that is not finite.
fn in_dot(st: Vec2) -> bool {
    let cell = (st + 0.5).floor();
    // Three far-apart points of the noise decide on existence and place.
    let random = |ds: f32, dt: f32| noise2(cell.x + ds, cell.y + dt);
    if random(0.5, 0.5) <= 0.0 {
        return false;
    }
    let shift = MAX_SHIFT * Vec2::new(random(1.5, 2.8), random(4.5, 9.8));
    st.distance_squared(cell + shift) < RADIUS * RADIUS
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dots_cover_what_they_should() {
        let n = 1000;
        let inside = (0..n * n).filter(|i| {
            let cell = Vec2::new((i % n) as f32 + 0.5, (i / n) as f32 + 0.5);
            in_dot(cell * (64.0 / n as f32) - 32.0)
        });
        let share = inside.count() as f32 / (n * n) as f32;
        let dots = (0..64 * 64)
            .filter(|i| noise2((i % 64) as f32 - 31.5, (i / 64) as f32 - 31.5) > 0.0)
            .count();
        let expected = dots as f32 / (64.0 * 64.0) * std::f32::consts::PI * RADIUS * RADIUS;
        // The grid has 16 points per cell side: 0.5 % of a dot's area; cells at the border count half.
        assert!((share / expected - 1.0).abs() < 0.02, "{share} {expected}");
        assert!((1500..2600).contains(&dots), "{dots}");
    }

    #[test]
    fn wild_points_are_harmless() {
        for x in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            assert!(!in_dot(Vec2::splat(x)) && !in_dot(Vec2::new(0.2, x)));
        }
        for x in [1e30, -1e30, f32::MIN, 1e-40] {
            // Whichever: it ends, and nearby points (the same float) agree.
            assert_eq!(
                in_dot(Vec2::splat(x)),
                in_dot(Vec2::splat(x * (1.0 + 1e-8)))
            );
        }
    }
}
