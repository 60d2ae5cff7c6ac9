//! `Shape "trianglemesh"`: triangles given in the scene file.
//!
//! | parameter | default | meaning |
//! |---|---|---|
//! | `integer indices` | required | three vertex numbers a triangle; one or two left over are dropped |
//! | `point3 P` | required | vertices |
//! | `normal N` | none | normals at the vertices |
//! | `vector3 S` | none | tangents at the vertices |
//! | `float uv`, else `st` | (0,0) (1,0) (1,1) at the corners | texture coordinates |
//! | `texture/float alpha`, `shadowalpha` | 1 | cut-outs: no surface where exactly 0 |
//! | `bool discarddegenerateUVs` | false | pbrt-v2 only: no uv where those of a triangle coincide |
//! | `integer faceIndices` | none: all 0 | for each triangle its face in `ptex` textures |
//!
//! Arrays of the wrong length are reported and left out (docs/scene-language.md §3.7).

use super::site::{ShapeType, Site};
use super::{CompiledShape, ShapeError, needed, triples};
use crate::assets::mesh::{MeshData, face_id};
use crate::math::{DVec3, Vec2, Vec3};
use crate::params::ParamReader;

/// See the module.
#[derive(Clone, Debug, PartialEq)]
pub struct TriangleMeshSpec {
    /// The triangles, object space.
    pub data: MeshData,
}

impl TriangleMeshSpec {
    /// Reads the parameters; `None` where vertices or indices are missing or wrong (reported).
    pub fn from_params(reader: &ParamReader) -> Option<TriangleMeshSpec> {
        let normals = reader.normals("N");
        let tangents = reader.vectors3("S");
        let uv_name = if reader.has("uv") { "uv" } else { "st" };
        let uv = reader.points2(uv_name);
        // Its default leaves all as it is.
        let discard = reader.boolean("discarddegenerateUVs", false);
        let faces = reader.integers("faceIndices");
        let (positions, indices) = vertices_and_triangles(reader)?;
        let per_vertex = |name: &str, values: Option<&[f64]>| -> Vec<Vec3> {
            let values = listed(reader, name, values);
            let (given, vertices) = (values.len() / 3, positions.len());
            if !values.is_empty() && given != vertices {
                let plural = if given == 1 { "" } else { "s" };
                let message =
                    format!("`{name}` has {given} value{plural} for {vertices} vertices: not used");
                match values.get(3 * vertices) {
                    Some(_) => reader.error_item(name, 3 * vertices, message),
                    None => reader.error(name, message),
                }
                return Vec::new();
            }
            triples(values).map(|v| v.as_vec3()).collect()
        };
        let mut data = MeshData {
            face_ids: face_ids(reader, faces, indices.len()),
            indices,
            normals: per_vertex("N", normals),
            tangents: per_vertex("S", tangents),
            uv: texture_coordinates(reader, uv_name, uv, positions.len()),
            positions,
            warnings: Vec::new(),
        };
        if discard && !data.normals.is_empty() && has_degenerate_uv(&data) {
            reader.warn(
                "discarddegenerateUVs",
                "the texture coordinates of a triangle coincide: none of the mesh are used",
            );
            data.uv.clear();
        }
        Some(TriangleMeshSpec { data })
    }
}

impl ShapeType for TriangleMeshSpec {
    fn compile(&self, site: &Site) -> Result<CompiledShape, ShapeError> {
        site.charge(self.data.indices.len())?;
        Ok(site.mesh(self.data.clone()))
    }
}

/// Returns `true` if a triangle that has an area (above 1e-7 in pbrt-v2, twice that here: of the parallelogram) has two
/// corners with the same texture coordinates.
fn has_degenerate_uv(data: &MeshData) -> bool {
    let at = |i: u32| Some((*data.positions.get(i as usize)?, *data.uv.get(i as usize)?));
    data.indices.iter().any(|&[a, b, c]| {
        let Some(((p, s), ((q, t), (r, u)))) = at(a).zip(at(b).zip(at(c))) else {
            return false;
        };
        (p - q).cross(r - q).length() >= 2e-7 && (s == t || t == u || u == s)
    })
}

/// Reads `point3 P` and `integer indices`; `None` where they are missing or wrong (reported).
pub(super) fn vertices_and_triangles(reader: &ParamReader) -> Option<(Vec<DVec3>, Vec<[u32; 3]>)> {
    let (points, indices) = (reader.points3("P"), reader.integers("indices"));
    let kind = reader.kind();
    let message = format!("a {kind} needs vertices: \"point3 P\"");
    let points = needed(reader, "P", points, message)?;
    let message = format!("a {kind} needs \"integer indices\"");
    let indices = needed(reader, "indices", indices, message)?;
    let positions: Vec<DVec3> = triples(points).collect();
    if indices.len() % 3 != 0 {
        reader.warn(
            "indices",
            "the number of indices is no multiple of 3: the last ones are dropped",
        );
    }
    match check_indices(indices, positions.len()) {
        Ok(indices) => Some((positions, indices)),
        Err((item, message)) => {
            reader.error_item("indices", item, message);
            None
        }
    }
}

