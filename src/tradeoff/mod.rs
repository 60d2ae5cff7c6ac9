//! What each setting that trades speed for accuracy costs and buys, measured on the user's own scene.
//!
//! The scene is rendered for long as it stands: its own **reference**. Then, one setting turned at a
//! time, every setting of the [`candidates`] is rendered several times with different seeds, all of them by
//! turns so that a machine that is busy for a while is unfair to nobody. An image's distance from the
//! reference is error; what of it differs from seed to seed is variance, the rest bias.
//! ([`measure`]). From that a [`recommendation`] follows, which is rendered to see whether it is true.

pub mod candidates;
pub mod clock;
pub mod measure;
pub mod recommendation;
mod study;

pub use candidates::{Candidate, Setting};
pub use measure::{Estimate, Measurement};
pub use recommendation::Recommendation;
pub use study::{Settings, Study, study};
