//! A comparison as JSON.

use super::{Input, Report};
use crate::compare::flip::FlipMap;
use crate::compare::{
    Answer, CHANNELS, Correction, Estimate, Findable, Level, Metrics, NoiseSource, Side, Statistic,
    Uniformity,
};
use crate::film::PixelBounds;
use serde_json::{Map, Value, json};

/// A single object. Infinite numbers are `null`, as JSON has none.
pub(super) fn text(report: &Report) -> Result<String, String> {
    serde_json::to_string_pretty(&value(report)).map_err(|e| e.to_string())
}

fn value(report: &Report) -> Value {
    let comparison = &report.comparison;
    let verdict = &comparison.verdict;
    let images = [Side::A, Side::B].map(|which| image(report, which));
    json!({
        "agree": comparison.answer() == Answer::Agree,
        "answer": answer(comparison.answer()),
        "verdict": comparison.sentence(),
        "findable": comparison.findable.iter().map(findable).collect::<Vec<_>>(),
        "notes": report.cautions(),
        "p": verdict.p(),
        "alpha": verdict.alpha,
        "correction": correction(verdict.correction),
        "noise": match comparison.noise {
            NoiseSource::Stored => "stored",
            NoiseSource::None => "none",
            _ => "spatial",
        },
        "a": images[0],
        "b": images[1],
        "pixels_left_out": comparison.non_finite.left_out,
        "impossible_variances": comparison.non_finite.impossible_variances,
        "levels": verdict.levels.iter().map(level).collect::<Vec<_>>(),
        "uniformity": comparison.uniformity.iter().map(uniformity).collect::<Vec<_>>(),
        "neighbor_correlation": {
            "value": comparison.neighbors.correlation,
            "standard_error": comparison.neighbors.error,
        },
        "metrics": metrics(&comparison.metrics),
        "flip": report.flip.as_ref().map(|flip| json!({
            "ldr": flip_map(&flip.ldr),
            "hdr": flip.hdr.as_ref().map(|(range, map)| {
                let mut value = flip_map(map);
                value["start_exposure"] = json!(range.start);
                value["stop_exposure"] = json!(range.stop);
                value["exposures"] = json!(range.count);
                value
            }),
        })),
    })
}

/// The word for an answer.
pub(in crate::cli) fn answer(answer: Answer) -> &'static str {
    match answer {
        Answer::Agree => "agree",
        Answer::Differ => "differ",
        Answer::CannotTell => "cannot tell",
    }
}

/// The word for a correction, as it is given on the command line.
pub(in crate::cli) fn correction(correction: Correction) -> &'static str {
    match correction {
        Correction::Holm => "holm",
        Correction::Sidak => "sidak",
    }
}

fn image(report: &Report, which: Side) -> Value {
    let input: &Input = &report.inputs[which as usize];
    let estimate = Estimate::of(&input.loaded);
    let non_finite = report.comparison.non_finite.of(which);
    json!({
        "file": input.path.display().to_string(),
        "window": window(input.loaded.image.bounds),
        "spp": input.loaded.spp,
        "runs": input.loaded.runs,
        "light_paths": input.loaded.light_paths.map(|used| used.per_sample),
        "joined_paths": input.loaded.light_paths.map(|used| used.joined),
        "variance": estimate.has_variance(),
        "degrees_of_freedom": estimate.has_variance().then_some(estimate.freedom),
        "decoded_from_srgb": input.srgb,
        "non_finite": non_finite.map(|(count, first)| json!({
            "count": count,
            "first": [first.x, first.y],
        })),
    })
}

pub(in crate::cli) fn level(level: &Level) -> Value {
    let worst = &level.worst;
    json!({
        "side": level.side,
        "statistic": match level.statistic {
            Statistic::Mean => "mean",
            Statistic::Neighbors => "neighbors",
        },
        "tests": level.tests,
        "differ": level.rejected,
        "p": level.p,
        "worst": {
            "window": window(worst.bounds),
            "channel": CHANNELS[worst.channel.min(2)],
            "a": worst.a,
            "b": worst.b,
            "t": worst.t,
            "degrees_of_freedom": worst.freedom,
            "p": worst.p,
        },
    })
}

pub(in crate::cli) fn findable(found: &Findable) -> Value {
    json!({
        "side": found.side,
        "window": window(found.bounds),
        "channel": CHANNELS[found.channel.min(2)],
        "relative_difference": found.relative,
        "effective_samples": found.effective_samples,
    })
}

fn uniformity(uniformity: &Uniformity) -> Value {
    json!({
        "side": uniformity.side,
        "tests": uniformity.tests,
        "histogram": uniformity.histogram,
        "below_0.05": uniformity.small,
        "deviation": uniformity.deviation,
        "p": uniformity.p,
    })
}

pub(in crate::cli) fn metrics(metrics: &Metrics) -> Value {
    let channels = CHANNELS.iter().zip(&metrics.channels).map(|(name, means)| {
        let value = json!({
            "a": means.a,
            "b": means.b,
            "ratio": means.ratio,
            "ratio_error_95": means.ratio_error,
        });
        ((*name).to_owned(), value)
    });
    json!({
        "mse": metrics.mse,
        "expected_mse": metrics.expected_mse,
        "relative_mse": metrics.relative_mse,
        "psnr": metrics.psnr,
        "max_difference": metrics.max_difference,
        "means": channels.collect::<Map<String, Value>>(),
        "largest_tile": {
            "window": window(metrics.largest_tile.bounds),
            "luminance_a": metrics.largest_tile.a,
            "luminance_b": metrics.largest_tile.b,
        },
    })
}

fn flip_map(map: &FlipMap) -> Value {
    json!({
        "mean": map.mean(),
        "median": map.quantile(0.5),
        "p95": map.quantile(0.95),
        "max": map.max(),
    })
}

/// First column and row, and one past the last.
fn window(bounds: PixelBounds) -> [u32; 4] {
    [bounds.min.x, bounds.min.y, bounds.max.x, bounds.max.y]
}
