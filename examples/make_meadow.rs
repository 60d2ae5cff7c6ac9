//! Writes the outdoor scene of `benches/peer`: hilly ground, two kinds of trees and a stone, each
//! instanced hundreds of times and textured, under an image of the sky. Too large to keep, so it is made anew.
//!
//! `cargo run --release --features studies --example make_meadow -- FOLDER`

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a panic is an answer here"
)]

use fstop::math::hash::{mix2, unit_float};
use fstop::math::{DVec2, DVec3};
use image::codecs::hdr::HdrEncoder;
use image::{ImageBuffer, Rgb, RgbImage};
use std::f64::consts::{PI, TAU};
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;

/// Copies of all objects together.
const INSTANCES: u64 = 900;

/// Half the side of the ground, scene units (meters).
const EXTENT: f64 = 60.0;

type Failure = Box<dyn std::error::Error>;

fn main() -> Result<(), Failure> {
    let folder = std::env::args_os()
        .nth(1)
        .ok_or("usage: make_meadow FOLDER")?;
    let folder = Path::new(&folder);
    std::fs::create_dir_all(folder)?;
    ground().write(&folder.join("ground.ply"))?;
    stone().write(&folder.join("stone.ply"))?;
    trunk().write(&folder.join("trunk.ply"))?;
    needles().write(&folder.join("needles.ply"))?;
    leaves().write(&folder.join("leaves.ply"))?;
    image(512, [0.20, 0.30, 0.09], [0.36, 0.40, 0.16], 24.0).save(folder.join("grass.png"))?;
    image(256, [0.36, 0.34, 0.32], [0.62, 0.60, 0.56], 9.0).save(folder.join("stone.png"))?;
    image(256, [0.22, 0.15, 0.10], [0.42, 0.31, 0.22], 17.0).save(folder.join("bark.png"))?;
    image(256, [0.08, 0.22, 0.07], [0.26, 0.44, 0.14], 13.0).save(folder.join("leaf.png"))?;
    let sky: Vec<Rgb<f32>> = (0..256)
        .flat_map(|y| (0..512).map(move |x| sky(x, y)))
        .collect();
    HdrEncoder::new(std::fs::File::create(folder.join("sky.hdr"))?).encode(&sky, 512, 256)?;
    std::fs::write(folder.join("meadow.pbrt"), scene()?)?;
    Ok(())
}

/// A number in [0, 1) of its own for each pair.
fn number(i: u64, what: u64) -> f64 {
    f64::from(unit_float(mix2(i, what)))
}

/// Smooth noise in 0…1 that repeats after `period` cells.
fn noise(p: DVec2, period: u64) -> f64 {
    let (cell, within) = (p.floor(), p - p.floor());
    let smooth = within * within * (DVec2::splat(3.0) - 2.0 * within);
    let at = |dx: f64, dy: f64| {
        let wrap = |v: f64| (v as i64).rem_euclid(period as i64) as u64;
        number(wrap(cell.x + dx) * 1013 + wrap(cell.y + dy), 99)
    };
    let low = at(0.0, 0.0) * (1.0 - smooth.x) + at(1.0, 0.0) * smooth.x;
    let high = at(0.0, 1.0) * (1.0 - smooth.x) + at(1.0, 1.0) * smooth.x;
    low * (1.0 - smooth.y) + high * smooth.y
}

/// Several octaves of noise between two colors (sRGB values), repeating at the borders.
fn image(side: u32, dark: [f64; 3], light: [f64; 3], cells: f64) -> RgbImage {
    ImageBuffer::from_fn(side, side, |x, y| {
        let p = DVec2::new(f64::from(x), f64::from(y)) / f64::from(side) * cells;
        let octave = |scale: f64| noise(p * scale, (cells * scale) as u64);
        let value = 0.5 * octave(1.0) + 0.3 * octave(2.0) + 0.2 * octave(4.0);
        Rgb([0, 1, 2].map(|c| (255.0 * (dark[c] + (light[c] - dark[c]) * value)) as u8))
    })
}

/// A gradient from horizon to zenith, some clouds, and a soft sun 40 degrees up. Row 0 is +z.
fn sky(x: u32, y: u32) -> Rgb<f32> {
    let (u, v) = ((f64::from(x) + 0.5) / 512.0, (f64::from(y) + 0.5) / 256.0);
    let (theta, phi) = (v * PI, u * TAU);
    let d = DVec3::new(
        theta.sin() * phi.cos(),
        theta.sin() * phi.sin(),
        theta.cos(),
    );
    let up = d.z.max(0.0);
    let cloud = noise(DVec2::new(u * 16.0, v * 12.0), 16) * (1.0 - up);
    let toward = DVec3::new(0.5, -0.6, 0.65).normalize().dot(d);
    let sun = 60.0 * ((toward - 1.0) * 900.0).exp();
    let below = if d.z < 0.0 { 0.3 } else { 1.0 };
    let sky = [0.55, 0.65, 0.80].map(|c| c * (1.0 - 0.45 * up) + 0.25 * cloud);
    let warm = [1.0, 0.92, 0.78];
    Rgb([0, 1, 2].map(|c| (below * sky[c] + sun * warm[c]) as f32))
}

