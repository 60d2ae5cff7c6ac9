//! fstop: a renderer for pbrt-v3 scene files whose heart is a real camera.
//!
//! Data flows one way, and the folders are listed in that order:
//!
//! ```text
//! scene.pbrt ──▶ syntax ──▶ scene ──▶ build ──▶ render ──▶ film ──▶ image.exr
//!  text          Directive   Scene-     World      Sample     Pixels    file
//!                + span      Description (frozen)
//!                                 │ Camera ◀── optics ◀── lens.dat
//! ```
//!
//! Dependencies point one way only:
//! `cli → tradeoff → render → integrators → {lights, materials, media, textures, shapes, accel, cameras, samplers} → surface → math`,
//! `cameras → optics → math`, `scene → params → syntax`.

pub mod accel;
pub mod assets;
pub mod bsdf;
pub mod bssrdf;
pub mod budget;
pub mod build;
pub mod cameras;
pub mod cli;
pub mod compare;
pub(crate) mod console;
pub mod files;
pub mod film;
pub mod filters;
pub mod handles;
pub mod integrators;
pub mod lights;
pub mod materials;
pub mod math;
pub mod media;
pub mod optics;
pub mod output;
pub mod params;
#[cfg(target_arch = "x86_64")]
mod processor;
pub mod render;
pub mod samplers;
pub mod scene;
pub mod session;
pub mod shapes;
pub mod surface;
pub mod syntax;
pub mod textures;
pub mod tradeoff;
pub mod world;
