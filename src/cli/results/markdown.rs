//! Results in Markdown, for a comment to a pull request or the summary of a job.

use super::{Results, Row, Status, found};
use std::fmt::Write;

/// A comment of GitHub's holds 65,536 characters.
const MAX_CHARACTERS: usize = 60_000;

pub(super) fn text(results: &Results) -> String {
    let mut text = format!(
        "### {}: {}\n\n{}\n",
        escaped(&results.title),
        results.counts(),
        results.promise()
    );
    let (calm, alarming): (Vec<&Row>, Vec<&Row>) = { results.sorted().into_iter() }
        .partition(|row| matches!(row.status(), Status::Agree | Status::Accepted));
    if !alarming.is_empty() {
        text += &table(&alarming, MAX_CHARACTERS - MAX_CHARACTERS / 4);
    }
    if !calm.is_empty() {
        let _ = write!(
            text,
            "\n<details><summary>{} without a difference</summary>\n{}\n</details>\n",
            calm.len(),
            table(&calm, MAX_CHARACTERS / 4)
        );
    }
    text
}

/// As many rows as fit.
fn table(rows: &[&Row], most: usize) -> String {
    let mut text = "\n| | image | | found with 95 % |\n|---|---|---|---|\n".to_owned();
    for (done, row) in rows.iter().enumerate() {
        let line = line(row);
        if text.len() + line.len() > most {
            let _ = writeln!(text, "\n… and {} more", rows.len() - done);
            break;
        }
        text += &line;
    }
    text
}

fn line(row: &Row) -> String {
    let status = row.status();
    let mut detail = escaped(row.detail().lines().next().unwrap_or_default());
    for remark in row.remarks() {
        detail += &format!("<br>{}", escaped(&remark));
    }
    format!(
        "| {} {} | {} | {detail} | {} |\n",
        status.sign(),
        status.word(),
        escaped(&row.name),
        row.comparison().map(found).unwrap_or_default()
    )
}

/// Text that is shown as it is, in a cell of a table.
fn escaped(text: &str) -> String {
    let mut escaped = String::new();
    for letter in text.chars() {
        match letter {
            '<' => escaped += "&lt;",
            '>' => escaped += "&gt;",
            '&' => escaped += "&amp;",
            '\\' | '`' | '*' | '_' | '[' | ']' | '|' | '~' | '#' | '@' => {
                escaped.push('\\');
                escaped.push(letter);
            }
            _ if letter.is_control() => escaped.push(' '),
            _ => escaped.push(letter),
        }
    }
    escaped
}
