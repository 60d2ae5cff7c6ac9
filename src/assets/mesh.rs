//! Polygon meshes read from files, triangulated.

use crate::budget::Budget;
use crate::files::{self, FileError};
use crate::math::{DVec2, DVec3, Vec2, Vec3};
use std::path::Path;

/// A triangle mesh in object space. Per-vertex arrays are empty if the file has none.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshData {
    /// Three vertex indices per triangle, each below `positions.len()`.
    pub indices: Vec<[u32; 3]>,
    /// Vertex positions.
    pub positions: Vec<DVec3>,
    /// Vertex normals, of any length.
    pub normals: Vec<Vec3>,
    /// Vertex tangents.
    pub tangents: Vec<Vec3>,
    /// Texture coordinates.
    pub uv: Vec<Vec2>,
    /// For each triangle the face of the original mesh that it belongs to, for Ptex; empty if all belong to face 0.
    pub face_ids: Vec<u32>,
    /// Warnings about the file, in words.
    pub warnings: Vec<String>,
}

/// How large a mesh is, for forecasts of memory.
#[derive(Clone, Copy, Debug, Default)]
pub struct MeshExtent {
    /// Triangles, however many corners faces have.
    pub triangles: u64,
    /// Vertices.
    pub vertices: u64,
    /// `true` if it has normals.
    pub normals: bool,
    /// `true` if it has texture coordinates.
    pub uv: bool,
    /// Numbers of faces that triangles have.
    pub faces: u64,
    /// Bytes of its file.
    pub file: u64,
}

impl MeshExtent {
    /// Of a mesh in memory.
    pub fn of(mesh: &MeshData) -> MeshExtent {
        MeshExtent {
            triangles: mesh.indices.len() as u64,
            vertices: mesh.positions.len() as u64,
            normals: !mesh.normals.is_empty(),
            uv: !mesh.uv.is_empty(),
            faces: mesh.face_ids.len() as u64,
            file: 0,
        }
    }

    /// Bytes in double precision.
    pub fn compiled(&self) -> u64 {
        self.with_vertex(size_of::<DVec3>())
    }

    /// Bytes as trees refer to it.
    pub fn stored(&self) -> u64 {
        self.with_vertex(size_of::<Vec3>())
    }

    fn with_vertex(&self, position: usize) -> u64 {
        let normal = if self.normals { size_of::<Vec3>() } else { 0 };
        let uv = if self.uv { size_of::<Vec2>() } else { 0 };
        self.triangles * size_of::<[u32; 3]>() as u64
            + self.vertices * (position + normal + uv) as u64
    }
}

/// Loads the mesh at `path` with `parse`, whose error is a sentence without the file's name.
pub(super) fn load(
    path: &Path,
    budget: &Budget,
    parse: fn(&[u8], &Budget) -> Result<MeshData, String>,
) -> Result<MeshData, FileError> {
    files::read_within(path, budget)
        .map_err(|e| FileError::from(e).said(|e| format!("cannot read: {e}")))
        .and_then(|bytes| Ok(parse(&bytes, budget)?))
        .map_err(|e| e.said(|e| format!("{}: {e}", path.display())))
}

/// The face index for the number that a mesh gives; an invalid number maps to an index beyond all faces.
pub fn face_id(number: f64) -> u32 {
    match number >= 0.0 {
        // Saturates.
        true => number as u32,
        false => u32::MAX,
    }
}

/// Polygons of up to this many corners are triangulated by ear clipping, whose cost grows quadratically; larger ones as
/// fans.
const EAR_CLIPPING_LIMIT: usize = 1024;

/// Triangulates polygons: the `arities[i]` corners of polygon i follow one another in `corners`. Quads become (0,1,2)
/// (3,0,2) as in pbrt; larger polygons are triangulated by ear clipping, so that concave ones keep their outline.
/// Polygons with fewer than three corners are dropped. Every corner must be below `positions.len()`.
pub fn triangulate(arities: &[u32], corners: &[u32], positions: &[DVec3]) -> Vec<[u32; 3]> {
    let mut triangles = Vec::with_capacity(arities.len());
    let mut rest = corners;
    for &arity in arities {
        let (polygon, tail) = rest.split_at((arity as usize).min(rest.len()));
        rest = tail;
        match *polygon {
            [] | [_] | [_, _] => {}
            [a, b, c] => triangles.push([a, b, c]),
            [a, b, c, d] => triangles.extend([[a, b, c], [d, a, c]]),
            _ if polygon.len() <= EAR_CLIPPING_LIMIT => {
                clip_ears(polygon, positions, &mut triangles)
            }
            [first, ref others @ ..] => {
                triangles.extend(others.windows(2).map(|w| [first, w[0], w[1]]));
            }
        }
    }
    triangles
}

