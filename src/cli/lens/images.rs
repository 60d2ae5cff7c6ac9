//! The report's images as files, with an overview in Markdown.

use super::Failure;
use super::page::Content;
use std::fmt::Write;
use std::path::Path;

/// Writes the images of one lens to `folder/name`, and returns its part of the overview.
pub(super) fn write_all(folder: &Path, content: &Content) -> Result<String, Failure> {
    let own = folder.join(&content.name);
    std::fs::create_dir_all(&own)
        .map_err(|e| Failure::Io(format!("cannot make {}: {e}", own.display())))?;
    let mut part = format!("## {}\n\nFocused {}.\n", content.title(), content.focus());
    for figure in &content.figures {
        let _ = write!(part, "\n### {}\n\n", figure.title);
        for (i, svg) in figure.svgs.iter().enumerate() {
            let file = match figure.svgs.len() {
                1 => format!("{}.svg", figure.slug),
                _ => format!("{}-{}.svg", figure.slug, i + 1),
            };
            super::write(&own.join(&file), svg)?;
            let (title, name) = (figure.title, &content.name);
            let _ = writeln!(part, "![{title} of {name}]({name}/{file})");
        }
        // Writing to a string cannot fail.
        let _ = write!(part, "\n{}\n", figure.caption);
    }
    Ok(part)
}

/// The overview of all lenses; `command` is what made it.
pub(super) fn readme(parts: &[String], command: &str) -> String {
    let mut text = format!(
        "# Lenses\n\nPictures of the report pages of `fstop lens --report`, made by\n\n```text\n{command}\n```\n"
    );
    for part in parts {
        let _ = write!(text, "\n{part}");
    }
    text
}
