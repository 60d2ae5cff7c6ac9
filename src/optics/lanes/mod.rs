//! The fast path: rays through the lens in single precision, many side by side.
//!
//! A ray alone waits for two divisions and two square roots at every surface; rays side by side
//! wait for them together. [`Lanes`] are a bundle of numbers that traces like one number
//! ([`super::real::Number`]): the formulas are those of [`super::trace`], compiled once, and the
//! bits are those of a single f32. [`FilmTracer`] takes bundles of film and pupil points to the scene, with the best
//! vector instructions of the processor ([`vectorize`]).
//!
//! ```
//! use fstop::optics::lanes::{FilmTracer, Lanes};
//! use fstop::optics::{ExitPupil, Lens, Prescription};
//!
//! let prescription = Prescription::parse("50 5 1.5168 20\n-50 2 1 20\n0 0 0 10\n")?;
//! let lens = Lens::new(&prescription, Lens::focused(&prescription, 1000.0)?)?;
//! let pupil = ExitPupil::new(&lens, 21.6, 16);
//! // Eight rays from one film point, through eight samples of the pupil.
//! let tracer = FilmTracer::new(&lens, pupil.plane_z());
//! let film = [Lanes::splat(10.0), Lanes::splat(0.0)];
//! let u = [Lanes([0.1, 0.2, 0.3, 0.4, 0.6, 0.7, 0.8, 0.9]), Lanes::splat(0.5)];
//! let rays = tracer.rays(&pupil, &film, &u);
//! assert!(rays.traced.passed.count() > 4);
//! let middle = rays.traced.get(3).ok_or("blocked")?;
//! assert!(middle.d[2] < 0.0 && middle.d[0] < 0.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Error: `docs/generated/lens-precision.md`. Speed: `cargo bench --bench lens`.

mod dispatch;
mod lane;
mod sample;
mod tracer;
mod wide_lanes;

pub use dispatch::{Instructions, Kernel, vectorize};
pub use lane::{DoubleMask, Doubles, LaneMask, Lanes};
pub use sample::{PupilSamples, WeightedRays, projected_solid_angle, sample_disk, sample_pupil};
pub use tracer::{FilmTracer, Traced};

#[cfg(test)]
mod tests;
