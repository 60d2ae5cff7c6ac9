//! Measures how settings trade speed for accuracy on the user's own scene.
//!
//! The unchanged scene is rendered for a long time: its own **reference**. Then every one of the [`candidates`], which
//! vary one setting at a time, is rendered several times with different seeds, interleaved so that other load on the
//! machine affects all equally. An image's distance from the reference is its error; the part that varies from seed to
//! seed is variance, the rest bias ([`measure`]). This yields a [`recommendation`], which is rendered to verify it.

pub mod candidates;
pub mod clock;
pub(crate) mod integrators;
pub mod measure;
pub mod recommendation;
mod study;

pub use candidates::{Candidate, Setting};
pub use measure::{Estimate, Measurement};
pub use recommendation::Recommendation;
pub use study::{Settings, Study, study};
