//! Results in JUnit's form, as test runners and the pages of build servers read it: no schema of it is official, and the
//! attributes here are those that all of them know.

use super::{Results, Row, Status};
use std::fmt::Write;

pub(super) fn xml(results: &Results) -> String {
    let failures = [
        Status::Changed,
        Status::Missing,
        Status::New,
        Status::CannotTell,
    ];
    let failures: usize = failures
        .into_iter()
        .map(|status| results.count(status))
        .sum();
    let [errors, skipped] = [Status::Failed, Status::NotRun].map(|status| results.count(status));
    // The sum of none is −0.
    let seconds: f64 = 0.0 + { results.rows.iter() }
        .filter_map(|row| row.seconds)
        .sum::<f64>();
    let attributes = format!(
        "name=\"{}\" tests=\"{}\" failures=\"{failures}\" errors=\"{errors}\" skipped=\"{skipped}\" time=\"{seconds:.3}\"",
        escaped(&results.title),
        results.rows.len(),
    );
    let cases: String = results
        .rows
        .iter()
        .map(|row| case(&results.title, row))
        .collect();
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites>\n<testsuite {attributes}>\n{cases}<system-out>{}</system-out>\n\
         </testsuite>\n</testsuites>\n",
        escaped(&results.promise())
    )
}

fn case(title: &str, row: &Row) -> String {
    let mut text = format!(
        "<testcase classname=\"{}\" name=\"{}\" time=\"{:.3}\">",
        escaped(title),
        escaped(&row.name),
        row.seconds.unwrap_or(0.0)
    );
    let (status, detail) = (row.status(), row.detail());
    let first = escaped(detail.lines().next().unwrap_or_default());
    let _ = match status {
        Status::Agree | Status::Accepted => Ok(()),
        Status::NotRun => write!(text, "<skipped message=\"{first}\"/>"),
        Status::Failed => write!(
            text,
            "<error type=\"failed\" message=\"{first}\">{}</error>",
            escaped(&detail)
        ),
        _ => write!(
            text,
            "<failure type=\"{}\" message=\"{first}\">{}</failure>",
            status.word(),
            escaped(&detail)
        ),
    };
    let mut said: Vec<String> = row.remarks();
    said.extend(
        row.comparison()
            .and_then(|comparison| comparison.warranty()),
    );
    if !said.is_empty() {
        let _ = write!(
            text,
            "<system-out>{}</system-out>",
            escaped(&said.join("\n"))
        );
    }
    text + "</testcase>\n"
}

/// Text as XML 1.0, which has no place for most control characters.
fn escaped(text: &str) -> String {
    let is_legal = |c: &char| !c.is_control() || matches!(c, '\n' | '\t');
    let text: String = text.chars().filter(is_legal).collect();
    crate::cli::html::escaped(&text.replace(['\u{fffe}', '\u{ffff}'], ""))
}
