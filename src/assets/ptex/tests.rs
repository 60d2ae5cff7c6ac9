//! Round trips of written files, and corrupt files.

use super::face::Neighbor;
use super::header::MeshKind;
use super::sample::SampleKind;
use super::writer::{Packing, Writer, halved};
use super::*;
use proptest::prelude::*;

const SAMPLES: [SampleKind; 4] = [
    SampleKind::U8,
    SampleKind::U16,
    SampleKind::F16,
    SampleKind::F32,
];

const fn res(u: u8, v: u8) -> Resolution {
    Resolution { u, v }
}

/// Values that differ from texel to texel and from face to face, within half a step of 1/255 in every sample type.
fn pattern(at: Resolution, channels: usize, seed: usize) -> Vec<f32> {
    (0..at.texels() * channels)
        .map(|i| ((i * 37 + seed * 101) % 256) as f32 / 255.0)
        .collect()
}

fn alone(at: Resolution) -> Face {
    Face::new(at, [None; 4])
}

/// The texels of a face at a resolution, as floats.
fn texels(file: &PtexFile, number: u32, at: Resolution) -> Vec<f32> {
    let face = file.face(number).unwrap();
    let range = file.position(face, at)..;
    let count = if face.is_constant() { 1 } else { at.texels() } * file.channels;
    fn values<S: Sample>(texels: &[S], count: usize) -> Vec<f32> {
        texels[..count].iter().map(|s| s.value() / S::ONE).collect()
    }
    match file.texels() {
        Texels::U8(t) => values(&t[range], count),
        Texels::U16(t) => values(&t[range], count),
        Texels::F16(t) => values(&t[range], count),
        Texels::F32(t) => values(&t[range], count),
    }
}

fn close(a: &[f32], b: &[f32], tolerance: f32) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() <= tolerance)
}

/// Faces of several sizes, one of them constant.
fn faces(mesh: MeshKind, channels: usize) -> Vec<(Face, Vec<f32>)> {
    let sizes = match mesh {
        MeshKind::Quads => [res(3, 4), res(0, 0), res(2, 2), res(5, 1), res(4, 4)],
        MeshKind::Triangles => [res(3, 3), res(0, 0), res(2, 2), res(1, 1), res(4, 4)],
    };
    let mut faces: Vec<(Face, Vec<f32>)> = sizes
        .iter()
        .enumerate()
        .map(|(i, &at)| (alone(at), pattern(at, channels, i)))
        .collect();
    let value = pattern(Resolution::ONE, channels, 77);
    faces.insert(1, (alone(res(3, 3)).as_constant(false), value));
    faces
}

