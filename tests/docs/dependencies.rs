//! Modules of the library use each other in one direction, as `src/lib.rs` says.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Source files by what they say, those of tests alone left out.
fn sources(folder: &Path, found: &mut BTreeMap<PathBuf, String>) {
    let entries = std::fs::read_dir(folder).expect("a folder");
    for path in entries.map(|entry| entry.expect("an entry").path()) {
        if path.is_dir() {
            sources(&path, found);
        } else {
            let text = std::fs::read_to_string(&path).expect("a source file");
            found.insert(path, text);
        }
    }
}

/// `folder/name` for each `mod name;` that is there for tests.
fn for_tests(path: &Path, text: &str) -> Vec<PathBuf> {
    let stem = path.with_extension("");
    let folder = if stem.ends_with("mod") {
        stem.parent().expect("a folder")
    } else {
        &stem
    };
    let items = text.split("#[cfg(test)]\n").skip(1);
    let names = items.filter_map(|item| {
        item.split_once(';')?
            .0
            .rsplit_once("mod ")
            .map(|split| split.1)
    });
    names.map(|name| folder.join(name)).collect()
}

/// For each top-level module of `src/` those that it names as `crate::…`, outside of tests and comments.
fn uses() -> BTreeMap<String, BTreeSet<String>> {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = BTreeMap::new();
    sources(&src, &mut files);
    let tests: Vec<PathBuf> = files
        .iter()
        .flat_map(|(path, text)| for_tests(path, text))
        .collect();
    let mut uses = BTreeMap::<String, BTreeSet<String>>::new();
    for (path, text) in &files {
        if tests
            .iter()
            .any(|test| path.with_extension("").starts_with(test))
        {
            continue;
        }
        let first = path.strip_prefix(&src).expect("within src").iter().next();
        let module = Path::new(first.expect("a name"))
            .file_stem()
            .expect("a stem")
            .to_string_lossy();
        let code = text
            .split("#[cfg(test)]\nmod tests {")
            .next()
            .expect("a part");
        let lines = code
            .lines()
            .filter(|line| !line.trim_start().starts_with("//"));
        let named = lines.flat_map(|line| line.split("crate::").skip(1));
        let named = named.map(|rest| {
            rest.split(|c: char| !c.is_alphanumeric() && c != '_')
                .next()
                .expect("a part")
        });
        let all = uses.entry(module.into_owned()).or_default();
        all.extend(named.map(String::from));
    }
    uses
}

#[test]
fn no_module_uses_one_that_uses_it() {
    let mut left = uses();
    assert!(
        left["cli"].contains("session") && left["session"].contains("render"),
        "{left:?}"
    );
    // What uses nothing that is left goes, until nothing is left, or a cycle.
    loop {
        let modules: BTreeSet<String> = left.keys().cloned().collect();
        let before = modules.len();
        left.retain(|module, used| {
            used.iter()
                .any(|other| other != module && modules.contains(other))
        });
        if left.len() == before {
            break;
        }
    }
    let modules: Vec<&String> = left.keys().collect();
    assert!(left.is_empty(), "in a cycle, or above one: {modules:?}");
}

/// What the program does a program that embeds fstop can do as well: by the session, not by what is within.
#[test]
fn the_command_line_uses_nothing_of_rendering_but_sessions() {
    let within = [
        "accel",
        "bsdf",
        "bssrdf",
        "build",
        "checkpoint",
        "denoise",
        "forecast",
        "integrators",
        "lights",
        "materials",
        "media",
        "render",
        "samplers",
        "shapes",
        "textures",
        "world",
    ];
    let uses = uses();
    let used: Vec<&&str> = within
        .iter()
        .filter(|module| uses["cli"].contains(**module))
        .collect();
    assert!(used.is_empty(), "{used:?}");
    assert!(within.iter().all(|module| uses.contains_key(*module)));
}
