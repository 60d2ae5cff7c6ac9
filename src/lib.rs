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
//! # Do two images show the same?
//!
//! ```
//! use fstop::compare::{Estimate, Options, compare};
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
//! let [a, b] = [&a, &b].map(|image| Estimate { image, freedom: 3.0, samples: Some(4.0) });
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
//! session       a scene from file to image: what a program calls
//! compare, tradeoff         do images agree; which settings are worth their time
//! cli           the command line
//! ```
//!
//! Dependencies point one way only:
//! `cli → tradeoff → session → {build, render} → integrators → {lights, materials, media, textures, shapes, accel, cameras, samplers} → surface → math`,
//! `cameras → optics → math`, `build → scene → params → syntax`; what is evaluated at every hit (`inputs`) is below
//! `params` and `textures` alike.
//!
//! # Errors
//!
//! One rule: what stops is a `Result`; what is said about a scene is collected (`Diagnostics` within, [`Problems`] for
//! callers), each with its place in the file, and whether it stops is the caller's [`Policy`]. `None` means that there is
//! none, never that something has been printed. Input does not panic.

#[doc(hidden)]
pub mod cli;
pub mod compare;
pub mod film;
pub mod optics;
pub mod tradeoff;

mod console;

// What the renderer is made of. Tests and benchmarks see it (the feature `internals`), programs do not.
#[cfg(not(feature = "internals"))]
mod accel;
#[cfg(feature = "internals")]
pub mod accel;
#[cfg(not(feature = "internals"))]
mod assets;
#[cfg(feature = "internals")]
pub mod assets;
#[cfg(not(feature = "internals"))]
mod bsdf;
#[cfg(feature = "internals")]
pub mod bsdf;
#[cfg(not(feature = "internals"))]
mod bssrdf;
#[cfg(feature = "internals")]
pub mod bssrdf;
#[cfg(not(feature = "internals"))]
mod budget;
#[cfg(feature = "internals")]
pub mod budget;
#[cfg(not(feature = "internals"))]
mod build;
#[cfg(feature = "internals")]
pub mod build;
#[cfg(not(feature = "internals"))]
mod cameras;
#[cfg(feature = "internals")]
pub mod cameras;
#[cfg(not(feature = "internals"))]
mod files;
#[cfg(feature = "internals")]
pub mod files;
#[cfg(not(feature = "internals"))]
mod filters;
#[cfg(feature = "internals")]
pub mod filters;
#[cfg(not(feature = "internals"))]
mod handles;
#[cfg(feature = "internals")]
pub mod handles;
#[cfg(not(feature = "internals"))]
mod inputs;
#[cfg(feature = "internals")]
pub mod inputs;
#[cfg(not(feature = "internals"))]
mod integrators;
#[cfg(feature = "internals")]
pub mod integrators;
#[cfg(not(feature = "internals"))]
mod lights;
#[cfg(feature = "internals")]
pub mod lights;
#[cfg(not(feature = "internals"))]
mod materials;
#[cfg(feature = "internals")]
pub mod materials;
#[cfg(not(feature = "internals"))]
mod math;
#[cfg(feature = "internals")]
pub mod math;
#[cfg(not(feature = "internals"))]
mod media;
#[cfg(feature = "internals")]
pub mod media;
#[cfg(not(feature = "internals"))]
mod output;
#[cfg(feature = "internals")]
pub mod output;
#[cfg(not(feature = "internals"))]
mod params;
#[cfg(feature = "internals")]
pub mod params;
#[cfg(not(feature = "internals"))]
mod render;
#[cfg(feature = "internals")]
pub mod render;
#[cfg(not(feature = "internals"))]
mod samplers;
#[cfg(feature = "internals")]
pub mod samplers;
#[cfg(not(feature = "internals"))]
mod scene;
#[cfg(feature = "internals")]
pub mod scene;
#[cfg(not(feature = "internals"))]
mod session;
#[cfg(feature = "internals")]
pub mod session;
#[cfg(not(feature = "internals"))]
mod shapes;
#[cfg(feature = "internals")]
pub mod shapes;
#[cfg(not(feature = "internals"))]
mod surface;
#[cfg(feature = "internals")]
pub mod surface;
#[cfg(not(feature = "internals"))]
mod syntax;
#[cfg(feature = "internals")]
pub mod syntax;
#[cfg(not(feature = "internals"))]
mod textures;
#[cfg(feature = "internals")]
pub mod textures;
#[cfg(not(feature = "internals"))]
mod world;
#[cfg(feature = "internals")]
pub mod world;

pub use cameras::Compat;
/// The vectors and matrices of the interfaces.
pub use glam;
pub use optics::models::ModelKind;
pub use params::Dialect;
pub use render::{Ended, Step};
pub use scene::dialect::DialectChoice;
pub use session::{
    DroppedSamples, Frame, OutputNames, Outputs, Policy, Prepared, Problems, ReadOptions,
    RenderOptions, Rendered, Scene,
};
