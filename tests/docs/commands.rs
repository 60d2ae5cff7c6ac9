//! The command lines that the pages show, held against the program.

use crate::common::program::fstop;
use crate::markdown::{Page, root};
use std::collections::BTreeSet;

/// A stranger reads it in one sitting, and starts with two commands, the second of which the checks
/// before each release run.
#[test]
fn the_readme_is_short_and_starts_with_two_commands() {
    let readme = Page::read("README.md");
    assert!(readme.text.lines().count() <= 110);
    let mut code = readme.code();
    let first = code.next().expect("a command");
    assert!(first.starts_with("cargo run --release -- render "));
    let second = code.next().expect("a second command");
    assert_eq!(second, "cargo test --release");
    let checks = std::fs::read_to_string(root().join(".ci/run")).expect("the checks");
    assert!(checks.contains(second));
}

/// There is no fstop in a registry: who installs it by its name gets an error, or somebody else's program.
#[test]
fn nothing_is_installed_from_where_it_is_not() {
    let mut checked = 0;
    for page in Page::all() {
        for line in page
            .text
            .lines()
            .filter(|line| line.contains("cargo install "))
        {
            checked += usize::from(line.contains("--git ADDRESS") || line.contains("--path ."));
            let names_it = line.split_whitespace().any(|word| word == "fstop");
            assert!(!names_it || line.contains("--git ADDRESS"), "{line}");
        }
    }
    assert!(checked >= 5, "{checked}");
}

/// The README says how many scenes are compared with pbrt-v3's images.
#[test]
fn the_readme_counts_the_references() {
    if crate::common::is_left_out("refimages") {
        return;
    }
    let images = std::fs::read_dir(root().join("refimages")).expect("the references");
    let exr = |entry: std::io::Result<std::fs::DirEntry>| {
        let path = entry.expect("an entry").path();
        path.extension().is_some_and(|ending| ending == "exr")
    };
    let count = images.filter_map(|entry| exr(entry).then_some(())).count();
    let readme = Page::read("README.md");
    assert!(
        readme
            .text
            .contains(&format!("and {count} scenes compared"))
    );
    assert!(readme.text.contains(&format!("images of {count} scenes")));
}

/// Each command line of the README has arguments that the program knows, and inputs that exist or that an
/// earlier one has written.
#[test]
fn the_commands_of_the_readme_are_understood() {
    let readme = Page::read("README.md");
    let mut written = BTreeSet::new();
    let mut checked = 0;
    for line in readme.code() {
        let start = "cargo run --release --";
        let Some(words) = line.strip_prefix("fstop").or(line.strip_prefix(start)) else {
            continue;
        };
        checked += 1;
        let words: Vec<&str> = words.split_whitespace().collect();
        // What stands before `--help` is parsed.
        let run = fstop(words.iter().copied().chain(["--help"]));
        assert_eq!(run.code, 0, "{line}\n{}", run.stderr);
        let mut output = false;
        for word in words.iter().skip(1) {
            let file = !word.starts_with('-') && word.contains('.');
            if file && output {
                written.insert(*word);
            } else if file {
                let known = root().join(word).exists() || written.contains(word);
                assert!(known, "{line}: no {word}");
            }
            output = ["-o", "--png", "--html", "--report"].contains(word);
        }
    }
    assert!(checked >= 7, "{checked} commands");
}

/// The long options of a command's help.
fn options(command: &str) -> BTreeSet<String> {
    let help = fstop([command, "--help"]);
    assert_eq!(help.code, 0, "{}", help.stderr);
    let words = help.stdout.lines().filter_map(|line| {
        let line = line.trim_start();
        let line = match line.split_once(", ") {
            Some((short, long)) if short.len() == 2 => long,
            _ => line,
        };
        line.starts_with("--").then(|| line.split(' ').next())?
    });
    words.map(str::to_owned).collect()
}

/// The command of a line of the help; a description's further lines are indented deeper.
fn name(line: &str) -> Option<&str> {
    let line = line.strip_prefix("  ")?;
    line.split(' ').next().filter(|name| !name.is_empty())
}

/// The guide has a section for each command, which names each of its options.
#[test]
fn the_guide_names_every_option() {
    let guide = Page::read("docs/guide.md");
    let help = fstop(["--help"]);
    let commands = help
        .stdout
        .lines()
        .skip_while(|line| *line != "Commands:")
        .skip(1);
    let commands = commands.take_while(|line| !line.is_empty());
    let (mut missing, mut checked) = (Vec::new(), 0);
    for command in commands.filter_map(name) {
        if command == "help" {
            continue;
        }
        checked += 1;
        let synopsis = format!("\n```\nfstop {command} ");
        let (_, section) = guide
            .text
            .split_once(&synopsis)
            .unwrap_or_else(|| panic!("the guide has no `fstop {command}`"));
        let section = section.split("\n## ").next().unwrap_or_default();
        for option in options(command).iter().filter(|option| *option != "--help") {
            let mut named = section.split(|c: char| c != '-' && !c.is_alphanumeric());
            if !named.any(|word| word == option) {
                missing.push(format!("fstop {command} {option}"));
            }
        }
    }
    let missing = missing.join("\n");
    assert!(missing.is_empty(), "not in docs/guide.md:\n{missing}");
    assert!(checked >= 5, "{checked} commands");
}
