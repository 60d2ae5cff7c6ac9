//! The page that the tests of the references write, `docs/generated/references.md`: a row for each scene, and
//! below them what is left out, by its reason.
//!
//! Each scene's test knows its own row and fails where the committed one says otherwise.
//! `FSTOP_WRITE_TABLES=1 cargo test --release --test scenes references::` writes it instead; with a scene's
//! name behind `--`, that scene's row only.

use crate::tables::{lock, same, writing};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Why pixels are not compared.
pub(super) struct Reason {
    /// Name of the constant that a scene's `left_out` has.
    pub name: &'static str,
    /// Heading of its explanation in `docs/compatibility.md`, and of its section here.
    pub what: &'static str,
}

/// A scene as the tables see it.
pub(super) struct Entry {
    pub name: &'static str,
    /// The constant that says what is left out.
    pub left_out: Option<String>,
}

const HEAD: &str = "# Every reference, and how it is met\n\n\
    Written by `FSTOP_WRITE_TABLES=1 cargo test --release --test scenes references::`, not by hand; the same tests fail\n\
    where it is out of date. Each scene of `tests/scenes/reference` is rendered and compared with pbrt-v3's\n\
    image in `refimages/` (the mean of 16 to 64 of its runs) by t-tests on pixels, on blocks of 8 and 32\n\
    pixels and on the whole ([`compare.md`](../compare.md)). *Mean ratio*: fstop's mean over pbrt-v3's in red,\n\
    green and blue, ± the largest half-width of their 95 % confidence intervals. *p*: the probability, at\n\
    most, of differences as large as the largest if both programs have the same expectation; a scene fails\n\
    below 1e-4. *Left out*: pixels where pbrt-v3's image is an accident\n\
    ([`compatibility.md`](../compatibility.md) says which), and fstop's mean over pbrt-v3's there.\n\n\
    | scene | what it shows | mean ratio | p | left out |\n|---|---|---|---|---|\n";

fn page() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/generated/references.md")
}

fn read() -> String {
    std::fs::read_to_string(page()).unwrap_or_default()
}

/// Takes over a scene's row, or checks that it is there already. An unoptimized program takes fewer
/// samples: its rows differ and nothing is checked.
pub(super) fn record(entries: &[Entry], reasons: &[Reason], name: &str, cells: [String; 4]) {
    if cfg!(debug_assertions) {
        return;
    }
    let row = format!("| `{name}` | {} |\n", cells.join(" | "));
    let _one = lock();
    let mut rows = rows(&read());
    if writing() {
        rows.insert(name.to_owned(), row);
        rows.retain(|name, _| entries.iter().any(|entry| entry.name == name));
        std::fs::write(page(), references(entries, reasons, &rows))
            .unwrap_or_else(|error| panic!("{}: {error}", page().display()));
        return;
    }
    let committed = rows.remove(name).unwrap_or_default();
    assert!(
        same(&committed, &row),
        "docs/generated/references.md is out of date:\n{committed}should be\n{row}Write it with\n  \
         FSTOP_WRITE_TABLES=1 cargo test --release --test scenes references::{name}"
    );
}

/// Checks what needs no rendering: that each scene has its row and nothing else has one, and that what
/// is left out follows from them.
pub(super) fn check(entries: &[Entry], reasons: &[Reason]) {
    for name in entries.iter().filter_map(|entry| entry.left_out.as_ref()) {
        let known = reasons.iter().any(|reason| reason.name == name);
        assert!(known, "{name} leaves pixels out and has no row in REASONS");
    }
    if writing() {
        return;
    }
    let _one = lock();
    let text = read();
    let rows = rows(&text);
    let hint = "write it with FSTOP_WRITE_TABLES=1 cargo test --release --test scenes references::";
    let named: Vec<&str> = rows.keys().map(String::as_str).collect();
    let listed: Vec<&str> = entries.iter().map(|entry| entry.name).collect();
    assert_eq!(named, listed, "{hint}");
    assert_eq!(text, references(entries, reasons, &rows), "{hint}");
}

/// The page. How much is left out comes from the scenes' own rows.
fn references(entries: &[Entry], reasons: &[Reason], rows: &BTreeMap<String, String>) -> String {
    let mut text = HEAD.to_owned();
    text.extend(rows.values().map(String::as_str));
    for reason in reasons {
        let (name, what) = (reason.name, reason.what);
        text += &format!("\n## {what}\n\n");
        for entry in entries {
            if entry.left_out.as_deref() == Some(name) {
                let row = rows.get(entry.name).map(|row| row.trim_end());
                let much = row.and_then(|row| row.rsplit('|').nth(1));
                let much = much.unwrap_or("not measured").trim();
                text += &format!("- `{}`: {much}\n", entry.name);
            }
        }
        text += &format!("\nHeld by: `tests/scenes/references.rs`, `{name}`\n");
    }
    text
}

/// The rows of a table by their first cells' names.
fn rows(text: &str) -> BTreeMap<String, String> {
    let name = |line: &str| Some(line.strip_prefix("| `")?.split_once('`')?.0.to_owned());
    let lines = text.lines();
    lines
        .filter_map(|line| Some((name(line)?, format!("{line}\n"))))
        .collect()
}

/// What a scene file says of itself: the first sentence of the comment at its top.
pub(super) fn description(source: &str) -> String {
    let comment = source.lines().map_while(|line| line.strip_prefix('#'));
    let words: Vec<&str> = comment.flat_map(str::split_whitespace).collect();
    // A bar would end the cell.
    let text = words.join(" ").replace('|', "/");
    match text.split_once(". ") {
        Some((sentence, _)) => format!("{sentence}."),
        None => text,
    }
}

#[test]
fn rows_are_found_by_name() {
    let rows = rows("# Head\n\n| scene | p |\n|---|---|\n| `b` | 1 |\n| `a` | 2 |\n");
    assert_eq!(
        rows.into_iter().collect::<Vec<_>>(),
        [
            ("a".to_owned(), "| `a` | 2 |\n".to_owned()),
            ("b".to_owned(), "| `b` | 1 |\n".to_owned()),
        ]
    );
    assert_eq!(
        description("# One | two,\n#  three. Four.\nCamera \"x\"\n# five"),
        "One / two, three."
    );
}
