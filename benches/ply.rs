//! Megabytes of PLY read in a second, of a mesh of a million triangles in three encodings.
//!
//! `cargo bench --bench ply`. Wall time of one thread; megabytes of the uncompressed file, so that
//! gzip shows what it costs.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a panic is an answer here"
)]

use divan::Bencher;
use divan::counter::BytesCount;
use flate2::Compression;
use flate2::write::GzEncoder;
use fstop::assets::ply;
use std::fmt::Write as _;
use std::io::Write as _;

fn main() {
    divan::main();
}

/// Quads along each side of a wavy square: twice its square are the triangles.
const SIDE: usize = 707;

fn header(format: &str) -> String {
    format!(
        "ply\nformat {format} 1.0\nelement vertex {}\nproperty float x\nproperty float y\n\
         property float z\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n",
        (SIDE + 1) * (SIDE + 1),
        2 * SIDE * SIDE
    )
}

fn vertices() -> impl Iterator<Item = [f32; 3]> {
    (0..(SIDE + 1) * (SIDE + 1)).map(|i| {
        let at = |k: usize| k as f32 / SIDE as f32;
        let (x, y) = (at(i % (SIDE + 1)), at(i / (SIDE + 1)));
        [x, y, 0.1 * (20.0 * x).sin() * (17.0 * y).cos()]
    })
}

fn faces() -> impl Iterator<Item = [u32; 3]> {
    (0..SIDE * SIDE).flat_map(|i| {
        let at = |dx: usize, dy: usize| (((i / SIDE) + dy) * (SIDE + 1) + i % SIDE + dx) as u32;
        [
            [at(0, 0), at(1, 0), at(1, 1)],
            [at(0, 0), at(1, 1), at(0, 1)],
        ]
    })
}

fn binary() -> Vec<u8> {
    let mut file = header("binary_little_endian").into_bytes();
    for x in vertices().flatten() {
        file.extend(x.to_le_bytes());
    }
    for face in faces() {
        file.push(3);
        for i in face {
            file.extend(i.to_le_bytes());
        }
    }
    file
}

fn ascii() -> Vec<u8> {
    let mut file = header("ascii");
    for [x, y, z] in vertices() {
        // Writing to a string does not fail.
        let _ = writeln!(file, "{x} {y} {z}");
    }
    for [a, b, c] in faces() {
        let _ = writeln!(file, "3 {a} {b} {c}");
    }
    file.into_bytes()
}

fn read(bencher: Bencher, plain: usize, file: Vec<u8>) {
    bencher
        .counter(BytesCount::new(plain))
        .bench_local(|| ply::parse(&file).expect("a mesh").indices.len());
}

#[divan::bench(sample_count = 10)]
fn binary_little_endian(bencher: Bencher) {
    let file = binary();
    read(bencher, file.len(), file);
}

#[divan::bench(sample_count = 3)]
fn ascii_text(bencher: Bencher) {
    let file = ascii();
    read(bencher, file.len(), file);
}

#[divan::bench(sample_count = 3)]
fn binary_in_gzip(bencher: Bencher) {
    let file = binary();
    let mut packed = GzEncoder::new(Vec::new(), Compression::default());
    packed.write_all(&file).expect("memory");
    read(bencher, file.len(), packed.finish().expect("memory"));
}
