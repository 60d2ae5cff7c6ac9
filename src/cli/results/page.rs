//! Results as one page that needs nothing else: an image a card, the most alarming first.

use super::{Results, Row, Status, found};
use crate::cli::html::{self, escaped};
use std::fmt::Write;

const STYLE: &str = include_str!("page.css");

pub(super) fn html(results: &Results) -> String {
    let mut body = format!("<header>\n<h1>{}</h1>\n", escaped(&results.title));
    let class = match results.code() {
        0 => "calm",
        super::ANSWER_IS_NO => "alarm",
        _ => "unknown",
    };
    let _ = writeln!(
        body,
        "<p id=\"verdict\" class=\"{class}\">{}</p>",
        escaped(&results.counts())
    );
    let _ = writeln!(
        body,
        "<p>{}</p>\n</header>\n<main>",
        escaped(&results.promise())
    );
    for row in results.sorted() {
        body += &card(row);
    }
    body += "</main>\n";
    html::page(&results.title, STYLE, &body, "")
}

fn card(row: &Row) -> String {
    let status = row.status();
    let class = match status {
        Status::Agree | Status::Accepted => "calm",
        Status::CannotTell | Status::NotRun => "unknown",
        _ => "alarm",
    };
    let name = escaped(&row.name);
    let name = match &row.page {
        Some(page) => format!("<a href=\"{}\">{name}</a>", link(page)),
        None => name,
    };
    let mut card = format!(
        "<article class=\"{class}\">\n<h2>{name}</h2>\n<p class=\"status\"><b aria-hidden=\"true\">{}</b> {}</p>\n",
        status.sign(),
        status.word()
    );
    card += &row.thumbnails.html();
    let _ = writeln!(
        card,
        "<p>{}</p>",
        escaped(&row.detail()).replace('\n', "<br>")
    );
    if let Some(found) = row
        .comparison()
        .map(found)
        .filter(|found| !found.is_empty())
    {
        let _ = writeln!(card, "<p class=\"aside\">Found with 95 %: {found}</p>");
    }
    for remark in row.remarks() {
        let _ = writeln!(card, "<p class=\"aside\">{}</p>", escaped(&remark));
    }
    if let Some(seconds) = row.seconds {
        let _ = writeln!(card, "<p class=\"aside\">Rendered in {seconds:.1} s</p>");
    }
    card + "</article>\n"
}

/// A relative path as a link: whatever has a meaning in one is encoded (RFC 3986, §2.1).
fn link(path: &str) -> String {
    let mut link = String::new();
    for byte in path.bytes() {
        match byte {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'/' | b'.' | b'-' | b'_' => {
                link.push(byte.into())
            }
            _ => {
                let _ = write!(link, "%{byte:02X}");
            }
        }
    }
    link
}
