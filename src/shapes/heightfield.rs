//! `Shape "heightfield"`: heights over a grid of the unit square, as flat triangles.
//!
//! | parameter | default | meaning |
//! |---|---|---|
//! | `integer nu`, `nv` | required | points in x and in y, at least 2 |
//! | `float Pz` | required | nu · nv heights, x fastest |
//!
//! (u, v) = (x, y) from 0 to 1; the normal points up (docs/scene-language.md §3.7; Pharr and Humphreys 2004,
//! §3, exercise 1). pbrt-v3 aborts where numbers are missing; here that is an error.

use super::site::{ShapeType, Site};
use super::{CompiledShape, ShapeError, grid, left_out, needed};
use crate::assets::mesh::MeshData;
use crate::math::{DVec2, DVec3};
use crate::params::ParamReader;

/// See the module.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightfieldSpec {
    /// Points in x, at least 2.
    pub columns: u32,
    /// Points in y, at least 2.
    pub rows: u32,
    /// `columns · rows` heights, x fastest, object units.
    pub heights: Vec<f64>,
}

impl HeightfieldSpec {
    /// Reads the parameters; `None` where heights are missing or are not as many as the grid has
    /// points (reported).
    pub fn from_params(reader: &ParamReader) -> Option<HeightfieldSpec> {
        let side = |name: &str| {
            let message = format!("a heightfield needs \"integer {name}\"");
            let count = needed(reader, name, reader.find_integer(name), message)?;
            if count < 2 {
                let message =
                    format!("`{name}` is {count}: a heightfield has at least 2 points a side");
                reader.error(name, message);
                return None;
            }
            Some(count)
        };
        let (columns, rows, heights) = (side("nu"), side("nv"), reader.floats("Pz"));
        let heights = needed(reader, "Pz", heights, "a heightfield needs \"float Pz\"");
        let (columns, rows, heights) = (columns?, rows?, heights?);
        if columns.checked_mul(rows) != i64::try_from(heights.len()).ok() {
            let given = heights.len();
            let why = format_args!("`Pz` has {given} heights for {columns} × {rows} points");
            return left_out(reader, "Pz", why);
        }
        Some(HeightfieldSpec {
            columns: u32::try_from(columns).ok()?,
            rows: u32::try_from(rows).ok()?,
            heights: heights.to_vec(),
        })
    }

    /// The mesh.
    pub fn mesh(&self) -> MeshData {
        let last = DVec2::new(f64::from(self.columns - 1), f64::from(self.rows - 1));
        let at =
            |i: u32| DVec2::new(f64::from(i % self.columns), f64::from(i / self.columns)) / last;
        let heights = self.heights.iter().zip(0..);
        let positions: Vec<DVec3> = heights.map(|(&z, i)| at(i).extend(z)).collect();
        MeshData {
            indices: grid::triangles(self.columns, self.rows),
            uv: positions.iter().map(|p| p.truncate().as_vec2()).collect(),
            positions,
            ..MeshData::default()
        }
    }
}

impl ShapeType for HeightfieldSpec {
    fn compile(&self, site: &Site) -> Result<CompiledShape, ShapeError> {
        site.charge(2 * self.heights.len())?;
        Ok(site.mesh(self.mesh()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec2;
    use crate::params::testing::read;

    fn reading(params: &str) -> crate::params::testing::Outcome<Option<HeightfieldSpec>> {
        read("heightfield", params, HeightfieldSpec::from_params)
    }

    #[test]
    fn points_are_on_the_unit_square_under_their_heights() {
        let field = reading("\"integer nu\" 3 \"integer nv\" 2 \"float Pz\" [0 1 2 3 4 5]");
        assert!(field.messages.is_empty());
        let mesh = field.value.unwrap().mesh();
        assert_eq!(mesh.positions[1], DVec3::new(0.5, 0.0, 1.0));
        assert_eq!(mesh.positions[5], DVec3::new(1.0, 1.0, 5.0));
        assert_eq!(mesh.uv[4], Vec2::new(0.5, 1.0));
        // All of the square is covered, by triangles that turn left.
        let turn = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|i| mesh.positions[i as usize].truncate());
            (b - a).perp_dot(c - a)
        };
        assert!(mesh.indices.iter().all(|t| turn(t) > 0.0));
        assert_eq!(mesh.indices.iter().map(turn).sum::<f64>(), 2.0);
    }

    #[test]
    fn missing_and_surplus_numbers_are_errors() {
        for params in [
            "",
            "\"integer nu\" 2 \"integer nv\" 2",
            "\"integer nu\" 2 \"float Pz\" [0 0 0 0]",
            "\"integer nu\" 2 \"integer nv\" 2 \"float Pz\" [0 0 0]",
            "\"integer nu\" 2 \"integer nv\" 2 \"float Pz\" [0 0 0 0 0]",
            "\"integer nu\" 1 \"integer nv\" 4 \"float Pz\" [0 0 0 0]",
            "\"integer nu\" -2 \"integer nv\" -2 \"float Pz\" [0 0 0 0]",
            "\"integer nu\" 4611686018427387904 \"integer nv\" 4 \"float Pz\" [0]",
        ] {
            let outcome = reading(params);
            assert!(outcome.value.is_none() && outcome.errors > 0, "{params}");
        }
    }
}
