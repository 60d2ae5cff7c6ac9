//! Writes `docs/generated/lens-precision.md`: how far single precision is from the truth, for every lens in
//! `tests/golden` and for single surfaces.
//!
//! `cargo run --release --features studies --example lens_precision`

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a panic is an answer here"
)]

use fstop::optics::lanes::{FilmTracer, Lanes};
use fstop::optics::pupil::RINGS;
use fstop::optics::{ExitPupil, Lens, LensRay, LensTracer, Prescription, Surface};
use serde_json::Value;
use std::error::Error;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// µm: a full-frame sensor of 6000 × 4000.
const PIXEL: f64 = 6.0;

/// What the issue asks of every lens, pixels.
const LIMIT: f64 = 0.02;

fn main() -> Result<(), Box<dyn Error>> {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    let mut lenses: Vec<PathBuf> = std::fs::read_dir(root.join("tests/golden"))?
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| path.extension().is_some_and(|e| e == "dat"))
        // Even aspheres, which the prescription has no room for.
        .filter(|path| path.file_stem().is_some_and(|s| s != "noct_58_f0.95"))
        .collect();
    lenses.sort();
    let mut text = INTRODUCTION.to_string();
    let mut worst: f64 = 0.0;
    for path in &lenses {
        let (row, largest) = lens_row(path)?;
        text += &row;
        worst = worst.max(largest);
    }
    write!(
        text,
        "\nWorst of all: {worst:.4} pixels; {} the limit of {LIMIT}.\n\n{SURFACES}",
        if worst < LIMIT { "within" } else { "BEYOND" }
    )?;
    for exponent in 1..=9 {
        let [ours, center] = surface_errors(10f64.powi(exponent));
        writeln!(text, "| 1e{exponent} | {ours:.2e} | {center:.2e} |")?;
    }
    std::fs::write(root.join("docs/generated/lens-precision.md"), text)?;
    Ok(())
}

/// Largest and mean square so far.
#[derive(Default)]
struct Error1 {
    max: f64,
    sum2: f64,
    count: usize,
}

impl Error1 {
    fn add(&mut self, x: f64) {
        self.max = self.max.max(x);
        self.sum2 += x * x;
        self.count += 1;
    }

    fn rms(&self) -> f64 {
        (self.sum2 / self.count.max(1) as f64).sqrt()
    }
}

/// Distances of a ray from the true one: across the true one where it leaves the lens, µm, and of the
/// directions, radians.
fn distances(ray: &LensRay<f32>, truth: &LensRay<f64>) -> (f64, f64) {
    let v: [f64; 3] = std::array::from_fn(|i| f64::from(ray.o[i]) - truth.o[i]);
    let along: f64 = (0..3).map(|i| v[i] * truth.d[i]).sum();
    let across = |i: usize| (v[i] - along * truth.d[i]).powi(2);
    let turn = |i: usize| (f64::from(ray.d[i]) - truth.d[i]).powi(2);
    (
        1e3 * (0..3).map(across).sum::<f64>().sqrt(),
        (0..3).map(turn).sum::<f64>().sqrt(),
    )
}

const LANES: usize = 16;

fn lens_row(path: &Path) -> Result<(String, f64), Box<dyn Error>> {
    let prescription = Prescription::read(path)?;
    let golden: Value =
        serde_json::from_str(&std::fs::read_to_string(path.with_extension("json"))?)?;
    let number = |key: &str| golden[key].as_f64().ok_or_else(|| format!("{key} missing"));
    let (film_radius, film_z) = (number("image_radius")?, number("film_z")?);
    let lens = Lens::new(&prescription, film_z - prescription.length())?;
    let focal_length = lens
        .paraxial()
        .cardinals
        .ok_or("afocal")?
        .focal_length
        .abs();
    // The 50-digit rays.
    let (mut position, mut direction) = (Error1::default(), Error1::default());
    for ray in golden["rays"].as_array().ok_or("no rays")? {
        let at = |i: usize| ray[i].as_f64().unwrap_or(f64::NAN);
        if ray[5] != "ok" || at(4) != 1.0 {
            continue;
        }
        let truth = LensRay {
            o: [at(7), at(8), at(9)],
            d: [at(10), at(11), at(12)],
        };
        let tracer = FilmTracer::<f32>::new(&lens, lens.length());
        let splat = |i: usize| Lanes::<8>::splat(at(i) as f32);
        let traced = tracer.trace(&[splat(0), splat(1)], &[splat(2), splat(3)]);
        let (across, turn) = distances(&traced.get(0).ok_or("blocked in f32")?, &truth);
        position.add(across);
        direction.add(turn);
    }
    // Many more against f64, which agrees with those to 1e-11 mm.
    let pupil = ExitPupil::new(&lens, film_radius, RINGS);
    let tracer = FilmTracer::<f32>::new(&lens, pupil.plane_z());
    let (mut many_position, mut many) = (Error1::default(), Error1::default());
    for bundle in 0..6250 {
        let samples: [([f64; 2], [f64; 3]); LANES] = std::array::from_fn(|i| {
            let s = |k: i32| {
                (0.5 + (bundle * LANES + i) as f64 / 1.167_303_978_261_418_7f64.powi(k)).fract()
            };
            let radius = film_radius * s(1).sqrt();
            let (sin, cos) = (std::f64::consts::TAU * s(2)).sin_cos();
            // The same numbers for both precisions.
            let round = |x: f64| f64::from(x as f32);
            let film = [round(radius * cos), round(radius * sin)];
            let u = fstop::math::Vec2::new(s(3) as f32, s(4) as f32);
            let aim = pupil.sample(film, u).map_or([f64::NAN; 3], |p| p.point);
            (film, [round(aim[0]), round(aim[1]), aim[2]])
        });
        let lane = |f: &dyn Fn(usize) -> f64| Lanes::<LANES>(std::array::from_fn(|i| f(i) as f32));
        let traced = tracer.trace(
            &[lane(&|i| samples[i].0[0]), lane(&|i| samples[i].0[1])],
            &[lane(&|i| samples[i].1[0]), lane(&|i| samples[i].1[1])],
        );
        for (i, (film, aim)) in samples.into_iter().enumerate() {
            // A ray that rounding puts on the other side of a rim is compared by nobody.
            if let (Some(ray), Ok(truth)) = (traced.get(i), lens.trace_from_film(film, aim)) {
                let (across, turn) = distances(&ray, &truth);
                many_position.add(across);
                many.add(turn);
            }
        }
    }
    let film = |angle: f64| 1e3 * focal_length * angle;
    let largest = film(many.max.max(direction.max)) / PIXEL;
    let row = format!(
        "| {} | {} | {focal_length:.0} | {:.4} / {:.4} | {:.4} / {:.4} | {:.4} / {:.4} | {:.4} / {:.4} | {:.5} / {:.5} |\n",
        path.file_stem().unwrap_or_default().to_string_lossy(),
        lens.surfaces().len(),
        position.rms(),
        position.max,
        film(direction.rms()) / PIXEL,
        film(direction.max) / PIXEL,
        many_position.rms(),
        many_position.max,
        film(many.rms()),
        film(many.max),
        film(many.rms()) / PIXEL,
        film(many.max) / PIXEL,
    );
    Ok((row, largest))
}

