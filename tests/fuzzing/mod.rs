//! What every fuzz target does with a file: read it, use what was read, and never panic, hang or take
//! memory without end. `fuzz/` runs these functions under libFuzzer; the tests run them on the files that
//! were found (`replay.rs`).

mod grammar;
mod lenses;
mod readers;
mod scenes;
mod vocabulary;

pub(crate) use grammar::scene_text;
pub(crate) use scenes::{Outcome, survive};

use std::path::{Path, PathBuf};

/// A reader of files, or the whole program.
pub(crate) struct Target {
    /// Also the name of its folders `fuzz/corpus/NAME` and `fuzz/regressions/NAME`.
    pub name: &'static str,
    /// Reads a file with these bytes; panics where a promise is broken.
    pub run: fn(&[u8]),
    /// Files to start from beside the corpus: folders of the project, and the endings that count there.
    pub seeds: &'static [(&'static str, &'static [&'static str])],
}

const SCENES: &[(&str, &[&str])] = &[
    ("tests/scenes/valid", &["pbrt"]),
    ("tests/scenes/fuzzed", &["pbrt"]),
];

/// Of other programs.
const LENSES: &[(&str, &[&str])] = &[(
    "tests/optics/files/lenses",
    &["zmx", "seq", "len", "txt", "json", "agf"],
)];

/// All of them.
pub(crate) const TARGETS: [Target; 19] = [
    Target {
        name: "program",
        run: scenes::program,
        seeds: SCENES,
    },
    Target {
        name: "grammar",
        run: scenes::grammar,
        seeds: &[],
    },
    Target {
        name: "scene",
        run: scenes::scene,
        seeds: SCENES,
    },
    Target {
        name: "dat",
        run: lenses::dat,
        seeds: &[
            ("lenses", &["dat"]),
            ("tests/scenes/valid/lenses", &["dat"]),
            ("tests/scenes/invalid/lenses", &["dat"]),
        ],
    },
    Target {
        name: "zmx",
        run: lenses::zmx,
        seeds: LENSES,
    },
    Target {
        name: "seq",
        run: lenses::seq,
        seeds: LENSES,
    },
    Target {
        name: "len",
        run: lenses::len,
        seeds: LENSES,
    },
    Target {
        name: "optbench",
        run: lenses::optbench,
        seeds: LENSES,
    },
    Target {
        name: "lens_json",
        run: lenses::json,
        seeds: LENSES,
    },
    Target {
        name: "agf",
        run: lenses::glasses,
        seeds: LENSES,
    },
    Target {
        name: "ply",
        run: readers::ply,
        seeds: &[("tests/scenes/valid/geometry", &["ply", "gz"])],
    },
    Target {
        name: "obj",
        run: readers::obj,
        seeds: &[
            ("tests/scenes/valid/geometry", &["obj"]),
            ("tests/scenes/invalid/parts", &["obj"]),
        ],
    },
    Target {
        name: "ptex",
        run: readers::ptex,
        seeds: &[("tests/scenes/valid/textures", &["ptx"])],
    },
    Target {
        name: "picture",
        run: readers::picture,
        seeds: &[
            ("tests/scenes/valid/textures", &["hdr", "jpg"]),
            (
                "tests/scenes/reference/textures",
                &["exr", "pfm", "png", "tga"],
            ),
        ],
    },
    Target {
        name: "exr",
        run: readers::exr,
        seeds: &[("tests/scenes/reference/textures", &["exr"])],
    },
    Target {
        name: "spd",
        run: readers::spd,
        seeds: &[
            ("tests/scenes/valid/spectra", &["spd"]),
            ("tests/scenes/invalid/parts", &["spd"]),
        ],
    },
    Target {
        name: "bsdf",
        run: readers::bsdf,
        seeds: &[("tests/scenes/valid/parts", &["bsdf"])],
    },
    Target {
        name: "merl",
        run: readers::merl,
        seeds: &[("tests/scenes/valid/parts", &["binary"])],
    },
    Target {
        name: "brdf",
        run: readers::brdf,
        seeds: &[("tests/scenes/valid/parts", &["brdf"])],
    },
];

/// The folder of the project, from the tests and from `fuzz/`.
pub(crate) fn project() -> &'static Path {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    if here.ends_with("fuzz") {
        here.parent().unwrap_or(here)
    } else {
        here
    }
}

/// The files in a folder, sorted; none where there is no such folder.
pub(crate) fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).into_iter().flatten();
    let mut files: Vec<PathBuf> = entries
        .map(|entry| entry.expect("an entry").path())
        .collect();
    files.sort();
    files
}
