//! What several test programs share.

#![allow(dead_code, reason = "each test program uses a part of it")]

pub(crate) mod golden_lenses;
pub(crate) mod program;
pub(crate) mod rendering;

/// Is a folder of the repository not here because the published package leaves it out (`exclude` of Cargo.toml)? Then the
/// test says so and is skipped. In the repository it is missing by mistake, and the test fails.
#[allow(clippy::print_stdout, reason = "a test that is skipped says so")]
pub(crate) fn is_left_out(folder: &str) -> bool {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    // Cargo keeps the manifest that was written by hand beside the one it publishes.
    let left_out = root.join("Cargo.toml.orig").exists() && !root.join(folder).exists();
    if left_out {
        println!("skipped: {folder} is not in the published package");
    }
    left_out
}
