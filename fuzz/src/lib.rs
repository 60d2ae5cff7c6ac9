//! The targets of `tests/fuzzing` for libFuzzer: `cargo fuzz run NAME`.

#[path = "../../tests/fuzzing/mod.rs"]
#[allow(dead_code, unused_imports)] // the tests use more of it
mod targets;

/// Gives the target of this name one input.
pub fn run(name: &str, bytes: &[u8]) {
    let target = targets::TARGETS.iter().find(|target| target.name == name);
    (target.expect("a target of tests/fuzzing").run)(bytes);
}
