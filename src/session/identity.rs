//! What an image depends on, so that a checkpoint is continued by the render that it is of, and by no other.

use super::{ReadOptions, RenderOptions};
use crate::checkpoint::Identity;
use crate::files;
use crate::syntax::{FileId, SourceMap};
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;

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
        ("--compat", compat),
    ];
    named(settings)
}

/// The identity of a frame of the scene in `sources`, which is called `name`.
pub(super) fn of_frame(
    name: &str,
    number: usize,
    sources: &SourceMap,
    reading: &BTreeMap<String, String>,
    options: &RenderOptions,
) -> Identity {
    let numbers = |values: [f64; 4]| values.map(|value| value.to_string()).join(",");
    let settings = named([
        ("frame", Some(number.to_string())),
        ("--spp", options.spp.map(|spp| spp.to_string())),
        ("--error", options.error.map(|error| error.to_string())),
        (
            "--time",
            options.time.map(|time| time.as_secs_f64().to_string()),
        ),
        ("--seed", Some(options.seed.to_string())),
        ("--crop", options.crop.map(numbers)),
        ("--cropwindow", options.default_crop.map(numbers)),
        ("--quick", Some(options.quick.to_string())),
        ("--tile-size", Some(options.tile_size.to_string())),
    ]);
    let hash = |bytes: &[u8]| {
        let digest = Sha256::digest(bytes);
        digest.iter().map(|byte| format!("{byte:02x}")).collect()
    };
    // A file that has gone meanwhile, or that never could be read, differs from every other.
    let unreadable = || "unreadable".to_string();
    let main = sources.bytes(FileId(0));
    let main = main.map_or_else(unreadable, |bytes| hash(&bytes));
    let named = sources.named_files().into_iter().map(|(name, path)| {
        let bytes = files::read(&path, u64::MAX);
        (
            name,
            bytes.map_or_else(|_| unreadable(), |bytes| hash(&bytes)),
        )
    });
    Identity {
        program: format!("fstop {}", env!("CARGO_PKG_VERSION")),
        files: named.chain([(name.to_string(), main)]).collect(),
        settings: settings.into_iter().chain(reading.clone()).collect(),
    }
}

fn named<const N: usize>(settings: [(&str, Option<String>); N]) -> BTreeMap<String, String> {
    let given = settings.into_iter();
    given
        .filter_map(|(name, value)| Some((name.to_string(), value?)))
        .collect()
}
