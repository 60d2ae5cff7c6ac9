//! A comparison as text for a terminal.

use super::Report;
use crate::compare::{CHANNELS, Level, NoiseSource, Statistic, blocks, extent, probability};
use std::fmt::Write;

/// The verdict, cautions about it, and tables.
pub(super) fn text(report: &Report) -> String {
    let comparison = &report.comparison;
    let mut text = comparison.sentence() + "\n";
    if let Some(warranty) = comparison.warranty() {
        text += &(warranty + "\n");
    }
    text.push('\n');
    for (name, input) in ["A", "B"].iter().zip(&report.inputs) {
        let _ = writeln!(
            text,
            "{name}  {}: {}",
            input.path.display(),
            input.describe()
        );
    }
    for caution in report.cautions() {
        let _ = writeln!(text, "note: {caution}");
    }
    text.push('\n');
    let rows = comparison.verdict.levels.iter().map(level_row);
    let head = [
        "tests of",
        "number",
        "differ",
        "smallest p",
        "corrected",
        "where",
    ];
    text += &table(std::iter::once(head.map(str::to_owned)).chain(rows));
    for uniformity in &comparison.uniformity {
        let _ = writeln!(
            text,
            "p-values of {}: {:.1} % below 5 %; uniform with p = {}",
            blocks(Some(uniformity.side)),
            100.0 * uniformity.small,
            probability(uniformity.p)
        );
    }
    text.push('\n');
    text += &means(report);
    for (name, value) in numbers(report) {
        let _ = writeln!(text, "{name}: {value}");
    }
    text.trim_end().to_owned()
}

/// Name of a level.
pub(super) fn level_name(level: &Level) -> String {
    match level.statistic {
        Statistic::Mean => blocks(level.side),
        Statistic::Neighbors => format!("neighbors in {}", blocks(level.side)),
    }
}

/// The cells of a level's row; see [`text`] for the columns.
pub(super) fn level_row(level: &Level) -> [String; 6] {
    let worst = &level.worst;
    let channel = CHANNELS[worst.channel.min(2)];
    let place = match level.side {
        None => String::new(),
        Some(1) => format!("{}, {} ", worst.bounds.min.x, worst.bounds.min.y),
        Some(_) => extent(worst.bounds) + " ",
    };
    let found = match worst.t {
        0.0 => "no difference".to_owned(),
        t => format!(
            "{place}{channel}: {:.6} against {:.6}, t = {t:+.2}",
            worst.a, worst.b
        ),
    };
    [
        level_name(level),
        level.tests.to_string(),
        level.rejected.to_string(),
        probability(worst.p),
        probability(level.p),
        found,
    ]
}

fn means(report: &Report) -> String {
    let row = |name: &str, of: &dyn Fn(usize) -> String| {
        let [r, g, b] = [0, 1, 2].map(of);
        [name.to_owned(), r, g, b]
    };
    let channels = &report.comparison.metrics.channels;
    table([
        row("mean", &|i| CHANNELS[i].to_owned()),
        row("A", &|i| format!("{:.6}", channels[i].a)),
        row("B", &|i| format!("{:.6}", channels[i].b)),
        row("A / B", &|i| ratio(report, i)),
    ])
}

/// The ratio of means with its 95 % confidence interval.
pub(super) fn ratio(report: &Report, channel: usize) -> String {
    let means = &report.comparison.metrics.channels[channel.min(2)];
    match means.ratio_error {
        Some(error) => format!("{:.5} ± {error:.5}", means.ratio),
        None => format!("{:.5}", means.ratio),
    }
}

/// Names and values of all whole-image metrics.
pub(super) fn numbers(report: &Report) -> Vec<(&'static str, String)> {
    let metrics = &report.comparison.metrics;
    let mut mse = format!("{:.4e}", metrics.mse);
    if let (Some(expected), NoiseSource::Stored) = (metrics.expected_mse, report.comparison.noise) {
        mse += &format!(" ({expected:.4e} from noise alone)");
    }
    let tile = &metrics.largest_tile;
    let mut numbers = vec![
        ("mean squared error", mse),
        (
            "relative mean squared error",
            format!("{:.4e}", metrics.relative_mse),
        ),
        ("PSNR", decibel(metrics.psnr)),
        (
            "largest difference of a value",
            format!("{:.6}", metrics.max_difference),
        ),
        (
            "most deviating block, in luminance",
            format!(
                "{}: {:.6} against {:.6}",
                extent(tile.bounds),
                tile.a,
                tile.b
            ),
        ),
    ];
    if let Some(flip) = &report.flip {
        let map = |map: &crate::compare::flip::FlipMap| {
            format!(
                "mean {:.4}, 95 % below {:.4}, largest {:.4}",
                map.mean(),
                map.quantile(0.95),
                map.max()
            )
        };
        numbers.push(("FLIP as shown on a screen", map(&flip.ldr)));
        if let Some((range, worst)) = &flip.hdr {
            let exposures = format!(
                "{} (the worst of {} exposures from {:+.1} to {:+.1} stops)",
                map(worst),
                range.count,
                range.start,
                range.stop
            );
            numbers.push(("FLIP of high dynamic range", exposures));
        }
    }
    numbers
}

fn decibel(psnr: f64) -> String {
    if psnr.is_infinite() && psnr > 0.0 {
        "infinite: the images are equal".to_owned()
    } else {
        format!("{psnr:.2} dB")
    }
}

/// Left-aligned columns.
fn table<const N: usize>(rows: impl IntoIterator<Item = [String; N]>) -> String {
    let rows: Vec<[String; N]> = rows.into_iter().collect();
    let width = |column: usize| {
        let lengths = rows.iter().map(|row| row[column].chars().count());
        lengths.max().unwrap_or(0)
    };
    let widths: [usize; N] = std::array::from_fn(width);
    let mut text = String::new();
    for row in &rows {
        let cells = row.iter().zip(widths);
        let line: String = cells
            .map(|(cell, width)| format!("{cell:width$}  "))
            .collect();
        text += line.trim_end();
        text.push('\n');
    }
    text + "\n"
}
