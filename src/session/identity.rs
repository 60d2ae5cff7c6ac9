//! Everything that an image depends on: a checkpoint is continued by the same render only.

use super::{ReadOptions, RenderOptions};
use crate::film::FilmSpec;
use crate::syntax::{FileId, SourceMap};
use sha2::{Digest, Sha256};
use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::path::{Path, PathBuf};

/// The settings of reading that change bits, under the names of their options.
pub(super) fn of_reading(options: &ReadOptions) -> BTreeMap<String, String> {
    let model = options.lens_model.map(|model| format!("{model:?}"));
    let compat = options.compat.map(|compat| format!("{compat:?}"));
    let settings = [
        (
            "how errors are treated",
            Some(format!("{:?}", options.policy)),
        ),
        ("--dialect", Some(format!("{:?}", options.dialect))),
        ("--lens-model", model),
        ("--f-number", options.f_number.map(|n| n.to_string())),
        (
            "--focus-point",
            options.focus_point.map(|[x, y]| format!("{x},{y}")),
        ),
        ("--compat", compat),
    ];
    named(settings)
}

/// The settings that change the bits of a frame's image.
pub(super) fn settings(
    number: usize,
    film: &FilmSpec,
    reading: &BTreeMap<String, String>,
    options: &RenderOptions,
) -> BTreeMap<String, String> {
    let settings = named([
        ("frame", Some(number.to_string())),
        (
            "the film",
            Some(format!("{} {:?}", film.resolution, film.crop_window)),
        ),
        (
            "--aov",
            (!film.layers.is_empty()).then(|| film.layers.to_string()),
        ),
        ("--spp", options.spp.map(|spp| spp.to_string())),
        ("--error", options.error.map(|error| error.to_string())),
        (
            "--confidence",
            options.confidence.map(|sure| sure.to_string()),
        ),
        (
            "--time",
            options.time.map(|time| time.as_secs_f64().to_string()),
        ),
        (
            "--variance",
            (options.variance && options.goal().is_none()).then(String::new),
        ),
        ("--seed", Some(options.seed.to_string())),
        ("--quick", Some(options.quick.to_string())),
        ("--tile-size", Some(options.tile_size.to_string())),
    ]);
    settings.into_iter().chain(reading.clone()).collect()
}

/// Name, version and target: systems differ in the last bits of their sines and logarithms.
pub(super) fn program() -> String {
    use std::env::consts::{ARCH, OS};
    let libc = match () {
        () if cfg!(target_env = "gnu") => "-gnu",
        () if cfg!(target_env = "musl") => "-musl",
        () => "",
    };
    format!("fstop {} ({ARCH}-{OS}{libc})", env!("CARGO_PKG_VERSION"))
}

/// SHA-256 of the main scene file.
pub(super) fn hash_of_main(sources: &SourceMap) -> String {
    let bytes = sources.bytes(FileId(0));
    bytes.map_or_else(unreadable, |bytes| hex(&Sha256::digest(&*bytes)))
}

/// The hash of a file that has been removed, or that never could be read.
fn unreadable() -> String {
    "unreadable".to_string()
}

/// SHA-256 of all files of a scene, each under the name that the scene gives it; of files in different folders under
/// the same name all hashes. `main` are the name and the hash of the main file.
pub(super) fn files(
    main: &(String, String),
    named: &BTreeSet<(String, PathBuf)>,
) -> BTreeMap<String, String> {
    let mut all = BTreeMap::from([main.clone()]);
    for (name, path) in named {
        let hash = hash_of(path).unwrap_or_else(|_| unreadable());
        let entry = all.entry(name.clone()).or_default();
        *entry = format!("{entry} {hash}").trim().to_string();
    }
    all
}

fn hash_of(path: &Path) -> std::io::Result<String> {
    let mut hasher = Sha256::new();
    if !path.is_file() {
        return Err(std::io::ErrorKind::InvalidInput.into());
    }
    std::io::copy(&mut File::open(path)?, &mut hasher)?;
    Ok(hex(&hasher.finalize()))
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

fn named<const N: usize>(settings: [(&str, Option<String>); N]) -> BTreeMap<String, String> {
    let given = settings.into_iter();
    given
        .filter_map(|(name, value)| Some((name.to_string(), value?)))
        .collect()
}
