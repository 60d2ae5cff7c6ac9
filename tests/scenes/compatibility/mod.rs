//! The table of `docs/compatibility.md`: where fstop's picture is not pbrt-v3's.
//!
//! Its rows are in `rows.rs`. Each names the tests and scenes that hold it, which must be there; each
//! figure of how much it is comes from a measurement made here (`measures.rs`) or from the comparison
//! with a reference (`docs/references.md`, which `tests/scenes/references.rs` writes).
//!
//! `FSTOP_WRITE_TABLES=1 cargo test --release --test scenes compatibility::` writes the table, after the
//! references' tests where those have changed; without it the test fails where the table is out of date.

mod measures;
mod rows;

use crate::tables::{lock, same, writing};
use std::path::{Path, PathBuf};

const BEGIN: &str = "<!-- rows: written by tests/scenes/compatibility -->\n";
const END: &str = "<!-- end of rows -->\n";
const HEAD: &str = "\n| what | pbrt-v3 | fstop | how much | held by |\n|---|---|---|---|---|\n";

/// One difference.
struct Row {
    what: &'static str,
    pbrt: &'static str,
    fstop: &'static str,
    much: &'static [Much],
    held: &'static [Proof],
}

/// How much it changes the picture.
enum Much {
    /// In words; figures are measured.
    Words(&'static str),
    /// The mean ratios of references that show it.
    References(&'static [&'static str]),
    /// What is measured here.
    Measured(fn() -> String),
}

/// What is executed with the tests and fails where the row is not so.
enum Proof {
    /// A test: its file, and its name.
    Test(&'static str, &'static str),
    /// A scene of `tests/scenes/valid`, and a line of the messages that it is rendered with, empty
    /// for none.
    Scene(&'static str, &'static str),
    /// A scene compared with pbrt-v3's picture.
    Reference(&'static str),
    /// The measurement in the row.
    Measurement,
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn read(path: PathBuf) -> String {
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

impl Much {
    fn text(&self) -> String {
        match self {
            Much::Words(words) => (*words).to_owned(),
            Much::References(names) => {
                let texts = names
                    .iter()
                    .map(|name| format!("`{name}`: {}", measures::mean_ratio(name)));
                texts.collect::<Vec<_>>().join("; ")
            }
            Much::Measured(measure) => measure(),
        }
    }
}

impl Proof {
    fn text(&self) -> String {
        match self {
            Proof::Test(file, name) => format!("`{file}`, `{name}`"),
            Proof::Scene(name, _) => format!("`valid/{name}`"),
            Proof::Reference(name) => format!("`{name}`"),
            Proof::Measurement => "the measurement".to_owned(),
        }
    }

    fn check(&self, row: &Row) {
        let what = row.what;
        match self {
            Proof::Test(file, name) => {
                let text = read(root().join(file));
                let lines: Vec<&str> = text.lines().map(str::trim).collect();
                let found = lines
                    .windows(2)
                    .any(|l| l[0] == "#[test]" && l[1].starts_with(&format!("fn {name}(")));
                assert!(found, "{what}: no test {name} in {file}");
            }
            Proof::Scene(name, message) => {
                let scene = root().join("tests/scenes/valid").join(name);
                assert!(scene.with_extension("pbrt").exists(), "{what}: {name}");
                // The corpus' test renders it and compares every message.
                if !message.is_empty() {
                    let expected = read(scene.with_extension("expected"));
                    assert!(expected.contains(message), "{what}: {name}: {message}");
                }
            }
            Proof::Reference(name) => {
                // A test of its own asserts that these are the references compared.
                let scene = format!("tests/scenes/reference/{name}.pbrt");
                assert!(root().join(scene).exists(), "{what}: {name}");
            }
            Proof::Measurement => {
                let measured = row.much.iter().any(|m| matches!(m, Much::Measured(_)));
                assert!(measured, "{what}: nothing is measured");
            }
        }
    }
}

impl Row {
    /// The row without how much it is, and with.
    fn cells(&self, much: &str) -> String {
        let held: Vec<String> = self.held.iter().map(Proof::text).collect();
        let (what, pbrt, fstop) = (self.what, self.pbrt, self.fstop);
        format!(
            "| {what} | {pbrt} | {fstop} | {much} | {} |\n",
            held.join("; ")
        )
    }

    fn much(&self) -> String {
        let texts: Vec<String> = self.much.iter().map(Much::text).collect();
        texts.join("; ")
    }
}

#[test]
fn every_row_is_held_by_what_is_executed() {
    for row in rows::ROWS {
        assert!(!row.held.is_empty() && !row.much.is_empty(), "{}", row.what);
        for cell in [row.what, row.pbrt, row.fstop] {
            assert!(!cell.contains(" | ") && !cell.contains('\n'), "{cell}");
        }
        row.held.iter().for_each(|proof| proof.check(row));
        for much in row.much {
            if let Much::Words(words) = much {
                let figures = words.chars().any(|c| c.is_ascii_digit());
                assert!(!figures, "{}: a figure that is not measured", row.what);
            }
        }
    }
}

#[test]
fn the_table_is_current() {
    // An unoptimised program would take minutes.
    if cfg!(debug_assertions) {
        return;
    }
    let written: Vec<String> = rows::ROWS.iter().map(|r| r.cells(&r.much())).collect();
    let written = format!("{HEAD}{}\n", written.concat());
    let _one = lock();
    let path = root().join("docs/compatibility.md");
    let text = read(path.clone());
    let (before, rest) = text.split_once(BEGIN).expect("where the table begins");
    let (committed, after) = rest.split_once(END).expect("where the table ends");
    if writing() {
        std::fs::write(&path, format!("{before}{BEGIN}{written}{END}{after}"))
            .unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        return;
    }
    let hint =
        "write it with FSTOP_WRITE_TABLES=1 cargo test --release --test scenes compatibility::";
    let count = |text: &str| text.lines().count();
    assert_eq!(count(committed), count(&written), "rows: {hint}");
    for (old, new) in committed.lines().zip(written.lines()) {
        assert!(
            same(old, new),
            "out of date:\n{old}\nshould be\n{new}\n{hint}"
        );
    }
}
