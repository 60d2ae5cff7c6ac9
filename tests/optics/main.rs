//! The optics without a scene: golden data computed by others, the exit pupil, stops and planes, and
//! lenses at the ends of what can be written down.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a panic is an answer here"
)]

mod analysis_golden;
mod asphere_golden;
#[path = "../common/mod.rs"]
mod common;
mod files;
mod film_in_a_medium;
mod ghost_energy;
mod lens_extremes;
mod limits;
mod optics_fields;
mod optics_golden;
mod pupil;
mod realistic_camera;
mod stop_shape;
mod stops_and_planes;
