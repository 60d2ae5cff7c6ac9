//! A comparison as one self-contained HTML page: images, maps, tables.

use super::raster::{self, MAX_PIXELS, Reduction};
use super::text::{level_row, numbers, ratio};
use super::{Input, Report};
use crate::cli::html::escaped;
use crate::compare::{Answer, BINS, CHANNELS, Uniformity, blocks, probability};
use crate::film::Image;
use crate::math::Rgb;
use std::fmt::Write;

const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");

/// Decades of p-values that a byte of the map covers.
const DECADES: f32 = 12.0;

/// Standard errors that a byte of the maps of blocks covers, up and down. Noise alone brings few blocks above 4.
const ERRORS: f32 = 8.0;

/// What is known of each pixel or block.
pub(super) struct Maps {
    /// The p-values of pixels.
    pub(super) p: Image,
    /// By the blocks' side, the differences of their means over the standard errors of these.
    pub(super) t: Vec<(u32, Image)>,
}

/// The whole page.
pub(super) fn html(report: &Report, maps: &Maps) -> String {
    let comparison = &report.comparison;
    let names = report.inputs.each_ref().map(name);
    let [a, b] = names.each_ref().map(|name| escaped(name));
    let (class, mark) = match comparison.answer() {
        Answer::Agree => ("agree", "✓"),
        Answer::Differ => ("differ", "≠"),
        Answer::CannotTell => ("unknown", "?"),
    };
    let mut page = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>{a} and {b}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<header>\n\
         <h1>{a} <span>and</span> {b}</h1>\n\
         <p id=\"verdict\" class=\"{class}\"><b aria-hidden=\"true\">{mark}</b> {}</p>\n",
        escaped(&comparison.sentence())
    );
    if let Some(warranty) = comparison.warranty() {
        let _ = writeln!(page, "<p>{}</p>", escaped(&warranty));
    }
    let cautions = report.cautions();
    if !cautions.is_empty() {
        let items = cautions
            .iter()
            .map(|c| format!("<li>{}</li>\n", escaped(c)));
        let _ = write!(
            page,
            "<ul id=\"notes\">\n{}</ul>\n",
            items.collect::<String>()
        );
    }
    page += "</header>\n<main>\n";
    let reduction = Reduction::new(report.inputs[0].loaded.image.bounds.size(), MAX_PIXELS);
    page += &viewer(report, maps, reduction);
    page += "<div class=\"tables\">\n";
    page += &tests(report);
    page += &metrics(report);
    page += &histograms(report);
    page += &images(report);
    page += "</div>\n</main>\n";
    page += &data(report, maps, reduction);
    let _ = write!(page, "<script>\n{SCRIPT}</script>\n</body>\n</html>\n");
    page
}

/// With its folders: two images that are compared often have the same name.
fn name(input: &Input) -> String {
    input.path.display().to_string()
}

