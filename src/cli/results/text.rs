//! Results as text for a terminal.

use super::{Results, found};
use std::fmt::Write;

/// A line or a few for each image, the most alarming last, where the eye is when the command ends.
pub(super) fn text(results: &Results) -> String {
    let mut text = String::new();
    let width = { results.rows.iter() }
        .map(|row| row.status().word().len())
        .max();
    let width = width.unwrap_or(0);
    for row in results.sorted().into_iter().rev() {
        let status = row.status();
        let _ = write!(
            text,
            "{} {:width$}  {}: ",
            status.sign(),
            status.word(),
            row.name
        );
        text += &row.detail().replace('\n', "\n    ");
        if let Some(found) = row
            .comparison()
            .map(found)
            .filter(|found| !found.is_empty())
        {
            let _ = write!(text, "\n    found with 95 %: {found}");
        }
        for remark in row.remarks() {
            let _ = write!(text, "\n    note: {remark}");
        }
        text.push('\n');
    }
    let _ = write!(
        text,
        "\n{}: {}\n{}",
        results.title,
        results.counts(),
        results.promise()
    );
    text
}
