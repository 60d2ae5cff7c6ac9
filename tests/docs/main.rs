//! What the documentation says, held against the code.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a panic is an answer here"
)]

mod commands;
#[path = "../common/mod.rs"]
mod common;
mod dependencies;
mod features;
mod links;
mod markdown;
mod mutants;
mod v2;
mod words;
