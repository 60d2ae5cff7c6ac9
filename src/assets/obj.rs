//! Wavefront OBJ meshes (our extension to the scene language): all objects and groups of a file become one mesh;
//! materials are ignored.

use super::mesh::{self, MeshData, triangulate};
use crate::budget::Budget;
use crate::files::FileError;
use crate::math::{DVec3, Vec2, Vec3};
use std::path::Path;

/// Vertices and faces take at most this many times the bytes of the text they are read from.
const GROWTH: u64 = 4;

/// Loads the mesh at `path`, unless that takes more memory than is left of `budget`.
pub fn load(path: &Path, budget: &Budget) -> Result<MeshData, FileError> {
    mesh::load(path, budget, |bytes, budget| {
        let needed = (bytes.len() as u64).saturating_mul(1 + GROWTH);
        let _held = budget.hold(needed).map_err(|e| format!("the mesh {e}"))?;
        parse(bytes)
    })
}

/// Reads an OBJ file from memory; the error message omits the file's name.
pub fn parse(bytes: &[u8]) -> Result<MeshData, String> {
    let options = tobj::LoadOptions {
        // One index for position, normal and texture coordinate, as in our meshes.
        single_index: true,
        // Polygons are triangulated by our own ear clipping: the reader's fans are wrong for concave ones.
        triangulate: false,
        ignore_points: true,
        ignore_lines: true,
    };
    // Names and comments may be in any encoding, but the reader requires UTF-8.
    let text = String::from_utf8_lossy(bytes);
    check_references(&text)?;
    let no_materials = |_: &Path| Ok(Default::default());
    let (models, _) = tobj::load_obj_buf(&mut text.as_bytes(), &options, no_materials)
        .map_err(|e| e.to_string())?;
    let mut mesh = MeshData::default();
    let (mut with_normals, mut with_uv) = (true, true);
    for tobj::Model { mesh: part, .. } in models {
        let first = mesh.positions.len();
        let (points, _) = part.positions.as_chunks::<3>();
        let (normals, _) = part.normals.as_chunks::<3>();
        let (uv, _) = part.texcoords.as_chunks::<2>();
        // Corners without a normal or texture coordinate make those lists shorter, and which corners they were is
        // unknown.
        with_normals &= normals.len() == points.len();
        with_uv &= uv.len() == points.len();
        let points = points.iter().map(|&point| Vec3::from(point).as_dvec3());
        let positions: Vec<DVec3> = points.collect();
        let count = positions.len();
        if let Some(bad) = part.indices.iter().find(|&&i| i as usize >= count) {
            return Err(format!(
                "a face refers to vertex {bad}, but there are {count}"
            ));
        }
        if first + count > u32::MAX as usize {
            return Err("too many vertices".into());
        }
        let arities = if part.face_arities.is_empty() {
            vec![3; part.indices.len() / 3]
        } else {
            part.face_arities
        };
        let triangles = triangulate(&arities, &part.indices, &positions);
        mesh.indices
            .extend(triangles.iter().map(|t| t.map(|i| i + first as u32)));
        mesh.positions.extend(positions);
        mesh.normals.extend(normals.iter().map(|&n| Vec3::from(n)));
        mesh.uv.extend(uv.iter().map(|&t| Vec2::from(t)));
    }
    drop_incomplete(&mut mesh, with_normals, with_uv);
    if mesh.indices.is_empty() {
        mesh.warnings.push("the file has no triangles".into());
    }
    Ok(mesh)
}

/// Fails if a face refers back to before the first vertex, or further ahead than a file can be long: the reader
/// computes with such indices before it checks them.
fn check_references(text: &str) -> Result<(), String> {
    const KINDS: [&str; 3] = ["vertex", "texture coordinate", "normal"];
    // Counts of each kind so far.
    let mut counts = [0_i64; 3];
    for (index, line) in text.lines().enumerate() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => counts[0] += 1,
            Some("vt") => counts[1] += 1,
            Some("vn") => counts[2] += 1,
            Some("f" | "l" | "p") => {
                let parts = words.flat_map(|word| word.split('/').zip(counts).zip(KINDS));
                for ((part, count), kind) in parts {
                    // The reader rejects anything that is not a number.
                    let number: i64 = part.parse().unwrap_or(0);
                    if number < -count || number > i64::from(u32::MAX) {
                        return Err(format!(
                            "line {}: a face refers to {kind} {number}, but there are {count} so far",
                            index + 1
                        ));
                    }
                }
            }
            _ => {}
        }
    }
    Ok(())
}

