//! fstop: a renderer for pbrt-v3 scene files whose heart is a real camera.
//!
//! # Rendering a scene
//!
//! Read it, look at what was found, render, and use or write the pixels:
//!
//! ```
//! use fstop::{ReadOptions, RenderOptions, Scene, Step};
//!
//! let scene = Scene::load("scenes/cornell/cornell.pbrt", &ReadOptions::default())?;
//! eprint!("{}", scene.problems()); // warnings, each with its line; a scene with errors is an `Err`
//! let mut options = RenderOptions::default();
//! (options.spp, options.quick) = (Some(1), true);
//! let rendered = scene.render(&options, &|step| {
//!     if let Step::Samples { done, all } = step {
//!         eprint!("\r{done} of {all} samples");
//!     }
//! })?;
//! assert!(rendered.image.pixels.iter().any(|rgb| rgb.x > 0.0));
//! rendered.write(std::env::temp_dir().join("fstop-cornell.exr"))?;
//! # std::fs::remove_file(std::env::temp_dir().join("fstop-cornell.exr"))?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Before it: what memory that will take ([`Scene::forecasts`]). Meanwhile, from another thread: the image so far
//! ([`Prepared::live`]). Afterwards: the image without its noise ([`Rendered::denoised`], by a [`Denoiser`], if there is one).
//!
//! # A lens by itself
//!
//! ```
//! use fstop::glam::Vec2;
//! use fstop::optics::pupil::RINGS;
//! use fstop::optics::{ExitPupil, Lens, Prescription};
//!
//! let mut prescription = Prescription::read("lenses/dgauss.50mm.dat".as_ref())?;
//! prescription.set_stops(8.0); // mm
//! let film_distance = Lens::focused(&prescription, 2000.0)?; // sharp two meters from the film
//! let lens = Lens::new(&prescription, film_distance)?;
//!
//! // A ray from 10 mm beside the axis through the middle of the light that gets there.
//! let pupil = ExitPupil::new(&lens, 21.6, RINGS);
//! let sample = pupil.sample([10.0, 0.0], Vec2::splat(0.5)).ok_or("no light reaches this point")?;
//! let ray = lens.trace_from_film([10.0, 0.0], sample.point).map_err(|blocked| blocked.to_string())?;
//! println!("from {:?} toward {:?}", ray.o, ray.d);
//! assert!(ray.d[2] < 0.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Comparing two images
//!
//! ```
//! use fstop::compare::{Estimate, Options, Pool, compare};
//! use fstop::{ReadOptions, RenderOptions, Scene};
//!
//! let render = |seed| {
//!     let scene = Scene::load("scenes/cornell/cornell.pbrt", &ReadOptions::default())?;
//!     let mut options = RenderOptions::default();
//!     (options.spp, options.seed, options.variance) = (Some(4), seed, true);
//!     options.crop = Some([0.4, 0.6, 0.4, 0.6]);
//!     scene.render(&options, &|_| ())
//! };
//! let [a, b] = [render(1)?.image, render(2)?.image];
//! let [a, b] = [&a, &b].map(|image| Estimate { image, freedom: 2.0, pool: Some(Pool { side: 8, freedom: 1.0 }), samples: Some(4.0), light_paths: None });
//! let comparison = compare(&a, &b, &Options::default())?;
//! println!("{}", comparison.sentence());
//! assert!(comparison.agrees()); // they differ by noise only
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # The tour
//!
//! In the order that data goes, one line a folder:
//!
//! ```text
//! syntax        text to directives, each with its place in the file
//! params        one directive's parameters, with types, defaults and messages
//! scene         directives to frames: what the file describes, nothing loaded
//! assets        the files it names: meshes, images, spectra, tabulated BSDFs
//! build         frames to worlds: files loaded, shapes placed, trees built
//!   shapes, accel           what rays meet, and how it is found
//!   textures, materials     what a surface is made of ...
//!   bsdf, bssrdf, media     ... and how it scatters light
//!   lights                  where light comes from, and which light to sample
//!   world                   all of these together, frozen
//! optics        a lens from its prescription: exact rays, pupils, focus, analysis
//! cameras       from a film point to a ray; `realistic` by way of `optics`
//! samplers, filters         where in pixel, lens and path the samples fall, and what they count
//! integrators   the light along a ray
//! render        tiles over threads, passes until the error is small enough
//! film          pixels with their variances; image files
//! checkpoint    what a render has done, in a file that survives it
//! session       a scene from file to image: what a program calls
//! compare, tradeoff         do images agree; which settings are worth their time
//! suite         many scenes and one false-alarm rate: what is rendered, by whom, and compared with what
//! cli           the command line
//! ```
//!
//! Small things that all of these use are in `math`, `handles`, `inputs`, `surface`, `budget`, `files`, `output`, `console` and `pages`; `forecast` tells the memory that a
//! render will take, `denoise` calls a library where there is one.
//!
//! Dependencies point one way only (`tests/docs/dependencies.rs` finds cycles, and what `cli` must not use):
//! `cli → {tradeoff, suite} → session → {build, render} → integrators → {lights, materials, media, textures, shapes, accel, cameras, samplers} → surface → math`,
//! `cameras → optics → math`, `build → scene → params → syntax`; what is evaluated at every hit (`inputs`) is below
//! `params` and `textures` alike.
//!
//! # Errors
//!
//! One rule: what stops is a `Result`; what is said about a scene is collected (`Diagnostics` within, [`Problems`] for
//! callers), each with its place in the file, and whether it stops is the caller's [`Policy`]. `None` means that there is
//! none, never that something has been printed. Input does not panic.

// Without `internals` its private modules would be all that this lint talks of.
#![cfg_attr(not(feature = "internals"), allow(unreachable_pub))]

#[doc(hidden)]
pub mod cli;
pub mod compare;
pub mod film;
pub mod optics;
pub mod tradeoff;

mod console;

// What the renderer is made of. Tests and benchmarks see it (the feature `internals`), programs do not.
#[path = "."]
mod parts {
    pub mod accel;
    pub mod assets;
    pub mod bsdf;
    pub mod bssrdf;
    pub mod budget;
    pub mod build;
    pub mod cameras;
    pub mod checkpoint;
    pub mod denoise;
    pub mod files;
    pub mod filters;
    pub mod forecast;
    pub mod handles;
    pub mod inputs;
    pub mod integrators;
    pub mod lights;
    pub mod materials;
    pub mod math;
    pub mod media;
    pub mod output;
    pub mod pages;
    pub mod params;
    pub mod render;
    pub mod samplers;
    pub mod scene;
    pub mod session;
    pub mod shapes;
    pub mod suite;
    pub mod surface;
    pub mod syntax;
    pub mod textures;
    pub mod world;
}
#[cfg(feature = "internals")]
pub use parts::*;
#[cfg(not(feature = "internals"))]
use parts::*;

pub use cameras::Compat;
/// The vectors and matrices of the interfaces.
pub use glam;
pub use optics::models::ModelKind;
pub use params::Dialect;
pub use scene::dialect::DialectChoice;
pub use session::{
    Checkpoint, CheckpointError, DenoiseError, Denoiser, DroppedSamples, Ended, FileError,
    Forecast, Frame, Live, MemoryStage, MemoryUse, MergeError, Merged, OutputNames, Outputs,
    OverBudget, Plan, PlanError, Policy, Prepared, Problems, Process, ReadOptions, RenderOptions,
    Rendered, Scene, Shard, ShardError, ShardFile, Shards, Step, Unfinished, merge,
};
