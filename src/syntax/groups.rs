//! Groups of diagnostics reported together: warnings of one kind, and missing files in one folder.

use super::diagnostic::{Diagnostic, Severity};
use std::collections::{HashMap, HashSet};

/// Maximum number of warnings of one kind, or notes, that are all shown. If there are more, only the first
/// [`SHOWN_OF_MANY`] are, with the number of the others.
const SHOWN_OF_FEW: usize = 20;

/// See [`SHOWN_OF_FEW`].
const SHOWN_OF_MANY: usize = 3;

/// Maximum number of missing files that are named besides the first.
const NAMED: usize = 9;

/// Maximum number of distinct missing files, and of kinds of warnings, so that a file of noise cannot exhaust memory.
const KEPT: usize = 10_000;

/// Severity, and the message without the parts that vary among warnings of a kind: quotations and numbers.
type Kind = (Severity, String);

fn kind_of(diagnostic: &Diagnostic) -> Kind {
    let mut quoted = false;
    let pattern = diagnostic.message.chars().filter(|&c| {
        quoted ^= c == '`';
        !quoted && !c.is_ascii_digit()
    });
    (diagnostic.severity, pattern.collect())
}

/// Missing files in one folder.
#[derive(Debug, Default)]
struct Missing {
    /// Number of different names.
    files: usize,
    /// The ones after the first, up to a limit.
    others: Vec<String>,
}

/// Counts by group. Only looked up, never iterated: the order of a hash map must not be visible.
#[derive(Debug, Default)]
pub(super) struct Groups {
    kinds: HashMap<Kind, usize>,
    folders: HashMap<String, Missing>,
    names: HashSet<String>,
}

impl Groups {
    /// Counts a problem; returns `false` if only others of its group are shown.
    pub(super) fn admit(&mut self, diagnostic: &Diagnostic) -> bool {
        match &diagnostic.missing {
            Some(name) => self.admit_missing(name),
            None if diagnostic.severity == Severity::Error => true,
            None => {
                let kind = kind_of(diagnostic);
                if self.kinds.len() >= KEPT && !self.kinds.contains_key(&kind) {
                    return true;
                }
                let count = self.kinds.entry(kind).or_default();
                *count += 1;
                *count <= SHOWN_OF_FEW
            }
        }
    }

    fn admit_missing(&mut self, name: &str) -> bool {
        let missing = self.folders.entry(folder(name).to_owned()).or_default();
        if self.names.contains(name) {
            // The first one of a folder may be missing at several locations.
            return !missing.others.iter().any(|other| other == name);
        }
        if self.names.len() < KEPT {
            self.names.insert(name.to_owned());
        }
        missing.files += 1;
        if missing.files > 1 && missing.others.len() < NAMED {
            missing.others.push(name.to_owned());
        }
        missing.files == 1
    }

    /// Returns `true` if a problem like this one would not be shown itself.
    pub(super) fn is_full(&self, diagnostic: &Diagnostic) -> bool {
        let count = self.kinds.get(&kind_of(diagnostic));
        count.is_some_and(|&count| count >= SHOWN_OF_FEW)
    }

    /// `diagnostic`, the `number`th that was kept with its [`key`](Groups::key), as it is to be shown, including
    /// counts; `None` if it is only counted.
    pub(super) fn shown(&self, mut diagnostic: Diagnostic, number: usize) -> Option<Diagnostic> {
        if let Some(name) = &diagnostic.missing {
            let missing = self.folders.get(folder(name));
            if let Some(missing) = missing.filter(|missing| missing.files > 1) {
                if number > 1 {
                    return None;
                }
                diagnostic.message = missing.message(name);
                diagnostic.notes.push(missing.note());
            }
            return Some(diagnostic);
        }
        let count = self.kinds.get(&kind_of(&diagnostic)).copied();
        let count = count.filter(|&count| count > SHOWN_OF_FEW).unwrap_or(0);
        if count > 0 && number > SHOWN_OF_MANY {
            return None;
        }
        if count > 0 && number == SHOWN_OF_MANY {
            let more = thousands(count - SHOWN_OF_MANY);
            diagnostic.notes.push(format!("… and {more} more like it"));
        }
        Some(diagnostic)
    }

