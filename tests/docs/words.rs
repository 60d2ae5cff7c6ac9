//! The words of doc comments: statements, in the field's terms.

use crate::markdown::root;
use std::path::{Path, PathBuf};

/// Words for which the field has others.
const OTHERS: [(&str, &str); 3] = [
    ("picture", "image"),
    ("goes on", "continues"),
    ("stands for", "represents"),
];

fn sources(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).expect("a folder");
    let paths = entries.map(|entry| entry.expect("an entry").path());
    paths
        .flat_map(|path| {
            if path.is_dir() {
                sources(&path)
            } else {
                vec![path]
            }
        })
        .collect()
}

#[test]
fn doc_comments_are_statements_in_the_fields_words() {
    let src = root().join("src");
    let mut wrong = Vec::new();
    let mut checked = 0;
    for path in sources(&src) {
        let text = std::fs::read_to_string(&path).expect("a source file");
        for (number, line) in text.lines().enumerate() {
            let line = line.trim_start();
            let Some(said) = line.strip_prefix("///").or(line.strip_prefix("//!")) else {
                continue;
            };
            checked += 1;
            let mut place =
                |why: &str| wrong.push(format!("{}:{}: {why}: {said}", path.display(), number + 1));
            if said.ends_with('?') || said.trim_start().starts_with("Whether") {
                place("say what is `true`");
            }
            let words = format!(" {said} ").replace(|c: char| !c.is_alphabetic() && c != '_', " ");
            for (word, better) in OTHERS {
                if words.contains(&format!(" {word} ")) {
                    place(better);
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(checked > 5000, "{checked}");
}