/// The canvas with its controls.
fn viewer(report: &Report, maps: &Maps, reduction: Reduction) -> String {
    let plain = [
        ("wipe", "Wipe"),
        ("a", "A"),
        ("b", "B"),
        ("difference", "A − B"),
        ("p", "pixels’ p"),
    ];
    let mut views: Vec<(String, String)> = { plain.iter() }
        .map(|(value, label)| ((*value).to_owned(), (*label).to_owned()))
        .collect();
    views.extend(
        { maps.t.iter() }.map(|(side, _)| (format!("t{side}"), format!("{side} × {side}"))),
    );
    if report.flip.is_some() {
        views.push(("flip".to_owned(), "FLIP".to_owned()));
    }
    let radios: String = views
        .iter()
        .map(|(value, label)| {
            let checked = if value == "wipe" { " checked" } else { "" };
            format!(
                "<label><input type=\"radio\" name=\"view\" value=\"{value}\"{checked}>{label}</label>\n"
            )
        })
        .collect();
    let shown = if reduction.factor == 1 {
        String::new()
    } else {
        let size = reduction.size();
        format!(
            "<p class=\"aside\">Shown at {} × {} pixels, each the mean of {f} × {f} (maps: the most striking \
             of them): images of more than {MAX_PIXELS} pixels are carried smaller. All numbers are of the \
             full image.</p>\n",
            size.x,
            size.y,
            f = reduction.factor
        )
    };
    let slider = |id: &str, label: &str, range: [&str; 4]| {
        let [min, max, step, value] = range;
        format!(
            "<label class=\"slider\" for=\"{id}\" data-for=\"{id}\">{label} <input type=\"range\" id=\"{id}\" \
             min=\"{min}\" max=\"{max}\" step=\"{step}\" value=\"{value}\"><output for=\"{id}\"></output></label>\n"
        )
    };
    format!(
        "<section id=\"viewer\" aria-label=\"Images\">\n<fieldset>\n<legend>Show</legend>\n{radios}</fieldset>\n\
         <div class=\"controls\">\n{}{}{}{}</div>\n\
         <div id=\"stage\"><div id=\"frame\"><canvas id=\"canvas\" tabindex=\"0\" role=\"img\" aria-label=\"The \
         chosen image; arrow keys move the pixel that is read out, Enter enlarges it\"></canvas><i id=\"line\"></i></div></div>\n\
         <canvas id=\"legend\" width=\"512\" height=\"12\" aria-hidden=\"true\"></canvas>\n\
         <p id=\"scale\"></p>\n<p id=\"readout\" aria-live=\"polite\">Point at a pixel, or focus the image and \
         use the arrow keys; a click or Enter enlarges it there, another shows all again.</p>\n{shown}<noscript><p>The images need JavaScript; all numbers are \
         below.</p></noscript>\n</section>\n",
        slider("exposure", "Exposure", ["-10", "10", "0.25", "0"]),
        slider("divide", "Wipe", ["0", "1", "0.001", "0.5"]),
        slider("range", "Color scale", ["-6", "2", "0.1", "-1"]),
        slider("zoom", "Zoom", ["0", "4", "1", "0"]),
    )
}

fn table(
    id: &str,
    caption: &str,
    head: &[&str],
    rows: impl Iterator<Item = Vec<String>>,
) -> String {
    let head: String = head
        .iter()
        .map(|h| format!("<th scope=\"col\">{h}</th>"))
        .collect();
    let row = |cells: Vec<String>| {
        let mut line = String::from("<tr>");
        for (i, cell) in cells.iter().enumerate() {
            let cell = escaped(cell);
            line += &match i {
                0 => format!("<th scope=\"row\">{cell}</th>"),
                _ => format!("<td>{cell}</td>"),
            };
        }
        line + "</tr>\n"
    };
    let rows: String = rows.map(row).collect();
    format!(
        "<section>\n<h2>{caption}</h2>\n<div class=\"wide\">\n<table id=\"{id}\">\n<thead><tr>{head}</tr></thead>\n\
         <tbody>\n{rows}</tbody>\n</table>\n</div>\n</section>\n"
    )
}

fn tests(report: &Report) -> String {
    let levels = report.comparison.verdict.levels.iter();
    let head = ["of", "number", "differ", "smallest p", "corrected", "where"];
    table(
        "tests",
        "Tests",
        &head,
        levels.map(|level| level_row(level).to_vec()),
    )
}

fn metrics(report: &Report) -> String {
    let channels = (0..3).map(|i| {
        let means = &report.comparison.metrics.channels[i];
        vec![
            CHANNELS[i].to_owned(),
            format!("{:.6}", means.a),
            format!("{:.6}", means.b),
            ratio(report, i),
        ]
    });
    let head = ["mean", "A", "B", "A / B, 95 % confidence"];
    let means = table("means", "Means", &head, channels);
    let numbers = numbers(report).into_iter();
    let rows = numbers.map(|(name, value)| vec![name.to_owned(), value]);
    means + &table("metrics", "Differences", &["number", "value"], rows)
}

fn images(report: &Report) -> String {
    let rows = ["A", "B"]
        .iter()
        .zip(&report.inputs)
        .map(|(letter, input)| {
            vec![
                (*letter).to_owned(),
                input.path.display().to_string(),
                input.describe(),
            ]
        });
    table("files", "Files", &["", "file", "what it holds"], rows)
}