/// Height of the ground.
fn height(x: f64, z: f64) -> f64 {
    1.2 * (0.11 * x).sin() * (0.09 * z).cos() + 0.5 * (0.31 * x + 0.23 * z).sin()
}

#[derive(Default)]
struct Mesh {
    positions: Vec<DVec3>,
    uv: Vec<DVec2>,
    faces: Vec<[u32; 3]>,
}

impl Mesh {
    /// The image of a grid of `columns` by `rows` cells over the unit square.
    fn grid(columns: u32, rows: u32, place: impl Fn(DVec2) -> DVec3) -> Mesh {
        let mut mesh = Mesh::default();
        for j in 0..=rows {
            for i in 0..=columns {
                let uv = DVec2::new(
                    f64::from(i) / f64::from(columns),
                    f64::from(j) / f64::from(rows),
                );
                mesh.positions.push(place(uv));
                mesh.uv.push(uv);
            }
        }
        for j in 0..rows {
            for i in 0..columns {
                let a = j * (columns + 1) + i;
                let b = a + columns + 1;
                mesh.faces.extend([[a, a + 1, b + 1], [a, b + 1, b]]);
            }
        }
        mesh
    }

    /// Adds a flat quad around `center`.
    fn quad(&mut self, center: DVec3, along: DVec3, across: DVec3) {
        let first = self.positions.len() as u32;
        for (s, t) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
            self.positions.push(center + along * s + across * t);
            self.uv.push(DVec2::new(0.5 + 0.5 * s, 0.5 + 0.5 * t));
        }
        self.faces
            .extend([[0, 1, 2], [0, 2, 3]].map(|f| f.map(|i| first + i)));
    }

    fn write(&self, path: &Path) -> Result<(), Failure> {
        let mut out = std::io::BufWriter::new(std::fs::File::create(path)?);
        writeln!(out, "ply\nformat binary_little_endian 1.0")?;
        writeln!(out, "element vertex {}", self.positions.len())?;
        for property in ["x", "y", "z", "u", "v"] {
            writeln!(out, "property float {property}")?;
        }
        writeln!(out, "element face {}", self.faces.len())?;
        writeln!(out, "property list uchar int vertex_indices\nend_header")?;
        for (p, uv) in self.positions.iter().zip(&self.uv) {
            for v in [p.x, p.y, p.z, uv.x, uv.y] {
                out.write_all(&(v as f32).to_le_bytes())?;
            }
        }
        for face in &self.faces {
            out.write_all(&[3])?;
            for i in face {
                out.write_all(&i.to_le_bytes())?;
            }
        }
        Ok(out.flush()?)
    }
}

fn ground() -> Mesh {
    Mesh::grid(120, 120, |uv| {
        let p = (uv * 2.0 - 1.0) * EXTENT;
        DVec3::new(p.x, height(p.x, p.y), p.y)
    })
}

fn stone() -> Mesh {
    Mesh::grid(48, 24, |uv| {
        let (theta, phi) = (uv.y * PI, uv.x * TAU);
        let d = DVec3::new(
            theta.sin() * phi.cos(),
            theta.cos(),
            theta.sin() * phi.sin(),
        );
        let bumps =
            0.12 * (5.0 * d.x).sin() * (4.0 * d.y).cos() + 0.05 * (11.0 * d.z + 7.0 * d.x).sin();
        d * DVec3::new(0.6, 0.4, 0.5) * (1.0 + bumps)
    })
}

/// A cone that tapers to the top, 3 high.
fn trunk() -> Mesh {
    Mesh::grid(16, 12, |uv| {
        let radius = 0.16 * (1.0 - 0.8 * uv.y) + 0.02 * (uv.x * 5.0 * TAU).sin() * (1.0 - uv.y);
        let phi = uv.x * TAU;
        DVec3::new(radius * phi.cos(), 3.0 * uv.y, radius * phi.sin())
    })
}

