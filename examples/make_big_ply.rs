//! Writes a large binary PLY mesh and a scene that shows it, to see what loading, building and
//! rendering take:
//!
//! ```text
//! cargo run --release --features studies --example make_big_ply -- DIR [MILLIONS OF TRIANGLES, default 10]
//! /usr/bin/time -v fstop render DIR/big.pbrt -o DIR/big.exr
//! ```
//!
//! "Maximum resident set size" is the memory; `docs/performance.md` holds what was measured.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a panic is an answer here"
)]
#![allow(clippy::print_stdout, clippy::print_stderr)]

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

const SCENE: &str = r#"LookAt 0 -2.2 1.1  0 0 0  0 0 1
Camera "perspective" "float fov" [40]
Film "image" "integer xresolution" [320] "integer yresolution" [200] "string filename" ["big.exr"]
Sampler "halton" "integer pixelsamples" [4]
Integrator "path" "integer maxdepth" [3]
WorldBegin
LightSource "infinite" "rgb L" [1 1 1]
Material "matte" "rgb Kd" [0.6 0.5 0.4]
Shape "plymesh" "string filename" ["big.ply"]
WorldEnd
"#;

fn main() -> io::Result<()> {
    let mut words = std::env::args().skip(1);
    let Some(folder) = words.next().map(PathBuf::from) else {
        eprintln!("make_big_ply DIR [MILLIONS OF TRIANGLES]");
        std::process::exit(2);
    };
    let millions = words.next().and_then(|n| n.parse().ok()).unwrap_or(10.0f64);
    std::fs::create_dir_all(&folder)?;
    std::fs::write(folder.join("big.pbrt"), SCENE)?;
    // Two triangles for every square of a grid.
    let side = (millions * 1e6 / 2.0).max(1.0).sqrt().ceil() as u32;
    write_waves(&folder.join("big.ply"), side)?;
    println!(
        "{}: {} triangles",
        folder.display(),
        2 * u64::from(side).pow(2)
    );
    Ok(())
}

/// A square from −1 to 1 with waves on it, `side` squares along each edge.
fn write_waves(path: &Path, side: u32) -> io::Result<()> {
    let mut file = BufWriter::new(File::create(path)?);
    let around = side + 1;
    write!(
        file,
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\n\
         property float y\nproperty float z\nelement face {}\n\
         property list uchar int vertex_indices\nend_header\n",
        u64::from(around).pow(2),
        2 * u64::from(side).pow(2)
    )?;
    for j in 0..around {
        for i in 0..around {
            let at = |k: u32| 2.0 * k as f32 / side as f32 - 1.0;
            let (x, y) = (at(i), at(j));
            let z = 0.05 * (17.0 * x).sin() * (13.0 * y).cos() + 0.005 * (160.0 * x * y).sin();
            for v in [x, y, z] {
                file.write_all(&v.to_le_bytes())?;
            }
        }
    }
    for j in 0..side {
        for i in 0..side {
            let corner = j * around + i;
            let [a, b, c, d] = [corner, corner + 1, corner + around + 1, corner + around];
            for face in [[a, b, c], [a, c, d]] {
                file.write_all(&[3])?;
                for v in face {
                    file.write_all(&v.to_le_bytes())?;
                }
            }
        }
    }
    file.flush()
}