fn histograms(report: &Report) -> String {
    let figures: String = report.comparison.uniformity.iter().map(histogram).collect();
    if figures.is_empty() {
        return String::new();
    }
    format!(
        "<section id=\"histograms\">\n<h2>Distribution of p-values</h2>\n<div class=\"figures\">\n{figures}</div>\n</section>\n"
    )
}

/// A histogram of p-values in twentieths, with the expected height if they were uniform.
fn histogram(uniformity: &Uniformity) -> String {
    const WIDTH: f64 = 320.0;
    const HEIGHT: f64 = 140.0;
    let total: u64 = uniformity.histogram.iter().sum();
    let even = total as f64 / BINS as f64;
    let most = uniformity.histogram.iter().copied().max().unwrap_or(0) as f64;
    // Leaves room above even a flat histogram.
    let scale = HEIGHT / most.max(1.6 * even).max(1.0);
    let step = WIDTH / BINS as f64;
    let bars: String = (0..BINS)
        .zip(uniformity.histogram)
        .map(|(i, count)| {
            let height = scale * count as f64;
            format!(
                "<rect x=\"{:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{height:.1}\"><title>{:.2} to {:.2}: {count}</title></rect>",
                i as f64 * step + 1.0,
                HEIGHT - height,
                step - 2.0,
                i as f64 / BINS as f64,
                (i + 1) as f64 / BINS as f64,
            )
        })
        .collect();
    let level = HEIGHT - scale * even;
    format!(
        "<figure><svg viewBox=\"0 -4 {WIDTH} 164\" role=\"img\" aria-label=\"Histogram of p-values of {what}\">\
         {bars}<line x1=\"0\" x2=\"{WIDTH}\" y1=\"{level:.1}\" y2=\"{level:.1}\"/>\
         <text x=\"0\" y=\"156\">0</text><text x=\"{WIDTH}\" y=\"156\" text-anchor=\"end\">1</text></svg>\
         <figcaption>{what}: {:.1} % below 5 %; uniform with p = {}</figcaption></figure>\n",
        100.0 * uniformity.small,
        probability(uniformity.p),
        what = blocks(Some(uniformity.side)),
    )
}

/// The images and maps, as JSON that browsers do not execute.
fn data(report: &Report, maps: &Maps, reduction: Reduction) -> String {
    let [a, b] = report
        .inputs
        .each_ref()
        .map(|input| reduction.halves(&input.loaded.image));
    let unlikely = |i: usize| {
        let p = maps.p.pixels.get(i).map_or(1.0, |p| p.min_element());
        -p.max(f32::MIN_POSITIVE).log10() / DECADES
    };
    let flip = report.flip.as_ref().map(|flip| {
        let map = flip.hdr.as_ref().map_or(&flip.ldr, |(_, map)| map);
        reduction.bytes(|i| map.values.get(i).copied().unwrap_or(0.0))
    });
    let t = maps.t.iter().map(|(side, map)| {
        let signed = |block: Rgb| {
            let larger = |most: f32, t: f32| if t.abs() > most.abs() { t } else { most };
            0.5 + 0.5 * block.to_array().into_iter().fold(0.0, larger) / ERRORS
        };
        let grid = raster::grid(map, *side, signed);
        serde_json::json!({ "side": side, "values": grid })
    });
    let t: Vec<_> = t.collect();
    let size = reduction.size();
    let origin = report.inputs[0].loaded.image.bounds.min;
    let value = serde_json::json!({
        "width": size.x,
        "height": size.y,
        "factor": reduction.factor,
        "origin": [origin.x, origin.y],
        "decades": DECADES,
        "a": a,
        "b": b,
        "p": reduction.bytes(unlikely),
        "flip": flip,
        "t": t,
        "errors": ERRORS,
        "full": report.inputs[0].loaded.image.bounds.size().to_array(),
    });
    // Base64 and numbers: nothing that could end the element.
    format!("<script type=\"application/json\" id=\"data\">{value}</script>\n")
}
