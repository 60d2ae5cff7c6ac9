//! How much memory a render will take, found without building its scene: from the headers of files and from the sizes of
//! what is made of them.
//!
//! A render goes through stages, in each of which some things are kept and others are there for a while. The peak is that
//! of the largest stage. What the process has from reading the scene's text is measured, all else is counted: `size_of`
//! what there is one of for each texel, triangle, pixel. Of what was freed, the allocator keeps small blocks.

mod images;
mod meshes;
mod process;

pub use process::Process;

use crate::accel::memory;
use crate::files::FileError;
use crate::film::{Accumulation, MEMORY_OF_SPLAT_BUFFER, pixels_encoded};
use crate::lights::{Light, MEMORY_OF_EMITTER};
use crate::render::threads_started;
use crate::scene::Frame;
use crate::scene::description::ShapeEntity;
use crate::shapes::{CompiledShape, ShapeError};
use crate::textures::Textures;
use images::Amount;
use meshes::Shapes;

/// The program when it starts, where the system does not tell, in bytes; measured.
const PROGRAM: u64 = 6 << 20;

/// Pages of code that building and rendering touch besides, in bytes; measured: a render of a sphere and 10,000 pixels
/// takes 9.3 MiB, of which the film has 1.1 and the program, having read the scene, 7.7.
const CODE: u64 = 1 << 19;

/// Pages of a thread's stack and of its part of the allocator that are touched, in bytes; measured: 16 threads take 1
/// MiB more than two.
const THREAD: u64 = 72 << 10;

/// What memory is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Use {
    /// Code, stacks.
    Program,
    /// What the scene's text was read into.
    Description,
    /// Textures, and images of lights.
    Images,
    /// Vertices, quadrics, curves.
    Shapes,
    /// Trees, and what building them takes.
    Trees,
    /// Lights that shapes form, and their tree.
    Lights,
    /// Pixels.
    Film,
}

impl Use {
    /// All of them, as they are printed.
    pub const ALL: [Use; 7] = [
        Use::Program,
        Use::Description,
        Use::Images,
        Use::Shapes,
        Use::Trees,
        Use::Lights,
        Use::Film,
    ];
}

/// What there is at one time, in bytes.
#[derive(Clone, Debug)]
pub struct Stage {
    /// When, such as `while trees are built`.
    pub when: &'static str,
    /// By use, in the order of [`Use::ALL`].
    pub bytes: [u64; 7],
}

impl Stage {
    fn new(when: &'static str, program: u64, parts: &[(Use, u64)]) -> Stage {
        let mut bytes = [0; 7];
        bytes[Use::Program as usize] = program;
        for &(part, size) in parts {
            bytes[part as usize] += size;
        }
        Stage { when, bytes }
    }

    /// All together.
    pub fn total(&self) -> u64 {
        self.bytes.iter().sum()
    }
}

/// What a render will take.
#[derive(Clone, Debug)]
pub struct Forecast {
    /// Its largest stage.
    pub peak: Stage,
    /// The same with `--variance`.
    pub with_variance: Stage,
    /// The same with `--error` or `--time`.
    pub in_passes: Stage,
}

/// The forecast for a frame whose scene was read into memory between `before` and now.
///
/// # Errors
/// A file that cannot be used, by name.
pub fn of(frame: &Frame, before: &Process) -> Result<Forecast, FileError> {
    let found = Found::of(frame, before)?;
    let peak = |bytes: [u64; 2]| {
        let rendering = found.rendering(bytes);
        let stages = found.before_rendering().into_iter().chain([rendering]);
        let peak = stages.max_by_key(Stage::total);
        peak.ok_or_else(|| FileError::from("there is nothing to render".to_string()))
    };
    let layers = frame.layers(frame.options.film.layers);
    let is_lit = found.splat_buffers > 0;
    let [without, with_variance, in_passes] = Accumulation::ALL.map(|how| {
        peak([
            how.memory_of_pixel(is_lit, layers),
            how.memory_of_file(layers),
        ])
    });
    Ok(Forecast {
        peak: without?,
        with_variance: with_variance?,
        in_passes: in_passes?,
    })
}