    /// The group of a problem, used to number those that were kept.
    pub(super) fn key(diagnostic: &Diagnostic) -> (Severity, String) {
        match &diagnostic.missing {
            Some(name) => (diagnostic.severity, folder(name).to_owned()),
            None => kind_of(diagnostic),
        }
    }
}

impl Missing {
    fn message(&self, first: &str) -> String {
        let files = thousands(self.files);
        let place = match folder(first) {
            "" => "files".to_owned(),
            folder => format!("files of `{folder}/`"),
        };
        format!("{files} {place} are missing; the first: `{first}`")
    }

    fn note(&self) -> String {
        let mut names: Vec<String> = self.others.iter().map(|name| format!("`{name}`")).collect();
        let more = self.files - 1 - names.len();
        if more > 0 {
            names.push(format!("… and {} more", thousands(more)));
        }
        format!("also: {}", names.join(", "))
    }
}

/// The folder part of a name as written in the scene; "" if there is none.
fn folder(name: &str) -> &str {
    name.rsplit_once(['/', '\\'])
        .map_or("", |(folder, _)| folder)
}

/// Formats a number with separators, such as `4,997`.
fn thousands(n: usize) -> String {
    let digits = n.to_string();
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::syntax::diagnostic::{Diagnostics, Style};
    use crate::syntax::{FileId, SourceMap, Span};

    fn text(problems: impl IntoIterator<Item = Diagnostic>) -> String {
        let diagnostics = Diagnostics::new();
        for (start, problem) in (0..).zip(problems) {
            diagnostics.push(problem.at(Span {
                file: FileId(0),
                start,
                end: start + 1,
            }));
        }
        diagnostics.render(&SourceMap::new(), Style::Plain)
    }

    #[test]
    fn five_thousand_warnings_of_one_kind_are_three_and_a_count() {
        let warning = |i: u32| Diagnostic::warning(format!("texture `t{i}` is {i} times too many"));
        let shown = text((0..5000).map(warning));
        assert_eq!(shown.matches("warning: texture").count(), 3, "{shown}");
        assert_eq!(shown.matches("… and 4,997 more like it").count(), 1);
        // The same with one message at many places.
        let shown = text((0..5000).map(|_| Diagnostic::warning("odd")));
        assert_eq!(shown.matches("warning: odd").count(), 3, "{shown}");
        assert_eq!(shown.matches("… and 4,997 more like it").count(), 1);
        // A few are all shown, and so is every error.
        assert_eq!(text((0..20).map(warning)).matches("warning").count(), 20);
        let error = |i: u32| Diagnostic::error(format!("texture `t{i}` is wrong"));
        assert_eq!(text((0..50).map(error)).matches("error").count(), 50);
    }

    #[test]
    fn missing_files_of_one_folder_are_one_message() {
        let missing = |name: String| Diagnostic::error(format!("no `{name}`")).missing(&name);
        let name = |i: u32| match i % 3 {
            2 => format!("maps/{i}.png"),
            // Each of these is missing twice.
            _ => format!("geometry/{}.ply", i / 3),
        };
        let shown = text((0..2061).map(|i| missing(name(i))));
        assert_eq!(shown.matches("error: ").count(), 2, "{shown}");
        let message = "error: 687 files of `geometry/` are missing; the first: `geometry/0.ply`";
        assert!(shown.contains(message), "{shown}");
        assert!(
            shown.contains("`geometry/9.ply`, … and 677 more"),
            "{shown}"
        );
        assert!(shown.contains("687 files of `maps/` are missing; the first: `maps/2.png`"));
        // A single one has the usual message.
        assert!(text([missing("a.ply".into())]).starts_with("error: no `a.ply`\n"));
    }

    #[test]
    fn numbers_are_cut_into_thousands() {
        let cut = [0, 999, 1000, 4997, 1234567].map(thousands);
        assert_eq!(cut, ["0", "999", "1,000", "4,997", "1,234,567"]);
    }
}
