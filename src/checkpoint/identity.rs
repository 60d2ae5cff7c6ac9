//! What a checkpoint is of.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Everything that the bits of an image depend on: the program, the contents of all files that were read, and the
/// settings. Two renders with the same identity make the same image.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Identity {
    /// The program and its version.
    pub program: String,
    /// SHA-256 of every file, under the name that the scene gives it.
    pub files: BTreeMap<String, String>,
    /// Settings, under the names of their options.
    pub settings: BTreeMap<String, String>,
}

impl Identity {
    /// What differs from the identity of a checkpoint, one sentence each; nothing if they are the same.
    pub fn differences(&self, checkpoint: &Identity) -> Vec<String> {
        let mut found = Vec::new();
        if self.program != checkpoint.program {
            let (now, then) = (&self.program, checkpoint.program.escape_debug());
            found.push(format!("this is {now}, the checkpoint is by {then}"));
        }
        for (name, now, then) in both(&self.files, &checkpoint.files) {
            match (now, then) {
                (Some(_), Some(_)) => found.push(format!("the file `{name}` has changed")),
                (Some(_), None) => found.push(format!("the scene now reads `{name}` too")),
                (None, _) => {
                    let name = name.escape_debug();
                    found.push(format!("the scene no longer reads `{name}`"));
                }
            }
        }
        for (name, now, then) in both(&self.settings, &checkpoint.settings) {
            let [now, then] = [now, then].map(|value| shown(value, "not given"));
            let then = then.escape_debug();
            found.push(format!(
                "{} is {now}, the checkpoint's is {then}",
                name.escape_debug()
            ));
        }
        found
    }
}

impl Identity {
    /// The setting that says which shard of a render a checkpoint is of.
    pub const SHARD: &str = "--shard";

    /// The same, but of a whole render if it is of a shard.
    #[must_use]
    pub fn of_all_shards(&self) -> Identity {
        let mut all = self.clone();
        // Shards are divided without tiles.
        let not_of_all = |name: &str| [Identity::SHARD, "--tile-size"].contains(&name);
        all.settings.retain(|name, _| !not_of_all(name));
        all
    }

    /// What two files are different in, a few words each; nothing if they are of the same render.
    pub fn unlike(&self, other: &Identity) -> Vec<String> {
        let mut found = Vec::new();
        let mut add = |name: &str, a: &str, b: &str| {
            let [name, a, b] = [name, a, b].map(str::escape_debug);
            found.push(format!("{name} ({a}, {b})"));
        };
        if self.program != other.program {
            add("the program", &self.program, &other.program);
        }
        for (name, a, b) in both(&self.settings, &other.settings) {
            add(name, shown(a, "none"), shown(b, "none"));
        }
        for (name, ..) in both(&self.files, &other.files) {
            found.push(format!("the file `{}`", name.escape_debug()));
        }
        found
    }
}

/// The value of a setting, for people. One without a value, such as `--variance`, is there or not.
fn shown<'a>(value: Option<&'a String>, none: &'a str) -> &'a str {
    match value.map(String::as_str) {
        Some("") => "given",
        value => value.unwrap_or(none),
    }
}

/// The entries that differ, with their two values.
fn both<'a>(
    a: &'a BTreeMap<String, String>,
    b: &'a BTreeMap<String, String>,
) -> impl Iterator<Item = (&'a str, Option<&'a String>, Option<&'a String>)> {
    let only_b = b.keys().filter(|name| !a.contains_key(*name));
    let pair = |name: &'a String| (name.as_str(), a.get(name), b.get(name));
    a.keys().chain(only_b).map(pair).filter(|(_, a, b)| a != b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_difference_is_named() {
        let map = |entries: &[(&str, &str)]| {
            let owned = |(a, b): &(&str, &str)| ((*a).to_string(), (*b).to_string());
            entries.iter().map(owned).collect()
        };
        let then = Identity {
            program: "fstop 1".to_string(),
            files: map(&[("a.pbrt", "12"), ("gone.ply", "3")]),
            settings: map(&[("--seed", "1"), ("--crop", "0,1,0,1")]),
        };
        let now = Identity {
            program: "fstop 2".to_string(),
            files: map(&[("a.pbrt", "13"), ("new.ply", "3")]),
            settings: map(&[("--seed", "2"), ("--variance", "")]),
        };
        assert_eq!(
            now.differences(&then),
            [
                "this is fstop 2, the checkpoint is by fstop 1",
                "the file `a.pbrt` has changed",
                "the scene now reads `new.ply` too",
                "the scene no longer reads `gone.ply`",
                "--seed is 2, the checkpoint's is 1",
                "--variance is given, the checkpoint's is not given",
                "--crop is not given, the checkpoint's is 0,1,0,1",
            ]
        );
        assert!(now.differences(&now).is_empty());
        assert_eq!(
            now.unlike(&then),
            [
                "the program (fstop 2, fstop 1)",
                "--seed (2, 1)",
                "--variance (given, none)",
                "--crop (none, 0,1,0,1)",
                "the file `a.pbrt`",
                "the file `new.ply`",
                "the file `gone.ply`",
            ]
        );
        assert!(now.unlike(&now).is_empty());
    }
}
