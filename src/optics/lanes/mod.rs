//! The fast path: rays through the lens in single precision, many side by side.
//!
//! A ray alone waits for two divisions and two square roots at every surface; rays side by side
//! wait for them together. [`Lanes`] are a bundle of numbers that traces like one number
//! ([`super::real::Number`]): the formulas are those of [`super::trace`], compiled once, and the
//! bits are those of a single f32. [`FilmTracer`] takes bundles of film and pupil points to the scene;
//! [`super::models::LensModel::rays`] is the whole way, from film point and sample to weighted ray. Both are meant to be run
//! with the best vector instructions of the processor (`crate::math::instruction_set`).
//!
//! Error: `docs/generated/lens-precision.md`. Speed: `cargo bench --bench lens`.

mod lane;
mod tracer;

pub use lane::{DoubleMask, Doubles, LaneMask, Lanes};
pub use tracer::{FilmTracer, Landed, SceneTracer, Traced};

#[cfg(test)]
mod tests;
