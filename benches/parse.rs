//! How fast scenes are read, in bytes of scene text per second on one core.
//!
//! `cargo bench --bench parse`. The goal is at least 100 MB/s on the meshes.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a panic is an answer here"
)]

use divan::Bencher;
use divan::counter::BytesCount;
use fstop::syntax::{Diagnostics, Parser, SourceMap};
use std::fmt::Write as _;

fn main() {
    divan::main();
}

/// One trianglemesh: a square grid of `side` × `side` vertices, written as exporters do.
fn mesh(side: usize, digits: usize) -> String {
    let mut scene = String::from("Shape \"trianglemesh\"\n\"point P\" [\n");
    for i in 0..side * side {
        let (x, y) = (
            (i % side) as f64 / side as f64,
            (i / side) as f64 / side as f64,
        );
        let z = (x * 12.9898 + y * 78.233).sin();
        writeln!(scene, "{x:.digits$} {y:.digits$} {z:.digits$}").expect("memory");
    }
    scene += "]\n\"integer indices\" [\n";
    for i in 0..side - 1 {
        for j in 0..side - 1 {
            let v = i * side + j;
            let below = v + side;
            writeln!(
                scene,
                "{v} {} {below} {} {below} {}",
                v + 1,
                v + 1,
                below + 1
            )
            .expect("memory");
        }
    }
    scene += "]\n";
    scene
}

fn read(bencher: Bencher, scene: String) {
    bencher
        .counter(BytesCount::of_slice(&scene))
        .bench_local(|| {
            // Taking the text in is part of the work; copying it for the next round is not in a render.
            let sources = SourceMap::new();
            let file = sources.add_text("bench.pbrt", scene.as_bytes());
            let diagnostics = Diagnostics::new();
            Parser::new(&sources, file, &diagnostics).count()
        });
}

/// About 60 MB, six decimals: the short road for every number.
#[divan::bench(sample_count = 10)]
fn mesh_with_six_decimals(bencher: Bencher) {
    read(bencher, mesh(1000, 6));
}

/// About 90 MB, seventeen decimals, as `%.17g` prints: the long road for every coordinate.
#[divan::bench(sample_count = 10)]
fn mesh_with_seventeen_decimals(bencher: Bencher) {
    read(bencher, mesh(1000, 17));
}

/// A hundred thousand small statements: what a forest of instances looks like.
#[divan::bench(sample_count = 10)]
fn small_shapes(bencher: Bencher) {
    let mut scene = String::new();
    for i in 0..100_000 {
        writeln!(
            scene,
            "AttributeBegin\n  Translate {i} 0.5 -2.25\n  Material \"matte\" \"rgb Kd\" [ 0.5 0.25 0.125 ]\n  \
             Shape \"sphere\" \"float radius\" [ 1.5 ]\nAttributeEnd"
        )
        .expect("memory");
    }
    read(bencher, scene);
}