/// Triangles from a flat list of numbers, truncated to integers as pbrt does. An error tells which
/// number is wrong.
fn check_indices(indices: &[f64], vertices: usize) -> Result<Vec<[u32; 3]>, (usize, String)> {
    let limit = vertices.min(u32::MAX as usize);
    let valid = |&i: &f64| i.trunc() >= 0.0 && i.trunc() < limit as f64;
    if let Some((item, bad)) = indices.iter().enumerate().find(|(_, i)| !valid(i)) {
        return Err((
            item,
            format!("vertex {bad} does not exist: there are {vertices} vertices, numbered from 0"),
        ));
    }
    let (triangles, _) = indices.as_chunks::<3>();
    Ok(triangles.iter().map(|t| t.map(|i| i as u32)).collect())
}

/// The numbers of a parameter, none if it is not given. Exporters write empty lists where a mesh has no normals or
/// texture coordinates: no more than a warning then, although pbrt-v3 calls it an error as it continues.
fn listed<'a>(reader: &ParamReader, name: &str, given: Option<&'a [f64]>) -> &'a [f64] {
    if given.is_some_and(<[f64]>::is_empty) {
        let message = format!("`{name}` is an empty list: as if it were not given");
        reader.warn(name, message);
    }
    given.unwrap_or_default()
}

/// One a triangle: any other number of them is dropped with an error, as in pbrt-v3.
fn face_ids(reader: &ParamReader, ids: Option<&[f64]>, triangles: usize) -> Vec<u32> {
    let name = "faceIndices";
    let ids = listed(reader, name, ids);
    if !ids.is_empty() && ids.len() != triangles {
        let message = format!(
            "`{name}` has {} value{} for {triangles} triangles: not used",
            ids.len(),
            if ids.len() == 1 { "" } else { "s" },
        );
        reader.error(name, message);
        return Vec::new();
    }
    ids.iter().map(|id| face_id(id.trunc())).collect()
}

/// One pair a vertex: too few are dropped with an error, too many cut with a warning.
fn texture_coordinates(
    reader: &ParamReader,
    name: &str,
    values: Option<&[f64]>,
    vertices: usize,
) -> Vec<Vec2> {
    let values = listed(reader, name, values);
    let pairs = values.len() / 2;
    if !values.is_empty() && pairs < vertices {
        reader.error(
            name,
            format!("{pairs} texture coordinates for {vertices} vertices: they are not used"),
        );
        return Vec::new();
    }
    if pairs > vertices {
        reader.warn_item(
            name,
            2 * vertices,
            format!(
                "{pairs} texture coordinates for {vertices} vertices: the last ones are not used"
            ),
        );
    }
    let narrow = |&[u, v]: &[f64; 2]| Vec2::new(u as f32, v as f32);
    let (pairs, _) = values.as_chunks::<2>();
    pairs.iter().take(vertices).map(narrow).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::params::testing::read;

    #[test]
    fn faces_are_numbered_triangle_by_triangle() {
        let mesh = |faces: &str| {
            let text = format!(
                "\"integer indices\" [0 1 2 0 1 2] \"point P\" [0 0 0 1 0 0 1 1 0] {faces}"
            );
            let outcome = read("trianglemesh", &text, TriangleMeshSpec::from_params);
            (outcome.value.unwrap().data.face_ids, outcome.messages)
        };
        let none = Vec::<u32>::new();
        assert_eq!(mesh(""), (none.clone(), vec![]));
        assert_eq!(mesh("\"integer faceIndices\" [7 3]").0, [7, 3]);
        // What cannot be a face's number is beyond all of them.
        assert_eq!(mesh("\"integer faceIndices\" [-1 0]").0, [u32::MAX, 0]);
        for faces in ["[1]", "[1 2 3]"] {
            let (ids, messages) = mesh(&format!("\"integer faceIndices\" {faces}"));
            assert_eq!(ids, none);
            assert!(
                messages[0].contains("for 2 triangles: not used"),
                "{messages:?}"
            );
        }
        assert!(mesh("\"integer faceIndices\" []").1[0].contains("empty list"));
    }

    #[test]
    fn indices_out_of_range_are_refused() {
        assert_eq!(
            check_indices(&[0.0, 1.0, 2.0, 2.0], 3).unwrap(),
            [[0, 1, 2]]
        );
        assert!(
            check_indices(&[0.0, 1.0, 3.0], 3)
                .is_err_and(|(item, message)| item == 2 && message.contains("vertex 3"))
        );
        assert!(
            check_indices(&[0.0, -1.0, 2.0], 3)
                .is_err_and(|(item, message)| item == 1 && message.contains("vertex -1"))
        );
        assert!(check_indices(&[0.0, f64::NAN, 2.0], 3).is_err());
        // −0.5 truncates to 0.
        assert!(check_indices(&[0.0, -0.5, 2.0], 3).is_ok());
        assert!(check_indices(&[0.0, 0.0, 1e300], 3).is_err());
    }
}
