//! The evidence for `docs/compatibility.md`: how far fstop's image is from pbrt-v3's, and what holds it.
//!
//! That page is written by hand; each of its differences links to its evidence in
//! `docs/generated/compatibility.md`, which is written here (`tests/docs/links.rs` checks the links both ways).
//! The rows are in `rows.rs`. Each names the tests and scenes that hold it, which must be there; each
//! figure of how much it is comes from a measurement made here (`measures.rs`) or from the comparison
//! with a reference (`docs/generated/references.md`, which `tests/scenes/references.rs` writes).
//!
//! `FSTOP_WRITE_TABLES=1 cargo test --release --test scenes compatibility::` writes the page, after the
//! references' tests where those have changed; without it the test fails where the page is out of date.

mod measures;
mod rows;

use crate::tables::{lock, same, writing};
use std::path::{Path, PathBuf};

const HEAD: &str = "# Evidence for the differences from pbrt-v3\n\n\
    Written by `FSTOP_WRITE_TABLES=1 cargo test --release --test scenes compatibility::`, not by hand; the same tests fail\n\
    where it is out of date. [Compatibility](../compatibility.md) explains each difference. Here is how large it is, as these\n\
    tests measured it or as the comparison with pbrt-v3's own image did (fstop's mean over pbrt-v3's in red, green and blue:\n\
    [references](references.md)), and which tests and scenes hold it (`valid/`: of `tests/scenes/valid`).\n";

/// One difference.
struct Row {
    /// Heading of its explanation, and of its evidence.
    what: &'static str,
    much: &'static [Much],
    held: &'static [Proof],
}

/// How much it changes the image.
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
    /// A scene compared with pbrt-v3's image.
    Reference(&'static str),
    /// The measurement in the row.
    Measurement,
}

/// What to do about a page that is out of date.
const HINT: &str =
    "write it with FSTOP_WRITE_TABLES=1 cargo test --release --test scenes compatibility::";

fn page() -> PathBuf {
    root().join("docs/generated/compatibility.md")
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn read(path: PathBuf) -> String {
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

impl Much {
    fn texts(&self) -> Vec<String> {
        match self {
            Much::Words(words) => vec![(*words).to_owned()],
            Much::References(names) => names
                .iter()
                .map(|name| format!("`{name}`: {}", measures::mean_ratio(name)))
                .collect(),
            Much::Measured(measure) => vec![measure()],
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
    /// The section of the page.
    fn section(&self) -> String {
        let texts = self.much.iter().flat_map(Much::texts);
        let much: String = texts.map(|text| format!("- {text}\n")).collect();
        format!("\n## {}\n\n{much}\n{}\n", self.what, self.held_by())
    }

    fn held_by(&self) -> String {
        let held: Vec<String> = self.held.iter().map(Proof::text).collect();
        format!("Held by: {}", held.join("; "))
    }
}

#[test]
fn every_row_is_held_by_what_is_executed() {
    for row in rows::ROWS {
        assert!(!row.held.is_empty() && !row.much.is_empty(), "{}", row.what);
        row.held.iter().for_each(|proof| proof.check(row));
        for much in row.much {
            if let Much::Words(words) = much {
                let figures = words.chars().any(|c| c.is_ascii_digit());
                assert!(!figures, "{}: a figure that is not measured", row.what);
            }
        }
    }
}

/// Each row has its section, which names what holds it; in any build.
#[test]
fn every_row_has_its_section() {
    let text = read(page());
    let mut sections = text.split("\n## ").skip(1);
    for row in rows::ROWS {
        let section = sections.next().unwrap_or_default().trim_end();
        let named = section.starts_with(&format!("{}\n", row.what));
        assert!(
            named && section.ends_with(&row.held_by()),
            "{section}\n{HINT}"
        );
    }
    assert_eq!(sections.next(), None, "{HINT}");
}

#[test]
fn the_page_is_current() {
    if crate::common::is_left_out("refimages") {
        return;
    }
    // An unoptimized program would take minutes.
    if cfg!(debug_assertions) {
        return;
    }
    let sections: Vec<String> = rows::ROWS.iter().map(Row::section).collect();
    let written = format!("{HEAD}{}", sections.concat());
    let _one = lock();
    if writing() {
        std::fs::write(page(), written)
            .unwrap_or_else(|error| panic!("{}: {error}", page().display()));
        return;
    }
    let committed = read(page());
    let count = |text: &str| text.lines().count();
    assert_eq!(count(&committed), count(&written), "lines: {HINT}");
    for (old, new) in committed.lines().zip(written.lines()) {
        assert!(
            same(old, new),
            "out of date:\n{old}\nshould be\n{new}\n{HINT}"
        );
    }
}
