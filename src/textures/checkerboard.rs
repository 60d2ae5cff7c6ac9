//! `checkerboard`.

use super::value::textures_of;
use super::{Compiler, Mapping, PointMap, TextureClass, TextureValue, Textures};
use crate::inputs::TexturesRead;
use crate::math::Vec2;
use crate::math::float::floor;
use crate::math::transform::Transform;
use crate::params::ParamReader;
use crate::surface::TexturePoint;

/// Unit squares or cubes that alternate between two textures: `tex1` where the sum of the cell's
/// integer coordinates is even. Parameters: `dimension` 2 (or 3), `tex1` (1), `tex2` (0) of the
/// texture's own kind; in two dimensions string `aamode` `closedform` (or `none`) and a 2-D mapping.
/// The closed form is the board's mean over a box around the point
/// (Pharr, Jakob and Humphreys 2016, §10.5.1).
#[derive(Clone, Copy, Debug)]
pub struct Checkerboard<V: TextureValue> {
    /// How points fall into cells.
    pub cells: Cells,
    /// Value on even cells.
    pub tex1: V::Input,
    /// Value on odd cells.
    pub tex2: V::Input,
}

/// The board's cells.
#[derive(Clone, Copy, Debug)]
pub enum Cells {
    /// Unit squares in (s, t).
    Squares(Mapping, Antialiasing),
    /// Unit cubes in the space to which the CTM itself leads ([`Solid`](super::solid::Solid)).
    Cubes(PointMap),
}

/// Filtering of a 2-D checkerboard.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Antialiasing {
    /// Point sampling.
    None,
    /// The exact mean over a box whose half-widths are the largest differentials.
    ClosedForm,
}

impl<V: TextureValue> TextureClass<V> for Checkerboard<V> {
    fn from_params(reader: &ParamReader, ctm: &Transform) -> Self {
        let cells = match reader.integer("dimension", 2) {
            3 => Cells::Cubes(PointMap::new(&ctm.m)),
            dimension => {
                if dimension != 2 {
                    reader.error(
                        "dimension",
                        format!("a checkerboard has 2 or 3 dimensions, not {dimension}: 2 taken"),
                    );
                }
                let antialiasing = match reader.one_of("aamode", &["closedform", "none"]) {
                    "none" => Antialiasing::None,
                    _ => Antialiasing::ClosedForm,
                };
                Cells::Squares(Mapping::from_params(reader, ctm), antialiasing)
            }
        };
        let tex1 = V::input_from_params(reader, "tex1", 1.0);
        let tex2 = V::input_from_params(reader, "tex2", 0.0);
        Checkerboard { cells, tex1, tex2 }
    }

    fn inputs(&self) -> TexturesRead {
        textures_of::<V>([self.tex1, self.tex2])
    }

    fn prepare(&mut self, compiler: &mut Compiler) {
        match &mut self.cells {
            Cells::Squares(mapping, _) => mapping.place(compiler.render_from_world),
            Cells::Cubes(map) => map.place(compiler.render_from_world),
        }
    }

    fn needs_footprint(&self) -> bool {
        matches!(self.cells, Cells::Squares(_, Antialiasing::ClosedForm))
    }

    fn evaluate(&self, textures: &Textures, at: &TexturePoint) -> V {
        let odd = match &self.cells {
            Cells::Squares(mapping, Antialiasing::None) => {
                odd_cell(&mapping.position(at).to_array())
            }
            Cells::Squares(mapping, Antialiasing::ClosedForm) => {
                let c = mapping.coordinates(at);
                odd_share(c.st, c.dstdx.abs().max(c.dstdy.abs()))
            }
            Cells::Cubes(map) => odd_cell(&map.point(at.p).to_array()),
        };
        if odd == 0.0 {
            V::lookup(self.tex1, textures, at)
        } else if odd == 1.0 {
            V::lookup(self.tex2, textures, at)
        } else {
            V::lookup(self.tex1, textures, at) * (1.0 - odd)
                + V::lookup(self.tex2, textures, at) * odd
        }
    }
}

/// 1 where the cell's coordinates add up to an odd number, else 0; what is not finite counts as 0.
fn odd_cell(p: &[f32]) -> f32 {
    /// From here on floats are even.
    const ALL_EVEN: f32 = 16_777_216.0;
    // Each coordinate's parity by itself: exact for floats beyond any integer's range too.
    let odd = p
        .iter()
        .filter(|x| x.abs() < ALL_EVEN && floor(**x).0 & 1 == 1);
    (odd.count() % 2) as f32
}

