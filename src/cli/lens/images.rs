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
        let file = format!("{}.svg", figure.slug);
        super::write(&own.join(&file), &figure.svg)?;
        // Writing to a string cannot fail.
        let _ = write!(
            part,
            "\n### {}\n\n![{} of {}]({}/{file})\n\n{}\n",
            figure.title, figure.title, content.name, content.name, figure.caption
        );
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