/// What the stages consist of, in bytes.
struct Found {
    program: u64,
    /// Growth of the process while the scene was read: at most, and afterwards.
    reading: [u64; 2],
    /// Of it, what describes no shapes, which are taken apart while they are placed.
    rest: u64,
    textures: Amount,
    light_maps: Amount,
    shapes: Shapes,
    /// Lights that shapes form, alone and while the tree is made by which they are chosen.
    lights: [u64; 2],
    pixels: u64,
    /// Pixels, each as often as it is in memory, that are encoded at a time.
    encoded: u64,
    /// What threads collect that paths from the lights bring, if any are traced: sums of it are then in each half.
    splat_buffers: u64,
    /// Of an iteration.
    photons: u64,
}

impl Found {
    fn of(frame: &Frame, before: &Process) -> Result<Found, FileError> {
        let threads = threads_started(0);
        let reading = before.growth();
        let wanted = Textures::wanted(&frame.textures);
        let need_faces = wanted.iter().any(|file| file.is_ptex);
        let shapes = meshes::survey(frame, threads, need_faces)?;
        let entities = (shapes.all * size_of::<ShapeEntity>()) as u64;
        let lights = [size_of::<Light>() as u64, MEMORY_OF_EMITTER];
        let window = frame.options.film.pixel_bounds();
        let pixels = window.area() as u64;
        Ok(Found {
            program: before.now.unwrap_or(PROGRAM) + CODE + THREAD * threads as u64,
            reading,
            rest: reading[1].saturating_sub(entities),
            textures: images::textures(&wanted, threads)?,
            light_maps: images::light_maps(&frame.lights)?,
            lights: lights.map(|bytes| bytes * shapes.emitters as u64),
            shapes,
            pixels,
            encoded: pixels_encoded(window.size(), threads),
            photons: frame.options.integrator.spec.memory(pixels),
            splat_buffers: match frame.may_trace_light() {
                true => MEMORY_OF_SPLAT_BUFFER * threads as u64,
                false => 0,
            },
        })
    }

    fn before_rendering(&self) -> [Stage; 5] {
        use Use::{Description, Images, Lights, Trees};
        let [reading, description] = self.reading.map(|bytes| (Description, bytes));
        let rest = (Description, self.rest);
        let textures = self.textures.kept;
        let images = (Images, textures + self.light_maps.kept);
        let read = (Images, textures + self.textures.passing);
        let light_maps = (Images, images.1 + self.light_maps.passing);
        let placed = (Use::Shapes, placing(&self.shapes));
        let stored = (Use::Shapes, self.shapes.stored + self.shapes.small);
        let trees = (Trees, self.shapes.trees + self.shapes.largest_tree);
        let lights = (Lights, self.lights[0]);
        let stage = |when, parts: &[(Use, u64)]| Stage::new(when, self.program, parts);
        [
            stage("while the scene is read", &[reading]),
            stage("while textures are read", &[description, read]),
            stage(
                "while images of lights are read",
                &[description, light_maps],
            ),
            stage("while shapes are placed", &[rest, images, placed, lights]),
            stage(
                "while trees are built",
                &[rest, images, stored, trees, lights],
            ),
        ]
    }

    /// With so many bytes a pixel, and so many in the file.
    fn rendering(&self, [pixel, file]: [u64; 2]) -> Stage {
        let parts = [
            (Use::Description, self.rest),
            (Use::Images, self.textures.kept + self.light_maps.kept),
            (Use::Shapes, self.shapes.stored),
            (Use::Trees, self.shapes.trees),
            (Use::Lights, self.lights[1]),
            (
                Use::Film,
                self.pixels * pixel + self.encoded * file + self.splat_buffers + self.photons,
            ),
        ];
        Stage::new("while it is rendered", self.program, &parts)
    }
}

/// Every shape as it was described, with what it becomes, before the first is put in its place: at most what meshes are
/// in double precision and once more as they are kept.
fn placing(shapes: &Shapes) -> u64 {
    let pair = size_of::<(ShapeEntity, Result<CompiledShape, ShapeError>)>();
    (shapes.all * pair) as u64 + shapes.compiled + shapes.stored.max(shapes.loading)
}

/// What trees over so many primitives take: when they are done, and while they are built.
fn tree(primitives: usize) -> [u64; 2] {
    [
        memory::TREE * primitives as u64,
        memory::building(primitives),
    ]
}
