//! Whole scenes: what is rendered, against pbrt-v3's images, the course's, laws of light, and the
//! messages recorded beside each scene file.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a panic is an answer here"
)]

mod caustic_through_lens;
mod census;
mod census_sppm;
#[path = "../common/mod.rs"]
mod common;
mod compatibility;
mod corpus;
mod course;
mod fourier;
#[path = "../fuzzing/mod.rs"]
mod fuzzing;
mod ghosts;
mod laws;
mod measured;
mod mixed_interiors;
mod null_boundaries;
mod ptex;
mod references;
mod rough_interiors;
mod stacks;
mod tables;
mod volumes;
mod watertight;