/// Ear clipping (Meisters 1975) in the plane of the polygon's mean (Newell) normal.
fn clip_ears(polygon: &[u32], positions: &[DVec3], triangles: &mut Vec<[u32; 3]>) {
    let at = |v: u32| positions[v as usize];
    let origin = at(polygon[0]);
    let normal = (0..polygon.len())
        .map(|i| {
            let next = polygon[(i + 1) % polygon.len()];
            (at(polygon[i]) - origin).cross(at(next) - origin)
        })
        .sum::<DVec3>();
    // Drop the normal's dominant axis; keep the orientation.
    let flat = |v: u32| {
        let (p, a) = (at(v) - origin, normal.abs());
        if a.x > a.y && a.x > a.z {
            DVec2::new(p.y, p.z) * DVec2::new(normal.x.signum(), 1.0)
        } else if a.y > a.z {
            DVec2::new(p.z, p.x) * DVec2::new(normal.y.signum(), 1.0)
        } else {
            DVec2::new(p.x, p.y) * DVec2::new(normal.z.signum(), 1.0)
        }
    };
    let mut left: Vec<(u32, DVec2)> = polygon.iter().map(|&v| (v, flat(v))).collect();
    while left.len() > 3 {
        let n = left.len();
        let corner = |i: usize| [left[(i + n - 1) % n], left[i], left[(i + 1) % n]];
        // A self-intersecting or degenerate polygon may have no ear: then any corner will do.
        let ear = (0..n).find(|&i| is_ear(corner(i), &left)).unwrap_or(0);
        triangles.push(corner(ear).map(|(v, _)| v));
        left.remove(ear);
    }
    triangles.push([left[0].0, left[1].0, left[2].0]);
}

/// Returns `true` if the corner turns left and no other corner of the polygon is inside its triangle.
fn is_ear([a, b, c]: [(u32, DVec2); 3], polygon: &[(u32, DVec2)]) -> bool {
    let turn = |p: DVec2, q: DVec2, r: DVec2| (q - p).perp_dot(r - p);
    if turn(a.1, b.1, c.1) <= 0.0 {
        return false;
    }
    polygon.iter().all(|&(v, p)| {
        [a.0, b.0, c.0].contains(&v)
            || turn(a.1, b.1, p) < 0.0
            || turn(b.1, c.1, p) < 0.0
            || turn(c.1, a.1, p) < 0.0
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(triangles: &[[u32; 3]], positions: &[DVec3]) -> DVec3 {
        triangles
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(|i| positions[i as usize]);
                0.5 * (b - a).cross(c - a)
            })
            .sum()
    }

    #[test]
    fn concave_polygons_keep_their_outline() {
        // An L of area 3, in three planes and both orientations.
        let outline = [
            (0.0, 0.0),
            (2.0, 0.0),
            (2.0, 1.0),
            (1.0, 1.0),
            (1.0, 2.0),
            (0.0, 2.0),
        ];
        for plane in 0..3 {
            let positions: Vec<DVec3> = outline
                .iter()
                .map(|&(x, y)| {
                    [
                        DVec3::new(x, y, 5.0),
                        DVec3::new(5.0, x, y),
                        DVec3::new(y, 5.0, x),
                    ][plane]
                })
                .collect();
            for backward in [false, true] {
                let mut corners: Vec<u32> = (0..6).collect();
                if backward {
                    corners.reverse();
                }
                let triangles = triangulate(&[6], &corners, &positions);
                assert_eq!(triangles.len(), 4);
                let sum = area(&triangles, &positions);
                // Exactly the outline: no triangle is flipped or outside.
                let separate: f64 = triangles
                    .iter()
                    .map(|&t| area(&[t], &positions).length())
                    .sum();
                assert!((sum.length() - 3.0).abs() < 1e-12 && (separate - 3.0).abs() < 1e-12);
                assert_eq!(sum.max_element() > 0.0, !backward);
            }
        }
    }

    #[test]
    fn quads_are_cut_as_pbrt_cuts_them() {
        let p = [DVec3::ZERO; 4];
        assert_eq!(
            triangulate(&[4, 2, 3], &[0, 1, 2, 3, 1, 2, 0, 2, 1], &p),
            [[0, 1, 2], [3, 0, 2], [0, 2, 1]]
        );
    }

    #[test]
    fn degenerate_and_huge_polygons_end() {
        let p = vec![DVec3::splat(f64::NAN); 2000];
        let corners: Vec<u32> = (0..2000).collect();
        assert_eq!(triangulate(&[2000], &corners, &p).len(), 1998);
        assert_eq!(triangulate(&[7], &[0; 7], &p).len(), 5);
        assert_eq!(triangulate(&[9], &[0, 1], &p).len(), 0);
    }
}
