//! Interprets the directives of a scene file (docs/scene-language.md §2): every name is resolved, every parameter read
//! and checked, but nothing loaded that only rendering needs. All problems of a file are reported in one run.

pub mod blocks;
pub mod description;
pub mod dialect;
pub mod graphics_state;
pub mod interpreter;
mod light_groups;
mod materials;
mod media;
mod names;
mod objects;
pub mod options;
pub mod reading;
pub mod scopes;
mod shapes;
pub mod transforms;
mod unused_transforms;
mod world_block;

pub use description::Frame;
pub use interpreter::{ReadSettings, read_scene};
pub use light_groups::LightGroups;
pub use names::{FocusTarget, Names};
