//! `--progress`: what programs and people are told of a render.

use super::cli::{Folder, OBJECTS};
use crate::common::program::{Run, fstop};
use serde_json::Value;
use std::process::Command;

/// Three frames, two of which have small images.
const FRAMES: &str = "tests/scenes/valid/several_frames.pbrt";

/// Every line of standard error.
fn events(said: &str) -> Vec<Value> {
    let event = |line| serde_json::from_str(line).unwrap_or_else(|e| panic!("{e}: {line}"));
    said.lines().map(event).collect()
}

fn of_kind<'a>(events: &'a [Value], kind: &str) -> Vec<&'a Value> {
    events.iter().filter(|e| e["event"] == kind).collect()
}

fn render(folder: &Folder, scene: &str, options: &[&str]) -> Run {
    let image = folder.path("a.exr").display().to_string();
    let line = ["render", scene, "-o", &image, "--progress", "json"];
    fstop([&line, options].concat())
}

/// What holds for every render, whatever became of it.
fn check(run: &Run) -> Vec<Value> {
    let events = events(&run.stderr);
    let (first, last) = (&events[0], &events[events.len() - 1]);
    assert_eq!(first["event"], "start");
    assert_eq!(first["fstop"], env!("CARGO_PKG_VERSION"));
    assert_eq!(last["event"], "end");
    assert_eq!(last["code"], run.code);
    let ends = ["start", "end"].map(|kind| of_kind(&events, kind).len());
    assert_eq!(ends, [1, 1], "{}", run.stderr);
    for file in last["written"].as_array().expect("a list") {
        assert!(std::fs::exists(file.as_str().expect("a name")).expect("a folder"));
    }
    events
}

#[test]
fn samples_are_counted_until_all_are_done() {
    let folder = Folder::new();
    let started = std::time::Instant::now();
    // For longer than a second, so that the clock has to speak.
    let run = render(&folder, OBJECTS, &["--spp", "4000", "--no-checkpoint"]);
    let took = started.elapsed().as_secs_f64();
    assert_eq!(run.code, 0, "{}", run.stderr);
    let events = check(&run);
    let progress = of_kind(&events, "progress");
    assert!(
        progress.len() as f64 >= took.floor(),
        "{took} s: {}",
        run.stderr
    );
    let number = |event: &Value, name: &str| event[name].as_f64();
    for pair in progress.windows(2) {
        for name in ["done", "elapsed_s", "peak_memory_bytes"] {
            assert!(number(pair[0], name) <= number(pair[1], name), "{pair:?}");
        }
    }
    let last = progress[progress.len() - 1];
    assert_eq!(last["done"], last["total"]);
    assert!(number(last, "rate") > Some(0.0) && number(last, "left_s") == Some(0.0));
    #[cfg(target_os = "linux")]
    for name in ["memory_bytes", "peak_memory_bytes"] {
        // A program that traces rays has more than a megabyte, and this scene takes less than a gigabyte.
        let bytes = number(last, name).expect("Linux tells");
        assert!((1e6..1e9).contains(&bytes), "{name}: {bytes}");
    }
    let frames = of_kind(&events, "frame");
    assert_eq!((frames.len(), &frames[0]["frame"]), (1, &Value::from(1)));
    let image = folder.path("a.exr").display().to_string();
    assert_eq!(frames[0]["outputs"][0], image);
    assert_eq!(events[events.len() - 1]["written"][0], image);
}

#[test]
fn passes_are_told_with_their_error() {
    let folder = Folder::new();
    let run = render(&folder, OBJECTS, &["--error", "5%"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    let events = check(&run);
    let progress = of_kind(&events, "progress");
    let last = progress[progress.len() - 1];
    assert!(
        last["total"].is_null() && last["left_s"].is_null(),
        "{last}"
    );
    assert!(
        last["pass"].as_u64() >= Some(1) && last["spp"].as_f64() >= Some(1.0),
        "{last}"
    );
    assert!(last["error"].as_f64().is_some_and(|e| e <= 0.05), "{last}");
}

/// Every frame has its lines, and what goes wrong is told in the same way.
#[test]
fn frames_and_failures_are_told() {
    let folder = Folder::new();
    let run = render(&folder, FRAMES, &["--spp", "1"]);
    let events = check(&run);
    let numbers: Vec<_> = of_kind(&events, "frame")
        .iter()
        .map(|e| e["frame"].as_u64())
        .collect();
    assert_eq!(numbers, [Some(1), Some(2), Some(3)]);
    assert_eq!(
        events[events.len() - 1]["written"].as_array().map(Vec::len),
        Some(3)
    );
    for (scene, options, code) in [
        ("nowhere.pbrt", vec![], 2),
        ("tests/scenes/invalid/missing_files.pbrt", vec![], 2),
        (OBJECTS, vec!["--png", "a.gif"], 2),
        (OBJECTS, vec!["--checkpoint", "nowhere/a.fsc"], 74),
    ] {
        let run = render(&folder, scene, &options);
        assert_eq!(run.code, code, "{}", run.stderr);
        let events = check(&run);
        let messages = of_kind(&events, "message");
        assert!(
            messages.iter().any(|m| m["level"] == "error"),
            "{}",
            run.stderr
        );
    }
    // Even of a command line that is none.
    let run = render(&folder, OBJECTS, &["--nonsense"]);
    let events = events_without_start(&run);
    assert_eq!((run.code, events.len()), (2, 2), "{}", run.stderr);
    let run = Command::new(env!("CARGO_BIN_EXE_fstop"))
        .args(["render", OBJECTS, "--progress=json"])
        .env("FSTOP_PANIC", "main")
        .output()
        .expect("the program");
    let said = String::from_utf8_lossy(&run.stderr);
    let bug: Vec<Value> = said
        .lines()
        .filter_map(|l| serde_json::from_str(l).ok())
        .collect();
    assert_eq!(
        bug.last().map(|e| &e["code"]),
        Some(&Value::from(70)),
        "{said}"
    );
}

fn events_without_start(run: &Run) -> Vec<Value> {
    let events = events(&run.stderr);
    assert_eq!(events[0]["event"], "message");
    assert_eq!(events[events.len() - 1]["code"], run.code);
    events
}

/// `--quiet` is about messages, `--progress` about progress.
#[test]
fn quiet_renders_tell_only_what_is_asked_for() {
    let folder = Folder::new();
    let run = render(&folder, OBJECTS, &["--spp", "1", "--quiet"]);
    let events = check(&run);
    assert_eq!(of_kind(&events, "message").len(), 0, "{}", run.stderr);
    for form in ["none", "log", "bar"] {
        let image = folder.path("a.exr").display().to_string();
        let run = fstop([
            "render",
            OBJECTS,
            "--spp",
            "1",
            "-o",
            &image,
            "--progress",
            form,
        ]);
        assert_eq!(
            (run.code, run.stderr.contains('{')),
            (0, false),
            "{}",
            run.stderr
        );
        assert!(
            run.stderr.contains("samples a pixel"),
            "{form}: {}",
            run.stderr
        );
    }
}
