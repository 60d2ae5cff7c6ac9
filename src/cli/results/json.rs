//! Results as JSON.

use super::{Results, Row};
use crate::cli::compare::json::{correction, findable, level, metrics};
use crate::compare::Comparison;
use serde_json::{Value, json};

pub(super) fn value(results: &Results) -> Value {
    let counts =
        super::Status::ALL.map(|status| (status.word().to_owned(), results.count(status).into()));
    json!({
        "title": results.title,
        "agree": results.code() == 0 && results.count(super::Status::NotRun) == 0,
        "counts": counts.into_iter().collect::<serde_json::Map<String, Value>>(),
        "alpha": results.family.alpha,
        "images": results.family.images,
        "correction": correction(results.family.correction),
        "level": results.level,
        "commit": results.spent.map(|(spent, alpha)| json!({
            "number": spent.number,
            "alpha_of_all_commits": alpha,
        })),
        "results": results.rows.iter().map(row).collect::<Vec<_>>(),
    })
}

fn row(row: &Row) -> Value {
    json!({
        "name": row.name,
        "status": row.status().word(),
        "detail": row.detail(),
        "notes": row.remarks(),
        "seconds": row.seconds,
        "page": row.page,
        "comparison": row.comparison().map(compared),
    })
}

/// Infinite numbers are `null`, as JSON has none.
fn compared(comparison: &Comparison) -> Value {
    json!({
        "p": comparison.verdict.p(),
        "verdict": comparison.sentence(),
        "warranty": comparison.warranty(),
        "findable": comparison.findable.iter().map(findable).collect::<Vec<_>>(),
        "levels": comparison.verdict.levels.iter().map(level).collect::<Vec<_>>(),
        "metrics": metrics(&comparison.metrics),
    })
}