/// Share of odd cells in the box of half-widths `w` around `st`; ½ for boxes wider than two cells.
fn odd_share(st: Vec2, w: Vec2) -> f32 {
    let (low, high) = (st - w, st + w);
    if w.max_element() > 1.0 || !low.is_finite() || !high.is_finite() {
        return 0.5;
    }
    if floor(low.x) == floor(high.x) && floor(low.y) == floor(high.y) {
        return odd_cell(&st.to_array());
    }
    let s = odd_interval_share(low.x, high.x);
    let t = odd_interval_share(low.y, high.y);
    s + t - 2.0 * s * t
}

/// Share of \[low, high\] that lies in odd unit intervals.
fn odd_interval_share(low: f32, high: f32) -> f32 {
    if high <= low {
        return odd_cell(&[low]);
    }
    // Length of odd intervals below x.
    let below = |x: f32| {
        let half = x / 2.0;
        let whole = floor(half).1;
        whole + 2.0 * (half - whole - 0.5).max(0.0)
    };
    ((below(high) - below(low)) / (high - low)).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::budget::Budget;
    use crate::handles::FloatTextureId;
    use crate::inputs::FloatInput;
    use crate::math::hash::{mix2, unit_float};
    use crate::math::{DVec3, Vec3};
    use crate::surface::Footprint;
    use crate::textures::{Texture, TextureSpecs, TextureUsage};

    #[test]
    fn even_cells_come_first_on_both_sides_of_zero() {
        assert_eq!(odd_cell(&[0.5, 0.5]), 0.0);
        assert_eq!(odd_cell(&[-0.5, 0.5]), 1.0);
        assert_eq!(odd_cell(&[-0.5, -0.5]), 0.0);
        assert_eq!(odd_cell(&[1.5, 0.5, 2.5]), 1.0);
        assert_eq!(odd_cell(&[3e9, 0.5]), 0.0);
        assert_eq!(odd_cell(&[f32::MAX, 1.5]), 1.0);
        assert_eq!(odd_cell(&[16_777_215.0, 0.5]), 1.0);
        assert_eq!(odd_cell(&[f32::NAN, f32::NEG_INFINITY]), 0.0);
    }

    #[test]
    fn closed_form_is_the_mean_over_the_box() {
        for i in 0..40u64 {
            let r = |k: u64| unit_float(mix2(i, k));
            let st = Vec2::new(6.0 * r(1) - 3.0, 6.0 * r(2) - 3.0);
            let w = Vec2::new(r(3), r(4));
            let n = 200;
            let mut odd = 0.0;
            for k in 0..n * n {
                let cell =
                    Vec2::new((k % n) as f32 + 0.5, (k / n) as f32 + 0.5) / n as f32 * 2.0 - 1.0;
                odd += odd_cell(&(st + w * cell).to_array());
            }
            // The grid misplaces at most one of its columns or rows at each of up to two edges.
            assert!((odd_share(st, w) - odd / (n * n) as f32).abs() < 4.0 / n as f32);
        }
        assert_eq!(odd_share(Vec2::ZERO, Vec2::new(1.5, 0.1)), 0.5);
        assert_eq!(odd_share(Vec2::new(0.5, 1.5), Vec2::ZERO), 1.0);
        assert!(
            (odd_share(Vec2::new(0.5, 1.0), Vec2::new(0.0, 0.25)) - 0.5).abs() < 1e-6,
            "a box without width"
        );
        for nowhere in [f32::NAN, f32::INFINITY] {
            assert_eq!(odd_share(Vec2::splat(nowhere), Vec2::splat(0.1)), 0.5);
        }
        assert_eq!(odd_share(Vec2::splat(1e20), Vec2::splat(2.0)), 0.5);
    }

    #[test]
    fn cubes_use_the_ctm_itself() {
        // `Scale 4 4 1` before the texture makes cells four times smaller, not larger.
        let ctm = Transform::scale(DVec3::new(4.0, 4.0, 1.0));
        let camera = DVec3::new(0.0, 0.0, -7.0);
        let board = Checkerboard::<f32> {
            cells: Cells::Cubes(PointMap::new(&ctm.m)),
            tex1: FloatInput::Constant(1.0),
            tex2: FloatInput::Constant(0.0),
        };
        let specs = TextureSpecs::of(&[Texture::Checkerboard(board)], &[]);
        let textures = Textures::compile(
            &specs,
            &TextureUsage::new(&specs),
            &Transform::translate(-camera),
            &Budget::unlimited(),
        );
        let value = |world: DVec3| {
            let p: Vec3 = (world - camera).as_vec3();
            let at = TexturePoint {
                p,
                uv: Vec2::ZERO,
                footprint: Footprint::default(),
                face: 0,
            };
            textures
                .0
                .float(&FloatInput::Texture(FloatTextureId(0)), &at)
        };
        assert_eq!(value(DVec3::new(0.1, 0.1, 0.5)), 1.0);
        assert_eq!(value(DVec3::new(0.3, 0.1, 0.5)), 0.0);
        assert_eq!(value(DVec3::new(0.6, 0.1, 0.5)), 1.0);
    }
}