/// Largest error, µm, of where a ray meets one surface of this radius: our form, and the center form.
fn surface_errors(radius: f64) -> [f64; 2] {
    let surface = Surface {
        radius,
        index: 1.5,
        aperture: 2.0 * (0.8 * radius).min(20.0),
        ..Surface::default()
    };
    let exact = LensTracer::<f64>::new(&[surface]);
    let single = LensTracer::<f32>::new(&[surface]);
    let mut worst = [0.0f64; 2];
    for i in 0..200_000 {
        let s = |k: i32| 2.0 * (0.5 + i as f64 / 1.167_303_978_261_418_7f64.powi(k)).fract() - 1.0;
        let reach = 0.5 * surface.aperture;
        let from = [15.0 * s(1), 15.0 * s(2), 50.0].map(|x| x as f32);
        let to = [reach * s(3), reach * s(4), 0.0].map(|x| x as f32);
        let ray = LensRay::through(from.map(f64::from), to.map(f64::from));
        let rounded = LensRay {
            o: from,
            d: ray.d.map(|x| x as f32),
        };
        let same = LensRay {
            o: from.map(f64::from),
            d: rounded.d.map(f64::from),
        };
        let (Ok(truth), Ok(ours)) = (exact.to_scene(&same), single.to_scene(&rounded)) else {
            continue;
        };
        let distance = |o: [f32; 3]| {
            let d = |k: usize| (f64::from(o[k]) - truth.o[k]).powi(2);
            1e3 * (0..3).map(d).sum::<f64>().sqrt()
        };
        worst[0] = worst[0].max(distance(ours.o));
        if let Some(o) = center_form(&rounded, radius as f32) {
            worst[1] = worst[1].max(distance(o));
        }
    }
    worst
}

/// Where the ray meets the sphere about (0, 0, radius), by the textbook's quadratic equation with
/// its stable root: what most renderers do.
fn center_form(ray: &LensRay<f32>, radius: f32) -> Option<[f32; 3]> {
    let [x, y, z] = ray.o;
    let z = z - radius;
    let b = 2.0 * (x * ray.d[0] + y * ray.d[1] + z * ray.d[2]);
    let c = x * x + y * y + z * z - radius * radius;
    let discriminant = b * b - 4.0 * c;
    let q = -0.5 * (b + discriminant.max(0.0).sqrt().copysign(b));
    let near = |t: f32| (ray.o[2] + t * ray.d[2]).abs();
    let t = [q, c / q]
        .into_iter()
        .min_by(|a, b| near(*a).total_cmp(&near(*b)))?;
    Some(std::array::from_fn(|i| ray.o[i] + t * ray.d[i]))
}

const INTRODUCTION: &str = "# Single precision against the truth

Written by `cargo run --release --features studies --example lens_precision`. Rays from the film at infinity focus, traced in f32 lanes (which have
the bits of f32 alone). Truth: the rays of `tests/golden`, computed with 50 digits, whose start is rounded to f32
here; and 100 000 rays over the whole image circle and pupil in f64, which agrees with the former to 1e-11 mm, from
the same rounded start. `Where` is the distance between the rays at the first surface; `in the
image` is the angle between them times the focal length. Each rms / largest. Pixels of 6 µm.

| lens | rows | f mm | golden: where, µm | golden: in the image, px | where, µm | in the image, µm | in the image, px |
|---|---|---|---|---|---|---|---|
";

const SURFACES: &str = "## One surface

Largest error of where one of 200 000 rays from 50 mm away meets it, µm, up to 20 mm from the axis. Ours is the vertex
form of `src/optics/trace.rs`; the center form is a renderer's usual sphere, whose error grows with the radius.

| radius mm | vertex form | center form |
|---|---|---|
";