/// Drops per-vertex data that some vertices lack.
fn drop_incomplete(mesh: &mut MeshData, with_normals: bool, with_uv: bool) {
    if !with_normals && !mesh.normals.is_empty() {
        mesh.warnings
            .push("some faces have no normals, so none are used".into());
    }
    if !with_uv && !mesh.uv.is_empty() {
        mesh.warnings
            .push("some faces have no texture coordinates, so none are used".into());
    }
    if !with_normals {
        mesh.normals.clear();
    }
    if !with_uv {
        mesh.uv.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = "# a roof and a wall\no roof\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\n\
        vn 0 0 1\nf 1/1/1 2/2/1 3/3/1\no wall\nf 1/1/1 2/2/1 3/3/1 4/1/1\n";

    #[test]
    fn objects_are_joined() {
        let mesh = parse(FILE.as_bytes()).unwrap();
        assert_eq!(mesh.indices, [[0, 1, 2], [3, 4, 5], [6, 3, 5]]);
        assert_eq!(
            (mesh.positions.len(), mesh.normals.len(), mesh.uv.len()),
            (7, 7, 7)
        );
        assert_eq!(mesh.positions[6], DVec3::Y);
        assert!(mesh.warnings.is_empty());
    }

    #[test]
    fn references_to_nowhere_are_errors() {
        for (face, said) in [
            (
                "-5/1/1",
                "line 13: a face refers to vertex -5, but there are 4 so far",
            ),
            ("1/-4/1", "texture coordinate -4, but there are 3 so far"),
            ("1/1/-2", "normal -2, but there are 1 so far"),
            (
                "1/9223372036854775807/1",
                "texture coordinate 9223372036854775807",
            ),
        ] {
            let file = FILE.replace(
                "f 1/1/1 2/2/1 3/3/1 4/1/1",
                &format!("f {face} 2/2/1 3/3/1"),
            );
            let error = parse(file.as_bytes()).unwrap_err();
            assert!(error.contains(said), "{error}");
        }
        let back = FILE.replace(
            "f 1/1/1 2/2/1 3/3/1 4/1/1",
            "f -4/-3/-1 -3/-2/-1 -2/-1/-1 -1/-3/-1",
        );
        assert_eq!(parse(back.as_bytes()), parse(FILE.as_bytes()));
    }

    #[test]
    fn incomplete_texture_coordinates_are_dropped() {
        let mesh = parse(FILE.replace("4/1/1", "4//1").as_bytes()).unwrap();
        assert_eq!(
            (mesh.normals.len(), mesh.uv.len(), mesh.warnings.len()),
            (7, 0, 1)
        );
    }

    #[test]
    fn concave_polygons_keep_their_outline() {
        // A fan from the first corner would cover the notch.
        let file =
            "v 1 1 0\nv 1 2 0\nv 0 2 0\nv 0 0 0\nv 2 0 0\nv 2 1 0\nv 1.5 0.5 0\nf 1 2 3 4 5 6 7\n";
        let mesh = parse(file.as_bytes()).unwrap();
        let area: f64 = mesh
            .indices
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(|i| mesh.positions[i as usize]);
                0.5 * (b - a).cross(c - a).length()
            })
            .sum();
        // The L of area 3 minus the triangle (1,1) (2,1) (1.5,0.5).
        assert!((area - 2.75).abs() < 1e-12);
    }

    #[test]
    fn damaged_files_do_not_panic() {
        for at in 0..FILE.len() {
            for value in [b'0', b'9', b'-', b'/', b'\n', b' ', 0xff] {
                let mut damaged = FILE.as_bytes().to_vec();
                damaged[at] = value;
                if let Ok(mesh) = parse(&damaged) {
                    assert!(
                        mesh.indices
                            .iter()
                            .flatten()
                            .all(|&i| (i as usize) < mesh.positions.len())
                    );
                }
            }
        }
        assert!(parse(b"v 0 0 0\nf 1 2 3\n").is_err());
        assert!(parse(b"v 0 0 0\nf 1 -5 3\n").is_err());
        assert!(parse(b"").unwrap().warnings.len() == 1);
    }
}
