//! The small files that scenes of `tests/scenes/valid` use.

use super::*;

/// The files of `tests/scenes/valid`: what they are called, and how they are written.
fn small_files() -> [(&'static str, Writer); 2] {
    // Four squares, in each of which a color prevails, and of the four numbers a texel one is alpha.
    let colors = [
        [0.8, 0.2, 0.1],
        [0.2, 0.7, 0.3],
        [0.3, 0.3, 0.9],
        [0.9, 0.8, 0.2],
    ];
    let mut squares = four(res(4, 4), |_| 0.0);
    squares.channels = 4;
    squares.alpha = 3;
    squares.samples = SampleKind::U8;
    squares.packing = Packing::Tiled(res(3, 2));
    squares.reductions = 2;
    squares.meta_data = true;
    for ((face, texels), [r, g, b]) in squares.faces.iter_mut().zip(colors) {
        *texels = [r, g, b, 1.0].repeat(face.resolution.texels());
        // A mark in the corner.
        texels[..4].copy_from_slice(&[0.0, 0.0, 0.0, 1.0]);
    }
    let at = res(3, 3);
    let mut triangles = triangle_fan(at, |i| vec![0.1 * (i + 1) as f32; at.texels()]);
    triangles.samples = SampleKind::F16;
    triangles.reductions = 1;
    triangles.faces[2].0 = triangles.faces[2].0.as_constant(false);
    // Nothing where it is a cut-out.
    triangles.faces[2].1 = vec![0.0];
    [("squares.ptx", squares), ("triangles.ptx", triangles)]
}

fn small_file(name: &str) -> std::path::PathBuf {
    std::path::Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/scenes/valid/textures")
        .join(name)
}

#[test]
fn the_small_files_are_the_writers() {
    for (name, writer) in small_files() {
        // Compressed bytes may be others one day; what they represent may not.
        let ours = format!("{:?}", file(&writer));
        let theirs =
            PtexFile::load(&small_file(name), &crate::budget::Budget::unlimited()).unwrap();
        assert_eq!(format!("{theirs:?}"), ours, "{name}");
    }
}

#[test]
#[ignore = "writes the files of tests/scenes/valid anew"]
fn write_the_small_files() {
    for (name, writer) in small_files() {
        std::fs::write(small_file(name), writer.to_bytes()).unwrap();
    }
}
