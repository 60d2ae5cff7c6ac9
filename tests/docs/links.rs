//! Where the pages and the source point: files, headings, sections of the scene language, evidence.

use crate::markdown::{Page, anchor, root};
use std::collections::BTreeSet;
use std::path::{Component, Path, PathBuf};

/// Relative links lead to files, and to headings of pages.
#[test]
fn links_lead_somewhere() {
    let mut wrong = Vec::new();
    let mut checked = 0;
    for page in Page::all() {
        for link in page.links() {
            if link.contains("://") || link.starts_with("mailto:") {
                continue;
            }
            checked += 1;
            if !leads_somewhere(&page, link) {
                wrong.push(format!("{}: {link}", page.path.display()));
            }
        }
    }
    assert!(wrong.is_empty(), "links to nothing:\n{}", wrong.join("\n"));
    assert!(checked > 100, "{checked} links");
}

fn leads_somewhere(page: &Page, link: &str) -> bool {
    let (file, heading) = link.split_once('#').unwrap_or((link, ""));
    let target = match file {
        "" => page.path.clone(),
        _ => plain(&page.path.with_file_name("").join(file)),
    };
    let heading_is_there = || {
        let anchors = Page::read(&target).anchors();
        anchors.iter().any(|anchor| anchor == heading)
    };
    root().join(&target).exists() && (heading.is_empty() || heading_is_there())
}

/// Without `..`.
fn plain(path: &Path) -> PathBuf {
    let mut plain = PathBuf::new();
    for part in path.components() {
        match part {
            Component::ParentDir => {
                plain.pop();
            }
            part => plain.push(part),
        }
    }
    plain
}

/// Each difference that `docs/compatibility.md` explains points at evidence, and all evidence is
/// explained.
#[test]
fn differences_and_evidence_belong_together() {
    let page = Page::read("docs/compatibility.md");
    let evidence = ["compatibility.md", "references.md"].map(|name| {
        let evidence = Page::read(format!("docs/generated/{name}"));
        let sections: Vec<String> = evidence
            .headings()
            .filter(|(level, _)| *level == 2)
            .map(|(_, text)| format!("generated/{name}#{}", anchor(text)))
            .collect();
        sections
    });
    let evidence: BTreeSet<String> = evidence.concat().into_iter().collect();
    assert!(evidence.len() > 40, "{} pieces of evidence", evidence.len());
    let named: BTreeSet<String> = page.links().iter().map(|link| link.to_string()).collect();
    let silent: Vec<&String> = evidence.difference(&named).collect();
    assert!(
        silent.is_empty(),
        "docs/compatibility.md does not explain {silent:?}"
    );
    for section in page.text.split("\n### ").skip(1) {
        let section = section.split("\n## ").next().unwrap_or_default();
        let heading = section.lines().next().unwrap_or_default();
        let proven = evidence.iter().any(|e| section.contains(&format!("({e})")));
        assert!(proven, "no evidence for {heading:?}");
    }
}

/// The sections of the scene language that a text cites: what follows each mention of the page.
fn citations(text: &str) -> Vec<String> {
    const PAGE: &str = "scene-language";
    // A citation may go on in the next line of a comment.
    let lines = text.lines().map(|line| {
        let line = line.trim_start();
        let comment = line.trim_start_matches(['/', '!', '#', ' ']);
        if line.starts_with("//") {
            comment
        } else {
            line
        }
    });
    let text = lines.collect::<Vec<_>>().join(" ");
    let mut citations = Vec::new();
    for rest in text.split(PAGE).skip(1) {
        let rest = rest.strip_prefix(".md").unwrap_or(rest);
        let rest = rest.trim_start_matches([' ', '§']);
        let rest = rest.strip_prefix("section ").unwrap_or(rest);
        let rest = rest.strip_prefix("appendix ").unwrap_or(rest);
        // "3.8, 3.9 and 4.4", each with or without a sign.
        let words = rest.split([' ', ',', ';', ')', '(', '`', '/', '"']);
        let sections = words
            .map(|word| {
                word.trim_start_matches('§')
                    .trim_end_matches(['.', ':', '-'])
            })
            .filter(|word| !["", "and", "to"].contains(word))
            .take_while(|word| is_section(word));
        let sections: Vec<String> = sections.map(str::to_owned).collect();
        match sections.is_empty() {
            true => citations.push(rest.chars().take(20).collect()),
            false => citations.extend(sections),
        }
    }
    citations
}

/// `4`, `4.2`, `A` or `A.1`.
fn is_section(word: &str) -> bool {
    let (chapter, section) = word.split_once('.').unwrap_or((word, "0"));
    let digits = |text: &str| !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
    (digits(chapter) || ["A", "B"].contains(&chapter)) && digits(section)
}

#[test]
fn citations_are_found() {
    let text = "//! As there (docs/scene-language.md §4.2).\n/// See scene-language 1.3 and 1.4, or\n\
                /// scene-language\n/// 4.5: so. scene-language appendix A. scene-language says";
    assert_eq!(
        citations(text),
        ["4.2", "1.3", "1.4", "4.5", "A", "says"],
        "what is no section is not lost"
    );
}

/// The text of the document that the source cites.
pub(crate) fn scene_language() -> String {
    std::fs::read_to_string(root().join("docs/scene-language.md")).expect("the document")
}

/// What the source cites of the scene language is there.
#[test]
fn every_section_that_is_cited_exists() {
    let page = Page::read("docs/scene-language.md");
    let sections: BTreeSet<&str> = page
        .headings()
        .filter_map(|(_, text)| {
            let text = text.strip_prefix("Appendix ").unwrap_or(text);
            Some(text.split(' ').next()?.trim_end_matches('.'))
        })
        .filter(|section| is_section(section))
        .collect();
    let mut files = Vec::new();
    for folder in ["src", "tests", "examples", "benches"] {
        rust_files(&root().join(folder), &mut files);
    }
    let (mut wrong, mut checked) = (Vec::new(), 0);
    for file in files.iter().filter(|file| !file.ends_with(file!())) {
        let text = std::fs::read_to_string(file).expect("a source file");
        for citation in citations(&text) {
            checked += 1;
            if !sections.contains(citation.as_str()) {
                wrong.push(format!("{}: {citation}", file.display()));
            }
        }
    }
    assert!(wrong.is_empty(), "no such section:\n{}", wrong.join("\n"));
    assert!(checked > 80, "{checked} citations");
}

fn rust_files(folder: &Path, files: &mut Vec<PathBuf>) {
    let entries = std::fs::read_dir(folder).expect("a folder of source files");
    for entry in entries {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            rust_files(&path, files);
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            files.push(path);
        }
    }
}
