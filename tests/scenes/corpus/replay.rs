//! What the fuzzers found, as plain tests: every file of `fuzz/corpus` and `fuzz/regressions` goes through
//! the target that it was found for, and so does what each starts from.

use super::mutation::Dice;
use super::watch::{trouble, under_watch};
use crate::fuzzing::{Outcome, TARGETS, Target, files, project, scene_text, survive};
use std::path::{Path, PathBuf};

/// The files that a target starts from.
fn seeds(target: &Target) -> Vec<PathBuf> {
    let mut seeds = Vec::new();
    for (folder, endings) in target.seeds {
        let ends = |path: &PathBuf| {
            let ending = path.extension().and_then(|ending| ending.to_str());
            endings.contains(&ending.unwrap_or_default())
        };
        let found = files(&project().join(folder));
        seeds.extend(found.into_iter().filter(ends));
    }
    seeds
}

/// All files for a target; the scenes of the project are rendered by tests of their own.
fn inputs(target: &Target) -> Vec<PathBuf> {
    let stored = |kind| files(&project().join("fuzz").join(kind).join(target.name));
    let mut inputs = [stored("corpus"), stored("regressions")].concat();
    if !["program", "scene"].contains(&target.name) {
        inputs.extend(seeds(target));
    }
    inputs
}

#[test]
fn what_was_found_is_survived() {
    under_watch(|report| {
        let mut troubles = Vec::new();
        for target in &TARGETS {
            for path in inputs(target) {
                let what = format!("{} {}", target.name, path.display());
                report(&what);
                let bytes = std::fs::read(&path).expect("a readable file");
                let found = trouble(|| (target.run)(&bytes));
                troubles.extend(found.map(|message| format!("{what}: {message}")));
            }
        }
        troubles
    });
}

/// Each target has something to start from or to go on from, and a program in `fuzz/`.
#[test]
fn every_target_can_run() {
    if crate::common::is_left_out("fuzz") {
        return;
    }
    let manifest = std::fs::read_to_string(project().join("fuzz/Cargo.toml")).expect("fuzz/");
    for target in &TARGETS {
        let name = target.name;
        assert!(
            !inputs(target).is_empty() || !seeds(target).is_empty(),
            "{name}"
        );
        let source = format!("targets/{name}.rs");
        assert!(manifest.contains(&format!("path = \"{source}\"")), "{name}");
        let source = std::fs::read_to_string(project().join("fuzz").join(source)).expect(name);
        assert!(
            source.contains(&format!("run(\"{name}\", bytes)")),
            "{name}"
        );
    }
}

/// The grammar is of use only where its scenes get past the parser: of random bytes most make an image.
#[test]
fn most_scenes_of_the_grammar_render() {
    const SCENES: u64 = 300;
    let mut rendered = 0;
    for i in 0..SCENES {
        let mut dice = Dice::new(i);
        let bytes: Vec<u8> = (0..2000).map(|_| dice.below(256) as u8).collect();
        let text = scene_text(&bytes);
        let name = Path::new("tests/scenes/valid/fuzzed.pbrt");
        rendered += u64::from(survive(name, text.as_bytes()) == Outcome::Rendered);
    }
    assert!(2 * rendered > SCENES, "{rendered} of {SCENES}");
}
