//! As much of Markdown as the pages' tests need: headings, their anchors, links, blocks of code.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// A page of the documentation.
pub(crate) struct Page {
    /// Relative to the project's folder.
    pub path: PathBuf,
    /// All of it.
    pub text: String,
}

/// The project's folder.
pub(crate) fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

impl Page {
    /// Reads a page of the project.
    pub(crate) fn read(path: impl Into<PathBuf>) -> Page {
        let path = path.into();
        let text = std::fs::read_to_string(root().join(&path));
        let text = text.unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        Page { path, text }
    }

    /// The pages in the project's folder and in `docs`.
    pub(crate) fn all() -> Vec<Page> {
        let mut pages = Vec::new();
        collect(Path::new(""), false, &mut pages);
        collect(Path::new("docs"), true, &mut pages);
        pages
    }

    /// The lines outside blocks of code.
    pub(crate) fn prose(&self) -> impl Iterator<Item = &str> {
        let mut code = false;
        self.text.lines().filter(move |line| {
            let fence = line.trim_start().starts_with("```");
            code ^= fence;
            !code && !fence
        })
    }

    /// The lines of the blocks of code.
    pub(crate) fn code(&self) -> impl Iterator<Item = &str> {
        let blocks = self.text.split("\n```").skip(1).step_by(2);
        blocks.flat_map(|block| block.lines().skip(1))
    }

    /// Level and text of each heading.
    pub(crate) fn headings(&self) -> impl Iterator<Item = (usize, &str)> {
        self.prose().filter_map(|line| {
            let text = line.trim_start_matches('#');
            let level = line.len() - text.len();
            Some((level, text.strip_prefix(' ').filter(|_| level > 0)?.trim()))
        })
    }

    /// The anchors of the headings, as GitHub makes them.
    pub(crate) fn anchors(&self) -> Vec<String> {
        let mut seen: HashMap<String, usize> = HashMap::new();
        let anchors = self.headings().map(|(_, text)| {
            let anchor = anchor(text);
            let count = seen.entry(anchor.clone()).or_default();
            *count += 1;
            match *count {
                1 => anchor,
                n => format!("{anchor}-{}", n - 1),
            }
        });
        anchors.collect()
    }

    /// Where the links of inline form lead, images included.
    pub(crate) fn links(&self) -> Vec<&str> {
        let targets = self.prose().flat_map(|line| {
            let after = line.split("](").skip(1);
            after.filter_map(|rest| rest.split_once(')').map(|(target, _)| target))
        });
        targets.collect()
    }
}

/// The pages of a folder.
fn collect(folder: &Path, deep: bool, pages: &mut Vec<Page>) {
    let entries = std::fs::read_dir(root().join(folder)).expect("a folder of pages");
    let mut paths: Vec<PathBuf> = entries
        .map(|entry| folder.join(entry.expect("an entry").file_name()))
        .collect();
    paths.sort();
    for path in paths {
        if path.extension().is_some_and(|ending| ending == "md") {
            pages.push(Page::read(path));
        } else if deep && root().join(&path).is_dir() {
            collect(&path, true, pages);
        }
    }
}

/// Letters, digits, hyphens and underscores in lower case; a hyphen for each blank.
pub(crate) fn anchor(heading: &str) -> String {
    let kept = heading.to_lowercase();
    let kept = kept
        .chars()
        .filter(|c| c.is_alphanumeric() || " -_".contains(*c));
    kept.map(|c| if c == ' ' { '-' } else { c }).collect()
}

#[test]
fn pages_are_taken_apart() {
    let text = "# One `two`\n\n[a](b.md#c) and ![d](e.svg)\n```sh\n# no [f](g)\n```\n## One two\n";
    let page = Page {
        path: PathBuf::from("page.md"),
        text: text.to_owned(),
    };
    assert_eq!(
        page.headings().collect::<Vec<_>>(),
        [(1, "One `two`"), (2, "One two")]
    );
    assert_eq!(page.anchors(), ["one-two", "one-two-1"]);
    assert_eq!(page.links(), ["b.md#c", "e.svg"]);
    assert_eq!(page.code().collect::<Vec<_>>(), ["# no [f](g)"]);
}
