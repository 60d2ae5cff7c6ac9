//! What the documentation says, held against the code.

mod commands;
#[path = "../common/mod.rs"]
mod common;
mod features;
mod links;
mod markdown;