/// A point in the unit ball, a unit vector and another across it, for the `i`-th leaf.
fn placed(i: u64) -> (DVec3, DVec3, DVec3) {
    let direction = |what| {
        let z = 1.0 - 2.0 * number(i, what);
        let r = (1.0 - z * z).max(0.0).sqrt();
        let phi = TAU * number(i, what + 1);
        DVec3::new(r * phi.cos(), r * phi.sin(), z)
    };
    let p = direction(1) * number(i, 3).cbrt();
    let along = direction(4);
    (p, along, along.any_orthonormal_vector())
}

/// A conical crown of long, thin quads.
fn needles() -> Mesh {
    let mut mesh = Mesh::default();
    for i in 0..1500 {
        let (_, along, across) = placed(i);
        let (up, phi) = (number(i, 11).sqrt(), TAU * number(i, 12));
        let radius = 1.3 * up * number(i, 13).sqrt();
        let center = DVec3::new(radius * phi.cos(), 4.0 - 3.2 * up, radius * phi.sin());
        mesh.quad(center, 0.16 * along, 0.02 * across);
    }
    mesh
}

/// A round crown of small quads.
fn leaves() -> Mesh {
    let mut mesh = Mesh::default();
    for i in 0..2000 {
        let (p, along, across) = placed(5000 + i);
        mesh.quad(
            DVec3::new(0.0, 3.2, 0.0) + 1.5 * p,
            0.09 * along,
            0.06 * across,
        );
    }
    mesh
}

const HEAD: &str = "\
# Made by `cargo run --release --features studies --example make_meadow`: textured instances under an image of the sky.
LookAt 0 4.5 -24   0 2.2 0   0 1 0
Camera \"perspective\" \"float fov\" [ 42 ]
Film \"image\" \"integer xresolution\" [ 400 ] \"integer yresolution\" [ 250 ]
  \"string filename\" \"meadow.exr\" \"float scale\" [ .9 ]
Sampler \"sobol\" \"integer pixelsamples\" [ 16 ]
Integrator \"path\" \"integer maxdepth\" [ 5 ]
WorldBegin
AttributeBegin
  Rotate -90 1 0 0
  LightSource \"infinite\" \"string mapname\" \"sky.hdr\"
AttributeEnd
Texture \"grass\" \"color\" \"imagemap\" \"string filename\" \"grass.png\" \"float uscale\" [ 20 ] \"float vscale\" [ 20 ]
Texture \"stone\" \"color\" \"imagemap\" \"string filename\" \"stone.png\" \"float uscale\" [ 2 ]
Texture \"bark\" \"color\" \"imagemap\" \"string filename\" \"bark.png\" \"float vscale\" [ 4 ]
Texture \"leaf\" \"color\" \"imagemap\" \"string filename\" \"leaf.png\"
AttributeBegin
  Material \"matte\" \"texture Kd\" \"grass\"
  Shape \"plymesh\" \"string filename\" \"ground.ply\"
AttributeEnd
ObjectBegin \"fir\"
  Material \"matte\" \"texture Kd\" \"bark\"
  Shape \"plymesh\" \"string filename\" \"trunk.ply\"
  Material \"matte\" \"texture Kd\" \"leaf\"
  Shape \"plymesh\" \"string filename\" \"needles.ply\"
ObjectEnd
ObjectBegin \"oak\"
  Material \"matte\" \"texture Kd\" \"bark\"
  Shape \"plymesh\" \"string filename\" \"trunk.ply\"
  Material \"matte\" \"texture Kd\" \"leaf\"
  Shape \"plymesh\" \"string filename\" \"leaves.ply\"
ObjectEnd
ObjectBegin \"stone\"
  Material \"plastic\" \"texture Kd\" \"stone\" \"color Ks\" [ .1 .1 .1 ] \"float roughness\" [ .2 ]
  Shape \"plymesh\" \"string filename\" \"stone.ply\"
ObjectEnd
";

fn scene() -> Result<String, Failure> {
    let mut text = HEAD.to_owned();
    for i in 0..INSTANCES {
        let [x, z] = [21, 22].map(|what| (2.0 * number(i, what) - 1.0) * 0.9 * EXTENT);
        // A clearing around the camera.
        if z < -10.0 && x.abs() < 4.0 + 0.3 * (z + 24.0).abs() {
            continue;
        }
        let name = ["fir", "oak", "stone"][(i % 3) as usize];
        let size = 0.6 + 0.7 * number(i, 23);
        writeln!(
            text,
            "AttributeBegin\nTranslate {x:.3} {:.3} {z:.3}\nRotate {:.1} 0 1 0\nScale {size:.3} {size:.3} {size:.3}\nObjectInstance \"{name}\"\nAttributeEnd",
            height(x, z) - 0.05,
            360.0 * number(i, 24),
        )?;
    }
    text.push_str("WorldEnd\n");
    Ok(text)
}
