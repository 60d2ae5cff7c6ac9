//! The sample loop allocates nothing: an image with four times the samples makes exactly as many
//! allocations, whatever the scene is made of.
//!
//! Images are rendered on the test's own thread, and an allocator counts what that thread asks for.
//! What is left are allocations for each image and each tile (its pixels); one that a single sample
//! made would show, for a tile of 16 × 16 pixels takes hundreds of them.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a panic is an answer here"
)]

use fstop::build::{PreparedScene, build, reset};
use fstop::render::{Progress, RenderJob, TILE_SIZE, render};
use fstop::samplers::Sampler;
use fstop::scene::options::Options;
use fstop::scene::{ReadSettings, read_scene};
use fstop::syntax::SourceMap;
use fstop::tradeoff::candidates::{Setting, candidates};
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// The system's allocator, counting on each thread.
struct Counting;

thread_local! {
    /// Calls of this thread that asked for memory. Constant at the start and without a destructor, so
    /// that reading it allocates nothing.
    static CALLS: Cell<u64> = const { Cell::new(0) };
}

fn count() {
    CALLS.with(|calls| calls.set(calls.get() + 1));
}

// SAFETY: every call goes to the system's allocator unchanged; counting touches no memory but a
// thread-local number that needs neither allocation nor destruction.
#[expect(unsafe_code, reason = "nothing else counts what a thread asks for")]
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count();
        // SAFETY: the caller's promises about `layout` are the system allocator's conditions.
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        count();
        // SAFETY: as for `alloc`.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn realloc(&self, block: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count();
        // SAFETY: `block` came from the system's allocator with this layout, as all do here; the rest
        // is the caller's promise.
        unsafe { System.realloc(block, layout, size) }
    }

    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        // SAFETY: `block` came from the system's allocator with this layout, as all do here.
        unsafe { System.dealloc(block, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Allocations that this thread makes in `work`.
fn allocations(work: impl FnOnce()) -> u64 {
    let before = CALLS.get();
    work();
    CALLS.get() - before
}

/// Samples a pixel of the short image; the long one has four times as many.
const FEW: u32 = 2;

/// Pixels of an image: several tiles, one of them not full.
const PIXELS: u32 = 24 * 24;

/// Allocations of an image with few and with many samples of the same job.
fn few_and_many(job: &mut RenderJob, options: &Options) -> [u64; 2] {
    let mut take = |spp: u32| {
        job.sampler = Sampler::new(&options.sampler.clone().with_spp(spp), 1);
        allocations(|| drop(render(job, TILE_SIZE, false, &Progress::hidden())))
    };
    // What is made on first use, such as a thread's place in the pool, is not the samples'.
    take(1);
    [FEW, 4 * FEW].map(take)
}

/// Runs `work` where parallel work is done by this thread.
fn on_this_thread<R: Send>(work: impl FnOnce() -> R + Send) -> R {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .use_current_thread()
        .build()
        .expect("a pool of this thread");
    pool.install(work)
}

/// The frames of a scene file, small; none where the scene has errors.
fn frames(path: &Path) -> Vec<(Options, PreparedScene)> {
    let sources = SourceMap::new();
    let file = sources.open(path).expect("a scene file");
    let (scene, diagnostics) = read_scene(&sources, file, &ReadSettings::default());
    if diagnostics.has_errors() {
        return Vec::new();
    }
    let frames = scene.frames.into_iter().filter_map(|mut frame| {
        frame.options.film.shrink(PIXELS);
        let options = frame.options.clone();
        Some((options, build(frame, 1).0?))
    });
    frames.collect()
}

/// The scene files of `tests/scenes/KIND`, sorted.
fn scenes(kind: &str) -> BTreeSet<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/scenes");
    let entries = std::fs::read_dir(folder.join(kind)).expect("a folder of scenes");
    let paths = entries.map(|entry| entry.expect("an entry").path());
    paths
        .filter(|path| path.extension().is_some_and(|ending| ending == "pbrt"))
        .collect()
}

#[test]
fn the_counter_counts() {
    let made = allocations(|| {
        let mut numbers = std::hint::black_box(vec![1u8]);
        numbers.reserve(1000);
        drop(std::hint::black_box(vec![0u64; 100]));
    });
    assert_eq!(made, 3);
}

/// Every scene there is: between them they have every type of the scene language.
#[test]
fn no_scene_allocates_for_a_sample() {
    let mut rendered = 0;
    let mut guilty = Vec::new();
    on_this_thread(|| {
        for path in ["reference", "valid"].into_iter().flat_map(scenes) {
            for (options, mut built) in frames(&path) {
                let [few, many] = few_and_many(&mut built.job, &options);
                assert!(few > 0, "the image itself");
                rendered += 1;
                if few != many {
                    guilty.push(format!("{}: {few} and {many}", path.display()));
                }
            }
        }
    });
    // Scenes with errors are left out; were all of them, nothing would be shown.
    assert!(rendered > 150, "{rendered} frames");
    assert!(guilty.is_empty(), "{guilty:#?}");
}

/// Every sampler, lens model, precision, pupil sampling, depth, choice of lights and filter.
#[test]
fn no_setting_allocates_for_a_sample() {
    let mut guilty = Vec::new();
    on_this_thread(|| {
        for name in [
            "reference/realistic_dgauss50_full",
            "valid/dispersion",
            "reference/int_volpath_fog",
            "reference/int_direct_all",
            "reference/int_whitted",
            "reference/tex_imagemap",
        ] {
            let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/scenes");
            for (options, mut built) in frames(&folder.join(name).with_extension("pbrt")) {
                // Any size of photon mapping's discs will do.
                for candidate in candidates(&options, 1.0, FEW, &[]) {
                    // Integrators have scenes of their own above. A lens that has no such model has nothing to show.
                    if candidate.setting == Setting::Integrator {
                        continue;
                    }
                    if reset(&mut built.job, &candidate.options, 1).is_err() {
                        continue;
                    }
                    let [few, many] = few_and_many(&mut built.job, &candidate.options);
                    if few != many {
                        let setting = format!("{} {}", candidate.setting.name(), candidate.value);
                        guilty.push(format!("{name}, {setting}: {few} and {many}"));
                    }
                }
            }
        }
    });
    assert!(guilty.is_empty(), "{guilty:#?}");
}
