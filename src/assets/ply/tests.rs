//! PLY files as written by various programs.

use super::*;
use flate2::{Compression, write::GzEncoder};
use std::io::Write;

const HEADER: &str = "element vertex 4\nproperty float x\nproperty double y\nproperty short z\n\
    property uchar red\nproperty float nx\nproperty float ny\nproperty float nz\n\
    property float s\nproperty float t\nelement material 1\nproperty list uchar float values\n\
    element face 2\nproperty uchar flag\nproperty list uchar INDEX vertex_index\nend_header\n";

fn ascii() -> Vec<u8> {
    let mut text = format!(
        "ply\nformat ascii 1.0\ncomment caf\u{e9}\n{}",
        HEADER.replace("INDEX", "int")
    );
    text.push_str(
        "0 0 0 9 0 0 1 0 0\n1 0 0 9 0 0 1 1 0\n1 1.5 0 9 0 0 1 1 1\n0 1.5 -2 9 0 0 1 0 1\n",
    );
    text.push_str("2 0.5 0.25\n7 4 0 1 2 3\n7 3 0 1 2");
    text.into_bytes()
}

fn binary(big: bool) -> Vec<u8> {
    let kind = if big { "big" } else { "little" };
    let mut out = format!("ply\r\nformat binary_{kind}_endian 1.0\r\n").into_bytes();
    // A comment that is not UTF-8.
    out.extend(b"comment caf\xe9\n");
    out.extend(HEADER.replace("INDEX", "ushort").bytes());
    macro_rules! put {
        ($($v:expr),*) => { $( if big { out.extend($v.to_be_bytes()) } else { out.extend($v.to_le_bytes()) } )* };
    }
    for (x, y, z, u, v) in [
        (0.0f32, 0.0f64, 0i16, 0.0f32, 0.0f32),
        (1.0, 0.0, 0, 1.0, 0.0),
        (1.0, 1.5, 0, 1.0, 1.0),
        (0.0, 1.5, -2, 0.0, 1.0),
    ] {
        put!(x, y, z, 9u8, 0.0f32, 0.0f32, 1.0f32, u, v);
    }
    put!(2u8, 0.5f32, 0.25f32);
    put!(7u8, 4u8, 0u16, 1u16, 2u16, 3u16, 7u8, 3u8, 0u16, 1u16, 2u16);
    out
}

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

#[test]
fn every_encoding_gives_the_same_mesh() {
    let expected = MeshData {
        indices: vec![[0, 1, 2], [3, 0, 2], [0, 1, 2]],
        positions: vec![
            DVec3::ZERO,
            DVec3::X,
            DVec3::new(1.0, 1.5, 0.0),
            DVec3::new(0.0, 1.5, -2.0),
        ],
        normals: vec![Vec3::Z; 4],
        tangents: vec![],
        uv: vec![Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y],
        face_ids: vec![],
        warnings: vec![],
    };
    let returns = |byte: u8| if byte == b'\n' { b'\r' } else { byte };
    let old_macintosh = ascii().into_iter().map(returns).collect();
    for file in [ascii(), old_macintosh, binary(false), binary(true)] {
        assert_eq!(parse(&file).unwrap(), expected);
        assert_eq!(parse(&gzip(&file)).unwrap(), expected);
    }
}

#[test]
fn all_names_of_texture_coordinates_are_known() {
    for (u, v) in [
        ("u", "v"),
        ("s", "t"),
        ("texture_u", "texture_v"),
        ("texture_s", "texture_t"),
    ] {
        let text = format!(
            "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n\
             property float z\nproperty float {u}\nproperty float {v}\nend_header\n1 2 3 4 5\n"
        );
        assert_eq!(parse(text.as_bytes()).unwrap().uv, [Vec2::new(4.0, 5.0)]);
    }
}

#[test]
fn numbers_of_faces_are_those_of_their_triangles() {
    let read = |kind: &str, body: &str| {
        let text = format!(
            "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n\
             property float z\nelement face 3\nproperty {kind} face_indices\n\
             property list uchar int vertex_indices\nend_header\n\
             0 0 0\n1 0 0\n1 1 0\n0 1 0\n{body}"
        );
        parse(text.as_bytes()).unwrap()
    };
    let triangles = "7 3 0 1 2\n0 3 0 2 3\n5 3 1 2 3\n";
    for kind in ["int", "uchar", "double"] {
        let mesh = read(kind, triangles);
        assert_eq!((mesh.face_ids, mesh.warnings), (vec![7, 0, 5], vec![]));
    }
    let mesh = read("int", "-2 3 0 1 2\n6 4 0 1 2 3\n4 2 0 1\n");
    assert_eq!(mesh.face_ids, [u32::MAX, 6, 6]);
    assert_eq!(mesh.indices.len(), 3);
    assert!(
        mesh.warnings[0].contains("more than three corners"),
        "{:?}",
        mesh.warnings
    );
    // A list of that name has another meaning.
    let mesh = read("list uchar int", "1 9 3 0 1 2\n0 3 0 2 3\n2 1 1 3 1 2 3\n");
    assert_eq!((mesh.face_ids.len(), mesh.indices.len()), (0, 3));
}

