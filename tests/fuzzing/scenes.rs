//! Scenes: from text to pixels.

use super::{grammar, project};
use fstop::build::build;
use fstop::film::FilmSpec;
use fstop::math::{Rgb, UVec2};
use fstop::render::{Progress, render};
use fstop::scene::{Frame, ReadSettings, description::SceneDescription, read_scene};
use fstop::syntax::{Diagnostics, SourceMap, Style};
use std::path::Path;

/// Most pixels of an image that is rendered here; larger ones are made smaller.
const PIXELS: u32 = 16;

/// Bytes that a scene may take: more than any small one needs, and soon used up.
const MEMORY: u64 = 256 << 20;

/// How far a text got.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Outcome {
    /// No scene, even with `--keep-going`.
    Refused,
    /// There were images.
    Rendered,
}

/// Is there something to render, be it with `--keep-going`?
fn can_be_rendered(diagnostics: &Diagnostics) -> bool {
    diagnostics.errors() == diagnostics.recoverable_errors()
}

/// Reads a text as if it stood in the file `name`, and says what it thinks of it.
fn read(name: &Path, text: &[u8], sources: &SourceMap) -> Option<SceneDescription> {
    let file = sources.add_text(&name.display().to_string(), text);
    let (scene, diagnostics) = read_scene(sources, file, &ReadSettings::default());
    diagnostics.render(sources, Style::Plain);
    can_be_rendered(&diagnostics).then_some(scene)
}

/// Reads a text as if it stood in the file `name`, and renders a few pixels of what it describes.
pub(crate) fn survive(name: &Path, text: &[u8]) -> Outcome {
    let sources = SourceMap::new();
    let frames = read(name, text, &sources).map_or(Vec::new(), |scene| scene.frames);
    let mut outcome = Outcome::Refused;
    for frame in frames.into_iter().take(2) {
        if render_a_little(frame, &sources) {
            outcome = Outcome::Rendered;
        }
    }
    outcome
}

/// Whether there is an image.
fn render_a_little(mut frame: Frame, sources: &SourceMap) -> bool {
    let options = &mut frame.options;
    options.sampler = options.sampler.clone().with_spp(1);
    options.max_memory = Some(MEMORY);
    if options.film.resolution.element_product() > PIXELS {
        options.film = FilmSpec {
            resolution: UVec2::new(4, 4),
            crop_window: [0.0, 1.0, 0.0, 1.0],
            ..options.film.clone()
        };
    }
    let (built, diagnostics) = build(frame, 0);
    diagnostics.render(sources, Style::Plain);
    let Some(built) = built.filter(|_| can_be_rendered(&diagnostics)) else {
        return false;
    };
    let image = render(&built.job, 16, false, &Progress::hidden()).image();
    let finite = |p: &Rgb| p.is_finite();
    assert!(image.pixels.iter().all(finite), "a pixel is not finite");
    true
}

/// Where texts without a file stand: among the files that the valid scenes refer to.
fn nowhere() -> std::path::PathBuf {
    project().join("tests/scenes/valid/fuzzed.pbrt")
}

/// The text of a scene as it is, with its includes.
pub(super) fn scene(text: &[u8]) {
    read(&nowhere(), text, &SourceMap::new());
}

/// The same rendered.
pub(super) fn program(text: &[u8]) {
    survive(&nowhere(), text);
}

/// The scene that the grammar makes of the bytes, rendered.
#[allow(clippy::print_stdout, reason = "a person asked for it, in a fuzzer")]
pub(super) fn grammar(bytes: &[u8]) {
    let text = grammar::scene_text(bytes);
    if std::env::var_os("FSTOP_FUZZ_SHOW").is_some() {
        println!("{text}");
    }
    survive(&nowhere(), text.as_bytes());
}
