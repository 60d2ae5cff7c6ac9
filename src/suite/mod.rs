//! Suites: many scenes, rendered by any program, and one false-alarm rate for all of their images.
//!
//! A [`Suite`] is read from a file. Each scene is rendered by a command line ([`Scene::command`], [`run`]) once for each seed; the renders
//! are averaged ([`merged`]) and compared with a reference, whose bytes are checked ([`Sums`]). [`compare`](crate::compare) does the
//! statistics of an image, [`Family`] shares the false-alarm rate among the images, [`spend`] among the commits. [`Plan`] says
//! how many samples it takes to find a difference.

pub mod command;
pub mod family;
pub mod file;
pub mod plan;
pub mod process;
pub mod references;
pub mod runs;
pub mod spending;
mod tables;

pub use command::{Placeholder, Values};
pub use family::Family;
pub use file::{Scene, Suite};
pub use plan::{Aim, MAX_SPP, Plan, Step};
pub use process::{RunError, last_lines, run};
pub use references::{Sums, hash};
pub use runs::{merged, metadata};
pub use spending::{Spent, spend};
