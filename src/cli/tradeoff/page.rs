//! The study as one self-contained HTML page.

use super::chart::{Series, log_log};
use super::text;
use crate::cli::html::{self, escaped};
use crate::cli::lens::chart::Failure;
use crate::tradeoff::{Candidate, Measurement, Setting, Study};
use std::fmt::Write;

const STYLE: &str = ".advice{font-size:1.15em;border-left:4px solid #0072b2;padding-left:.8em}figure{margin:1em 0;overflow-x:auto}\
figure>svg{max-width:none;width:100%;min-width:54em}td{white-space:nowrap}\
td:nth-child(-n+2),th:nth-child(-n+2){text-align:left}";

/// The page.
pub(super) fn html(study: &Study, scene: &str, shrunk: bool) -> Result<String, Failure> {
    let mut body = String::new();
    let _ = write!(
        body,
        "<h1>{0}: speed against accuracy</h1>\n<p class=\"lead\">{1}</p>\n<p class=\"advice\">{2}</p>\n",
        escaped(scene),
        escaped(&text::heading(study, scene, shrunk)),
        escaped(&text::sentence(study)),
    );
    let _ = writeln!(
        body,
        "<figure>{}<figcaption>Each point is a value; the line joins the scene's own settings with more and more samples. \
         Below the line a value is worth its time, above it more samples are.</figcaption></figure>",
        log_log((900, 560), &series(study))?
    );
    let head = [
        "setting",
        "value",
        "spp",
        "error (%)",
        "bias (%)",
        "processor s",
        "efficiency",
    ];
    let rows = text::rows(study).map(|row| row.map(|cell| escaped(&cell)));
    body += &html::table(&head, rows);
    let legend = escaped(&text::legend(study));
    let _ = writeln!(body, "<p class=\"legend\">{legend}</p>");
    let title = format!("{scene}: speed against accuracy");
    Ok(html::page(
        &title,
        &(html::PLAIN.to_owned() + STYLE),
        &body,
        "",
    ))
}

/// The candidates for sample counts, joined, then the other settings.
fn series(study: &Study) -> Vec<Series> {
    let point = |(candidate, m): &(Candidate, Measurement)| {
        let label = candidate.value.clone();
        (m.seconds.value, 100.0 * m.error().value, label)
    };
    let of = |setting: Setting| -> Vec<(f64, f64, String)> {
        let candidates = study
            .measured
            .iter()
            .filter(|(candidate, _)| candidate.setting == setting);
        candidates.map(point).collect()
    };
    let mut samples = of(Setting::Samples);
    samples.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut all = vec![Series {
        name: "samples a pixel".into(),
        points: samples,
        joined: true,
    }];
    for setting in Setting::QUALITY.into_iter().chain([Setting::Filter]) {
        let points = of(setting);
        if !points.is_empty() {
            all.push(Series {
                name: setting.name().into(),
                points,
                joined: false,
            });
        }
    }
    all
}
