//! Measures how well one of 10,000 lights is chosen: variance times processor time for the strategies
//! `uniform`, `power` and `spatial` in three scenes made here.
//!
//! `cargo run --release --features studies --example many_lights` writes `docs/generated/light-choice.md`;
//! `cargo run --release --features studies --example many_lights -- FOLDER` writes the scenes there instead;
//! `-- build COUNT` measures the making of the choice alone, for so many lights.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a panic is an answer here"
)]
#![allow(clippy::print_stdout)]

use fstop::build::{PreparedScene, build};
use fstop::film::Image;
use fstop::lights::{LightSelector, SelectionStrategy};
use fstop::math::hash::{mix2, unit_float};
use fstop::render::{Progress, TILE_SIZE, render};
use fstop::scene::{ReadSettings, read_scene};
use fstop::syntax::SourceMap;
use std::error::Error;
use std::fmt::Write;
use std::path::Path;

const LIGHTS: u64 = 10_000;

/// Samples a pixel of one measurement.
const SPP: u32 = 64;

const STRATEGIES: [&str; 3] = ["uniform", "power", "spatial"];

const HEAD: &str = "# Choosing one of 10,000 lights: measured

Written by `cargo run --release --features studies --example many_lights`, not by hand. [Choosing lights](../light-choice.md) says what is measured,
and how.

| scene | strategy | mean | variance of a sample | µs a sample | gain over uniform |
|---|---|---|---|---|---|
";

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let scenes = [
        ("rooms", rooms(LIGHTS)),
        ("spread", spread(LIGHTS)),
        ("mesh", mesh(LIGHTS)),
    ];
    match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        [] => {
            let mut table = HEAD.to_owned();
            for (name, text) in &scenes {
                measure(name, text, &mut table)?;
            }
            print!("{table}");
            let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/generated/light-choice.md");
            std::fs::write(page, table)?;
        }
        ["build", count] => measure_build(count.parse()?)?,
        [folder] => {
            for (name, text) in &scenes {
                let path = Path::new(folder).join(name).with_extension("pbrt");
                std::fs::write(path, scene(text, "spatial", 2))?;
            }
        }
        _ => return Err("usage: many_lights [FOLDER | build COUNT]".into()),
    }
    Ok(())
}

/// Renders with every strategy; a row of the table for each.
fn measure(name: &str, text: &str, table: &mut String) -> Result<(), Box<dyn Error>> {
    // Where lights are seen their edges are most of the noise, however light is chosen.
    let (lamps, _) = picture(&scene(text, "uniform", 0))?;
    let mut uniform = None;
    for strategy in STRATEGIES {
        let (image, time) = picture(&scene(text, strategy, 2))?;
        let variances = image.variance.as_ref().ok_or("no variances")?;
        let pixels = image.pixels.iter().zip(variances).zip(&lamps.pixels);
        let lit = pixels.filter(|(_, lamp)| lamp.y == 0.0).map(|(lit, _)| lit);
        let (mut mean, mut variance, mut count) = (0.0, 0.0, 0.0);
        for (pixel, of_mean) in lit {
            mean += f64::from(pixel.y);
            variance += f64::from(of_mean.y) * f64::from(SPP);
            count += 1.0;
        }
        mean /= count;
        // Of one sample, as a part of the image's mean squared.
        variance /= count * mean * mean;
        let sample = time / (image.pixels.len() as f64 * f64::from(SPP));
        let work = variance * sample;
        let gain = *uniform.get_or_insert(work) / work;
        writeln!(
            table,
            "| {name} | {strategy} | {mean:.4} | {variance:.1} | {:.2} | {gain:.1} |",
            sample * 1e6
        )?;
    }
    Ok(())
}

/// An image, and the processor time of its rendering.
fn picture(text: &str) -> Result<(Image, f64), Box<dyn Error>> {
    let built = built(text)?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let start = seconds();
    let film = pool.install(|| render(&built.job, TILE_SIZE, true, &Progress::hidden()));
    Ok((film.image(), seconds() - start))
}

fn measure_build(count: u64) -> Result<(), Box<dyn Error>> {
    let built = built(&scene(&spread(count), "uniform", 2))?;
    let world = &built.job.world;
    let (start, memory) = (seconds(), resident());
    let selector = LightSelector::new(world.sampled_lights(), SelectionStrategy::Spatial, 100.0);
    println!(
        "{} lights: {:.2} s, {} KiB",
        world.sampled_lights().len(),
        seconds() - start,
        resident().saturating_sub(memory)
    );
    drop(selector);
    Ok(())
}

