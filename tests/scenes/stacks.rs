//! Threads need little stack, however many there are.
//!
//! rayon divides tiles by a recursion, and a thread that waits for another takes up other work on top: no level of that may hold what a
//! tile takes. With a wave's arrays in each, 2 megabytes were too few on 16 processors.

use fstop::build::build;
use fstop::render::{Progress, render};
use fstop::scene::{ReadSettings, read_scene};
use fstop::syntax::SourceMap;
use std::path::Path;

/// Enough for one tile, which takes more than half of it.
const STACK: usize = 512 << 10;

#[test]
fn many_threads_render_on_small_stacks() {
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/cornell/cornell.pbrt");
    let sources = SourceMap::new();
    let file = sources.open(&scene).expect("a scene");
    let (scene, said) = read_scene(&sources, file, &ReadSettings::default());
    assert!(!said.has_errors());
    let mut frame = scene.frames.into_iter().next().expect("a frame");
    frame.options.film.shrink(64 * 64);
    let job = build(frame, 0).0.expect("a scene without errors").job;
    let image = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let pool = pool.stack_size(STACK).build().expect("threads");
        let rendered = || render(&job, 4, true, &Progress::hidden()).image();
        pool.install(rendered).pixels
    };
    assert!(image(16) == image(1), "images do not depend on threads");
}
