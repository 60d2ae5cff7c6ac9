//! The fast path: rays through the lens in single precision, many side by side.
//!
//! A ray alone waits for two divisions and two square roots at every surface; rays side by side
//! wait for them together. [`Lanes`] are a bundle of numbers that traces like one number
//! ([`super::real::Number`]): the formulas are those of [`super::trace`], compiled once, and the
//! bits are those of a single f32. [`FilmTracer`] takes bundles of film and pupil points to the scene, with the best
//! vector instructions of the processor ([`vectorize`]).
//!
//! Error: `docs/lens-precision.md`. Speed: `cargo bench --bench lens`.

mod dispatch;
mod lane;
mod sample;
mod tracer;
mod wide_lanes;

pub use dispatch::{Instructions, Kernel, vectorize};
pub use lane::{LaneMask, Lanes};
pub use sample::{PupilSamples, WeightedRays, projected_solid_angle, sample_disk, sample_pupil};
pub use tracer::{FilmTracer, Traced};

#[cfg(test)]
mod tests;