/// This process' memory, KiB; 0 where nobody says.
fn resident() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find(|line| line.starts_with("VmRSS"));
    let number = line.and_then(|line| line.split_whitespace().nth(1));
    number.and_then(|n| n.parse().ok()).unwrap_or(0)
}

/// Processor time of this process, or else the time of day.
fn seconds() -> f64 {
    /// Of the kernel's clock, on every Linux there is.
    const TICKS: f64 = 100.0;
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    // The fourteenth field; the second one, in parentheses, may have blanks.
    let after = stat.rsplit(')').next().unwrap_or_default();
    let ticks = after.split_whitespace().nth(11);
    match ticks.and_then(|t| t.parse::<f64>().ok()) {
        Some(ticks) => ticks / TICKS,
        None => std::time::UNIX_EPOCH
            .elapsed()
            .map_or(0.0, |d| d.as_secs_f64()),
    }
}

fn built(text: &str) -> Result<PreparedScene, Box<dyn Error>> {
    let sources = SourceMap::new();
    let file = sources.add_text("many_lights.pbrt", text.to_string());
    let (scene, diagnostics) = read_scene(&sources, file, &ReadSettings::default());
    if diagnostics.has_errors() {
        return Err("the scene has errors".into());
    }
    let frame = scene.frames.into_iter().next().ok_or("no frame")?;
    let (built, _) = build(frame, 1);
    built.ok_or_else(|| "the scene cannot be built".into())
}

/// A file of the world and camera in `text`.
fn scene(text: &str, strategy: &str, depth: u32) -> String {
    format!(
        "Film \"image\" \"integer xresolution\" 96 \"integer yresolution\" 64\n\
         Sampler \"random\" \"integer pixelsamples\" {SPP}\n\
         Integrator \"path\" \"integer maxdepth\" {depth} \"string lightsamplestrategy\" \"{strategy}\"\n\
         {text}WorldEnd\n"
    )
}

/// The number `k` of thing `i`, from 0 to 1.
fn random(i: u64, k: u64) -> f32 {
    unit_float(mix2(i, k))
}

fn color(i: u64) -> [f32; 3] {
    // Lamps of one building differ by a factor of 30 in power.
    let power = 30f32.powf(random(i, 10));
    [1.0, 0.5 + 0.5 * random(i, 11), 0.3 + 0.7 * random(i, 12)].map(|c| c * power)
}

/// Ten by ten rooms with doors, each with the same number of small square lights under its ceiling,
/// as one mesh; the camera stands in one of the rooms.
fn rooms(lights: u64) -> String {
    let mut text =
        "LookAt 20.5 1.6 20.5  23 1.3 23  0 1 0\nCamera \"perspective\" \"float fov\" 80\n\
        WorldBegin\nMaterial \"matte\" \"rgb Kd\" [.6 .6 .6]\n"
            .to_string();
    let each = lights / 200;
    quad(
        &mut text,
        [0.0, 0.0, 0.0],
        [40.0, 0.0, 0.0],
        [0.0, 0.0, 40.0],
    );
    quad(
        &mut text,
        [0.0, 3.0, 0.0],
        [40.0, 0.0, 0.0],
        [0.0, 0.0, 40.0],
    );
    for i in 0..=10 {
        let at = 4.0 * i as f32;
        for j in 0..10 {
            // A door of one unit in the middle of each wall.
            for start in [4.0 * j as f32, 4.0 * j as f32 + 2.5] {
                quad(
                    &mut text,
                    [at, 0.0, start],
                    [0.0, 0.0, 1.5],
                    [0.0, 3.0, 0.0],
                );
                quad(
                    &mut text,
                    [start, 0.0, at],
                    [1.5, 0.0, 0.0],
                    [0.0, 3.0, 0.0],
                );
            }
        }
    }
    for room in 0..100u64 {
        let corner = [4.0 * (room % 10) as f32, 4.0 * (room / 10) as f32];
        let [r, g, b] = color(room);
        let (mut points, mut indices) = (String::new(), String::new());
        for lamp in 0..each {
            let i = room * each + lamp;
            let [x, z] = [1, 2].map(|k| corner[k as usize - 1] + 0.2 + 3.6 * random(i, k));
            let first = 4 * lamp;
            for (dx, dz) in [(0.0, 0.0), (0.05, 0.0), (0.05, 0.05), (0.0, 0.05)] {
                points += &format!("{} 2.95 {} ", x + dx, z + dz);
            }
            let [a, b, c, d] = [0, 1, 2, 3].map(|k| first + k);
            indices += &format!("{a} {b} {c} {a} {c} {d} ");
        }
        text += &format!(
            "AttributeBegin\nAreaLightSource \"diffuse\" \"rgb L\" [{r} {g} {b}]\n\
             Shape \"trianglemesh\" \"point P\" [{points}] \"integer indices\" [{indices}]\nAttributeEnd\n"
        );
    }
    text
}

