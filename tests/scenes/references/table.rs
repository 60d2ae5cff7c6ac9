//! The tables that the tests of the references write: `docs/references.md`, and in
//! `docs/compatibility.md` the rows of what is left out.
//!
//! Each scene's test knows its own row and fails where the committed one says otherwise.
//! `FSTOP_WRITE_TABLES=1 cargo test --release --test scenes references::` writes them instead; with a scene's
//! name behind `--`, that scene's row only.

use crate::tables::{lock, same, writing};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Why pixels are not compared: one row of `docs/compatibility.md`.
pub struct Reason {
    /// Name of the constant that a scene's `left_out` has.
    pub name: &'static str,
    pub what: &'static str,
    pub pbrt: &'static str,
    pub fstop: &'static str,
}

/// A scene as the tables see it.
pub struct Entry {
    pub name: &'static str,
    /// The constant that says what is left out.
    pub left_out: Option<String>,
}

const HEAD: &str = "# Every reference, and how it is met\n\n\
    Written by `FSTOP_WRITE_TABLES=1 cargo test --release --test scenes references::`, not by hand; the same tests fail\n\
    where it is out of date. Each scene of `tests/scenes/reference` is rendered and compared with pbrt-v3's\n\
    picture in `refimages/` (the mean of 16 to 64 of its runs) by t-tests on pixels, on blocks of 8 and 32\n\
    pixels and on the whole ([`compare.md`](compare.md)). *Mean ratio*: fstop's mean over pbrt-v3's in red,\n\
    green and blue, ± the largest half-width of their 95 % confidence intervals. *p*: the probability, at\n\
    most, of differences as large as the largest if both programs have the same expectation; a scene fails\n\
    below 1e-4. *Left out*: pixels where pbrt-v3's picture is an accident\n\
    ([`compatibility.md`](compatibility.md) says which), and fstop's mean over pbrt-v3's there.\n\n\
    | scene | what it shows | mean ratio | p | left out |\n|---|---|---|---|---|\n";

const BEGIN: &str = "<!-- left out: written by tests/scenes/references.rs -->\n";
const END: &str = "<!-- end of left out -->\n";

fn docs(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("docs")
        .join(name)
}

fn read(name: &str) -> String {
    std::fs::read_to_string(docs(name)).unwrap_or_default()
}

fn write(name: &str, text: &str) {
    std::fs::write(docs(name), text).unwrap_or_else(|error| panic!("docs/{name}: {error}"));
}

/// Takes over a scene's row, or checks that it is there already. An unoptimised program takes fewer
/// samples: its rows differ and nothing is checked.
pub fn record(entries: &[Entry], reasons: &[Reason], name: &str, cells: [String; 4]) {
    if cfg!(debug_assertions) {
        return;
    }
    let row = format!("| `{name}` | {} |\n", cells.join(" | "));
    let _one = lock();
    let mut rows = rows(&read("references.md"));
    if writing() {
        rows.insert(name.to_owned(), row);
        rows.retain(|name, _| entries.iter().any(|entry| entry.name == name));
        write("references.md", &references(&rows));
        write("compatibility.md", &with_reasons(entries, reasons, &rows));
        return;
    }
    let committed = rows.remove(name).unwrap_or_default();
    assert!(
        same(&committed, &row),
        "docs/references.md is out of date:\n{committed}should be\n{row}Write it with\n  \
         FSTOP_WRITE_TABLES=1 cargo test --release --test scenes references::{name}"
    );
}

/// Checks what needs no rendering: that each scene has its row and nothing else has one, and that the
/// rows of what is left out follow from them.
pub fn check(entries: &[Entry], reasons: &[Reason]) {
    for name in entries.iter().filter_map(|entry| entry.left_out.as_ref()) {
        let known = reasons.iter().any(|reason| reason.name == name);
        assert!(known, "{name} leaves pixels out and has no row in REASONS");
    }
    if writing() {
        return;
    }
    let _one = lock();
    let text = read("references.md");
    let rows = rows(&text);
    let hint = "write it with FSTOP_WRITE_TABLES=1 cargo test --release --test scenes references::";
    let named: Vec<&str> = rows.keys().map(String::as_str).collect();
    let listed: Vec<&str> = entries.iter().map(|entry| entry.name).collect();
    assert_eq!(named, listed, "docs/references.md: {hint}");
    assert_eq!(text, references(&rows), "docs/references.md: {hint}");
    let expected = with_reasons(entries, reasons, &rows);
    assert_eq!(
        read("compatibility.md"),
        expected,
        "docs/compatibility.md: {hint}"
    );
}

fn references(rows: &BTreeMap<String, String>) -> String {
    HEAD.to_owned() + &rows.values().map(String::as_str).collect::<String>()
}

/// The rows of a table by their first cells' names.
fn rows(text: &str) -> BTreeMap<String, String> {
    let name = |line: &str| Some(line.strip_prefix("| `")?.split_once('`')?.0.to_owned());
    let lines = text.lines();
    lines
        .filter_map(|line| Some((name(line)?, format!("{line}\n"))))
        .collect()
}

/// `docs/compatibility.md` with its table of what is left out made anew: how much comes from the
/// scenes' own rows.
fn with_reasons(entries: &[Entry], reasons: &[Reason], rows: &BTreeMap<String, String>) -> String {
    let text = read("compatibility.md");
    let (before, rest) = text
        .split_once(BEGIN)
        .expect("the mark where the table begins");
    let (_, after) = rest.split_once(END).expect("the mark where the table ends");
    let mut table =
        String::from("\n| what | pbrt-v3 | fstop | how much | held by |\n|---|---|---|---|---|\n");
    for reason in reasons {
        let scenes = entries
            .iter()
            .filter(|entry| entry.left_out.as_deref() == Some(reason.name));
        let much: Vec<String> = scenes
            .map(|entry| {
                let last = rows
                    .get(entry.name)
                    .and_then(|row| row.trim_end().rsplit('|').nth(1));
                format!(
                    "`{}`: {}",
                    entry.name,
                    last.unwrap_or("not measured").trim()
                )
            })
            .collect();
        table += &format!(
            "| {} | {} | {} | {} | `tests/scenes/references.rs`, `{}` |\n",
            reason.what,
            reason.pbrt,
            reason.fstop,
            much.join("; "),
            reason.name
        );
    }
    format!("{before}{BEGIN}{table}\n{END}{after}")
}

/// What a scene file says of itself: the first sentence of the comment at its top.
pub fn description(source: &str) -> String {
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
