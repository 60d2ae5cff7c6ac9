//! The program `fstop` as a user runs it: its commands, what they print, and the files they write.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a panic is an answer here"
)]

mod browser;
#[cfg(unix)]
mod chaos;
mod cli;
#[path = "../common/mod.rs"]
mod common;
mod completions;
mod denoise;
mod diagnostics;
mod encoding;
mod exit_codes;
#[cfg(unix)]
mod farm;
mod files_within;
mod focusing;
mod ghosts;
mod interrupted;
mod layers;
mod lens_files;
mod lens_report;
mod light_groups;
mod light_pass;
mod live;
mod loading;
mod lost_light;
mod mattes;
mod memory_forecast;
mod memory_limit;
mod motion;
mod outputs;
mod passes;
mod photons;
mod progress;
mod shards;
mod strategies;
#[cfg(target_os = "linux")]
mod streams;
mod suites;
mod tradeoff;
#[cfg(unix)]
mod unreadable;