/// Small glowing balls of all strengths over a plain with blocks on it.
fn spread(lights: u64) -> String {
    let mut text = "LookAt 50 6 -3  50 0 12  0 1 0\nCamera \"perspective\" \"float fov\" 60\n\
        WorldBegin\nMaterial \"matte\" \"rgb Kd\" [.5 .5 .5]\n"
        .to_string();
    quad(
        &mut text,
        [0.0, 0.0, 0.0],
        [100.0, 0.0, 0.0],
        [0.0, 0.0, 100.0],
    );
    for i in 0..60u64 {
        let [x, z] = [3, 4].map(|k| 5.0 + 90.0 * random(i, k));
        let height = 1.0 + 3.0 * random(i, 5);
        quad(&mut text, [x, 0.0, z], [3.0, 0.0, 0.5], [0.0, height, 0.0]);
    }
    for i in 0..lights {
        let [x, z] = [1, 2].map(|k| 100.0 * random(i, k));
        let y = 0.1 + 2.0 * random(i, 6);
        let [r, g, b] = color(i);
        text += &format!(
            "AttributeBegin\nTranslate {x} {y} {z}\nAreaLightSource \"diffuse\" \"rgb L\" [{r} {g} {b}]\n\
             Shape \"sphere\" \"float radius\" .03\nAttributeEnd\n"
        );
    }
    text
}

/// One glowing mesh: a long folded ribbon over a floor.
fn mesh(lights: u64) -> String {
    let mut text = "LookAt 0 4 -9  0 1 0  0 1 0\nCamera \"perspective\" \"float fov\" 50\n\
        WorldBegin\nMaterial \"matte\" \"rgb Kd\" [.5 .5 .5]\n"
        .to_string();
    quad(
        &mut text,
        [-20.0, 0.0, -20.0],
        [40.0, 0.0, 0.0],
        [0.0, 0.0, 40.0],
    );
    let (mut points, mut indices) = (String::new(), String::new());
    for i in 0..=lights / 2 {
        let turn = i as f32 * 0.01;
        let radius = 3.0 + (turn * 0.31).sin();
        let [x, y, z] = [
            radius * turn.cos(),
            1.5 + (turn * 0.37).sin(),
            radius * turn.sin(),
        ];
        points += &format!("{x} {y} {z} {x} {} {z} ", y + 0.04);
        if i > 0 {
            let first = 2 * (i - 1);
            let [a, b, c, d] = [0, 1, 2, 3].map(|k| first + k);
            indices += &format!("{a} {b} {c} {b} {d} {c} ");
        }
    }
    text += &format!(
        "AttributeBegin\nAreaLightSource \"diffuse\" \"rgb L\" [3 2 1]\n\
         Shape \"trianglemesh\" \"point P\" [{points}] \"integer indices\" [{indices}]\nAttributeEnd\n"
    );
    text
}

/// A parallelogram.
fn quad(text: &mut String, p: [f32; 3], a: [f32; 3], b: [f32; 3]) {
    let corner = |s: f32, t: f32| {
        let at = |k: usize| p[k] + s * a[k] + t * b[k];
        format!("{} {} {} ", at(0), at(1), at(2))
    };
    *text += &format!(
        "Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point P\" [{}{}{}{}]\n",
        corner(0.0, 0.0),
        corner(1.0, 0.0),
        corner(1.0, 1.0),
        corner(0.0, 1.0)
    );
}