#[test]
fn every_mesh_sample_and_encoding_is_read_as_written() {
    for mesh in [MeshKind::Quads, MeshKind::Triangles] {
        for samples in SAMPLES {
            for packing in [
                Packing::Zipped,
                Packing::Differences,
                Packing::Tiled(res(1, 2)),
                Packing::Tiled(res(9, 0)),
            ] {
                for channels in [1, 3] {
                    let writer = Writer {
                        mesh,
                        samples,
                        channels,
                        packing,
                        meta_data: channels == 1,
                        faces: faces(mesh, channels),
                        ..Writer::default()
                    };
                    let file = PtexFile::parse(&writer.to_bytes()).unwrap();
                    assert_eq!((file.mesh, file.channels), (mesh, channels));
                    assert_eq!(file.faces().len(), writer.faces.len());
                    for (number, (face, expected)) in (0..).zip(&writer.faces) {
                        let read = texels(&file, number, face.resolution);
                        // Half floats have 11 bits.
                        assert!(
                            close(&read, expected, 0.5 / 2048.0),
                            "{mesh:?} {samples:?} {packing:?}"
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn a_constant_block_stands_for_all_texels() {
    let writer = Writer {
        packing: Packing::Constant,
        faces: vec![(alone(res(2, 3)), vec![0.25; 32])],
        ..Writer::default()
    };
    let file = PtexFile::parse(&writer.to_bytes()).unwrap();
    assert_eq!(texels(&file, 0, res(2, 3)), [0.25; 32]);
    assert_eq!(texels(&file, 0, res(1, 3)), [0.25; 16]);
}

#[test]
fn reductions_are_means_of_what_they_reduce() {
    for (u, v) in [(3, 3), (4, 2), (0, 3), (5, 0)] {
        let full = res(u, v);
        let finest = pattern(full, 3, 5);
        let writer = Writer {
            channels: 3,
            faces: vec![(alone(full), finest.clone())],
            ..Writer::default()
        };
        let file = PtexFile::parse(&writer.to_bytes()).unwrap();
        for at in (0..=u).flat_map(|u| (0..=v).map(move |v| res(u, v))) {
            let read = texels(&file, 0, at);
            let (du, dv) = (full.width() / at.width(), full.height() / at.height());
            for (i, value) in read.iter().enumerate() {
                let (texel, c) = (i / 3, i % 3);
                let (x, y) = (texel % at.width() * du, texel / at.width() * dv);
                let block = (y..y + dv).flat_map(|y| (x..x + du).map(move |x| (x, y)));
                let sum: f32 = block
                    .map(|(x, y)| finest[(y * full.width() + x) * 3 + c])
                    .sum();
                // Sums of up to 64 values below 1, in another order.
                assert!((value - sum / (du * dv) as f32).abs() < 1e-5, "{at:?}");
            }
        }
    }
}

#[test]
fn reductions_of_triangles_are_means_of_four() {
    let full = res(4, 4);
    let mut expected = pattern(full, 1, 3);
    let writer = Writer {
        mesh: MeshKind::Triangles,
        faces: vec![(alone(full), expected.clone())],
        ..Writer::default()
    };
    let file = PtexFile::parse(&writer.to_bytes()).unwrap();
    for log2 in (1..=4).rev() {
        assert!(close(&texels(&file, 0, res(log2, log2)), &expected, 1e-6));
        expected = halved(MeshKind::Triangles, res(log2, log2), 1, &expected);
    }
}

#[test]
fn integers_are_cut_when_they_are_averaged() {
    let values = [0.0, 1.0, 1.0, 2.0, 3.0, 3.0, 3.0, 4.0].map(|v| v / 255.0);
    let writer = Writer {
        samples: SampleKind::U8,
        faces: vec![(alone(res(2, 1)), values.into())],
        ..Writer::default()
    };
    let file = PtexFile::parse(&writer.to_bytes()).unwrap();
    let numbers = |at| {
        texels(&file, 0, at)
            .into_iter()
            .map(|v| (v * 255.0).round() as u8)
    };
    // (0 + 1)/2, (1 + 2)/2, (3 + 3)/2, (3 + 4)/2.
    assert_eq!(numbers(res(1, 1)).collect::<Vec<u8>>(), [0, 1, 3, 3]);
    // (0 + 3)/2, (1 + 3)/2, (1 + 3)/2, (2 + 4)/2.
    assert_eq!(numbers(res(2, 0)).collect::<Vec<u8>>(), [1, 2, 2, 3]);
}

#[test]
fn stored_reductions_are_used_in_the_order_of_the_faces_sizes() {
    for mesh in [MeshKind::Quads, MeshKind::Triangles] {
        let mut writer = Writer {
            mesh,
            faces: faces(mesh, 1),
            reductions: 2,
            ..Writer::default()
        };
        let made = PtexFile::parse(
            &Writer {
                reductions: 0,
                ..writer.clone()
            }
            .to_bytes(),
        )
        .unwrap();
        let stored = PtexFile::parse(&writer.to_bytes()).unwrap();
        // The same values, from the right faces: each face's pattern is its own.
        for (number, (face, _)) in (0..).zip(&writer.faces) {
            for halvings in 0..=face.resolution.u.min(face.resolution.v) {
                let at = res(face.resolution.u - halvings, face.resolution.v - halvings);
                assert!(close(
                    &texels(&stored, number, at),
                    &texels(&made, number, at),
                    1e-6
                ));
            }
        }
        // Stored as constants, they are recognized as those of the file.
        writer.packing = Packing::Constant;
        let stored = PtexFile::parse(&writer.to_bytes()).unwrap();
        let half = texels(&stored, 5, res(3, 3));
        assert!(half.iter().all(|&v| v == half[0]));
        assert_ne!(half[0], texels(&stored, 5, res(4, 4))[0]);
    }
}

#[test]
fn the_smallest_reduction_is_the_files_mean() {
    let writer = Writer {
        faces: vec![
            (alone(res(1, 1)), vec![0.0, 0.0, 1.0, 0.5]),
            (alone(res(0, 0)), vec![0.75]),
        ],
        ..Writer::default()
    };
    let file = PtexFile::parse(&writer.to_bytes()).unwrap();
    assert_eq!(texels(&file, 0, Resolution::ONE), [0.375]);
    assert_eq!(texels(&file, 1, Resolution::ONE), [0.75]);
}

#[test]
fn texels_are_multiplied_by_alpha_which_is_left_out_of_four_channels() {
    // Channels, alpha and one texel; what is kept of it.
    let cases: [(usize, i32, &[f32], &[f32]); 6] = [
        (4, 3, &[1.0, 0.5, 0.25, 0.5], &[0.5, 0.25, 0.125]),
        (4, 0, &[0.5, 1.0, 0.5, 0.25], &[0.5, 0.25, 0.125]),
        // Those after it are not, unless it is the first.
        (4, 2, &[1.0, 0.5, 0.5, 0.25], &[0.5, 0.25, 0.25]),
        (2, 1, &[1.0, 0.25], &[0.25]),
        (3, 2, &[1.0, 0.5, 0.5], &[0.5, 0.25, 0.5]),
        (1, 0, &[0.5], &[0.5]),
    ];
    for (channels, alpha, texel, expected) in cases {
        for samples in [SampleKind::U16, SampleKind::F32] {
            let full = res(1, 2);
            let writer = Writer {
                channels,
                alpha,
                samples,
                reductions: 1,
                faces: vec![
                    (alone(full), texel.repeat(8)),
                    (alone(full).as_constant(false), texel.into()),
                ],
                ..Writer::default()
            };
            let file = PtexFile::parse(&writer.to_bytes()).unwrap();
            for (face, at) in [(0, full), (0, res(0, 1)), (0, res(0, 0)), (1, full)] {
                let read = texels(&file, face, at);
                // Cut to 1/65535 after rounding to it.
                assert!(close(
                    &read,
                    &expected.repeat(read.len() / expected.len()),
                    2.0 / 65535.0
                ));
            }
        }
    }
    for (channels, alpha) in [(2, -1), (4, -1), (5, 4), (0, 0)] {
        let writer = Writer {
            channels,
            alpha,
            ..Writer::default()
        };
        let message = PtexFile::parse(&writer.to_bytes()).unwrap_err();
        assert!(message.contains("channels: 1 or 3 are read"), "{message}");
    }
}

#[test]
fn edits_replace_faces_and_their_reductions() {
    let full = res(3, 3);
    let writer = Writer {
        reductions: 2,
        meta_data: true,
        faces: vec![(alone(full), vec![0.5; 64]); 3],
        edits: vec![
            (0, alone(full), vec![0.0; 64]),
            (1, alone(full).as_constant(false), vec![1.0]),
            (0, alone(res(2, 4)), vec![0.25; 64]),
            (9, alone(full), vec![0.0; 64]),
        ],
        ..Writer::default()
    };
    let file = PtexFile::parse(&writer.to_bytes()).unwrap();
    assert_eq!(texels(&file, 0, res(2, 4)), [0.25; 64]);
    assert_eq!(texels(&file, 0, res(1, 3)), [0.25; 16]);
    assert_eq!(texels(&file, 0, Resolution::ONE), [0.25]);
    assert_eq!(texels(&file, 1, full), [1.0]);
    assert_eq!(texels(&file, 2, full), [0.5; 64]);
}

#[test]
fn neighbors_borders_and_flags_are_read() {
    let ring = |a: u32, b: u32| [Some((a, 2)), None, Some((b, 3)), Some((0, 0))];
    let writer = Writer {
        borders: [1, 2],
        tangent_vectors: true,
        channels: 3,
        faces: vec![
            (Face::new(res(1, 1), ring(1, 2)), vec![0.5; 12]),
            (alone(res(1, 1)).as_subface(), vec![0.5; 12]),
            (alone(res(1, 1)).as_constant(true), vec![0.5; 3]),
        ],
        ..Writer::default()
    };
    let file = PtexFile::parse(&writer.to_bytes()).unwrap();
    assert_eq!(file.borders, [Border::Black, Border::Periodic]);
    assert!(file.tangent_vectors);
    let [first, second, third] = [0, 1, 2].map(|i| *file.face(i).unwrap());
    assert_eq!(first.neighbor(0), Some(Neighbor { face: 1, edge: 2 }));
    assert_eq!(first.neighbor(5), None);
    assert_eq!(first.neighbor(2), Some(Neighbor { face: 2, edge: 3 }));
    assert_eq!(first.neighbor(3), Some(Neighbor { face: 0, edge: 0 }));
    assert!(second.is_subface() && !first.is_subface());
    assert!(third.is_constant_around() && third.is_constant() && !second.is_constant_around());
    assert_eq!(file.face(3), None);
}

/// A file that uses every feature.
fn sample() -> Writer {
    Writer {
        samples: SampleKind::U8,
        channels: 3,
        packing: Packing::Tiled(res(2, 1)),
        reductions: 2,
        meta_data: true,
        faces: faces(MeshKind::Quads, 3),
        edits: vec![(2, alone(res(1, 1)), pattern(res(1, 1), 3, 8))],
        ..Writer::default()
    }
}

#[test]
fn what_is_wrong_is_said() {
    let good = sample().to_bytes();
    let with = |at: usize, value: u32| {
        let mut bytes = good.clone();
        bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
        PtexFile::parse(&bytes).unwrap_err()
    };
    assert!(PtexFile::parse(&good).is_ok());
    let cases = [
        (0, 7, "does not start with \"Ptex\""),
        (4, 2, "version 2"),
        (8, 2, "kind of mesh 2"),
        (12, 4, "kind of sample 4"),
        (24, 0, "no faces"),
        (24, 1 << 31, "cannot hold the"),
        (28, u32::MAX, "the file ends within its header"),
        (32, 5, "the compressed data of its face table"),
        (40, u32::MAX, "the file ends before its levels"),
        (64, 3, "border mode 3"),
    ];
    for (at, value, expected) in cases {
        let message = with(at, value);
        assert!(message.contains(expected), "{message}");
    }
    let triangles = Writer {
        mesh: MeshKind::Triangles,
        ..sample()
    };
    let message = PtexFile::parse(&triangles.to_bytes()).unwrap_err();
    assert!(
        message.contains("face 0: a triangle must be as fine"),
        "{message}"
    );
    let face = |neighbor| Face::new(res(1, 1), [Some(neighbor), None, None, None]);
    for (mesh, neighbor, expected) in [
        (MeshKind::Quads, (1, 0), "neighbor 1 does not exist"),
        (MeshKind::Triangles, (0, 3), "three edges"),
    ] {
        let writer = Writer {
            mesh,
            faces: vec![(face(neighbor), vec![0.0; 4])],
            ..Writer::default()
        };
        let message = PtexFile::parse(&writer.to_bytes()).unwrap_err();
        assert!(message.contains(expected), "{message}");
    }
    let huge = Writer {
        packing: Packing::Constant,
        faces: vec![(alone(res(16, 16)), vec![0.0])],
        ..Writer::default()
    };
    let message = PtexFile::parse(&huge.to_bytes()).unwrap_err();
    assert!(message.contains("too many texels"), "{message}");
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("faces.ptx");
    std::fs::write(&path, &good[..200]).unwrap();
    let message = PtexFile::load(&path, &Budget::unlimited())
        .unwrap_err()
        .to_string();
    assert!(message.contains("faces.ptx"), "{message}");
}

#[test]
fn truncated_files_are_errors() {
    let writer = Writer {
        edits: Vec::new(),
        meta_data: false,
        ..sample()
    };
    let good = writer.to_bytes();
    // The eight zeros at the end are for old readers.
    for end in 0..good.len() - 8 {
        assert!(PtexFile::parse(&good[..end]).is_err(), "{end}");
    }
    let edited = sample().to_bytes();
    for end in 0..edited.len() {
        let _ = PtexFile::parse(&edited[..end]);
    }
}

/// Whole files to corrupt. Compressing them again for every case took most of the time.
fn whole_files() -> &'static [Vec<u8>; 2] {
    static FILES: std::sync::OnceLock<[Vec<u8>; 2]> = std::sync::OnceLock::new();
    FILES.get_or_init(|| {
        let triangles = Writer {
            mesh: MeshKind::Triangles,
            faces: faces(MeshKind::Triangles, 1),
            reductions: 1,
            ..Writer::default()
        };
        [sample().to_bytes(), triangles.to_bytes()]
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn damaged_files_are_errors_or_textures_but_never_panics(
        which in 0usize..2,
        edits in proptest::collection::vec((any::<proptest::sample::Index>(), any::<u8>()), 1..6),
        in_header in any::<bool>(),
    ) {
        let mut bytes = whole_files()[which].clone();
        for (at, value) in edits {
            let at = at.index(if in_header { 104 } else { bytes.len() });
            bytes[at] = value;
        }
        if let Ok(file) = PtexFile::parse(&bytes) {
            for number in 0..file.faces().len() as u32 {
                let at = file.faces()[number as usize].resolution;
                prop_assert_eq!(texels(&file, number, at).len() % file.channels, 0);
            }
        }
    }
}