#[test]
fn errors_say_what_is_wrong() {
    let error = |text: &str| parse(text.as_bytes()).unwrap_err();
    assert!(error("off\n").contains("not a PLY file"));
    assert!(error("ply\nformat ascii 1.0\n").contains("end_header"));
    let vertex = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n";
    assert!(error(&format!("{vertex}end_header\n1 2\n")).contains("property z"));
    let face = "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n1 2 3\n";
    assert!(error(&format!("{vertex}{face}3 0 0 7\n")).contains("vertex 7, but there are 1"));
    assert!(error(&format!("{vertex}{face}3 0 0 -1\n")).contains("vertex -1"));
    assert!(error(&format!("{vertex}{face}3 0\n")).contains("element face"));
    let wrong = error(&format!("{vertex}{face}x 0 0\n"));
    assert!(
        wrong.contains("element face") && wrong.contains("near line 11"),
        "{wrong}"
    );
    let empty = "ply\nformat ascii 1.0\nelement thing 99999999999999\nend_header\n";
    assert!(error(empty).contains("no properties"));
    let file = load(Path::new("/nowhere/at all.ply"), &Budget::unlimited())
        .unwrap_err()
        .to_string();
    assert!(file.contains("/nowhere/at all.ply") && file.contains("cannot read"));
}

#[test]
fn damaged_files_neither_panic_nor_swallow_memory() {
    // Every byte of every encoding replaced by a few revealing values, and every truncation.
    for file in [ascii(), binary(false), binary(true)] {
        for at in 0..file.len() {
            let _ = parse(&file[..at]);
            for value in [0u8, 0xff, b'9', b'-', b'\n', file[at] ^ 1] {
                let mut damaged = file.clone();
                damaged[at] = value;
                // Anything accepted is consistent.
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
    }
    let compressed = gzip(&ascii());
    for at in 0..compressed.len() {
        let mut damaged = compressed.clone();
        damaged[at] ^= 0x55;
        let _ = parse(&damaged);
    }
}

#[test]
fn huge_counts_in_small_files_are_an_error() {
    for count in ["99999999999", "18446744073709551615"] {
        let file = String::from_utf8(ascii()).unwrap();
        assert!(
            parse(
                file.replace("vertex 4", &format!("vertex {count}"))
                    .as_bytes()
            )
            .is_err()
        );
    }
    let list = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n\
        element face 1\nproperty list uint int vertex_indices\nend_header\n0 0 0\n4294967295 0 0 0\n";
    assert!(parse(list.as_bytes()).is_err());
}

/// The header of a binary file says how many triangles its faces make; a text has to be read.
#[test]
fn the_size_of_a_mesh_is_known_before_it_is_read() {
    let header = |format| {
        format!(
            "ply\nformat {format} 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty double z\n\
             property float u\nproperty float v\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n"
        )
    };
    let mut binary = header("binary_little_endian").into_bytes();
    binary.extend([0; 4 * (4 + 4 + 8 + 4 + 4)]);
    for face in [vec![0, 1, 2, 3], vec![0, 1, 2]] {
        binary.push(face.len() as u8);
        face.into_iter()
            .for_each(|i: i32| binary.extend(i.to_le_bytes()));
    }
    let vertex = "0 0 0 0 0\n".repeat(4);
    let text = header("ascii") + &vertex + "4 0 1 2 3\n3 0 1 2\n";
    let folder = tempfile::tempdir().expect("a folder");
    for (name, bytes) in [("a.ply", binary), ("b.ply", text.into_bytes())] {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).expect("a file");
        let read = load(&path, &Budget::unlimited()).expect("a mesh");
        let known = extent(&path).expect("a mesh");
        assert_eq!((known.triangles, known.vertices), (3, 4), "{name}");
        assert_eq!(known.stored(), MeshExtent::of(&read).stored(), "{name}");
    }
}
