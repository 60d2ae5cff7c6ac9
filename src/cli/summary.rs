//! The last line of a render.

use super::messages;
use crate::console;
use crate::film::FilmMetadata;
use crate::session::{Ended, Rendered};
use std::time::Instant;

/// Prints what was rendered, how good it is and how long it took; `rendering` began then.
pub(super) fn print(rendered: &Rendered, written: &[String], started: Instant, rendering: Instant) {
    let seconds = rendering.elapsed().as_secs_f64();
    if let Some(dropped) = &rendered.dropped {
        messages::warning(format!(
            "{} of the samples were negative or not finite, and count as black; the first is {}",
            dropped.count,
            dropped.first()
        ));
    }
    let written = match written {
        [] => "not written".to_string(),
        written => written.join(" and "),
    };
    console::say(format_args!(
        "{written}: {}, {seconds:.2} s ({:.2} M samples/s), {:.2} s in all",
        quality(rendered),
        rendered.samples / seconds / 1e6,
        started.elapsed().as_secs_f64(),
    ));
}

/// How sure the error is, if a confidence was asked for.
fn promised(rendered: &Rendered) -> String {
    let FilmMetadata {
        confidence,
        error_bound,
        ..
    } = rendered.metadata;
    let told = |(sure, bound): (f64, f64)| {
        let (sure, bound) = (100.0 * sure, 100.0 * bound);
        format!(", below {bound:.3} % with {sure} % confidence")
    };
    confidence.zip(error_bound).map(told).unwrap_or_default()
}

/// How good an image is.
fn quality(rendered: &Rendered) -> String {
    let Some((passes, ended)) = rendered.passes else {
        return format!("{} samples a pixel", rendered.spp);
    };
    let error = match rendered.metadata.relative_error {
        Some(error) => format!(
            "relative error {:.3} %{}",
            100.0 * error,
            promised(rendered)
        ),
        None if rendered.spp < 1.0 => "unknown error (not every pixel has a sample)".to_string(),
        None if rendered.is_black() => "no light was found".to_string(),
        None => "unknown error (no noise was found)".to_string(),
    };
    format!(
        "{error} after {:.1} samples a pixel on average in {passes} passes ({})",
        rendered.spp,
        match ended {
            Ended::Error => "good enough",
            Ended::Time => "time is up",
            Ended::Samples => "no more samples allowed",
            Ended::Stopped => "stopped",
        }
    )
}
